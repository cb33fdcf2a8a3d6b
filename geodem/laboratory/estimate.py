"""What the tests of a case will cost, before they are made: particles, bonds, steps, time, memory."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import pace as paces
from .orders import KINDS, TestOrder, specimen_of
from .processes import Processes, Task
from .rig import Rig
from .specimen import Specimen

PROBE_STEPS = 50
BATCHES = 6
"""Steps of a batch, and batches, of which the fastest counts."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Cost of a set of orders.

    Attributes
    ----------
    specimen : Specimen
        The first one.
    bonds : (m, 2) int64
        Pairs of its particles.
    time_step : float
        [s]; masses are those of a quasi-static test, so that it is no physical time.
    step_seconds : float
        Time that a step took [s].
    steps : dict of str to float
        By kind of test: steps of all its tests together, in steps of that specimen.
    longest : float
        Seconds of the longest test.
    memory_bytes : int
        Of a process that makes a test; 0 where the system does not tell.
    """

    specimen: Specimen
    bonds: NDArray[np.int64]
    time_step: float
    step_seconds: float
    steps: dict[str, float]
    longest: float
    memory_bytes: int

    def seconds(self, processes: int) -> float:
        """Until all tests are finished, so many at a time."""
        return max(sum(self.steps.values()) * self.step_seconds / processes, self.longest)


def estimate(orders: Sequence[TestOrder]) -> Estimate:
    """Make the first specimen that is gripped, and let it move a few steps, where and as a test would.

    Parameters
    ----------
    orders : sequence of TestOrder
        At least one.

    Raises
    ------
    InputError
        As of `specimen_of` and `Rig`.
    """
    first = next((order for order in orders if not KINDS[order.kind].slender), None)
    if first is None:
        first = TestOrder("uniaxial-compression", orders[0].specimen, orders[0].material)
    with Processes(1) as processes:
        found = [
            event.content for event in processes.events([Task(_probe, (first,))]) if event.what == "done"
        ]
    specimen, bonds, time_step, per_step, memory = found[0]
    whole = specimen.height / specimen.diameter * (first.pace + paces.PILOT) * KINDS[first.kind].length
    steps: dict[str, float] = {}
    most = 0.0
    for order in orders:
        own = whole * order.cost() / first.cost()
        steps[order.kind] = steps.get(order.kind, 0.0) + own
        most = max(most, own)
    return Estimate(specimen, bonds, time_step, per_step, steps, most * per_step, memory)


def _probe(order: TestOrder) -> tuple[Specimen, NDArray[np.int64], float, float, int]:
    """The specimen, its bonds, its step [s], the run time of one [s] and the memory of the process [bytes]."""
    specimen = specimen_of(order)
    rig = Rig(specimen, order.material, seed=order.seed)
    rig.begin(1e-9)
    s = rig.simulation
    s.run(2)
    batches = []
    for _ in range(BATCHES):
        begun = time.perf_counter()
        s.run(PROBE_STEPS)
        batches.append((time.perf_counter() - begun) / PROBE_STEPS)
    # what else the machine does can only make a step longer
    return specimen, s.assembly.bonds.astype(np.int64), s.time_step, min(batches), _memory()


def _memory() -> int:
    """The most that this process has taken [bytes]."""
    try:
        import resource
    except ImportError:
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(most) * (1 if sys.platform == "darwin" else 1024)
