"""All properties of a material on one specimen: E, nu, compressive and tensile strength, friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

from . import pace as paces
from .axial import compress, pull
from .confined import CONFINED
from .envelope import fit_envelope
from .material import BondedMaterial
from .record import TestRecord
from .rig import STEP
from .specimen import Specimen

FALL = 0.85
"""Share of the peak at which a test ends whose curve beyond the peak is not asked for."""


@dataclass(frozen=True)
class Properties:
    """What was measured on one specimen.

    Attributes
    ----------
    young_modulus [Pa], poisson_ratio : float
        Of the middle of the specimen, by one elastic solve. In 2D those of a plate: plane stress.
    compressive_strength, tensile_strength : float [Pa]
    friction_angle : float
        Of the straight envelope between no confinement and that of the confined test [rad].
    low_friction_angle : float
        The same up to the lower confinement [rad]; nan where none was asked for.
    records : tuple of TestRecord
    """

    young_modulus: float
    poisson_ratio: float
    compressive_strength: float
    tensile_strength: float
    friction_angle: float
    low_friction_angle: float
    records: tuple[TestRecord, ...]

    @property
    def seconds(self) -> float:
        """Run time of the tests [s]."""
        return sum(record.seconds for record in self.records)


def measure_properties(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    expected: dict[str, float] | None = None,
    confinement: float | None = None,
    lower: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
) -> Properties:
    """Measure E, nu, tension, compression and confined compression.

    Parameters
    ----------
    specimen : Specimen
    material : BondedMaterial
    expected : dict, optional
        Axial strains at the peaks by "compression", "tension", "confined": what is missing is found by pilots.
    confinement : float, optional
        Of the confined test [Pa]; `CONFINED` of the measured compressive strength where it is left out.
    lower : float, optional
        Of one more confined test, over the measured compressive strength [-].
    pace, time_share : float
        See `compress`.

    Raises
    ------
    InputError
        As of the tests.
    """
    known = expected or {}

    def pressed_at(sides: float, strain: float | None) -> TestRecord:
        return compress(
            specimen,
            material,
            confinement=sides,
            expected_strain=strain,
            pace=pace,
            time_share=time_share,
            fall=FALL,
        )

    pulled = pull(
        specimen, material, expected_strain=known.get("tension"), pace=pace, time_share=time_share, fall=FALL
    )
    pressed = pressed_at(0.0, known.get("compression"))
    sides = confinement if confinement is not None else CONFINED * pressed.strength
    guess = known.get("confined")
    if guess is None and math.isfinite(pressed.numbers["peak_strain"]):
        # it is farther the more friction there is: of sandstone and granite about six times
        guess = 6.0 * pressed.numbers["peak_strain"]
    records = [pulled, pressed, pressed_at(sides, guess)]
    frictions = [_friction(pressed, records[-1])]
    if lower is not None:
        records.append(pressed_at(lower * pressed.strength, None if guess is None else 0.5 * guess))
        frictions.append(_friction(pressed, records[-1]))
    numbers = pressed.numbers
    return Properties(
        numbers["young_modulus"],
        numbers["poisson_ratio"],
        pressed.strength,
        pulled.strength,
        frictions[0],
        frictions[1] if lower is not None else math.nan,
        tuple(records),
    )


def _friction(pressed: TestRecord, confined: TestRecord) -> float:
    sides = confined.numbers["confinement"]
    return fit_envelope([0.0, sides], [pressed.strength, confined.strength]).friction_angle
