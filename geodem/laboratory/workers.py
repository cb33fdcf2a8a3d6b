"""Several tests at a time, each in a process and on a thread of its own.

Tests know nothing of each other, so that the bits of every one are the same whoever carries it out and when. Each is
stored as soon as it is finished: what was begun is lost where all is stopped, and nothing else.
"""

from __future__ import annotations

import heapq
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from .orders import FinishedTest, TestOrder, Told, find_test, perform, write_test
from .processes import Processes, Task

OVERDUE = 0.05
"""Share of its time that a test is said to need still when it should have ended already."""


@dataclass(frozen=True)
class Overview:
    """How far a set of orders is.

    Attributes
    ----------
    finished, total : int
        Orders.
    last : FinishedTest or None
        The one that has just ended; None where nothing has.
    running : tuple of (TestOrder, Told)
        What is carried out now and where it is.
    seconds_left : float
        nan until the first test is well under way.
    """

    finished: int
    total: int
    last: FinishedTest | None
    running: tuple[tuple[TestOrder, Told], ...]
    seconds_left: float


def workers_allowed(threads: int | None) -> int:
    """How many tests may run at a time: as many as cores, where `threads` does not say less or more."""
    if threads is not None:
        return threads
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Workers:
    """Processes that carry out orders; use it in a `with` block.

    Parameters
    ----------
    count : int
        Processes; fewer are started where there are fewer orders.
    folder : pathlib.Path, optional
        Where finished tests are stored, NAME.h5, and found again. Nothing is stored where it is left out.
    watch : callable, optional
        Is given an `Overview` now and then.
    stop_asked : callable, optional
        Says when to stop.
    """

    def __init__(
        self,
        count: int,
        folder: Path | None = None,
        *,
        watch: Callable[[Overview], None] | None = None,
        stop_asked: Callable[[], bool] | None = None,
    ) -> None:
        self.processes = Processes(count)
        self.folder = folder
        self.watch = watch
        self.stop_asked = stop_asked
        self._pace = Forecast()

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.processes.close()

    def run(self, orders: Sequence[TestOrder]) -> list[FinishedTest]:
        """Carry out the orders that are not stored yet; all of them, in their order.

        Raises
        ------
        InputError
            As of the tests; a process was ended from outside; a file cannot be written.
        StoppedError
            `stop_asked` said so.
        """
        done: dict[int, FinishedTest] = {}
        for k, order in enumerate(orders):
            found = find_test(self.folder / order.file, order) if self.folder is not None else None
            if found is not None:
                done[k] = found
        # the longest first, so that none is left alone at the end
        open_ = sorted((k for k in range(len(orders)) if k not in done), key=lambda k: -orders[k].cost())
        begun: set[int] = set()
        self._tell(orders, done, open_, begun, None)
        tasks = [Task(perform, (orders[k],), tells=True) for k in open_]
        for what, number, test in self.processes.events(tasks, self.stop_asked):
            last = None
            if what == "done":
                done[open_[number]] = last = test
                # without the start of a process, which the next test needs not
                self._pace.learn(test.order, test.seconds)
                if self.folder is not None:
                    write_test(self.folder / test.order.file, test)
            self._tell(orders, done, open_, begun, last)
        return [done[k] for k in range(len(orders))]

    def _tell(
        self,
        orders: Sequence[TestOrder],
        done: dict[int, FinishedTest],
        open_: Sequence[int],
        begun: set[int],
        last: FinishedTest | None,
    ) -> None:
        if self.watch is None:
            return
        running = [each for each in self.processes.running() if open_[each.task] not in done]
        begun |= {each.task for each in running}
        waiting = [orders[k] for number, k in enumerate(open_) if number not in begun]
        told = [(orders[open_[each.task]], each.seconds, each.told or Told()) for each in running]
        left = self._pace.left(told, waiting, self.processes.count)
        under_way = tuple((order, now) for order, _, now in told)
        self.watch(Overview(len(done), len(orders), last, under_way, left))


class Forecast:
    """How long orders take: by what those of the same kind took, else by all, and by how far those under way are."""

    def __init__(self) -> None:
        self.took: dict[str, list[float]] = {}  # kind -> seconds per cost

    def learn(self, order: TestOrder, seconds: float) -> None:
        """An order has been carried out in so many seconds, compiling left out."""
        self.took.setdefault(order.kind, []).append(seconds / order.cost())

    def left(
        self, running: Sequence[tuple[TestOrder, float, Told]], waiting: Sequence[TestOrder], count: int
    ) -> float:
        """Seconds until all have ended, each given to the first who is free [s]; nan where nothing is known.

        Parameters
        ----------
        running : sequence of (order, seconds since it began, what it told)
        waiting : sequence of orders
        count : int
            At a time.
        """
        if not (running or waiting):
            return 0.0
        known = dict(self.took)
        for order, _, told in running:
            if order.kind not in self.took and not math.isnan(told.whole):
                known.setdefault(order.kind, []).append(told.whole / order.cost())
        if not known:
            return math.nan
        ends = [self._rest(order, since, told, known) for order, since, told in running]
        ends += [0.0] * (count - len(ends))
        heapq.heapify(ends)
        for order in waiting:
            heapq.heapreplace(ends, ends[0] + _expected(order, known))
        return max(ends)

    def _rest(self, order: TestOrder, since: float, told: Told, known: dict[str, list[float]]) -> float:
        """Of one that is under way [s]."""
        whole = _expected(order, known)
        if math.isnan(told.share):
            return max(whole - since, OVERDUE * whole)
        return max(1.0 - told.share, OVERDUE) * whole


def _expected(order: TestOrder, known: dict[str, list[float]]) -> float:
    took = known.get(order.kind) or [value for values in known.values() for value in values]
    return order.cost() * sum(took) / len(took)
