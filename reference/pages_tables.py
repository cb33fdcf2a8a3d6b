"""Rows of results to tables of Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

Row = Mapping[str, Any]

METHODS = {
    "strength-reduction": "Strength reduction: factor of safety",
    "gravity-increase": "Gravity increase: load factor",
}
DILATIONS = {"associated": "dilation angle equal to the friction angle", "zero": "dilation angle zero"}


def groups(rows: Sequence[Row]) -> list[tuple[str, str, list[Row]]]:
    """Rows by method and dilation, the usual ones first."""
    order = [(method, dilation) for method in METHODS for dilation in DILATIONS]
    found = dict.fromkeys((row["method"], row["dilation"]) for row in rows)
    pairs = [pair for pair in order if pair in found] + [pair for pair in found if pair not in order]
    return [(*pair, [row for row in rows if (row["method"], row["dilation"]) == pair]) for pair in pairs]


def sizes(rows: Iterable[Row]) -> list[tuple[int, list[Row]]]:
    """Rows by the number of particles asked for, ascending."""
    ordered = sorted(rows, key=lambda row: row["asked"])
    return [(asked, list(group)) for asked, group in groupby(ordered, key=lambda row: row["asked"])]


def by_case(rows: Sequence[Row], shown: Callable[[Row], str], *, published: bool = False) -> str:
    """A line per case, a column per size."""
    asked_for = [asked for asked, _ in sizes(rows)]
    found = {(row["case"], row["asked"]): row for row in rows}
    lines = []
    for case in sorted({row["case"] for row in rows}):
        cells = [shown(found[case, asked]) if (case, asked) in found else "-" for asked in asked_for]
        known = next((row.get("published") for row in rows if row["case"] == case), None)
        lines.append([case, *([number(known)] if published else []), *cells])
    return table(["case", *(["published"] if published else []), *[f"{asked}" for asked in asked_for]], lines)


def number(value: object, digits: int = 4) -> str:
    """A number with so many digits; a dash for None, other values as text."""
    if value is None:
        return "-"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return f"{value:.0f}" if 10.0**digits <= abs(value) < 1e7 else f"{float(value):.{digits}g}"


def table(head: Sequence[object], lines: Iterable[Sequence[object]]) -> str:
    """A table of Markdown; a bar inside a cell is escaped."""
    rows = [head, ["---"] * len(head), *lines]
    return (
        "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows)
        + "\n"
    )
