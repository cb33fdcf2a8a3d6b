"""From a case of ground to its body and its particles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from .builders.body import Body
from .builders.body_filling import BodyFilling
from .builders.fill_body import fill_body
from .case.ground import GroundCase, GroundSource
from .case.ground_source import SOURCES
from .case.ground_tables import MANY, mismatches
from .case.source_files import metres, moved
from .case.table import join
from .errors import InputError, InputErrors
from .units import show

if TYPE_CHECKING:
    from .builders.segmentation import Segmentation

FEWEST = 20
"""Particles that a radius must leave room for: fewer come of a mistaken unit more often than of a wish."""
_PLACES = {
    "arrangement": "arrangement", "radius": "radius", "particles": "particles", "grading": "grading",
    "solid_fraction": "solid_fraction", "size_ratio": "size_ratio", "seed": "seed",
}  # fmt: skip


@dataclass(frozen=True)
class GroundBody:
    """What a source became.

    Attributes
    ----------
    body : Body
    picture : array or None
        The photograph as it was read.
    segmentation : Segmentation or None
        How it, or a stack of slices, was cut by brightness.
    """

    body: Body
    picture: NDArray[Any] | None = None
    segmentation: Segmentation | None = None


def make_body(case: GroundCase, *, spare: Sequence[str] = ()) -> GroundBody:
    """The body of a case.

    `spare`: materials that the source need not have.

    Raises
    ------
    InputError, InputErrors
        A file that cannot be used; materials of the file without a table, and tables of no material.
    """
    source = case.source
    place = join("source", source.kind)
    try:
        made = _MAKERS[source.kind](source)
    except InputErrors:
        raise
    except InputError as error:
        keys = {key: key for key in (*SOURCES[source.kind], *source.options)}
        value = source.file.name if source.files else None
        raise moved(error, place, value=value, keys=keys) from error
    found = made.body.materials
    wanted = tuple(name for name in case.materials if name in found or name not in spare)
    errors = mismatches(found, wanted, "the source")
    if errors:
        raise InputErrors(errors)
    empty = [name for name, size in zip(made.body.materials, made.body.sizes, strict=True) if not size > 0.0]
    if empty:
        raise InputError(
            join("material", empty[0]), "the source has no ground of this material",
            "Take it out of the case, or mend its colour or thresholds.",
        )  # fmt: skip
    return made


def fill(case: GroundCase, body: Body) -> BodyFilling:
    """Particles of the body.

    Raises
    ------
    InputError
        A size that does not fit the body, or needs more memory than there is.
    """
    options = case.particles
    size = " by ".join(show(float(f"{side:.3g}"), "length") for side in np.ptp(body.bounds, axis=0))
    if options.radius is not None:
        radius = show(options.radius, "length")
        unit = math.pi if body.dimension == 2 else 4.0 / 3.0 * math.pi
        room = float(body.sizes.sum()) / (unit * options.radius**body.dimension)
        if room < FEWEST:
            raise InputError(
                "particles.radius", f"the ground is {size}: it has no room for {FEWEST} such particles",
                "Check both units, and give a smaller radius.", value=radius,
            )  # fmt: skip
        if room > MANY and "particles.radius" not in case.allow_implausible:
            raise InputError(
                "particles.radius", f"the ground is {size}: it would take about {room:.2g} such particles",
                "Check both units, and give a larger radius. If it is meant, add "
                'allow_implausible = ["particles.radius"] at the top of the file.',
                value=radius,
            )  # fmt: skip
    key = next((name for name in ("radius", "grading") if getattr(options, name) is not None), "particles")
    try:
        return fill_body(body, **options.arguments())
    except InputError as error:
        raise moved(error, f"particles.{key}", value=error.value, keys=_PLACES) from error


def _image(source: GroundSource) -> GroundBody:
    from .builders.grid_sources import grid_from_image

    o = source.options
    body = grid_from_image(
        source.file, scale=o["scale"], legend=o["legend"], background=o["background"], origin=o.get("origin", 0.0)
    )  # fmt: skip
    return GroundBody(body)


def _photograph(source: GroundSource) -> GroundBody:
    from .builders.image_pixels import read_pixels

    picture = read_pixels(source.file, "photograph").colour
    return _segmented(source, source.file, picture, source.options["scale"])


def _slices(source: GroundSource) -> GroundBody:
    from .builders.grid_sources import grid_from_slices, read_slices
    from .builders.segmentation import luminance

    o = source.options
    if "legend" in o:
        return GroundBody(
            grid_from_slices(
                source.file, voxel=o["voxel"], legend=o["legend"], background=o["background"],
                origin=o.get("origin", 0.0),
            )
        )  # fmt: skip
    stack = read_slices(source.file)
    if stack.ndim == 4:
        stack = luminance(stack, 255.0 if stack.dtype == np.uint8 else 65535.0)
    return _segmented(source, stack, None, o["voxel"])


def _segmented(source: GroundSource, given: Any, picture: NDArray[Any] | None, side: Any) -> GroundBody:
    from .builders.segmentation import segment

    o = source.options
    names = o["materials"]
    cut = segment(
        given, classes=len(names), thresholds=o.get("thresholds"), lighting=o.get("lighting"),
        smoothing=o["smoothing"], smallest=o["smallest"],
        grains=names.index(o["grains"]) if "grains" in o else None, apart=o.get("apart"),
    )  # fmt: skip
    return GroundBody(cut.body(side, names, origin=o.get("origin", 0.0)), picture, cut)


def _grid(source: GroundSource) -> GroundBody:
    if find_spec("pyvista") is None:
        raise InputError(
            "grid", "VTK files are read by pyvista, which is not here", "Run: pip install 'geodem[pictures]'."
        )
    from .builders.grid_sources import grid_from_vtk

    o = source.options
    return GroundBody(
        grid_from_vtk(source.file, thresholds=o["thresholds"], materials=o["materials"], scalars=o.get("scalars"))
    )  # fmt: skip


def _mesh(source: GroundSource) -> GroundBody:
    from .builders.from_mesh import body_from_mesh

    o = source.options
    files = dict(source.files) if source.kind == "solids" else source.file
    return GroundBody(
        body_from_mesh(
            files, length_unit=metres(o.get("length_unit")), size=o.get("size"), names=o.get("names"),
            material_array=o.get("material_array"),
        )
    )  # fmt: skip


def _terrain(source: GroundSource) -> GroundBody:
    from .builders.terrain import Layer
    from .case.terrain_section import load_terrain

    o = source.options
    terrain = load_terrain(source.file, o.get("degrees"), o["holes"])
    if "cut_out" in o:
        low, high = terrain.metres(o["cut_out"])
        terrain = terrain.crop(low, high)
    layers = [Layer(name, depth) for name, depth in o["layers"]]
    return GroundBody(cast("Body", terrain.body(base=o["base"], layers=layers)))


def _regions(source: GroundSource) -> GroundBody:
    from .builders.section import Section
    from .builders.section_body import SectionBody

    regions = [(name, np.array(corners)) for name, corners in source.options["regions"]]
    return GroundBody(SectionBody(Section.from_polygons(regions, place="source.regions")))


def _box(source: GroundSource) -> GroundBody:
    from .builders.section_body import box_body

    o = source.options
    return GroundBody(box_body(o["box"], o["layers"], o.get("origin")))


_MAKERS = {
    "image": _image,
    "photograph": _photograph,
    "slices": _slices,
    "grid": _grid,
    "mesh": _mesh,
    "solids": _mesh,
    "geometry": _mesh,
    "terrain": _terrain,
    "regions": _regions,
    "box": _box,
}
