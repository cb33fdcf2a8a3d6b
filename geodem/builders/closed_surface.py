"""Closed surfaces of triangles: read, repaired, turned so that they face outwards, and refused where they are open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders import mesh_checks as checks
from geodem.builders.mesh import drop_unused, rows_as_numbers
from geodem.builders.mesh_source import read_file
from geodem.builders.point_location import SurfaceLocator
from geodem.errors import InputError

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

SAME_CORNER = 1e-6
"""Corners nearer to each other than this share of the span are one: a file has seven digits."""
THIN = 1e-9
"""Twice the area of a triangle over the square of its longest side at or below which it has none."""


@dataclass(frozen=True)
class ClosedSurface:
    """Corners (f, 3, 3) float64 [m] of triangles that face outwards, and what was repaired."""

    corners: Floats
    remarks: tuple[str, ...]

    @property
    def volume(self) -> float:
        """Volume [m3], by the divergence theorem."""
        return enclosed_volume(self.corners)


def enclosed_volume(corners: Floats) -> float:
    """Volume [m3] inside triangles (f, 3, 3) that face outwards."""
    a, b, c = (corners[:, k] - corners.mean(axis=(0, 1)) for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def read_surface(path: Path, unit: float) -> Floats:
    """Corners (f, 3, 3) [m] of the triangles of a file; quadrilaterals are divided.

    Raises
    ------
    InputError
        No such file, or one that cannot be read or holds no triangles.
    """
    if not path.is_file():
        raise InputError(str(path), "there is no such file", "Mend the path.")
    source = read_file(path, None, None)
    found = [part.corners for part in source.elements if part.kind == "triangle"]
    found += [
        part.corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3) for part in source.elements if part.kind == "quad"
    ]
    if source.dimension != 2 or not found:
        raise InputError(
            str(path), "it holds no surface of triangles", "Export the surface of the body as .stl."
        )
    return np.asarray(source.points[np.concatenate(found)] * unit)


def close_surface(place: str, corners: Floats) -> ClosedSurface:
    """Check and repair a surface.

    Corners at one place are merged, triangles without an area removed, shells turned so that they face out of the
    material: the outermost outwards, holes in it inwards. What was done is in the remarks.

    Raises
    ------
    InputError
        An edge of one triangle only, of more than two, a surface with one side, shells that cross.
    """
    remarks = []
    nodes, faces = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
    exact, inverse = np.unique(nodes, axis=0, return_inverse=True)
    into, gone = checks.merge_nodes(exact, SAME_CORNER)
    if gone:
        remarks.append(
            f"{gone} corners lay next to another, within a millionth of the span; they were merged."
        )
    nodes, (faces,) = drop_unused(exact, into[inverse.reshape(-1)][faces])
    thin = _without_area(nodes[faces])
    if thin.any():
        remarks.append(
            f"{int(thin.sum())} triangles without an area were removed, the first at "
            f"{checks.place_of(nodes[faces[np.argmax(thin)]].mean(axis=0))}."
        )
        faces = faces[~thin]
    if not len(faces):
        raise InputError(place, "none of its triangles has an area", "Export it again.")
    _, first = np.unique(rows_as_numbers(faces, len(nodes)), return_index=True)
    if len(first) < len(faces):
        remarks.append(f"{len(faces) - len(first)} triangles were there twice; one of each was kept.")
        faces = faces[np.sort(first)]
    _refuse_open(place, nodes, faces)
    faces, shell, turned = _agree(place, nodes, faces)
    faces, more = _outwards(place, nodes, faces, shell, remarks)
    turned ^= more
    if turned.any():
        remarks.append(f"{int(turned.sum())} of {len(faces)} triangles faced inwards; they were turned over.")
    return ClosedSurface(nodes[faces], tuple(remarks))


def _without_area(corners: Floats) -> NDArray[np.bool_]:
    a, b, c = (corners[:, k] for k in range(3))
    longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) <= THIN * longest)


def _edges(faces: Whole) -> Whole:
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def _refuse_open(place: str, nodes: Floats, faces: Whole) -> None:
    edges = _edges(faces)
    _, first, uses = np.unique(rows_as_numbers(edges, len(nodes)), return_index=True, return_counts=True)
    for wrong, what, remedy in (
        (
            uses == 1,
            "open: {} edges belong to one triangle only",
            "Close the holes in the program that drew it",
        ),
        (
            uses > 2,
            "not one skin: {} edges belong to more than two triangles",
            "Give bodies that touch a file each, or remove inner walls",
        ),
    ):
        if wrong.any():
            where = nodes[edges[np.sort(first[wrong])[0]]].mean(axis=0)
            count = int(wrong.sum())
            raise InputError(
                place,
                f"the surface is {what.format(count)}, the first at {checks.place_of(where)}",
                remedy + ".",
            )


def _agree(place: str, nodes: Floats, faces: Whole) -> tuple[Whole, Whole, NDArray[np.bool_]]:
    """Triangles whose neighbours agree on the side, the shell of each, and which were turned over for that.

    Within a shell the sense of the majority is kept.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    edges = _edges(faces)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.argsort(rows_as_numbers(edges, len(nodes)), kind="stable")
    first, second = order[::2], order[1::2]
    # neighbours that agree run along their edge in opposite senses
    against = (edges[first] == edges[second]).all(axis=1)
    count = len(faces)
    # 1: the same sense, 2: opposite senses
    weight = np.where(against, 2.0, 1.0)
    pairs = np.concatenate([owner[first], owner[second]]), np.concatenate([owner[second], owner[first]])
    graph = coo_array((np.ones(2 * len(first)), pairs), shape=(count, count)).tocsr()
    shells, shell = connected_components(graph, directed=False)
    turned = np.zeros(count, dtype=bool)
    if against.any():
        senses = {}
        for a, b, w in zip(owner[first].tolist(), owner[second].tolist(), weight.tolist(), strict=True):
            senses[a, b] = senses[b, a] = w == 2.0
        for number in range(shells):
            root = int(np.argmax(shell == number))
            visited, before = breadth_first_order(graph, root, directed=False)
            for face in visited[1:].tolist():
                parent = int(before[face])
                turned[face] = turned[parent] ^ senses[parent, face]
        agree = turned[owner[first]] ^ turned[owner[second]] == against
        if not agree.all():
            where = nodes[edges[first[np.argmin(agree)]]].mean(axis=0)
            raise InputError(
                place, f"the surface has one side only, like a Moebius strip, around {checks.place_of(where)}",
                "Close it in the program that drew it.",
            )  # fmt: skip
        for number in range(shells):
            mine = shell == number
            if 2 * int(turned[mine].sum()) > int(mine.sum()):
                turned[mine] ^= True
    return np.where(turned[:, None], faces[:, ::-1], faces), np.asarray(shell, dtype=np.int64), turned


def _outwards(
    place: str, nodes: Floats, faces: Whole, shell: Whole, remarks: list[str]
) -> tuple[Whole, NDArray[np.bool_]]:
    """Shells turned outwards, those in an odd number of others inwards; and which triangles were turned."""
    shells = int(shell.max()) + 1
    depth = np.zeros(shells, dtype=int)
    if shells > 1:
        low, high = np.full((shells, 3), np.inf), np.full((shells, 3), -np.inf)
        np.minimum.at(low, shell, nodes[faces].min(axis=1))
        np.maximum.at(high, shell, nodes[faces].max(axis=1))
        for outer in range(shells):
            meets = ((low <= high[outer]) & (high >= low[outer])).all(axis=1)
            meets[outer] = False
            if not meets.any():
                continue
            locator = SurfaceLocator(nodes[faces[shell == outer]])
            for inner in np.flatnonzero(meets):
                corners = nodes[faces[shell == inner]]
                inside = locator.encloses(corners.mean(axis=1))
                if inside.any() and not inside.all():
                    where = corners[inside].mean(axis=(0, 1))
                    raise InputError(
                        place, f"two of its {shells} shells cross each other around {checks.place_of(where)}",
                        "Join them in the program that drew them, or give each a file.",
                    )  # fmt: skip
                depth[inner] += int(inside.all())
        holes = int((depth % 2 == 1).sum())
        remarks.append(
            f"The surface has {shells} shells" + (f", {holes} of them around holes." if holes else ".")
        )
    turned = np.zeros(len(faces), dtype=bool)
    for number in range(shells):
        mine = shell == number
        outwards = enclosed_volume(nodes[faces[mine]]) > 0.0
        if outwards != (depth[number] % 2 == 0):
            turned |= mine
    return np.where(turned[:, None], faces[:, ::-1], faces), turned


def shared_facets(parts: Sequence[Floats]) -> list[NDArray[np.bool_]]:
    """Which triangles of several surfaces (f, 3, 3) lie exactly on one of another surface."""
    every = np.concatenate(parts)
    exact, inverse = np.unique(every.reshape(-1, 3), axis=0, return_inverse=True)
    into, _ = checks.merge_nodes(exact, SAME_CORNER)
    faces = into[inverse.reshape(-1)].reshape(-1, 3)
    _, which, uses = np.unique(rows_as_numbers(faces, len(exact)), return_inverse=True, return_counts=True)
    shared = uses[which.reshape(-1)] > 1
    return np.split(shared, np.cumsum([len(part) for part in parts])[:-1])
