"""How many steps a plan of digging still takes: increments counted by hand, and recorded tunnels; no clock."""

from __future__ import annotations

import pytest

from geodem.run_progress import Work
from geodem.tunnelling.digging import Digging
from geodem.tunnelling.forecast import increments_of_plan, steps_left
from geodem.tunnelling.plan import DepthStress, Opening, Plan, Stage
from tests.small_cases import forecast_error
from tests.tunnelling.tunnels import level_ground

# steps of the increments of `geodem run --quick` on the case of `geodem new tunnel`, 1500 particles
RECORDED = [200, 200, 200, 200, 300, 350, 350, 350, 350, 450]


def test_increments_are_those_that_are_carried_out():
    ground, plan = level_ground(particles=300)
    digging = Digging(ground, plan, increments=4)
    digging.run()
    assert len(digging.progress.taken) == sum(increments_of_plan(plan, 4)) == 2
    assert sum(digging.progress.taken) == digging.progress.steps


def test_increments_of_a_plan_by_hand():
    openings = (Opening("heading", None, (0.0, 0.0)), Opening("bench", None, (0.0, -2.0)))
    stages = (
        Stage("heading", excavate=("heading",), relax=0.4),  # 0.4 of ten
        Stage("support", install=("shell",)),  # nothing moves
        Stage("bench", excavate=("bench",), opening="bench", relax=0.25),  # 0.25 of ten, rounded up
        Stage("far", relax=1.0),  # 0.75 of the bench's are left
        Stage("pressed", opening="heading", pressure=1e5),  # as half of all
    )
    assert increments_of_plan(Plan(openings, DepthStress(0.5), stages), 10) == [4, 0, 3, 8, 5]


def test_steps_left_of_a_recorded_tunnel_are_within_a_fifth():
    done = [sum(RECORDED[:k]) for k in range(len(RECORDED) + 1)]
    left = [steps_left(RECORDED[:k], len(RECORDED), 1500) for k in range(len(RECORDED) + 1)]
    assert forecast_error([Work(*both) for both in zip(done, left, strict=True)], after=0.0) < 0.2
    assert left[-1] == 0.0
    assert steps_left([], 10, 1500) == pytest.approx(10 * 5.0 * 1500**0.5 * 1.55)
