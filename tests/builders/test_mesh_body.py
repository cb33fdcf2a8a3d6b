"""Materials, sizes and surfaces of a mesh as a body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from geodem.builders.body import OUTSIDE
from geodem.builders.mesh import Mesh, cell_facets, simplex_sizes
from geodem.builders.mesh_body import MeshBody
from geodem.builders.mesh_checks import facet_normals
from geodem.builders.mesh_reading import read_mesh
from geodem.builders.point_location import SimplexLocator
from tests.builders.mesh_files import CUBE, FOUR, SQUARE, square, write_msh


def hull(dimension, count, seed=1):
    """Cells of random points, by qhull, without slivers."""
    found = Delaunay(np.random.default_rng(seed).random((count, dimension)))
    corners = found.points[found.simplices]
    return found, corners, np.abs(simplex_sizes(corners)) > 1e-12


@pytest.mark.parametrize(("dimension", "count"), [(2, 3000), (3, 1500)])
def test_points_are_found_where_qhull_finds_them(dimension, count):
    found, corners, kept = hull(dimension, count)
    points = np.random.default_rng(2).uniform(-0.1, 1.1, (40_000, dimension))
    own = np.flatnonzero(kept)
    mine, second = SimplexLocator(corners[kept]).locate(points)
    theirs = found.find_simplex(points)
    assert (theirs < 0).sum() > 1000
    assert ((mine >= 0) == (theirs >= 0)).all()
    inside = mine >= 0
    assert (own[mine[inside]] == theirs[inside]).all()
    assert (second == -1).all()


def test_points_on_common_sides_belong_to_one_cell():
    """Nodes, middles of sides: inside, and in one of the cells that have them."""
    _, corners, kept = hull(3, 400)
    locator = SimplexLocator(corners[kept])
    own = np.repeat(np.arange(kept.sum()), 3)
    points = np.stack([corners[kept][:, : k + 1].mean(axis=1) for k in range(3)], axis=1).reshape(-1, 3)
    mine, _ = locator.locate(points)
    assert (mine >= 0).all()
    inverse = np.linalg.inv(np.swapaxes(corners[kept][:, 1:] - corners[kept][:, :1], 1, 2))
    share = np.einsum("kij,kj->ki", inverse[mine], points - corners[kept][mine, 0])
    assert np.minimum(share.min(axis=1), 1.0 - share.sum(axis=1)).min() > -1e-9
    assert (mine != own).any()


def test_graded_cells():
    """From 1 mm to 1 km in one mesh."""
    x = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 200)])
    nodes = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x, 1e3 + 0 * x])])
    n = len(x)
    cells = np.array([t for k in range(n - 1) for t in ((k, k + 1, n + k + 1), (k, n + k + 1, n + k))])
    mine, _ = SimplexLocator(nodes[cells]).locate(nodes[cells].mean(axis=1))
    assert (mine == np.arange(len(cells))).all()


def test_materials_of_points(tmp_path):
    elements = [("triangle", t, 1 + k // 2) for k, t in enumerate(FOUR)]
    path = write_msh(tmp_path / "s.msh", SQUARE, elements, [(2, 1, "clay"), (2, 2, "sand")])
    body = MeshBody(read_mesh(path))
    points = [(1.0, 0.1), (1.9, 1.0), (1.0, 1.9), (0.1, 1.0), (-0.1, 1.0), (np.nan, 1.0), (1e300, 0.0)]
    assert body.material_at(np.array(points)).tolist() == [0, 0, 1, 1, OUTSIDE, OUTSIDE, OUTSIDE]
    assert body.bounds.tolist() == [[0.0, 0.0], [2.0, 2.0]]
    assert body.sizes == pytest.approx([2.0, 2.0])
    assert (body.dimension, body.materials) == (2, ("clay", "sand"))


@pytest.mark.parametrize("dimension", [2, 3])
def test_surfaces_face_outwards_and_close(dimension, tmp_path):
    """Their normals point away from the middle, and the sum of area times normal is nothing."""
    if dimension == 2:
        mesh = read_mesh(square(tmp_path / "s.msh", triangles=[t[::-1] for t in FOUR]))
    else:
        path = write_msh(tmp_path / "h.msh", CUBE, [("hexahedron", range(8), 1)], [(3, 1, "rock")])
        mesh = read_mesh(path)
    (surface,) = MeshBody(mesh).surfaces
    normal = facet_normals(surface.corners)
    away = surface.corners.mean(axis=1) - mesh.nodes.mean(axis=0)
    assert ((normal * away).sum(axis=1) > 0.0).all()
    if dimension == 2:
        sizes = np.linalg.norm(surface.corners[:, 1] - surface.corners[:, 0], axis=1)
        assert sizes.sum() == pytest.approx(8.0)
    else:
        a, b, c = (surface.corners[:, k] for k in range(3))
        sizes = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        assert sizes.sum() == pytest.approx(6.0)
    assert (sizes[:, None] * normal).sum(axis=0) == pytest.approx(np.zeros(dimension), abs=1e-12)


def test_hole_is_bounded_from_inside():
    """A ring of eight triangles around a square hole: the hole's sides have the ground on their left."""
    outer = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)]
    inner = [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)]
    cells = [t for k in range(4) for t in ((k, (k + 1) % 4, 4 + (k + 1) % 4), (k, 4 + (k + 1) % 4, 4 + k))]
    sides = cell_facets(np.array(cells)).reshape(-1, 2)
    once = [tuple(s) for s in sides.tolist() if s[::-1] not in sides.tolist()]
    nodes = np.array(outer + inner)
    mesh = Mesh(nodes, np.array(cells, dtype=np.int32), np.zeros(8, dtype=np.int32), np.arange(8, dtype=np.int32),
                ("clay",), np.array(once, dtype=np.int32), np.full(len(once), -1, dtype=np.int32), ())  # fmt: skip
    body = MeshBody(mesh)
    assert body.sizes == pytest.approx([8.0])
    assert body.material_at(np.array([[1.5, 1.5], [0.5, 0.5]])).tolist() == [OUTSIDE, 0]
    (surface,) = body.surfaces
    middle = surface.corners.mean(axis=1)
    in_hole = np.abs(middle - 1.5).max(axis=1) < 0.6
    towards = ((facet_normals(surface.corners) * (1.5 - middle)).sum(axis=1)) > 0.0
    assert (towards == in_hole).all()
    assert in_hole.sum() == 4
