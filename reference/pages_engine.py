"""The part of docs/performance.md on discs and spheres in motion: what they are held to, and what was measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from reference.pages_tables import Row, number, table

PICTURE = "pictures/engine_error_against_time.png"

NAMES = {"bonded-discs": "bonded discs", "bonded-block": "bonded spheres", "touching": "touching spheres",
         "spheres": "spheres in a box", "moving": "moving spheres"}  # fmt: skip


class Check(NamedTuple):
    """One line of a table: least or most is None where it does not bind; both where nothing does."""

    name: str
    measured: float
    low: float
    high: float
    least: float | None
    most: float | None
    unit: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the figure is good; None where it is held to nothing."""
        if self.least is not None:
            return self.measured >= self.least
        return None if self.most is None else self.measured <= self.most


def stored_check(row: Row) -> list[Check]:
    """A row of the benchmarks that store checks as they are shown."""
    least, most = row["held_to_least"], row["held_to_most"]
    return [Check(row["check"], row["measured"], row["low"], row["high"], least, most, row["unit"])]


def held_frontier(row: Row) -> list[Check]:
    """Only what is held to something: the others are points of a curve."""
    return [check for check in stored_check(row) if check.met is not None]


def limits_checks(row: Row) -> list[Check]:
    """Speed over the loop in C, and share of the memory's bandwidth."""
    about = f"{row['particles']} {NAMES.get(row['scene'], row['scene'])}, {_threads(row)}"
    found = [
        Check(f"speed over the same loop in C, {about}", row["ratio"], row["ratio_low"], row["ratio_high"],
              row["held_to_ratio"], None)
    ]  # fmt: skip
    share = row["share_of_triad"]
    if row["held_to_share"] is not None:
        found.append(Check(f"share of the triad, {about}", share, share, share, row["held_to_share"], None))
    return found


def peers_checks(row: Row) -> list[Check]:
    """Speed over another code."""
    about = f"{row['particles']} {NAMES.get(row['scene'], row['scene'])}, {_threads(row)}"
    name = {"yade": "YADE", "liggghts": "LIGGGHTS", "lammps": "LAMMPS"}.get(row["code"], row["code"])
    return [
        Check(f"speed over {name}, {about}", row["ratio"], row["ratio_low"], row["ratio_high"], row["held_to"], None)
    ]  # fmt: skip


def _threads(row: Row) -> str:
    return f"{row['threads']} thread" + ("" if row["threads"] == 1 else "s")


class Section(NamedTuple):
    """One file of results and how it is shown."""

    name: str
    title: str
    text: str
    checks: Callable[[Row], list[Check]]


SECTIONS = (
    Section("limits", "Against what the machine allows",
            "The inner loop beside the same loop in C, compiled for this machine, on the same arrays; and the bytes "
            "that it moves a second beside a = b + s c on arrays far larger than the caches (the triad).",
            limits_checks),
    Section("peers", "Against other codes",
            "The same scene and the same cores, one after the other in turn. Figures are times of a step.",
            peers_checks),
    Section("features", "What features cost, and what rest saves",
            "Each feature is added to the bare normal contact of discs; the same pairs touch in all of them.",
            stored_check),
    Section("statics", "Ways to equilibrium",
            "`find_equilibrium` beside the usual way, local damping of 0.8 at the usual time step, from the same start "
            "to the same balance. Displacements are compared with those of a thousand times better balance.",
            stored_check),
    Section("large", "A million particles",
            "Beside the same scene with fewer. Memory held is that of the simulation; growth is that of the process, "
            "which holds the input as well.",
            stored_check),
    Section("frontier", "Run time against error",
            "Two colliding discs, a cantilever of bonded discs that swings, and one at rest, each with an answer in "
            "closed form.",
            held_frontier),
)  # fmt: skip


def engine_part(
    stored: Mapping[str, Sequence[Row]], headers: Mapping[str, str], not_run: str, *, picture: bool
) -> list[str]:
    """Paragraphs and tables, in Markdown.

    Parameters
    ----------
    stored : mapping of str to rows
        By the name of the file of results.
    headers : mapping of str to str
        The paragraph that says where each file comes from.
    not_run : str
        What is said of a file that is absent, with ``{name}`` and ``{command}``.
    picture : bool
        Whether the picture of run time against error was made.
    """
    parts = [
        "## Discs and spheres in motion\n",
        "Every figure beside what it is held to. The spread is that of the measurements of one run; figures are "
        "medians.\n",
    ]
    for section in SECTIONS:
        parts += [f"### {section.title}\n", section.text + "\n"]
        rows = stored.get(section.name, ())
        if not rows:
            parts.append(
                not_run.format(name=section.name, command=f"python -m reference bench {section.name}") + "\n"
            )
            continue
        checks = [check for row in rows for check in section.checks(row)]
        parts += [headers[section.name], *_checks(checks), *_reasons(checks)]
        if section.name == "frontier":
            if picture:
                parts.append(f"![Run time against error]({PICTURE})\n")
            parts.append(_frontier(rows))
    return parts


REASONS = (
    (
        "speed over the same loop in C, 10000 touching spheres, 1 thread",
        "Of 13.4 ns a pair the law takes 4.2, copying histories to and from the blocks 2.2, rows to the "
        "blocks 2.1, noting which pairs touch 2.0, adding up forces 1.9, and moving the particles the rest "
        "(each part left out in turn). C has gained more from this processor than the blocks have. To try "
        "next: histories in columns, so that successive pairs are read without being sorted into lanes.",
    ),
    (
        "speed over the same loop in C, 10000 touching spheres, 2 threads",
        "The looks at one thread cost some percent of a short run, and the few particles whose forces come "
        "from the other thread's chunks are moved in a second parallel loop.",
    ),
    (
        "speed over the same loop in C, 100000 touching spheres, 2 threads",
        "From 20,000 spheres on a pair takes 5 ns longer, in C 10: rows, pairs and histories no longer fit "
        "the last cache. Asking for them ahead did not help; shorter records would (histories in single "
        "precision, local numbers of two bytes).",
    ),
    (
        "share of the triad",
        "The triad of this machine came out between 33 and 70 GB/s from run to run, against 32 to 35 on the "
        "one on which the share was set; the loop is bound by the work on a pair, not by memory.",
    ),
    (
        "time of rows in random order over sorted ones",
        "Random order costs less than it did: a step asks for the rows of pairs to come ahead of time. That "
        "figure is a measure of what sorting saves, not of the speed of sorted rows.",
    ),
    (
        "one thread over two",
        "As above: looks at one thread, and the second parallel loop of a step.",
    ),
    (
        "time of damped motion over that of find_equilibrium",
        "Steps are hundreds of times fewer. But a step of motion has become three times as fast, on two "
        "threads, and the solves have not: links, matrix and conjugate gradients run on one. To try next: "
        "products of the links in a parallel kernel, the matrix and its levels kept from one solve to the "
        "next.",
    ),
    (
        "time of a search over a force step, 100000 bonded discs",
        "The force step has become 1.5 times as fast; the search has not. Two fifths of it go into looking "
        "through the cells, a sixth into memory that is taken anew for every list (keeping it was tried: 1 ms "
        "less, 110 bytes a particle more).",
    ),
    (
        "speed over LAMMPS",
        "1.8 on one thread. A step takes half a millisecond here, so that the looks at one thread and the "
        "second parallel loop of a step weigh; they were not taken apart.",
    ),
    (
        "speed over YADE, 10000 touching spheres, 2 threads",
        "Within the spread of what is asked; 12 on one thread.",
    ),
    (
        "speed over the same loop in C, 10000 bonded discs, 2 threads",
        "A step takes 0.16 ms: looks at one thread and the second parallel loop, as with spheres.",
    ),
)
"""Why a check is not met, by the beginning of its name: found by leaving out or timing each part."""


def _reasons(checks: Sequence[Check]) -> list[str]:
    """One line for each reason why something is missed."""
    missed = [check.name for check in checks if check.met is False]
    found = [
        f"- {start}: {reason}\n"
        for start, reason in REASONS
        if any(name.startswith(start) for name in missed)
    ]
    return ["What falls short, and why:\n", *found] if found else []


def _checks(checks: Sequence[Check]) -> list[str]:
    held = [check for check in checks if check.met is not None]
    good = sum(check.met is True for check in held)
    lines = []
    for check in checks:
        bound = check.least if check.least is not None else check.most
        word = "at least" if check.least is not None else "at most"
        unit = f" {check.unit}" if check.unit else ""
        spread = "-" if check.low == check.high else f"{number(check.low, 3)} to {number(check.high, 3)}"
        lines.append(
            [
                check.name,
                "-" if bound is None else f"{word} {number(bound, 3)}{unit}",
                number(check.measured, 3) + unit,
                spread,
                {True: "yes", False: "**no**", None: "-"}[check.met],
            ]
        )
    said = [f"{good} of {len(held)} are met.\n"] if held else []
    return [*said, table(["check", "held to", "measured", "spread", "met"], lines)]


SETTINGS = {
    "collision": "step over critical",
    "swing": "step over critical",
    "rest": "unbalanced ratio",
}


def _frontier(rows: Sequence[Row]) -> str:
    """All points of the curves."""
    lines = [
        [
            row["problem"],
            row["driver"],
            f"{SETTINGS[row['problem']]} {row['setting']:g}",
            number(median(row["seconds"]), 3),
            number(row["measured"], 3),
        ]
        for row in rows
    ]
    return table(["problem", "way", "setting", "seconds", "error"], lines)


def write_engine_picture(rows: Sequence[Row], path: Path) -> bool:
    """Draw run time against error; False, and no picture, where there are no rows."""
    if not rows:
        path.unlink(missing_ok=True)
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(run_time_against_error(rows))
    return True


TITLES = {
    "collision": "Collision of two discs",
    "swing": "Swing of a cantilever",
    "rest": "Cantilever under a load",
}
LEAST = 1e-10
"""Smaller errors are drawn here."""


def run_time_against_error(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """A PNG with one panel a problem, both axes logarithmic.

    Parameters
    ----------
    rows : sequence of mapping
        With problem, driver, setting, seconds and measured; at least one.
    """
    from geodem.plotting.theme import new_figure, png, quiet_axes, style
    from reference.pages_chart import DARKEST, LIGHTEST

    problems = [problem for problem in TITLES if any(row["problem"] == problem for row in rows)]
    with style():
        figure = new_figure(4.0 * len(problems), 3.9)
        panels = figure.subplots(1, len(problems), squeeze=False)[0]
        for axes, problem in zip(panels, problems, strict=True):
            own = [row for row in rows if row["problem"] == problem]
            drivers = list(dict.fromkeys(row["driver"] for row in own))
            for place, driver in enumerate(drivers):
                line = sorted(
                    (row for row in own if row["driver"] == driver), key=lambda row: -row["setting"]
                )
                share = 1.0 - place / max(len(drivers) - 1, 1)
                colour = tuple(
                    light + share * (dark - light) for light, dark in zip(LIGHTEST, DARKEST, strict=True)
                )
                axes.plot(
                    [median(row["seconds"]) for row in line],
                    [max(row["measured"], LEAST) for row in line],
                    "o-",
                    color=colour,
                    markersize=5.0,
                    linewidth=1.2,
                    label=driver,
                )
                for row in (line[0], line[-1]):
                    axes.annotate(
                        f"{row['setting']:g}",
                        (median(row["seconds"]), max(row["measured"], LEAST)),
                        textcoords="offset points",
                        xytext=(5, 4),
                        fontsize=8,
                    )
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlabel("run time [s]")
            axes.xaxis.set_minor_formatter("")
            axes.set_title(f"{TITLES[problem]}\n(numbers: {SETTINGS[problem]})")
            if len(drivers) > 1:
                axes.legend()
            quiet_axes(axes)
        panels[0].set_ylabel("relative error")
        return png(figure)
