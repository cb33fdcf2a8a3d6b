"""Values of a varied key: a list, or a range with its ends and how many or how far apart."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import units
from .document import read_text
from .document_places import steps_of, written
from .table import Findings, Table

RANGE_KEYS = ("from", "to", "count", "step", "spacing")
EXAMPLE = '["10 kPa", "20 kPa"], or {from = "10 kPa", to = "50 kPa", count = 5}'
MOST = 100_000
"""Values of a range."""
_DIGITS = 10
"""Of the values of a range: so many, that 0.1 does not become 0.1000000000000000055."""


def read_varied(top: Table) -> dict[str, tuple[Any, ...]]:
    """Values of every key of [vary]; what is wrong is told."""
    content = top.content.get("vary", {})
    if not isinstance(content, dict):
        top.error(
            "vary",
            f"a table is needed here, not {units.describe(content)}",
            f"Write [vary] with KEY = {EXAMPLE}.",
        )
        return {}
    found: dict[str, tuple[Any, ...]] = {}
    _walk(content, "", top.findings, found)
    return found


def read_list(path: Path, findings: Findings) -> list[dict[str, Any]]:
    """Runs of a table of comma-separated values: keys in its first line, then the values of a run a line."""
    text, _ = read_text(path, what="runs")
    rows = [row for row in csv.reader(text.splitlines()) if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        findings.error(
            "runs", "the file has no line with values", "Write the keys first, then a line for each run."
        )
        return []
    keys = [_key(cell, f"runs, column {k}", findings) for k, cell in enumerate(rows[0], start=1)]
    found = []
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(keys):
            findings.error(
                f"runs, line {number}", f"{len(row)} values, where the first line has {len(keys)} keys",
                "Write one value for every key.",
            )  # fmt: skip
            continue
        found.append({key: _cell(cell) for key, cell in zip(keys, row, strict=True) if key is not None})
    return found


def _walk(content: dict[str, Any], above: str, findings: Findings, found: dict[str, tuple[Any, ...]]) -> None:
    for name, value in content.items():
        place = f"{above}.{name}" if above else name
        at = f"vary.{place}"
        if isinstance(value, dict) and not {"from", "to"} & set(value):
            _walk(value, place, findings, found)
            continue
        key = _key(place, at, findings)
        if key is None:
            continue
        if isinstance(value, dict):
            values = _range(Table(findings, at, value, RANGE_KEYS))
        elif isinstance(value, list):
            values = value
            if not value:
                findings.error(at, "the list is empty", f"Write {EXAMPLE}.")
        else:
            findings.error(
                at, "one value is no list", f"Write {EXAMPLE}; or put it into the case.", value=value
            )
            continue
        twice = _twice(values)
        if twice is not None:
            findings.error(
                at, "this value stands twice", "Name it once: a run is not done twice.", value=twice
            )
        found[key] = tuple(values)


def _twice(values: Sequence[Any]) -> Any:
    """The first value that has stood before, or None."""
    seen: set[str] = set()
    for value in values:
        number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2**53
        # 5 and 5.0 make the same run
        written_out = repr(float(value)) if number else repr(value)
        if written_out in seen:
            return value
        seen.add(written_out)
    return None


def _key(place: str, at: str, findings: Findings) -> str | None:
    from ..errors import InputError

    try:
        return written(steps_of(place, at=at))
    except InputError as error:
        findings.errors.append(error)
        return None


def _range(table: Table) -> list[Any]:
    """Values of a range, in the unit of its first one."""
    findings = table.findings
    before = len(findings.errors)
    for key in ("from", "to"):
        if key not in table:
            table.missing(key, f"Write {EXAMPLE}.")
    if len({"count", "step"} & set(table.content)) != 1:
        findings.error(table.place, "a range has either count or step", f"Write {EXAMPLE}.")
    ends = [units.split(table.content.get(key)) for key in ("from", "to")]
    for key, end in zip(("from", "to"), ends, strict=True):
        if key in table and end is None:
            table.error(key, "this is no number with a unit that is known", f"Write {EXAMPLE}.")
    count = table.integer("count", smallest=2, remedy="Write a whole number such as 5.")
    spacing = table.choice("spacing", ("linear", "log"), default=None) if "spacing" in table else "linear"
    if count is not None and count > MOST:
        table.error("count", f"so many values are no sweep ({MOST:,} at most)", "Write a smaller number.")
    if len(findings.errors) > before:
        return []
    low, high = ends
    assert low is not None
    assert high is not None
    if low[2] != high[2]:
        table.error("to", "this is another kind of quantity than from", f"Write {EXAMPLE}.")
        return []
    start, unit = float(low[0]), low[1]
    last = units.in_unit(units.parse(table.content["to"], high[2], place=table.at("to")), unit)
    if count is not None:
        return _spaced(table, start, last, count, unit, log=spacing == "log")
    return _stepped(table, start, last, low)


def _spaced(table: Table, start: float, end: float, count: int, unit: str, *, log: bool) -> list[Any]:
    if log and not (start > 0.0 and end > 0.0):
        table.error(
            "spacing", "logarithms are of positive values only", 'Leave spacing out, or write "linear".'
        )
        return []
    shares = [k / (count - 1) for k in range(count)]
    if log:
        return [
            _value(math.exp(math.log(start) + t * (math.log(end) - math.log(start))), unit) for t in shares
        ]
    return [_value(start + t * (end - start), unit) for t in shares]


def _stepped(table: Table, start: float, end: float, low: tuple[str, str, str]) -> list[Any]:
    step = table.quantity("step", low[2])
    if step is None:
        return []
    step = units.in_unit(step, low[1])
    if step == 0.0 or (end - start) / step < 0.0:
        table.error("step", "this step does not lead from the one end to the other", f"Write {EXAMPLE}.")
        return []
    steps = (end - start) / step * (1.0 + 1e-12) + 1e-9
    if not steps < MOST:
        table.error("step", f"this makes {steps:.3g} values ({MOST:,} at most)", "Write a larger step.")
        return []
    count = math.floor(steps) + 1
    return [_value(start + k * step, low[1]) for k in range(count)]


def _value(number: float, unit: str) -> Any:
    """A value as a case has it: text with its unit, a whole number where it is one."""
    rounded = float(f"{number:.{_DIGITS}g}")
    whole = rounded.is_integer() and abs(rounded) < 1e15
    if not unit:
        return int(rounded) if whole else rounded
    return f"{int(rounded) if whole else rounded!r} {unit}"


def _cell(cell: str) -> Any:
    """A cell as TOML would have it."""
    text = cell.strip()
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
