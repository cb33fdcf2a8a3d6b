"""From a rock's properties to bonds: the map turned round, what cannot be had, and the next trial after a measured one.

The two scales come last and cost nothing: bonds of other Ec and Tb, everything else alike, make a specimen of which all
moduli and all strengths are that much larger. So the search is over what is dimensionless: nu, R = UCS/T and phi by the
stiffness ratio, C/Tb, tan(phi_b) and what else the map varies. Then Ec = E/(E/Ec) and Tb = T/(T/Tb).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..errors import InputError
from ..laboratory.material import BondedMaterial
from .surrogate import Estimate, Surrogate
from .table import DEFAULTS, LOGARITHMIC, from_scale, to_scale
from .targets import RockTargets

Floats = NDArray[np.float64]

AIMS = ("poisson_ratio", "strength_ratio", "friction_angle")
"""The dimensionless properties, in the order in which they are told."""

STARTS = 4
"""Points of the map from which the search begins: those nearest to what is wanted."""

_PREFERENCE = 0.03  # of a variable's usual value, in standard deviations of the aims per half range
_IN_HULL = 100.0  # the same of staying where was measured
_HEAVY = 20.0  # of the properties that are kept, against the one whose nearest value is asked for
_CLOSE = {"poisson_ratio": 0.005, "strength_ratio": 0.02, "friction_angle": math.radians(1.0)}
# what counts as met, even where the map is known better


@dataclass(frozen=True)
class Miss:
    """A property that the bonds of the map cannot have as wanted.

    Attributes
    ----------
    name : str
        Of `AIMS`.
    wanted, nearest : float
        [-] or [rad]; `nearest` with the other properties as wanted, or as near to it as they come.
    others_kept : bool
        Whether the other properties are met there.
    """

    name: str
    wanted: float
    nearest: float
    others_kept: bool

    def __str__(self) -> str:
        kept = "with the others as wanted" if self.others_kept else "with the others as near as they come"
        bound = "at most" if self.nearest < self.wanted else "at least"
        wanted, nearest = _show(self.name, self.wanted), _show(self.name, self.nearest)
        return f"{_TITLES[self.name]} {wanted} cannot be had: {bound} {nearest} {kept}"


@dataclass(frozen=True)
class Fit:
    """Bonds for a rock.

    Attributes
    ----------
    micro : dict of str to float
        Dimensionless, names of `geodem.calibration.table.MICRO`.
    effective_modulus, tensile_strength : float
        Of the bonds [Pa].
    answers : dict of str to Estimate
        What the map says that specimens of them give: names of `RockTargets`, SI.
    missed : tuple of Miss
        Empty where the targets can be had.
    """

    micro: Mapping[str, float]
    effective_modulus: float
    tensile_strength: float
    answers: Mapping[str, Estimate]
    missed: tuple[Miss, ...]

    def material(self, density: float, *, name: str = "rock") -> BondedMaterial:
        """The bonds and contacts as a laboratory takes them."""
        return BondedMaterial.rock(
            density=density,
            effective_modulus=self.effective_modulus,
            stiffness_ratio=self.micro["stiffness_ratio"],
            tensile_strength=self.tensile_strength,
            shear_strength=self.micro["shear_over_tension"] * self.tensile_strength,
            friction_angle=math.atan(self.micro["bond_friction"]),
            moment_contribution=self.micro["moment_contribution"],
            residual_friction=self.micro["residual_friction"],
            bonding_range=self.micro["bonding_range"],
            name=name,
        )


def invert(
    surrogate: Surrogate,
    targets: RockTargets,
    *,
    keep: Mapping[str, float] | None = None,
    tests: int | None = None,
) -> Fit:
    """Bonds of which specimens have the targets' properties.

    Where more is free than is asked for, what is left of the freedom goes to the usual values (`DEFAULTS`). Outside of
    what was measured nothing is given: the nearest that can be had is, and `Fit.missed` tells what it lacks. After
    trials, invert `surrogate.corrected(trials)`: that is a secant step in which every trial counts as much as its
    specimens tell.

    Parameters
    ----------
    surrogate : Surrogate
    targets : RockTargets
        Checked (`check_targets`).
    keep : dict of str to float, optional
        Micro-parameters that are to have this value.
    tests : int, optional
        The intervals are those of means over so many specimens; without it, over all that there could be.

    Raises
    ------
    InputError
        A kept value outside of what was measured.
    """
    search = _Search(surrogate, targets, dict(keep or {}))
    place = search.solve(dict.fromkeys(search.aims, 1.0))
    missed = []
    for name in search.missed(place):
        others = {other: 1.0 if other == name else _HEAVY for other in search.aims}
        there = search.solve(others, start=place)
        nearest = from_scale(name, search.value(there, name))
        kept = not [other for other in search.missed(there) if other != name]
        missed.append(Miss(name, search.wanted(name), nearest, kept))
    return _fit(surrogate, targets, place, tuple(missed), tests)


def _fit(
    surrogate: Surrogate, targets: RockTargets, place: Floats, missed: tuple[Miss, ...], tests: int | None
) -> Fit:
    found = {name: surrogate.estimate(place, name, tests=tests) for name in surrogate.answers}
    for name in ("modulus_ratio", "tension_ratio"):
        if name not in found:
            raise InputError(f"map, {name}", "the map lacks it, and no scale follows", "Measure it")
    modulus = targets.young_modulus / found["modulus_ratio"].value
    strength = targets.tensile_strength / found["tension_ratio"].value
    answers = {
        "young_modulus": found["modulus_ratio"].times(modulus),
        "tensile_strength": found["tension_ratio"].times(strength),
    }
    if "compression_ratio" in found:
        answers["uniaxial_compressive_strength"] = found["compression_ratio"].times(strength)
    for name in ("poisson_ratio", "friction_angle"):
        if name in found:
            answers[name] = found[name]
    return Fit(surrogate.micro(place), modulus, strength, answers, missed)


class _Search:
    """Least squares over the coordinates of the map, in units of what each answer is known to."""

    def __init__(self, surrogate: Surrogate, targets: RockTargets, keep: Mapping[str, float]) -> None:
        self.surrogate = surrogate
        self.aims = [name for name in AIMS if name in surrogate.answers]
        self._targets = targets
        self._weights = {
            name: max(surrogate.answers[name].surface.leave_one_out, _CLOSE[name]) for name in self.aims
        }
        self.kept = self._kept(keep)
        self._free = [i for i, name in enumerate(surrogate.variables) if name not in keep]
        usual = surrogate.micro(np.zeros(len(surrogate.variables)))
        usual.update({name: value for name, value in DEFAULTS.items() if name in surrogate.variables})
        self._usual = np.clip(surrogate.place(usual), -1.0, 1.0)

    def _kept(self, keep: Mapping[str, float]) -> dict[int, float]:
        found = {}
        surrogate = self.surrogate
        for name, value in keep.items():
            if name in surrogate.variables:
                index = surrogate.variables.index(name)
                middle = surrogate.micro(np.zeros(len(surrogate.variables)))
                found[index] = float(surrogate.place({**middle, name: value})[index])
                low, high = (surrogate.micro(np.full(len(surrogate.variables), end))[name] for end in (-1, 1))
                fault = abs(found[index]) > 1.0 + 1e-6
            else:
                low = high = surrogate.fixed.get(name, math.nan)
                fault = not math.isclose(low, value, rel_tol=1e-6, abs_tol=1e-9)
            if fault:
                remedy = f"The map holds {low:.4g}" + ("" if low == high else f" to {high:.4g}")
                raise InputError(name, "this lies outside of what was measured", remedy, value=value)
        return found

    def wanted(self, name: str) -> float:
        """A property of the targets, dimensionless."""
        return float(getattr(self._targets, name))

    def missed(self, place: Floats) -> list[str]:
        """Aims that are missed there by more than the map errs."""
        return [name for name in self.aims if abs(self._error(place, name)) > 1.0]

    def _error(self, place: Floats, name: str) -> float:
        return (self.value(place, name) - to_scale(name, self.wanted(name))) / self._weights[name]

    def value(self, place: Floats, name: str) -> float:
        """An aim at coordinates (d,), in the scale of the fit.

        UCS/T is that of the two surfaces whose strengths are told as achieved. It has a surface of its own too, which
        agrees with them in the map, but after trials each of the three is drawn to them by its own errors.
        """
        answers = self.surrogate.answers
        if name == "strength_ratio" and {"compression_ratio", "tension_ratio"} <= answers.keys():
            compression, _ = self.surrogate.raw(place, "compression_ratio")
            tension, _ = self.surrogate.raw(place, "tension_ratio")
            return compression - tension
        return self.surrogate.raw(place, name)[0]

    def solve(self, weights: Mapping[str, float], *, start: Floats | None = None) -> Floats:
        """Coordinates (d,) where the aims are best met, within what was measured."""
        surrogate = self.surrogate
        if not self._free:
            return self._whole(np.empty(0))

        def residuals(free: Floats) -> Floats:
            place = self._whole(free)
            aims = [weights[name] * self._error(place, name) for name in self.aims]
            outside = _IN_HULL * surrogate.distance(place)
            usual = _PREFERENCE * (free - self._usual[self._free])
            return np.array([*aims, outside, *usual])

        starts = [self._usual] if start is None else [start]
        starts += self._nearest_points(weights)
        steps = np.full(len(self._free), 1e-5)
        best = None
        for begin in starts:
            free = np.clip(begin[self._free], -1.0 + 1e-9, 1.0 - 1e-9)
            found = least_squares(residuals, free, bounds=(-1.0, 1.0), x_scale=0.5, diff_step=steps)
            if best is None or found.cost < best.cost * (1.0 - 1e-9):
                best = found
        assert best is not None
        return self._whole(best.x)

    def _whole(self, free: Floats) -> Floats:
        place = np.array(self._usual)
        place[self._free] = free
        for index, value in self.kept.items():
            place[index] = value
        return place

    def _nearest_points(self, weights: Mapping[str, float]) -> list[Floats]:
        """Measured points that come nearest to the aims."""
        surrogate = self.surrogate
        places = {tuple(self._row(index)): None for index in range(len(surrogate.table.rows))}
        ranked = sorted(
            (sum((weights[name] * self._error(np.array(place), name)) ** 2 for name in self.aims), place)
            for place in places
        )
        return [np.array(place) for _, place in ranked[:STARTS]]

    def _row(self, index: int) -> list[float]:
        row = {**self.surrogate.fixed, **self.surrogate.table.rows[index].micro}
        return [float(value) for value in self.surrogate.place({**DEFAULTS, **row})]


_TITLES = {
    "poisson_ratio": "Poisson's ratio",
    "strength_ratio": "compressive over tensile strength",
    "friction_angle": "a friction angle of",
}


def _show(name: str, value: float) -> str:
    if name == "friction_angle":
        return f"{math.degrees(value):.3g} deg"
    return f"{value:.3g}" if name in LOGARITHMIC else f"{value:.2f}"
