"""Read a mesh or mesh a geometry, check it, repair what can be repaired, and say what was done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders import mesh_checks as checks
from geodem.builders.mesh import Mesh, drop_unused, rows_as_numbers, split_elements
from geodem.builders.mesh_gmsh import STEP, read_with_gmsh, step_unit
from geodem.builders.mesh_source import MeshSource, read_file
from geodem.builders.point_location import SimplexLocator
from geodem.errors import InputError

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

MESHES = (".msh", ".vtk", ".vtu", ".inp", ".stl")
GEOMETRIES = (".geo", ".geo_unrolled", *STEP)


def read_mesh(
    path: str | Path,
    *,
    length_unit: float | None = None,
    size: float | None = None,
    names: Mapping[int, str] | None = None,
    material_array: str | None = None,
) -> Mesh:
    """Read a section or a volume with its materials.

    Triangles and quadrilaterals of a plane make a section, tetrahedra, hexahedra, wedges and pyramids a volume.
    Physical groups name materials and parts of the boundary; in .inp files element sets do, in .vtk and .vtu files an
    array of the cells numbers materials.

    Parameters
    ----------
    path : str or Path
        .msh (2 and 4), .vtk, .vtu, .inp; .geo and .step, which gmsh meshes; a flat .stl. What an .stl or other surface
        encloses in space is a `geodem.builders.solid_body.SolidBody`.
    length_unit : float, optional
        Metres per unit of the file: 0.001 for millimetres. Left out: 1, and what STEP files say; a span below 1 cm or
        beyond 10 km is refused then.
    size : float, optional
        Largest side of an element where gmsh meshes [m].
    names : dict, optional
        Materials by number, for groups without a name: of a group, of an array's value, of a surface or volume.
    material_array : str, optional
        Array of the cells that numbers the materials, for .vtk and .vtu.

    Returns
    -------
    Mesh
        `remarks` says what was assumed and repaired: turned over, merged, removed.

    Raises
    ------
    InputError
        No such file, one that cannot be read or has elements that cannot be used; a surface where a volume is needed;
        a span that looks like another unit; elements without a material or folded; bodies that overlap.
    """
    path = Path(path)
    source = _source(path, length_unit, size, names, material_array)
    if length_unit is not None:
        declared = step_unit(path) if path.suffix.lower() in STEP else 1.0
        if declared is None:
            raise InputError(
                str(path), "its own unit of length is not understood, so that another one cannot replace it",
                "Leave length_unit out.", value=length_unit,
            )  # fmt: skip
        source.points *= length_unit / declared
    return _check(path, source, length_unit)


def _source(
    path: Path,
    length_unit: float | None,
    size: float | None,
    names: Mapping[int, str] | None,
    material_array: str | None,
) -> MeshSource:
    if length_unit is not None and not (math.isfinite(length_unit) and length_unit > 0.0):
        raise InputError("length_unit", "not a positive length in m", "Give 0.001 for mm.", value=length_unit)
    if size is not None and not (math.isfinite(size) and size > 0.0):
        raise InputError("size", "not a positive length in m", "Give for example 0.5.", value=size)
    suffix = path.suffix.lower()
    if not path.is_file():
        raise InputError(str(path), "there is no such file", "Mend the path.")
    if suffix in GEOMETRIES:
        scale = 1.0 if length_unit is None else length_unit
        if suffix in STEP:
            scale /= step_unit(path) or 1.0 if length_unit is not None else 1.0
        return read_with_gmsh(path, None if size is None else size / scale, names)
    if suffix not in MESHES:
        raise InputError(
            str(path), f"files of the kind {suffix or 'without an ending'!r} are not read",
            f"Give one of {', '.join((*MESHES, *GEOMETRIES))}.",
        )  # fmt: skip
    if size is not None:
        raise InputError(
            "size",
            f"{path.name} is a mesh already",
            "Leave it out, or give the .geo or .step file.",
            value=size,
        )
    return read_file(path, names, material_array)


def _check(path: Path, source: MeshSource, length_unit: float | None) -> Mesh:
    place = str(path)
    top = source.dimension
    if top < 2:
        raise InputError(
            place, "it holds neither surfaces nor volumes", "Export triangles or tetrahedra, too."
        )
    remarks = list(source.all_remarks())
    cells, element, group = _cells(source, top)
    points = _in_plane(path, source.points, cells, remarks) if top == 2 else source.points
    remarks += checks.check_span(
        place, np.ptp(points[np.unique(cells)], axis=0), length_unit, source.unit is not None
    )
    facets, facet_group = _given_facets(source, top)
    points, (cells, facets) = drop_unused(points, cells, facets)
    whole = (facets >= 0).all(axis=1)
    facets, facet_group = facets[whole], facet_group[whole]
    into, gone = checks.merge_nodes(points)
    if gone:
        # a surface of loose triangles has each corner several times: nothing that needs telling
        if path.suffix.lower() != ".stl":
            remarks.append(f"{gone} nodes lay at the place of another; they were merged.")
        points, (cells, facets) = drop_unused(points, into[cells], into[facets])
    empty = checks.without_size(points, cells)
    if empty.all():
        raise InputError(place, "none of its elements has a size", "Export it again.")
    if empty.any():
        what = "triangles without an area" if top == 2 else "tetrahedra without a volume"
        middle = points[cells[np.argmax(empty)]].mean(axis=0)
        remarks.append(f"{int(empty.sum())} {what} were removed, the first at {checks.place_of(middle)}.")
        cells, element, group = cells[~empty], element[~empty], group[~empty]
        points, (cells, facets) = drop_unused(points, cells, facets)
    cells, told = checks.turn_over(place, points, cells, element)
    remarks += told
    names, material = _materials(path, source.names[top], points, cells, group, remarks)
    locator = SimplexLocator(points[cells])
    boundary = checks.find_boundary(place, points, cells, locator)
    remarks += checks.refuse_overlap(place, points[cells], material, names, locator)
    if boundary.unjoined:
        remarks.append(
            f"{boundary.unjoined} sides of elements lie inside the ground without a neighbour that shares their nodes: "
            "parts that were meshed apart do not hold together where particles stand on nodes."
        )
    numbers, groups = _boundary_groups(
        source.names[top - 1], boundary.nodes, facets, facet_group, len(points), remarks
    )
    return Mesh(
        nodes=points,
        cells=cells.astype(np.int32),
        cell_material=material.astype(np.int32),
        cell_element=element.astype(np.int32),
        materials=tuple(names),
        facets=boundary.nodes.astype(np.int32),
        facet_group=numbers.astype(np.int32),
        groups=tuple(groups),
        unjoined=boundary.unjoined,
        remarks=tuple(remarks),
    )


def _cells(source: MeshSource, top: int) -> tuple[Whole, Whole, Whole]:
    """Triangles or tetrahedra, the number of the element of each, and its group."""
    cells, elements, groups, before = [], [], [], 0
    for part in source.elements:
        if part.dimension == top:
            own, element = split_elements(part.kind, part.corners)
            cells.append(own)
            elements.append(element + before)
            groups.append(part.group[element])
            before += len(part.corners)
    return np.concatenate(cells), np.concatenate(elements), np.concatenate(groups)


def _given_facets(source: MeshSource, top: int) -> tuple[Whole, Whole]:
    """Segments or triangles of named parts of the boundary, and their group."""
    facets, groups = [np.empty((0, top), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for part in source.elements:
        if part.dimension != top - 1:
            continue
        named = np.flatnonzero(part.group >= 0)
        own, element = (
            (part.corners[named], np.arange(len(named))) if top == 2 else split_elements(part.kind, part.corners[named])
        )  # fmt: skip
        facets.append(own)
        groups.append(part.group[named][element])
    return np.concatenate(facets), np.concatenate(groups)


def _in_plane(path: Path, points: Floats, cells: Whole, remarks: list[str]) -> Floats:
    """Two coordinates of the points of a flat mesh."""
    used = points[np.unique(cells)]
    extent = np.ptp(used, axis=0)
    flat = extent <= 1e-9 * extent.max()
    if flat[2]:
        return np.ascontiguousarray(points[:, :2])
    for axis, name in ((1, "x and z"), (0, "y and z")):
        if flat[axis]:
            remarks.append(f"The section stands upright in space: its coordinates are {name} of the file.")
            return np.ascontiguousarray(np.delete(points, axis, axis=1))
    remedy = "Mesh the volume that it encloses"
    if path.suffix.lower() == ".stl":
        remedy = "Make a body of what it encloses: geodem.builders.from_mesh.body_from_mesh"
    raise InputError(
        str(path),
        f"it is a surface in space ({len(cells)} triangles), neither a flat section nor a volume",
        remedy,
    )


def _materials(
    path: Path, names: list[str], points: Floats, cells: Whole, group: Whole, remarks: list[str]
) -> tuple[list[str], Whole]:
    without = group < 0
    if without.all():
        name = path.stem
        remarks.append(f"No physical group names a material: all of it is called {name!r}, after the file.")
        return [name], np.zeros(len(cells), dtype=np.int64)
    if without.any():
        middle = points[cells[np.argmax(without)]].mean(axis=0)
        raise InputError(
            str(path), f"{int(without.sum())} of {len(cells)} elements are in no physical group, the first at "
            f"{checks.place_of(middle)}",
            "Put every surface (3D: volume) into a physical group that names its material.",
        )  # fmt: skip
    used = np.unique(group)
    number = np.full(len(names), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return [names[k] for k in used], number[group]


def _boundary_groups(
    names: list[str], boundary: Whole, facets: Whole, group: Whole, nodes: int, remarks: list[str]
) -> tuple[Whole, list[str]]:
    """Group of every facet of the boundary, and the names of the groups that have any."""
    numbers = rows_as_numbers(np.concatenate([boundary, facets]), nodes)
    own, given = numbers[: len(boundary)], numbers[len(boundary) :]
    order = np.argsort(given, kind="stable")
    found = np.full(len(boundary), -1, dtype=np.int64)
    if len(given):
        spot = np.minimum(np.searchsorted(given[order], own), len(given) - 1)
        hit = given[order][spot] == own
        found[hit] = group[order][spot[hit]]
    for index, name in enumerate(names):
        wanted, taken = int((group == index).sum()), int((found == index).sum())
        if taken < wanted:
            remarks.append(
                f"{wanted - taken} of {wanted} facets of {name!r} do not lie on the boundary of the ground; they bound "
                "nothing."
            )
    used = np.unique(found[found >= 0])
    number = np.full(len(names) + 1, -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return number[found], [names[k] for k in used]
