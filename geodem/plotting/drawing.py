"""The pieces that pictures of a section are drawn from: ground, supports, loads, surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.plotting.theme import INK, OTHER_CIRCLES, PAPER, SLIP, SOFT, halo, material_colour, new_figure
from geodem.plotting.views import Floats, ReportView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIDES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}
"""Side of the section: axis across it, and whether it lies at the lower (0) or upper (1) bound."""


def section_figure(
    view: ReportView, *, width: float = 7.7, loads: bool = False, extra: float = 0.9
) -> tuple[Figure, Axes]:
    """A figure with one axes in metres, true to scale, as high as the section needs.

    Parameters
    ----------
    view : ReportView
    width : float [inch]
    loads : bool
        Leave room over the ground for the arrows of surcharges.
    extra : float [inch]
        Height for title, axis and legend.
    """
    low, high = view.positions.min(axis=0), view.positions.max(axis=0)
    size = float((high - low).max())
    pad = 0.045 * size
    above = 0.0
    if loads and view.surcharges:
        above = max(0.0, max(max(a[1], b[1]) for a, b, _ in view.surcharges) - high[1] + 0.045 * size) / size
    room = high - low + 2.0 * pad + np.array([0.0, above * size])
    height = float(np.clip((width - 0.8) * room[1] / room[0] + extra, 2.2, 1.25 * width))
    figure = new_figure(width, height)
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad + above * size)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.tick_params(length=3.0)
    return figure, axes


def draw_materials(axes: Axes, view: ReportView, *, edges: bool = True, fade: float = 0.0) -> None:
    """The regions in light fills with thin edges; `fade` 0..1 takes the fills towards paper."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    def fill(index: int) -> Any:
        return tuple((1.0 - fade) * np.array(to_rgb(material_colour(index))) + fade * np.ones(3))

    if not view.outlines:
        colours = [fill(int(index)) for index in range(max(len(view.materials), 1))]
        draw_triangles(axes, view, colours)
        return
    names = list(view.materials)
    for material, rings in view.outlines:
        vertices, codes = [], []
        for ring in rings:
            closed = np.concatenate([np.asarray(ring)[:, :2], np.asarray(ring)[:1, :2]])
            vertices.append(closed)
            codes += [Path.MOVETO] + [Path.LINETO] * (len(closed) - 2) + [Path.CLOSEPOLY]
        index = names.index(material) if material in names else len(names)
        axes.add_patch(
            PathPatch(
                Path(np.concatenate(vertices), codes),
                facecolor=fill(index),
                edgecolor="#8794a1" if edges else "none",
                linewidth=0.6,
                zorder=1.0,
            )
        )


def draw_triangles(axes: Axes, view: ReportView, colours: Sequence[Any]) -> None:
    """The triangles, each in the colour of its material."""
    from matplotlib.collections import PolyCollection

    faces = [colours[int(index) % len(colours)] for index in view.triangle_material]
    axes.add_collection(
        PolyCollection(
            list(view.positions[view.triangles]),
            facecolors=faces,
            edgecolors=faces,
            linewidths=0.3,
            zorder=1.0,
        ),
        autolim=False,
    )


def outline_segments(triangles: NDArray[np.integer]) -> NDArray[np.integer]:
    """Edges (b, 2) that only one triangle has."""
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return unique[count == 1]


def outline_rings(triangles: NDArray[np.integer]) -> list[NDArray[np.int64]]:
    """The outline as closed chains of particles, first one repeated at the end."""
    links: dict[int, list[int]] = {}
    for one, two in outline_segments(triangles).tolist():
        links.setdefault(one, []).append(two)
        links.setdefault(two, []).append(one)
    rings = []
    while links:
        start = min(links)
        ring, here = [start], start
        while links.get(here):
            onward = links[here].pop()
            links[onward].remove(here)
            ring.append(onward)
            here = onward
        links = {particle: others for particle, others in links.items() if others}
        rings.append(np.array(ring, dtype=np.int64))
    return rings


def draw_outline(axes: Axes, positions: Floats, triangles: NDArray[np.integer], **line: Any) -> None:
    """The outline of the ground."""
    options = {"color": INK, "linewidth": 1.0, "zorder": 3.0, "solid_joinstyle": "round", **line}
    for ring in outline_rings(triangles):
        axes.plot(*positions[ring].T, **options)


def side_spans(view: ReportView, side: str) -> list[tuple[float, float]]:
    """Stretches of the outline that lie on a side of the section: (from, to) along it [m]."""
    across, upper = SIDES[side]
    positions = view.positions
    bound = positions[:, across].max() if upper else positions[:, across].min()
    edges = outline_segments(view.triangles)
    lengths = np.hypot(*(positions[edges[:, 0]] - positions[edges[:, 1]]).T)
    near = np.abs(positions[edges][:, :, across] - bound).max(axis=1) < 0.05 * np.median(lengths)
    stretches = np.sort(positions[edges[near]][:, :, 1 - across], axis=1)
    spans: list[tuple[float, float]] = []
    for low, high in stretches[np.argsort(stretches[:, 0])].tolist():
        if spans and low <= spans[-1][1] + 1e-9:
            spans[-1] = (spans[-1][0], max(high, spans[-1][1]))
        else:
            spans.append((low, high))
    return spans


def draw_supports(axes: Axes, view: ReportView) -> None:
    """Fixed sides as a hatched wall, rollers as wheels against a wall; free sides stay bare."""
    from matplotlib.collections import EllipseCollection
    from matplotlib.patches import Rectangle

    size = float(np.ptp(view.positions, axis=0).max())
    wheel, wall = 0.012 * size, 0.014 * size
    for side, kind in view.supports.items():
        if side not in SIDES or kind not in ("fixed", "roller"):
            continue
        across, upper = SIDES[side]
        sign = 1.0 if upper else -1.0
        bound = view.positions[:, across].max() if upper else view.positions[:, across].min()
        for low, high in side_spans(view, side):
            face = bound
            if kind == "roller":
                count = max(int((high - low) / (1.7 * wheel)), 1)
                along = low + (np.arange(count) + 0.5) * (high - low) / count
                centre = np.full(count, bound + sign * 0.5 * wheel)
                wheels = np.column_stack([along, centre] if across else [centre, along])
                axes.add_collection(
                    EllipseCollection(
                        np.full(count, wheel), np.full(count, wheel), np.zeros(count), units="xy",
                        offsets=wheels, offset_transform=axes.transData,
                        facecolors=PAPER, edgecolors=SOFT, linewidths=0.7, zorder=2.5,
                    ),
                    autolim=False,
                )  # fmt: skip
                face = bound + sign * wheel
            start = face if upper else face - wall
            corner, sides = (
                ((low, start), (high - low, wall)) if across else ((start, low), (wall, high - low))
            )
            axes.add_patch(
                Rectangle(
                    corner,
                    *sides,
                    facecolor=PAPER,
                    edgecolor="#8794a1",
                    hatch="//////",
                    linewidth=0,
                    zorder=2.4,
                )
            )
            ends = [[low, high], [face, face]] if across else [[face, face], [low, high]]
            axes.plot(*ends, color=SOFT, linewidth=1.1, zorder=2.6, solid_capstyle="butt")


def draw_loads(axes: Axes, view: ReportView) -> None:
    """Surcharges as rows of arrows onto the ground, a pseudo-static acceleration as one arrow."""
    size = float(np.ptp(view.positions, axis=0).max())
    reach = 0.045 * size
    arrow = {
        "arrowstyle": "-|>,head_width=0.16,head_length=0.3",
        "color": INK,
        "linewidth": 0.9,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    for start, end, pressure in view.surcharges:
        ends = np.array([start, end], dtype=float)
        along = ends[1] - ends[0]
        length = float(np.hypot(*along))
        if length == 0.0:
            continue
        normal = np.array([-along[1], along[0]]) / length
        normal = normal if normal[1] > 0 or (normal[1] == 0 and normal[0] > 0) else -normal
        for share in np.linspace(0.0, 1.0, max(int(length / (0.025 * size)), 2)):
            foot = ends[0] + share * along
            axes.annotate(
                "", xy=tuple(foot), xytext=tuple(foot + reach * normal), arrowprops=arrow, zorder=5.0
            )
        axes.plot(*(ends + reach * normal).T, color=INK, linewidth=0.9, zorder=5.0)
        axes.annotate(
            f"{pressure / 1e3:g} kPa", tuple(ends.mean(axis=0) + reach * normal), xytext=(0, 3),
            textcoords="offset points", ha="center", va="bottom", fontsize=8.5, zorder=5.0,
        )  # fmt: skip
    if view.horizontal_acceleration:
        sign = float(np.sign(view.horizontal_acceleration))
        high, low = view.positions.max(axis=0), view.positions.min(axis=0)
        # beside the slope, over the lower ground, where there is air
        third = (high[0] - low[0]) / 3.0
        tops = [
            view.positions[np.abs(view.positions[:, 0] - end) < third, 1].max() for end in (low[0], high[0])
        ]
        middle = low[0] + 0.5 * third if tops[0] <= tops[1] else high[0] - 0.5 * third
        reach, level = sign * 0.07 * size, float(high[1] - 0.06 * size)
        axes.annotate(
            "", xy=(middle + reach, level), xytext=(middle - reach, level),
            arrowprops={**arrow, "linewidth": 1.6}, zorder=5.0,
        )  # fmt: skip
        axes.annotate(
            f"{abs(view.horizontal_acceleration):.3g} m/s²", (middle, level), xytext=(0, 4),
            textcoords="offset points", ha="center", va="bottom", fontsize=8.5, zorder=5.0,
        )  # fmt: skip


def draw_slip_surface(axes: Axes, surface: Floats, *, label: str = "slip surface, traced") -> None:
    """The traced surface, a strong line with a halo."""
    if len(surface):
        axes.plot(*surface.T, color=SLIP, linewidth=2.2, label=label, path_effects=halo(4.0), zorder=4.5)


def draw_neighbours(axes: Axes, neighbours: Sequence[Mapping[str, Any]]) -> None:
    """Surfaces of other methods, dashed; where several all but coincide, one line with all names."""
    from shapely import LineString

    groups: list[tuple[Floats, list[str]]] = []
    for neighbour in neighbours:
        surface = np.asarray(neighbour.get("surface", ()), dtype=float).reshape(-1, 2)
        if len(surface) < 2:
            continue
        name = f"{neighbour.get('method', 'other method')} ({float(neighbour['factor']):.2f})"
        near = 0.015 * float(np.ptp(surface, axis=0).max())
        for known, names in groups:
            if LineString(known).hausdorff_distance(LineString(surface)) < near:
                names.append(name)
                break
        else:
            groups.append((surface, [name]))
    dashes = ((0, (6, 2.5)), (0, (2, 1.6)), (0, (6, 2, 1.5, 2)))
    for index, (surface, names) in enumerate(groups):
        axes.plot(
            *surface.T,
            color=OTHER_CIRCLES[index % len(OTHER_CIRCLES)],
            linewidth=1.7,
            linestyle=dashes[index % len(dashes)],
            label=", ".join(names),
            zorder=4.6,
        )


def moving_polygons(view: ReportView, moving: NDArray[np.bool_], surface: Floats) -> list[Floats]:
    """The moving mass as rings (k, 2) [m]: the ground cut along the slip surface, the side that moves.

    Where there is no surface to cut along, the triangles that move.
    """
    from shapely import LineString, Polygon, contains_xy, linestrings, polygonize, union_all

    edges = linestrings(view.positions[outline_segments(view.triangles)])
    if len(surface) >= 2:
        step = np.hypot(*(surface[1] - surface[0])) or 1.0
        before = surface[0] + (surface[0] - surface[1]) / step * 1e-3 * step
        after = surface[-1] + (surface[-1] - surface[-2]) / step * 1e-3 * step
        cut = LineString(np.concatenate([[before], surface, [after]]))
        parts = polygonize([union_all([*edges, cut])]).geoms
        rings = []
        for part in parts:
            inside = contains_xy(part, *view.positions.T)
            if inside.any() and moving[inside].mean() > 0.5 and part.area > 0.0:
                rings.append(np.array(part.exterior.coords))
        if rings:
            return rings
    moved = view.triangles[moving[view.triangles].all(axis=1)]
    if not len(moved):
        return []
    whole = union_all([Polygon(corners) for corners in view.positions[moved]])
    return [np.array(part.exterior.coords) for part in getattr(whole, "geoms", [whole])]
