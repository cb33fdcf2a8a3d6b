"""One line of the table of the stability battery: what was tried, how often, the bound, what was seen."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from geodem.errors import InputError, UnstableError


class Trial(NamedTuple):
    """What was tried so many times, and the worst that was seen beside its bound.

    `error` is how far the figure lies beyond its bound, over the bound (or by itself where the bound is 0).
    """

    name: str
    quantity: str
    value: float
    expected: float
    error: float
    bound: float
    seconds: float
    source: str = ""
    attempts: int = 1
    seen: str = ""

    @property
    def good(self) -> bool:
        """Within its bound."""
        return abs(self.error) <= self.bound


def trial(
    name: str,
    quantity: str,
    value: float,
    limit: float,
    count: int,
    seconds: float,
    source: str = "",
    seen: str = "",
) -> Trial:
    """A figure that must not lie above a limit, of the worst of `count` attempts."""
    # in this order, what is no number stays none and is not good
    error = max(value - limit, 0.0) if limit == 0.0 else max(value / limit - 1.0, 0.0)
    if value != value:
        error = value
    return Trial(name, quantity, float(value), float(limit), error, 1e-9, seconds, source, count, seen)


def refused(name: str, what: str, messages: list[str | None], wanted: list[str], seconds: float) -> Trial:
    """All of the attempts must end with a message that holds every one of `wanted`; None is an attempt that went on."""
    silent = sum(message is None or not all(word in message for word in wanted) for message in messages)
    words = ", ".join(wanted)
    shown = next((message for message in messages if message), "no message")
    return trial(
        name,
        f"{what}: attempts without a message that names {words}",
        silent,
        0.0,
        len(messages),
        seconds,
        "every attempt must stop with a message",
        shown.splitlines()[0][:220],
    )


class Ending:
    """What a piece of work ended with: nothing, or geodem's message."""

    def __init__(self) -> None:
        self.message: str | None = None
        self.error: InputError | UnstableError | None = None


@contextmanager
def ending() -> Iterator[Ending]:
    """Collect the message of an `InputError` or an `UnstableError`; everything else is a defect and goes on."""
    found = Ending()
    try:
        yield found
    except (InputError, UnstableError) as error:
        found.message = str(error)
        found.error = error


class Clock:
    """Seconds since it was made or last read."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def read(self) -> float:
        """Seconds since the last reading."""
        now = time.perf_counter()
        passed, self._last = now - self._last, now
        return passed
