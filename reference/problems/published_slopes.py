"""Published slopes (P01 to P10): factors of both methods against their own columns, with the bounds we hold them to."""

from __future__ import annotations

from statistics import fmean

from ..benchmarks.slopes import METHODS, answers, published, run_one
from .rows import Row, relative

BOUNDS = {
    # method, particles: largest mean of |error|, largest |error| of one case
    (METHODS[0], 2500): (0.013, 0.033),
    (METHODS[0], 10000): (0.008, 0.03),
    (METHODS[1], 10000): (0.025, 0.04),
}


def run() -> list[Row]:
    """Every case, method and number of particles of `BOUNDS`; then the mean of each group."""
    rows = []
    for (method, particles), (mean_bound, bound) in BOUNDS.items():
        group = []
        for case in sorted(answers()):
            known = published(case, method)
            if known is None:
                continue
            found = run_one(case, method, particles)
            value = float("nan") if found["factor"] is None else found["factor"]
            quantity = f"{method}, {particles} particles"
            group.append(relative(case, quantity, value, known[0], bound, found["seconds"]))
        mean = fmean(abs(row.error) for row in group)
        seconds = fmean(row.seconds for row in group)
        rows += [
            *group,
            Row("mean of |error|", f"{method}, {particles} particles", mean, 0.0, mean, mean_bound, seconds),
        ]
    return rows
