"""Two programs timed in turn, so that a machine that drifts drifts for both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

Seconds = Callable[[int], float]
"""Seconds of one step, measured over a number of steps."""


def enough_steps(run: Seconds, seconds: float, *, least: int = 20, most: int = 20_000) -> int:
    """Steps that take about so many seconds, found from a short run."""
    one = max(run(least), 1e-9)
    return int(min(max(seconds / one, least), most))


def alternate(
    first: Seconds, second: Seconds, *, seconds: float, rounds: int
) -> tuple[list[float], list[float]]:
    """Seconds of one step of both, first and second in turn, `rounds` times each."""
    steps = enough_steps(first, seconds), enough_steps(second, seconds)
    pairs = [(first(steps[0]), second(steps[1])) for _ in range(rounds)]
    return [a for a, _ in pairs], [b for _, b in pairs]


def compared(ours: Sequence[float], theirs: Sequence[float]) -> dict[str, Any]:
    """Medians, all measurements, and theirs over ours: median and extremes of the ratios, round by round."""
    ratios = [b / a for a, b in zip(ours, theirs, strict=True)]
    return {
        "ours": median(ours),
        "theirs": median(theirs),
        "ratio": median(ratios),
        "ratio_low": min(ratios),
        "ratio_high": max(ratios),
        "ours_all": list(ours),
        "theirs_all": list(theirs),
    }
