"""State of the bodies: servo, turning, place of the primitives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geodem.assembly import Servo
from geodem.boundaries import walls
from geodem.boundaries.wall_pairs import check_servo_contact, contact_sum
from geodem.boundaries.wall_table import servo_gain, set_servo_gains, wall_table
from geodem.errors import InputError
from geodem.kernels import wall_geometry as columns
from tests.boundaries.wall_scene import KN, WallScene, particle_rows


def test_shared_corners_have_one_number_within_a_body_only():
    chain = [(0, 0), (1, 0), (2, 1)]
    table = wall_table([walls.segments("a", chain), walls.segments("b", chain)], 2)
    assert table.vertex[:, 2].tolist() == [-1] * 4
    assert table.vertex[0, 1] == table.vertex[1, 0]
    assert len(np.unique(table.vertex[:, :2])) == 6
    assert table.body.tolist() == [0, 0, 1, 1]
    assert not table.walls_turn


def test_one_wall_of_planes_and_triangles():
    from dataclasses import replace

    both = replace(
        walls.box("both", (0, 0, 0), (1, 1, 1)), triangles=np.array([[(0, 0, 0.5), (1, 0, 0.5), (0, 1, 0.5)]])
    )
    table = wall_table([both], 3)
    assert table.kind.tolist() == [0] * 6 + [2]
    assert (table.vertex[:6] == -1).all()


def test_body_turns_as_its_spin_says():
    spin, velocity, centre = np.array([0.7, -0.4, 1.1]), np.array([0.1, 0.2, -0.3]), np.array([1.0, 2.0, 3.0])
    facet = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]])
    table = wall_table([walls.triangles("t", facet, spin=spin, velocity=velocity, centre=centre)], 3)
    assert table.walls_turn
    fastest = [table.advance(1e-3) for _ in range(1000)]
    expected = Rotation.from_rotvec(spin).apply(facet[0] - centre) + centre + velocity
    assert table.corners_now()[0] == pytest.approx(expected, abs=1e-12)
    # no corner has been faster than what the search is told
    assert np.linalg.norm(velocity) < min(fastest)
    speed = max(np.linalg.norm(velocity + np.cross(spin, corner - centre - velocity)) for corner in expected)
    assert speed <= min(fastest)


def servo_scene(force, *, count=3, gain=None, start=0.99, limit=1.0):
    """A lid held by a servo above `count` fixed spheres."""
    servo = Servo((0.0, 0.0, -1.0), force, limit, gain)
    lid = walls.plane("lid", (0, 0, start), (0, 0, -1), servo=servo)
    positions = np.zeros((count, 3))
    positions[:, 0] = 3.0 * np.arange(count)
    scene = WallScene([lid], particle_rows(3, positions, 1.0))
    scene.forces()
    stiffness = contact_sum(scene.table, scene.pairs, np.full(len(scene.pairs.particle), KN))
    set_servo_gains(scene.table, [lid], stiffness, scene.dt)
    return scene, stiffness


def test_servo_halves_its_error_in_every_step():
    """gain = 0.5 / (dt sum kn): the error of linear contacts goes as 1/2^steps."""
    scene, stiffness = servo_scene(2e5, limit=100.0)
    assert stiffness[0] == 3 * KN
    gain = servo_gain(3 * KN, scene.dt)
    assert scene.table.bodies[0, columns.BODY_GAIN] == gain
    assert gain == pytest.approx(0.5 / (scene.dt * 3 * KN))
    errors = 2e5 - np.array([-scene.slide(1)[0, :, 2].sum() for _ in range(20)])
    assert errors[1:] / errors[:-1] == pytest.approx(0.5, rel=1e-6)
    scene.slide(30)
    assert scene.table.forces()[0] == pytest.approx([0.0, 0.0, 2e5])
    # the lid ends where 3 springs carry the force
    assert scene.table.displacements()[0, 2] == pytest.approx(-(2e5 / (3 * KN) - 0.01))


def test_servo_keeps_its_limit_and_its_own_gain():
    scene, _ = servo_scene(1e9, gain=1e-3, limit=0.25)
    assert scene.table.bodies[0, columns.BODY_GAIN] == 1e-3
    scene.slide(4)
    assert scene.table.displacements()[0] == pytest.approx([0.0, 0.0, -0.25 * 4e-3])


def test_servo_work_is_what_the_contacts_store():
    scene, _ = servo_scene(2e5, count=1, start=0.999999)
    scene.slide(400)
    assert scene.table.work()[0] == pytest.approx(0.5 * 2e5**2 / KN, rel=1e-3)
    assert scene.energy[3] == pytest.approx(0.5 * 2e5**2 / KN, rel=1e-9)


def test_servo_far_from_all_particles_is_refused():
    servo = Servo((0.0, -1.0), 1e3, 0.1)
    rows = particle_rows(2, [[0.0, 0.0], [1.5, 0.0]], 0.5)
    near = walls.plane("near", (0, 1.4), (0, -1), servo=servo)
    far = walls.segments("far", [(-1, 1.6), (1, 1.6)], servo=servo)
    idle = walls.segments("idle", [(-1, 9), (1, 9)])
    check_servo_contact(rows, wall_table([near, idle], 2), [near, idle])
    with pytest.raises(InputError, match="wall 'far', servo: no particle is within 1 m"):
        check_servo_contact(rows, wall_table([near, far], 2), [near, far])
    check_servo_contact(rows, wall_table([near, far], 2), [near, far], reach=1.2)


def test_velocity_can_be_changed_by_name():
    table = wall_table([walls.plane("a", (0, 0), (0, 1)), walls.plane("b", (0, 5), (0, -1))], 2)
    table.set_velocity("b", np.array([0.5, -1.0]), np.array([2.0]))
    table.advance(0.1)
    assert table.displacements() == pytest.approx(np.array([[0, 0], [0.05, -0.1]]))
    with pytest.raises(InputError, match="Known walls: a, b"):
        table.set_velocity("c", np.zeros(2))
