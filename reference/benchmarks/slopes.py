"""Error against run time of both methods on the published slopes, over numbers of particles.

Every row is one search, from the case file to the factor, in a process that has its kernels compiled; the time
holds everything but compiling. Rows are stored as they come, and a row that is there already is not run again.
"""

from __future__ import annotations

import argparse
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from geodem._jit import compile_seconds, set_threads
from geodem.analysis import Analysis
from geodem.case import Case, load_case
from geodem.stability.bracket import bracket

from ..results_file import Row, load_rows, store_rows

CASES = Path(__file__).parent.parent / "problems" / "slopes"
SIZES = (500, 1000, 2500, 5000, 10000, 20000, 50000)
METHODS = ("strength-reduction", "gravity-increase")
NAME = "slopes"


def answers() -> dict[str, dict[str, Any]]:
    """Published answers by case."""
    return tomllib.loads((CASES / "answers.toml").read_text())


def published(case: str, method: str) -> tuple[float, str] | None:
    """Published factor and its source; None where there is none."""
    answer = answers()[case]
    key = "factor" if method == "strength-reduction" else "gravity"
    return (answer[key], answer[f"{key}_source"]) if key in answer else None


def run_one(case: str, method: str, particles: int, *, associated: bool = True) -> Row:
    """One search; a row of the results file."""
    known = published(case, method)
    assert known is not None
    value, source = known
    posed = replace(load_case(CASES / f"{case}.toml"), particles=particles, methods=(method,))
    if not associated:
        posed = _without_dilation(posed)
    start, compiled = time.perf_counter(), compile_seconds()
    analysis = Analysis(posed)
    model = analysis.build()
    built = time.perf_counter() - start
    analysis.search()
    seconds = time.perf_counter() - start - (compile_seconds() - compiled)
    record = analysis.records[method]
    now = bracket(record.fine)
    assert analysis.model is not None
    assert analysis.particles is not None
    return {
        "case": case,
        "method": method,
        "dilation": "associated" if associated else "zero",
        "asked": particles,
        "particles": model.particles,
        "spacing": analysis.particles.spacing,
        "factor": now.value,
        "stable": now.stable,
        "failed": now.failed,
        "undecided": list(now.undecided),
        "published": value,
        "published_source": source,
        "error_percent": None if now.value is None else 100.0 * (now.value / value - 1.0),
        "seconds": round(seconds, 3),
        "seconds_build": round(built, 3),
        "steps": sum(trial.steps for trial in (*record.coarse, *record.fine)),
        "threads": set_threads(None),
    }


def _without_dilation(case: Case) -> Case:
    flat = {name: replace(m, dilation_angle=0.0, dilation_given=True) for name, m in case.materials.items()}
    return replace(case, materials=flat)


def wanted(
    cases: Sequence[str], methods: Sequence[str], sizes: Sequence[int], zero: bool
) -> Iterator[tuple[Any, ...]]:
    """(case, method, particles, associated) in the order of their cost."""
    frictionless = {name for name in cases if not any(m.friction_angle for m in _materials(name))}
    for size in sizes:
        for method in methods:
            for name in cases:
                if published(name, method) is None:
                    continue
                if not zero:
                    yield name, method, size, True
                elif name not in frictionless and method == METHODS[0]:
                    yield name, method, size, False


def _materials(case: str) -> list[Any]:
    return list(load_case(CASES / f"{case}.toml").materials.values())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench slopes``."""
    parser.add_argument("--cases", nargs="*", default=sorted(answers()), help="cases; all if left out")
    parser.add_argument("--sizes", nargs="*", type=int, default=list(SIZES), help="numbers of particles")
    parser.add_argument("--methods", nargs="*", default=list(METHODS), choices=METHODS)
    parser.add_argument("--zero-dilation", action="store_true", help="with psi = 0 instead of psi = phi")
    parser.add_argument("--again", action="store_true", help="run rows that are stored already, too")
    parser.add_argument("--threads", type=int, default=None)


def main(arguments: argparse.Namespace) -> int:
    """Run what is asked, print a table, store the rows."""
    set_threads(arguments.threads)
    rows = load_rows(NAME)
    command = "python -m reference " + " ".join(sys.argv[1:])
    done = {_key(row) for row in rows}
    for name, method, size, associated in wanted(
        arguments.cases, arguments.methods, arguments.sizes, arguments.zero_dilation
    ):
        key = (name, method, "associated" if associated else "zero", size)
        if key in done and not arguments.again:
            continue
        try:
            # the first search of a process may compile; run it on the smallest model first
            row = run_one(name, method, size, associated=associated)
        except ValueError as error:
            print(f"{name:13s} {size:6d} {method:18s} refused: {error}", flush=True)
            continue
        rows = [r for r in rows if _key(r) != key] + [row]
        store_rows(NAME, sorted(rows, key=_key), command)
        print(_line(row), flush=True)
    print_summary(rows)
    return 0


def _key(row: Row) -> tuple[str, str, str, int]:
    return row["case"], row["method"], row["dilation"], row["asked"]


def _line(row: Row) -> str:
    error = "open" if row["error_percent"] is None else f"{row['error_percent']:+.2f} %"
    factor = "-" if row["factor"] is None else f"{row['factor']:.4f}"
    undecided = f", {len(row['undecided'])} undecided" if row["undecided"] else ""
    return (
        f"{row['case']:13s} {row['asked']:6d} {row['method']:18s} {row['dilation']:10s} {factor} "
        f"({error} of {row['published']:g}{undecided}) {row['seconds']:.2f} s"
    )


def print_summary(rows: Sequence[Row]) -> None:
    """Mean and largest error, mean and largest time, of every method and size."""
    groups: dict[tuple[str, str, int], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["method"], row["dilation"], row["asked"]), []).append(row)
    for (method, dilation, asked), group in sorted(groups.items()):
        errors = [abs(r["error_percent"]) for r in group if r["error_percent"] is not None]
        times = [r["seconds"] for r in group]
        mean = sum(errors) / len(errors)
        print(
            f"{method:18s} {dilation:10s} {asked:6d}: {len(group):2d} cases, error mean {mean:.2f} % "
            f"max {max(errors):.2f} %, time mean {sum(times) / len(times):.2f} s max {max(times):.2f} s"
        )
