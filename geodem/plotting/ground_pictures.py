"""The figures of a case of ground: its particles, its named boundaries, and how a photograph was cut."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.breaking.scene import BondedScene
from geodem.builders.body import Surface
from geodem.builders.body_filling import BodyFilling
from geodem.builders.mesh_body import REST
from geodem.errors import InputError
from geodem.plotting.bodies import (
    draw_filling,
    filling_figure,
    filling_picture,
    particle_colours,
    segmentation_figure,
)
from geodem.plotting.scene_pictures import scene_picture
from geodem.plotting.spheres import PIXELS, render_balls, render_facets
from geodem.plotting.theme import INK, SOFT, material_colour, new_figure, png, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from geodem.builders.segmentation import Segmentation

LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#6b5200", "#1f2933")
"""Colours of boundaries, repeated after eight (M. Okabe & K. Ito 2008)."""
UNNAMED = "#9aa5b1"
MOST_NAMES = 12
"""Boundaries that are named in a picture."""
VIEW = (-60.0, 25.0)


def ground_pictures(
    filling: BodyFilling,
    surfaces: Sequence[Surface],
    *,
    title: str,
    picture: NDArray[Any] | None = None,
    segmentation: Segmentation | None = None,
    scene: BondedScene | None = None,
) -> tuple[dict[str, bytes], list[str]]:
    """PNGs by name, and words on what could not be drawn.

    "particles" always, but of spheres without pyvista; "inside" of spheres; "surfaces" where the body names any;
    "cut" of a photograph; "scene" with joints, bolts and sides.
    """
    made: dict[str, bytes] = {}
    with style():
        try:
            if scene is not None:
                made["scene"] = scene_picture(scene, title=title)
            made["particles"] = png(particles_figure(filling, title=title))
            if filling.dimension == 3:
                made["inside"] = png(_inside(filling))
            if surfaces:
                made["surfaces"] = png(surfaces_figure(filling, surfaces))
        except InputError as error:
            return made, [f"no pictures of spheres: {error.problem}. {error.remedy}."]
        if picture is not None and segmentation is not None:
            made["cut"] = png(
                segmentation_figure(picture, segmentation, filling, title="As it was photographed")
            )
    return made, []


def particles_figure(filling: BodyFilling, *, title: str) -> Figure:
    """Discs or spheres by material."""
    if filling.dimension == 2:
        return filling_figure(filling, title=title)
    return filling_picture(filling, title=title, view=VIEW)


def check_figure(
    filling: BodyFilling, surfaces: Sequence[Surface], *, title: str, scene: BondedScene | None = None
) -> bytes:
    """One PNG of particles and boundaries, for a look before anything is kept; raises as `render_facets`."""
    if scene is not None:
        return scene_picture(scene, title=title)
    with style():
        if filling.dimension == 3:
            return png(_both(filling, title))
        if surfaces:
            return png(surfaces_figure(filling, surfaces, title=title))
        return png(particles_figure(filling, title=title))


def _both(filling: BodyFilling, title: str) -> Figure:
    """Spheres from outside, and without the half in front, side by side."""
    faces = particle_colours(filling)
    figure = new_figure(11.0, 4.8)
    for axes, shown, words in zip(
        figure.subplots(1, 2), (np.ones(filling.particles, dtype=bool), _behind(filling)),
        (title, "Cut through the middle"), strict=True,
    ):  # fmt: skip
        image = render_balls(
            filling.positions[shown], filling.radii[shown], faces[shown], view=VIEW, pixels=PIXELS
        )
        axes.imshow(image)
        axes.set_axis_off()
        axes.set_title(words)
    figure.legend(
        handles=_material_handles(filling), loc="outside lower center", ncols=min(6, len(filling.materials)),
        labelcolor=INK,
    )  # fmt: skip
    return figure


def _material_handles(filling: BodyFilling) -> list[Any]:
    from matplotlib.patches import Patch

    return [
        Patch(
            facecolor=material_colour(k), edgecolor=SOFT, linewidth=0.6, label=f"{share.name} ({share.particles:,})"
        )
        for k, share in enumerate(filling.shares)
    ]  # fmt: skip


def surfaces_figure(
    filling: BodyFilling, surfaces: Sequence[Surface], *, title: str = "Boundaries"
) -> Figure:
    """The named boundaries: lines over the discs, or facets."""
    from matplotlib.lines import Line2D

    # what is in no group is seen through
    colours = [UNNAMED if s.name == REST else LINES[k % len(LINES)] for k, s in enumerate(surfaces)]
    if filling.dimension == 3:
        figure = _facets(surfaces, colours, title)
    else:
        figure = _lines(filling, surfaces, colours, title)
    handles: list[Any] = _material_handles(filling) if filling.dimension == 2 else []
    handles += [
        Line2D([], [], color=colour, linewidth=3.0, label=f"{surface.name} ({len(surface.corners):,})")
        for surface, colour in zip(surfaces[:MOST_NAMES], colours, strict=False)
    ]
    more = len(surfaces) - MOST_NAMES
    if more > 0:
        handles.append(Line2D([], [], color="none", label=f"and {more} more"))
    figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)), labelcolor=INK)
    return figure


def _lines(filling: BodyFilling, surfaces: Sequence[Surface], colours: Sequence[str], title: str) -> Figure:
    from matplotlib.collections import LineCollection

    width, height = np.ptp(filling.positions, axis=0)
    figure = new_figure(7.6, float(np.clip(7.6 * height / width + 0.9, 2.4, 8.0)))
    axes: Any = figure.subplots()
    draw_filling(axes, filling)
    for surface, colour in zip(surfaces, colours, strict=True):
        axes.add_collection(
            LineCollection(list(surface.corners), colors=colour, linewidths=2.2, capstyle="round")
        )
    axes.set_title(title)
    return figure


def _facets(surfaces: Sequence[Surface], colours: Sequence[str], title: str) -> Figure:
    named = any(surface.name != REST for surface in surfaces)
    opacities = [0.3 if named and surface.name == REST else 1.0 for surface in surfaces]
    image = render_facets([surface.corners for surface in surfaces], colours, opacities, view=VIEW)
    figure = new_figure(7.6, 7.6 * image.shape[0] / image.shape[1] + 0.9)
    axes: Any = figure.subplots()
    axes.imshow(image)
    axes.set_axis_off()
    axes.set_title(title, pad=10.0)
    engine: Any = figure.get_layout_engine()
    engine.set(w_pad=0.12, h_pad=0.08)
    return figure


def _inside(filling: BodyFilling) -> Figure:
    """The spheres behind the middle, as if the half that is nearer to the viewer were taken away."""
    return filling_picture(filling, title="Cut through the middle", view=VIEW, shown=_behind(filling))


def _behind(filling: BodyFilling) -> NDArray[np.bool_]:
    y = filling.positions[:, 1]
    return np.asarray(y >= 0.5 * (y.min() + y.max()))
