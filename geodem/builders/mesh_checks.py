"""What can be wrong with a mesh: repaired and told where that is safe, else refused with number and place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.mesh import cell_facets, rows_as_numbers, simplex_sizes
from geodem.builders.point_location import SimplexLocator
from geodem.errors import InputError

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

SMALLEST, LARGEST = 0.01, 10_000.0
"""Spans [m] that are believed without a unit: from a specimen to the largest pit."""
SAME_NODE = 1e-8
"""Nodes nearer to each other than this share of the span are one."""
FLAT = 1e-10
"""Size of a cell over the power of its longest side at or below which it has none."""
OVERLAP = 1e-4
"""Share of the whole that may be counted twice, as parts meshed apart along a curve do."""
LOOK = {
    3: np.concatenate([np.full((1, 3), 1 / 3), 0.6 * np.eye(3) + 0.4 / 3, 0.2 + 0.4 * (1.0 - np.eye(3)) - 0.4 / 3]),
    4: np.concatenate([np.full((1, 4), 0.25), 0.6 * np.eye(4) + 0.1]),
}  # fmt: skip
"""Barycentric coordinates, by the number of corners, at which it is asked whether a cell lies in another."""


class Facets(NamedTuple):
    """The boundary: nodes (f, d) int64, and how many sides of cells lie inside the ground without a neighbour."""

    nodes: Whole
    unjoined: int


def place_of(point: Floats) -> str:
    """A point as text."""
    return "(" + ", ".join(f"{c:.6g}" for c in np.atleast_1d(point)) + ") m"


def check_span(place: str, extent: Floats, unit: float | None, own_unit: bool) -> list[str]:
    """Refuse a span that is likely in another unit; say what was assumed.

    Parameters
    ----------
    place : str
    extent : (d,) [m]
    unit : float, optional
        [m] per unit, where the caller gives it.
    own_unit : bool
        The file says its unit.
    """
    size = " by ".join(f"{side:.4g} m" for side in extent)
    if unit is not None:
        return []
    if own_unit:
        said = f"The file says its own unit: the ground is {size}."
    else:
        said = f"No length_unit was given, so coordinates are metres: the ground is {size}."
    span = float(extent.max())
    if span > LARGEST or span < SMALLEST:
        if own_unit:
            remedy = (
                'Give the unit that its numbers have in truth, for instance length_unit = "m" (1 in Python).'
            )
        elif span > LARGEST:
            remedy = 'Give length_unit = "mm" (0.001 in Python), or "m" (1) if it is right.'
        else:
            remedy = 'Give length_unit = "km" (1000 in Python), or "m" (1) if it is right.'
        raise InputError(f"{place}, length_unit", f"the ground would be {size}", remedy)
    return [said]


def merge_nodes(nodes: Floats, share: float = SAME_NODE) -> tuple[Whole, int]:
    """Number of the node that each node (n, d) is merged into, the lowest of those nearer than `share` of the span.

    Returns the numbers (n,), and how many nodes are gone.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    span = float(np.ptp(nodes, axis=0).max())
    unique, number = np.unique(nodes, axis=0, return_inverse=True)
    number = number.reshape(-1)
    near = cKDTree(unique).query_pairs(share * span, output_type="ndarray")
    graph = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(unique), len(unique)))
    parts, label = connected_components(graph, directed=False)
    first = np.full(parts, len(nodes), dtype=np.int64)
    np.minimum.at(first, label[number], np.arange(len(nodes)))
    return first[label[number]], len(nodes) - parts


def without_size(nodes: Floats, cells: Whole) -> NDArray[np.bool_]:
    """Which cells (m, d + 1) have no area or volume."""
    corners = nodes[cells]
    longest = np.zeros(len(cells))
    for first in range(cells.shape[1]):
        for second in range(first):
            longest = np.maximum(longest, np.linalg.norm(corners[:, first] - corners[:, second], axis=1))
    power = 2 if cells.shape[1] == 3 else 3
    return np.asarray(np.abs(simplex_sizes(corners)) <= FLAT * longest**power)


def turn_over(place: str, nodes: Floats, cells: Whole, element: Whole) -> tuple[Whole, list[str]]:
    """Cells of positive size, and what was said about those that were not.

    Raises InputError for an element with parts of either sense: it is folded.
    """
    negative = simplex_sizes(nodes[cells]) < 0.0
    if not negative.any():
        return cells, []
    parts = np.bincount(element)
    inverted = np.bincount(element, negative, minlength=len(parts))
    folded = np.flatnonzero((inverted > 0) & (inverted < parts))
    if len(folded):
        middle = nodes[cells[element == folded[0]]].mean(axis=(0, 1))
        raise InputError(
            place, f"{len(folded)} elements are folded: their sides cross, the first at {place_of(middle)}",
            "Number their corners around the element, or mesh again.",
        )  # fmt: skip
    cells = np.where(negative[:, None], cells[:, [1, 0, *range(2, cells.shape[1])]], cells)
    count = int((inverted > 0).sum())
    of = f"{count} of {int((parts > 0).sum())}"
    return cells, [f"{of} elements were inverted, with corners in the wrong sense; they were turned over."]


def find_boundary(place: str, nodes: Floats, cells: Whole, locator: SimplexLocator) -> Facets:
    """Sides of one cell only, outwards, without those that lie on another cell.

    Raises InputError where more than two cells share a side, as copies of an element do.
    """
    sides = cell_facets(cells).reshape(-1, cells.shape[1] - 1)
    numbers = rows_as_numbers(sides, len(nodes))
    _, first, times = np.unique(numbers, return_index=True, return_counts=True)
    if (times > 2).any():
        worst = int(first[np.argmax(times)])
        what = "edge" if cells.shape[1] == 3 else "face"
        raise InputError(
            place, f"{int((times > 2).sum())} {what}s belong to more than two elements, as copies of elements make "
            f"them, the first at {place_of(nodes[sides[worst]].mean(axis=0))}",
            "Remove elements that are there twice, or mesh the bodies so that they share their boundary.",
        )  # fmt: skip
    outer = sides[np.sort(first[times == 1])]
    corners = nodes[outer]
    middle = corners.mean(axis=1)
    outwards = facet_normals(corners)
    length = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    outside, _ = locator.locate(middle + 1e-6 * length[:, None] * outwards)
    free = outside < 0
    return Facets(outer[free], int((~free).sum()))


def facet_normals(corners: Floats) -> Floats:
    """Unit normals (f, d) of segments or triangles: to the right of a segment, by the right hand over a triangle."""
    along = corners[:, 1] - corners[:, 0]
    if corners.shape[2] == 2:
        normal = np.column_stack([along[:, 1], -along[:, 0]])
    else:
        normal = np.cross(along, corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300))


def refuse_overlap(
    place: str, corners: Floats, material: Whole, names: list[str], locator: SimplexLocator
) -> list[str]:
    """Refuse elements that lie in each other; say so where it is next to nothing."""
    weights = LOOK[corners.shape[1]]
    points = np.einsum("wc,mcd->mwd", weights, corners)
    found, second = locator.locate(points.reshape(-1, corners.shape[2]))
    own = np.repeat(np.arange(len(corners)), len(weights))
    # a point of a cell that another one holds deeper has itself as the second
    other = np.where(found == own, second, found)
    twice = np.flatnonzero((other >= 0) & (second >= 0) & (other != own))
    if not len(twice):
        return []
    sizes = np.abs(simplex_sizes(corners))
    # what two cells share is seen from both
    both = 0.5 * float(sizes[own[twice]].sum()) / len(weights)
    # the most frequent pair of materials names the bodies
    pairs = np.sort(np.column_stack([material[own[twice]], material[other[twice]]]), axis=1)
    kinds, of, times = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    most = int(np.argmax(times))
    first, last = (names[int(k)] for k in kinds[most])
    between = f"{first!r} and {last!r}" if first != last else f"elements of {first!r}"
    middle = points.reshape(-1, corners.shape[2])[twice[of.reshape(-1) == most]].mean(axis=0)
    unit = "m2" if corners.shape[2] == 2 else "m3"
    if both <= OVERLAP * float(sizes.sum()):
        return [f"{between} overlap by about {both:.3g} {unit} around {place_of(middle)}; it was left."]
    raise InputError(
        place, f"{between} overlap by about {both:.4g} {unit} around {place_of(middle)}",
        "Cut one body out of the other before meshing, or remove elements that are there twice.",
    )  # fmt: skip
