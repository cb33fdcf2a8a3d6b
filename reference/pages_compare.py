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
    Group(
        "beam",
        "A bonded beam",
        "3 x 3 x 20 spheres on a cubic lattice, all that touch bonded, one end held, the other drawn, twisted or bent "
        "by forces that stay; no damping. The stiffness is the force over the mean deflection, the period that of the "
        "lowest swing; differences are relative.",
    ),
    Group(
        "block",
        "A bonded block pressed to failure",
        "About 1,200 spheres, face-centred cubic with 7 % of the sites empty and the strength of every bond 0.6 to 1.4 "
        "times the mean, between two driven layers. The same law, strengths and criterion in both codes; local damping "
        "of 0.2 with YADE, none with LAMMPS. The modulus is the slope up to the first break. Motion is chaotic after "
        "that, so three blocks are broken. Broken contacts slide with friction, in LAMMPS from no shear force on, "
        "in geodem with what the bond left. The time of a step is that of the loop, in YADE and LAMMPS with the frames "
        "that they keep. Only modulus and peak have bounds, the rest is for information.\n\n"
        "![Stress against strain](pictures/compare_block.png)",
    ),
    Group(
        "settling",
        "Three thousand spheres settle in a box",
        "Spheres with radii of 0.8 to 1.2 times the mean begin at the same random places in all codes, without "
        "touching, and fall into a box with smooth sides. Springs and friction are the same everywhere: kn d/(m "
        "g) = 3,000, ks = 2/7 kn, friction 0.5. YADE's law has no dashpots and LIGGGHTS has no local damping, so "
        "geodem runs twice: with local damping beside YADE, with dashpots beside LIGGGHTS, in its own convention. "
        "The motion is chaotic, so means over three seeds are compared. The bound is that of Student's test: "
        "where nothing but chance tells the means of two codes apart, 99 of 100 differences lie within it. For "
        "distributions, two codes may be no farther apart than two seeds of one code. That the comparison sees "
        "what it should is shown by geodem with another friction. Seconds are those of one thread, the codes one "
        "after the other; on a machine with other work they are rough.",
    ),
    Group(
        "column",
        "A column of five thousand spheres collapses",
        "The grains of the box above stand as a column, 24 mean diameters wide, in a slot of 6 between smooth "
        "walls, on a floor of held spheres. geodem lets them settle behind a gate; all codes begin with these "
        "positions, at rest, and without the gate. Local damping is 0.02 only: it holds back what flows by a share "
        "of the forces on it, which grow with the pressure. Bounds as above. Lines are means of three seeds, bands "
        "reach from the lowest to the highest.\n\n"
        "![Collapsed columns](pictures/compare_column.png)",
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
