"""Published slopes, a few of them and small; ``python -m reference run slopes`` holds all of them to their bounds.

The bounds here are those of 2,500 particles: no case above 3.3 % in strength reduction. Gravity increase needs
more particles than that (it is held to 4 % at 10,000), so its row here has 6 %. Expected values: answers.toml,
each with its source.
"""

from __future__ import annotations

import json
from pathlib import Path
from statistics import fmean

import pytest

from reference.benchmarks.slopes import published, run_one

STORED = Path(__file__).parents[2] / "reference" / "results" / "slopes.json"
NO_TENSION = ("P05-0-crack", "P05-25-crack")


@pytest.mark.parametrize("case", ["P02", "P04-20", "P06", "P07", "P09", "P10e"])
def test_strength_reduction_meets_the_published_factor(case):
    row = run_one(case, "strength-reduction", 2500)
    assert row["undecided"] == []
    assert abs(row["error_percent"]) <= 3.3


def test_gravity_increase_meets_its_own_column_and_not_the_factor_of_safety():
    row = run_one("P10a", "gravity-increase", 2500)
    assert abs(row["error_percent"]) <= 6.0
    known = published("P10a", "strength-reduction")
    assert known is not None
    assert row["factor"] > 1.5 * known[0]


def test_without_friction_both_methods_give_the_same_factor():
    # c/F against gravity times F is the same problem when phi = 0
    by_strength = run_one("P10f", "strength-reduction", 1500)
    by_gravity = run_one("P10f", "gravity-increase", 1500)
    assert by_gravity["factor"] == pytest.approx(by_strength["factor"], rel=0.01)


def stored_errors(method: str, asked: int) -> dict[str, float]:
    rows = json.loads(STORED.read_text())["rows"]
    return {
        row["case"]: abs(row["error_percent"])
        for row in rows
        if (row["method"], row["asked"], row["dilation"]) == (method, asked, "associated")
    }


@pytest.mark.parametrize(
    ("method", "asked", "mean", "worst"),
    [
        ("strength-reduction", 2500, 1.3, 3.3),
        ("strength-reduction", 10000, 0.8, 3.0),
        ("gravity-increase", 10000, 2.5, 4.0),
    ],
)
def test_stored_benchmark_keeps_its_bounds(method, asked, mean, worst):
    """The mean over all cases; the largest over those with the full cone.

    The two cuts without tension fail by a slab as thin as the particles allow and miss the bound of a single case:
    they are listed with the others in docs/verification.md.
    """
    errors = stored_errors(method, asked)
    assert len(errors) >= 18
    assert fmean(errors.values()) <= mean
    assert max(error for case, error in errors.items() if case not in NO_TENSION) <= worst
