"""How much is left of stages and searches: recorded runs, told look by look; no clock.

Recorded are `geodem run --quick` on the case of `geodem new breaking` and on workflows/rock_slope: of every stage and
trial the unbalanced force ratio at every look, a hundred steps apart, and the trials with their verdicts.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from geodem.breaking.criteria import Criteria
from geodem.breaking.forecast import Forecast
from geodem.breaking.search import GRAVITY, STRENGTH, Search, SearchPlan
from geodem.breaking.stages import Excavate, FindFactor, RemoveWalls, Run, Settle
from geodem.stability.bracket import Trial
from tests.small_cases import forecast_error

RECORDED = json.loads((Path(__file__).parent / "recorded_runs.json").read_text())


def find(kind):
    return FindFactor("factor", SearchPlan(kind, tolerance=0.2))


STAGES = {
    "breaking": [Settle("settle"), Excavate("cut", lambda site: site), find(GRAVITY.kind), Run("slide", 4.0)],
    "rock_slope": [Settle("settle"), find(GRAVITY.kind), find(STRENGTH.kind)],
}


def works_of_recorded(name):
    """What would have been told at every look of a recorded run."""
    run, stages = RECORDED[name], STAGES[name]
    forecast = Forecast(stages, particles=run["particles"], dimension=2, time_step=run["time_step"])
    trials = iter(row for _, rows in run["trials"] for row in rows)
    number, works = -1, []
    for stage, factor, ratios in run["parts"]:
        if stage != number:
            number = stage
            search = Search(stages[stage].plan, {}) if factor is not None else None
            forecast.begin(stage, search)
        for ratio in ratios:
            forecast.saw(100.0, ratio)
            works.append(forecast.work())
        if factor is not None:
            tried, verdict, steps = next(trials)
            assert tried == factor
            search.trials.append(Trial(factor, verdict, "", steps, 0.0, 0.0, run["particles"], "fine"))
    return works


@pytest.mark.parametrize("name", STAGES)
def test_the_work_left_is_told_within_a_fifth_of_all(name):
    works = works_of_recorded(name)
    assert forecast_error(works) < 0.2
    whole = works[-1].done
    assert all(work.done + work.most >= whole for work in works if not math.isnan(work.most))


def test_stages_of_motion_and_removal_are_known_before_they_begin():
    forecast = Forecast(
        [RemoveWalls("open", ("left",)), Run("fall", 2.0)], particles=900, dimension=2, time_step=1e-3
    )
    assert forecast.work() == pytest.approx((0.0, 2000.0, math.nan), nan_ok=True)
    forecast.begin(1)
    forecast.saw(500.0, 0.1)
    assert forecast.work() == pytest.approx((500.0, 1500.0, math.nan), nan_ok=True)


def test_what_comes_to_rest_is_followed_by_its_unbalanced_force():
    """A tenth of it in 500 steps: from 1 to the 1e-4 of rest in 2000 after the ramp; the limit is 6000."""
    forecast = Forecast([Settle("settle")], particles=900, dimension=2, time_step=1e-3)
    ramp, limit = Criteria().ramp_steps(900, 2), Criteria().most_steps(900, 2)
    forecast.begin(0)
    for _ in range(ramp // 100):
        forecast.saw(100.0, 1.0)
    for k in range(1, 16):
        forecast.saw(100.0, 10.0 ** (-100 * k / 500.0))
    found = forecast.work()
    assert found.done == ramp + 1500
    # the median of the last five looks lies two looks behind
    assert found.left == pytest.approx(500.0 + 200.0)
    assert found.most == limit - 1500
