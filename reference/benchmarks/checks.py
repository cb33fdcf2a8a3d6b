"""What one check of a benchmark measured, beside what it is held to."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

from ..results_file import Row, load_rows, store_rows


def check(
    name: str,
    values: Sequence[float],
    *,
    unit: str = "",
    least: float | None = None,
    most: float | None = None,
    **details: Any,
) -> Row:
    """A row: median and extremes of what was measured, and the bound that it is held to, if any.

    Parameters
    ----------
    name : str
        What is measured, as a reader of the table is told it.
    values : sequence of float
        One figure a round.
    unit : str
    least, most : float, optional
        Good are figures from `least` on, or up to `most`.
    **details
        Further columns of the row.
    """
    return {
        "check": name,
        "unit": unit,
        "measured": median(values),
        "low": min(values),
        "high": max(values),
        "held_to_least": least,
        "held_to_most": most,
        **details,
    }


def met(row: Row) -> bool | None:
    """Whether a row is as good as it is held to be; None where it is held to nothing."""
    if row["held_to_least"] is not None:
        return bool(row["measured"] >= row["held_to_least"])
    if row["held_to_most"] is not None:
        return bool(row["measured"] <= row["held_to_most"])
    return None


def line(row: Row) -> str:
    """A row as it is printed."""
    unit = f" {row['unit']}" if row["unit"] else ""
    held = ""
    if met(row) is not None:
        least = row["held_to_least"] is not None
        bound = row["held_to_least" if least else "held_to_most"]
        held = f", held to at {'least' if least else 'most'} {bound:g}: {'met' if met(row) else 'MISSED'}"
    spread = f" ({row['low']:.4g} to {row['high']:.4g})" if row["low"] != row["high"] else ""
    return f"{row['check']}: {row['measured']:.4g}{unit}{spread}{held}"


class Results:
    """Rows of one benchmark: each is printed and stored as it comes, and takes the place of its older self."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.rows = load_rows(name)
        self.command = "python -m reference " + " ".join(sys.argv[1:])

    def add(self, row: Row) -> None:
        """Print and store a row."""
        print(line(row), flush=True)
        kept = {old["check"]: old for old in self.rows} | {row["check"]: row}
        self.rows = list(kept.values())
        store_rows(self.name, self.rows, self.command)


def in_turn(
    runs: Sequence[Callable[[], float]], rounds: int, *, warm_up: bool = True
) -> list[tuple[float, ...]]:
    """What several measurements gave, one after the other, `rounds` times; a first round of all does not count."""
    if warm_up:
        for run in runs:
            run()
    return [tuple(run() for run in runs) for _ in range(rounds)]


def ratios(figures: Sequence[tuple[float, ...]]) -> list[float]:
    """The second figure over the first, round by round."""
    return [second / first for first, second in figures]
