"""The section of a tool: every angle and length measured on its corners."""

import math

import numpy as np
import pytest

from geodem.cutting.tool import BODY, FACE, FLAT, RELIEF, TIP, Tool
from geodem.errors import InputError, InputErrors


def tool(**changes):
    values = {"rake": 15.0, "clearance": 10.0, "height": 0.02, "friction_angle": 20.0} | changes
    for name in ("rake", "clearance", "friction_angle"):
        values[name] = math.radians(values[name])
    return Tool(**values)


def sides(one):
    corners, parts = one.outline()
    return np.roll(corners, -1, axis=0) - corners, corners, parts


@pytest.mark.parametrize("rake", [-30.0, 0.0, 15.0, 60.0])
@pytest.mark.parametrize(("flat", "radius"), [(0.0, 0.0), (0.003, 0.0), (0.0, 0.002), (0.003, 0.002)])
def test_face_and_relief_have_their_angles_and_the_lowest_point_is_the_origin(rake, flat, radius):
    along, corners, parts = sides(tool(rake=rake, wear_flat=flat, tip_radius=radius))
    face, relief = along[parts == FACE][0], along[parts == RELIEF][0]
    # the rake is from the normal of the path, positive where the face leans back from +x
    assert math.degrees(math.atan2(face[0], -face[1])) == pytest.approx(rake, abs=1e-9)
    assert math.degrees(math.atan2(relief[1], -relief[0])) == pytest.approx(10.0)
    assert corners[:, 1].min() == pytest.approx(0.0, abs=1e-15)
    assert corners[:, 1].max() == pytest.approx(0.02)
    np.testing.assert_allclose(corners[np.argmin(np.hypot(*corners.T))], 0.0, atol=1e-15)
    if flat:
        np.testing.assert_allclose(along[parts == FLAT], [[-0.003, 0.0]], atol=1e-15)
    # closed, clockwise: the shoelace area is negative
    x, y = corners.T
    assert (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0.0
    assert (parts == BODY).any()


def test_a_round_tip_has_its_radius_and_goes_over_smoothly():
    radius = 0.002
    along, corners, parts = sides(tool(tip_radius=radius))
    arc = corners[np.flatnonzero(parts == TIP)]
    np.testing.assert_allclose(np.hypot(arc[:, 0], arc[:, 1] - radius), radius)
    heading = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))[: int((parts == RELIEF).argmax()) + 1]
    turns = np.diff(heading)
    # no corner turns by more than one step of the arc
    assert np.abs(turns).max() < math.radians(16.0)
    assert abs(turns.sum()) == pytest.approx(math.radians(180.0 - (90.0 - 15.0 - 10.0)))


def test_normal_over_cutting_force_of_a_sliding_face():
    # Fn/Fc = tan(psi - alpha); Merchant's worked numbers 0.31/3.57, 2.42/6.65, 12.2/17.4
    for rake, ratio in ((15.0, 0.31 / 3.57), (0.0, 2.42 / 6.65), (-15.0, 12.2 / 17.4)):
        assert tool(rake=rake).ratio == pytest.approx(ratio, rel=0.02)


def test_how_far_it_reaches_ahead_of_its_lowest_point():
    assert tool(rake=-30.0).foremost(0.01) == pytest.approx(0.01 * math.tan(math.radians(30.0)))
    assert tool(rake=30.0).foremost(0.01) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"rake": 95.0}, "rake"),
        ({"clearance": 0.0}, "clearance"),
        ({"rake": 70.0, "clearance": 20.0}, "rake"),
        ({"height": 0.0}, "height"),
        ({"wear_flat": -0.001}, "wear_flat"),
        ({"tip_radius": 0.02}, "tip_radius"),
        ({"friction_angle": 90.0}, "friction_angle"),
    ],
)
def test_what_is_no_tool_is_refused_with_what_to_do(changes, place):
    with pytest.raises(InputError) as raised:
        tool(**changes).check()
    assert raised.value.place == f"tool, {place}"
    assert raised.value.remedy


def test_all_that_is_wrong_is_told_at_once():
    with pytest.raises(InputErrors) as raised:
        tool(clearance=0.0, height=-1.0).check()
    assert len(raised.value.errors) == 2
