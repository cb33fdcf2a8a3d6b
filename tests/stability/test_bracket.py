"""The search for a factor against grounds that are formulas: they fail at a known factor, or behave oddly."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geodem.stability.bracket import Trial, bracket, next_factor
from geodem.stability.forecast import halvings_left

LIMITS = (0.02, 200.0)


def trial(factor, verdict):
    return Trial(factor, verdict, "", 100, 0.0, 0.0, 1000, "fine")


def search(ground, *, start=1.0, step=0.3, tolerance=0.01, limits=LIMITS, most=200):
    """Try factors until the search says that it is done."""
    trials = []
    for _ in range(most):
        factor = next_factor(trials, start=start, step=step, tolerance=tolerance, limits=limits)
        if factor is None:
            return trials
        assert limits[0] <= factor <= limits[1] or not trials
        assert factor not in [t.factor for t in trials], "a factor is tried twice"
        trials.append(trial(factor, ground(factor)))
    raise AssertionError(f"not done after {most} trials")


def fails_at(threshold):
    return lambda factor: "failed" if factor >= threshold else "stable"


thresholds = st.floats(0.03, 150.0)
starts = st.floats(0.1, 20.0)
steps = st.floats(0.02, 0.6)
tolerances = st.floats(0.002, 0.05)


@given(thresholds, starts, steps, tolerances)
def test_finds_the_factor(threshold, start, step, tolerance):
    trials = search(fails_at(threshold), start=start, step=step, tolerance=tolerance)
    found = bracket(trials)
    assert found.stable < threshold <= found.failed
    assert found.width <= tolerance * (1 + 1e-6)
    assert abs(found.value - threshold) <= 0.5 * (found.failed - found.stable) * (1 + 1e-9)
    assert len(trials) < 60


@given(thresholds, starts, tolerances, st.floats(1.001, 1.2))
def test_an_undecided_zone_is_enclosed_and_never_stable(threshold, start, tolerance, ratio):
    """Between `threshold` and `ratio` times it nobody can tell; the bracket keeps that inside, tightly."""

    def ground(factor):
        if factor < threshold:
            return "stable"
        return "failed" if factor >= threshold * ratio else "undecided"

    limits = (LIMITS[0], 400.0)
    trials = search(ground, start=start, tolerance=tolerance, limits=limits)
    found = bracket(trials)
    assert found.stable < threshold
    assert found.failed >= threshold * ratio
    assert all(threshold <= factor < threshold * ratio for factor in found.undecided)
    if found.undecided:
        assert found.undecided[0] - found.stable <= tolerance * found.value * (1 + 1e-6)
        assert found.failed - found.undecided[-1] <= tolerance * found.value * (1 + 1e-6)
    else:
        assert found.width <= tolerance * (1 + 1e-6)


# what a machine with other work takes says nothing of the search
@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(st.sampled_from(["stable", "failed", "undecided"]), min_size=1, max_size=40), starts, tolerances
)
def test_any_answers_end_the_search(answers, start, tolerance):
    """A ground without rhyme or reason: no factor twice, an end, and a bracket in order."""
    given_ = iter(answers)
    trials = search(lambda factor: next(given_, "failed"), start=start, tolerance=tolerance)
    found = bracket(trials)
    failed = [t.factor for t in trials if t.verdict == "failed"]
    if failed:
        assert found.failed == min(failed)
    if found.stable is not None and found.failed is not None:
        assert found.stable < found.failed
        assert all(found.stable < factor < found.failed for factor in found.undecided)


def test_a_stable_factor_above_a_failed_one_does_not_count():
    found = bracket(
        [trial(1.0, "stable"), trial(1.3, "failed"), trial(1.5, "stable"), trial(1.2, "undecided")]
    )
    assert (found.stable, found.failed, found.undecided) == (1.0, 1.3, (1.2,))
    assert found.value == pytest.approx(1.15)
    assert found.width == pytest.approx(0.3 / 1.15)


def test_failure_below_what_was_stable_starts_again_below():
    trials = [trial(1.0, "stable"), trial(1.3, "failed"), trial(0.9, "failed")]
    assert bracket(trials).stable is None
    assert next_factor(trials, start=1.0, step=0.3, tolerance=0.01, limits=LIMITS) < 0.9


@pytest.mark.parametrize(
    ("verdict", "end"), [("stable", LIMITS[1]), ("undecided", LIMITS[1]), ("failed", LIMITS[0])]
)
def test_ground_that_never_changes_its_mind_ends_at_the_limits(verdict, end):
    trials = search(lambda factor: verdict)
    assert trials[-1].factor == end
    found = bracket(trials)
    assert found.value is None
    assert found.width == float("inf")


def test_nothing_tried():
    assert next_factor([], start=1.37, step=0.3, tolerance=0.01, limits=LIMITS) == 1.37
    assert bracket([]).value is None


def test_a_good_start_needs_few_trials():
    """From within 1 % of the answer: two ends and one halving reach half a per cent."""
    assert len(search(fails_at(1.38), start=1.37, step=0.01, tolerance=0.005)) == 3


@given(thresholds, tolerances)
def test_the_expected_number_of_trials_is_about_right(threshold, tolerance):
    trials = search(fails_at(threshold), tolerance=tolerance)
    both = next(k for k in range(len(trials) + 1) if bracket(trials[:k]).value is not None)
    left = halvings_left(bracket(trials[:both]).width, tolerance)
    # the middle that the width is measured by moves by up to a half
    assert abs(left - (len(trials) - both)) <= 2
    assert halvings_left(bracket(trials).width, tolerance) == 0
