"""The part of docs/performance.md on run time against error for several codes: picture, who is ahead, all points."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from reference.pages_tables import Row, number, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAME = "frontier-codes"
PICTURE = "pictures/codes_error_against_time.png"
CODES = {"geodem": "geodem", "yade": "YADE", "liggghts": "LIGGGHTS"}
TARGETS = (1e-2, 1e-3)


class Problem(NamedTuple):
    """Title of a panel, and what is run and measured."""

    title: str
    text: str


PROBLEMS = {
    "collision": Problem(
        "Head-on collisions",
        "pairs of spheres with a linear contact that meet anywhere within a step; error of their distance after "
        "parting, over the way in half a period, against the closed form. The codes take the same steps, so their "
        "errors are the same and the picture shows their speed.",
    ),
    "oblique": Problem(
        "Oblique collisions",
        "the same askew, with friction and spins; error of velocities and rim speeds over the speed at which they "
        "meet, against each code's own answer with a tenth of the shortest step.",
    ),
    "pack": Problem(
        "Settling pack",
        "spheres at random that just do not touch, in a box, with friction of 0.5, until they rest under gravity; "
        "distance from the code's own state at rest (after 2.5 times the most steps, or at a balance of 1e-8) over the "
        "way there. Each way to rest leads to a rest of its own: the error tells how near it is, not which is right.",
    ),
    "weight": Problem(
        "Settling pack: weight",
        "the same runs; error of the force on the walls against the weight of the spheres.",
    ),
    "cantilever": Problem(
        "Cantilever at rest",
        "a row of bonded spheres (CohFrict) under a load at its end; error of the deflection against the stiffness "
        "matrix of the chain.",
    ),
    "swing": Problem(
        "Swing of a cantilever",
        "a shorter one in its lowest mode; error of the period.",
    ),
    "first break": Problem(
        "Slope: first break",
        "a layer of bonded spheres (JCFpm) in a hexagonal lattice, cut to 45 degrees, whose gravity grows; error of "
        "the factor at which the first bond breaks. Ramps start from nothing; their error is that of their haste.",
    ),
    "damage": Problem(
        "Slope: a twentieth broken",
        "the factor at which a twentieth of the bonds is broken, against geodem's statics in increments of 0.2 %. What "
        "breaks after the first bond depends on the way, so that errors need not fall with the time spent.",
    ),
}  # fmt: skip

COLOURS = {"geodem": "#0072b2", "yade": "#d55e00", "liggghts": "#00755b"}
MARKERS = "osD^v"
LEGEND_LINE = 0.055
"""Share of a panel's height that a line of its legend takes."""
LEAST = 1e-9
"""Smaller errors are drawn here."""


def points(rows: Sequence[Row]) -> list[Row]:
    """Rows with an error and a time."""
    return [
        row
        for row in rows
        if row["problem"] in PROBLEMS
        and math.isfinite(row["measured"])
        and all(math.isfinite(s) for s in row["seconds"])
    ]


def curves(rows: Sequence[Row]) -> list[Row]:
    """The same, with those that tell two errors twice."""
    found = points(rows)
    twice = [row for row in found if math.isfinite(row.get("weight_error", math.nan))]
    return found + [{**row, "problem": "weight", "measured": row["weight_error"]} for row in twice]


# --- text ---------------------------------------------------------------------------------------------------


def frontier_part(rows: Sequence[Row], header: str, not_run: str, *, picture: bool) -> list[str]:
    """Paragraphs and tables, in Markdown."""
    parts = [
        "## Run time against error, beside YADE and LIGGGHTS\n",
        "The same problems in each code's own laws and steps, one thread each, in turn. Run time is that of the loop "
        "over the steps (of the search, where geodem seeks equilibrium): starts and compiling are told apart below. "
        "Where a run swings about its answer, its error is the largest from then on. LIGGGHTS has no bonds.\n",
    ]
    if not points(rows):
        return [*parts, not_run.format(name=NAME, command=f"python -m reference bench {NAME}") + "\n"]
    parts.append(header)
    if picture:
        parts.append(f"![Run time against error of three codes]({PICTURE})\n")
    parts += ["### Who is ahead\n", ahead(rows)]
    starts = [row for row in rows if row["problem"] == "start"]
    if starts:
        lines = [[CODES.get(row["code"], row["code"]), number(row["measured"], 3)] for row in starts]
        parts += [
            "### Start\n",
            "Seconds of a run beside its loop: start of the program, reading and building the scene, the answer. "
            "geodem compiles its search for neighbours once, and a kernel for each combination of laws and features, "
            "and keeps both on disk.\n",
            table(["code", "seconds"], lines),
        ]
    parts += ["### All points\n", _all(rows)]
    return parts


def ahead(rows: Sequence[Row]) -> str:
    """One line a problem: which code reaches an error in the least time, and how much longer the others take."""
    lines = []
    for name, problem in PROBLEMS.items():
        own = [row for row in curves(rows) if row["problem"] == name]
        if own:
            said = " ".join(_fastest(own, target) for target in TARGETS)
            lines.append(f"- **{problem.title}** ({problem.text}) {said}\n")
    return "\n".join(lines)


def _fastest(rows: Sequence[Row], target: float) -> str:
    best: dict[str, tuple[float, str]] = {}
    for row in rows:
        if row["measured"] <= target:
            found = (median(row["seconds"]), row["driver"])
            best[row["code"]] = min(best.get(row["code"], found), found)
    share = f"{100.0 * target:g} %"
    if not best:
        return f"No code reaches {share}."
    order = sorted(best, key=lambda code: best[code])
    first = best[order[0]]
    others = [
        f"{CODES[code]} ({best[code][1]}) takes {number(best[code][0] / first[0], 2)} times as long"
        for code in order[1:]
    ]
    missing = [CODES[code] for code in dict.fromkeys(row["code"] for row in rows) if code not in best]
    others += [f"{code} does not reach it" for code in missing]
    return (
        f"To {share} {CODES[order[0]]} is the fastest ({first[1]}, {number(first[0], 2)} s)"
        + "".join(f"; {other}" for other in others)
        + "."
    )


def _all(rows: Sequence[Row]) -> str:
    lines = [
        [
            row["problem"],
            CODES[row["code"]],
            row["driver"],
            f"{row['setting']:g} {row['setting_unit']}",
            number(median(row["seconds"]), 3),
            number(row["measured"], 3),
        ]
        for row in curves(rows)
    ]
    return table(["problem", "code", "way", "setting", "seconds", "error"], lines)


# --- picture ------------------------------------------------------------------------------------------------


def write_frontier_picture(rows: Sequence[Row], path: Path) -> bool:
    """Draw run time against error; False, and no picture, where there is nothing to draw."""
    if not points(rows):
        path.unlink(missing_ok=True)
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(codes_error_against_time(curves(rows)))
    return True


def codes_error_against_time(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """A PNG with one panel a problem, both axes logarithmic: a colour a code, a mark a way.

    Parameters
    ----------
    rows : sequence of mapping
        With problem, code, driver, seconds and measured; at least one.
    """
    from geodem.plotting.theme import new_figure, png, style

    shown = [name for name in PROBLEMS if any(row["problem"] == name for row in rows)]
    across = min(len(shown), 4)
    down = -(-len(shown) // across)
    with style():
        figure = new_figure(3.3 * across, 3.4 * down)
        panels = figure.subplots(down, across, squeeze=False).ravel()
        for axes, name in zip(panels, shown, strict=False):
            _panel(axes, [row for row in rows if row["problem"] == name])
            axes.set_title(PROBLEMS[name].title)
        for axes in panels[len(shown) :]:
            axes.set_axis_off()
        for axes in panels[::across]:
            axes.set_ylabel("relative error")
        return _few_colours(png(figure))


def _few_colours(picture: bytes) -> bytes:
    """The same PNG with a palette: a third of the bytes."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as whole:
        whole.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(out, format="PNG", optimize=True)
    return out.getvalue()


def _panel(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    from geodem.plotting.theme import quiet_axes

    for code, name in CODES.items():
        own = [row for row in rows if row["code"] == code]
        for place, driver in enumerate(dict.fromkeys(row["driver"] for row in own)):
            line = [row for row in own if row["driver"] == driver]
            axes.plot(
                [median(row["seconds"]) for row in line],
                [max(row["measured"], LEAST) for row in line],
                marker=MARKERS[place % len(MARKERS)],
                color=COLOURS[code],
                markersize=4.5,
                linewidth=1.1,
                label=f"{name}, {driver}",
            )
    axes.set_xscale("log")
    axes.set_yscale("log")
    # room for the legend below the curves
    low, high = axes.get_ylim()
    room = LEGEND_LINE * len(axes.get_lines())
    axes.set_ylim(low * (low / high) ** (room / (1.0 - room)), high)
    axes.set_xlabel("run time [s]")
    axes.xaxis.set_minor_formatter("")
    axes.legend(fontsize=6.5, loc="lower left")
    quiet_axes(axes)
