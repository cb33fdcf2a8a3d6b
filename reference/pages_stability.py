"""What geodem survives: the part of docs/verification.md that is made from the results of its stability battery."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reference.pages_fuzzing import fuzzing_section
from reference.pages_particles import figures
from reference.pages_tables import Row, number, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BATTERY = "stability"
INTERRUPTIONS = "interruptions"
ORDER = "order"
PICTURE = "pictures/order_of_accuracy.png"
HEAD = ["what was tried", "how often", "what is bounded", "bound", "seen", "within", "why", "remarks"]


def stability_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """The battery, one line an attempt or many of a kind, and the order of accuracy."""
    parts = [
        "## Stability and accuracy\n",
        "### What geodem was put through\n",
        "Every line stays within a bound that was stated before it was run, or must stop with a message that "
        "names particle, step and cause. What watches over a motion, and what that costs: "
        "[long particle runs](how-to/particle-runs.md).\n",
    ]
    battery = read(BATTERY)
    if battery.rows:
        parts += [header(battery), _battery(battery.rows)]
    else:
        parts.append(not_run.format(name=BATTERY, command=f"python -m reference run {BATTERY}") + "\n")
    parts += _interruptions(read, header, not_run)
    parts += fuzzing_section(read, header, not_run)
    parts += ["### Order of accuracy\n"]
    order = read(ORDER)
    if order.rows:
        parts += [
            header(order),
            "A lattice of closed contacts, or of bonds, is shaken and moved to one instant with ever shorter steps; "
            "errors are those of places over the swing. The order is the slope of the last two.\n",
            f"![Error against time step]({PICTURE})\n",
            figures(order.rows),
        ]
    else:
        parts.append(not_run.format(name=ORDER, command=f"python -m reference run {ORDER}") + "\n")
    return parts


ENDS = {
    "kills at a random moment": "killed at a random moment",
    "kills in writing what it goes on from": "in writing what it goes on from",
    "kills in writing its outputs": "in writing its outputs",
    "runs ended by Ctrl-C": "Ctrl-C",
    "runs ended by a killed process of theirs": "one of its processes killed",
    "runs ended by a full file": "a file too large",
    "runs ended by a full file system": "disk full",
    "runs ended by a locked folder": "read-only folder",
    "runs gone on with from spoilt files": "spoilt checkpoints",
}
"""Columns of the table of interruptions, by the quantity whose value stands in them."""


def _interruptions(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """How runs of every kind were ended, one line a kind, and what was wrong with what they left."""
    title = "### Runs that are ended by force\n"
    found = read(INTERRUPTIONS)
    if not found.rows:
        return [
            title,
            not_run.format(name=INTERRUPTIONS, command=f"python -m reference run {INTERRUPTIONS}") + "\n",
        ]
    lines = []
    for name in dict.fromkeys(str(row["name"]) for row in found.rows):
        own = {str(row["quantity"]): row for row in found.rows if row["name"] == name}
        counts = [str(round(own[key]["value"])) if key in own else "-" for key in ENDS]
        wrong = sum(
            round(row["value"]) for key, row in own.items() if not row["expected"] and key not in ENDS
        )
        lines.append([name, *counts, str(wrong)])
    kills = sum(int(cell) for line in lines for cell in line[1:4] if cell != "-")
    wrong = sum(int(line[-1]) for line in lines)
    how = "nothing was wrong" if not wrong else f"**{wrong} wrong**"
    return [
        title,
        header(found),
        f"Small runs of every kind, killed {kills} times with `kill -9` and stopped in other ways. After each of "
        "these every file in the folder must be whole, nothing that stood there may be lost, and the run must go on "
        "to the bits of one that nobody disturbed. A full disk and a read-only folder must be told in words; a "
        "checkpoint that is cut off, changed or of an old format must be refused in words or made anew. Columns count "
        f"runs; {how}. What a user does then: "
        "[When something goes wrong](how-to/when-something-goes-wrong.md).\n",
        table(["run", *ENDS.values(), "wrong"], lines),
    ]


def _battery(rows: Sequence[Row]) -> str:
    lines = [
        [
            str(row["name"]),
            str(row["attempts"]),
            str(row["quantity"]),
            number(row["expected"], 3),
            number(row["value"], 3),
            "yes" if row["good"] else "**no**",
            str(row.get("source", "")),
            str(row.get("seen", "")),
        ]
        for row in rows
    ]
    good = sum(bool(row["good"]) for row in rows)
    tried = sum(int(row["attempts"]) for row in rows)
    return f"{good} of {len(lines)} lines, {tried:,} attempts, lie within their bounds.\n\n" + table(
        HEAD, lines
    )


def write_order_picture(rows: Sequence[Row], path: Path) -> bool:
    """Draw errors against time steps; False, and no picture, where there is nothing to draw."""
    if not rows:
        path.unlink(missing_ok=True)
        return False
    from geodem.plotting.theme import new_figure, png, style

    with style():
        figure = new_figure(9.0, 4.0)
        panels = figure.subplots(1, 2, sharey=True)
        for axes, expected, title in zip(
            panels,
            (2.0, 1.0),
            ("Order 2: laws, centred damping, turning", "Order 1: dashpots, local damping"),
            strict=True,
        ):
            _panel(axes, [row for row in rows if row["expected"] == expected], int(expected))
            axes.set_title(title)
        panels[0].set_ylabel("error of places over the swing")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(png(figure))
    return True


def _panel(axes: Axes, rows: Sequence[Row], order: int) -> None:
    from geodem.plotting.theme import INK, quiet_axes

    colours = {"contact": "#2f6f9f", "bond": "#b5651d", "damping": "#5b7f3a"}
    bonds = (
        "two_springs",
        "parallel_bond",
        "cement",
        "rotational_bond",
        "rock",
        "flat_joint",
        "cohesive_moments",
        "jointed",
    )
    named: set[str] = set()
    for row in rows:
        name = str(row["name"])
        sort = (
            "bond"
            if name.startswith(bonds)
            else "contact"
            if name.split()[-1] in ("2D", "3D") and "," not in name
            else "damping"
        )
        if "attitude" in name or "restitution" in name:
            sort = "damping"
        label = {"contact": "laws of contacts", "bond": "laws of bonds", "damping": "damping, attitude"}[sort]
        axes.plot(
            row["steps"],
            row["errors"],
            marker="o",
            markersize=3.5,
            linewidth=1.0,
            alpha=0.75,
            color=colours[sort],
            label=None if label in named else label,
        )
        named.add(label)
    steps = rows[0]["steps"]
    highest = max(float(row["errors"][0]) for row in rows)
    axes.plot(
        steps,
        [2.0 * highest * (step / steps[0]) ** order for step in steps],
        color=INK,
        linestyle="--",
        linewidth=1.0,
        label=f"slope {order}",
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(list(steps), [f"{step:g}" for step in steps])
    axes.minorticks_off()
    axes.set_xlabel("time step over the critical one")
    axes.legend(loc="lower right")
    quiet_axes(axes)
