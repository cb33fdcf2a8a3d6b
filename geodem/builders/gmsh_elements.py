"""What gmsh made of a geometry: elements with their groups, and what they leave out of curved bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geodem.builders.mesh import simplex_sizes
from geodem.builders.mesh_file import CORNERS
from geodem.builders.mesh_source import Elements, MeshSource
from geodem.errors import InputError

KINDS = {1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge", 7: "pyramid"}
"""gmsh's numbers of the linear elements."""
TOLD = 1e-4
"""Share of the size as drawn from which a difference is told."""


def drawn_size(gmsh: Any, top: int, used: Sequence[int]) -> float | None:
    """Area or volume of surfaces or volumes as drawn; None where OpenCASCADE does not know them."""
    known = {tag for _, tag in gmsh.model.occ.getEntities(top)}
    if not known.issuperset(used):
        return None
    return float(sum(gmsh.model.occ.getMass(top, tag) for tag in used))


def take_elements(
    gmsh: Any,
    path: Path,
    top: int,
    used: Sequence[int],
    groups: Mapping[int, Mapping[int, str]],
    source: MeshSource,
) -> None:
    """Write nodes and elements of the `used` surfaces or volumes, and of what bounds them, into the source.

    Raises InputError where there are none, or of a kind that cannot be used.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.full(int(tags.max(initial=0)) + 1, -1, dtype=np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    source.points = np.reshape(coordinates, (-1, 3)).copy()
    for dimension in (top - 1, top):
        entities = used if dimension == top else [tag for _, tag in gmsh.model.getEntities(dimension)]
        for entity in entities:
            kinds, _, nodes = gmsh.model.mesh.getElements(dimension, entity)
            for kind, corners in zip(kinds.tolist(), nodes, strict=True):
                if kind not in KINDS:
                    raise InputError(
                        str(path), "its elements have nodes between their corners", "Mesh it with order 1."
                    )
                rows = number[corners.astype(np.int64)].reshape(-1, CORNERS[KINDS[kind]])
                group = np.full(len(rows), source.group_number(dimension, groups[dimension].get(entity)))
                source.elements.append(Elements(KINDS[kind], rows, group))
    if source.dimension < top:
        raise InputError(str(path), "gmsh made no elements of it", "Mesh it in gmsh to see why.")


def size_remarks(source: MeshSource, top: int, drawn: float | None) -> list[str]:
    """What flat sides of elements leave out of curved bodies, or add to them."""
    cells = [part.corners for part in source.elements if part.kind == ("triangle" if top == 2 else "tetra")]
    whole = sum(len(part.corners) for part in source.elements if part.dimension == top) == sum(
        map(len, cells)
    )
    if not drawn or not whole:
        return []
    corners = source.points[np.concatenate(cells)]
    if top == 3:
        made = float(np.abs(simplex_sizes(corners)).sum())
    else:
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        made = 0.5 * float(np.linalg.norm(np.cross(a, b), axis=1).sum())
    share = made / drawn - 1.0
    if abs(share) < TOLD:
        return []
    return [
        f"Elements with flat sides hold {100.0 * share:+.2f} % of the {'area' if top == 2 else 'volume'} as drawn; "
        "smaller ones come closer."
    ]
