"""Links of supports: their law, a ring under even pressure and in bending, bolts in the ground."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.ground import GroundProperties
from geodem.builders.section import Section
from geodem.errors import InputError
from geodem.laws.support.bar import update_force
from geodem.tunnelling.ground import make_tunnel_ground
from geodem.tunnelling.measure import wall_normals
from geodem.tunnelling.plan import Bolts, Lining, Opening
from geodem.tunnelling.supports import build_bolts, build_lining
from reference.problems.tunnels_deep import circle
from tests.tunnelling.tunnels import CLAY

RING = Lining("ring", "hole", 0.2, 30e9, 0.0)


@pytest.fixture(scope="module")
def ground():
    """A hole of 2 m radius in a square of 12 m."""
    section = Section.from_polygons([("rock", [[-6, -6], [6, -6], [6, 6], [-6, 6]])])
    return make_tunnel_ground(
        section, [Opening("hole", circle(2.0), (0.0, 0.0))], {"rock": GroundProperties.of(0.0, **CLAY)},
        boundary=dict.fromkeys(("left", "right", "bottom", "top"), "fixed"), particles=1500, wall_spacing=0.2,
        gravity=0.0,
    )  # fmt: skip


def assembled(ground, built):
    """Stiffness of the ring alone over its particles, and their places."""
    particles = np.unique(built.chain)
    place = {int(p): k for k, p in enumerate(particles)}
    matrix = np.zeros((2 * len(particles), 2 * len(particles)))
    for row in built.rows:
        vector = np.zeros(len(matrix))
        for p, v in zip(row.particles, row.vectors, strict=True):
            vector[2 * place[p] : 2 * place[p] + 2] = v
        matrix += row.stiffness * np.outer(vector, vector)
    return particles, matrix


def test_the_law_yields_between_its_limits():
    force, plastic = update_force(2.0, -3.0, 5.0, 4.0, 1.0)
    assert (force, plastic) == (5.0, 0.5)
    assert update_force(2.0, -3.0, 5.0, 0.0, 1.0) == (2.0, 0.0)
    assert update_force(2.0, -3.0, 5.0, -2.0, -1.0) == (-3.0, -0.5)


def test_a_ring_under_even_pressure(ground):
    """u = p a^2 / (E t), from the thin ring; within the square of the angle between its particles, 0.5 %."""
    built = build_lining(ground, RING, ground.wall(0, [0]))
    particles, matrix = assembled(ground, built)
    _, normals = wall_normals(ground.model.positions, ground.wall(0, [0]))
    load = (-1e6 * normals).ravel()  # a pressure from the ground
    moved = (np.linalg.pinv(matrix) @ load).reshape(-1, 2)
    at = ground.model.positions[particles]
    inward = -(moved * at).sum(axis=1) / 2.0
    assert inward.mean() == pytest.approx(1e6 * 2.0**2 / (30e9 * 0.2), rel=5e-3)


def test_a_ring_that_is_pressed_flat(ground):
    """Two opposite forces P: the diameter shortens by 0.1488 P a^3 / (E I) (Timoshenko, Strength of materials)."""
    built = build_lining(ground, RING, ground.wall(0, [0]))
    particles, matrix = assembled(ground, built)
    at = ground.model.positions[particles]
    top, bottom = int(np.argmax(at[:, 1])), int(np.argmin(at[:, 1]))
    load = np.zeros(len(matrix))
    load[2 * top + 1], load[2 * bottom + 1] = -1e3, 1e3
    moved = (np.linalg.pinv(matrix) @ load).reshape(-1, 2)
    shortened = moved[bottom, 1] - moved[top, 1]
    stiffness = 30e9 * 0.2**3 / 12.0
    exact = (np.pi / 4.0 - 2.0 / np.pi) * 1e3 * 2.0**3 / stiffness
    # the thrust shortens it as well: P a pi / (4 E A)
    exact += np.pi / 4.0 * 1e3 * 2.0 / (30e9 * 0.2)
    assert shortened == pytest.approx(exact, rel=0.01)


def test_no_motion_as_a_whole_strains_a_lining(ground):
    built = build_lining(ground, RING, ground.wall(0, [0]))
    particles, matrix = assembled(ground, built)
    at = ground.model.positions[particles]
    for motion in (np.tile([1.0, 0.0], (len(at), 1)), np.stack([-at[:, 1], at[:, 0]], axis=1)):
        assert np.abs(matrix @ motion.ravel()).max() < 1e-9 * np.abs(matrix).max()


@pytest.mark.parametrize("anchored", [False, True])
def test_a_bolt_follows_ground_that_is_stretched(ground, anchored):
    """Under u = e x its bars lengthen by e times their length, whatever lies between; grout does not slip."""
    bolts = Bolts("b", (((2.0, 0.0), (5.0, 0.0)),), 1e-3, 200e9, 1e9, 1.0, anchored=anchored)
    count = ground.model.particles
    built = build_bolts(ground, bolts, [0], count, 0.3)
    places = np.concatenate([ground.model.positions, built.nodes])
    displacement = 1e-3 * places * [1.0, 0.0]
    stretch = np.array([(row.vectors * displacement[list(row.particles)]).sum() for row in built.rows])
    bars = built.reading["bar"]
    total = 1e-3 * 3.0
    assert stretch[bars].sum() == pytest.approx(total, rel=0.02)
    rest = np.setdiff1d(np.arange(len(built.rows)), bars)
    assert np.abs(stretch[rest]).max(initial=0.0) < 0.02 * total


def test_a_bolt_that_leaves_the_ground_is_refused(ground):
    bolts = Bolts("b", (((2.0, 0.0), (9.0, 0.0)),), 1e-3, 200e9, 1e9, 1.0)
    with pytest.raises(InputError, match="misses the ground"):
        build_bolts(ground, bolts, [0], ground.model.particles, 0.3)
