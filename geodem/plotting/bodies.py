"""Bodies and the particles that fill them: what a picture was cut into, discs in the plane, spheres in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body_filling import BodyFilling
from geodem.builders.segmentation import TINTS, Segmentation
from geodem.plotting.spheres import PIXELS, render_balls
from geodem.plotting.theme import FAILED, INK, SOFT, material_colour, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

GRAINS = (
    "#8dafc9", "#d9b57c", "#9cbf94", "#d99a8b", "#b3a3cc", "#c9c07f", "#86bdb4", "#b8aca0", "#d297b4", "#9aa67f",
)  # fmt: skip
"""Fills that tell neighbouring grains apart; they repeat."""
BINS = 128
TALLEST = 5.6
"""Of the spheres in a picture [inch]."""


def particle_colours(filling: BodyFilling, fills: Sequence[str] | None = None) -> Floats:
    """Colours (n, 4) by material; grains that are told apart have one each, out of ten."""
    from matplotlib.colors import to_rgba

    own = [material_colour(k) for k in range(len(filling.materials))] if fills is None else fills
    faces = np.array([to_rgba(fill) for fill in own])[filling.material]
    grained = filling.group >= 0
    # neighbours in number are neighbours in space, so the colours are dealt out of order
    faces[grained] = np.array([to_rgba(fill) for fill in GRAINS])[filling.group[grained] * 7919 % len(GRAINS)]
    return faces


def draw_filling(axes: Axes, filling: BodyFilling, fills: Sequence[str] | None = None) -> None:
    """The discs of a plane filling, true to scale."""
    from matplotlib.collections import EllipseCollection

    reach = filling.radii.max()
    low, high = filling.positions.min(axis=0) - reach, filling.positions.max(axis=0) + reach
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    faces = particle_colours(filling, fills)
    sides = 2.0 * filling.radii
    axes.add_collection(
        EllipseCollection(
            sides, sides, np.zeros(len(sides)), units="xy", offsets=filling.positions,
            offset_transform=axes.transData, facecolors=faces, edgecolors="none", rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def draw_thresholds(axes: Axes, segmentation: Segmentation) -> None:
    """How often each brightness occurs, in the tints of the classes, and the thresholds."""
    count, edges = np.histogram(segmentation.grey, bins=BINS, range=(0.0, 1.0))
    middle = 0.5 * (edges[:-1] + edges[1:])
    tint = TINTS[np.digitize(middle, segmentation.thresholds) % len(TINTS)] / 255.0
    axes.bar(middle, count / count.max(), width=edges[1], color=tint * 0.75 + 0.25)
    for threshold in segmentation.thresholds:
        axes.axvline(threshold, color=FAILED, linewidth=1.4)
        axes.text(threshold + 0.01, 1.02, f"{threshold:.3f}", color=FAILED, va="bottom")
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.15), xlabel="brightness [-]", yticks=[], title="Thresholds")


def segmentation_figure(
    original: NDArray[np.generic], segmentation: Segmentation, filling: BodyFilling, *, title: str
) -> Figure:
    """A picture, its thresholds, the classes and grains, and the discs that they became."""
    figure = new_figure(7.8, 7.2)
    (source, histogram), (classes, discs) = figure.subplots(2, 2)
    source.imshow(original, cmap="gray")
    source.set_title(title)
    draw_thresholds(histogram, segmentation)
    classes.imshow(segmentation.picture())
    number = int(segmentation.grains.max()) + 1
    classes.set_title(f"{number} pieces told apart" if number else f"{segmentation.classes} classes")
    for axes in (source, classes):
        axes.set(xticks=[], yticks=[])
    draw_filling(discs, filling)
    discs.set_title(f"{filling.particles:,} discs")
    return figure


def filling_figure(filling: BodyFilling, *, title: str) -> Figure:
    """The discs of a plane body with the names of its materials."""
    width, height = np.ptp(filling.positions, axis=0)
    figure = new_figure(7.6, float(np.clip(7.6 * height / width + 0.9, 2.4, 8.0)))
    axes: Any = figure.subplots()
    draw_filling(axes, filling)
    axes.set_title(title)
    _name_materials(figure, filling)
    return figure


def filling_picture(
    filling: BodyFilling,
    *,
    title: str,
    view: tuple[float, float] = (-60.0, 25.0),
    shown: NDArray[np.bool_] | None = None,
    fills: Sequence[str] | None = None,
    shade_height: bool = False,
) -> Figure:
    """The spheres of a body, those of the mask `shown` only.

    `view`: azimuth and elevation that they are looked at from [deg]. `shade_height`: higher ones lighter.
    """
    seen = np.ones(filling.particles, dtype=bool) if shown is None else shown
    faces = particle_colours(filling, fills)
    if shade_height:
        z = filling.positions[:, 2]
        faces[:, :3] *= 0.82 + 0.18 * ((z - z.min()) / max(float(np.ptp(z)), 1e-300))[:, None]
    image = render_balls(filling.positions[seen], filling.radii[seen], faces[seen], view=view, pixels=PIXELS)
    width = min(7.6, TALLEST * image.shape[1] / image.shape[0])
    figure = new_figure(max(width, 5.0), width * image.shape[0] / image.shape[1] + 0.6)
    axes: Any = figure.subplots()
    axes.imshow(image)
    axes.set_axis_off()
    axes.set_title(title, pad=10.0)
    _widen(figure)
    _name_materials(figure, filling, fills)
    return figure


def _widen(figure: Figure) -> None:
    """Room around what has no axes, whose letters would touch the edge."""
    engine: Any = figure.get_layout_engine()
    engine.set(w_pad=0.12, h_pad=0.08)


def _name_materials(figure: Figure, filling: BodyFilling, fills: Sequence[str] | None = None) -> None:
    from matplotlib.patches import Patch

    own = [material_colour(k) for k in range(len(filling.materials))] if fills is None else fills
    grained = np.unique(filling.material[filling.group >= 0])
    handles = [
        Patch(facecolor=fill, edgecolor=SOFT, linewidth=0.6, label=f"{share.name} ({share.particles:,})")
        for number, (fill, share) in enumerate(zip(own, filling.shares, strict=True))
        if number not in grained
    ]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), labelcolor=INK)
