"""The time left of a search: what it is made of, and how it changes while a search goes on."""

from __future__ import annotations

from math import inf

import pytest

from geodem.stability.bracket import Trial
from geodem.stability.criteria import Criteria
from geodem.stability.forecast import Planned, expected_steps, halvings, halvings_left, pace, work_left


def trial(factor, verdict, steps=1000, seconds=2.0):
    return Trial(factor, verdict, "", steps, 0.0, 0.0, 3000, "fine", seconds)


def test_trials_near_the_critical_factor_take_longer_up_to_their_limit():
    far, near, at = (expected_steps(d, 3000) for d in (0.3, 0.01, 0.0))
    assert far < near < at == Criteria().max_steps(3000)
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
    left = [work_left(done[:k], 0, 3000, **options) for k in range(2, 5)]
    assert left == sorted(left, reverse=True)
    assert work_left(done, 900, 3000, **{**options, "running": False}) == 0.0
    # what has run longer than expected needs more still
    assert work_left(done[:4], 50_000, 3000, **options) > work_left(done[:4], 500, 3000, **options)


def test_the_pace_is_that_of_all_that_was_done():
    assert pace([], 0.0, 0, 3000) == inf
    assert pace([trial(1.0, "stable")] * 3, 4.0, 2000, 3000) == pytest.approx(10.0 / (5000 * 3000))


def test_the_work_of_a_search_grows_with_particles_and_steps():
    """Particles to the power 3/2: as many more in each step, and the square root of that more steps."""
    assert Planned(12_000, 0.01, 0.3).work() == pytest.approx(8.0 * Planned(3000, 0.01, 0.3).work())
