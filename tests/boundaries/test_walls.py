"""Walls as a user makes them, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geodem.assembly import Servo
from geodem.boundaries import walls
from geodem.boundaries.checks import merge_corners, wall_errors
from geodem.errors import InputError

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def cube():
    """Triangles of the unit cube, normals outwards."""
    return np.array([CUBE[list(t)] for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))])


def test_plane_has_a_unit_normal():
    wall = walls.plane("base", (0, 1), (0, 4))
    assert wall.planes.tolist() == [[[0, 1], [0, 1]]]
    assert wall.centre.tolist() == [0, 1]
    assert wall.spin.shape == (1,)


def test_box_faces_inwards():
    for low, high in (((0, 0), (2, 1)), ((0, 0, -1), (2, 1, 3))):
        box = walls.box("box", low, high)
        middle = 0.5 * (np.array(low) + high)
        assert len(box.planes) == 2 * len(low)
        depth = [(middle - point) @ normal for point, normal in box.planes]
        assert sorted(depth) == sorted(np.tile(0.5 * (np.array(high) - low), 2))
        assert box.centre.tolist() == middle.tolist()


def test_chain_closes():
    points = [(0, 0), (1, 0), (0, 1)]
    assert len(walls.segments("s", points).segments) == 2
    closed = walls.segments("s", points, closed=True).segments
    assert closed[2].tolist() == [[0, 1], [0, 0]]


def test_contact_and_motion_are_kept_as_given():
    wall = walls.plane(
        "lid", (0, 0, 1), (0, 0, -1), velocity=(0, 0, -0.1), contact={"friction_coefficient": 0.0}
    )
    assert wall.contact == {"friction_coefficient": 0.0}
    assert wall.velocity.tolist() == [0, 0, -0.1]


@pytest.mark.parametrize("make", ["binary", "text"])
def test_stl_file(tmp_path, make):
    path = tmp_path / "cube.stl"
    if make == "binary":
        facets = np.zeros(12, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        facets["corners"] = 1000 * cube()
        path.write_bytes(b" " * 80 + np.uint32(12).tobytes() + facets.tobytes())
    else:
        corners = ["".join(f"vertex {x} {y} {z}\n" for x, y, z in facet) for facet in 1000 * cube()]
        facets = [f"facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n" for lines in corners]
        path.write_text("solid cube\n" + "".join(facets) + "endsolid cube\n")
    wall = walls.from_stl("cube", path, scale=1e-3)
    assert wall.triangles == pytest.approx(cube())
    assert wall.centre == pytest.approx([0.5, 0.5, 0.5])


def test_stl_file_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        walls.from_stl("w", tmp_path / "none.stl")
    path = tmp_path / "broken.stl"
    path.write_bytes(b"\x01\x02 no mesh")
    with pytest.raises(InputError, match=r"cannot be read|no triangles"):
        walls.from_stl("w", path)


REFUSED = {
    "normal without length": (lambda: walls.plane("w", (0, 0), (0, 0)), "no direction"),
    "point that is not finite": (lambda: walls.plane("w", (0, np.nan), (0, 1)), "not finite"),
    "empty box": (lambda: walls.box("w", (0, 0), (1, 0)), "no inside"),
    "one point": (lambda: walls.segments("w", [(0, 0)]), "no chain"),
    "segment without length": (lambda: walls.segments("w", [(0, 0), (1, 0), (1, 0)]), "segment 1.*one point"),
    "triangle without area": (
        lambda: walls.triangles("w", [[(0, 0, 0), (1, 0, 0), (3, 0, 0)]]),
        "triangle 0.*on one line",
    ),
    "inside out": (lambda: walls.triangles("w", cube()[:, ::-1]), "inside out.*turn_over"),
    "neighbours that disagree": (
        lambda: walls.triangles("w", np.concatenate([cube()[:-1], cube()[-1:, ::-1]])),
        "neighbours face opposite sides",
    ),
    "velocity of the wrong dimension": (
        lambda: walls.plane("w", (0, 0), (0, 1), velocity=(1, 0, 0)),
        "velocity is not made of 2",
    ),
    "spin of the wrong dimension": (lambda: walls.plane("w", (0, 0, 0), (0, 0, 1), spin=1.0), "spin"),
    "servo without direction": (
        lambda: walls.plane("w", (0, 0), (0, 1), servo=Servo((0.0, 0.0), 1e3, 0.1)),
        "servo.*no unit vector",
    ),
    "servo with a negative limit": (
        lambda: walls.plane("w", (0, 0), (0, 1), servo=Servo((0.0, 1.0), 1e3, -0.1)),
        "limit",
    ),
    "servo force that is not finite": (
        lambda: walls.plane("w", (0, 0), (0, 1), servo=Servo((0.0, 1.0), np.inf, 0.1)),
        "force is not finite",
    ),
    "servo gain": (lambda: walls.plane("w", (0, 0), (0, 1), servo=Servo((0.0, 1.0), 1.0, 0.1, 0.0)), "gain"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    make, message = REFUSED[case]
    with pytest.raises(InputError, match=rf"(?s)wall 'w'.*{message}"):
        make()


def test_walls_of_the_other_dimension_are_refused():
    chain = walls.segments("chain", [(0, 0), (1, 0)])
    assert "segments bound discs" in str(wall_errors(chain, 3)[0])
    mesh = walls.triangles("mesh", cube())
    assert "triangles bound spheres" in str(wall_errors(mesh, 2)[0])
    floor = walls.plane("floor", (0, 0), (0, 1))
    assert wall_errors(floor, 3)
    assert "length 1" in str(wall_errors(replace(floor, planes=2.0 * floor.planes), 2)[0])


def test_open_and_hollow_surfaces_are_accepted():
    walls.triangles("open, any winding", np.concatenate([cube()[:5], cube()[5:9, ::-1]]))
    inner = 0.25 + 0.5 * cube()[:, ::-1]
    walls.triangles("hollow", np.concatenate([cube(), inner]))
    walls.triangles("inner face of a container", cube()[:, ::-1], turn_over=True)


def test_corners_are_merged_where_equal():
    numbers = merge_corners(cube())
    assert len(np.unique(numbers)) == 8
    shaken = cube() + np.random.default_rng(0).uniform(-1e-8, 1e-8, (12, 3, 3))
    assert np.unique(merge_corners(shaken)).size == 8
    apart = cube()
    apart[0] += 1e-3
    assert np.unique(merge_corners(apart)).size == 11
