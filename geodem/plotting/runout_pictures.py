"""Pictures of a run-out: what is handed over, how it flows, where it comes to rest, and its energy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.plotting.theme import (
    FAILED,
    FAINT,
    INK,
    SLIP,
    SOFT,
    STABLE,
    displacement_colours,
    halo,
    material_colour,
    new_figure,
    png,
    quiet_axes,
    style,
)
from geodem.runout.flow import Flow
from geodem.runout.handing import HandOver

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

WIDTH = 7.7
MOMENTS = 4
"""Pictures of the mass on its way."""
RIGID = "#c9ced6"
BANDS = 8
"""Stripes across the mass that show how it was deformed."""


def runout_pictures(
    hand: HandOver, flow: Flow, places: Floats, deposit: Mapping[str, Any]
) -> dict[str, bytes]:
    """PNGs by name.

    Parameters
    ----------
    hand : HandOver
    flow : Flow
        At its end.
    places : (k, n, 2) [m]
        The discs at the hand-over and every few looks.
    deposit : mapping
        As in result.json.
    """
    with style():
        return {
            "before": _before(hand, flow),
            "during": _during(flow, places),
            "after": _after(flow, deposit),
            "history": _history(flow),
        }


def _view(flow: Flow, places: Floats) -> tuple[float, float, float, float]:
    """What is worth seeing: left, right, bottom, top [m]."""
    own = flow.moving
    spots = places[:, own].reshape(-1, 2)
    (left, bottom), (right, top) = spots.min(axis=0), spots.max(axis=0)
    margin = 0.12 * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - 0.5 * margin, top + 0.5 * margin


def _axes_of(view: tuple[float, float, float, float], panels: int = 1) -> tuple[Any, list[Axes]]:
    left, right, bottom, top = view
    tall = (WIDTH - 0.9) * (top - bottom) / (right - left)
    wide = 1 if panels == 1 else 2
    rows = -(-panels // wide)
    figure = new_figure(WIDTH, rows * (tall / wide + 0.45) + 0.75)
    axes = list(np.ravel(figure.subplots(rows, wide, sharex=True, sharey=True, squeeze=False)))
    for ax in axes[panels:]:
        ax.set_axis_off()
    for ax in axes[:panels]:
        ax.set_xlim(left, right)
        ax.set_ylim(bottom, top)
        ax.set_aspect("equal")
        ax.tick_params(length=3.0, width=0.8)
    for number, ax in enumerate(axes[:panels]):
        if number % wide == 0:
            ax.set_ylabel("y [m]")
        if number >= panels - wide:
            ax.set_xlabel("x [m]")
    return figure, axes[:panels]


def _discs(axes: Axes, places: Floats, radii: Floats, faces: Floats, *, edge: float = 0.0) -> None:
    from matplotlib.collections import EllipseCollection

    size = 2.0 * radii
    axes.add_collection(
        EllipseCollection(
            size, size, np.zeros(len(size)), units="xy", offsets=places, offset_transform=axes.transData,
            facecolors=faces, edgecolors=0.62 * faces[:, :3], linewidths=edge, zorder=2.0, rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip


def _fills(flow: Flow) -> Floats:
    """Colours (n, 4): rigid ground grey, the rest by material."""
    from matplotlib.colors import to_rgba

    a = flow.simulation.assembly
    fills = np.array([to_rgba(material_colour(k)) for k in range(len(a.material_names))])
    faces = np.asarray(fills[a.material])
    faces[~flow.moving] = to_rgba(RIGID)
    return faces


def _striped(flow: Flow) -> Floats:
    """The same with darker stripes by the place across the mass at the hand-over."""
    faces = _fills(flow)
    own = flow.moving
    along = flow.start[own, 0]
    low, high = float(along.min()), float(along.max())
    band = np.minimum(((along - low) / (high - low) * BANDS).astype(int), BANDS - 1)
    shade = np.where(band % 2 == 0, 1.0, 0.72)
    faces[own, :3] *= shade[:, None]
    return faces


def _before(hand: HandOver, flow: Flow) -> bytes:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    source, a = hand.source, flow.simulation.assembly
    figure, (axes,) = _axes_of(_view(flow, flow.start[None]))
    corners = source.positions
    axes.triplot(*corners.T, source.triangles, color=FAINT, linewidth=0.4, zorder=0.5)
    _discs(axes, flow.start, a.radii, _fills(flow), edge=0.15)
    if len(source.slip_surface):
        axes.plot(*source.slip_surface.T, color=SLIP, linewidth=1.6, zorder=3.0, path_effects=halo(3.0))
    axes.plot(
        *source.centre, "+", color=INK, markersize=9.0, markeredgewidth=1.6, zorder=4.0, path_effects=halo()
    )
    axes.set_title("Handed over")
    axes.set_title(
        f"{int(flow.moving.sum()):,} discs of {source.mass:,.3g} kg/m, {int((~flow.moving).sum()):,} held",
        loc="right", fontsize=8.5, fontweight="normal", color=SOFT,
    )  # fmt: skip
    used = np.flatnonzero(source.material_mass > 0.0)
    handles: list[Any] = [Patch(color=material_colour(int(k)), label=source.materials[int(k)]) for k in used]
    handles += [
        Patch(color=RIGID, label="rigid ground"),
        Line2D([], [], color=SLIP, linewidth=1.6, label="slip surface"),
        Line2D([], [], color=INK, marker="+", linestyle="none", label="centre of gravity"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, columnspacing=1.6)
    return png(figure)


def _during(flow: Flow, places: Floats) -> bytes:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    looks = flow.looks
    kept = len(places)
    # moments at even shares of what the centre of gravity sinks
    every = (len(looks) - 1) / max(kept - 1, 1) if kept > 1 else 1.0
    sunk = np.array([looks[0].centre_y - look.centre_y for look in looks])
    shares = [0.2, 0.5, 0.8, 0.97][:MOMENTS]
    chosen = [int(np.argmax(sunk >= share * sunk[-1])) for share in shares]
    frames = [min(round(look / every), kept - 1) for look in chosen]
    frames = sorted(dict.fromkeys(frames)) or [kept - 1]
    figure, axes = _axes_of(_view(flow, places), len(frames))
    own, a = flow.moving, flow.simulation.assembly
    moved = np.hypot(*(places[:, own] - flow.start[own]).transpose(2, 0, 1))
    norm = Normalize(0.0, float(np.percentile(moved[-1], 99.0)) or 1.0)
    colours = displacement_colours()
    for ax, frame in zip(axes, frames, strict=True):
        faces = _fills(flow)
        faces[own] = colours(norm(moved[frame]))
        ax.plot(*flow.surface.T, color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)), zorder=1.0)
        _discs(ax, places[frame], a.radii, faces)
        when = looks[min(round(frame * every), len(looks) - 1)].time
        ax.set_title(f"{when:.3g} s")
    figure.colorbar(
        ScalarMappable(norm, colours), ax=axes, label="displacement [m]", extend="max", aspect=30.0, pad=0.02
    )
    return png(figure)


def _after(flow: Flow, deposit: Mapping[str, Any]) -> bytes:
    from matplotlib.lines import Line2D

    a, now = flow.simulation.assembly, flow.simulation.positions
    crest, front = np.array(deposit["crest_m"]), float(deposit["front_m"])
    tip = np.array([front, crest[1] - float(deposit["fall_height_m"])])
    left, right, bottom, top = _view(flow, np.stack([flow.start, now]))
    figure, (axes,) = _axes_of((left, right, min(bottom, tip[1] - 0.04 * (right - left)), top))
    axes.plot(*flow.surface.T, color=SOFT, linewidth=1.0, linestyle=(0, (4, 3)), zorder=1.5)
    _discs(axes, now, a.radii, _striped(flow), edge=0.1)
    axes.plot(*np.stack([crest, tip]).T, color=FAILED, linewidth=1.4, zorder=3.0, path_effects=halo(3.0))
    middle = 0.5 * (crest + tip)
    axes.annotate(
        f"angle of reach {deposit['angle_of_reach_deg']:.1f}°", middle, xytext=(0.0, 9.0),
        textcoords="offset points", color=FAILED, fontweight="bold", ha="left" if flow.downhill > 0 else "right",
        va="bottom", path_effects=halo(),
    )  # fmt: skip
    toe = front - flow.downhill * float(deposit["run_out_m"])
    low = tip[1] - 0.02 * (right - left)
    axes.annotate(
        "", (front, low), (toe, low), arrowprops={"arrowstyle": "<->", "color": INK, "linewidth": 1.0}
    )
    axes.annotate(
        f"run-out {deposit['run_out_m']:.3g} m", (0.5 * (front + toe), low), xytext=(0.0, -3.0),
        textcoords="offset points", ha="center", va="top", fontsize=8.5,
    )  # fmt: skip
    before = np.array([flow.looks[0].centre_x, flow.looks[0].centre_y])
    after = np.array(deposit["centre_m"])
    axes.annotate(
        "",
        (after[0], after[1]),
        (before[0], before[1]),
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.4},
        zorder=4.0,
    )
    axes.set_title("At rest" if flow.at_rest else f"After {flow.looks[-1].time:.3g} s")
    axes.set_title(
        f"{flow.looks[-1].time:.3g} s after the failure",
        loc="right",
        fontsize=8.5,
        fontweight="normal",
        color=SOFT,
    )
    handles = [
        Line2D([], [], color=SOFT, linestyle=(0, (4, 3)), label="surface before"),
        Line2D([], [], color=FAILED, label="crest to front"),
        Line2D([], [], color=INK, marker=">", label="centre of gravity"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return png(figure)


def _history(flow: Flow) -> bytes:
    looks = np.array(flow.looks)
    time, kinetic, potential, lost = looks[:, 0], looks[:, 3], looks[:, 4], looks[:, 6]
    figure = new_figure(WIDTH, 2.9)
    energy, front = figure.subplots(1, 2)
    for values, colour, name in (
        (potential, STABLE, "potential"), (kinetic, FAILED, "kinetic"), (lost, INK, "dissipated"),
    ):  # fmt: skip
        energy.plot(time, values / 1e3, color=colour, linewidth=1.5, label=name)
    energy.set_xlabel("time [s]")
    energy.set_ylabel("energy [kJ per m]")
    energy.set_title("Energy")
    energy.legend(loc="center right")
    way = flow.downhill * (looks[:, 7] - looks[0, 7])
    sunk = flow.downhill * (looks[:, 1] - looks[0, 1])
    front.plot(time, way, color=FAILED, linewidth=1.5, label="front")
    front.plot(time, sunk, color=STABLE, linewidth=1.5, label="centre of gravity")
    front.set_xlabel("time [s]")
    front.set_ylabel("way downhill [m]")
    front.set_title("Way")
    front.legend(loc="best")
    for axes in (energy, front):
        quiet_axes(axes)
    return png(figure)
