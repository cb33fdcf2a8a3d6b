"""Geometry, meshes and surfaces that `ground_meshes` reads, with their sizes by another count."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders.mesh_gmsh import gmsh_session, silence

Floats = NDArray[np.float64]

LAYERS = {
    "bedrock": [(0.0, 0.0), (40.0, 0.0), (40.0, 9.0), (0.0, 5.0)],
    "seam": [(0.0, 5.0), (40.0, 9.0), (40.0, 10.0), (0.0, 6.0)],
    "soil": [(0.0, 6.0), (40.0, 10.0), (40.0, 20.0), (25.0, 20.0), (10.0, 10.0), (0.0, 10.0)],
}
"""A slope over an inclined seam of 1 m [m]."""
HALF = 4.0
"""Half the side of the plate around the hole [m]; the hole's radius is 1 m."""


def layers_geo(size: float) -> str:
    """A .geo text of `LAYERS`, with elements of `size` [m]."""
    corners = list(dict.fromkeys(corner for outline in LAYERS.values() for corner in outline))
    lines = [f"Point({k + 1}) = {{{x}, {y}, 0, {size}}};" for k, (x, y) in enumerate(corners)]
    drawn: dict[tuple[int, int], int] = {}
    for number, (name, outline) in enumerate(LAYERS.items(), start=1):
        loop = []
        for first, second in zip(outline, [*outline[1:], outline[0]], strict=True):
            a, b = corners.index(first) + 1, corners.index(second) + 1
            if (b, a) in drawn:
                loop.append(-drawn[b, a])
                continue
            drawn[a, b] = len(drawn) + 1
            lines.append(f"Line({drawn[a, b]}) = {{{a}, {b}}};")
            loop.append(drawn[a, b])
        lines.append(f"Curve Loop({number}) = {{{', '.join(map(str, loop))}}};")
        lines.append(f"Plane Surface({number}) = {{{number}}};")
        lines.append(f'Physical Surface("{name}") = {{{number}}};')
    lines.append('Physical Curve("base") = {1};')
    return "\n".join(lines) + "\n"


def write_layers(path: Path, size: float, version: float) -> Path:
    """A .msh file of `LAYERS`, by gmsh."""
    geo = path.with_suffix(".geo")
    geo.write_text(layers_geo(size))
    with gmsh_session(geo) as gmsh:
        gmsh.merge(str(geo))
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(path))
    return path


def write_tunnel_block(path: Path) -> float:
    """A STEP file of a block of 20 m with a round tunnel of 3 m radius through it; its volume [m3]."""
    with gmsh_session(path) as gmsh:
        occ = gmsh.model.occ
        block = occ.addBox(0.0, 0.0, 0.0, 20.0, 20.0, 20.0)
        tube = occ.addCylinder(10.0, 0.0, 10.0, 0.0, 20.0, 0.0, 3.0)
        occ.cut([(3, block)], [(3, tube)])
        occ.synchronize()
        with silence():
            gmsh.write(str(path))
    return 20.0**3 - math.pi * 3.0**2 * 20.0


def write_stl(path: Path, corners: Floats) -> Path:
    """A binary .stl file of triangles (f, 3, 3) [m]."""
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets["corners"] = corners
    path.write_bytes(b" " * 80 + np.uint32(len(corners)).tobytes() + facets.tobytes())
    return path


def egg(count: int) -> tuple[Floats, float]:
    """Triangles (f, 3, 3) [m] of the hull of points on an ellipsoid, 12 m long, and its volume [m3] by qhull."""
    from scipy.spatial import ConvexHull

    # evenly spread: a golden spiral
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    wide = np.sqrt(1.0 - z * z)
    points = np.stack([wide * np.cos(angle), wide * np.sin(angle), z], axis=1) * [6.0, 5.0, 4.0]
    hull = ConvexHull(points.astype(np.float32).astype(np.float64))
    corners = hull.points[hull.simplices]
    outwards = (
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * hull.equations[:, :3]
    ).sum(1)
    return np.where(outwards[:, None, None] > 0.0, corners, corners[:, ::-1]), float(hull.volume)


def hole_geo(fine: float, coarse: float) -> str:
    """A .geo text of a plate with a hole of 1 m radius, elements of `fine` at the hole and `coarse` outside [m]."""
    ring = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    rim = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    lines = ["Point(1) = {0, 0, 0};"]
    lines += [f"Point({k + 2}) = {{{x}, {y}, 0, {fine}}};" for k, (x, y) in enumerate(ring)]
    lines += [f"Point({k + 6}) = {{{HALF * x}, {HALF * y}, 0, {coarse}}};" for k, (x, y) in enumerate(rim)]
    lines += [f"Circle({k + 1}) = {{{k + 2}, 1, {(k + 1) % 4 + 2}}};" for k in range(4)]
    lines += [f"Line({k + 5}) = {{{k + 6}, {(k + 1) % 8 + 6}}};" for k in range(8)]
    lines += ["Curve Loop(1) = {1:4};", "Curve Loop(2) = {5:12};", "Plane Surface(1) = {2, 1};"]
    lines += [
        'Physical Surface("rock") = {1};',
        'Physical Curve("tunnel") = {1:4};',
        'Physical Curve("far") = {5:12};',
    ]
    return "\n".join(lines) + "\n"
