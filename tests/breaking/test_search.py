"""Searches on a hanging chain, whose factors are known: strength over the weight that its top bond bears."""

from __future__ import annotations

from dataclasses import replace

import pytest

from geodem.breaking.criteria import Criteria
from geodem.breaking.search import METHODS, Search, SearchPlan
from geodem.breaking.stages import Settle
from geodem.breaking.watching import Silent
from geodem.errors import StoppedError
from tests.breaking.chains import FACTOR, LINKS, site
from tests.breaking.test_stages import PATIENT, Stopping

CRITERIA = Criteria(rest=1e-5, steps_per_length=3000.0, ramp_per_length=300.0)


@pytest.fixture(scope="module")
def base():
    found = site()
    Settle("settle", criteria=PATIENT).carry_out(found, Silent())
    return found.tree()


@pytest.mark.parametrize("kind", METHODS)
def test_the_bracket_holds_the_factor_of_a_hanging_chain(base, kind):
    search = Search(SearchPlan(kind, tolerance=0.02, step=0.5, criteria=CRITERIA), base)
    search.run(Silent())
    found = search.bracket
    assert found.stable < FACTOR < found.failed
    assert found.width <= 0.02
    assert not found.undecided
    failed = [t for t in search.trials if t.verdict == "failed"]
    assert all("diameters" in t.criterion or "still moving" in t.criterion for t in failed)


def test_what_goes_on_is_what_was_asked_for(base):
    for goes_on, cracks in (("start", 0), ("stable", 0), ("failed", 1)):
        plan = SearchPlan("gravity-increase", tolerance=0.3, criteria=CRITERIA, goes_on=goes_on)
        search = Search(plan, base)
        site_after = search.run(Silent())
        assert site_after.cracks().count == cracks
        wanted = {"start": 1.0, "stable": search.bracket.stable, "failed": search.bracket.failed}
        assert site_after.gravity_factor == pytest.approx(wanted[goes_on])
        assert len(site_after.history) > len(search.rows) > 0


def test_a_stopped_search_goes_on_to_the_same_bits(base):
    plan = SearchPlan("strength-reduction", tolerance=0.1, criteria=CRITERIA)
    whole = Search(plan, base)
    whole.run(Silent())
    kept = []

    class After(Silent):
        def stop_asked(self):
            return len(kept) == 2

    search = Search(plan, base)
    with pytest.raises(StoppedError):
        search.run(After(), lambda s: kept.append(s.tree()))
    again = Search(plan, base)
    again.take_up(kept[-1])
    again.run(Silent())
    assert [t.factor for t in again.trials] == [t.factor for t in whole.trials]
    assert [t.history for t in again.trials] == [t.history for t in whole.trials]
    assert again.bracket == whole.bracket


def test_a_stop_within_a_trial_loses_that_trial_alone(base):
    search = Search(SearchPlan("gravity-increase", criteria=CRITERIA), base)
    with pytest.raises(StoppedError):
        search.run(Stopping())
    assert search.trials == []
    assert len(base["origin"]) == LINKS


def test_a_trial_of_which_nobody_can_tell_is_given_more_time(base):
    def first_trial(criteria):
        plan = SearchPlan("gravity-increase", start=0.9 * FACTOR, tolerance=1.0, criteria=criteria)
        search = Search(plan, base)
        search.run(Silent())
        return search.trials[0]

    patient = first_trial(CRITERIA)
    assert patient.verdict == "stable"
    hasty = replace(CRITERIA, balanced=0.0, growing=10.0, steps_per_length=patient.steps / 2.5 / LINKS**0.5)
    given_up = first_trial(replace(hasty, longer=0))
    assert given_up.verdict == "undecided"
    decided = first_trial(hasty)
    assert (decided.verdict, decided.steps) == ("stable", patient.steps)
    assert decided.steps > given_up.steps
