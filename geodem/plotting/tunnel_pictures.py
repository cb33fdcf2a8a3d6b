"""Pictures of a tunnel: its yielded zone, displacements, ground reaction curve, lining forces, and the check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geodem.plotting.drawing import draw_loads, draw_materials, draw_supports, section_figure
from geodem.plotting.scenes import deformation_scale
from geodem.plotting.theme import (
    FAILED,
    INK,
    PAPER,
    SLIP,
    SOFT,
    displacement_colours,
    halo,
    material_colour,
    new_figure,
    png,
    quiet_axes,
    strain_colours,
    style,
)
from geodem.plotting.tunnel_views import BoltView, LiningView, TunnelView
from geodem.plotting.views import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINING, BOLT, FAR = "#0b4f8a", "#00755b", "#8794a1"


def tunnel_pictures(view: TunnelView) -> dict[str, bytes]:
    """PNGs by name: "reaction", "yielded", "displacement", and where there is any, "lining" and "failure-KIND"."""
    with style():
        made = {
            "reaction": png(reaction_chart(view)),
            "yielded": png(yielded_figure(view)),
            "displacement": png(displacement_figure(view)),
        }
        for lining in view.linings:
            made[f"lining-{lining.name}"] = png(lining_figure(view, lining))
        for failure in view.failures:
            made[f"failure-{failure.kind}"] = png(failure_figure(view, failure.strain, failure.factor))
    return made


def check_picture(view: TunnelView) -> bytes:
    """The section as it will be dug: particles, openings, supports, stress."""
    with style():
        return png(check_figure(view))


def reaction_chart(view: TunnelView) -> Figure:
    """Pressure on the wall against mean convergence: the ground's curve, the supported path, the support's line."""
    figure = new_figure(7.0, 4.4)
    axes = figure.add_subplot()
    quiet_axes(axes)
    supported = any(row["lining_pressure"] > 0.0 for row in view.rows) or bool(view.bolts)
    first = view.rows[0]["opening"] if view.rows else ""
    curve = [row for row in (view.reaction or view.rows) if row["opening"] == first]
    name = "ground reaction curve" if view.reaction or not supported else "supported"
    _line(axes, curve, "pressure", INK, name, marker="o")
    if view.reaction and supported:
        rows = [row for row in view.rows if row["opening"] == first]
        installed = [row for row in rows if row["lining_pressure"] > 0.0]
        if installed:
            begin = rows[rows.index(installed[0]) - 1] if rows.index(installed[0]) else installed[0]
            _line(
                axes,
                [begin, *installed],
                "lining_pressure",
                LINING,
                "pressure that the lining bears",
                marker="s",
            )
            last = installed[-1]
            axes.plot(
                1e3 * last["mean"], last["lining_pressure"] / 1e6, marker="*", markersize=15, color=SLIP,
                markeredgecolor=PAPER, linestyle="none", zorder=6,
                label=f"equilibrium: {last['lining_pressure'] / 1e6:.3g} MPa at {1e3 * last['mean']:.3g} mm",
            )  # fmt: skip
        else:
            _line(axes, rows, "pressure", LINING, "with supports", marker="s")
    if view.collapse is not None and not view.reaction:
        level = view.collapse["pressure_failed"] / 1e6
        axes.axhline(level, color=FAILED, linewidth=1.2, linestyle=(0, (5, 3)))
        axes.annotate(
            f"no rest below {1e3 * level:.4g} kPa", (0.98, level), xycoords=("axes fraction", "data"),
            xytext=(0, 4), textcoords="offset points", ha="right", color=FAILED, fontsize=8.5,
        )  # fmt: skip
    axes.set_xlabel("mean convergence of the wall [mm]")
    axes.set_ylabel("mean pressure on the wall [MPa]")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_title("Ground reaction")
    axes.legend(loc="upper right")
    return figure


def _line(
    axes: Axes, rows: Sequence[Mapping[str, Any]], key: str, colour: str, name: str, *, marker: str
) -> None:
    axes.plot(
        [1e3 * row["mean"] for row in rows], [row[key] / 1e6 for row in rows], color=colour, linewidth=1.8,
        marker=marker, markersize=3.6, markeredgecolor=PAPER, markeredgewidth=0.5, label=name, zorder=4,
    )  # fmt: skip


def _near_figure(view: TunnelView, title: str) -> tuple[Figure, Axes]:
    left, bottom, right, top = view.window
    wide, high = right - left, top - bottom
    width = 6.4
    figure = new_figure(width, float(np.clip((width - 0.9) * high / wide + 1.2, 2.6, 7.6)))
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.tick_params(length=3.0)
    axes.set_title(title)
    return figure, axes


def yielded_figure(view: TunnelView) -> Figure:
    """Plastic shear strain around the openings, with the rim of what has yielded."""
    figure, axes = _near_figure(view, "Yielded ground")
    _shade(figure, axes, view, 100.0 * view.strain, strain_colours(), "plastic shear strain [%]", power=0.6)
    if (view.yielded > 0.5).any() and (view.yielded < 0.5).any():
        axes.tricontour(
            _triangles(view), view.yielded, levels=[0.5], colors=[INK], linewidths=1.0, linestyles="--"
        )
        axes.plot([], [], color=INK, linewidth=1.0, linestyle="--", label="rim of the yielded ground")
    _draw_built(axes, view)
    _legend(axes)
    return figure


def displacement_figure(view: TunnelView) -> Figure:
    """Size of the displacement, arrows, and the wall as it moved, enlarged."""
    figure, axes = _near_figure(view, "Displacement")
    size = np.hypot(*view.displacement.T)
    factor, unit = (1e3, "mm") if size.max(initial=0.0) < 0.2 else (1.0, "m")
    _shade(figure, axes, view, factor * size, displacement_colours(), f"displacement [{unit}]", power=1.0)
    scale = deformation_scale(view.positions, view.displacement, share=0.02)
    if scale:
        _moved_walls(axes, view, scale)
    _arrows(axes, view)
    _draw_built(axes, view)
    _legend(axes)
    return figure


def failure_figure(view: TunnelView, strain: Floats, factor: float) -> Figure:
    """Plastic shear strain of the lowest failed state over the whole section."""
    low, high = view.positions.min(axis=0), view.positions.max(axis=0)
    wide, tall = high - low
    figure = new_figure(6.4, float(np.clip(5.6 * tall / wide + 1.2, 2.6, 7.6)))
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(f"As it fails at a factor of {factor:.4g}")
    _shade(
        figure, axes, view, 100.0 * strain, strain_colours(), "plastic shear strain [%]", power=0.5, top=99.0
    )
    _draw_built(axes, view)
    return figure


def lining_figure(view: TunnelView, lining: LiningView) -> Figure:
    """Thrust and moment drawn outwards from the axis of a lining."""
    figure = new_figure(7.6, 4.2)
    data = (
        ("Thrust", lining.thrust / 1e3, lining.thrust_at, "kN per m"),
        ("Moment", lining.moment / 1e3, lining.moment_at, "kN m per m"),
    )
    for place, (title, values, at, unit) in enumerate(data, start=1):
        axes = figure.add_subplot(1, 2, place)
        axes.set_aspect("equal", adjustable="datalim")
        axes.plot(*lining.axis.T, color=INK, linewidth=1.6)
        axes.set_xlabel("x [m]")
        if place == 1:
            axes.set_ylabel("y [m]")
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
        axes.set_title(f"{title}: {low:.4g} to {high:.4g} {unit}", fontsize=9.0)
        largest = float(np.abs(values).max(initial=0.0))
        if largest > 0.0:
            size = 0.25 * float(np.ptp(lining.axis, axis=0).max())
            outwards = _outwards(lining.axis, at)
            tips = at + outwards * (values / largest * size)[:, None]
            for foot, tip in zip(at, tips, strict=True):
                axes.plot(*np.array([foot, tip]).T, color=LINING, linewidth=0.5, alpha=0.7)
            closed = bool((lining.axis[0] == lining.axis[-1]).all())
            axes.plot(*(np.concatenate([tips, tips[:1]]) if closed else tips).T, color=LINING, linewidth=1.2)
    return figure


def _outwards(axis: Floats, at: Floats) -> Floats:
    """Unit normals of a lining's axis at points on it, to the right of its direction reversed: into the ground."""
    middle = 0.5 * (axis[1:] + axis[:-1])
    along = axis[1:] - axis[:-1]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
    nearest = [int(np.argmin(np.hypot(*(middle - point).T))) for point in at]
    return normal[nearest]


def check_figure(view: TunnelView) -> Figure:
    """The section with its particles, what will be dug and built, and the stress before."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, Polygon

    ground = view.ground
    figure, axes = section_figure(ground, loads=True, extra=1.5)
    draw_materials(axes, ground, fade=0.2)
    draw_supports(axes, ground)
    draw_loads(axes, ground)
    low, high = ground.positions.min(axis=0), ground.positions.max(axis=0)
    size = float(np.clip(1.6 * np.sqrt(4000.0 / len(ground.positions)), 0.5, 3.0))
    across, up = ground.positions.T
    axes.scatter(across, up, s=size, color=SOFT, linewidths=0, zorder=2.2, rasterized=True)
    handles: list[Any] = [
        Patch(facecolor=material_colour(k), edgecolor="#8794a1", label=name)
        for k, name in enumerate(ground.materials)
    ]
    for name, outline in view.openings:
        axes.add_patch(
            Polygon(
                outline, facecolor=(1, 1, 1, 0.7), edgecolor=SLIP, linewidth=1.6, hatch="....", zorder=3.0
            )
        )
        handles.append(Patch(facecolor=PAPER, edgecolor=SLIP, hatch="....", label=f"dug out: {name}"))
    for lining in view.linings:
        axes.plot(*lining.axis.T, color=LINING, linewidth=2.6, zorder=4.0)
        handles.append(Line2D([], [], color=LINING, linewidth=2.6, label=f"lining: {lining.name}"))
    for bolts in view.bolts:
        for bar in bolts.bars:
            axes.plot(*bar.T, color=BOLT, linewidth=1.4, zorder=4.0)
        handles.append(Line2D([], [], color=BOLT, linewidth=1.4, label=f"bolts: {bolts.name}"))
    far = [side for side, support in ground.supports.items() if support == "far"]
    for side in far:
        x = {"left": low[0], "right": high[0]}.get(side)
        y = {"bottom": low[1], "top": high[1]}.get(side)
        ends = ([x, x], [low[1], high[1]]) if x is not None else ([low[0], high[0]], [y, y])
        axes.plot(*ends, color=FAR, linewidth=2.4, linestyle=(0, (1, 1.2)), zorder=3.0)
    if far:
        handles.append(
            Line2D([], [], color=FAR, linewidth=2.4, linestyle=(0, (1, 1.2)), label="the ground goes on")
        )
    _stress_arrows(axes, view, low, high)
    axes.set_title(ground.title)
    figure.legend(handles=handles, loc="outside lower center", ncols=3, borderpad=0.9)
    return figure


def _stress_arrows(axes: Axes, view: TunnelView, low: Floats, high: Floats) -> None:
    """Horizontal and vertical stress as pairs of arrows in a corner, their lengths in proportion."""
    size = float((high - low).max())
    if "k0" in view.stress:
        horizontal, vertical = view.stress["k0"], 1.0
        words = (f"K0 = {horizontal:g}", "weight")
    else:
        horizontal, vertical = view.stress["horizontal"], view.stress["vertical"]
        words = (f"{horizontal / 1e6:.3g} MPa", f"{vertical / 1e6:.3g} MPa")
    largest = max(horizontal, vertical) or 1.0
    reach, gap = 0.09 * size, 0.022 * size
    at = np.array([high[0] - 0.16 * size, high[1] - 0.16 * size])
    arrow = {
        "arrowstyle": "-|>,head_width=0.2,head_length=0.35",
        "color": INK,
        "linewidth": 1.3,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    for direction, value in (((1.0, 0.0), horizontal), ((0.0, 1.0), vertical)):
        along = np.asarray(direction)
        for sign in (-1.0, 1.0):
            tip = at + sign * gap * along
            tail = tip + sign * reach * value / largest * along
            axes.annotate("", xy=tuple(tip), xytext=tuple(tail), arrowprops=arrow, zorder=6.0)
    rim = halo(3.0)
    axes.annotate(
        words[0], (at[0], at[1] - gap), xytext=(0, -14), textcoords="offset points", ha="center", fontsize=8.0,
        path_effects=rim, zorder=6.0,
    )  # fmt: skip
    axes.annotate(
        words[1], (at[0] + gap, at[1] + gap + 0.5 * reach), xytext=(4, 0), textcoords="offset points", va="center",
        fontsize=8.0, path_effects=rim, zorder=6.0,
    )  # fmt: skip


def _triangles(view: TunnelView) -> Any:
    from matplotlib.tri import Triangulation

    return Triangulation(view.positions[:, 0], view.positions[:, 1], view.triangles)


def _shade(
    figure: Figure, axes: Axes, view: TunnelView, values: Floats, colours: Any, label: str, *, power: float,
    top: float = 100.0,
) -> None:  # fmt: skip
    from matplotlib.colors import PowerNorm

    highest = float(np.percentile(values, top)) if len(values) else 1.0
    highest = highest if highest > 0.0 else max(float(values.max(initial=0.0)), 1e-12)
    shaded = axes.tripcolor(
        _triangles(view), np.clip(values, 0.0, None), shading="gouraud", cmap=colours,
        norm=PowerNorm(power, vmin=0.0, vmax=highest), zorder=1.0, rasterized=True,
    )  # fmt: skip
    bar = figure.colorbar(
        shaded, ax=axes, location="bottom", shrink=0.65, aspect=34, pad=0.03,
        extend="max" if values.max(initial=0.0) > highest * (1.0 + 1e-9) else "neither",
    )  # fmt: skip
    bar.set_label(label)
    bar.outline.set_visible(False)


def _draw_built(axes: Axes, view: TunnelView) -> None:
    for _, outline in view.openings:
        axes.plot(*outline.T, color=INK, linewidth=1.0, zorder=3.0)
    for lining in view.linings:
        axes.plot(*lining.axis.T, color=LINING, linewidth=3.0, zorder=3.5, label=f"lining: {lining.name}")
    for bolts in view.bolts:
        _draw_bolts(axes, bolts)


def _draw_bolts(axes: Axes, bolts: BoltView) -> None:
    for number, bar in enumerate(bolts.bars):
        axes.plot(
            *bar.T,
            color=BOLT,
            linewidth=1.5,
            zorder=3.6,
            label=f"bolts: {bolts.name}" if number == 0 else None,
        )
    yielded = np.abs(bolts.force) > 0.999 * bolts.yield_force
    if yielded.any():
        axes.plot(*bolts.at[yielded].T, "x", color=FAILED, markersize=5.0, zorder=3.8, label="bolt yields")


def _moved_walls(axes: Axes, view: TunnelView, scale: float) -> None:
    from scipy.spatial import cKDTree

    tree = cKDTree(view.positions)
    near = float(np.median(np.asarray(tree.query(view.positions, k=2)[0])[:, 1]))
    for number, (_, outline) in enumerate(view.openings):
        far, nearest = (np.asarray(found) for found in tree.query(outline))
        on = far < near
        moved = outline[on] + scale * view.displacement[nearest[on]]
        axes.plot(
            *moved.T, color=SLIP, linewidth=1.4, zorder=3.4,
            label=f"wall, displacements × {scale:g}" if number == 0 else None,
        )  # fmt: skip


def _arrows(axes: Axes, view: TunnelView) -> None:
    left, bottom, right, top = view.window
    cell = max(right - left, top - bottom) / 14.0
    inside = np.flatnonzero(
        (view.positions[:, 0] >= left)
        & (view.positions[:, 0] <= right)
        & (view.positions[:, 1] >= bottom)
        & (view.positions[:, 1] <= top)
    )
    if not len(inside):
        return
    grid = np.floor(view.positions[inside] / cell).astype(np.int64)
    away = np.hypot(*(view.positions[inside] / cell - grid - 0.5).T)
    order = np.lexsort((inside, away))
    _, first = np.unique(grid[order], axis=0, return_index=True)
    at = inside[order[first]]
    longest = float(np.hypot(*view.displacement[inside].T).max())
    if longest <= 0.0:
        return
    vectors = view.displacement[at] * (0.9 * cell / longest)
    axes.quiver(
        *view.positions[at].T, *vectors.T, angles="xy", scale_units="xy", scale=1.0, facecolor=PAPER, edgecolor=INK,
        linewidth=0.35, width=0.004, headwidth=3.8, headlength=4.4, zorder=3.2,
    )  # fmt: skip


def _legend(axes: Axes) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="upper right", fontsize=7.5, framealpha=0.85, frameon=True, edgecolor="none", facecolor=PAPER
        )
