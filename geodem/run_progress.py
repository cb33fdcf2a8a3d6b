"""What a run tells whoever watches it: where it is, how much work is left, and how long that takes.

Work is counted in a unit of which all parts of a run take about the same time: steps times particles, say. So a
forecast is two of them, each to be looked at by itself: how much work is left, which follows from the run and is the
same on every machine, and how long a unit of it takes here and now.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from typing import NamedTuple


class Work(NamedTuple):
    """How far a run is.

    Attributes
    ----------
    done, left : float
        What was done, and what is expected to be left.
    most : float
        What may be left at most, where nobody can know: a search whose trials may go on. NaN where `left` is all.
    """

    done: float
    left: float
    most: float = math.nan


def together(parts: Iterable[Work]) -> Work:
    """The work of parts of a run, one after the other."""
    works = list(parts)
    bounded = any(not math.isnan(part.most) for part in works)
    most = sum(part.left if math.isnan(part.most) else part.most for part in works) if bounded else math.nan
    return Work(sum(part.done for part in works), sum(part.left for part in works), most)


class RunUpdate(NamedTuple):
    """Where a run is.

    Attributes
    ----------
    stage : str
        What is done, in a word: "build", "settle".
    text : str
        What is done, in words. A new one is a new line where there is no terminal.
    detail : str
        How far it is; shown on a terminal only, and may change at every batch of steps.
    seconds_left : float
        As expected; NaN where nobody knows.
    seconds_most : float
        At most, where it may be more than expected; else NaN.
    work : Work, optional
        What the times are made of.
    """

    stage: str
    text: str
    detail: str = ""
    seconds_left: float = math.nan
    seconds_most: float = math.nan
    work: Work | None = None


LEAST = 0.02
"""Share of the work that has to be done before its pace is trusted: the first steps fill caches."""

SURE = 0.1
"""Share of the work over which a pace is taken at least, once so much is done: parts of a run differ."""

MARKS = 0.01
"""Share of the work between two moments that a pace is taken from."""


class Pace:
    """How long work takes: as long as the latter half of what was done took, or all while that is little; no compiling.

    Steps become slower as ground breaks and flows, or as others use the machine: what was long ago says little.

    Parameters
    ----------
    compiled : callable
        Seconds that were spent on compiling so far, as of `geodem._jit.compile_seconds`.
    done : float
        Work that was done before, as in a run that is gone on with.
    closing : float
        Seconds that follow the work: measures, pictures, report.
    """

    def __init__(self, compiled: Callable[[], float], *, done: float = 0.0, closing: float = 0.0) -> None:
        self._compiled = compiled
        self._closing = closing
        self.begin(done)

    def begin(self, done: float = 0.0) -> None:
        """Count from now on, with so much work behind."""
        self._behind = done
        self._marks: list[tuple[float, float]] = []

    def left(self, work: Work) -> tuple[float, float]:
        """Seconds left as expected, and at most [s]; NaN while little has been done, and where there is no `most`."""
        now = time.perf_counter() - self._compiled()
        if not self._marks:
            # before the first work there is much to be made ready
            if work.done > self._behind:
                self._marks.append((work.done, now))
            return math.nan, math.nan
        first = self._marks[0][0]
        done = work.done - first
        whole = done + work.left
        if done <= LEAST * whole:
            return math.nan, math.nan
        latter = min(0.5 * done, max(done - SURE * whole, 0.0))
        since, at = next(mark for mark in reversed(self._marks) if mark[0] <= first + latter)
        if work.done >= self._marks[-1][0] + MARKS * whole:
            self._marks.append((work.done, now))
        each = (now - at) / (work.done - since)
        return each * work.left + self._closing, each * work.most + self._closing


def duration(seconds: float) -> str:
    """A time as it is told while one waits: 1 s, 40 s, 2.5 min."""
    if seconds < 1.0:
        return "1 s"
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.1f} min"


def time_left(expected: float, most: float = math.nan) -> str:
    """How long it still takes, in seconds [s]: "about 5.0 min left, 20.0 min at most"; nothing where nobody knows."""
    if not math.isfinite(expected):
        return ""
    left = f"about {duration(expected)} left"
    return f"{left}, {duration(most)} at most" if math.isfinite(most) else left
