"""Pictures of a section: materials, particles, the failed state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError
from geodem.measure.failure import Failure
from geodem.plotting.drawing import (
    draw_loads,
    draw_materials,
    draw_neighbours,
    draw_outline,
    draw_slip_surface,
    draw_supports,
    moving_polygons,
    section_figure,
)
from geodem.plotting.theme import (
    INK,
    PAPER,
    SLIP,
    SOFT,
    displacement_colours,
    material_colour,
    strain_colours,
)
from geodem.plotting.views import Floats, ReportView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure


def failure_scene(
    view: ReportView, failure: Failure, neighbours: Sequence[Mapping[str, Any]] = ()
) -> tuple[Figure, float]:
    """The failed state in one picture: materials, moving mass, slip surface, other methods' surfaces.

    Parameters
    ----------
    view : ReportView
    failure : Failure
    neighbours : sequence of dict
        method, factor, surface (k, 2) [m].

    Returns
    -------
    Figure
    float
        How many times the displacements of the deformed outline are drawn [-]; 0 where none is drawn.
    """
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, Polygon

    figure, axes = section_figure(view, loads=True, extra=1.3)
    draw_materials(axes, view)
    draw_supports(axes, view)
    draw_loads(axes, view)
    handles: list[Any] = [
        Patch(facecolor=material_colour(index), edgecolor="#8794a1", label=name)
        for index, name in enumerate(view.materials)
    ]
    rings = moving_polygons(view, failure.moving, failure.slip_surface) if failure.moving.any() else []
    for ring in rings:
        axes.add_patch(
            Polygon(
                ring,
                facecolor=(*_rgb(SLIP), 0.10),
                edgecolor=(*_rgb(SLIP), 0.45),
                hatch="////",
                linewidth=0.0,
                zorder=2.0,
            )
        )
    if rings:
        handles.append(
            Patch(
                facecolor=(*_rgb(SLIP), 0.10),
                edgecolor=(*_rgb(SLIP), 0.45),
                hatch="////",
                label="moving mass",
            )
        )
    scale = deformation_scale(view.positions, failure.displacement)
    draw_outline(axes, view.positions, view.triangles, color="#8794a1", linewidth=0.8)
    if scale:
        deformed = view.positions + scale * failure.displacement
        draw_outline(axes, deformed, view.triangles, linewidth=1.2, zorder=3.5)
        handles.append(Line2D([], [], color=INK, linewidth=1.2, label=f"outline, displacements × {scale:g}"))
    draw_slip_surface(axes, failure.slip_surface)
    draw_neighbours(axes, neighbours)
    handles += axes.get_legend_handles_labels()[0]
    _legend_below(figure, handles)
    return figure, scale


def displacement_scene(view: ReportView, failure: Failure) -> Figure:
    """Magnitude of the displacement from the settled state, with arrows where the ground moves."""
    figure, axes = section_figure(view, width=5.6, extra=1.25)
    magnitude = np.hypot(*failure.displacement.T)
    factor, unit = _length_unit(float(magnitude.max()))
    _field(
        figure, axes, view, magnitude * factor, displacement_colours(), f"displacement [{unit}]", top=100.0
    )
    draw_slip_surface(axes, failure.slip_surface)
    _arrows(axes, view, failure)
    return figure


def strain_scene(view: ReportView, failure: Failure) -> Figure:
    """Plastic shear strain accumulated in the failing trial."""
    figure, axes = section_figure(view, width=5.6, extra=1.25)
    # a thin layer shears far more than the band above it: the root keeps both in sight
    _field(
        figure,
        axes,
        view,
        failure.plastic_shear_strain,
        strain_colours(),
        "plastic shear strain [-] (colours over its root)",
        top=99.5,
        power=0.5,
    )
    if len(failure.slip_surface):
        axes.plot(*failure.slip_surface.T, color=INK, linewidth=1.0, linestyle=(0, (4, 2)), zorder=4.5)
    return figure


def particles_scene(view: ReportView, *, width: float = 7.7, title: str = "") -> Figure:
    """The particles on their materials, with supports and loads."""
    from matplotlib.lines import Line2D

    figure, axes = section_figure(view, width=width, loads=True, extra=1.2)
    draw_materials(axes, view, fade=0.25)
    draw_supports(axes, view)
    draw_loads(axes, view)
    owner = particle_materials(len(view.positions), view.triangles, view.triangle_material)
    low, high = axes.get_xlim()
    inches = (width - 0.8) / (high - low)
    spacing = view.spacing or mean_spacing(view.positions, view.triangles)
    diameter = float(np.clip(0.5 * spacing * inches * 72.0, 0.35, 6.0))
    handles = []
    for index, name in enumerate(view.materials):
        own = owner == index
        colour = _darker(material_colour(index))
        axes.scatter(
            view.positions[own, 0],
            view.positions[own, 1],
            s=diameter**2,
            color=colour,
            linewidths=0,
            zorder=3.0,
            rasterized=True,
        )
        handles.append(
            Line2D(
                [],
                [],
                marker="o",
                markersize=6.5,
                linestyle="none",
                markerfacecolor=colour,
                markeredgecolor=PAPER,
                label=f"{name} ({int(own.sum()):,} particles)",
            )
        )
    draw_outline(axes, view.positions, view.triangles, linewidth=0.7, color=SOFT)
    if title:
        axes.set_title(title)
    _legend_below(figure, handles)
    return figure


def source_picture(path: Path, *, longest: int = 1100, most_bytes: int = 600_000) -> tuple[bytes, str]:
    """The picture that a section was read from, made small enough to embed.

    Parameters
    ----------
    path : path
    longest : int [px]
        Longest side.
    most_bytes : int
        A PNG larger than this, a photograph most likely, is given as JPEG instead.

    Returns
    -------
    bytes, str
        The picture and its media type.

    Raises
    ------
    InputError
        The file is gone or is no picture.
    """
    import io

    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            picture = image.convert("RGBA")
    except (OSError, ValueError, UnidentifiedImageError, Image.DecompressionBombError) as error:
        raise InputError(
            str(path), f"the picture cannot be read ({error})", "Check the path and the file."
        ) from error
    if max(picture.size) > longest:
        picture.thumbnail((longest, longest))
    paper = Image.new("RGBA", picture.size, PAPER)
    paper.alpha_composite(picture)
    buffer = io.BytesIO()
    paper.convert("RGB").save(buffer, format="PNG", optimize=True)
    if buffer.tell() <= most_bytes:
        return buffer.getvalue(), "image/png"
    buffer = io.BytesIO()
    paper.convert("RGB").save(buffer, format="JPEG", quality=85)
    return buffer.getvalue(), "image/jpeg"


def deformation_scale(positions: Floats, displacement: Floats, *, share: float = 0.05) -> float:
    """A round factor (1, 2 or 5 times a power of ten) that draws the largest displacement well visible.

    At most `share` of the section's size; 0 where nothing moves.
    """
    largest = float(np.quantile(np.hypot(*displacement.T), 0.995))
    size = float(np.ptp(positions, axis=0).max())
    if not np.isfinite(largest) or largest <= 1e-12 * size:
        return 0.0
    wanted = share * size / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted * (1.0 + 1e-9)))


def particle_materials(
    count: int, triangles: NDArray[np.integer], triangle_material: NDArray[np.integer]
) -> NDArray[np.int64]:
    """Material (n,) of each particle: that of most of its triangles, the later one on a tie; -1: none."""
    kinds = int(triangle_material.max()) + 1 if len(triangle_material) else 1
    votes = np.zeros((count, kinds), dtype=np.int64)
    np.add.at(votes, (triangles.ravel(), np.repeat(triangle_material, 3)), 1)
    owner = kinds - 1 - votes[:, ::-1].argmax(axis=1)
    return np.where(votes.any(axis=1), owner, -1)


def mean_spacing(positions: Floats, triangles: NDArray[np.integer]) -> float:
    """Mean length of a triangle's side [m]."""
    sides = positions[triangles] - positions[np.roll(triangles, 1, axis=1)]
    return float(np.hypot(sides[..., 0], sides[..., 1]).mean())


def _field(
    figure: Figure,
    axes: Axes,
    view: ReportView,
    values: Floats,
    colours: Colormap,
    label: str,
    *,
    top: float,
    power: float = 1.0,
) -> None:
    """A field of the particles, shaded within the triangles, with its colour bar below."""
    from matplotlib.colors import PowerNorm
    from matplotlib.tri import Triangulation

    finite = values[np.isfinite(values)]
    highest = float(np.percentile(finite, top)) if len(finite) else 1.0
    highest = highest if highest > 0.0 else (float(finite.max()) if len(finite) and finite.max() > 0 else 1.0)
    shaded = axes.tripcolor(
        Triangulation(view.positions[:, 0], view.positions[:, 1], view.triangles),
        np.nan_to_num(np.maximum(values, 0.0)),
        shading="gouraud",
        cmap=colours,
        norm=PowerNorm(power, vmin=0.0, vmax=highest),
        zorder=1.0,
        rasterized=True,
    )
    bar = figure.colorbar(
        shaded,
        ax=axes,
        location="bottom",
        shrink=0.62,
        aspect=36,
        pad=0.03,
        extend="max" if len(finite) and finite.max() > highest * (1 + 1e-9) else "neither",
    )
    bar.set_label(label)
    bar.outline.set_visible(False)
    _region_edges(axes, view)
    draw_outline(axes, view.positions, view.triangles, linewidth=0.9)


def _region_edges(axes: Axes, view: ReportView) -> None:
    """Faint boundaries between materials, drawn over a field."""
    if len(view.outlines) > 1:
        for _, rings in view.outlines:
            for ring in rings:
                closed = np.concatenate([np.asarray(ring), np.asarray(ring)[:1]])
                axes.plot(closed[:, 0], closed[:, 1], color=INK, alpha=0.35, linewidth=0.5, zorder=2.0)


def _arrows(axes: Axes, view: ReportView, failure: Failure) -> None:
    """Directions of the displacement at some thirty places of the moving mass."""
    if not failure.moving.any():
        return
    chosen = np.flatnonzero(failure.moving)
    extent = np.ptp(view.positions[chosen], axis=0)
    cell = float(np.sqrt(max(failure.moving_area, 1e-12 + float(extent.prod()) * 0.1) / 28.0))
    grid = np.floor(view.positions[chosen] / cell).astype(np.int64)
    centre_distance = np.hypot(*(view.positions[chosen] / cell - grid - 0.5).T)
    order = np.lexsort((chosen, centre_distance))
    _, first = np.unique(grid[order], axis=0, return_index=True)
    at = chosen[order[first]]
    vectors = failure.displacement[at]
    longest = float(np.hypot(*failure.displacement[chosen].T).max())
    axes.quiver(
        *view.positions[at].T,
        *(vectors * (1.0 * cell / longest)).T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        facecolor=PAPER,
        edgecolor=INK,
        linewidth=0.35,
        width=0.0032,
        headwidth=3.8,
        headlength=4.4,
        zorder=4.7,
    )


def _legend_below(figure: Figure, handles: list[Any]) -> None:
    """A legend under the axes, in as many columns as fit."""
    longest = max((len(str(handle.get_label())) for handle in handles), default=1)
    inches = 0.075 * longest + 0.55
    columns = int(np.clip(figure.get_figwidth() // inches, 1, max(len(handles), 1)))
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=columns,
        handlelength=2.2,
        columnspacing=1.6,
        borderpad=0.9,
    )


def _length_unit(largest: float) -> tuple[float, str]:
    """What to multiply metres with, and the unit, so that numbers are easy to read."""
    return (1000.0, "mm") if largest < 0.2 else (1.0, "m")


def _rgb(colour: str) -> tuple[float, float, float]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def _darker(colour: str) -> tuple[float, float, float]:
    """The same hue, dark enough to stand on its own light fill."""
    import colorsys

    hue, light, strength = colorsys.rgb_to_hls(*_rgb(colour))
    return colorsys.hls_to_rgb(hue, 0.52 * light, min(0.85 * strength + 0.05, 1.0))
