"""geodem beside other codes: the part of docs/verification.md that is made from `python -m reference compare`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from reference.pages_particles import Group
from reference.pages_tables import Row, table

COMPARED = (
    Group(
        "fewbody",
        "A few spheres, a thousand steps",
        "The same scene, posed once, in geodem (in the convention of the other code) and in the other code. The "
        "difference is the largest over all particles and steps, over the largest value; only rounding is left.",
    ),
    Group(
        "handover",
        "Ten thousand spheres, handed over",
        "The other code goes first; its positions, velocities, spins and shear forces are handed to geodem, and both "
        "go on for twenty steps.",
    ),
    Group(
        "convergence",
        "geodem's own convention",
        "By default geodem turns remembered forces with their contact exactly and begins half a step back, which the "
        "others do otherwise. What follows from that vanishes with the time step.",
    ),
    Group(
        "mutation",
        "What would be seen",
        "One formula of a law is made a millionth larger, and the few-body comparisons are made again. Each must then "
        "be far out of its bound under one of the changes, and each change must be seen.",
    ),
)
"""Files of results, compare-NAME.json, and how they stand on the page; others that are there follow."""


def compared_sections(
    read: Callable[[str], Any], header: Callable[[Any], str], not_run: str, others: Sequence[str] = ()
) -> list[str]:
    """Texts of all comparisons; `read` gives what is stored under a name, `others` are names without a text here."""
    parts = ["## Other codes\n"]
    groups = [*COMPARED, *(Group(name, name.replace("-", " ").capitalize(), "") for name in others)]
    for group in groups:
        parts.append(f"### {group.title}\n")
        if group.text:
            parts.append(group.text + "\n")
        name = f"compare-{group.name}"
        stored = read(name)
        if not stored.rows:
            parts.append(
                not_run.format(name=name, command=f"python -m reference compare {group.name}") + "\n"
            )
            continue
        said = ", ".join(dict.fromkeys(f"{row['code']} {row['version']}" for row in stored.rows))
        parts += [header(stored), f"Compared with {said}.\n", comparisons(stored.rows)]
    return parts


def comparisons(rows: Sequence[Row]) -> str:
    """A line for every scene: its quantities one after the other where there are several."""
    scenes: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        scenes.setdefault((str(row["code"]), str(row["scene"])), []).append(row)
    lines = []
    for (code, scene), group in scenes.items():
        bounds = {row["bound"] for row in group if row["bound"] is not None}
        told = "; ".join(f"{row['quantity']} {_number(row['difference'])}" for row in group)
        bound = ", ".join(_number(value) for value in sorted(bounds)) or "-"
        lines.append([code, scene, told, bound, "yes" if all(row["good"] for row in group) else "**no**"])
    good = sum(line[-1] == "yes" for line in lines)
    head = ["code", "scene", "largest difference over largest value", "bound", "within"]
    return f"{good} of {len(lines)} comparisons lie within their bounds.\n\n" + table(head, lines)


def _number(value: Any) -> str:
    if value is None:
        return "no number"
    return "0" if value == 0 else f"{value:.1e}"
