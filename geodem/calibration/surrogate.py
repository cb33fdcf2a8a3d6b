"""The map from bonds to rock: surfaces through what was measured, what they are worth, and where they hold.

The micro side is dimensionless (`geodem.calibration.table.MICRO`), the macro side too: moduli over the bonds' effective
modulus, strengths over their tensile strength. It knows nothing of how the table was measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from ..errors import InputError
from .estimate import CONFIDENCE, Estimate
from .surface import Noise, Surface, fit_surface, nearest_in_hull, noise_of
from .table import DEFAULTS, LOGARITHMIC, MACRO, MICRO, MapTable

Floats = NDArray[np.float64]

ELASTIC = ("stiffness_ratio", "bonding_range")
"""All that the elastic answers of an unbroken specimen depend on."""

_BY_FACTOR = frozenset({"stiffness_ratio", "shear_over_tension"})
_ELASTIC_ANSWERS = frozenset({"modulus_ratio", "poisson_ratio"})

FLOORS = {"poisson_ratio": 0.02, "friction_angle": math.radians(3.0)}
FLOOR = 0.1
"""How far other specimens than those of the map may lie off it at least (for moduli and strengths as a share): other
sizes, other resolutions, other seeds."""

REACH = 1.0
"""Distance, in half ranges of the map, over which a correction found at one point loses most of its hold."""

EDGE = 1e-3
"""In half ranges: nearer to an end of what was measured is at it."""

POOLED = 3
"""Degrees of freedom from which on the scatter is that of the trials' own specimens."""


@dataclass(frozen=True)
class Measured:
    """What tests of a trial material gave, dimensionless as in the map.

    Attributes
    ----------
    micro : dict of str to float
        Names of `MICRO`.
    macro : dict of str to sequence of float
        Names of `MACRO`, a value for each specimen.
    """

    micro: Mapping[str, float]
    macro: Mapping[str, Sequence[float]]


@dataclass(frozen=True, eq=False)
class _Answer:
    """One macro answer: its surface and which of the variables it depends on."""

    name: str
    surface: Surface
    variables: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Surfaces of all macro answers over the variables that the table varies.

    Attributes
    ----------
    table : MapTable
    variables : tuple of str
        Micro-parameters that vary.
    fixed : dict of str to float
        Those that do not, and what they are.
    low, high : (d,)
        Range of each variable in the scale that it is fitted in: ln kappa, ln(C/Tb), else itself.
    hulls : tuple of (tuple of int, ndarray)
        Variables and points (n, d) of what was measured, for the elastic variables and for the others: how the
        stiffness ratio shifts strengths is taken to be alike for all strengths, so it need not be measured with each.
    measured : tuple of Measured
        Trials that correct the surfaces.
    """

    table: MapTable
    variables: tuple[str, ...]
    fixed: Mapping[str, float]
    low: Floats
    high: Floats
    answers: Mapping[str, _Answer]
    hulls: tuple[tuple[tuple[int, ...], Floats], ...]
    measured: tuple[Measured, ...] = ()

    def place(self, micro: Mapping[str, float]) -> Floats:
        """Coordinates (d,) of micro-parameters, -1 to 1 over the range of the table."""
        values = [_scaled(name, micro.get(name, DEFAULTS.get(name, math.nan))) for name in self.variables]
        return 2.0 * (np.array(values) - self.low) / (self.high - self.low) - 1.0

    def micro(self, place: Floats) -> dict[str, float]:
        """Micro-parameters at coordinates (d,), the fixed ones included."""
        values = self.low + 0.5 * (place + 1.0) * (self.high - self.low)
        found = {name: _unscaled(name, float(v)) for name, v in zip(self.variables, values, strict=True)}
        return {**self.fixed, **found}

    def raw(self, place: Floats, name: str) -> tuple[float, float]:
        """A macro answer at coordinates (d,) and its standard deviation, both in the scale of the fit."""
        answer = self.answers[name]
        own = self._own(answer, place)
        values, deviations = answer.surface.predict(own[None, :])
        value, deviation = float(values[0]), float(deviations[0])
        correction = self._correction(answer, own, deviation)
        return value + correction[0], correction[1]

    def predict(self, micro: Mapping[str, float], *, tests: int | None = None) -> dict[str, Estimate]:
        """Macro answers of micro-parameters.

        Parameters
        ----------
        micro : dict of str to float
        tests : int, optional
            The interval is that of the mean over so many specimens; without it, of the mean over all that there could
            be.
        """
        place = self.place(micro)
        return {name: self.estimate(place, name, tests=tests) for name in self.answers}

    def estimate(self, place: Floats, name: str, *, tests: int | None = None) -> Estimate:
        """A macro answer at coordinates (d,) with its interval."""
        value, deviation = self.raw(place, name)
        surface = self.answers[name].surface
        if self._tried(name):
            scatter, freedom = self._scatter(name)
            quantile = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))
            half = quantile * math.hypot(deviation, scatter / math.sqrt(tests) if tests is not None else 0.0)
        else:
            half = surface.half_width(deviation, CONFIDENCE, common=True, tests=tests)
        return _estimate(name, value, half)

    def _tried(self, name: str) -> bool:
        return any(_transformed(name, trial.macro.get(name, ())).size for trial in self.measured)

    def _scatter(self, name: str) -> tuple[float, float]:
        """Standard deviation from specimen to specimen, and how many degrees of freedom tell it.

        That of the trials, pooled, where they have enough specimens: their size and resolution are those that count,
        and a map with one specimen a point tells none. Else the surface's.
        """
        found = [_transformed(name, trial.macro.get(name, ())) for trial in self.measured]
        freedom = sum(max(len(values) - 1, 0) for values in found)
        surface = self.answers[name].surface
        if freedom < POOLED and surface.scatter > 0.0:
            return surface.scatter, surface.freedom
        squares = sum(float(((values - values.mean()) ** 2).sum()) for values in found if len(values) > 1)
        if freedom == 0:
            return FLOORS.get(name, FLOOR), 1.0
        return math.sqrt(squares / freedom), float(freedom)

    def distance(self, place: Floats) -> float:
        """How far coordinates (d,) lie outside what was measured, in half ranges; 0 inside."""
        found = 0.0
        for variables, points in self.hulls:
            own = place[list(variables)]
            found = max(found, float(np.linalg.norm(nearest_in_hull(points, own) - own)))
        return found if found > 1e-6 else 0.0

    def edges(self, micro: Mapping[str, float]) -> dict[str, float]:
        """Those micro-parameters that stand at an end of what was measured, and their values."""
        place = self.place(micro)
        at_end = dict(zip(self.variables, np.abs(place) > 1.0 - EDGE, strict=True))
        return {name: float(micro[name]) for name, ended in at_end.items() if ended}

    def corrected(self, measured: Sequence[Measured]) -> Surrogate:
        """The same, drawn to what trials gave.

        The difference of a trial from the surface, of the logarithm for moduli and strengths (so that the surface is
        multiplied by measured over predicted), holds at the trial and less the farther away; a difference within the
        noise of few specimens moves the surface little. That is the posterior of a Gaussian process with the surface as
        its mean.
        """
        return replace(self, measured=tuple(map(_completed, measured)))

    def report(self) -> list[dict[str, str | float]]:
        """For each answer: the kind of surface, its error at points left out, the scatter from seed to seed."""
        return [
            {
                "answer": name,
                "surface": answer.surface.kind,
                "variables": ", ".join(answer.variables),
                "points": float(len(answer.surface.values)),
                "leave_one_out": answer.surface.leave_one_out,
                "scatter": answer.surface.scatter,
            }
            for name, answer in self.answers.items()
        ]

    def _own(self, answer: _Answer, place: Floats) -> Floats:
        return place[[self.variables.index(name) for name in answer.variables]]

    def _correction(self, answer: _Answer, own: Floats, deviation: float) -> tuple[float, float]:
        """Mean and standard deviation of what the trials add to the surface."""
        trials = []
        for trial in self.measured:
            values = _transformed(answer.name, trial.macro.get(answer.name, ()))
            if len(values):
                trials.append((self._own(answer, self.place(trial.micro)), values))
        if not trials:
            return 0.0, deviation
        places = np.array([place for place, _ in trials])
        surface = answer.surface
        offsets = np.array([values.mean() for _, values in trials]) - surface.predict(places)[0]
        scatter, _ = self._scatter(answer.name)
        noise = np.array([scatter**2 / len(values) for _, values in trials])
        prior = max(2.0 * deviation, FLOORS.get(answer.name, FLOOR)) ** 2

        def related(first: Floats, second: Floats) -> Floats:
            squared = ((first[:, None, :] - second[None, :, :]) ** 2).sum(axis=2)
            return np.asarray(prior * np.exp(-0.5 * squared / REACH**2))

        # trials of known noise; a little more keeps two trials of one material apart
        known = related(places, places) + np.diag(noise + 1e-9 * prior)
        here = related(own[None, :], places)[0]
        held = np.linalg.solve(known, here)
        return float(held @ offsets), math.sqrt(max(prior - float(held @ here), 1e-9 * prior))


def fit_surrogate(table: MapTable) -> Surrogate:
    """Surfaces through a table.

    Elastic answers are fitted over stiffness_ratio and bonding_range alone; rows that agree in these count as one.

    Raises
    ------
    InputError
        Fewer than four points of an answer that varies.
    """
    names = [name for name in MICRO if np.isfinite(table.micro(name)).all()]
    ranges = {name: np.array([_scaled(name, value) for value in table.micro(name)]) for name in names}
    variables = tuple(name for name in names if np.ptp(ranges[name]) > 1e-9)
    low = np.array([ranges[name].min() for name in variables])
    high = np.array([ranges[name].max() for name in variables])
    fixed = {name: float(table.micro(name)[0]) for name in names if name not in variables}
    units = {
        name: 2.0 * (ranges[name] - a) / (b - a) - 1.0
        for name, a, b in zip(variables, low, high, strict=True)
    }
    answers = {}
    for name in MACRO:
        answer = _answer(table, name, variables, units)
        if answer is not None:
            answers[name] = answer
    if not answers:
        raise InputError("map", "no answer was measured", f"Known: {', '.join(MACRO)}")
    return Surrogate(table, variables, fixed, low, high, answers, _hulls(table, variables, units))


def _hulls(
    table: MapTable, variables: tuple[str, ...], units: Mapping[str, Floats]
) -> tuple[tuple[tuple[int, ...], Floats], ...]:
    """What was measured, for the elastic variables and for the others."""
    tested = [i for i, row in enumerate(table.rows) if row.macro.keys() - _ELASTIC_ANSWERS]
    found = []
    for elastic in (True, False):
        own = tuple(i for i, name in enumerate(variables) if (name in ELASTIC) == elastic)
        rows = list(range(len(table.rows))) if elastic or not tested else tested
        if own:
            points = np.stack([units[variables[i]][rows] for i in own], axis=1)
            found.append((own, np.unique(points, axis=0)))
    return tuple(found)


def _answer(
    table: MapTable,
    name: str,
    variables: tuple[str, ...],
    units: Mapping[str, Floats],
) -> _Answer | None:
    by_row = table.macro(name)
    rows = [index for index, values in enumerate(by_row) if len(values)]
    if not rows:
        return None
    wanted = [v for v in variables if v in ELASTIC] if name in _ELASTIC_ANSWERS else list(variables)
    own = tuple(v for v in wanted if np.ptp(units[v][rows]) > 1e-9)
    groups: dict[tuple[float, ...], dict[int, list[float]]] = {}
    for row in rows:
        group = groups.setdefault(tuple(float(round(units[v][row], 9)) for v in own), {})
        for seed, value in by_row[row].items():
            group.setdefault(seed, []).append(value)
    by_point = [{seed: float(np.mean(found)) for seed, found in group.items()} for group in groups.values()]
    means = np.array([np.mean(list(values.values())) for values in by_point])
    counts = np.array([float(len(values)) for values in by_point])
    noise = noise_of(by_point)
    if not own:
        # nothing that this answer depends on varies: one point, known as well as its seeds tell
        return _Answer(name, _constant(means, counts, noise), own)
    return _Answer(name, fit_surface(np.array(list(groups)), means, counts, noise, what=name), own)


def _constant(values: Floats, counts: Floats, noise: Noise) -> Surface:
    deviation = noise.scatter / math.sqrt(counts[0])
    return Surface(
        kind="constant",
        points=np.zeros((1, 0)),
        values=values,
        leave_one_out=deviation,
        freedom=max(float(counts[0]) - 1.0, 1.0),
        scatter=noise.scatter,
        common=0.0,
        seeds=noise.seeds,
        deviation=deviation,
        misfit=0.0,
        weights=lambda where: np.ones((len(where), 1)),
    )


def _completed(trial: Measured) -> Measured:
    """With UCS/Tb = R T/Tb where only these two are given, specimen by specimen, as in the map."""
    macro = trial.macro
    if "compression_ratio" in macro or not {"strength_ratio", "tension_ratio"} <= macro.keys():
        return trial
    pairs = zip(macro["strength_ratio"], macro["tension_ratio"], strict=True)
    return replace(trial, macro={**macro, "compression_ratio": [ratio * tension for ratio, tension in pairs]})


def estimate_of(name: str, values: Sequence[float], *, scatter: float | None = None) -> Estimate:
    """The mean of a macro answer over specimens, with its interval.

    Parameters
    ----------
    name : str
        Of `MACRO`: tells whether values scatter by a factor or by a difference.
    values : sequence of float
        One for each specimen.
    scatter : float, optional
        Standard deviation from seed to seed where it is known (`Surface.scatter`); else it is taken from the values, of
        which there must be two.
    """
    found = _transformed(name, values)
    if len(found) == 0 or (len(found) == 1 and scatter is None):
        raise InputError(name, f"{len(found)} values tell no interval", "Run two specimens at least")
    if scatter is None:
        scatter = float(found.std(ddof=1))
        quantile = float(stdtrit(len(found) - 1, 0.5 + 0.5 * CONFIDENCE))
    else:
        quantile = float(ndtri(0.5 + 0.5 * CONFIDENCE))
    return _estimate(name, float(found.mean()), quantile * scatter / math.sqrt(len(found)))


def _estimate(name: str, value: float, half: float) -> Estimate:
    found = (value, value - half, value + half)
    return Estimate(*(map(math.exp, found) if name in LOGARITHMIC else found))


def _transformed(name: str, values: Sequence[float]) -> Floats:
    found = np.asarray(values, dtype=float)
    found = found[np.isfinite(found)]
    return np.log(found) if name in LOGARITHMIC else found


def _scaled(name: str, value: float) -> float:
    """In the scale in which answers are nearly straight."""
    return math.log(value) if name in _BY_FACTOR else float(value)


def _unscaled(name: str, value: float) -> float:
    return math.exp(value) if name in _BY_FACTOR else value
