"""The time left of a search: what it is made of, and how it changes while a search goes on."""

from __future__ import annotations

import math
from math import inf

import numpy as np
import pytest

from geodem.stability.bracket import Trial
from geodem.stability.criteria import Criteria
from geodem.stability.forecast import (
    Planned,
    expected_steps,
    halvings,
    halvings_left,
    mean_steps,
    pace,
    trial_left,
    work_left,
)


def trial(factor, verdict, steps=1000, seconds=2.0):
    return Trial(factor, verdict, "", steps, 0.0, 0.0, 3000, "fine", seconds)


def test_trials_near_the_critical_factor_take_longer_up_to_their_limit():
    far, near, at = (expected_steps(d, 3000) for d in (0.3, 0.01, 0.0))
    assert far < near < at == pytest.approx(Criteria().max_steps(3000), rel=0.01)
    assert expected_steps(0.01, 3000, failed=True) == pytest.approx(1650.0)
    assert expected_steps(0.01, 3000, failed=False) == pytest.approx(1750.0)
    # waves cross four times as many particles in twice as many steps
    assert expected_steps(0.01, 12_000) == pytest.approx(2.0 * near)


@pytest.mark.parametrize(
    ("width", "tolerance", "count"), [(0.1, 0.01, 4), (0.01, 0.01, 0), (0.08, 0.01, 3), (0.0, 0.01, 0)]
)
def test_a_bracket_is_halved_until_it_is_as_narrow_as_asked_for(width, tolerance, count):
    assert halvings_left(width, tolerance) == count
    assert (halvings(width, tolerance, 3000) > 0.0) == (count > 0)


def test_work_left_falls_with_every_trial_and_ends_at_nothing():
    done = [
        trial(1.0, "stable"),
        trial(1.3, "failed"),
        trial(1.15, "stable"),
        trial(1.225, "stable"),
        trial(1.2625, "failed"),
    ]
    options = {"tolerance": 0.04, "step": 0.3, "running": True}
    works = [work_left(done[:k], 0, 3000, **options) for k in range(2, 5)]
    left = [work.left for work in works]
    assert left == sorted(left, reverse=True)
    assert all(work.most > work.left for work in works)
    assert work_left(done, 900, 3000, **{**options, "running": False}).left == 0.0
    # one trial is left in each case: what has run for long is near to the critical factor, and needs more still
    assert work_left(done[:4], 4000, 3000, **options).left > work_left(done[:4], 500, 3000, **options).left
    # less where it says itself that it is at its end, the more so the longer it has gone on
    for steps, most in ((500, 1.0), (4000, 0.25)):
        told = work_left(done[:4], steps, 3000, seen=50.0, **options).left
        assert 50.0 * 3000 < told < most * work_left(done[:4], steps, 3000, **options).left


def test_a_trial_is_expected_to_take_the_mean_over_where_the_critical_factor_may_be():
    """Against the mean of `expected_steps` over many distances; and once it has lasted, of those that last as long."""
    distances = (np.arange(200_000) + 0.5) / 200_000 * 0.01
    both = [np.array([expected_steps(d, 3000, failed) for d in distances]) for failed in (True, False)]
    assert mean_steps(0.01, 3000) == pytest.approx(np.concatenate(both).mean(), rel=1e-3)
    for gone in (1000.0, 4000.0):
        lasting = np.concatenate([steps[steps > gone] for steps in both])
        assert mean_steps(0.01, 3000, gone) == pytest.approx(lasting.mean(), rel=1e-2)


def test_a_trial_says_itself_how_long_it_still_takes():
    criteria = Criteria()
    # a tenth of the unbalanced force in 1000 steps, from 0.01; rest is at 1e-5: after 3000 steps
    falling = [(50 * k, 10.0 ** (-2.0 - 50 * k / 1000.0), 0.001) for k in range(1, 41)]
    assert trial_left(falling, 1.0, 10_000.0, criteria) == pytest.approx(1000.0)
    # an elastic settlement in 400 steps; failed after ten
    moving = [(50 * k, 1e-3, 50 * k / 400.0) for k in range(1, 41)]
    assert trial_left(moving, 1.0, 10_000.0, criteria) == pytest.approx(2000.0)
    assert trial_left(moving, 1.0, 2500.0, criteria) == pytest.approx(500.0), "the step limit comes first"
    assert math.isnan(trial_left(moving[:4], 1.0, 10_000.0, criteria))


def test_the_pace_is_that_of_all_that_was_done():
    assert pace([], 0.0, 0, 3000) == inf
    assert pace([trial(1.0, "stable")] * 3, 4.0, 2000, 3000) == pytest.approx(10.0 / (5000 * 3000))


def test_the_work_of_a_search_grows_with_particles_and_steps():
    """Particles to the power 3/2: as many more in each step, and the square root of that more steps."""
    assert Planned(12_000, 0.01, 0.3).work().left == pytest.approx(8.0 * Planned(3000, 0.01, 0.3).work().left)
