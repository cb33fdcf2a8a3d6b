"""Pictures of discs or spheres as they are now: by material or by what happened, with cracks and walls."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError
from geodem.io.files import write_whole
from geodem.io.particle_frames import damage
from geodem.plotting.theme import (
    FAINT,
    INK,
    PAPER,
    SOFT,
    displacement_colours,
    halo,
    material_colour,
    new_figure,
    png,
    strain_colours,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from matplotlib.figure import Figure

    from geodem.particle_reading import ParticleReading

Floats = NDArray[np.float64]

COLOURINGS = ("material", "displacement", "speed", "damage")
TENSION, SHEAR = "#c2410c", "#0b4f8a"
CRACKS = {1: (TENSION, "crack, tension"), 2: (SHEAR, "crack, shear")}
"""Colour and name of a break by its mode."""
OPEN = 1.5
"""Distance over the sum of the radii up to which a crack is drawn; beyond, the gap itself shows it."""
WIDTH = 7.7
"""Of a picture [inch]."""


class Colouring(NamedTuple):
    """Colours of the particles (n, 4) and what explains them: a scale or names."""

    faces: Floats
    colours: Colormap | None
    norm: Normalize | None
    label: str
    more: bool  # some values are beyond the scale


def write_particle_picture(
    path: Path | str,
    simulation: ParticleReading,
    *,
    colour: str = "material",
    cracks: bool = True,
    title: str = "",
    view: tuple[float, float] = (-60.0, 22.0),
) -> bytes:
    """Draw discs or spheres as they are now, true to scale.

    Parameters
    ----------
    path : path
        A PNG file.
    simulation : ParticleSimulation
    colour : str
        "material", "displacement" (since the assembly), "speed" or "damage" (share of a particle's bonds that broke).
    cracks : bool
        Draw broken bonds between discs that are still near each other, by mode.
    title : str
        Stands above; the time where it is left out.
    view : (float, float)
        Of spheres: where they are looked at from, azimuth and elevation [deg].

    Returns
    -------
    bytes
        The PNG.

    Raises
    ------
    InputError
        No such colouring; the file cannot be written; spheres without pyvista.
    """
    with style():
        picture = png(particle_figure(simulation, colour=colour, cracks=cracks, title=title, view=view))
    write_whole(path, picture)
    return picture


NAMES_IN_A_LINE = 5

LINE_OF_NAMES = 0.25
"""Height of a line of the legend [inch]."""


def particle_figure(
    simulation: ParticleReading,
    *,
    colour: str = "material",
    cracks: bool = True,
    title: str = "",
    view: tuple[float, float] = (-60.0, 22.0),
) -> Figure:
    """The figure that `write_particle_picture` writes, to be made and saved within `geodem.plotting.theme.style`."""
    s = simulation
    colouring = colour_particles(s, colour)
    broken = s.broken_bonds().mode
    handles = _material_handles(s) if colour == "material" and len(s.assembly.material_names) > 1 else []
    if s.dimension == 2:
        figure, axes = _plane_figure(s)
        draw_walls(axes, s)
        draw_cell(axes, s)
        draw_discs(axes, s, colouring.faces)
        if cracks and len(broken):
            handles += draw_cracks(axes, s)
    else:
        from geodem.plotting.spheres import render_spheres

        image = render_spheres(s, colouring.faces, view=view)
        figure = new_figure(
            WIDTH, WIDTH * image.shape[0] / image.shape[1] + (1.1 if colouring.colours is not None else 0.6)
        )
        axes = figure.add_subplot()
        axes.imshow(image, interpolation="antialiased")
        axes.set_axis_off()
    axes.set_title(title or f"{s.time:.4g} s")
    what = "discs" if s.dimension == 2 else "spheres"
    note = f"{s.assembly.particles:,} {what}"
    if len(s.assembly.bonds):
        note += f", {len(broken):,} of {len(s.assembly.bonds):,} bonds broken"
    axes.set_title(note, loc="right", fontsize=8.5, fontweight="normal", color=SOFT)
    if colouring.colours is not None:
        _colour_bar(figure, axes, colouring)
    if handles:
        columns = min(len(handles), NAMES_IN_A_LINE)
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, columnspacing=1.6)
        # the layout gives lines of names the room of the title
        more = LINE_OF_NAMES * math.ceil(len(handles) / columns) if s.dimension == 2 else 0.0
        figure.set_size_inches(figure.get_figwidth(), figure.get_figheight() + more)
    return figure


def colour_particles(simulation: ParticleReading, colour: str) -> Colouring:
    """Colours of the particles by one of `COLOURINGS`; raises InputError for another."""
    from matplotlib.colors import Normalize, to_rgba

    s, a = simulation, simulation.assembly
    if colour == "material":
        fills = np.array([to_rgba(material_colour(k)) for k in range(len(a.material_names))])
        return Colouring(fills[a.material], None, None, "", False)
    if colour == "displacement":
        values = np.sqrt(((s.positions - a.positions) ** 2).sum(axis=1))
        factor, unit = (1e3, "mm") if values.max(initial=0.0) < 0.2 else (1.0, "m")
        values, label, colours = values * factor, f"displacement [{unit}]", displacement_colours()
    elif colour == "speed":
        values = np.sqrt((s.velocities**2).sum(axis=1))
        label, colours = "speed [m/s]", displacement_colours()
    elif colour == "damage":
        values = damage(s)[1]
        label, colours = "share of bonds broken [-]", strain_colours()
    else:
        raise InputError("colour", "there is no such colouring", f"Give one of {COLOURINGS}", value=colour)
    top = 1.0 if colour == "damage" else float(np.percentile(values, 99.5))
    top = top if top > 0.0 else max(float(values.max(initial=0.0)), 1e-12)
    norm = Normalize(0.0, top)
    return Colouring(
        colours(norm(values)), colours, norm, label, bool(values.max(initial=0.0) > top * (1 + 1e-9))
    )


def draw_discs(axes: Axes, simulation: ParticleReading, faces: Floats) -> None:
    """The discs, outlined where they are large enough on paper."""
    from matplotlib.collections import EllipseCollection

    s = simulation
    low, high = axes.get_xlim()
    points = 72.0 * (WIDTH - 0.8) / (high - low) * 2.0 * float(np.median(s.assembly.radii))
    edges = 0.55 * faces
    edges[:, 3] = 1.0
    diameters = 2.0 * s.assembly.radii
    axes.add_collection(
        EllipseCollection(
            diameters, diameters, np.zeros(len(diameters)), units="xy", offsets=s.seen_positions(),
            offset_transform=axes.transData, facecolors=faces, edgecolors=edges,
            linewidths=float(np.clip(0.06 * points, 0.0, 0.7)), zorder=2.0, rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip


def draw_cracks(axes: Axes, simulation: ParticleReading) -> list[Any]:
    """Broken bonds as short lines across where they were, over the discs; returns what names them in a legend."""
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    s = simulation
    found = s.broken_bonds()
    pairs = s.assembly.bonds[found.bond]
    places = s.seen_positions()[pairs]
    radii = s.assembly.radii[pairs]
    apart = places[:, 1] - places[:, 0]
    if s.cell is not None:
        apart = s.cell.nearest(apart)
    distance = np.hypot(*apart.T)
    across = np.column_stack([-apart[:, 1], apart[:, 0]]) / distance[:, None]
    middle = places[:, 0] + apart * ((radii[:, 0] + 0.5 * (distance - radii.sum(axis=1))) / distance)[:, None]
    half = 0.65 * radii.min(axis=1)[:, None] * across
    near = distance < OPEN * radii.sum(axis=1)
    low, high = axes.get_xlim()
    points = 72.0 * (WIDTH - 0.8) / (high - low) * float(np.median(s.assembly.radii))
    width = float(np.clip(0.35 * points, 0.5, 2.0))
    ends = np.stack([middle - half, middle + half], axis=1)
    handles = []
    for mode, (colour, name) in CRACKS.items():
        own = near & (found.mode == mode)
        axes.add_collection(
            LineCollection(
                list(ends[own]), colors=colour, linewidths=width,
                capstyle="round", zorder=3.0, path_effects=halo(width + 1.0) if points > 6.0 else None,
            ),
            autolim=False,
        )  # fmt: skip
        count = int((found.mode == mode).sum())
        if count:
            handles.append(Line2D([], [], color=colour, linewidth=2.0, label=f"{name} ({count:,})"))
    return handles


def draw_cell(axes: Axes, simulation: ParticleReading) -> None:
    """The edges of a periodic cell, over the discs."""
    if simulation.cell is not None:
        for ends in simulation.cell.outline():
            axes.plot(*ends.T, color=INK, linewidth=1.2, linestyle=(0, (5, 3)), zorder=2.8)


def draw_walls(axes: Axes, simulation: ParticleReading) -> None:
    """Planes as hatched bands behind their faces, segments as lines."""
    from matplotlib.patches import Polygon

    s = simulation
    corners = s.walls.corners_now()[:, :, :2]
    limits = np.array([axes.get_xlim(), axes.get_ylim()])
    size = float(np.ptp(limits, axis=1).max())
    thickness = 0.014 * size
    for kind, points in zip(s.walls.kind, corners, strict=True):
        if kind == 1:
            axes.plot(*points[:2].T, color=INK, linewidth=2.0, solid_capstyle="round", zorder=2.6)
            continue
        at, normal = points[0], points[1]
        along = np.array([-normal[1], normal[0]])
        centre = at + along * ((limits.mean(axis=1) - at) @ along)
        ends = np.array([centre - size * along, centre + size * along])
        band = np.concatenate([ends, ends[::-1] - thickness * normal])
        axes.add_patch(
            Polygon(band, facecolor=PAPER, edgecolor="#8794a1", hatch="//////", linewidth=0.0, zorder=1.4)
        )
        axes.plot(*ends.T, color=SOFT, linewidth=1.1, zorder=1.6)


def _plane_figure(s: ParticleReading) -> tuple[Figure, Axes]:
    """A figure in metres around all discs, and around walls that are near them."""
    radii = s.assembly.radii[:, None]
    places = s.seen_positions()
    low, high = (places - radii).min(axis=0), (places + radii).max(axis=0)
    if s.cell is not None:
        corners = s.cell.corners()
        low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
    size = float((high - low).max())
    for kind, points in zip(s.walls.kind, s.walls.corners_now()[:, :, :2], strict=True):
        if kind == 1:
            low, high = np.minimum(low, points[:2].min(axis=0)), np.maximum(high, points[:2].max(axis=0))
            continue
        # only planes along an axis have a face that fits a picture's edge
        axis = int(np.argmax(np.abs(points[1])))
        if abs(points[1, axis]) > 0.999 and low[axis] - size < points[0, axis] < high[axis] + size:
            low[axis], high[axis] = min(low[axis], points[0, axis]), max(high[axis], points[0, axis])
    pad = 0.03 * float((high - low).max())
    room = high - low + 2.0 * pad
    height = float(np.clip((WIDTH - 0.8) * room[1] / room[0] + 1.2, 2.2, 1.25 * WIDTH))
    figure = new_figure(WIDTH, height)
    axes = figure.add_subplot()
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(low[1] - pad, high[1] + pad)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.tick_params(length=3.0)
    return figure, axes


def _material_handles(s: ParticleReading) -> list[Any]:
    from matplotlib.patches import Patch

    return [
        Patch(facecolor=material_colour(k), edgecolor="#8794a1", label=name)
        for k, name in enumerate(s.assembly.material_names)
    ]


def _colour_bar(figure: Figure, axes: Axes, colouring: Colouring) -> None:
    from matplotlib.cm import ScalarMappable

    bar = figure.colorbar(
        ScalarMappable(colouring.norm, colouring.colours), ax=axes, location="bottom", shrink=0.62, aspect=36,
        pad=0.03, extend="max" if colouring.more else "neither",
    )  # fmt: skip
    bar.set_label(colouring.label)
    bar.outline.set_edgecolor(FAINT)
