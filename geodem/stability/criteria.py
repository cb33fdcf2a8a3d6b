"""When a trial is stable, when it has failed, and when nobody can tell.

Reference for the idea (unbalanced force and displacement instead of an iteration count): Dawson, Roth &
Drescher 1999 (Geotechnique 49:835). The limits are ours; any failure limit from 2 to 20 settlements gives the same
factor within 0.3 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from .bracket import Verdict


@dataclass(frozen=True)
class Criteria:
    """The rules, in the order in which they are asked.

    Attributes
    ----------
    stable_ratio : float
        Stable when the unbalanced force ratio falls below this [-].
    failed_settlements : float
        Failed when what moves has moved more than this many elastic settlements u_s [-] ...
    own_settlements : float
        ... of them at least this many in this trial [-]: one that continues a state which has moved that far
        before is not failed by its first step ...
    steady : float
        ... and the unbalanced force is still above this share of what it was half that way [-]: what comes to
        rest after a long way has not failed.
    balanced_ratio : float
        What has moved that far, or is at the step limit, counts as stable where the unbalanced force is below this
        share of the weight of what moves [-]: it is in balance for all practical purposes. (The thin slabs that
        split off ground without tension lean a long way before they rest.)
    growing : float
        At the step limit: failed when the displacement of the last quarter of the steps is above this share of
        that of the quarter before [-] ...
    growing_settlements : float
        ... and above this many u_s [-].
    steps_per_length : float
        Step limit per square root of the number of particles: waves need that many steps to cross the section.
    batch : int
        Steps between two looks.
    """

    stable_ratio: float = 1e-5
    failed_settlements: float = 10.0
    own_settlements: float = 2.0
    steady: float = 0.8
    balanced_ratio: float = 5e-4
    growing: float = 0.7
    growing_settlements: float = 0.02
    steps_per_length: float = 300.0
    batch: int = 50

    def max_steps(self, particles: int) -> int:
        """Step limit of a trial."""
        batches = int(self.steps_per_length * sqrt(particles) / self.batch) + 1
        return max(batches, 80) * self.batch

    def judge(
        self,
        history: Sequence[tuple[int, float, float]],
        settlement: float,
        max_steps: int,
        moving_share: float = 1.0,
    ) -> tuple[Verdict, str] | None:
        """Verdict and the rule that gave it, or None: go on.

        Parameters
        ----------
        history : sequence of (steps, unbalanced force ratio [-], displacement of what moves [m])
            One entry per batch.
        settlement : float
            u_s, the elastic settlement under gravity by the same measure [m].
        max_steps : int
        moving_share : float
            Share of the section that moves [-].
        """
        steps, ratio, displacement = history[-1]
        if ratio < self.stable_ratio:
            return "stable", f"unbalanced force below {self.stable_ratio:g} of the weight"
        balanced = ratio < self.balanced_ratio * sqrt(moving_share)
        far = displacement > self.failed_settlements * settlement
        own = displacement - history[0][2] > self.own_settlements * settlement
        if far and own and self._is_steady(history):
            if balanced:
                return (
                    "stable",
                    f"a long way, but in balance to {self.balanced_ratio:g} of the weight that moves",
                )
            return (
                "failed",
                f"moved more than {self.failed_settlements:g} elastic settlements, not slowing down",
            )
        if steps < max_steps:
            return None
        if balanced:
            return (
                "stable",
                f"in balance to {self.balanced_ratio:g} of the weight that moves after {steps} steps",
            )
        quarter = max(1, len(history) // 4)
        last = displacement - history[-1 - quarter][2]
        before = (
            history[-1 - quarter][2] - history[-1 - 2 * quarter][2] if len(history) > 2 * quarter else last
        )
        if last > self.growing * before and last > self.growing_settlements * settlement:
            return "failed", f"still growing after {steps} steps"
        return "undecided", f"neither at rest nor growing after {steps} steps"

    def _is_steady(self, history: Sequence[tuple[int, float, float]]) -> bool:
        """Whether the unbalanced force held its size over the second half of the way of this trial."""
        _, ratio, displacement = history[-1]
        half = 0.5 * (history[0][2] + displacement)
        earlier = next(entry for entry in history if entry[2] >= half)
        return ratio >= self.steady * earlier[1]
