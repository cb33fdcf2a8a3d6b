"""Processes that do one piece of work each at a time, on one thread: specimens side by side keep all cores busy.

They are started as programs of their own, not as copies of the one that runs: what that has loaded, and how a user's
script is written, is of no account.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any, NamedTuple

from ..errors import InputError, StoppedError

POLL = 0.2
"""Seconds between looks at whether all is to stop."""


class Task(NamedTuple):
    """A function at the top of a module and its arguments; one that tells how far it is takes `say` as the last one."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    tells: bool = False


class Event(NamedTuple):
    """What has happened: a task has ended with a result ("done"), tells how far it is ("at"), or nothing ("")."""

    what: str
    task: int
    content: Any


class Running(NamedTuple):
    """A task that is under way, for how long [s], and what it told last."""

    task: int
    seconds: float
    told: Any


class Processes:
    """Processes that carry out tasks; use it in a `with` block.

    Parameters
    ----------
    count : int
        At most so many; fewer are started where there are fewer tasks. They go on waiting for the next ones.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self._messages: queue.Queue[tuple[_Hand, tuple[Any, ...]]] = queue.Queue()
        self._hands: list[_Hand] = []

    def __enter__(self) -> Processes:
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

    def running(self) -> list[Running]:
        """What is under way."""
        return [
            Running(hand.task, time.perf_counter() - hand.since, hand.told)
            for hand in self._hands
            if hand.task is not None
        ]

    def events(self, tasks: Sequence[Task], stop_asked: Callable[[], bool] | None = None) -> Iterator[Event]:
        """Carry out tasks, the first ones first; what happens, as it happens, until all are done.

        Raises
        ------
        InputError
            A task raised it (its place then names the task), or a process was ended from outside.
        RuntimeError
            A task raised anything else.
        StoppedError
            `stop_asked` said so; what was under way is lost.
        """
        waiting = list(range(len(tasks)))
        left = len(tasks)
        try:
            while left:
                if stop_asked is not None and stop_asked():
                    raise StoppedError("stopped, with every finished test kept")
                self._hand_out(tasks, waiting)
                try:
                    hand, (what, *content) = self._messages.get(timeout=POLL)
                except queue.Empty:
                    yield Event("", -1, None)
                    continue
                task = hand.task
                if what == "gone" or task is None:
                    raise InputError(
                        "--threads", f"a process that made a test was ended from outside ({content[0]})",
                        "Where memory is short give fewer threads, each makes a test of its own; what is done is kept",
                    )  # fmt: skip
                if what == "refused":
                    place, problem, remedy, value = content
                    raise InputError(place, problem, remedy, value=value)
                if what == "failed":
                    raise RuntimeError(f"a test went wrong where it was made:\n{content[0]}")
                if what == "at":
                    hand.told = content[0]
                    yield Event("at", task, content[0])
                else:
                    left -= 1
                    yield Event("done", task, content[0])
                    hand.task = None
        except BaseException:
            self.close()
            raise

    def _hand_out(self, tasks: Sequence[Task], waiting: list[int]) -> None:
        idle = [hand for hand in self._hands if hand.task is None]
        while waiting and (idle or len(self._hands) < self.count):
            if not idle:
                self._hands.append(_Hand(self._messages))
                idle.append(self._hands[-1])
            k = waiting.pop(0)
            idle.pop().begin(k, tasks[k])


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
        self.told: Any = None
        self.since = 0.0
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.orders: IO[bytes] = self.process.stdin
        self.listener = threading.Thread(
            target=self._listen, args=(self.process.stdout, messages), daemon=True
        )
        self.listener.start()

    def begin(self, number: int, task: Task) -> None:
        self.task, self.told, self.since = number, None, time.perf_counter()
        # the listener tells where it has gone
        with contextlib.suppress(BrokenPipeError):
            pickle.dump(task, self.orders)
            self.orders.flush()

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
