"""Pictures of ground that breaks: materials, displacements and cracks by stage, and what measured points did."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from geodem.breaking.search import Search
from geodem.breaking.site import Site
from geodem.errors import InputError
from geodem.plotting.particles import SHEAR, TENSION, particle_figure
from geodem.plotting.theme import (
    FAILED,
    INK,
    SOFT,
    STABLE,
    VERDICT_COLOURS,
    halo,
    new_figure,
    png,
    quiet_axes,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
STAGE, FACTOR, STEP, TIME = range(4)
"""Columns of a history, as of `Site.columns`."""
CRACKS = (7, 8)
FIRST_POINT = 9


class End(Protocol):
    """A finished stage."""

    @property
    def stage(self) -> Any: ...

    @property
    def site(self) -> Site: ...

    @property
    def search(self) -> Search | None: ...


class Drawn(NamedTuple):
    """A picture with its caption, and the stage that it belongs to, from 1; 0: to all."""

    png: bytes
    caption: str
    stage: int


def breaking_pictures(ends: Sequence[End]) -> dict[str, Drawn]:
    """All pictures by name, PNG; of spheres those that need pyvista only where it is there."""
    found: dict[str, Drawn] = {}
    with style():
        first = ends[0]
        _add(found, "materials", first.site, "material", 1, False,
             f"Materials and walls, after {first.stage.name!r}.", "Materials")  # fmt: skip
        for number, end in enumerate(ends, start=1):
            name = end.stage.name
            if end.search is None:
                if number > 1:
                    _both(found, f"stage-{number}", end.site, number, f"after {name!r}")
                continue
            for verdict, tree in (("stable", end.search.stable), ("failed", end.search.failed)):
                if tree is not None:
                    site = Site.from_tree(tree)
                    factor = end.search.plan.method.value(site)
                    words = f"{_changed(end.search)} {factor:.4g}, {verdict}"
                    _both(found, f"stage-{number}-{verdict}", site, number, words)
            if ends[-1].site.points:
                drawn = png(settlement_chart(end.search, ends[-1].site))
                text = (
                    "Measured points at every factor that was tried, from the moment its trial began. Each trial goes "
                    "on from the highest state that stands."
                )
                found[f"stage-{number}-settlement"] = Drawn(drawn, text, number)
        chart = history_chart(ends)
        if chart is not None:
            text = "Measured points since the start, and cracks by mode, through all stages but trials of a factor."
            found["history"] = Drawn(png(chart), text, 0)
    return found


def site_figure(site: Site, colour: str, title: str, *, cracks: bool = True) -> Figure:
    """A site as it is now, displacements since it settled; measured points are marked."""
    s = copy.copy(site.simulation)
    s.assembly = replace(s.assembly, positions=site.settled[site.number])
    figure = particle_figure(s, colour=colour, cracks=cracks, title=title)
    if s.dimension == 2:
        _mark_points(figure.axes[0], site)
    return figure


def settlement_chart(search: Search, site: Site) -> Figure:
    """Vertical displacement of the first measured points against time, one line a trial."""
    names = list(site.points)[:3]
    d = site.simulation.dimension
    rows = np.array(search.rows)
    figure = new_figure(7.7, 1.2 + 2.9 * len(names))
    panels = figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
    for k, (axes, name) in enumerate(zip(panels, names, strict=True)):
        quiet_axes(axes)
        column = FIRST_POINT + d * list(site.points).index(name) + d - 1
        ends: list[tuple[float, float, str, str]] = []
        for trial in sorted(search.trials, key=lambda t: t.factor):
            own = rows[rows[:, FACTOR] == trial.factor]
            if not len(own):
                continue
            since = own[:, TIME] - own[0, TIME]
            colour = VERDICT_COLOURS[trial.verdict]
            axes.plot(since, own[:, column], color=colour, linewidth=1.5, zorder=3.0)
            ends.append((float(since[-1]), float(own[-1, column]), f"{trial.factor:.3g}", colour))
        _label_ends(axes, ends)
        axes.set_ylabel(f"{name}, {'xyz'[d - 1]} [m]")
        if k == 0:
            axes.set_title(f"Displacement while the {_axis(search)} is reached and held")
    panels[-1].set_xlabel("time since the trial began [s]")
    _legend(figure)
    return figure


def history_chart(ends: Sequence[End]) -> Figure | None:
    """Measured points and cracks against time; None where there is nothing to show."""
    site = ends[-1].site
    rows = np.array(site.history)
    if not len(rows):
        return None
    rows = rows[np.isnan(rows[:, FACTOR])]
    if len(rows) < 2:
        return None
    # a line ends where a search lies between two stages
    jumps = np.flatnonzero(np.diff(rows[:, STAGE]) > 1.0) + 1
    rows = np.insert(rows, jumps, np.nan, axis=0)
    d = site.simulation.dimension
    figure = new_figure(7.7, 4.4 if site.points else 2.6)
    count = 2 if site.points else 1
    panels = figure.subplots(count, 1, squeeze=False, sharex=True)[:, 0]
    if site.points:
        quiet_axes(panels[0])
        for k, name in enumerate(site.points):
            for axis in range(d):
                column = FIRST_POINT + d * k + axis
                dash = "-" if axis == d - 1 else (0, (4, 1.5))
                panels[0].plot(
                    rows[:, TIME], rows[:, column], linewidth=1.4, linestyle=dash, color=f"C{k}",
                    label=f"{name}, {'xyz'[axis]}",
                )  # fmt: skip
        panels[0].set_ylabel("displacement [m]")
        panels[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    lower = panels[-1]
    quiet_axes(lower)
    for column, colour, words in zip(CRACKS, (TENSION, SHEAR), ("tension", "shear"), strict=True):
        lower.plot(rows[:, TIME], rows[:, column], color=colour, linewidth=1.6, label=f"cracks, {words}")
    lower.set_ylabel("cracks [-]")
    lower.set_xlabel("time [s]")
    lower.set_ylim(bottom=0.0)
    lower.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    for number, end in enumerate(ends, start=1):
        own = rows[rows[:, STAGE] == number]
        if len(own):
            for axes in panels:
                axes.axvline(own[0, TIME], color=SOFT, linewidth=0.7, linestyle=(0, (2, 2)), zorder=1.5)
            panels[0].annotate(
                end.stage.name, (own[0, TIME], 1.0), xycoords=("data", "axes fraction"), rotation=90,
                xytext=(3, -3), textcoords="offset points", va="top", fontsize=7.5, color=SOFT,
            )  # fmt: skip
    return figure


def _both(found: dict[str, Drawn], name: str, site: Site, stage: int, words: str) -> None:
    cracks = site.cracks().by_mode()
    _add(
        found,
        f"{name}-displacement",
        site,
        "displacement",
        stage,
        False,
        f"Displacement since the ground settled, {words}.",
        f"Displacement, {words}",
    )
    if sum(cracks.values()):
        _add(
            found, f"{name}-cracks", site, "material", stage, True,
            f"Cracks by mode on the materials, {words}: {cracks['tension']:,} in tension, {cracks['shear']:,} in "
            "shear. Cracks that have opened by more than half a grain show as gaps.", f"Cracks, {words}",
        )  # fmt: skip


def _add(
    found: dict[str, Drawn],
    name: str,
    site: Site,
    colour: str,
    stage: int,
    cracks: bool,
    caption: str,
    title: str,
) -> None:
    try:
        found[name] = Drawn(png(site_figure(site, colour, title, cracks=cracks)), caption, stage)
    except InputError:
        # spheres without pyvista: the frames are there
        return


def _mark_points(axes: Axes, site: Site) -> None:
    where = site.positions_of_all()
    for name, number in site.points.items():
        x, y = where[number]
        if not np.isfinite(x):
            continue
        axes.plot(x, y, marker="v", markersize=6.0, color=INK, markeredgecolor="white", zorder=5.0)
        axes.annotate(
            name, (x, y), xytext=(0, 7), textcoords="offset points", ha="center", fontsize=8.0, zorder=5.0,
            path_effects=halo(),
        )  # fmt: skip


def _label_ends(axes: Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """The factor at the end of each line, moved apart where they would lie over each other."""
    if not ends:
        return
    low, high = axes.get_ylim()
    apart = 0.055 * (high - low)
    at = -np.inf
    for x, y, text, colour in sorted(ends, key=lambda end: end[1]):
        at = max(y, at + apart)
        axes.annotate(
            text, (x, y), xytext=(x + 0.012 * axes.get_xlim()[1], at), textcoords="data", fontsize=7.5, color=colour,
            va="center", path_effects=halo(),
        )  # fmt: skip


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=colour, linewidth=1.6, label=word)
        for word, colour in (("stands", STABLE), ("failed", FAILED))
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)


def _changed(search: Search) -> str:
    return "gravity times" if search.plan.kind == "gravity-increase" else "strength over"


def _axis(search: Search) -> str:
    return "gravity" if search.plan.kind == "gravity-increase" else "reduced strength"
