"""Chaotic scenes by their statistics: whether two codes differ by more than chance lets three seeds differ.

No number here can be made to fit by a wide bound: it follows from the seeds. `told_apart` shows with a law that is made
another that the comparison sees what it should.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np
from scipy import stats

from ..posed import Floats
from .comparison import Row

LEVEL = 0.99
"""Means of the same kind lie within their bound in so many of all cases [-]."""

Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Compared:
    """Two means of several seeds.

    Attributes
    ----------
    means, scatters : (float, float)
        Of each code; the scatter is the standard deviation over its seeds.
    difference : float
        Of the means, over the larger of their sizes [-].
    bound : float
        What chance makes of it in `LEVEL` of all cases, by Student's t with the scatter of both codes [-].
    """

    means: tuple[float, float]
    scatters: tuple[float, float]
    difference: float
    bound: float

    @property
    def alike(self) -> bool:
        """No farther apart than by chance."""
        return self.difference <= self.bound

    @property
    def over_scatter(self) -> float:
        """Difference of the means over the mean scatter of the seeds [-]."""
        scatter = math.sqrt(0.5 * (self.scatters[0] ** 2 + self.scatters[1] ** 2))
        return abs(self.means[0] - self.means[1]) / scatter if scatter > 0.0 else math.inf


def means_of(ours: Sequence[float], theirs: Sequence[float]) -> Compared:
    """Student's two-sample test on the means of the seeds; both codes need two seeds or more."""
    one, other = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
    freedoms = len(one) + len(other) - 2
    if min(len(one), len(other)) < 2:
        raise ValueError("a scatter needs two seeds or more in both codes")
    spread = float(((one - one.mean()) ** 2).sum() + ((other - other.mean()) ** 2).sum()) / freedoms
    error = math.sqrt(spread * (1.0 / len(one) + 1.0 / len(other)))
    size = max(abs(one.mean()), abs(other.mean()))
    factor = float(stats.t.ppf(0.5 + 0.5 * LEVEL, freedoms))
    return Compared(
        (float(one.mean()), float(other.mean())),
        (float(one.std(ddof=1)), float(other.std(ddof=1))),
        float(abs(one.mean() - other.mean()) / size),
        factor * error / size,
    )


def apart(
    ours: Sequence[Floats], theirs: Sequence[Floats], distance: Callable[[Floats, Floats], float]
) -> tuple[float, float]:
    """Mean distance of runs of different codes, and the largest of runs of one code with different seeds."""
    between = [distance(one, other) for one, other in product(ours, theirs)]
    within = [distance(one, other) for runs in (ours, theirs) for one, other in combinations(runs, 2)]
    return float(np.mean(between)), float(np.max(within))


def kolmogorov_smirnov(one: Floats, other: Floats) -> float:
    """Largest difference of two cumulative distributions [-]."""
    return float(stats.ks_2samp(one, other).statistic)


def rows_of_means(about: Mapping[str, Any], ours: Sequence[Numbers], theirs: Sequence[Numbers]) -> list[Row]:
    """A row for every number that the runs tell; `about`: its other fields, with the first of its name."""
    rows = []
    for name in ours[0]:
        found = means_of([run[name] for run in ours], [run[name] for run in theirs])
        said = " and ".join(
            f"{mean:.4g} ± {scatter:.1g}" for mean, scatter in zip(found.means, found.scatters, strict=True)
        )
        rows.append(
            Row(
                **{**about, "scene": f"{about['scene']}: {name}"},
                quantity=f"geodem's and the other's mean and scatter of {len(ours)} seeds {said}, "
                f"{found.over_scatter:.1f} scatters apart; means differ by",
                difference=found.difference,
                bound=found.bound,
            )
        )
    return rows


def row_of_distance(
    about: Mapping[str, Any], name: str, ours: Sequence[Floats], theirs: Sequence[Floats],
    distance: Callable[[Floats, Floats], float],
) -> Row:  # fmt: skip
    """Two codes may be no farther apart than two seeds of one code are."""
    between, within = apart(ours, theirs, distance)
    return Row(
        **{**about, "scene": f"{about['scene']}: {name}"},
        quantity="mean between the codes; the bound is the largest between seeds of one code:",
        difference=between,
        bound=within,
    )


def told_apart(
    about: Mapping[str, Any], change: str, ours: Sequence[Numbers], changed: Sequence[Numbers]
) -> Row:
    """geodem against geodem with something changed: that must be seen in one number at least."""
    found = {name: means_of([run[name] for run in ours], [run[name] for run in changed]) for name in ours[0]}
    # not "unlike": what is no number was not seen
    seen = [name for name, one in found.items() if one.difference > one.bound]
    return Row(
        **{**about, "scene": f"{about['scene']}: geodem against geodem with {change}, which must be seen"},
        quantity=f"of {len(found)} numbers, {len(seen)} differ by more than their bound"
        + (f" ({', '.join(seen)})" if seen else "")
        + "; lacks to one",
        difference=0.0 if seen else 1.0,
        bound=0.0,
    )
