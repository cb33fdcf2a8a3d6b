"""From a mesh to what is computed with: a body, particles on its nodes or one in each element, a section, walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Wall
from geodem.boundaries.walls import Motion, facets
from geodem.builders.body import Body
from geodem.builders.body_filling import BodyFilling
from geodem.builders.mesh import Mesh, cell_facets, rows_as_numbers
from geodem.builders.mesh_body import MeshBody
from geodem.builders.mesh_checks import place_of
from geodem.builders.mesh_reading import read_mesh
from geodem.builders.particles import Particles, hilbert_index
from geodem.builders.section import Region, Section
from geodem.builders.solid_body import SolidBody, read_solids
from geodem.errors import InputError

Floats = NDArray[np.float64]

BALL = {2: np.pi, 3: 4.0 * np.pi / 3.0}
SHARP = 10.0
"""Angle [deg] of triangles below which they are told of."""
STRAIGHT = 1e-9
"""Sine of the turn of a line at a node up to which it is straight."""


def body_from_mesh(
    path: str | Path | Mapping[str, str | Path],
    *,
    length_unit: float | None = None,
    size: float | None = None,
    names: Mapping[int, str] | None = None,
    material_array: str | None = None,
) -> MeshBody | SolidBody:
    """A body from a file of any kind that is read.

    Parameters
    ----------
    path : str, Path or mapping
        A mesh or geometry as `read_mesh` takes it; an .stl file, or several by the name of their material, for what
        closed surfaces enclose.
    length_unit, size, names, material_array
        As in `geodem.builders.mesh_reading.read_mesh`; for closed surfaces only `length_unit`.

    Raises
    ------
    InputError
        As `geodem.builders.mesh_reading.read_mesh` and `geodem.builders.solid_body.read_solids` do.
    """
    if isinstance(path, Mapping) or Path(path).suffix.lower() == ".stl":
        for key, value in (("size", size), ("names", names), ("material_array", material_array)):
            if value is not None:
                raise InputError(key, "closed surfaces have no such thing", "Leave it out.", value=value)
        files = path if isinstance(path, Mapping) else {Path(path).stem: path}
        return read_solids(files, length_unit=length_unit)
    return MeshBody(
        read_mesh(path, length_unit=length_unit, size=size, names=names, material_array=material_array)
    )


def particles_from_mesh(mesh: Mesh) -> Particles:
    """Stress-carrying particles on the nodes of a section, joined by its triangles, however graded.

    Raises
    ------
    InputError
        A volume; parts that were meshed apart and do not share their nodes.
    """
    _require_section(mesh, "particles_from_mesh")
    if mesh.unjoined:
        raise InputError(
            "particles_from_mesh", f"{mesh.unjoined} sides of elements inside the ground have no neighbour with the "
            "same nodes, so that the ground would come apart there",
            "Mesh all surfaces at once, so that they share their common lines (in gmsh: Coherence, BooleanFragments).",
        )  # fmt: skip
    order = np.argsort(hilbert_index(mesh.nodes), kind="stable")
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    triangles = number[mesh.cells]
    turn = (np.argmin(triangles, axis=1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, turn, axis=1)
    by_corner = np.lexsort((triangles[:, 2], triangles[:, 1], triangles[:, 0]))
    area = mesh.cell_sizes
    return Particles(
        positions=mesh.nodes[order],
        triangles=triangles[by_corner].astype(np.int32),
        triangle_material=mesh.cell_material[by_corner],
        materials=mesh.materials,
        boundary_edges=number[mesh.facets].astype(np.int32),
        # large triangles, which fill most of the ground, stand for what is away from refined places
        spacing=float(np.sqrt(4.0 / np.sqrt(3.0) * (area**2).sum() / area.sum())),
        messages=_angle_messages(mesh),
    )


def _angle_messages(mesh: Mesh) -> tuple[str, ...]:
    corners = mesh.nodes[mesh.cells]
    smallest = np.full(len(corners), np.pi)
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), (a * b).sum(axis=1))
        smallest = np.minimum(smallest, angle)
    sharp = int((smallest < np.radians(SHARP)).sum())
    if not sharp:
        return ()
    worst = int(np.argmin(smallest))
    return (
        f"{sharp} triangles have an angle below {SHARP:g} deg, the worst {np.degrees(smallest[worst]):.2g} deg at "
        f"{place_of(corners[worst].mean(axis=0))}: stresses are poor there and steps short",
    )


def element_particles(mesh: Mesh, *, radius_ratio: float = 1.0) -> BodyFilling:
    """One disc or sphere in each element of the file, at its centroid; a split element gets one.

    Parameters
    ----------
    mesh : Mesh
    radius_ratio : float
        Radius over that of the disc or sphere as large as the element. At 1 neighbours overlap; the density makes up
        for smaller ones, so that each particle has the mass of its element.

    Raises
    ------
    InputError
        A ratio that is not positive.
    """
    if not (np.isfinite(radius_ratio) and radius_ratio > 0.0):
        raise InputError("radius_ratio", "this is not a positive number", "Give 1.", value=radius_ratio)
    _, first, element = np.unique(mesh.cell_element, return_index=True, return_inverse=True)
    sizes = np.bincount(element.reshape(-1), mesh.cell_sizes)
    middles = mesh.nodes[mesh.cells].mean(axis=1) * mesh.cell_sizes[:, None]
    centres = (
        np.stack([np.bincount(element.reshape(-1), part) for part in middles.T], axis=1) / sizes[:, None]
    )
    d = mesh.dimension
    return BodyFilling(
        positions=centres,
        radii=radius_ratio * (sizes / BALL[d]) ** (1.0 / d),
        material=mesh.cell_material[first],
        materials=mesh.materials,
        sources=mesh.sizes,
        solid_fraction=radius_ratio**d,
        arrangement="elements",
        group=np.full(len(sizes), -1, dtype=np.int32),
        remarks=mesh.remarks,
    )


def section_from_mesh(mesh: Mesh) -> Section:
    """The materials of a section as polygons whose corners are nodes, for `geodem.fill_section`.

    Nodes on a straight line between two others are left out.

    Raises
    ------
    InputError
        A volume; parts that were meshed apart.
    """
    import shapely

    _require_section(mesh, "section_from_mesh")
    if mesh.unjoined:
        raise InputError(
            "section_from_mesh", "parts of the mesh do not share the nodes of their common lines",
            "Mesh all surfaces at once.",
        )  # fmt: skip
    sides = cell_facets(mesh.cells.astype(np.int64)).reshape(-1, 2)
    own = np.repeat(mesh.cell_material, 3)
    key = rows_as_numbers(sides, len(mesh.nodes))
    body = MeshBody(mesh)
    rims = []
    for number in range(len(mesh.materials)):
        mine = own == number
        _, first, uses = np.unique(key[mine], return_index=True, return_counts=True)
        rims.append(sides[mine][first[uses == 1]])
    plain = {tuple(node) for node in mesh.nodes[_straight(mesh.nodes, np.concatenate(rims))].tolist()}

    def corners(ring: Any) -> list[tuple[float, ...]]:
        return [point for point in ring.coords[:-1] if point not in plain]

    regions = []
    for number, name in enumerate(mesh.materials):
        faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(mesh.nodes[rims[number]])))
        spots = shapely.get_coordinates(shapely.point_on_surface(faces))
        for face in faces[body.material_at(spots) == number]:
            holes = [corners(hole) for hole in face.interiors]
            regions.append(Region(name, shapely.normalize(shapely.Polygon(corners(face.exterior), holes))))
    return Section(tuple(regions))


def _straight(nodes: Floats, lines: NDArray[np.int64]) -> NDArray[np.int64]:
    """Nodes in which two lines meet that are one."""
    lines = np.unique(np.sort(lines, axis=1), axis=0)
    ends = np.concatenate([lines, lines[:, ::-1]])
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    node, first, uses = np.unique(ends[:, 0], return_index=True, return_counts=True)
    pairs, node = first[uses == 2], node[uses == 2]
    a, b = nodes[ends[pairs, 1]] - nodes[node], nodes[ends[pairs + 1, 1]] - nodes[node]
    turn = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    level = turn <= STRAIGHT * np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    return np.asarray(node[level & ((a * b).sum(axis=1) < 0.0)])


def walls_from_body(
    body: Body, names: Sequence[str] | None = None, **motion: Unpack[Motion]
) -> tuple[Wall, ...]:
    """A wall of each named surface of a body.

    Parameters
    ----------
    body : Body
    names : sequence of str, optional
        Surfaces that become walls; all, where it is left out.
    motion
        As for every wall, see `geodem.boundaries.walls`.

    Raises
    ------
    InputError
        A surface that the body does not have; facets without a size.
    """
    known = [surface.name for surface in body.surfaces]
    for name in names or ():
        if name not in known:
            raise InputError(
                "walls_from_body", f"the body has no surface {name!r}",
                f"Name one of {', '.join(map(repr, known)) or 'none: it has no surface'}.", value=name,
            )  # fmt: skip
    return tuple(
        facets(surface.name, surface.corners, **motion)
        for surface in body.surfaces
        if names is None or surface.name in names
    )


def _require_section(mesh: Mesh, place: str) -> None:
    if mesh.dimension != 2:
        raise InputError(place, "it takes a section, and this is a volume", "Fill it with fill_body.")
