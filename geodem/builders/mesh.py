"""A mesh of the ground: triangles or tetrahedra with their materials, and the named parts of the boundary.

Quadrilaterals, hexahedra, wedges and pyramids are split without new nodes, so that neighbours still share whole sides
(pulling at the corner of the smallest number: Dompierre et al. 1999, 8th International Meshing Roundtable).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
Whole = NDArray[np.int64]

SIDES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": (
        (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
    ),
}  # fmt: skip
"""Sides of solid elements, outwards by the right hand; corners numbered as VTK does."""


@dataclass(frozen=True)
class Mesh:
    """Triangles of a section or tetrahedra of a volume.

    Attributes
    ----------
    nodes : (n, d) float64 [m]
    cells : (m, d + 1) int32
        Triangles counter-clockwise, tetrahedra of positive volume.
    cell_material : (m,) int32
        Index into `materials`.
    cell_element : (m,) int32
        Number of the element of the file, from 0, that the cell is all or a part of.
    materials : tuple of str
    facets : (f, d) int32
        The boundary: segments with the ground on their left, or triangles whose right-handed normal points out.
    facet_group : (f,) int32
        Index into `groups`, -1 for none.
    groups : tuple of str
        Names of parts of the boundary.
    unjoined : int
        Sides of cells inside the ground whose neighbour does not share their nodes.
    remarks : tuple of str
        What was assumed and repaired when it was read.
    """

    nodes: Floats
    cells: Integers
    cell_material: Integers
    cell_element: Integers
    materials: tuple[str, ...]
    facets: Integers
    facet_group: Integers
    groups: tuple[str, ...]
    unjoined: int = 0
    remarks: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.nodes.shape[1])

    @cached_property
    def cell_sizes(self) -> Floats:
        """Area or volume of every cell (m,) [m2 or m3]."""
        return simplex_sizes(self.nodes[self.cells])

    @cached_property
    def sizes(self) -> Floats:
        """Area or volume of every material [m2 or m3]."""
        return np.asarray(
            np.bincount(self.cell_material, self.cell_sizes, minlength=len(self.materials)), dtype=np.float64
        )


def simplex_sizes(corners: Floats) -> Floats:
    """Signed areas or volumes (m,) of triangles or tetrahedra with corners (m, d + 1, d)."""
    edges = corners[:, 1:] - corners[:, :1]
    if corners.shape[2] == 2:
        return np.asarray(0.5 * (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]))
    return np.asarray((edges[:, 0] * np.cross(edges[:, 1], edges[:, 2])).sum(axis=1) / 6.0)


def split_elements(kind: str, corners: Whole) -> tuple[Whole, Whole]:
    """Triangles or tetrahedra of elements of one kind.

    Parameters
    ----------
    kind : str
        "triangle", "quad" or a key of `SIDES`.
    corners : (k, c) int64
        Nodes of the elements.

    Returns
    -------
    cells : (m, d + 1) int64
        In the order of the elements, with the sense of the element.
    element : (m,) int64
    """
    if kind in ("triangle", "tetra"):
        return corners, np.arange(len(corners))
    if kind == "quad":
        return _fans(corners)
    tip = corners.min(axis=1)
    cells, elements = [], []
    for side in SIDES[kind]:
        face = corners[:, side]
        away = np.flatnonzero((face != tip[:, None]).all(axis=1))
        triangles, owner = (face[away], np.arange(len(away))) if len(side) == 3 else _fans(face[away])
        # seen from the tip, corners of a side that faces outwards run clockwise
        cells.append(np.column_stack([triangles, tip[away][owner]])[:, [1, 0, 2, 3]])
        elements.append(away[owner])
    element = np.concatenate(elements)
    order = np.argsort(element, kind="stable")
    return np.concatenate(cells)[order], element[order]


def _fans(corners: Whole) -> tuple[Whole, Whole]:
    """Two triangles of each quadrilateral (k, 4), divided at its smallest node."""
    turn = (np.argmin(corners, axis=1)[:, None] + np.arange(4)) % 4
    turned = np.take_along_axis(corners, turn, axis=1)
    cells = turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return cells, np.repeat(np.arange(len(corners)), 2)


def cell_facets(cells: Whole) -> Whole:
    """Sides (m, d + 1, d) of cells of positive size, outwards: with the cell on the left of a segment."""
    if cells.shape[1] == 3:
        return cells[:, [[0, 1], [1, 2], [2, 0]]]
    return cells[:, [list(side) for side in SIDES["tetra"]]]


def rows_as_numbers(rows: Whole, nodes: int) -> Whole:
    """One number for each row of node numbers, whatever their order in the row."""
    ordered = np.sort(rows, axis=1)
    if rows.shape[1] == 2 or nodes < 2_000_000:
        number = np.zeros(len(rows), dtype=np.int64)
        for column in ordered.T:
            number = number * nodes + column
        return number
    return np.asarray(np.unique(ordered, axis=0, return_inverse=True)[1], dtype=np.int64).reshape(-1)


def drop_unused(nodes: Floats, *numbers: Whole) -> tuple[Floats, list[Whole]]:
    """Nodes that the first array of numbers uses, and all arrays in the new numbers; -1 where a node is gone."""
    used = np.unique(numbers[0])
    number = np.full(len(nodes), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return nodes[used], [number[rows] for rows in numbers]
