"""Pictures of a cut: fragments and cracks around the tool, forces over the way, where the work went, sizes of chips."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.cutting.course import Course, Frame
from geodem.cutting.outcome import Outcome
from geodem.measure.fragments import find_fragments
from geodem.plotting.particles import CRACKS
from geodem.plotting.theme import FAINT, INK, SOFT, new_figure, png, quiet_axes, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

WIDTH = 7.7
STEEL = "#4a5563"
GROUND, LOOSE = "#e4dac6", "#f2b134"
CHIPS = ("#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#8a6fb0", "#1b7f79", "#b5495b", "#6a994e")
"""Of the largest chips, then again."""
CUTTING, NORMAL = "#0b4f8a", "#c2410c"
STAGES = 3
BEHIND = 0.25
"""Of the ground's length, shown behind it at most."""
ENERGY_NAMES = {
    "elastic": "elastic", "kinetic": "kinetic", "broken": "in broken bonds", "friction": "friction",
    "damping": "damping",
}  # fmt: skip
ENERGY_COLOURS = ("#56b4e9", "#cc79a7", "#d55e00", "#e69f00", "#9aa5b1")


class Scale(NamedTuple):
    """A unit that fits: its name, and how many of it a metre is."""

    unit: str
    per_metre: float


def scale_of(size: float) -> Scale:
    """Millimetres up to 2 m, metres beyond."""
    return Scale("mm", 1e3) if size < 2.0 else Scale("m", 1.0)


def cutting_pictures(cut: Any, course: Course, found: Outcome) -> dict[str, bytes]:
    """All figures of a report, as PNG by name.

    Parameters
    ----------
    cut : geodem.cutting_building.Cut
    course : Course
    found : Outcome
    """
    with style():
        figures = {
            "stages": stages_figure(cut, course),
            "fragments": fragments_figure(cut, course, found),
            "forces": forces_figure(cut, course, found),
            "energy": energy_figure(cut, course),
        }
        if found.cut.any():
            figures["sizes"] = sizes_figure(cut, found)
        return {name: png(figure) for name, figure in figures.items()}


def start_picture(cut: Any) -> bytes:
    """Ground, supports and tool before anything moves."""
    with style():
        a, plan = cut.assembly, cut.plan
        box = _window(cut, cut.placed.end)
        figure, axes = _axes(box, scale_of(float(np.ptp(box[:, 0]))))
        scale = scale_of(float(np.ptp(box[:, 0])))
        held = a.held.any(axis=1)
        faces = np.tile(_rgba(GROUND), (a.particles, 1))
        faces[held] = _rgba("#a9b3bd")
        _discs(axes, a.positions, a.radii, faces, scale)
        _tool(axes, cut, 0.0, scale)
        y = cut.placed.place[1] * scale.per_metre
        ends = np.array([cut.placed.place[0], cut.placed.end]) * scale.per_metre
        axes.annotate(
            "", (ends[1], y), (ends[0], y), arrowprops={"arrowstyle": "->", "color": INK}, zorder=5.0
        )
        axes.set_title(f"{plan.tool.rake * 180.0 / np.pi:.3g} deg rake; grey particles are held")
        return png(figure)


def fragments_figure(cut: Any, course: Course, found: Outcome) -> Figure:
    """The end: pieces by colour, cracks over them."""
    box = _window(cut, cut.placed.place[0] + course.way)
    scale = scale_of(float(np.ptp(box[:, 0])))
    figure, axes = _axes(box, scale, legend=True)
    frame = course.frames[-1]
    _discs(axes, frame.positions, course.assembly.radii, piece_colours(cut, course, frame), scale)
    handles = _cracks(axes, course, frame, scale)
    _tool(axes, cut, frame.way, scale)
    axes.set_title(f"After {frame.way * scale.per_metre:.3g} {scale.unit}")
    axes.legend(
        handles=[*_piece_handles(found), *handles], loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3
    )
    return figure


def stages_figure(cut: Any, course: Course) -> Figure:
    """Three moments, one above the other."""
    frames = [course.frames[k] for k in np.unique(np.linspace(1, len(course.frames) - 1, STAGES).astype(int))]
    box = _window(cut, cut.placed.place[0] + course.way)
    scale = scale_of(float(np.ptp(box[:, 0])))
    wide, high = np.ptp(box, axis=0)
    figure = new_figure(WIDTH, len(frames) * ((WIDTH - 1.0) * high / wide + 0.42) + 0.5)
    rows = figure.subplots(len(frames), 1, sharex=True, squeeze=False)[:, 0]
    for axes, frame in zip(rows, frames, strict=True):
        _dress(axes, box, scale)
        _discs(axes, frame.positions, course.assembly.radii, piece_colours(cut, course, frame), scale)
        _tool(axes, cut, frame.way, scale)
        axes.set_title(
            f"{frame.way * scale.per_metre:.3g} {scale.unit}, {frame.time:.3g} s",
            fontweight="normal",
            fontsize=9.0,
        )
    for axes in rows[:-1]:
        axes.set_xlabel("")
    return figure


def piece_colours(cut: Any, course: Course, frame: Frame) -> Floats:
    """Colours (n, 4): ground that holds, single grains, chips by turns."""
    a = course.assembly
    f = find_fragments(frame.positions, a.radii, a.mass, a.bonds, ~frame.broken)
    held = a.held.any(axis=1)
    fixed = np.zeros(f.count, dtype=bool)
    fixed[np.unique(f.piece_of[held])] = True
    colours = np.tile(_rgba(GROUND), (f.count, 1))
    chips = np.flatnonzero(~fixed & ~f.single)
    colours[chips] = np.array([_rgba(CHIPS[k % len(CHIPS)]) for k in range(len(chips))]).reshape(-1, 4)
    colours[~fixed & f.single] = _rgba(LOOSE)
    return np.asarray(colours[f.piece_of])


def forces_figure(cut: Any, course: Course, found: Outcome) -> Figure:
    """Cutting and normal force over the way, and those on the face and the flat."""
    c = course.columns()
    scale = scale_of(cut.plan.distance)
    figure = new_figure(WIDTH, 5.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    way = c["way"] * scale.per_metre
    for axes, parts in ((upper, ("",)), (lower, ("_face", "_tip", "_flat"))):
        quiet_axes(axes)
        axes.axhline(0.0, color=SOFT, linewidth=0.8)
        axes.axvline(found.first * scale.per_metre, color=SOFT, linewidth=0.8, linestyle=(0, (4, 3)))
        for part, look in zip(parts, ("-", (0, (4, 1.5)), (0, (1, 1.2))), strict=False):
            for name, colour in (("cutting", CUTTING), ("normal", NORMAL)):
                values = c[name + part] * 1e-3
                if part and not np.abs(values).max(initial=0.0) > 0.0:
                    continue
                label = f"{name} force{part.replace('_', ' on the ')}"
                axes.plot(way, values, color=colour, linewidth=0.9, linestyle=look, label=label)
        axes.set_ylabel("force [kN/m]")
        axes.legend(loc="upper left", ncols=3)
        axes.margins(x=0.0)
        axes.set_ylim(top=axes.get_ylim()[1] * 1.25)
    if np.isfinite(found.cutting.mean):
        upper.plot(
            [found.first * scale.per_metre, way[-1]],
            2 * [1e-3 * found.cutting.mean],
            color=INK,
            linewidth=1.2,
        )
        upper.annotate(
            f"mean {1e-3 * found.cutting.mean:.3g} kN/m", (way[-1], 1e-3 * found.cutting.mean), (-4, 4),
            textcoords="offset points", ha="right", color=INK, fontsize=8.5,
        )  # fmt: skip
    upper.set_title("Forces of the ground on the tool; means are taken behind the dashed line")
    lower.set_xlabel(f"way of the tool [{scale.unit}]")
    return figure


def energy_figure(cut: Any, course: Course) -> Figure:
    """Where the work of the tool went, and the share that the account misses."""
    c = course.columns()
    scale = scale_of(cut.plan.distance)
    figure = new_figure(WIDTH, 3.4)
    axes = figure.add_subplot()
    quiet_axes(axes)
    way = c["way"] * scale.per_metre
    parts = [c[name] for name in ENERGY_NAMES]
    axes.stackplot(way, *parts, labels=list(ENERGY_NAMES.values()), colors=ENERGY_COLOURS, linewidth=0.0)
    axes.plot(way, c["tool"] + c["gravity"], color=INK, linewidth=1.3, label="work of tool and gravity")
    axes.set_xlabel(f"way of the tool [{scale.unit}]")
    axes.set_ylabel("energy [J/m]")
    axes.legend(loc="upper left")
    axes.margins(x=0.0)
    axes.set_title(f"Where the work went; the account is off by {100.0 * abs(c['imbalance'][-1]):.2g} %")
    return figure


def sizes_figure(cut: Any, found: Outcome) -> Figure:
    """Passing curve of what was cut off."""
    f = found.fragments
    scale = scale_of(cut.plan.distance)
    figure = new_figure(WIDTH, 3.0)
    axes = figure.add_subplot()
    quiet_axes(axes)
    size = np.unique(f.size[found.cut])
    passing = f.passing(size, found.cut)
    axes.step(size * scale.per_metre, 100.0 * passing, where="post", color=CUTTING, linewidth=1.6)
    axes.axvline(cut.plan.depth * scale.per_metre, color=SOFT, linestyle=(0, (4, 3)), linewidth=0.9)
    axes.annotate(
        "depth of cut",
        (cut.plan.depth * scale.per_metre, 4.0),
        (4, 0),
        textcoords="offset points",
        color=SOFT,
    )
    axes.set_xscale("log")
    axes.set_ylim(0.0, 103.0)
    axes.set_xlabel(f"size of piece [{scale.unit}]")
    axes.set_ylabel("passing by mass [%]")
    axes.set_title("Sizes of what was cut off, single grains included")
    return figure


# ------------------------------------------------------------------ parts of pictures


def _window(cut: Any, tip: float) -> Floats:
    """What is shown (2, 2) [m]: the ground and the tool, less of what is far below."""
    low, high = np.asarray(cut.scene.box, dtype=float)
    corners, _ = cut.plan.tool.outline()
    depth, diameter = cut.plan.depth, cut.placed.diameter
    left = min(low[0], cut.placed.place[0] + corners[:, 0].min()) - diameter
    # of a long tool the front is enough
    left = max(left, low[0] - BEHIND * float(high[0] - low[0]))
    top = max(cut.placed.place[1] + corners[:, 1].max(), high[1] + 2.0 * depth) + diameter
    return np.array([[left, low[1] - diameter], [high[0] + 2.0 * diameter, top]])


def _axes(box: Floats, scale: Scale, *, legend: bool = False) -> tuple[Figure, Axes]:
    wide, high = np.ptp(box, axis=0)
    figure = new_figure(WIDTH, min((WIDTH - 1.0) * high / wide, 8.0) + 1.15 + (0.6 if legend else 0.0))
    axes = figure.add_subplot()
    _dress(axes, box, scale)
    return figure, axes


def _dress(axes: Axes, box: Floats, scale: Scale) -> None:
    quiet_axes(axes)
    axes.grid(False)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(*(box[:, 0] * scale.per_metre))
    axes.set_ylim(*(box[:, 1] * scale.per_metre))
    axes.set_xlabel(f"x [{scale.unit}]")
    axes.set_ylabel(f"y [{scale.unit}]")


def _discs(axes: Axes, places: Floats, radii: Floats, faces: Floats, scale: Scale) -> None:
    from matplotlib.collections import EllipseCollection

    diameters = 2.0 * radii * scale.per_metre
    edges = 0.62 * faces
    edges[:, 3] = 1.0
    axes.add_collection(
        EllipseCollection(
            diameters, diameters, np.zeros(len(radii)), units="xy", offsets=places * scale.per_metre,
            offset_transform=axes.transData, facecolors=faces, edgecolors=edges, linewidths=0.25, zorder=2.0,
            rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip


def _tool(axes: Axes, cut: Any, way: float, scale: Scale) -> None:
    from matplotlib.patches import Polygon

    corners, _ = cut.plan.tool.outline()
    place = cut.placed.place + np.array([way, 0.0])
    axes.add_patch(
        Polygon(
            (corners + place) * scale.per_metre, facecolor=STEEL, edgecolor=INK, linewidth=1.0, zorder=3.5
        )
    )


def _cracks(axes: Axes, course: Course, frame: Frame, scale: Scale) -> list[Any]:
    """Bonds that broke and whose particles are still near, as short lines across."""
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    s, a = course.simulation, course.assembly
    broken = s.broken_bonds()
    pairs = a.bonds[broken.bond]
    places, radii = frame.positions[pairs], a.radii[pairs]
    apart = places[:, 1] - places[:, 0]
    distance = np.hypot(*apart.T)
    near = distance < 1.4 * radii.sum(axis=1)
    across = np.column_stack([-apart[:, 1], apart[:, 0]]) / distance[:, None]
    middle = 0.5 * places.sum(axis=1)
    half = 0.65 * radii.min(axis=1)[:, None] * across
    ends = np.stack([middle - half, middle + half], axis=1) * scale.per_metre
    handles = []
    for mode, (colour, name) in CRACKS.items():
        own = broken.mode == mode
        axes.add_collection(
            LineCollection(list(ends[near & own]), colors=colour, linewidths=0.8, zorder=3.0), autolim=False
        )
        if own.any():
            handles.append(Line2D([], [], color=colour, linewidth=2.0, label=f"{name} ({int(own.sum()):,})"))
    return handles


def _piece_handles(found: Outcome) -> list[Any]:
    from matplotlib.patches import Patch

    chips, grains = int(found.chips.sum()), int((found.cut & found.fragments.single).sum())
    handles = [Patch(facecolor=GROUND, edgecolor=FAINT, label="ground")]
    if chips:
        handles.append(Patch(facecolor=CHIPS[0], label=f"chips, by turns ({chips:,})"))
    if grains:
        handles.append(Patch(facecolor=LOOSE, label=f"single grains ({grains:,})"))
    return handles


def _rgba(colour: str) -> Any:
    from matplotlib.colors import to_rgba

    return np.array(to_rgba(colour))
