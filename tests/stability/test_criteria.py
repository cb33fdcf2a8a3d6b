"""Verdicts on histories whose outcome is plain."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.stability.criteria import Criteria

RULES = Criteria()
SETTLEMENT = 0.01
STEPS = 50 * 100


def history(ratio, displacement, *, batches=100):
    """One entry per batch from functions of the share of the step limit (0 to 1)."""
    share = (np.arange(batches) + 1) / 100
    return [(int(50 * (k + 1)), float(ratio(s)), float(displacement(s))) for k, s in enumerate(share)]


def judge(entries, moving_share=1.0):
    """The first verdict on a growing history, as the search meets it."""
    for k in range(1, len(entries) + 1):
        answer = RULES.judge(entries[:k], SETTLEMENT, STEPS, moving_share)
        if answer is not None:
            return answer, k
    return None, len(entries)


def test_ground_at_rest_is_stable():
    entries = history(lambda s: 1e-2 * 10 ** (-8 * s), lambda s: 0.02 * (1 - np.exp(-10 * s)))
    (verdict, why), batches = judge(entries)
    assert verdict == "stable"
    assert "1e-05" in why
    assert batches == 38  # 1e-2 * 10^(-8 s) < 1e-5 for s > 0.375


def test_ground_that_speeds_up_has_failed():
    entries = history(lambda s: 0.01 + 0.1 * s, lambda s: 0.5 * s**2)
    (verdict, why), batches = judge(entries)
    assert verdict == "failed"
    assert "elastic settlements" in why
    assert 0.5 * (batches / 100) ** 2 > RULES.failed_settlements * SETTLEMENT


def test_steady_flow_has_failed():
    (verdict, _), _ = judge(history(lambda s: 1e-2, lambda s: 0.4 * s))
    assert verdict == "failed"


def test_a_long_way_to_rest_is_not_failure():
    """Fifteen settlements, but the unbalanced force fades all the way."""
    (verdict, _), _ = judge(history(lambda s: 1e-1 * 10 ** (-6 * s), lambda s: 0.15 * (1 - np.exp(-6 * s))))
    assert verdict == "stable"


def test_a_long_way_before_the_trial_is_not_failure():
    """Continued from a state fifteen settlements down; what counts is what this trial adds."""
    (verdict, _), batches = judge(
        history(lambda s: 1e-2 * 10 ** (-8 * s), lambda s: 0.15 + 0.005 * (1 - np.exp(-6 * s)))
    )
    assert (verdict, batches) == ("stable", 38)
    (verdict, _), batches = judge(history(lambda s: 1e-2, lambda s: 0.15 + 0.4 * s))
    assert verdict == "failed"
    assert 0.4 * batches / 100 > RULES.own_settlements * SETTLEMENT


def test_slow_growth_at_the_step_limit_is_failure():
    (verdict, why), batches = judge(history(lambda s: 1e-3, lambda s: 0.05 * s))
    assert (verdict, batches) == ("failed", 100)
    assert "still growing" in why


def test_growth_that_fades_is_undecided():
    (verdict, why), batches = judge(history(lambda s: 1e-3, lambda s: 0.05 * (1 - np.exp(-12 * s))))
    assert (verdict, batches) == ("undecided", 100)
    assert "neither" in why


def test_creep_below_notice_is_undecided():
    """Growing, but by less than a fiftieth of the settlement in a quarter of the steps."""
    (verdict, _), _ = judge(history(lambda s: 1e-3, lambda s: 0.0006 * s))
    assert verdict == "undecided"


def test_balance_for_all_practical_purposes_is_stable():
    """Just above the strict limit, at the step limit or a long way down."""
    for way in (0.05, 0.5):
        (verdict, why), _ = judge(history(lambda s: 4e-4, lambda s, way=way: way * s))
        assert verdict == "stable"
        assert "in balance to 0.0005" in why


def test_the_balance_is_that_of_what_moves():
    """The same forces on a hundredth of the section are ten times as much to what moves."""
    entries = history(lambda s: 4e-4, lambda s: 0.5 * s)
    assert judge(entries, moving_share=0.01)[0][0] == "failed"
    assert judge(history(lambda s: 4e-5, lambda s: 0.5 * s), moving_share=0.01)[0][0] == "stable"


def test_no_verdict_before_the_step_limit():
    assert judge(history(lambda s: 1e-3, lambda s: 0.05 * s, batches=99))[0] is None


def test_one_entry_at_the_limit_is_enough():
    verdict, _ = RULES.judge([(STEPS, 1e-3, 0.05)] * 2, SETTLEMENT, STEPS)
    assert verdict == "undecided"


@pytest.mark.parametrize(("particles", "steps"), [(100, 4000), (2500, 15_050), (10_000, 30_050)])
def test_step_limit(particles, steps):
    """300 times the square root of the number of particles, in whole batches, 4000 at least."""
    assert RULES.max_steps(particles) == steps
