"""A search for the factor: bracket on a coarse model, bisect on the fine one, continue from the last stable state."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._jit import compile_seconds
from ..measure.energy import EnergyAccount
from ..run_progress import Work
from ..simulation import Simulation
from ..state import State
from .bracket import Bracket, Trial, bracket, next_factor
from .criteria import Criteria
from .forecast import pace, trial_left, work_left
from .methods import Method

Floats = NDArray[np.float64]


class Progress(NamedTuple):
    """Where a search stands, after every batch of steps."""

    kind: str
    model: Literal["coarse", "fine"]
    factor: float
    steps: int
    max_steps: int
    unbalanced_ratio: float
    displacement_settlements: float
    bracket: Bracket
    trials: int
    seconds_left: float


@dataclass
class Snapshot:
    """A state kept: of the last stable trial, or of a failed one."""

    factor: float
    state: State
    energy: EnergyAccount


@dataclass
class Search:
    """Search for the factor of one method on one model; everything that a checkpoint must hold is an attribute.

    Attributes
    ----------
    simulation : Simulation
    method : Method
    criteria : Criteria
    tolerance : float
        Width of [stable, failed] over its middle.
    start, step : float
        First factor, and relative step outwards until both sides are known.
    model : "coarse" or "fine"
    trials : list of Trial
    stable, failed : Snapshot or None
        Highest stable and lowest failed state so far.
    current : float or None
        The factor under trial.
    history : list of (steps, ratio, displacement)
        Of the trial under way.
    """

    simulation: Simulation
    method: Method
    criteria: Criteria = field(default_factory=Criteria)
    tolerance: float = 0.01
    start: float = 1.0
    step: float = 0.3
    model: Literal["coarse", "fine"] = "fine"
    trials: list[Trial] = field(default_factory=list)
    stable: Snapshot | None = None
    failed: Snapshot | None = None
    current: float | None = None
    history: list[tuple[int, float, float]] = field(default_factory=list)
    moving_share: float = 1.0  # at the last look
    seconds: float = 0.0  # of the trial under way

    def run(self, on_batch: Callable[[Search], None] | None = None) -> Bracket:
        """Run to the end, or from where a checkpoint left off; `on_batch` is called after every batch of steps."""
        while self.current is not None or self._begin():
            # what is compiled once tells nothing of the pace
            started = time.perf_counter() - compile_seconds()
            measures = self.simulation.run(self.criteria.batch)
            self.history.append(
                (self.simulation.state.steps, measures.unbalanced_ratio, measures.mean_displacement)
            )
            self.moving_share = measures.moving_share
            self.seconds += time.perf_counter() - compile_seconds() - started
            self._judge()
            if on_batch is not None:
                on_batch(self)
        return bracket(self.trials)

    def continue_trial(
        self, factor: float, history: Sequence[tuple[int, float, float]], state: State
    ) -> None:
        """Take up a trial where a checkpoint left it."""
        self.method.apply(self.simulation, factor)
        self.simulation.state = state
        self.current, self.history = factor, list(history)

    def _begin(self) -> bool:
        """Set up the next trial; False when the search is done."""
        factor = next_factor(
            self.trials, start=self.start, step=self.step, tolerance=self.tolerance, limits=self.method.limits
        )
        if factor is None:
            return False
        factor = round(factor, 5)
        self.method.apply(self.simulation, factor)
        before = self.stable
        if before is not None and before.factor < factor:
            stress = self.method.stress_at(self.simulation, before.state.stress[:, :3], before.factor, factor)
            self.simulation.begin(
                stress,
                displacement=before.state.displacement,
                plastic_shear_strain=before.state.stress[:, 3],
                support=before.state.support,
            )
        else:
            self.simulation.begin(
                self.method.stress_at(self.simulation, self.simulation.elastic.stress, 1.0, factor)
            )
        self.current, self.history, self.seconds = factor, [], 0.0
        return True

    def _judge(self) -> None:
        """End the trial under way if its verdict is due."""
        assert self.current is not None
        factor = self.current
        particles = self.simulation.model.particles
        settlement = self.method.settlement(self.simulation, factor)
        answer = self.criteria.judge(
            self.history, settlement, self.criteria.max_steps(particles), self.moving_share
        )
        if answer is None:
            return
        verdict, criterion = answer
        steps, ratio, displacement = self.history[-1]
        self.trials.append(
            Trial(
                factor,
                verdict,
                criterion,
                steps,
                ratio,
                displacement,
                particles,
                self.model,
                self.seconds,
                self.history,
            )
        )
        now = bracket(self.trials)
        if now.stable == factor or now.failed == factor:
            kept = Snapshot(factor, self.simulation.state.copy(), self.simulation.energy())
            if verdict == "stable":
                self.stable = kept
            else:
                self.failed = kept
                if self.stable is not None and self.stable.factor >= factor:
                    self.stable = None
        self.current, self.history = None, []

    def progress(self) -> Progress:
        """Where the search stands."""
        now = bracket(self.trials)
        steps, ratio, displacement = self.history[-1] if self.history else (0, 1.0, 0.0)
        factor = self.current if self.current is not None else self.trials[-1].factor
        return Progress(
            kind=self.method.kind,
            model=self.model,
            factor=factor,
            steps=steps,
            max_steps=self.criteria.max_steps(self.simulation.model.particles),
            unbalanced_ratio=ratio,
            displacement_settlements=displacement / self.method.settlement(self.simulation, factor),
            bracket=now,
            trials=len(self.trials),
            seconds_left=self.work().left * self.pace(),
        )

    def work(self) -> Work:
        """Steps times particles of this search: done, and left by what trials so near to the critical factor take."""
        steps = self.history[-1][0] if self.history else 0
        particles = self.simulation.model.particles
        seen = math.nan
        if self.current is not None:
            settlement = self.method.settlement(self.simulation, self.current)
            seen = trial_left(self.history, settlement, self.criteria.max_steps(particles), self.criteria)
        left = work_left(
            self.trials, steps, particles, tolerance=self.tolerance, step=self.step,
            running=self.current is not None, seen=seen,
        )  # fmt: skip
        return left._replace(done=sum(t.steps * t.particles for t in self.trials) + float(steps * particles))

    def pace(self, before: Sequence[Trial] = ()) -> float:
        """Seconds of a step of a particle, by this search and the trials of those before it."""
        steps = self.history[-1][0] if self.history else 0
        particles = self.simulation.model.particles
        return pace([*before, *self.trials], self.seconds if self.history else 0.0, steps, particles)
