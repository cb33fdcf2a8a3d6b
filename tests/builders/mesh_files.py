"""Mesh and surface files that the tests write by hand, so that what they hold is known."""

from __future__ import annotations

import numpy as np

KINDS = {"line": 1, "triangle": 2, "quad": 3, "tetra": 4, "hexahedron": 5, "wedge": 6, "pyramid": 7, "line3": 8,
         "triangle6": 9, "vertex": 15, "polygon": 2}  # fmt: skip


def write_msh(path, nodes, elements, names=()):
    """A text file of version 2.2.

    `elements`: (kind, nodes from 0, number of the physical group); `names`: (dimension, number, name).
    """
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if names:
        lines += ["$PhysicalNames", str(len(names))]
        lines += [f'{dimension} {number} "{name}"' for dimension, number, name in names]
        lines += ["$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes))]
    for k, node in enumerate(nodes):
        x, y, z = [*node, 0.0][:3]
        lines.append(f"{k + 1} {x!r} {y!r} {z!r}")
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for k, (kind, corners, group) in enumerate(elements):
        lines.append(f"{k + 1} {KINDS[kind]} 2 {group} {group} {' '.join(str(c + 1) for c in corners)}")
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n")
    return path


SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0)]
FOUR = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
"""Triangles of `SQUARE`, counter-clockwise, of 1 m2 each."""


def square(path, triangles=FOUR, nodes=SQUARE, group=1, names=((2, 1, "clay"),), more=()):
    """A square of four triangles in one material."""
    return write_msh(path, nodes, [*(("triangle", t, group) for t in triangles), *more], names)


CUBE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 1.0)]  # fmt: skip
"""Corners of a cube as a hexahedron has them."""


def cube_facets(low=(0.0, 0.0, 0.0), side=1.0):
    """Triangles (12, 3, 3) of a cube, outwards."""
    corners = np.array(low) + side * np.array(CUBE)
    quads = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return np.array([corners[list(t)] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def write_stl(path, corners):
    """A binary file of triangles (f, 3, 3)."""
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets["corners"] = corners
    path.write_bytes(b" " * 80 + np.uint32(len(corners)).tobytes() + facets.tobytes())
    return path
