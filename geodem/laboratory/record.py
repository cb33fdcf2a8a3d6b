"""What a test ends with: curves, numbers, cracks, and why it ended."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNITS = {
    "steps": "-",
    "axial_strain": "-",
    "gauge_axial": "-",
    "gauge_lateral": "-",
    "axial_stress": "Pa",
    "tension_cracks": "-",
    "shear_cracks": "-",
    "force": "N",
    "displacement": "m",
    "dilation": "m",
    "unbalanced_ratio": "-",
}
"""Units of the curves."""


@dataclass(frozen=True, eq=False)
class Cracks:
    """Broken bonds, in the order of time.

    Attributes
    ----------
    place : (k, d) [m]
    mode : (k,) int64
        1 tension, 2 shear.
    direction : (k, d)
        From one particle to the other when they were bonded: the crack lies across it.
    size : (k,) [m]
        Smaller diameter of the two.
    stress : (k,) [Pa]
        Axial stress, or what the test calls its load, at that moment.
    """

    place: Floats
    mode: NDArray[np.int64]
    direction: Floats
    size: Floats
    stress: Floats

    @property
    def tension(self) -> int:
        """Cracks by tension."""
        return int((self.mode == 1).sum())

    @property
    def shear(self) -> int:
        """Cracks by shear."""
        return int((self.mode == 2).sum())


@dataclass(frozen=True, eq=False)
class TestRecord:
    """One test on one specimen; stress and strain positive in compression.

    Attributes
    ----------
    kind : str
    strength : float
        What the test is made for [Pa]: the largest axial stress, the tensile strength and so on, as a positive number.
    failed : bool
        Whether the load fell behind a peak; else `strength` is the largest that was reached.
    reason : str
        Why the test ended.
    curves : dict of str to (k,)
        By the names of `UNITS`.
    numbers : dict of str to float
        Others, by name with the unit in SI.
    cracks : Cracks
    positions, displacements : (n, d) [m]
        At the end, in the order of the specimen.
    warnings : tuple of str
    steps : int
    seconds : float
    seed : int or None
        Of the specimen.
    """

    __test__ = False  # not one of pytest's

    kind: str
    strength: float
    failed: bool
    reason: str
    curves: dict[str, Floats]
    numbers: dict[str, float]
    cracks: Cracks
    positions: Floats
    displacements: Floats
    steps: int
    seconds: float
    seed: int | None
    warnings: tuple[str, ...] = field(default=())

    @property
    def peak(self) -> int:
        """Place of the strength in the curves."""
        stress = self.curves.get("axial_stress", self.curves.get("force"))
        return int(np.argmax(np.abs(stress))) if stress is not None and len(stress) else 0

    def summary(self) -> str:
        """One line."""
        verdict = "" if self.failed else f", NOT failed ({self.reason})"
        confined = self.numbers.get("confinement", 0.0)
        at = f" at {confined / 1e6:.4g} MPa" if confined else ""
        return (
            f"{self.kind}{at}: {self.strength / 1e6:.4g} MPa{verdict}, cracks {self.cracks.tension} in tension, "
            f"{self.cracks.shear} in shear, {self.steps:,} steps, {self.seconds:.1f} s"
        )


def friction_of(slope: float) -> float:
    """Friction angle [rad] of an envelope whose major principal stress rises by `slope` per confinement."""
    return math.asin((slope - 1.0) / (slope + 1.0))
