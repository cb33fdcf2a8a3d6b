"""Particles feel a surface, not the facets it is made of; forces on particles and walls balance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geodem.boundaries import walls
from geodem.kernels import wall_geometry
from tests.boundaries.wall_scene import FRICTION, KN, KS, WallScene, particle_rows

coordinate = st.floats(-2.0, 2.0, allow_nan=False)
point = st.tuples(coordinate, coordinate, coordinate)


@settings(max_examples=300, deadline=None)
@given(p=point, a=point, b=point, c=point)
def test_no_point_of_a_triangle_is_nearer_than_the_closest(p, a, b, c):
    corners = np.array([a, b, c])
    if np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) < 1e-3:
        return
    *normal, distance, feature = wall_geometry.closest_on_triangle(*p, *a, *b, *c, 1e-12)
    nearest = np.array(p) + distance * np.array(normal)
    # barycentric coordinates say that the point belongs to the triangle, and to the feature
    share = np.linalg.lstsq(np.vstack([corners.T, np.ones(3)]), np.append(nearest, 1.0), rcond=None)[0]
    assert np.abs(corners.T @ share - nearest).max() < 1e-7
    assert share.min() > -1e-6
    grid = np.array([(i, j, 20 - i - j) for i in range(21) for j in range(21 - i)]) / 20.0
    assert distance <= np.linalg.norm(grid @ corners - p, axis=1).min() + 1e-12
    if feature >= 4:
        assert share[feature - 4] == pytest.approx(1.0, abs=1e-6)
    elif feature >= 1:
        assert share[(feature + 1) % 3] == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=200, deadline=None)
@given(p=point, a=point, b=point)
def test_no_point_of_a_segment_is_nearer_than_the_closest(p, a, b):
    a, b, p = np.array(a[:2]), np.array(b[:2]), np.array(p[:2])
    if np.linalg.norm(b - a) < 1e-3:
        return
    *normal, distance, feature = wall_geometry.closest_on_segment(*p, *a, *b, 1e-12)
    share = np.linspace(0.0, 1.0, 1001)[:, np.newaxis]
    along = a + share * (b - a)
    assert distance <= np.linalg.norm(along - p, axis=1).min() + 1e-12
    nearest = p + distance * np.array(normal)
    t = (nearest - a) @ (b - a) / ((b - a) @ (b - a))
    assert np.abs(a + t * (b - a) - nearest).max() < 1e-9
    assert -1e-9 < t < 1.0 + 1e-9
    if feature:
        assert t == pytest.approx(feature - 4, abs=1e-9)


def floor_of_triangles(rng, count=7, shuffle=True):
    """A flat floor z = 0, every square split along one diagonal at random, in any order and winding."""
    x = np.sort(rng.uniform(-1.0, 1.0, count - 2))
    x = np.concatenate([[-6.0], 1.5 * x, [6.0]])
    facets = []
    for i in range(count - 1):
        for j in range(count - 1):
            a, b = (x[i], x[j], 0.0), (x[i + 1], x[j], 0.0)
            c, d = (x[i + 1], x[j + 1], 0.0), (x[i], x[j + 1], 0.0)
            facets += [(a, b, c), (a, c, d)] if rng.random() < 0.5 else [(a, b, d), (b, c, d)]
    facets = np.array(facets)
    return facets[rng.permutation(len(facets))] if shuffle else facets


@pytest.mark.parametrize("seed", range(4))
def test_sphere_slides_over_triangles_as_over_a_plane(seed):
    """Through corners and along edges too; shear history included, which friction caps half way."""
    rng = np.random.default_rng(seed)
    facets = floor_of_triangles(rng)
    inner = facets.reshape(-1, 3)
    inner = inner[(np.abs(inner) < 2.0).all(axis=1)]
    where = inner[rng.integers(len(inner))]
    results = []
    for wall in (walls.triangles("floor", facets), walls.plane("floor", (0, 0, 0), (0, 0, 1))):
        rows = particle_rows(3, [[-1.5, -1.5, 0.98]], 1.0)
        # right through a corner of the mesh in step 400
        way = np.array([where[0] + 1.5, where[1] + 1.5, 0.0])
        rows[0, 4:7] = way / 0.4 + [0.0, 0.0, -0.01]
        rows[0, 8:11] = [0.3, -0.2, 0.7]
        results.append(WallScene([wall], rows, buffer=1.0).slide(900))
    on_mesh, on_plane = results
    assert np.abs(on_plane[:, 0, 3:]).max() > 0.4 * FRICTION * KN * 0.02
    assert np.abs(on_mesh - on_plane).max() < 1e-12 * np.abs(on_plane).max()


def test_sphere_on_triangles_keeps_its_elastic_shear_force():
    """No friction limit reached: shear force = -ks * way, however many facets were passed."""
    rng = np.random.default_rng(9)
    facets = floor_of_triangles(rng, count=40)
    rows = particle_rows(3, [[-1.0, 0.3, 0.9]], 1.0)
    rows[0, 4] = 0.05
    scene = WallScene([walls.triangles("floor", facets)], rows, buffer=0.5)
    found = scene.slide(1000)[:, 0]
    way = 0.05 * 1e-3 * np.arange(1, 1001)
    assert found[:, 0] == pytest.approx(-KS * way, rel=1e-12)
    assert np.abs(found[:, 2] - KN * 0.1).max() < 1e-9 * KN
    assert scene.contacts == 1


@pytest.mark.parametrize("seed", range(4))
def test_disc_slides_over_segments_as_over_a_line(seed):
    rng = np.random.default_rng(seed)
    x = np.concatenate([[-6.0], np.sort(rng.uniform(-1.5, 1.5, 12)), [6.0]])
    flat = np.stack([x, np.zeros(len(x))], axis=1)
    angle = 0.4
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    results = []
    for wall in (
        walls.segments("floor", flat[:: 1 if seed % 2 else -1] @ turn.T),
        walls.plane("floor", (0, 0), turn @ (0.0, 1.0)),
    ):
        rows = particle_rows(2, [turn @ (-1.5, 0.98)], 1.0)
        # right over a corner in step 400
        rows[0, 4:6] = turn @ ((x[7] + 1.5) / 0.4, -0.01)
        rows[0, 6] = 0.7
        results.append(WallScene([wall], rows, buffer=1.0).slide(900))
    on_chain, on_line = results
    assert np.abs(on_chain - on_line).max() < 1e-12 * np.abs(on_line).max()


@pytest.mark.parametrize("dimension", [2, 3])
def test_normal_turns_continuously_over_a_convex_edge(dimension):
    """A roof of 90 degrees: the force of a particle led around its ridge at constant overlap only turns."""
    if dimension == 2:
        wall = walls.segments("roof", [(-3, -3), (0, 0), (3, -3)])
    else:
        a, b, c, d = (-3, -3, -3), (-3, 3, -3), (0, -3, 0), (0, 3, 0)
        e, f = (3, -3, -3), (3, 3, -3)
        wall = walls.triangles("roof", [(a, b, c), (b, c, d), (c, d, e), (d, e, f)])
    rows = particle_rows(dimension, np.zeros(dimension), 1.0)
    scene = WallScene([wall], rows, buffer=2.0)
    for angle in np.linspace(-np.pi / 4, np.pi / 4, 200):
        out = np.array([np.sin(angle), np.cos(angle)])
        rows[0, [0, dimension - 1]] = 0.9 * out
        force = scene.forces()[0]
        assert scene.contacts == 1
        assert force[[0, dimension - 1]] == pytest.approx(KN * 0.1 * out, abs=1e-9 * KN)
    # beside the ridge the facets themselves: the same normal
    rows[0, [0, dimension - 1]] += np.sqrt(0.5) * np.array([1.0, -1.0]) * 0.5
    assert scene.forces()[0, [0, dimension - 1]] == pytest.approx(KN * 0.1 * out, abs=1e-9 * KN)


@pytest.mark.parametrize("dimension", [2, 3])
def test_concave_corner_has_two_contacts(dimension):
    if dimension == 2:
        wall = walls.segments("corner", [(0, 5), (0, 0), (5, 0)])
    else:
        a, b, c, d = (0, -5, 5), (0, 5, 5), (0, -5, 0), (0, 5, 0)
        e, f = (5, -5, 0), (5, 5, 0)
        wall = walls.triangles("corner", [(a, b, c), (b, c, d), (c, d, e), (d, e, f)])
    centre = np.zeros(dimension)
    centre[0], centre[-1] = 0.97, 0.99
    scene = WallScene([wall], particle_rows(dimension, centre, 1.0), buffer=2.0)
    force = scene.forces()[0]
    assert scene.contacts == 2
    assert force[0] == pytest.approx(0.03 * KN, rel=1e-12)
    assert force[dimension - 1] == pytest.approx(0.01 * KN, rel=1e-12)


def test_two_walls_with_one_surface_are_two_contacts():
    """Only facets of one body are one surface."""
    floor = [(-5, 0), (5, 0)]
    scene = WallScene(
        [walls.segments("one", floor), walls.segments("two", floor)], particle_rows(2, [[0.0, 0.9]], 1.0)
    )
    assert scene.forces()[0, 1] == pytest.approx(2 * 0.1 * KN)


def random_scene(dimension, rng):
    """Particles pressed into a turning mesh and a turning plane, all with any velocity."""
    if dimension == 2:
        chain = walls.segments(
            "mesh", [(-2, 0), (-0.5, 0.4), (0.4, -0.2), (2, 0.3)],
            velocity=rng.normal(size=2), spin=rng.normal(), centre=rng.normal(size=2),
        )  # fmt: skip
        others = {"velocity": rng.normal(size=2), "spin": rng.normal()}
    else:
        facets = floor_of_triangles(rng) * [0.4, 0.4, 1.0]
        facets[:, :, 2] = 0.2 * np.sin(2 * facets[:, :, 0]) * np.cos(facets[:, :, 1])
        chain = walls.triangles(
            "mesh", facets, velocity=rng.normal(size=3), spin=rng.normal(size=3), centre=rng.normal(size=3)
        )
        others = {"velocity": rng.normal(size=3), "spin": rng.normal(size=3)}
    side = walls.plane("side", -0.6 * np.eye(dimension)[0], np.eye(dimension)[0] + 0.1, **others)
    positions = rng.uniform(-1.0, 1.0, (9, dimension))
    positions[:, -1] = rng.uniform(0.3, 0.5, 9)
    rows = particle_rows(dimension, positions, rng.uniform(0.3, 0.6, 9))
    rows[:, 4 : 4 + dimension] = rng.normal(size=(9, dimension))
    rows[:, 6 if dimension == 2 else 8 : 7 if dimension == 2 else 11] = rng.normal(
        size=(9, 2 * dimension - 3)
    )
    return WallScene([chain, side], rows, buffer=1.0, dt=1e-4)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_walls_feel_the_opposite_of_what_the_particles_feel(dimension, seed):
    """Momentum and angular momentum about the origin: sum F = 0, sum (x x F + T) = 0."""
    scene = random_scene(dimension, np.random.default_rng(seed))
    scene.slide(50)
    force = scene.forces()
    assert scene.contacts > 3
    table = scene.table
    centres = table.bodies[:, wall_geometry.BODY_CENTRE : wall_geometry.BODY_CENTRE + dimension]
    centres = centres + table.displacements()
    places = np.concatenate([scene.rows[:, :dimension], centres])
    forces = np.concatenate([force[:, :dimension], table.forces()])
    torques = np.concatenate([force[:, dimension:], table.torques()])
    scale = np.abs(forces).max()
    assert np.abs(forces.sum(axis=0)).max() < 1e-12 * scale
    if dimension == 2:
        lever = (places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0])[:, np.newaxis]
    else:
        lever = np.cross(places, forces)
    assert np.abs((lever + torques).sum(axis=0)).max() < 1e-12 * scale


@pytest.mark.parametrize("dimension", [2, 3])
def test_rigid_motion_of_a_particle_with_its_wall_is_no_slip(dimension):
    """Frame indifference: what was stored turns with the pair, to second order in the step."""
    spin = np.array([1.3]) if dimension == 2 else np.array([0.7, -0.4, 1.1])
    velocity = np.array([0.3, -0.2, 0.5])[:dimension]
    wall = walls.plane("floor", np.zeros(dimension), np.eye(dimension)[-1], velocity=velocity, spin=spin)
    start = np.array([0.4, 0.95]) if dimension == 2 else np.array([0.4, -0.3, 0.95])
    errors = []
    for steps in (200, 400):
        rows = particle_rows(dimension, [start], 1.0)
        scene = WallScene([wall], rows, buffer=5.0, dt=1.0 / steps)
        scene.pairs.history[0, : dimension - 1] = [7e3, -4e3][: dimension - 1]
        scene.pairs.touching[0] = 1
        scene.pairs.normal[0, dimension - 1] = -1.0
        b = scene.table.bodies[0]
        for k in range(1, steps + 1):
            scene.kernel.move_walls(scene.table.bodies, scene.dt)
            turn = rotation(spin, k / steps)
            rows[0, :dimension] = turn @ start + velocity * k / steps
            # leap-frog: the velocity of half a step ago
            before = rotation(spin, (k - 1) / steps) @ start + velocity * (k - 1) / steps
            rows[0, 4 : 4 + dimension] = (rows[0, :dimension] - before) * steps
            rows[0, 6 if dimension == 2 else 8 : 7 if dimension == 2 else 11] = spin
            force = scene.forces()[0, :dimension]
        r = b[wall_geometry.BODY_ROTATION : wall_geometry.BODY_ROTATION + 9].reshape(3, 3)
        assert np.abs(r[:dimension, :dimension] - rotation(spin, 1.0)).max() < 1e-12
        assert np.abs(r @ r.T - np.eye(3)).max() < 1e-14
        if dimension == 2:
            # shear along t = (-ny, nx) = (1, 0) for n = (0, -1)
            at_start = np.array([7e3, 0.05 * KN])
        else:
            at_start = np.array([7e3, -4e3, 0.05 * KN])
        errors.append(np.linalg.norm(force - turn @ at_start) / np.linalg.norm(at_start))
    assert errors[0] < 1e-3
    assert errors[1] < 0.27 * errors[0]


def rotation(spin, time):
    if len(spin) == 1:
        c, s = np.cos(spin[0] * time), np.sin(spin[0] * time)
        return np.array([[c, -s], [s, c]])
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(spin * time).as_matrix()


@pytest.mark.parametrize("dimension", [2, 3])
def test_no_slip_where_a_particle_rolls(dimension):
    """A wall of speed v below a particle that turns with v / (distance to the wall): nothing is sheared."""
    velocity = np.zeros(dimension)
    velocity[0] = 0.8
    wall = walls.plane("belt", np.zeros(dimension), np.eye(dimension)[-1], velocity=velocity)
    rows = particle_rows(dimension, 0.9 * np.eye(dimension)[-1], 1.0)
    # the lowest point of a disc with spin w moves with w * 0.9 along x
    rows[0, 6 if dimension == 2 else 9] = 0.8 / 0.9 if dimension == 2 else -0.8 / 0.9
    force = WallScene([wall], rows).slide(20)[-1, 0]
    assert force[0] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(force[dimension:]).max() < 1e-9


def test_energy_is_accounted_for():
    """A plate drags a held sphere: its work is what friction takes and what the contact stores."""
    wall = walls.plane("plate", (0, 0, 0), (0, 0, 1), velocity=(4.0, 1.0, 0.0))
    scene = WallScene([wall], particle_rows(3, [[0.0, 0.0, 0.9]], 1.0), dt=1e-4)
    scene.slide(2000)
    scene.forces()
    # first the spring is wound up to the friction limit, then all is friction
    way = np.hypot(4.0, 1.0) * 1e-4 * 2001
    limit = FRICTION * KN * 0.1
    wound = limit / KS
    friction = limit * (way - wound)
    assert scene.energy[0] == pytest.approx(friction, rel=1e-3)
    assert scene.energy[3] == pytest.approx(0.5 * KN * 0.01 + 0.5 * limit**2 / KS, rel=1e-9)
    assert scene.table.work()[0] == pytest.approx(friction + 0.5 * limit**2 / KS, rel=1e-3)


def test_contact_that_reaches_beyond_touch_begins_at_touch():
    rows = particle_rows(3, [[0.1, 0.2, 1.05]], 1.0)
    facets = floor_of_triangles(np.random.default_rng(1))
    scene = WallScene([walls.triangles("floor", facets)], rows, buffer=0.5, reach=0.1)
    assert scene.forces()[0, 2] == 0.0
    rows[0, 2] = 0.99
    assert scene.forces()[0, 2] > 0.0
    rows[0, 2] = 1.05
    assert scene.forces()[0, 2] == pytest.approx(-0.05 * KN)
    rows[0, :2] += 1.0
    assert scene.forces()[0, 2] == pytest.approx(-0.05 * KN)
    rows[0, 2] = 1.11
    assert scene.forces()[0, 2] == 0.0
    rows[0, 2] = 1.05
    assert scene.forces()[0, 2] == 0.0
