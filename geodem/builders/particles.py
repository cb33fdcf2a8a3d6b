"""Fill a section with particles that lie on all of its lines, and join them to triangles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.builders.filling import (
    EQUILATERAL,
    GRADINGS,
    Draft,
    FillTask,
    Packing,
    Thin,
    TooFewParticlesError,
    draft_filling,
    fill,
    most_particles,
    pack_count,
    refuse_thin,
    settle,
    too_many,
    uniform_count,
    wanted_triangles,
)
from geodem.builders.outline import Floats, Ints, build_graph
from geodem.builders.size_field import SizeField
from geodem.builders.triangulation import Mesh
from geodem.errors import InputError

if TYPE_CHECKING:
    from geodem.builders.section import Section


STARVED_BY = 3.0
"""Times the particles given that a refined place may seem to need before anything is placed."""

# map coordinates this many times the section's extent leave too few digits to tell which circle is empty;
# moved to the origin and back, the corners keep their bits
FAR = 10.0


@dataclass(frozen=True)
class Particles:
    """Particles of a section and the Delaunay triangles between them.

    Attributes
    ----------
    positions : (n, 2) float64 [m]
        Neighbours in space are near in the array (Hilbert curve).
    triangles : (m, 3) int32
        Counter-clockwise.
    triangle_material : (m,) int32
        Index into `materials`.
    materials : tuple of str
        In the section's order.
    boundary_edges : (b, 2) int32
        Edges of one triangle only; the ground lies on the left.
    spacing : float [m]
        Side of the equilateral triangles whose density the packing has away from refined places.
    messages : tuple of str
        What the user should know: refined regions.
    """

    positions: NDArray[np.float64]
    triangles: NDArray[np.int32]
    triangle_material: NDArray[np.int32]
    materials: tuple[str, ...]
    boundary_edges: NDArray[np.int32]
    spacing: float
    messages: tuple[str, ...] = ()


def fill_section(
    section: Section,
    *,
    particles: int | None = None,
    spacing: float | None = None,
    packing: Packing = "random",
    seed: int = 1,
    layers: int = 2,
    thin: Thin = "refine",
    refine: Sequence[tuple[Any, float]] = (),
    focus: Sequence[tuple[Any, float]] = (),
    grading: float | None = None,
    points: Sequence[tuple[float, float]] | Floats = (),
) -> Particles:
    """Fill a section with particles, by number or by spacing.

    Particles lie on every outer and material boundary: on all corners, and between them equally spaced.
    Inside they are either irregular (random sequential insertion, then three sweeps of smoothing) or a
    hexagonal lattice. Their Delaunay triangles follow all boundaries.

    Parameters
    ----------
    section : Section
    particles : int, optional
        Number of particles, met within 2 %. Either this or `spacing`.
    spacing : float, optional [m]
        Side of the equilateral triangles of the same density.
    packing : {"random", "hexagonal"}
    seed : int
        Of the random packing.
    layers : int
        Rows of triangles that cross every region at least; thinner regions are refined, or refused.
    thin : {"refine", "refuse"}
    refine : sequence of (shapely geometry, float [m])
        Largest spacing on a geometry.
    focus : sequence of (shapely geometry, float)
        Spacing on a geometry over the spacing elsewhere, below one [-].
    grading : float, optional
        Growth of the spacing per unit of distance from a refined place. Left out: 0.25, and up to 0.6 where a
        given number of particles would leave too few for the rest.
    points : (p, 2) array_like [m]
        Points that must be particles, such as the ends of a surcharge.

    Returns
    -------
    Particles

    Raises
    ------
    InputError
        Neither or both of `particles` and `spacing`; a value out of its range; a point outside the ground; a
        spacing too large for the section; thin regions where they are refused, or where they need more
        particles than given; more particles than the memory holds.
    """
    _check_options(particles, spacing, packing, layers, thin, refine, grading)
    bounds = section.bounds if section.regions else (0.0, 0.0, 0.0, 0.0)
    if not section.regions or section.outline.area <= 0.0:
        raise InputError(
            "section",
            "there is no ground in it",
            "Give at least one region with an area, or check the legend.",
        )
    extent = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    origin = 0.5 * np.array([bounds[0] + bounds[2], bounds[1] + bounds[3]])
    if np.abs(origin).max() > FAR * extent:
        here = fill_section(
            _moved(section, -origin),
            particles=particles,
            spacing=spacing,
            packing=packing,
            seed=seed,
            layers=layers,
            thin=thin,
            refine=[(_shifted(shape, -origin), limit) for shape, limit in refine],
            focus=[(_shifted(shape, -origin), ratio) for shape, ratio in focus],
            grading=grading,
            points=np.asarray(points, dtype=np.float64).reshape(-1, 2) - origin,
        )
        return replace(here, positions=here.positions + origin)
    marks = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    graph, on_line = build_graph(section, marks, 1e-6 * extent)
    _check_points(section, marks, on_line)
    task = FillTask(
        section,
        graph,
        marks[~on_line],
        packing,
        seed,
        layers,
        thin,
        tuple(refine),
        tuple(focus),
        GRADINGS[0] if grading is None else grading,
        GRADINGS if grading is None else (grading,),
        most_particles(),
    )
    _check_refined(task, particles)
    if spacing is not None:
        draft = draft_filling(task, _checked_spacing(section, spacing, task.most))
        refuse_thin(task, draft)
        mesh, natural = fill(task, draft)
        mesh = settle(task, draft.layout.field, mesh, natural if packing == "random" else None)
    else:
        assert particles is not None
        if particles > task.most:
            raise too_many(particles, "particles", particles, task.most)
        draft, mesh = pack_count(task, particles)
        refuse_thin(task, draft)
    return _finish(task, draft, mesh)


def _moved(section: Section, by: Floats) -> Section:
    from geodem.builders.section import Region, Section

    return Section(tuple(Region(part.material, _shifted(part.polygon, by)) for part in section.regions))


def _shifted(shape: Any, by: Floats) -> Any:
    import shapely

    return shapely.transform(shape, lambda coordinates: coordinates + by)


def _finish(task: FillTask, draft: Draft, mesh: Mesh) -> Particles:
    """Number particles and triangles along a Hilbert curve, and say what was refined."""
    section = task.section
    triangles, region = mesh.label(section)
    for index, part in enumerate(section.regions):
        inside = region == index
        if not inside.any():
            raise InputError(
                "spacing",
                f"a region of {part.material!r} of {part.polygon.area:.3g} m2 holds no triangle at the "
                f"spacing of {draft.layout.field.base:.3g} m",
                f"Give a spacing below {math.sqrt(part.polygon.area) / 2.0:.2g} m, or more particles.",
            )
    used = np.unique(triangles)
    order = used[np.argsort(hilbert_index(mesh.positions[used]), kind="stable")]
    number = np.full(len(mesh.positions), -1, dtype=np.int64)
    number[order] = np.arange(len(order))
    triangles = number[triangles]
    # each triangle starts with its smallest corner, so that the same triangles are the same bits
    turn = (np.argmin(triangles, axis=1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, turn, axis=1)
    by_corner = np.lexsort((triangles[:, 2], triangles[:, 1], triangles[:, 0]))
    triangles, region = triangles[by_corner], region[by_corner]
    materials = section.materials
    material = np.array([materials.index(part.material) for part in section.regions], dtype=np.int32)
    return Particles(
        positions=mesh.positions[order],
        triangles=triangles.astype(np.int32),
        triangle_material=material[region],
        materials=materials,
        boundary_edges=_boundary_edges(triangles).astype(np.int32),
        spacing=draft.layout.field.base,
        messages=_messages(task, draft),
    )


def _boundary_edges(triangles: Ints) -> Ints:
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    keys = sides.min(axis=1) * (int(triangles.max()) + 1) + sides.max(axis=1)
    _, first, times = np.unique(keys, return_index=True, return_counts=True)
    edges: Ints = sides[first[times == 1]]
    return edges


def hilbert_index(points: Floats) -> NDArray[np.uint64]:
    """Place of each point (n, 2) along a Hilbert curve of 2^20 x 2^20 cells over the points' square."""
    low = points.min(axis=0)
    size = float((points.max(axis=0) - low).max()) or 1.0
    x, y = np.minimum((points - low) / size * 2.0**20, 2.0**20 - 1.0).astype(np.uint64).T
    index = np.zeros(len(points), dtype=np.uint64)
    one, three = np.uint64(1), np.uint64(3)
    for bit in range(19, -1, -1):
        shift = np.uint64(bit)
        right, up = (x >> shift) & one, (y >> shift) & one
        index = (index << np.uint64(2)) | ((three * right) ^ up)
        # the curve in the lower quarters runs mirrored about a diagonal
        flip = (up == 0) & (right == 1)
        mask = (one << shift) - one
        x, y = np.where(flip, mask - (x & mask), x & mask), np.where(flip, mask - (y & mask), y & mask)
        x, y = np.where(up == 0, y, x), np.where(up == 0, x, y)
    return index


def _messages(task: FillTask, draft: Draft) -> tuple[str, ...]:
    """One line for each material that was refined because it is thin."""
    thin, field = draft.layout.thin, draft.layout.field
    names = np.array([part.material for part in task.section.regions])[thin.region]
    total = wanted_triangles(field, draft.grid, draft.inside) if len(names) else 0.0
    lines = []
    for name in dict.fromkeys(names.tolist()):
        here = names == name
        kept = np.ones(len(field.places), dtype=bool)
        kept[len(kept) - len(names) :] = ~here
        without = SizeField(field.base, field.grading, field.places[kept], field.limits[kept], field.shapes)
        more = 0.5 * (total - wanted_triangles(without, draft.grid, draft.inside))
        step = 10 ** max(0, math.floor(math.log10(max(more, 1.0))) - 1)
        low, high = thin.thickness[here].min(), thin.thickness[here].max()
        thick = f"{low:.3g}" if high < 1.05 * low else f"{low:.3g} to {high:.3g}"
        lines.append(
            f"{name}: {thick} m thick, spacing refined from {field.base:.3g} m to {low / task.layers:.3g} m "
            f"there" + (f", about +{round(more / step) * step} particles" if more >= 1.0 else "")
        )
    if field.grading > task.grading:
        lines.append(
            f"the spacing grows by {field.grading:g} m a metre away from refined places instead of "
            f"{task.grading:g} m, so that particles are left for the rest; more particles make it grow slower"
        )
    return tuple(lines)


def _check_options(
    particles: int | None,
    spacing: float | None,
    packing: str,
    layers: int,
    thin: str,
    refine: Sequence[tuple[Any, float]],
    grading: float | None,
) -> None:
    if (particles is None) == (spacing is None):
        raise InputError(
            "particles",
            "either the number of particles or their spacing is needed, and not both",
            'Give particles = 5000, or spacing = "0.5 m".',
        )
    if particles is not None and particles < 4:
        raise InputError("particles", "too few to fill a section", "Give 1000 or more.", value=particles)
    if spacing is not None and not (math.isfinite(spacing) and spacing > 0.0):
        raise InputError("spacing", "not a positive length in m", 'Give for example "0.5 m".', value=spacing)
    for place, value, choices in (
        ("packing", packing, ("random", "hexagonal")),
        ("thin", thin, ("refine", "refuse")),
    ):
        if value not in choices:
            raise InputError(place, "unknown", f"Give one of {', '.join(choices)}.", value=value)
    if layers < 1:
        raise InputError("layers", "a region needs at least one layer of triangles", "Give 2.", value=layers)
    if grading is not None and not 0.0 < grading <= 1.0:
        raise InputError("grading", "outside 0 to 1 (metres per metre)", "Give 0.25.", value=grading)
    for index, (_, limit) in enumerate(refine):
        if not (math.isfinite(limit) and limit > 0.0):
            raise InputError(
                f"refine[{index}]", "not a positive length in m", 'Give for example "0.2 m".', value=limit
            )


def _check_refined(task: FillTask, count: int | None) -> None:
    """Refuse refined places that need far more particles than are given or fit the memory, before any is made."""
    import shapely

    lines = shapely.union_all([part.polygon.boundary for part in task.section.regions])
    for index, (shape, limit) in enumerate(task.shapes):
        area = task.section.outline.intersection(shape).area
        needed = area / (2.0 * EQUILATERAL * limit**2) + lines.intersection(shape).length / limit
        if needed > task.most:
            raise too_many(round(needed), f"refine[{index}]", limit, task.most)
        if count is not None and needed > STARVED_BY * count:
            raise TooFewParticlesError(
                f"a refined place alone needs about {needed:.0f}",
                f"Give at least {math.ceil(1.1 * needed)}, or a larger spacing there.",
                value=count,
                needed=math.ceil(1.1 * needed),
            )


def _check_points(section: Section, points: Floats, on_line: NDArray[np.bool_]) -> None:
    import shapely

    inside = on_line | shapely.contains_xy(section.outline, points[:, 0], points[:, 1])
    for index in np.flatnonzero(~inside):
        x, y = points[index]
        raise InputError(
            f"points[{index}]",
            f"({x:g}, {y:g}) m lies outside the ground",
            "Give a point inside the section or on its outline.",
        )


def _checked_spacing(section: Section, spacing: float, most: int) -> float:
    west, south, east, north = section.bounds
    least = min(east - west, north - south)
    if spacing > least:
        raise InputError(
            "spacing",
            f"larger than the section, which is {east - west:.4g} m by {north - south:.4g} m",
            f"Give for example {least / 20.0:.2g} m, which makes about "
            f"{uniform_count(section, least / 20.0)} particles.",
            value=f"{spacing:g} m",
        )
    count = uniform_count(section, spacing)
    if count > most:
        raise too_many(count, "spacing", f"{spacing:g} m", most)
    return spacing
