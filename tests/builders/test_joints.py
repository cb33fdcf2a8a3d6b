"""Geometry of joints: faces, orientation, clipping, sets, bands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.builders.joint_sets import JointScatter, joint_set_2d, joint_set_3d
from geodem.builders.joints import clipped, dip_normal, disc, in_band, plane, polyline, segment
from geodem.errors import InputError

BOX2 = np.array([[0.0, 0.0], [10.0, 6.0]])
BOX3 = np.array([[0.0, 0.0, 0.0], [10.0, 8.0, 6.0]])


def ends(joint):
    """Ends (f, 2, 2) of the faces of a joint in 2D."""
    along = np.stack([joint.normals[:, 1], -joint.normals[:, 0]], axis=1) * joint.radii[:, None]
    return np.stack([joint.centres - along, joint.centres + along], axis=1)


def test_polyline_has_a_face_between_every_two_points():
    points = [[1.0, 1.0], [4.0, 1.0], [4.0, 5.0]]
    joint = polyline(points, "j")
    assert joint.area == pytest.approx(7.0)
    assert joint.normals == pytest.approx(np.array([[0.0, 1.0], [-1.0, 0.0]]))
    assert ends(joint) == pytest.approx(np.array([points[:2], points[1:]]))


def test_dip_and_dip_direction():
    """x east, y north: a plane that dips 30 degrees to the east has its normal tilted to the east."""
    assert dip_normal(math.radians(30.0), math.radians(90.0)) == pytest.approx([0.5, 0.0, math.sqrt(0.75)])
    assert dip_normal(math.radians(90.0), 0.0) == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


def test_segments_end_at_the_box():
    cut = clipped(segment((-5.0, 3.0), (20.0, 3.0), "j"), BOX2)
    assert ends(cut)[0] == pytest.approx(np.array([[0.0, 3.0], [10.0, 3.0]]))
    # along the diagonal y = x
    cut = clipped(segment((-5.0, -5.0), (20.0, 20.0), "j"), BOX2)
    assert ends(cut)[0] == pytest.approx(np.array([[0.0, 0.0], [6.0, 6.0]]))
    assert clipped(segment((-5.0, 7.0), (20.0, 7.0), "j"), BOX2) is None


def test_discs_that_pass_by_are_left_out():
    assert clipped(disc((5.0, 4.0, 3.0), (0.0, 0.0, 1.0), 2.0, "j"), BOX3) is not None
    assert clipped(disc((5.0, 4.0, 9.0), (0.0, 0.0, 1.0), 5.0, "j"), BOX3) is None
    assert clipped(disc((-3.0, 4.0, 3.0), (0.0, 0.0, 1.0), 2.0, "j"), BOX3) is None


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0])
def test_persistent_set_has_the_area_of_its_spacing(angle):
    """Length of joints per area of ground is 1/spacing, up to joints that the box cuts off."""
    spacing = 0.05
    joints = joint_set_2d(BOX2, "j", angle=angle, spacing=spacing)
    length = sum(joint.area for joint in joints)
    assert length * spacing / 60.0 == pytest.approx(1.0, abs=0.03)
    along = np.array([math.cos(angle), math.sin(angle)])
    for joint in joints:
        assert abs(float(joint.normals[0] @ along)) < 1e-12


def test_bridges_take_their_share():
    joints = joint_set_2d(
        BOX2, "j", angle=0.3, spacing=0.05, trace=0.3, gap=0.1, scatter=JointScatter(seed=3, trace=0.2)
    )
    assert sum(joint.area for joint in joints) * 0.05 / 60.0 == pytest.approx(0.75, abs=0.03)


def test_sets_are_the_same_for_the_same_seed():
    def made(seed):
        scatter = JointScatter(seed=seed, angle=0.1, spacing=0.2, trace=0.2)
        found = joint_set_2d(BOX2, "j", angle=0.5, spacing=0.5, trace=1.0, gap=0.3, scatter=scatter)
        return np.concatenate([joint.centres for joint in found])

    assert np.array_equal(made(4), made(4))
    assert not np.array_equal(made(4)[:5], made(5)[:5])


def test_scatter_of_angles_has_its_deviation():
    scatter = JointScatter(seed=1, angle=0.1)
    joints = joint_set_2d(BOX2, "j", angle=0.5, spacing=0.01, scatter=scatter)
    angles = [math.atan2(-joint.normals[0, 0], joint.normals[0, 1]) for joint in joints]
    assert np.std(angles) == pytest.approx(0.1, rel=0.1)
    assert np.mean(angles) == pytest.approx(0.5, abs=0.02)


def test_set_in_space():
    dip, direction = math.radians(40.0), math.radians(120.0)
    planes = joint_set_3d(BOX3, "j", dip=dip, dip_direction=direction, spacing=0.5)
    normal = dip_normal(dip, direction)
    shifts = np.sort([float(joint.centres[0] @ normal) for joint in planes])
    assert np.diff(shifts) == pytest.approx(0.5)
    for joint in planes:
        assert joint.normals[0] == pytest.approx(normal)
    discs = joint_set_3d(BOX3, "j", dip=dip, dip_direction=direction, spacing=1.0, trace=2.0, gap=1.0)
    assert len(discs) > 20
    assert [float(joint.radii[0]) for joint in discs] == pytest.approx([1.0] * len(discs))


def test_band_is_as_thick_as_it_is_given():
    points = np.random.default_rng(1).uniform(BOX2[0], BOX2[1], (200_000, 2))
    inside = in_band(plane((5.0, 3.0), (0.6, 0.8), BOX2, "j"), points, 0.4)
    # ends are round, beyond the box
    length = plane((5.0, 3.0), (0.6, 0.8), BOX2, "j").area
    assert inside.mean() * 60.0 == pytest.approx(0.4 * length, rel=0.03)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: polyline([[0.0, 0.0]], "j"), "points"),
        (lambda: polyline([[0.0, 0.0], [0.0, 0.0]], "j"), "coincide"),
        (lambda: disc((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0, "j"), "direction"),
        (lambda: disc((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), -1.0, "j"), "radius"),
        (lambda: plane((0.0, 90.0), (0.0, 1.0), BOX2, "j"), "passes by"),
        (lambda: dip_normal(3.0, 0.0), "dip"),
        (lambda: joint_set_2d(BOX2, "j", angle=0.0, spacing=0.0), "spacing"),
        (lambda: joint_set_2d(BOX2, "j", angle=0.0, spacing=1e-6), "joints"),
        (lambda: joint_set_2d(BOX3, "j", angle=0.0, spacing=1.0), "2D"),
        (
            lambda: joint_set_2d(BOX2, "j", angle=0.0, spacing=1.0, scatter=JointScatter(1, trace=1.0)),
            "trace",
        ),
    ],
)
def test_bad_joints_are_refused(make, named):
    with pytest.raises(InputError, match=named):
        make()
