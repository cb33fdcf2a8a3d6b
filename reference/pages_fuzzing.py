"""What spoilt input did: the part of docs/verification.md that is made from the results of the fuzzing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from reference.pages_tables import Row, number, table

NAME = "fuzzing"
HEAD = [
    "family", "inputs", "refused in words", "neither used nor refused", "slowest [s]", "bound [s]",
    "memory taken [MB]", "bound [MB]",
]  # fmt: skip
INPUTS, WRONG, SLOWEST, MEMORY = (
    "inputs tried", "taken otherwise than in use or words", "slowest input [s]", "growth of resident memory [MB]"
)  # fmt: skip


def fuzzing_section(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> Sequence[str]:
    """One line a family of inputs."""
    parts = ["### Spoilt input\n"]
    stored = read(NAME)
    if not stored.rows:
        return [*parts, not_run.format(name=NAME, command=f"python -m reference run {NAME}") + "\n"]
    by_family: dict[str, dict[str, Row]] = {}
    for row in stored.rows:
        by_family.setdefault(str(row["name"]), {})[str(row["quantity"])] = row
    whole = by_family.pop("all")
    lines = [_line(family, rows) for family, rows in by_family.items()]
    wrong = int(whole[WRONG]["value"])
    return [
        *parts,
        header(stored),
        f"{int(whole[INPUTS]['value']):,} inputs, made by hypothesis from a seed: keys, numbers, units, words and "
        "nesting of cases of every kind, their bytes, pictures, meshes, terrains, materials, checkpoints. Each must be "
        "used, or be refused in words that name place, problem and remedy, within the time and the memory; "
        f"{wrong if wrong else 'none'} ended otherwise. `checks` builds the case as `geodem check` does, where 3 MB of "
        "memory are free, and counts compiling.\n",
        table(HEAD, lines),
    ]


def _line(family: str, rows: dict[str, Row]) -> list[str]:
    tried, wrong, slowest, memory = (rows[name] for name in (INPUTS, WRONG, SLOWEST, MEMORY))
    refused = str(tried["source"]).rpartition("; ")[2].split(" ")[0]
    return [
        family, f"{int(tried['value']):,}", f"{int(refused):,}",
        "none" if not wrong["value"] else f"**{int(wrong['value'])}**",
        number(slowest["value"], 2), number(slowest["expected"], 2),
        number(memory["value"], 3), number(memory["expected"], 3),
    ]  # fmt: skip
