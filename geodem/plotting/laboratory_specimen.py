"""A specimen at the end of its test: particles by how far they went, cracks by how they were made."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError
from geodem.io.files import write_whole
from geodem.laboratory.orders import FinishedTest
from geodem.laboratory.record import Cracks
from geodem.laboratory.specimen import Specimen
from geodem.plotting.particles import CRACKS, SHEAR
from geodem.plotting.theme import (
    FAINT,
    SOFT,
    displacement_colours,
    material_colour,
    new_figure,
    png,
    quiet_axes,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

WIDTH, HEIGHT = 3.7, 5.4
"""Of one specimen's picture [inch]."""

UNITS = ((2e-5, 1e6, "µm"), (0.02, 1e3, "mm"), (np.inf, 1.0, "m"))
"""Up to which displacement [m], with what factor, a unit is used."""


def specimen_chart(test: FinishedTest, title: str) -> Figure:
    """The specimen as it ended; in 3D the spheres and, beside them, the cracks alone.

    Parameters
    ----------
    test : FinishedTest
    title : str

    Raises
    ------
    InputError
        Spheres without pyvista.
    """
    record = test.record
    distance = np.sqrt((record.displacements**2).sum(axis=1))
    far = float(np.percentile(distance, 98.0))
    factor, unit = next((f, u) for limit, f, u in UNITS if far < limit)
    norm = _norm(distance * factor)
    faces = displacement_colours()(norm(distance * factor))
    if record.positions.shape[1] == 2:
        figure, axes, points = _discs(record.positions, test.radii, test.size, faces)
        _draw_cracks(axes, record.cracks, points)
    else:
        figure, axes = _spheres(test, faces)
    axes.set_title(title)
    _colour_bar(figure, axes, norm, f"displacement [{unit}]")
    handles = _crack_names(test)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2, columnspacing=1.6)
    return figure


def write_bare_specimen(path: Path, specimen: Specimen, bonds: NDArray[np.int64], title: str) -> None:
    """Draw a specimen before any test into a PNG file; errors as of `bare_chart`, or it cannot be written."""
    with style():
        picture = png(bare_chart(specimen, bonds, title))
    write_whole(path, picture)


def bare_chart(specimen: Specimen, bonds: NDArray[np.int64], title: str) -> Figure:
    """A specimen before any test, with its bonds (m, 2) as lines; errors as of `specimen_chart`."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgba

    faces = np.tile(to_rgba(material_colour(0)), (specimen.particles, 1))
    if specimen.dimension == 3:
        from geodem.plotting.spheres import render_balls

        figure = new_figure(WIDTH + 1.0, HEIGHT)
        axes = figure.add_subplot()
        axes.imshow(render_balls(specimen.positions, specimen.radii, faces), interpolation="antialiased")
        axes.set_axis_off()
    else:
        figure, axes, points = _discs(specimen.positions, specimen.radii, specimen.size, faces)
        width = float(np.clip(0.08 * points, 0.25, 0.9))
        ends = list(1e3 * specimen.positions[bonds])
        axes.add_collection(LineCollection(ends, colors=SHEAR, linewidths=width, zorder=3.0), autolim=False)
    axes.set_title(title)
    return figure


def _norm(values: Floats) -> Normalize:
    from matplotlib.colors import Normalize

    # a few that were thrown off must not take all the colours
    top = float(np.percentile(values, 98.0)) or float(values.max()) or 1.0
    return Normalize(0.0, top)


def _discs(positions: Floats, radii: Floats, size: Floats, faces: Floats) -> tuple[Figure, Axes, float]:
    """Discs in millimetres, and how many points the middle one of their diameters is on paper."""
    from matplotlib.collections import EllipseCollection

    places, size = 1e3 * positions, 1e3 * size
    pad = 0.12 * float(size[0])
    low, high = -pad * np.ones(2), size + pad
    room = high - low
    width = min(WIDTH, HEIGHT * room[0] / room[1] + 1.0) if room[1] > room[0] else WIDTH + 1.0
    height = min((width - 0.8) * room[1] / room[0] + 1.5, HEIGHT + 1.5)
    figure = new_figure(width, height)
    axes = figure.add_subplot()
    quiet_axes(axes)
    axes.grid(False)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    diameters = 2e3 * radii
    axes.add_collection(
        EllipseCollection(
            diameters, diameters, np.zeros(len(radii)), units="xy", offsets=places,
            offset_transform=axes.transData, facecolors=faces, edgecolors="none", zorder=2.0, rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip
    points = 72.0 * (width - 0.8) / room[0] * float(np.median(diameters))
    return figure, axes, points


def _draw_cracks(axes: Axes, cracks: Cracks, points: float) -> None:
    from matplotlib.collections import LineCollection

    across = np.column_stack([-cracks.direction[:, 1], cracks.direction[:, 0]])
    half = 0.6 * 1e3 * cracks.size[:, None] * across
    middle = 1e3 * cracks.place
    ends = np.stack([middle - half, middle + half], axis=1)
    thick = float(np.clip(0.14 * points, 0.5, 1.2))
    for mode, (colour, _) in CRACKS.items():
        own = cracks.mode == mode
        axes.add_collection(
            LineCollection(list(ends[own]), colors=colour, linewidths=thick, capstyle="round", zorder=3.0),
            autolim=False,
        )


def _spheres(test: FinishedTest, faces: Floats) -> tuple[Figure, Axes]:
    from geodem.plotting.spheres import render_balls, render_flakes

    cracks = test.record.cracks
    balls = render_balls(test.record.positions, test.radii, faces)
    colours = np.array([_rgb(CRACKS[int(mode)][0]) for mode in cracks.mode]).reshape(-1, 3)
    flakes = render_flakes(cracks.place, cracks.direction, 0.5 * cracks.size, colours, test.size)
    figure = new_figure(7.7, HEIGHT)
    left, right = figure.subplots(1, 2)
    for axes, image in ((left, balls), (right, flakes)):
        axes.imshow(image, interpolation="antialiased")
        axes.set_axis_off()
    right.set_title("its cracks", fontweight="normal", color=SOFT)
    return figure, left


def _rgb(colour: str) -> tuple[float, float, float]:
    from matplotlib.colors import to_rgb

    return to_rgb(colour)


def _crack_names(test: FinishedTest) -> list[Any]:
    from matplotlib.lines import Line2D

    handles = []
    for mode, (colour, name) in CRACKS.items():
        count = int((test.record.cracks.mode == mode).sum())
        if count:
            handles.append(Line2D([], [], color=colour, linewidth=2.0, label=f"{name} ({count:,})"))
    return handles


def _colour_bar(figure: Figure, axes: Axes, norm: Normalize, label: str) -> None:
    from matplotlib.cm import ScalarMappable

    bar = figure.colorbar(
        ScalarMappable(norm, displacement_colours()), ax=axes, location="bottom", shrink=0.8, aspect=30, pad=0.03,
        extend="max",
    )  # fmt: skip
    bar.set_label(label)
    bar.outline.set_edgecolor(FAINT)


def can_draw(test: FinishedTest) -> str:
    """Why there can be no picture of it, or nothing."""
    if test.record.positions.shape[1] == 2:
        return ""
    if find_spec("pyvista") is None:
        error = InputError("picture", "spheres are drawn by pyvista", "Run: pip install 'geodem[pictures]'")
        return str(error)
    return ""
