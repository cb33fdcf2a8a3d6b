"""Spoilt cases, pictures, meshes, terrains, materials and checkpoints: each is used, or refused in words.

Every family runs in a process of its own, whose memory is limited,
with inputs that hypothesis makes from a seed.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from .fuzzing_families import FAMILIES, fuzz, longest, prepare
from .fuzzing_judge import MEMORY, ROOT, Finding, Judge, limited
from .rows import Row, at_most

COUNTS = {
    "cases": 2500, "kinds": 2500, "checks": 120, "case text": 1500, "tables of runs": 300,
    "materials": 800, "pictures": 60, "meshes": 1500, "terrains": 1000,
    "checkpoints": 600, "histories": 300, "results": 300, "fillings": 150,
}  # fmt: skip
"""Inputs of each family."""

SEED = 20261130


def run() -> Sequence[Row]:
    """Every family; rows of how many inputs were tried, what was found, the slowest and the memory."""
    rows = []
    for family, count in COUNTS.items():
        rows += _rows(family, count, *_apart(family, count, SEED))
    tried = int(sum(row.value for row in rows if row.quantity == "inputs tried"))
    whole = [row for row in rows if row.quantity.startswith("taken otherwise")]
    rows.append(
        Row("all", "inputs tried", tried, 10_000, min(tried / 10_000 - 1.0, 0.0), 0.0, 0.0, "asked for")
    )
    rows.append(_none("all", "taken otherwise than in use or words", sum(row.value for row in whole), 0.0))
    return rows


def _rows(family: str, count: int, told: dict[str, float], findings: list[str], seconds: float) -> list[Row]:
    for finding in findings:
        print(finding)
    tried = told.get("cases", 0)
    source = f"seed {SEED}; {int(told.get('refused', 0))} refused in words"
    return [
        Row(family, "inputs tried", tried, count, tried / count - 1.0, 0.05, seconds, source),
        _none(family, "taken otherwise than in use or words", len(findings), seconds),
        at_most(family, "slowest input [s]", told.get("slowest", math.inf), longest(family), seconds, "stated"),
        at_most(family, "growth of resident memory [MB]", told.get("memory", 0.0) / 1e6, MEMORY / 1e6, seconds,
                "stated; the address space is held to it"),
    ]  # fmt: skip


def _none(name: str, quantity: str, value: float, seconds: float) -> Row:
    return Row(name, quantity, value, 0.0, value, 0.0, seconds, "wanted")


def _apart(family: str, count: int, seed: int) -> tuple[dict[str, float], list[str], float]:
    """Figures and findings of a family, and how long it took; from a process that may not come back."""
    begun = time.perf_counter()
    program = [sys.executable, "-m", f"{__package__}.fuzzing", family, str(count), str(seed)]
    done = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - begun
    lines = done.stdout.splitlines()
    if done.returncode != 0 or not lines:
        last = (done.stderr.strip().splitlines() or ["nothing said"])[-1]
        return {}, [f"{family}: the process ended with {done.returncode}: {last}"], seconds
    told = json.loads(lines[-1])
    return told["figures"], told["findings"], seconds


def measured(family: str, count: int, seed: int) -> tuple[Judge, float]:
    """A family in this process; the growth of its resident memory [B]."""
    with tempfile.TemporaryDirectory() as name:
        judge = Judge(family, longest(family))
        prepare(family, Path(name) / "first")
        before = _highest()
        with limited():
            fuzz(judge, Path(name) / "then", count, seed)
        return judge, _highest() - before


def _highest() -> float:
    """Highest resident memory so far [B]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024.0 * int(next(line.split()[1] for line in lines if line.startswith("VmHWM:")))


def main() -> None:
    """One family, told as one line of JSON."""
    family, count, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    judge, memory = measured(family, count, seed)
    figures = {"cases": judge.cases, "refused": judge.refused, "slowest": judge.slowest, "memory": memory}
    found: list[Finding] = list(judge.findings.values())
    print(json.dumps({"figures": figures, "findings": [str(finding) for finding in found]}))


if __name__ == "__main__":
    assert set(COUNTS) == set(FAMILIES)
    main()
