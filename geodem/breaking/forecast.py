"""How many steps the stages of breaking ground still take, for the time left that is told.

Ramps and motions have as many steps as they have. When ground comes to rest nobody knows; it is expected to take as
long as it took in the stages and trials before, and while it comes to rest, as long as the unbalanced force needs to
fall on at its pace. How many trials a search takes depends on where the factor is. So a number that is expected is told
beside one that cannot be exceeded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..run_progress import Work
from ..stability.bracket import bracket
from ..stability.forecast import halvings_left
from .criteria import Criteria
from .search import Search, SearchPlan
from .stages import Excavate, FindFactor, MoveWall, RemoveWalls, Run, Settle, Stage

RESTS, FAILS = 0.15, 0.5
"""Steps until ground rests or has failed over its step limit, before one has."""

OUTWARDS = 3
"""Trials beyond the first until ground fails, about."""

SPAN = 10
"""Looks over which the unbalanced force is followed."""

AGAIN = 0.3
"""What has gone on for longer than expected is expected to need this share of it again."""


class Forecast:
    """Steps of the stages of a case, as they become known.

    Parameters
    ----------
    stages : sequence of Stage
    particles, dimension : int
    time_step : float [s]
    """

    def __init__(self, stages: Sequence[Stage], *, particles: int, dimension: int, time_step: float) -> None:
        self.stages = list(stages)
        self.size = particles, dimension
        self.time_step = time_step
        self.done = 0.0
        self.rested: list[float] = []  # over the step limit
        self.failed: list[float] = []
        self.number = -1
        self.search: Search | None = None
        self._steps = 0.0
        self._ratios: list[float] = []
        self._trials = 0

    def begin(self, number: int, search: Search | None = None, *, gone: float = 0.0) -> None:
        """A stage begins, or is gone on with after so many steps; `search` where it is one."""
        self._learn()
        self.number, self.search = number, search
        self._steps, self._ratios = gone, []
        self._trials = 0 if search is None else len(search.trials)

    def saw(self, steps: float, ratio: float) -> None:
        """So many more steps have been done, and the unbalanced force ratio is this one."""
        if self.search is not None and len(self.search.trials) > self._trials:
            self._learn_trials(self.search)
            self._steps, self._ratios = 0.0, []
        self.done += steps
        self._steps += steps
        self._ratios.append(ratio)

    def work(self) -> Work:
        """Steps of all stages."""
        parts = [self._of_stage(stage) for stage in self.stages[self.number + 1 :]]
        if self.number >= 0:
            parts.append(self._now())
        left, most = (sum(part[k] for part in parts) for k in (0, 1))
        return Work(self.done, left, most if most > left else math.nan)

    # ------------------------------------------------------------------ what was seen

    def _learn(self) -> None:
        if self.search is not None:
            self._learn_trials(self.search)
        elif self.number >= 0 and self._steps > 0.0 and _rests(stage := self.stages[self.number]):
            criteria = _criteria(stage)
            rest = self._steps - _ramp(stage, criteria, self.size)
            self.rested.append(max(rest, 0.0) / criteria.most_steps(*self.size))

    def _learn_trials(self, search: Search) -> None:
        limit = search.plan.criteria.most_steps(*self.size)
        for trial in search.trials[self._trials :]:
            # the trial that begins where the ground is at rest already tells nothing
            if trial.factor != search.plan.start or trial.verdict != "stable":
                (self.rested if trial.verdict == "stable" else self.failed).append(trial.steps / limit)
        self._trials = len(search.trials)

    def _rest_share(self) -> float:
        if self.rested or self.number < 0 or not _rests(stage := self.stages[self.number]):
            return _mean(self.rested, RESTS)
        # the first that comes to rest says already how long that takes at least
        criteria = _criteria(stage)
        limit = criteria.most_steps(*self.size)
        gone = self._steps - _ramp(stage, criteria, self.size)
        if gone <= 0.0:
            return RESTS
        falls = self._falls(criteria)
        return max(RESTS, min(gone + (0.0 if math.isnan(falls) else falls), limit) / limit)

    def _fail_share(self) -> float:
        return _mean(self.failed, max(FAILS, self._rest_share()))

    # ------------------------------------------------------------------ what is expected

    def _of_stage(self, stage: Stage) -> tuple[float, float]:
        """Steps of a stage that has not begun: expected, and at most."""
        if isinstance(stage, FindFactor):
            return self._of_search(stage.plan, None)
        if isinstance(stage, Run | MoveWall):
            steps = math.ceil(stage.time / self.time_step)
            if not _rests(stage):
                return steps, steps
            return min(steps, self._rest_share() * _criteria(stage).most_steps(*self.size)), steps
        if isinstance(stage, RemoveWalls):
            return 0.0, 0.0
        criteria = _criteria(stage)
        ramp, limit = _ramp(stage, criteria, self.size), criteria.most_steps(*self.size)
        if not _rests(stage):
            return ramp, ramp
        return ramp + self._rest_share() * limit, ramp + limit

    def _now(self) -> tuple[float, float]:
        """Steps left of the stage that is under way: expected, and at most."""
        stage, gone = self.stages[self.number], self._steps
        if self.search is not None:
            return self._of_search(self.search.plan, self.search)
        expected, most = self._of_stage(stage)
        if not _rests(stage):
            return max(expected - gone, 0.0), max(most - gone, 0.0)
        ramp = _ramp(stage, _criteria(stage), self.size)
        left = max(expected - gone, 0.0)
        if gone > ramp:
            left = self._to_rest(_criteria(stage), expected - gone, most - gone)
        return left, max(most - gone, left)

    def _to_rest(self, criteria: Criteria, expected: float, most: float) -> float:
        """Steps until the ground rests, by the unbalanced force where that says something."""
        falls = self._falls(criteria)
        left = max(expected, AGAIN * self._steps) if math.isnan(falls) else falls
        return min(left, max(most, 0.0))

    def _falls(self, criteria: Criteria) -> float:
        """Steps until the unbalanced force has fallen far enough, at its pace; NaN where it does not fall."""
        half = SPAN // 2
        if len(self._ratios) <= SPAN:
            return math.nan
        # medians of the last looks, and of those before
        before, now = (sorted(part)[half // 2] for part in (self._ratios[-SPAN:-half], self._ratios[-half:]))
        if not 0.0 < now < before:
            return math.nan
        each = half * self._steps / len(self._ratios)
        return each * math.log(max(now / criteria.rest, 1.0)) / math.log(before / now)

    def _of_search(self, plan: SearchPlan, search: Search | None) -> tuple[float, float]:
        """Steps left of a search: expected, and at most."""
        criteria = plan.criteria
        ramp, limit = criteria.ramp_steps(*self.size), criteria.most_steps(*self.size)
        rest, fail = (ramp + share * limit for share in (self._rest_share(), self._fail_share()))
        trials = [] if search is None else search.trials
        now = bracket(trials)
        farthest = float(ramp + (1 + criteria.longer) * limit)
        if now.value is not None:
            count = halvings_left(now.width, plan.tolerance)
            expected, most = 0.5 * (rest + fail) * count, farthest * count
        else:
            down = now.failed is not None
            out = sum(
                (trial.factor < plan.start) if down else (trial.factor > plan.start) for trial in trials
            )
            more = 1 if down else max(1, OUTWARDS - out)
            width = _width(plan.step * 2.0 ** (out + more - 1))
            expected = (more - 1) * rest + (rest if down else fail)
            expected += 0.5 * (rest + fail) * halvings_left(width, plan.tolerance)
            looks, wide = _outwards(plan, out, down)
            most = farthest * (looks + halvings_left(_width(wide), plan.tolerance))
        if search is not None and self._steps > 0.0 and expected > 0.0:
            own = 0.5 * (rest + fail)
            expected += max(own - self._steps, AGAIN * self._steps) - own
            most -= self._steps
        return max(expected, 0.0), max(most, expected, 0.0)


def _width(step: float) -> float:
    """Of a bracket between a factor and that times 1 + step, over its middle."""
    return step / (1.0 + 0.5 * step)


def _outwards(plan: SearchPlan, out: int, down: bool) -> tuple[int, float]:
    """Most trials until both sides are known, and the last step."""
    low, high = plan.method.lowest, min(plan.highest, plan.method.highest)
    factor, count, step = plan.start, 0, plan.step
    while (factor > low) if down else (factor < high):
        step = plan.step * 2.0**count
        factor = factor / (1.0 + step) if down else factor * (1.0 + step)
        count += 1
    return max(count - out, 1), step


def _criteria(stage: Stage) -> Criteria:
    assert not isinstance(stage, FindFactor | MoveWall | RemoveWalls)
    return stage.criteria


def _rests(stage: Stage) -> bool:
    """Whether a stage, no search, goes on until the ground rests."""
    if isinstance(stage, Run):
        return stage.until_rest
    return not isinstance(stage, MoveWall | RemoveWalls | FindFactor) and not (
        isinstance(stage, Excavate) and not stage.rest
    )


def _ramp(stage: Stage, criteria: Criteria, size: tuple[int, int]) -> float:
    """Steps before a stage comes to rest."""
    if isinstance(stage, Run | MoveWall | RemoveWalls):
        return 0.0
    ramp = float(criteria.ramp_steps(*size))
    if isinstance(stage, Excavate):
        return stage.shares * max(100, ramp // stage.shares)
    if isinstance(stage, Settle) and not stage.from_nothing and stage.factor == 1.0:
        return 0.0
    return ramp


def _mean(values: Sequence[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise
