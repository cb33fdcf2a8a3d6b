"""Processes that do the runs of a sweep, several at a time; each does one after the other, and none ends the others."""

from __future__ import annotations

import contextlib
import json
import math
import os
import queue
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple

from .errors import StoppedError
from .sweep_record import LEFT

POLL = 0.2
"""Seconds between looks at whether all is to stop."""

GRACE = 300.0
"""Seconds that a run is given to come to a place from which it can be gone on with."""


class UnderWay(NamedTuple):
    """A run that is under way for so many seconds, and still takes so many (NaN where it has not told)."""

    seconds: float
    left: float


class Ended(NamedTuple):
    """A run has ended; `gone` says how its process did, where that did not say that the run is done."""

    number: int
    gone: str = ""


def do_runs(
    numbers: Sequence[int],
    order: Mapping[str, Any],
    *,
    processes: int,
    ended: Callable[[Ended], None],
    waiting: Callable[[dict[int, UnderWay]], None],
    stop_asked: Callable[[], bool] | None = None,
) -> None:
    """Do runs, the first ones first.

    Parameters
    ----------
    numbers : sequence of int
        Of the runs.
    order : mapping
        What `geodem.sweep_worker` is told of the sweep; "threads" among it.
    processes : int
        Runs at a time.
    ended : callable
        Is given an `Ended` for each run.
    waiting : callable
        Is called now and then with what is known of each run that is under way.
    stop_asked : callable, optional

    Raises
    ------
    StoppedError
        `stop_asked` said so; runs that were under way can be gone on with.
    """
    left = deque(numbers)
    messages: queue.Queue[tuple[_Hand, str]] = queue.Queue()
    hands: list[_Hand] = []
    try:
        while left or any(hand.number for hand in hands):
            if stop_asked is not None and stop_asked():
                for hand in hands:
                    hand.stop()
                raise StoppedError("stopped, with every finished run kept")
            while left and (idle := _idle(hands, processes, order, messages)) is not None:
                idle.begin(left.popleft())
            try:
                hand, said = messages.get(timeout=POLL)
            except queue.Empty:
                waiting({hand.number: hand.under_way() for hand in hands if hand.number})
                continue
            if said.startswith(LEFT):
                hand.left, hand.told = float(said.removeprefix(LEFT)), time.perf_counter()
                continue
            number, hand.number = hand.number, 0
            if said.startswith("gone"):
                hands.remove(hand)
            if number:
                ended(Ended(number, said.removeprefix("gone, ") if said.startswith("gone") else ""))
    finally:
        try:
            for hand in hands:
                hand.end()
        except BaseException:
            # told to stop at once: nobody is left who would wait for the others
            for hand in hands:
                hand.kill()
            raise


def _idle(
    hands: list[_Hand], processes: int, order: Mapping[str, Any], messages: queue.Queue[tuple[_Hand, str]]
) -> _Hand | None:
    """A process that has nothing to do, a new one where there may be one more."""
    free = next((hand for hand in hands if not hand.number), None)
    if free is None and len(hands) < processes:
        free = _Hand(order, messages)
        hands.append(free)
    return free


class _Hand:
    """One process, and the run that it is at (0 for none)."""

    def __init__(self, order: Mapping[str, Any], messages: queue.Queue[tuple[_Hand, str]]) -> None:
        names = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        # the folder that geodem was imported from comes first: it need not be an installed one
        root = str(Path(__file__).resolve().parents[1])
        paths = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process: subprocess.Popen[str] = subprocess.Popen(
            [sys.executable, "-P", "-m", "geodem.sweep_worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, **dict.fromkeys(names, str(order["threads"])), "PYTHONPATH": paths},
            start_new_session=True,  # Ctrl-C asks the one who waits for it to stop, not this one to die
        )
        self.number = 0
        self.since = self.told = 0.0
        self.left = math.nan
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self._orders: IO[str] = self.process.stdin
        self._say(json.dumps(order))
        self._listener = threading.Thread(
            target=self._listen, args=(self.process.stdout, messages), daemon=True
        )
        self._listener.start()

    def begin(self, number: int) -> None:
        self.number, self.since, self.left = number, time.perf_counter(), math.nan
        self._say(str(number))

    def under_way(self) -> UnderWay:
        """Its run, now."""
        now = time.perf_counter()
        left = self.left - (now - self.told)
        return UnderWay(now - self.since, 0.0 if left < 0.0 else left)

    def stop(self) -> None:
        """Tell it to stop; `end` waits for it."""
        with contextlib.suppress(BrokenPipeError):
            self._orders.close()

    def end(self) -> None:
        """Wait for it where it was told to stop or has nothing to do, else end it at once."""
        told = self._orders.closed or not self.number
        self.stop()
        try:
            if told:
                self.process.wait(GRACE)
        except subprocess.TimeoutExpired:
            pass
        finally:
            self.kill()
            self._listener.join()

    def kill(self) -> None:
        """End it at once; may be called again."""
        self.process.kill()
        self.process.wait()

    def _say(self, line: str) -> None:
        # the listener tells where it has gone
        with contextlib.suppress(BrokenPipeError):
            self._orders.write(f"{line}\n")
            self._orders.flush()

    def _listen(self, stream: IO[str], messages: queue.Queue[tuple[_Hand, str]]) -> None:
        with stream:
            for line in stream:
                messages.put((self, line.strip()))
        code = self.process.wait()
        messages.put((self, "gone, " + (f"signal {-code}" if code < 0 else f"status {code}")))
