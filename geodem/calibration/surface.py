"""A smooth surface through measured points, chosen by the error that it makes at points left out.

Every surface is linear in the measured values: value at x = sum of w_i(x) y_i. So the error at a point left out is
known without fitting again, r_i/(1 - w_i(x_i)) (Allen 1974, Technometrics 16:125-127; for thin plates Craven & Wahba
1979, Numer. Math. 31:377-403), and so is how the noise of the points spreads to other places.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.optimize import nnls
from scipy.special import ndtri, stdtrit

from ..errors import InputError

Floats = NDArray[np.float64]
Weights = Callable[[Floats], Floats]

SMOOTHING = (1e-2, 1e-1, 1.0)
"""Of thin plates, for coordinates from -1 to 1: from nearly through the points to nearly a plane."""

LEAST_FREEDOM = 2.5
"""Points that a surface must have more than it has parameters: without them its error is a guess."""

PARSIMONY = 1.05
"""A simpler surface is taken where its error at points left out is at most this many times the smallest."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A fitted surface.

    Attributes
    ----------
    kind : str
        constant, linear, squares, interactions, quadratic, cubic, or thin plate with its smoothing.
    points : (n, d)
        Where was measured, each coordinate from -1 to 1.
    values : (n,)
        Means over the seeds.
    leave_one_out : float
        Root mean square error at points left out; holds the noise of these points.
    freedom : float
        Points less effective parameters.
    scatter : float
        Standard deviation from one specimen to another.
    common : float
        Standard error that all points share because they were measured on the same few seeds; points left out tell
        nothing of it.
    seeds : float
        Number of these.
    deviation : float
        Of the points about the surface: noise of the means and misfit.
    misfit : float
        What of `deviation` the noise of the means does not explain.
    weights : callable
        Points (m, d) -> (m, n).
    """

    kind: str
    points: Floats
    values: Floats
    leave_one_out: float
    freedom: float
    scatter: float
    common: float
    seeds: float
    deviation: float
    misfit: float
    weights: Weights

    def predict(self, points: Floats) -> tuple[Floats, Floats]:
        """Values (m,) at points (m, d) and their standard deviations, without what is common to all points."""
        weights = self.weights(points)
        spread = (weights**2).sum(axis=1)
        return weights @ self.values, np.sqrt(self.misfit**2 + self.deviation**2 * spread)

    def half_width(self, deviation: float, confidence: float, *, common: bool, tests: int | None) -> float:
        """Half of the interval of a value of that standard deviation.

        Parameters
        ----------
        deviation : float
            Of `predict`.
        confidence : float
        common : bool
            Whether what is common to all points counts.
        tests : int, optional
            Of the mean over so many specimens; without it, over all that there could be.
        """
        level = 0.5 + 0.5 * confidence
        # each part by the quantile of its own freedom: a little too wide where both are alike, never too narrow
        parts = [float(stdtrit(self.freedom, level)) * deviation]
        if common:
            parts.append(float(stdtrit(max(self.seeds - 1.0, 1.0), level)) * self.common)
        if tests is not None:
            # where no point has two specimens, all that they lie off the surface is scatter
            parts.append(float(ndtri(level)) * (self.scatter or self.deviation) / np.sqrt(tests))
        return float(np.linalg.norm(parts))


@dataclass(frozen=True)
class Noise:
    """How specimens of one material differ.

    Attributes
    ----------
    scatter : float
        Standard deviation from one specimen to another.
    own : float
        What of it is a specimen's own, not common to all tests on its seed.
    common : float
        Standard error of what is common to a seed, over the seeds that were used.
    seeds : float
        Their number.
    """

    scatter: float
    own: float
    common: float
    seeds: float


def noise_of(by_point: Sequence[Mapping[int, float]]) -> Noise:
    """Noise from values by seed at each point: an analysis of variance by points and seeds."""
    squares, freedom = 0.0, 0
    away: dict[int, list[float]] = {}
    for values in by_point:
        found = np.array(list(values.values()))
        squares += float(((found - found.mean()) ** 2).sum())
        freedom += len(found) - 1
        if len(found) > 1:
            for seed, value in values.items():
                away.setdefault(seed, []).append(value - float(found.mean()))
    scatter = float(np.sqrt(squares / freedom)) if freedom else 0.0
    shared = [np.array(values) for values in away.values() if len(values) > 2]
    seeds = float(np.mean([len(values) for values in by_point]))
    if len(shared) < 2:
        return Noise(scatter, scatter, 0.0, seeds)
    effects = np.array([values.mean() for values in shared])
    repeats = float(np.mean([len(values) for values in shared]))
    # the mean over `repeats` points of noise of their own would scatter by this much
    variance = max((effects.var(ddof=1) - scatter**2 / repeats) / (1.0 - 1.0 / repeats), 0.0)
    own = float(np.sqrt(max(scatter**2 - variance, 0.0)))
    return Noise(scatter, own, float(np.sqrt(variance / len(shared))), float(len(shared)))


def nearest_in_hull(points: Floats, point: Floats) -> Floats:
    """The nearest point (d,) of the convex hull of `points` (n, d).

    Non-negative weights of sum 1 by non-negative least squares, the sum held by a heavy last row.
    """
    heavy = 1e3
    matrix = np.vstack([points.T, np.full(len(points), heavy)])
    weights, _ = nnls(matrix, np.append(point, heavy))
    return np.asarray(points.T @ (weights / weights.sum()))


def fit_surface(points: Floats, values: Floats, counts: Floats, noise: Noise, *, what: str) -> Surface:
    """The surface with the smallest error at points left out, or a simpler one that is hardly worse.

    Parameters
    ----------
    points : (n, d)
        Distinct, each coordinate from -1 to 1.
    values : (n,)
        Means over seeds.
    counts : (n,)
        Seeds of each.
    noise : Noise
    what : str
        For the message.

    Raises
    ------
    InputError
        Fewer than four points.
    """
    if len(points) < 4:
        remedy = "Measure four points at least, twenty for a map"
        raise InputError(f"map, {what}", f"{len(points)} points do not tell a surface", remedy)
    of_means = noise.own * float(np.sqrt(np.mean(1.0 / counts)))
    found = [
        _surface(kind, points, values, weights, noise, of_means) for kind, weights in _candidates(points)
    ]
    usable = [surface for surface in found if surface.freedom >= LEAST_FREEDOM]
    best = min(surface.leave_one_out for surface in usable)
    return next(surface for surface in usable if surface.leave_one_out <= PARSIMONY * best)


def _surface(
    kind: str, points: Floats, values: Floats, weights: Weights, noise: Noise, of_means: float
) -> Surface:
    smoother = weights(points)
    own = np.clip(np.diag(smoother), 0.0, 1.0 - 1e-9)
    left_out = (values - smoother @ values) / (1.0 - own)
    # the expectation of e^2 (1 - w) is the variance about the surface, exactly for polynomials
    deviation = float(np.sqrt(np.mean(left_out**2 * (1.0 - own))))
    return Surface(
        kind=kind,
        points=points,
        values=values,
        leave_one_out=float(np.sqrt(np.mean(left_out**2))),
        freedom=len(points) - float(own.sum()),
        scatter=noise.scatter,
        common=noise.common,
        seeds=noise.seeds,
        # the noise of means is known from all points, so a lucky fit does not lower it
        deviation=max(deviation, of_means),
        misfit=float(np.sqrt(max(deviation**2 - of_means**2, 0.0))),
        weights=weights,
    )


def _candidates(points: Floats) -> Iterator[tuple[str, Weights]]:
    """Surfaces from the simplest on: polynomials, then thin plates from stiff to soft."""
    dimensions = points.shape[1]
    powers = [(0,) * dimensions]
    yield "constant", _polynomial(points, powers)
    single = [tuple(int(i == j) for j in range(dimensions)) for i in range(dimensions)]
    squares = [tuple(2 * exponent for exponent in one) for one in single]
    pairs = [
        tuple(a + b for a, b in zip(single[i], single[j], strict=True))
        for i in range(dimensions)
        for j in range(i + 1, dimensions)
    ]
    linear = [*powers, *single]
    seen = [powers]
    for kind, terms in (
        ("linear", linear),
        ("squares", [*linear, *squares]),
        ("interactions", [*linear, *pairs]),
        ("quadratic", [*linear, *pairs, *squares]),
        ("cubic", [*linear, *squares, (3,)] if dimensions == 1 else linear),
    ):
        told = _told_apart(points, terms)
        if told not in seen and len(told) < len(points):
            seen.append(told)
            yield kind, _polynomial(points, told)
    if linear in seen:
        for smoothing in sorted(SMOOTHING, reverse=True):
            yield f"thin plate {smoothing:g}", _thin_plate(points, smoothing)


def _told_apart(points: Floats, terms: list[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """The terms, one after the other, that the points tell apart from those before."""
    kept: list[tuple[int, ...]] = []
    for term in terms:
        columns = _columns(points, [*kept, term])
        if np.linalg.matrix_rank(columns, tol=1e-6 * np.sqrt(len(points))) == columns.shape[1]:
            kept.append(term)
    return kept


def _columns(points: Floats, powers: list[tuple[int, ...]]) -> Floats:
    return np.stack([np.prod(points ** np.array(power), axis=1) for power in powers], axis=1)


def _polynomial(points: Floats, powers: list[tuple[int, ...]]) -> Weights:
    inverse = np.linalg.pinv(_columns(points, powers))
    return lambda where: np.asarray(_columns(where, powers) @ inverse)


def _thin_plate(points: Floats, smoothing: float) -> Weights:
    # the interpolant of unit values is the table of weights
    plate = RBFInterpolator(
        points, np.eye(len(points)), smoothing=smoothing, kernel="thin_plate_spline", degree=1
    )
    return lambda where: np.asarray(plate(where))
