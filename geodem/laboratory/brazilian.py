"""Splitting of a disc: the Brazilian test.

Curved jaws bear on a short arc of the disc's rim, 10 degrees as the suggested method has it. Here they are the
particles that lie outermost on that arc at both ends of the loaded diameter: driven towards each other, free across.
In the elastic state of random discs 40 particles across the most stressed bond is one well inside, and no crack comes
first at the loads. With wider jaws the halves go on to bear when the disc has split: with 15 degrees
the load comes to a tenth to a quarter more, with 30 to three quarters more. What it comes to after it has fallen by
`DROP` is no strength.

Reference: ISRM 1978, Suggested methods for determining tensile strength of rock materials, Int. J. Rock Mech. Min. Sci.
Geomech. Abstr. 15:99-103 (sigma_t = 2 P/(pi D t), jaws in contact over about 10 degrees at failure).
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import pace as paces
from .course import Driving, carry_out
from .driven import Driven, outermost
from .material import BondedMaterial
from .record import Cracks, TestRecord
from .rig import STEP, Watch
from .specimen import Specimen

ARC = math.radians(10.0)
"""Of the rim that a jaw bears on [rad]."""

WIDEST = math.radians(60.0)
"""Jaws that are wider press a disc and do not split it [rad]."""

DROP = 0.1
"""Share of the load that is lost when a disc has split."""

FALL = 0.7
"""Share of the peak at which the test ends."""

OVERSHOOT = 2.5
"""Displacement at the peak over `Driven.scale`, at a guess."""

PILOT_SHARE = 0.9
"""Displacement at the peak over that of the fast pilot's."""

EARLY = 0.25
"""Share of the cracks up to the peak that count as the first ones."""

NEAR = 0.15
"""Distance from the loads, over the diameter, up to which a crack is one of crushing."""


def split(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    arc: float = ARC,
    expected_displacement: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
    fall: float = FALL,
    seed: int | None = None,
    watch: Watch | None = None,
) -> TestRecord:
    """Split a disc between two jaws.

    Parameters
    ----------
    specimen : Specimen
        Disc.
    material : BondedMaterial
    arc : float
        Of the rim that a jaw bears on [rad].
    expected_displacement : float, optional
        By which the jaws have come closer at the peak, roughly [m]: sets the rate. A fast pilot finds it where it is
        left out.
    pace : float
        See `geodem.laboratory.pace`.
    time_share : float
        Of the critical time step.
    fall : float
        Share of the peak at which the test ends.
    seed : int, optional
        Of the scatter of bond strengths; the specimen's where it is left out.

    Returns
    -------
    TestRecord
        `strength` is the Brazilian tensile strength 2 P/(pi D t) [Pa]; the curve `axial_stress` is that of the load.
        Numbers: first_break_stress and largest_stress (of the halves, where they bear more) [Pa], stiffness [N/m],
        peak_displacement [m], crushing (share of the first cracks that lie near the loads).

    Raises
    ------
    InputError
        No disc, an arc that is none, or as of `geodem.laboratory.driven.Driven`.
    """
    begun = time.perf_counter()
    if specimen.shape != "disc":
        raise InputError(
            "specimen, shape", "what is split is a disc", 'Give shape "disc"', value=specimen.shape
        )
    if not (math.isfinite(arc) and 0.0 < arc <= WIDEST):
        raise InputError(
            "brazilian, arc", "jaws bear on a short arc of the rim",
            f"Give up to {math.degrees(WIDEST):g} deg; {math.degrees(ARC):g} deg is the suggested method's",
            value=f"{math.degrees(arc):g} deg",
        )  # fmt: skip
    own = seed if seed is not None else (specimen.seed or 1)
    motion = jaws(specimen, arc)
    driving = Driving(
        per_force=splitting_stress(specimen, 1.0),
        high=specimen.across, overshoot=OVERSHOOT, share=PILOT_SHARE, fall=fall,
    )  # fmt: skip

    def mounted() -> Driven:
        return Driven(specimen, material, motion, time_share=time_share, seed=own)

    run = carry_out(mounted, driving, pace=pace, expected=expected_displacement, watch=watch)
    curves, driven = run.curves, run.driven
    top = split_at(curves["force"])
    s = driven.simulation
    cracks = driven.cracks(curves["steps"], curves["axial_stress"])
    strength = float(curves["axial_stress"][top])
    at_peak = int(curves["tension_cracks"][top] + curves["shear_cracks"][top])
    numbers = {
        "largest_stress": float(curves["axial_stress"].max()),
        "residual_stress": float(curves["axial_stress"][-1]),
        "crushing": crushing(specimen, cracks, at_peak),
        **run.numbers(top),
    }
    warnings = run.warnings(numbers, pace)
    if numbers["crushing"] > 0.5:
        warnings.append(
            f"{numbers['crushing']:.0%} of the first cracks lie within {NEAR:.0%} of the diameter of the loads: "
            "it was crushed there, and the strength is no tensile strength"
        )
    return TestRecord(
        "brazilian", strength, run.failed, run.reason, curves, numbers, cracks, s.positions,
        s.positions - driven.start, run.steps, time.perf_counter() - begun, specimen.seed, tuple(warnings),
    )  # fmt: skip


def splitting_stress(specimen: Specimen, force: float) -> float:
    """Tensile stress [Pa] in the middle of an elastic disc under opposite forces [N]: 2 P/(pi D t)."""
    return 2.0 * force / (math.pi * specimen.area)


def jaws(specimen: Specimen, arc: float = ARC) -> NDArray[np.float64]:
    """Motion (n, d) for `Driven` of the outermost particles on an arc [rad] at both ends of the loaded diameter."""
    motion = np.full(specimen.positions.shape, np.nan)
    half = 0.5 * specimen.width * math.sin(0.5 * arc)
    middle = 0.5 * specimen.size
    low, high = np.zeros(specimen.dimension - 1), specimen.size[:-1].copy()
    low[0], high[0] = middle[0] - half, middle[0] + half
    for sign in (1.0, -1.0):
        at, _ = outermost(specimen.positions, specimen.radii, specimen.dimension - 1, sign, low, high)
        off = np.abs(specimen.positions[at, 0] - middle[0])
        motion[at[(off <= half) | (off == off.min(initial=math.inf))], -1] = -0.5 * sign
    return motion


def split_at(force: NDArray[np.float64]) -> int:
    """Place of the largest load [N] before the first fall by `DROP`."""
    fallen = np.flatnonzero(force < (1.0 - DROP) * np.maximum.accumulate(force))
    return int(np.argmax(force[: fallen[0] if len(fallen) else len(force)]))


def crushing(specimen: Specimen, cracks: Cracks, at_peak: int) -> float:
    """Share of the first cracks before the peak that lie near the loads [-]; 0 without cracks."""
    first = cracks.place[: math.ceil(EARLY * at_peak)][:, [0, -1]]
    if not len(first):
        return 0.0
    loads = np.array([[0.5 * specimen.width, 0.0], [0.5 * specimen.width, specimen.height]])
    away = np.sqrt(((first[:, None] - loads) ** 2).sum(axis=2)).min(axis=1)
    return float((away < NEAR * specimen.width).mean())
