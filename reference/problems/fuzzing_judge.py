"""Judge of how a reader takes spoilt input: it may use it, or refuse it in words; nothing else."""

from __future__ import annotations

import resource
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NamedTuple

from geodem.errors import InputError, InputErrors

SECONDS = 10.0
"""Longest time that one input may take [s of the processor]; six times as long by the clock, where it waits."""

MEMORY = 1 << 30
"""What reading may take beyond what the program holds before [B]; address space, so that nothing escapes it."""

WORDS = 2000
"""Longest message of one error [characters]."""

ROOT = Path(__file__).resolve().parents[2]


class OverdueError(BaseException):
    """The time is over; no `except Exception` may hide it."""


class Finding(NamedTuple):
    """An input that was taken otherwise than it should be."""

    family: str
    what: str
    where: str
    given: str

    def __str__(self) -> str:
        return f"{self.family}: {self.what}\n    at {self.where}\n    given {self.given}"


class Judge:
    """Counts inputs, and keeps the shortest of each kind that was not taken well.

    Parameters
    ----------
    family : str
        Of the inputs.
    seconds : float, optional
        Longest time that one of them may take [s of the processor]; `SECONDS` if left out.
    """

    def __init__(self, family: str, seconds: float | None = None) -> None:
        self.family = family
        self.seconds = seconds
        self.cases = 0
        self.refused = 0
        self.slowest = 0.0
        self.findings: dict[tuple[str, str], Finding] = {}

    def judge(self, read: Callable[[], object], given: str) -> None:
        """Let `read` have the input; `given` shows it where something is found."""
        self.cases += 1
        begun = time.process_time()
        seconds = SECONDS if self.seconds is None else self.seconds
        try:
            with _in_time(seconds), warnings.catch_warnings():
                # a warning of numpy on the screen tells a user as little as a traceback
                warnings.simplefilter("error", RuntimeWarning)
                read()
        except InputErrors as errors:
            self.refused += 1
            for error in errors.errors:
                self._words(error, given)
        except InputError as error:
            self.refused += 1
            self._words(error, given)
        except OverdueError as error:
            self._keep(f"not done within {seconds:g} s", _where(error), given)
        except (Exception, SystemExit) as error:
            self._keep(f"{type(error).__name__}: {error}"[:200], _where(error), given)
        finally:
            self.slowest = max(self.slowest, time.process_time() - begun)

    def found(self, what: str, where: str, given: str) -> None:
        """Keep what the caller has seen to be wrong."""
        self._keep(what, where, given)

    def _words(self, error: InputError, given: str) -> None:
        """An error names a place and says what to do, in words that can be printed."""
        for part in ("place", "problem", "remedy"):
            if not str(getattr(error, part)).strip():
                self._keep(f"an error without its {part}", _where(error), given)
        text = str(error)
        try:
            text.encode()
        except UnicodeEncodeError:
            self._keep("an error that cannot be printed", _where(error), given)
        if len(text) > WORDS:
            self._keep(f"an error of more than {WORDS} characters", f"{error.place[:60]}", given)

    def _keep(self, what: str, where: str, given: str) -> None:
        key = (what.split(":")[0], where)
        held = self.findings.get(key)
        if held is None or len(given) < len(held.given):
            self.findings[key] = Finding(self.family, what, where, given)


@contextmanager
def limited(memory: int = MEMORY) -> Iterator[None]:
    """No more than so much address space beyond what this process has now [B]; MemoryError beyond it."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + memory, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextmanager
def _in_time(seconds: float) -> Iterator[None]:
    def over(number: int, frame: FrameType | None) -> None:
        raise OverdueError

    timers = {
        signal.ITIMER_PROF: (signal.SIGPROF, seconds),
        signal.ITIMER_REAL: (signal.SIGALRM, 6.0 * seconds),
    }
    old = {number: signal.signal(number, over) for number, _ in timers.values()}
    for timer, (_, limit) in timers.items():
        signal.setitimer(timer, limit)
    try:
        yield
    finally:
        for timer in timers:
            signal.setitimer(timer, 0.0)
        for number, handler in old.items():
            signal.signal(number, handler)


def _where(error: BaseException) -> str:
    """The last line of geodem that an error went through."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "/geodem/" in frame.filename] or list(frames)
    if not ours:
        return "?"
    last = ours[-1]
    name = Path(last.filename)
    shown = name.relative_to(ROOT) if name.is_relative_to(ROOT) else name.name
    return f"{shown}:{last.lineno} in {last.name}"
