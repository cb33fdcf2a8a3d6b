"""When bonded ground stands, when it has failed, and when nobody can tell: rules for true, damped motion.

The idea is that of Dawson, Roth & Drescher 1999 (Geotechnique 49:835), unbalanced force and displacement instead of
a count of iterations, as in `geodem.stability.criteria`. Distances count in particles here, not in elastic settlements:
a crack opens by the size of a grain however stiff the ground is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..stability.bracket import Verdict

Look = tuple[int, float, float]
"""Steps, unbalanced force ratio [-], way of what moves most [m]."""


@dataclass(frozen=True)
class Criteria:
    """The rules, in the order in which they are asked.

    Attributes
    ----------
    rest : float
        At rest when the unbalanced force falls below this share of the mean contact force [-].
    failed_diameters : float
        Failed when what moves most has gone this many mean diameters since the trial's loads were on [-] ...
    steady : float
        ... and is not slower than this share of its largest speed [-]: what comes to rest has not failed.
    moving_share : float
        What moves most: this share of the particles [-], and ten of them at least. What has come to rest has failed as
        well where that has gone so far since the search began, beyond what it would have settled without breaking:
        ground that creeps from one rest to the next is not the same.
    balanced : float
        At the step limit: stands where the unbalanced force is below this share [-] ...
    creeping : float
        ... and it has gone less than this many diameters in the last quarter of the steps [-].
    growing : float
        At the step limit: failed when it has gone more than `creeping` in the last quarter, and more than this share
        of what it went in the quarter before [-].
    steps_per_length : float
        Step limit per particle along a side of as many particles: waves need about two steps to pass one.
    ramp_per_length : float
        The same of the steps in which loads or strength change.
    longer : int
        Times that a trial of which nobody can tell goes on for as many steps again.
    """

    rest: float = 1e-4
    failed_diameters: float = 2.0
    steady: float = 0.5
    moving_share: float = 0.005
    balanced: float = 2e-3
    creeping: float = 0.05
    growing: float = 0.7
    steps_per_length: float = 200.0
    ramp_per_length: float = 20.0
    longer: int = 2

    def most_steps(self, particles: int, dimension: int) -> int:
        """Step limit of a trial after its ramp."""
        return 100 * max(1, round(self.steps_per_length * particles ** (1.0 / dimension) / 100))

    def ramp_steps(self, particles: int, dimension: int) -> int:
        """Steps in which a trial's loads or strengths are reached."""
        return 100 * max(1, round(self.ramp_per_length * particles ** (1.0 / dimension) / 100))

    def judge(self, history: Sequence[Look], diameter: float, most_steps: int) -> tuple[Verdict, str] | None:
        """Verdict and the rule that gave it, or None: go on.

        Parameters
        ----------
        history : sequence of Look
            One entry a look, in equal steps.
        diameter : float [m]
        most_steps : int
        """
        steps, ratio, way = history[-1]
        if ratio < self.rest:
            return "stable", f"at rest: unbalanced force below {self.rest:g} of the mean contact force"
        if way > self.failed_diameters * diameter and self._is_steady(history):
            return (
                "failed",
                f"what moves most went more than {self.failed_diameters:g} particle diameters, not slowing down",
            )
        if steps < most_steps:
            return None
        quarter = max(1, len(history) // 4)
        last, before = self._ways(history, quarter)
        if ratio < self.balanced and last < self.creeping * diameter:
            return "stable", f"in balance to {self.balanced:g} of the mean contact force after {steps} steps"
        if last > self.creeping * diameter and last > self.growing * before:
            return "failed", f"still moving, not slowing down, after {steps} steps"
        return "undecided", f"neither at rest nor failed after {steps} steps"

    def count_all(self, answer: tuple[Verdict, str], total: float, diameter: float) -> tuple[Verdict, str]:
        """The verdict, once what moved in the trials before counts too.

        Parameters
        ----------
        answer : (verdict, rule)
            Of the trial by itself.
        total : float
            Way of what moves most since the search began, beyond the settlement of unbroken ground [m].
        diameter : float [m]
        """
        if answer[0] == "failed" or total <= self.failed_diameters * diameter:
            return answer
        rest = "came to rest" if answer[0] == "stable" else "not at rest"
        return (
            "failed",
            f"{rest}, and what moves most has gone {total / diameter:.2g} particle diameters since the search began, "
            f"more than {self.failed_diameters:g}",
        )

    def _is_steady(self, history: Sequence[Look]) -> bool:
        """Whether the speed, over a tenth of the looks, has kept its size."""
        span = max(1, len(history) // 10)
        ways = [look[2] for look in history]
        speeds = [b - a for a, b in zip(ways, ways[span:], strict=False)]
        return bool(speeds) and speeds[-1] >= self.steady * max(speeds)

    @staticmethod
    def _ways(history: Sequence[Look], quarter: int) -> tuple[float, float]:
        """Gone in the last quarter of the looks, and in that before [m]."""
        ways = [0.0, *(look[2] for look in history)]
        last = ways[-1] - ways[-1 - quarter]
        return last, ways[-1 - quarter] - ways[max(0, len(ways) - 1 - 2 * quarter)]


def most_moved(ways: NDArray[np.float64], share: float) -> float:
    """Mean [m] of the largest of ways (n,) [m], of this share of all and of ten at least."""
    sizes = np.sort(ways)
    return float(sizes[-max(10, round(share * len(sizes))) :].mean())
