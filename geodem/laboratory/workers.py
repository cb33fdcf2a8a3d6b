"""Several tests at a time, each in a process and on a thread of its own.

Tests know nothing of each other, so that the bits of every one are the same whoever carries it out and when. Each is
stored as soon as it is finished: what was begun is lost where all is stopped, and nothing else.
"""

from __future__ import annotations

import contextlib
import heapq
import math
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from ..errors import InputError, StoppedError
from .orders import FinishedTest, TestOrder, find_test, write_test

POLL = 0.2
"""Seconds between looks at whether all is to stop."""

OVERDUE = 0.2
"""Share of its time so far that a test is said to need still when it should have ended already."""


@dataclass(frozen=True)
class Overview:
    """How far a set of orders is.

    Attributes
    ----------
    finished, total : int
        Orders.
    last : FinishedTest or None
        The one that has just ended; None where nothing has.
    running : tuple of (TestOrder, strain, stress)
        What is carried out now and where it is; strain and stress [Pa] are nan until the test has begun.
    seconds_left : float
        nan until one order has been carried out.
    """

    finished: int
    total: int
    last: FinishedTest | None
    running: tuple[tuple[TestOrder, float, float], ...]
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
        self.count = count
        self.folder = folder
        self.watch = watch
        self.stop_asked = stop_asked
        self._messages: queue.Queue[tuple[_Hand, tuple[Any, ...]]] = queue.Queue()
        self._hands: list[_Hand] = []
        self._pace = _Pace()

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the processes, whatever they are at."""
        for hand in self._hands:
            hand.end()
        self._hands = []
        self._messages = queue.Queue()

    def run(self, orders: Sequence[TestOrder]) -> list[FinishedTest]:
        """Carry out the orders that are not stored yet; all of them, in their order.

        Raises
        ------
        InputError
            As of the tests, once what is finished has been stored; a process was ended from outside; a file cannot be
            written.
        StoppedError
            `stop_asked` said so.
        """
        done: dict[int, FinishedTest] = {}
        for k, order in enumerate(orders):
            found = find_test(self._path(order), order) if self.folder is not None else None
            if found is not None:
                done[k] = found
        # the longest first, so that none is left alone at the end
        waiting = sorted((k for k in range(len(orders)) if k not in done), key=lambda k: -orders[k].cost())
        try:
            self._work(orders, waiting, done)
        except BaseException:
            self.close()
            raise
        return [done[k] for k in range(len(orders))]

    def _work(self, orders: Sequence[TestOrder], waiting: list[int], done: dict[int, FinishedTest]) -> None:
        self._tell(orders, waiting, done, None)
        while len(done) < len(orders):
            self._refuse_to_go_on()
            self._hand_out(orders, waiting)
            try:
                hand, (what, *rest) = self._messages.get(timeout=POLL)
            except queue.Empty:
                self._tell(orders, waiting, done, None)
                continue
            if what == "at":
                hand.at = (float(rest[0]), float(rest[1]))
                continue
            if what == "done":
                (test,) = rest
                assert hand.task is not None
                done[hand.task] = test
                self._pace.learn(test.order, hand.seconds() - test.compile_seconds)
                hand.task = None
                if self.folder is not None:
                    write_test(self._path(test.order), test)
                self._tell(orders, waiting, done, test)
            elif what == "refused":
                place, problem, remedy, value = rest
                assert hand.task is not None
                where = f"{orders[hand.task].kind}, {place}"
                raise InputError(where, problem, remedy, value=value)
            elif what == "failed":
                raise RuntimeError(f"a test went wrong where it was carried out:\n{rest[0]}")
            elif hand in self._hands:
                raise InputError(
                    "--threads", f"a process that made a test was ended from outside ({rest[0]})",
                    "Where memory is short give fewer threads, each makes a test of its own; finished tests are kept",
                )  # fmt: skip

    def _path(self, order: TestOrder) -> Path:
        assert self.folder is not None
        return self.folder / f"{order.name}.h5"

    def _refuse_to_go_on(self) -> None:
        if self.stop_asked is not None and self.stop_asked():
            raise StoppedError("stopped, with every finished test kept")

    def _hand_out(self, orders: Sequence[TestOrder], waiting: list[int]) -> None:
        idle = [hand for hand in self._hands if hand.task is None]
        while waiting and (idle or len(self._hands) < self.count):
            if not idle:
                self._hands.append(_Hand(self._messages))
                idle.append(self._hands[-1])
            hand, k = idle.pop(), waiting.pop(0)
            hand.begin(k, orders[k])

    def _tell(
        self,
        orders: Sequence[TestOrder],
        waiting: Sequence[int],
        done: dict[int, FinishedTest],
        last: FinishedTest | None,
    ) -> None:
        if self.watch is None:
            return
        busy = [hand for hand in self._hands if hand.task is not None]
        running = tuple((orders[hand.task], *hand.at) for hand in busy if hand.task is not None)
        left = self._pace.left(
            [(orders[hand.task], hand.seconds()) for hand in busy if hand.task is not None],
            [orders[k] for k in waiting],
            self.count,
        )
        self.watch(Overview(len(done), len(orders), last, running, left))


class _Hand:
    """One process and what it is at."""

    def __init__(self, messages: queue.Queue[tuple[_Hand, tuple[Any, ...]]]) -> None:
        threads = dict.fromkeys(
            ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
        )
        # the folder that geodem was imported from comes first: it need not be an installed one
        root = str(Path(__file__).resolve().parents[2])
        paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process: subprocess.Popen[bytes] = subprocess.Popen(
            [sys.executable, "-P", "-m", "geodem.laboratory.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **threads, "PYTHONPATH": paths},
            start_new_session=True,  # Ctrl-C asks the one who waits for it to stop, not this one to die
        )
        self.task: int | None = None
        self.at = (math.nan, math.nan)
        self.since = 0.0
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.orders: IO[bytes] = self.process.stdin
        self.listener = threading.Thread(
            target=self._listen, args=(self.process.stdout, messages), daemon=True
        )
        self.listener.start()

    def begin(self, task: int, order: TestOrder) -> None:
        self.task, self.at, self.since = task, (math.nan, math.nan), time.perf_counter()
        try:
            pickle.dump(order, self.orders)
            self.orders.flush()
        except BrokenPipeError:
            return  # the listener tells that it has gone

    def seconds(self) -> float:
        return time.perf_counter() - self.since

    def end(self) -> None:
        with contextlib.suppress(BrokenPipeError):
            self.orders.close()
        if self.task is not None:
            self.process.kill()
        self.process.wait()
        self.listener.join()

    def _listen(self, stream: IO[bytes], messages: queue.Queue[tuple[_Hand, tuple[Any, ...]]]) -> None:
        with stream:
            while True:
                try:
                    messages.put((self, pickle.load(stream)))
                except (EOFError, pickle.UnpicklingError):
                    break
        code = self.process.wait()
        messages.put((self, ("gone", f"signal {-code}" if code < 0 else f"status {code}")))


class _Pace:
    """How long orders take: by what those of the same kind took, else by all."""

    def __init__(self) -> None:
        self.took: dict[str, list[float]] = {}  # kind -> seconds per cost

    def learn(self, order: TestOrder, seconds: float) -> None:
        self.took.setdefault(order.kind, []).append(seconds / order.cost())

    def expected(self, order: TestOrder) -> float:
        known = self.took.get(order.kind) or [value for values in self.took.values() for value in values]
        return order.cost() * sum(known) / len(known)

    def left(
        self, running: Sequence[tuple[TestOrder, float]], waiting: Sequence[TestOrder], count: int
    ) -> float:
        """Seconds until all have ended, each given to the first who is free [s]; nan where nothing is known."""
        if not self.took:
            return math.nan if running or waiting else 0.0
        ends = [max(self.expected(order) - since, OVERDUE * since) for order, since in running]
        ends += [0.0] * (count - len(ends))
        heapq.heapify(ends)
        for order in waiting:
            heapq.heapreplace(ends, ends[0] + self.expected(order))
        return max(ends)
