"""Where a tool starts and first touches: worked out for single particles by hand."""

import math

import numpy as np
import pytest

from geodem.cutting.plan import CuttingPlan, place_tool
from geodem.cutting.tool import Tool
from geodem.errors import InputError

BOX = np.array([[0.0, 0.0], [1.0, 0.5]])
RADIUS = 0.02


def plan(*, rake=0.0, **changes):
    tool = Tool(math.radians(rake), math.radians(10.0), 0.4, math.radians(20.0))
    values = {"depth": 0.1, "speed": 1.0, "distance": 0.4, "entry": 0.1} | changes
    return CuttingPlan(tool, **values)


def block():
    """Particles in rows, which begin at x = 0."""
    x, y = np.meshgrid(np.arange(RADIUS, 1.0, 2 * RADIUS), np.arange(RADIUS, 0.5, 2 * RADIUS))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    return places, np.full(len(places), RADIUS)


def test_an_upright_face_touches_the_foremost_particle():
    placed = place_tool(plan(), *block(), BOX)
    np.testing.assert_allclose(placed.place, [0.0, 0.4], atol=1e-12)
    assert placed.end == pytest.approx(0.4)


def test_a_slanted_face_touches_where_its_normal_points():
    # one particle in the way: the face through the tip at (X, 0.4) leans forward by 30 deg
    place, radius = np.array([[0.5, 0.45]]), np.array([0.02])
    touch = place_tool(
        plan(rake=-30.0, depth=0.1, start=-0.4, distance=0.9, entry=0.0), place, radius, BOX
    ).contact
    # distance of the centre to the line through (X, 0.4) along (sin 30, cos 30) is the radius
    x = 0.5 - 0.05 * math.tan(math.radians(30.0)) - 0.02 / math.cos(math.radians(30.0))
    assert touch == pytest.approx(x)


def test_a_sharp_tip_touches_a_particle_at_its_own_level():
    place, radius = np.array([[0.5, 0.4]]), np.array([0.02])
    touch = place_tool(plan(rake=20.0, start=-0.4, distance=0.9, entry=0.0), place, radius, BOX).contact
    assert touch == pytest.approx(0.48)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"start": 0.3}, "start", "in the ground"),
        ({"start": 1.5}, "start", "moves away"),
        ({"start": -1.0, "distance": 0.5}, "distance", "does not reach"),
        ({"distance": 2.0}, "distance", "beyond the end"),
        ({"distance": -0.1}, "distance", "away from the ground"),
        ({"depth": 0.03}, "depth", "finer than a particle"),
        ({"depth": 0.49}, "height", "below the surface"),
        ({"depth": 0.6}, "height", "below the surface"),
        ({"entry": 0.5}, "entry", "means are to be taken"),
        ({"speed": 0.0}, "speed", "cuts nothing"),
    ],
)
def test_a_cut_that_cannot_be_is_refused_with_what_to_do(changes, key, words):
    with pytest.raises(InputError) as raised:
        place_tool(plan(**changes), *block(), BOX)
    assert raised.value.place == f"tool, {key}"
    assert words in raised.value.problem
    assert raised.value.remedy


def test_a_depth_beyond_the_block_is_refused():
    deep = CuttingPlan(Tool(0.0, 0.2, 2.0, 0.3), 0.48, 1.0, 0.4)
    with pytest.raises(InputError, match="thick"):
        place_tool(deep, *block(), BOX)
