"""What `geodem check` tells of a sweep: how many runs, of what, and how long they will take."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case.sweep import SweepCase
from .case.toml_text import toml_value
from .check_printing import escaped, expected_time, print_notices
from .sweep_run import shares

if TYPE_CHECKING:
    from rich.console import Console

SHOWN = 8
"""Values of a key that are printed."""


def check_sweep(case: SweepCase, picture: Path, console: Console) -> dict[str, Any]:
    """Say what will be run, build the case of the first run and estimate the whole from it.

    Returns
    -------
    dict
        "runs", and "expected_s" of all of them.

    Raises
    ------
    InputError
    """
    from rich.console import Console as QuietConsole

    processes, threads = shares(case, None)
    console.print(f"[bold]{escaped(case.title)}[/]")
    console.print(
        f"Sweep: {len(case.runs):,} runs of {escaped(case.base_file.name)}, a case of the kind {case.kind}"
    )
    for key in case.keys:
        values = list(dict.fromkeys(toml_value(run.values[key]) for run in case.runs))
        told = ", ".join(values[:SHOWN]) + (", ..." if len(values) > SHOWN else "")
        console.print(f"  {escaped(key)}: {escaped(told)} ({len(values)} values)")
    if case.table:
        console.print(f"Table: {escaped(', '.join(case.table))}")
    found = case.of.check(case.read(case.runs[0]), picture, QuietConsole(file=io.StringIO()))
    one = _seconds(found.get("expected_s"))
    whole = one * -(-len(case.runs) // processes)
    low, high = expected_time(whole / 3), expected_time(whole * 3)
    each = "1 thread" if threads == 1 else f"{threads} threads"
    console.print(
        f"Expected time: {expected_time(whole)} (from {low} to {high}), {processes} at a time on {each} each, if every "
        f"run takes as long as the first one ({expected_time(one)}); compiling not counted"
    )
    print_notices(case.notices, (), console)
    for text in case.questions:
        console.print(f"[yellow]note[/] {escaped(text)}")
    if picture.is_file():
        console.print(f"Picture of the first run: {escaped(str(picture))}")
    return {"runs": len(case.runs), "expected_s": whole, "first": found}


def _seconds(expected: Any) -> float:
    if isinstance(expected, Mapping):
        return float(sum(expected.values()))
    return float(expected or 0.0)
