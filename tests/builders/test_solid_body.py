"""Closed surfaces as bodies: what they enclose, what is repaired, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay

from geodem.builders.body import OUTSIDE
from geodem.builders.from_mesh import body_from_mesh
from geodem.builders.solid_body import read_solids
from geodem.errors import InputError
from tests.builders.mesh_files import cube_facets, write_stl


def solid(folder, corners, name="rock"):
    return read_solids({name: write_stl(folder / f"{name}.stl", corners)})


def ball(count, seed=1):
    """Triangles of the hull of random points on a sphere, outwards, and the hull."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points = (points / np.linalg.norm(points, axis=1, keepdims=True)).astype(np.float32).astype(np.float64)
    found = ConvexHull(points)
    corners = points[found.simplices]
    outwards = (
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * found.equations[:, :3]
    ).sum(1)
    return np.where(outwards[:, None, None] > 0.0, corners, corners[:, ::-1]), found


def test_ball_holds_what_qhull_says(tmp_path):
    corners, found = ball(1500)
    body = solid(tmp_path, corners)
    assert body.sizes == pytest.approx([found.volume], rel=1e-12)
    points = np.random.default_rng(2).uniform(-1.0, 1.0, (40_000, 3))
    # of a convex body, all points inside are within all its planes
    depth = (points @ found.equations[:, :3].T + found.equations[:, 3]).max(axis=1)
    clear = np.abs(depth) > 1e-7
    assert (body.material_at(points)[clear] == np.where(depth < 0.0, 0, OUTSIDE)[clear]).all()


def test_points_below_corners_and_edges(tmp_path):
    """A lattice whose lines along z meet corners and edges of the triangles exactly."""
    body = solid(tmp_path, cube_facets())
    line = np.linspace(-0.25, 1.25, 13)
    points = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = ((points > 0.0) & (points < 1.0)).all(axis=1)
    outside = ((points < 0.0) | (points > 1.0)).any(axis=1)
    material = body.material_at(points)
    assert (material[inside] == 0).all()
    assert (material[outside] == OUTSIDE).all()
    assert body.material_at(np.full((1, 3), np.nan)).tolist() == [OUTSIDE]


def test_points_below_corners_of_a_ball(tmp_path):
    """Over its corners five or six triangles meet."""
    corners, found = ball(500)
    body = solid(tmp_path, corners)
    high = found.points[found.points[:, 2] > 0.3]
    below = np.column_stack([high[:, :2], np.zeros(len(high))])
    assert (body.material_at(below) == 0).all()


def test_body_that_is_not_convex(tmp_path):
    """A torus, turned so that no axis is special: inside by its formula."""
    big, small, n, m = 3.0, 1.0, 48, 24
    a, b = np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m
    a, b = np.meshgrid(a, b, indexing="ij")
    wide = big + small * np.cos(b)
    grid = np.stack([wide * np.cos(a), wide * np.sin(a), small * np.sin(b)], axis=-1)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    quads = [(grid[i, j], grid[(i + 1) % n, j], grid[(i + 1) % n, (j + 1) % m], grid[i, (j + 1) % m])
             for i in range(n) for j in range(m)]  # fmt: skip
    corners = np.array([t for p, q, r, s in quads for t in ((p, q, r), (p, r, s))]) @ turn.T
    body = solid(tmp_path, corners)
    points = np.random.default_rng(4).uniform(-4.0, 4.0, (20_000, 3))
    x, y, z = points.T
    distance = np.hypot(np.hypot(x, y) - big, z)
    clear = np.abs(distance - small) > 0.05
    assert (body.material_at(points @ turn.T)[clear] == np.where(distance < small, 0, OUTSIDE)[clear]).all()
    # Pappus: 2 pi^2 R r^2, of which chords lose a little
    assert body.sizes[0] == pytest.approx(2.0 * np.pi**2 * big * small**2, rel=0.02)


def test_surface_that_faces_inwards_in_part(tmp_path):
    corners = cube_facets()
    for some in ([3], list(range(12)), [0, 5, 7]):
        turned = corners.copy()
        turned[some] = turned[some][:, ::-1]
        body = solid(tmp_path, turned)
        assert body.sizes == pytest.approx([1.0])
        assert f"{len(some)} of 12 triangles faced inwards" in " ".join(body.remarks)


def test_cavity(tmp_path):
    """A cube of 3 m around one of 1 m, whichever way the inner one faces: 26 m3, and nothing in the middle."""
    inner = cube_facets((1.0, 1.0, 1.0))
    for hole in (inner, inner[:, ::-1]):
        body = solid(tmp_path, np.concatenate([cube_facets(side=3.0), hole]))
        assert body.sizes == pytest.approx([26.0])
        assert body.material_at(np.array([[1.5, 1.5, 1.5], [0.5, 0.5, 0.5]])).tolist() == [OUTSIDE, 0]
        assert any("2 shells, 1 of them around holes" in remark for remark in body.remarks)


def test_open_surface(tmp_path):
    with pytest.raises(InputError, match=r"open: 3 edges belong to one triangle only, the first at \(.*\) m"):
        solid(tmp_path, cube_facets()[1:])


def test_edge_of_more_than_two_triangles(tmp_path):
    """Two cubes that have an edge in common."""
    corners = np.concatenate([cube_facets(), cube_facets((1.0, 1.0, 0.0))])
    with pytest.raises(
        InputError, match=r"1 edges belong to more than two triangles, the first at \(1, 1, 0.5\) m"
    ):
        solid(tmp_path, corners)


def test_shells_that_cross(tmp_path):
    corners = np.concatenate([cube_facets(), cube_facets((0.5, 0.55, 0.6), 2.0)])
    with pytest.raises(InputError, match="two of its 2 shells cross each other"):
        solid(tmp_path, corners)


def test_surface_with_one_side(tmp_path):
    """A Klein bottle in 3D crosses itself, but has no edge that is open: squares glued with a twist."""
    n, m = 8, 7
    grid = np.random.default_rng(5).random((n, m, 3))

    def at(i, j):
        return grid[i % n, j % m] if (i // n) % 2 == 0 else grid[i % n, (-j) % m]

    corners = [t for i in range(n) for j in range(m)
               for p, q, r, s in [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))]
               for t in ((p, q, r), (p, r, s))]  # fmt: skip
    with pytest.raises(InputError, match="one side only"):
        solid(tmp_path, np.array(corners))


def test_triangles_without_area_and_twice(tmp_path):
    """A needle between two triangles, a point, and one triangle again."""
    cube = cube_facets()
    point = np.repeat(cube[:1, :1], 3, axis=1)
    body = solid(tmp_path, np.concatenate([cube, point, cube[:1]]))
    assert body.sizes == pytest.approx([1.0])
    said = " ".join(body.remarks)
    assert "1 triangles without an area were removed" in said
    assert "1 triangles were there twice" in said


def test_corners_that_almost_meet_are_merged(tmp_path):
    cube = cube_facets()
    cube[0, 0] += 3e-7
    body = solid(tmp_path, cube)
    assert body.sizes == pytest.approx([1.0], rel=1e-5)
    assert any("corners lay next to another" in remark for remark in body.remarks)


def test_bodies_side_by_side(tmp_path):
    """Materials in order of the files; what they have in common is no surface."""
    mirrored = (cube_facets() * (-1.0, 1.0, 1.0) + (2.0, 0.0, 0.0))[:, ::-1]
    paths = {
        "rock": write_stl(tmp_path / "a.stl", cube_facets()),
        "dyke": write_stl(tmp_path / "b.stl", mirrored),
    }
    body = body_from_mesh(paths)
    assert body.materials == ("rock", "dyke")
    assert body.sizes == pytest.approx([1.0, 1.0])
    assert body.material_at(np.array([[0.5, 0.5, 0.5], [1.5, 0.5, 0.5], [2.5, 0.5, 0.5]])).tolist() == [
        0,
        1,
        -1,
    ]
    assert [len(surface.corners) for surface in body.surfaces] == [10, 10]
    assert body.bounds.tolist() == [[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]]


def test_bodies_that_overlap(tmp_path):
    """Half of each is the other: 0.5 m3 around (0.75, 0.5, 0.5)."""
    paths = {
        "rock": write_stl(tmp_path / "a.stl", cube_facets()),
        "dyke": write_stl(tmp_path / "b.stl", cube_facets((0.5, 0.0, 0.0))),
    }
    with pytest.raises(
        InputError, match=r"'rock' and 'dyke' overlap by about 0.5 m3 around \(0.75, 0.5, 0.5\) m"
    ):
        read_solids(paths)


def test_sliver_in_two_bodies_is_told(tmp_path):
    paths = {
        "rock": write_stl(tmp_path / "a.stl", cube_facets()),
        "dyke": write_stl(tmp_path / "b.stl", cube_facets((0.9995, 0.0, 0.0))),
    }
    body = read_solids(paths)
    assert any("overlap by about 0.0005 m3" in remark for remark in body.remarks)
    assert body.material_at(np.array([[0.9998, 0.5, 0.5]])).tolist() == [0]


def test_units_of_surfaces(tmp_path):
    path = write_stl(tmp_path / "rock.stl", 20_000.0 * cube_facets())
    with pytest.raises(InputError, match='length_unit = "mm"'):
        body_from_mesh(path)
    body = body_from_mesh(path, length_unit=0.001)
    assert body.materials == ("rock",)
    assert body.sizes == pytest.approx([8000.0])


@pytest.mark.parametrize("key", ["size", "names", "material_array"])
def test_what_surfaces_do_not_have(tmp_path, key):
    with pytest.raises(InputError, match=f"{key} = 1: closed surfaces have no such thing"):
        body_from_mesh(write_stl(tmp_path / "rock.stl", cube_facets()), **{key: 1})


def test_file_without_triangles(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_solids({"rock": tmp_path / "none.stl"})
    (tmp_path / "empty.stl").write_text("solid x\nendsolid x\n")
    with pytest.raises(InputError, match=r"cannot be read|no surface of triangles"):
        read_solids({"rock": tmp_path / "empty.stl"})
    with pytest.raises(InputError, match="there is no file"):
        read_solids({})


def test_volume_of_qhull_tetrahedra_is_that_of_their_hull(tmp_path):
    """A body given by its surface and by tetrahedra is one body."""
    points = np.random.default_rng(6).random((60, 3)).astype(np.float32).astype(np.float64)
    found = Delaunay(points)
    corners, _ = points[found.convex_hull], None
    body = solid(tmp_path, corners)
    samples = np.random.default_rng(7).random((20_000, 3))
    inside = found.find_simplex(samples) >= 0
    assert (body.material_at(samples) == np.where(inside, 0, OUTSIDE)).all()
