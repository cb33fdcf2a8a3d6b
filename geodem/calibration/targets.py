"""What a calibration aims at: the properties of a rock, and whether any rock can have them all."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from ..errors import InputError
from ..laboratory.confined import CONFINED
from ..units import show

LARGEST_FRICTION = math.radians(65.0)
"""Of intact rock [rad]: granite at low confinement comes to 60 deg."""

OPTIONAL = ("friction_confinement",)
"""What need not be given."""

LEAST_CONFINEMENT = 0.02
"""Of the compressive strength: below it the scatter of the strengths hides what friction adds."""

LARGEST_RATIO = 60.0
"""Of uniaxial compressive over direct tensile strength [-]: 0.81 mi + 7 is 36 for the largest mi of Hoek's table."""

_DENSITY = (1000.0, 5100.0)  # [kg/m3]: pumice and massive ore lie outside, and are no bonded rock
_YOUNG_MODULUS = (1e7, 3e11)  # [Pa]: weak mudstone to quartzite, with a margin
_COMPRESSION = (2e5, 6e8)  # [Pa]: soil begins below (ISRM R0: 0.25 MPa), the strongest basalt ends at 0.5 GPa
_TENSION = (5e3, 6e7)  # [Pa]
_MODULUS_RATIO = (50.0, 3000.0)
# E/UCS: 150 (shale) to 1000 (marble) in Hoek & Diederichs 2006, Int. J. Rock Mech. Min. Sci. 43:203-215, table 4

_DIMENSIONS = {
    "density": "density",
    "young_modulus": "stress",
    "uniaxial_compressive_strength": "stress",
    "tensile_strength": "stress",
    "friction_angle": "angle",
    "friction_confinement": "stress",
    "poisson_ratio": "dimensionless",
}


@dataclass(frozen=True)
class RockTargets:
    """Properties of a rock as its laboratory tests give them.

    Attributes
    ----------
    density : float
        [kg/m3]
    young_modulus : float
        [Pa]
    poisson_ratio : float
        [-]
    uniaxial_compressive_strength : float
        [Pa]
    tensile_strength : float
        Of a direct tension test [Pa]; that is 0.9 (metamorphic), 0.8 (igneous) or 0.7 (sedimentary rock) of a Brazilian
        test's (Perras & Diederichs 2014).
    friction_angle : float
        Of the straight line through the strengths between no confinement and `sides` [rad].
    friction_confinement : float
        The confinement [Pa] up to which that line was laid; where it is not given, half the compressive strength. Rock
        is steeper at low confinement: an angle says little without it.

    NaN stands for what is not given; `check_targets` tells it.
    """

    density: float = math.nan
    young_modulus: float = math.nan
    poisson_ratio: float = math.nan
    uniaxial_compressive_strength: float = math.nan
    tensile_strength: float = math.nan
    friction_angle: float = math.nan
    friction_confinement: float = math.nan

    @property
    def sides(self) -> float:
        """Confinement of the test that gives the friction angle [Pa]."""
        if math.isnan(self.friction_confinement):
            return CONFINED * self.uniaxial_compressive_strength
        return self.friction_confinement

    @property
    def strength_ratio(self) -> float:
        """Compressive over tensile strength [-]."""
        return self.uniaxial_compressive_strength / self.tensile_strength

    @property
    def cohesion(self) -> float:
        """Of the Mohr-Coulomb line through the compressive strength, UCS (1 - sin phi)/(2 cos phi) [Pa]."""
        sine = math.sin(self.friction_angle)
        return self.uniaxial_compressive_strength * (1.0 - sine) / (2.0 * math.cos(self.friction_angle))

    def shown(self, name: str) -> str:
        """A property with its unit, as a reader wants it."""
        return show(getattr(self, name), _DIMENSIONS[name])


def flow_number(friction_angle: float) -> float:
    """(1 + sin phi)/(1 - sin phi) [-]: strength added per confinement.

    Also the least UCS/T: an envelope that steepens towards tension, as those of rocks do, leaves less tensile strength
    than the straight line.
    """
    sine = math.sin(friction_angle)
    return (1.0 + sine) / (1.0 - sine)


def check_targets(targets: RockTargets, dimension: int, *, place: str = "rock") -> list[InputError]:
    """What is wrong with targets, all at once and before any test is run.

    Parameters
    ----------
    targets : RockTargets
    dimension : int
        Of the particles, 2 or 3.
    place : str
        What the properties' names stand under in the messages.

    Returns
    -------
    list of InputError
        First `contradictions`, then `doubts`; empty where a rock can have these properties. Whether particles can be
        given them is for the map to tell.
    """
    found = []
    if dimension not in (2, 3):
        found.append(
            InputError("dimension", "particles are discs (2) or spheres (3)", "Write 2 or 3", value=dimension)
        )
    return [*found, *contradictions(targets, place=place), *doubts(targets, place=place)]


def contradictions(targets: RockTargets, *, place: str = "rock") -> list[InputError]:
    """Properties that are missing, that are no numbers of their kind, or that exclude each other."""
    found = []
    given = set()
    for field in fields(targets):
        value = getattr(targets, field.name)
        where = f"{place}.{field.name}"
        if math.isnan(value):
            if field.name in OPTIONAL:
                continue
            found.append(InputError(where, "missing", _EXAMPLES[field.name]))
        elif not (math.isfinite(value) and value > 0.0):
            problem = "this must be a finite number greater than 0"
            found.append(InputError(where, problem, _EXAMPLES[field.name], value=value))
        else:
            given.add(field.name)
    ratio = targets.poisson_ratio
    if "poisson_ratio" in given and ratio >= 0.5:
        meant = f"Did you mean {ratio / 100.0:g}?" if 1.0 <= ratio < 50.0 else "Rocks have 0.1 to 0.4"
        problem = "Poisson's ratio lies between 0 and 0.5"
        found.append(InputError(f"{place}.poisson_ratio", problem, meant, value=ratio))
    if "friction_angle" in given and targets.friction_angle >= 0.5 * math.pi - 1e-9:
        where = f"{place}.friction_angle"
        remedy = "Rocks have 20 to 60 deg"
        value = targets.shown("friction_angle")
        found.append(InputError(where, "a friction angle is below 90 deg", remedy, value=value))
        given.discard("friction_angle")
    if {"tensile_strength", "uniaxial_compressive_strength"} <= given:
        found += _strengths(targets, "friction_angle" in given, place)
    if {"friction_confinement", "uniaxial_compressive_strength"} <= given:
        found += _confinement(targets, place)
    return found


def _confinement(targets: RockTargets, place: str) -> list[InputError]:
    """A confinement of the friction angle that tells nothing, or is beyond what breaks by cracks."""
    compression, sides = targets.uniaxial_compressive_strength, targets.friction_confinement
    low, high = LEAST_CONFINEMENT * compression, compression
    if low <= sides <= high:
        return []
    problem = (
        "so little adds less than specimens scatter"
        if sides < low
        else "this is above the compressive strength"
    )
    remedy = f"Give {show(low, 'stress')} to {show(high, 'stress')}, or leave it out for half the strength"
    value = targets.shown("friction_confinement")
    return [InputError(f"{place}.friction_confinement", problem, remedy, value=value)]


def _strengths(targets: RockTargets, friction: bool, place: str) -> list[InputError]:
    """Tension against compression, and against the envelope where its angle is known."""
    where = f"{place}.tensile_strength"
    tension, compression = targets.tensile_strength, targets.uniaxial_compressive_strength
    value = targets.shown("tensile_strength")
    if tension >= compression:
        problem = (
            f"this is not below the compressive strength, {targets.shown('uniaxial_compressive_strength')}"
        )
        remedy = f"Rocks have a tenth of it, here {show(0.1 * compression, 'stress')}: check both units"
        return [InputError(where, problem, remedy, value=value)]
    if not friction or targets.friction_angle > LARGEST_FRICTION:
        return []  # the angle itself is doubted, so no other number is judged by it
    least = flow_number(targets.friction_angle)
    if targets.strength_ratio >= least:
        return []
    largest = compression / least
    # the friction of which UCS/T is the flow number
    angle = math.asin((targets.strength_ratio - 1.0) / (targets.strength_ratio + 1.0))
    problem = (
        f"compressive over tensile strength is {targets.strength_ratio:.3g}, and a Mohr-Coulomb line of "
        f"{targets.shown('friction_angle')} through the compressive strength leaves at least {least:.3g}"
    )
    remedy = (
        f"Give at most {show(_rounded_down(largest), 'stress')} of tensile strength, or at most "
        f"{math.degrees(angle):.3g} deg of friction_angle"
    )
    return [InputError(where, problem, remedy, value=value)]


def doubts(targets: RockTargets, *, place: str = "rock") -> list[InputError]:
    """Properties that no rock has, each with what was probably meant: mostly a unit that was mistaken.

    What is missing or no number is left to `contradictions`.
    """
    found = []
    for name, (smallest, largest), kind in (
        ("density", _DENSITY, "rocks have 1000 to 5100 kg/m3"),
        ("young_modulus", _YOUNG_MODULUS, "rocks have 10 MPa to 300 GPa"),
        ("uniaxial_compressive_strength", _COMPRESSION, "rocks have 0.2 to 600 MPa"),
        ("tensile_strength", _TENSION, "rocks have 5 kPa to 60 MPa"),
    ):
        value = getattr(targets, name)
        if _usable(value) and not smallest <= value <= largest:
            hint = _hint(value, smallest, largest, _DIMENSIONS[name])
            found.append(InputError(f"{place}.{name}", kind, hint, value=targets.shown(name)))
    doubted = {error.place for error in found}
    friction = targets.friction_angle
    if _usable(friction) and LARGEST_FRICTION < friction < 0.5 * math.pi - 1e-9:
        times = flow_number(friction)
        problem = f"no rock has so much: a pressure would add {times:.3g} times itself to the strength"
        remedy = (
            "Granite at low confinement comes to 60 deg; fit the line up to half the compressive strength, or say with "
            "friction_confinement up to where it was fitted"
        )
        value = targets.shown("friction_angle")
        found.append(InputError(f"{place}.friction_angle", problem, remedy, value=value))
    elif _usable(friction) and friction < math.radians(1.6):
        degrees = math.degrees(friction)
        problem = "so small an angle looks like radians"
        remedy = f'Did you mean "{degrees:.3g} rad" ({math.degrees(degrees):.3g} deg)?'
        value = targets.shown("friction_angle")
        found.append(InputError(f"{place}.friction_angle", problem, remedy, value=value))
    compression = targets.uniaxial_compressive_strength
    if _usable(targets.young_modulus) and _usable(compression):
        found += _modulus_ratio(targets, doubted, place)
    ratio = targets.strength_ratio if _usable(targets.tensile_strength) and _usable(compression) else math.nan
    if ratio > LARGEST_RATIO and f"{place}.tensile_strength" not in doubted:
        problem = f"the compressive strength is {ratio:.3g} times as much; rocks have 5 to 35 times"
        meant = [f for f in (10.0, 1e3) if 4.0 <= ratio / f <= LARGEST_RATIO]
        shown = show(targets.tensile_strength * meant[0] if meant else compression / 12.0, "stress")
        remedy = f'Did you mean "{shown}"?' if meant else f"A twelfth would be {shown}"
        value = targets.shown("tensile_strength")
        found.append(InputError(f"{place}.tensile_strength", problem, remedy, value=value))
    return found


def _modulus_ratio(targets: RockTargets, doubted: set[str], place: str) -> list[InputError]:
    """E/UCS, judged where neither of the two was doubted by itself."""
    smallest, largest = _MODULUS_RATIO
    compression = targets.uniaxial_compressive_strength
    ratio = targets.young_modulus / compression
    pair = {f"{place}.young_modulus", f"{place}.uniaxial_compressive_strength"}
    if smallest <= ratio <= largest or pair & doubted:
        return []
    problem = f"Young's modulus is {ratio:.3g} times the compressive strength; rocks have 100 to 1000 times"
    low, high = show(100.0 * compression, "stress"), show(1000.0 * compression, "stress")
    remedy = f"With this strength {low} to {high}: check both units"
    return [InputError(f"{place}.young_modulus", problem, remedy, value=targets.shown("young_modulus"))]


def _hint(value: float, smallest: float, largest: float, dimension: str) -> str:
    """What may have been meant: a step of a thousand or a million."""
    for factor in (1e3, 1e-3, 1e6, 1e-6):
        if smallest <= value * factor <= largest:
            return f'Did you mean "{show(value * factor, dimension)}"?'
    return "Check the unit"


def _usable(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _rounded_down(value: float) -> float:
    """Three digits, not more than the value: a remedy that is followed to the letter must help."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.floor(value / step) * step


_EXAMPLES = {
    "density": 'Write density = "2600 kg/m3"',
    "young_modulus": 'Write young_modulus = "30 GPa"',
    "poisson_ratio": "Write poisson_ratio = 0.25; rocks have 0.1 to 0.4",
    "uniaxial_compressive_strength": 'Write uniaxial_compressive_strength = "80 MPa"',
    "tensile_strength": 'Write tensile_strength = "6 MPa", of a direct tension test or 0.7 to 0.9 of the Brazilian one',
    "friction_angle": 'Write friction_angle = "45 deg", of strengths between 0 and half the compressive one',
    "friction_confinement": 'Write friction_confinement = "20 MPa", or leave it out for half the compressive strength',
}
