"""Distributions of particle sizes: equal, uniform, normal, lognormal, and a grading curve.

Radii are drawn one from each of as many equal shares of the number of particles, so that even a few hundred have the
moments of their distribution nearly to the last digit, and any seed the same solid fraction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.builders.packings import volumes
from geodem.errors import InputError

Floats = NDArray[np.float64]

STRATA = 20_000
"""Equal shares over which moments are summed."""


@dataclass(frozen=True)
class Sizes:
    """A distribution of radii.

    Attributes
    ----------
    name : str
    quantile : function of an array
        Radius [m] below which a given share of the number of particles lies, 0 to 1.
    dimension : int or None
        Of a grading, which is by area or by volume; None where it does not matter.
    """

    name: str
    quantile: Callable[[Floats], Floats]
    dimension: int | None = None

    def draw(self, count: int, rng: np.random.Generator) -> Floats:
        """`count` radii (n,) [m] in random order."""
        share = (np.arange(count) + rng.random(count)) / count
        return np.asarray(rng.permutation(self.quantile(share)), dtype=np.float64)

    def mean_volume(self, dimension: int) -> float:
        """Mean area [m2] or volume [m3] of the particles."""
        share = (np.arange(STRATA) + 0.5) / STRATA
        return float(volumes(self.quantile(share), dimension).mean())

    @property
    def largest(self) -> float:
        """Largest radius [m]."""
        return float(self.quantile(np.ones(1))[0])


def equal(radius: float) -> Sizes:
    """All of one radius [m]; raises InputError for one that is not positive."""
    _refuse("equal sizes", radius=radius)
    return Sizes("equal", lambda share: np.full(len(share), float(radius)))


def uniform(smallest: float, largest: float) -> Sizes:
    """All radii between two [m] equally frequent; raises InputError for radii out of order or not positive."""
    _refuse("uniform sizes", smallest=smallest, largest=largest)
    _refuse_order("uniform sizes", smallest, largest)
    return Sizes("uniform", lambda share: smallest + (largest - smallest) * share)


def normal(mean: float, deviation: float, *, smallest: float, largest: float) -> Sizes:
    """Normal distribution of radii [m], cut off at the smallest and largest.

    Raises InputError for radii out of order, not positive, or a distribution with next to nothing between them.
    """
    _refuse("normal sizes", mean=mean, deviation=deviation, smallest=smallest, largest=largest)
    _refuse_order("normal sizes", smallest, largest)
    ends = ((smallest - mean) / deviation, (largest - mean) / deviation)
    score = _score_between("normal sizes", *ends)
    return Sizes("normal", lambda share: np.clip(mean + deviation * score(share), smallest, largest))


def lognormal(median: float, spread: float, *, smallest: float, largest: float) -> Sizes:
    """Radii whose logarithm is normally distributed, cut off at the smallest and largest.

    Parameters
    ----------
    median : float [m]
    spread : float
        Standard deviation of ln(radius) [-].
    smallest, largest : float [m]

    Raises
    ------
    InputError
        Radii out of order, not positive, or a distribution with next to nothing between them.
    """
    _refuse("lognormal sizes", median=median, spread=spread, smallest=smallest, largest=largest)
    _refuse_order("lognormal sizes", smallest, largest)
    ends = (np.log(smallest / median) / spread, np.log(largest / median) / spread)
    score = _score_between("lognormal sizes", *ends)
    return Sizes(
        "lognormal", lambda share: np.clip(median * np.exp(spread * score(share)), smallest, largest)
    )


def graded(curve: Sequence[tuple[float, float]], dimension: int) -> Sizes:
    """A sieve curve.

    Parameters
    ----------
    curve : sequence of (float, float)
        (radius [m], share of the area or volume of smaller particles [-]), from share 0 to 1, straight in between. Two
        equal radii: that share is of that one size.
    dimension : int
        2: shares of area, 3: of volume.

    Raises
    ------
    InputError
        Fewer than two points, radii not positive, a curve that falls or does not go from 0 to 1.
    """
    place = "grading"
    if dimension not in (2, 3):
        raise InputError(place, "shares are of area or of volume", "Give dimension 2 or 3.", value=dimension)
    try:
        points = np.asarray(curve, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise InputError(
            place, "these are not at least two pairs", "Give (radius, share) pairs.", value=curve
        )
    if not (np.isfinite(points).all() and (points[:, 0] > 0.0).all()):
        raise InputError(place, "not all radii are positive", "Give radii in m.", value=curve)
    if (np.diff(points, axis=0) < 0.0).any() or points[0, 1] != 0.0 or points[-1, 1] != 1.0:
        raise InputError(
            place, "radii and shares do not grow, or shares do not go from 0 to 1",
            "Give for instance [(0.1, 0.0), (0.2, 0.4), (0.5, 1.0)].", value=curve,
        )  # fmt: skip
    low, high = points[:-1, 0], points[1:, 0]
    # particles per share: the mean of 1/r^d over radii that are equally frequent by area or volume
    mean = 1.0 / (low * high) if dimension == 2 else 0.5 * (low + high) / (low * high) ** 2
    numbers = np.diff(points[:, 1]) * mean
    ends = np.concatenate([[0.0], np.cumsum(numbers) / numbers.sum()])
    ends[-1] = 1.0
    power = 1.0 - dimension

    def quantile(share: Floats) -> Floats:
        piece = np.clip(np.searchsorted(ends, share, side="right") - 1, 0, len(low) - 1)
        # pieces without particles have no width to divide by
        width = np.maximum(ends[piece + 1] - ends[piece], 1e-300)
        within = np.clip((share - ends[piece]) / width, 0.0, 1.0)
        a, b = low[piece] ** power, high[piece] ** power
        return np.asarray(np.clip((a + (b - a) * within) ** (1.0 / power), low[piece], high[piece]))

    return Sizes("graded", quantile, dimension)


def _score_between(place: str, low: float, high: float) -> Callable[[Floats], Floats]:
    """Quantile of a standard normal distribution that is cut off on both sides."""
    from scipy.special import ndtr, ndtri

    # in the lower tail, where small probabilities keep their digits
    mirrored = low > 0.0
    if mirrored:
        low, high = -high, -low
    begin, room = float(ndtr(low)), float(ndtr(high) - ndtr(low))
    if room < 1e-6:
        raise InputError(
            place, "next to none of the distribution lies between the smallest and the largest radius",
            "Move them towards its middle.",
        )  # fmt: skip

    def score(share: Floats) -> Floats:
        return np.asarray(-ndtri(begin + room * (1.0 - share)) if mirrored else ndtri(begin + room * share))

    return score


def _refuse(place: str, **values: float) -> None:
    for name, value in values.items():
        try:
            good = bool(np.isfinite(value) and value > 0.0)
        except TypeError:
            good = False
        if not good:
            raise InputError(f"{place}, {name}", "this is not a positive number", "Give m.", value=value)


def _refuse_order(place: str, smallest: float, largest: float) -> None:
    if not smallest <= largest:
        raise InputError(
            place, "the smallest radius is above the largest", "Exchange them.", value=(smallest, largest)
        )
