"""Strains of links: blind to rigid motion, and forces that are the slope of the elastic energy."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.assembly import Anchors
from geodem.integrators.link_stiffness import law_stiffness
from geodem.integrators.network import (
    RIGID,
    anchor_springs,
    build_network,
    imposed_strain,
    joined,
    link_forces,
    link_strains,
    links,
    pair_links,
    stiffness_matrix,
)
from geodem.laws.bond import parallel_bond


def cloud(dimension, seed=3):
    """Eight unequal overlapping particles, all linked, no two stiffnesses alike."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(0.0, 3.0, (8, dimension))
    radii = rng.uniform(0.5, 1.0, 8)
    pairs = np.argwhere(np.triu(np.ones((8, 8)), 1))
    stiffness = rng.uniform(0.5, 2.0, (4, len(pairs)))
    return positions, radii, build_network(positions, pair_links(positions, radii, pairs, *stiffness))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_motion_strains_nothing(dimension):
    positions, _, network = cloud(dimension)
    spin = np.array([0.3]) if dimension == 2 else np.array([0.3, -0.5, 0.2])
    moved = np.zeros((len(positions), network.freedoms))
    if dimension == 2:
        moved[:, :2] = spin * np.stack([-positions[:, 1], positions[:, 0]], axis=1)
    else:
        moved[:, :3] = np.cross(spin, positions)
    moved[:, :dimension] += 0.7
    moved[:, dimension:] = spin
    strains = link_strains(network, moved)
    for part in strains:
        np.testing.assert_allclose(part, 0.0, atol=1e-14)
    assert np.abs(stiffness_matrix(network) @ moved.ravel()).max() < 1e-13
    # a rotation of the centres without that of the particles does strain: the test can fail
    moved[:, dimension:] = 0.0
    assert np.abs(link_strains(network, moved).slip).max() > 0.1


@pytest.mark.parametrize("dimension", [2, 3])
def test_strains_by_their_definition(dimension):
    """Extension, slip, twist and bend as the equations say, vector by vector."""
    positions, radii, network = cloud(dimension)
    moved = np.random.default_rng(5).normal(size=(len(positions), network.freedoms))
    strains = link_strains(network, moved)
    for k, (a, b) in enumerate(zip(network.links.first, network.links.second, strict=True)):
        branch = positions[b] - positions[a]
        distance = np.linalg.norm(branch)
        n = branch / distance
        arm_a = radii[a] - 0.5 * (radii[a] + radii[b] - distance)
        translation = moved[b, :dimension] - moved[a, :dimension]
        turn = arm_a * moved[a, dimension:] + (distance - arm_a) * moved[b, dimension:]
        bend = moved[b, dimension:] - moved[a, dimension:]
        np.testing.assert_allclose(strains.extension[k], n @ translation, atol=1e-13)
        if dimension == 2:
            t = np.array([-n[1], n[0]])
            np.testing.assert_allclose(strains.slip[k], t @ translation - turn, atol=1e-13)
            np.testing.assert_allclose(strains.bend[k], bend, atol=1e-13)
        else:
            relative = translation - np.cross(turn, n)
            np.testing.assert_allclose(strains.slip[k], relative - n * (n @ relative), atol=1e-13)
            np.testing.assert_allclose(strains.twist[k], n @ bend, atol=1e-13)
            np.testing.assert_allclose(strains.bend[k], bend - n * (n @ bend), atol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_on_particles(dimension):
    """K u is minus the sum of the links' forces: F_a = tension n + shear, torques with the arms, moments."""
    positions, _, network = cloud(dimension)
    moved = np.random.default_rng(6).normal(size=(len(positions), network.freedoms))
    forces = link_forces(network, moved)
    total = np.zeros_like(moved)
    for k, (a, b) in enumerate(zip(network.links.first, network.links.second, strict=True)):
        n, arms = network.links.normal[k], network.links.arms[k]
        if dimension == 2:
            shear = forces.slip[k] * np.array([-n[1], n[0]])
            torque, moment = forces.slip[k], forces.bend[k]
        else:
            shear, torque = forces.slip[k], np.cross(n, forces.slip[k])
            moment = forces.twist[k] * n + forces.bend[k]
        force = forces.extension[k] * n + shear
        total[a] += [*force, *(arms[0] * torque + moment)]
        total[b] += [*-force, *(arms[1] * torque - moment)]
    np.testing.assert_allclose(stiffness_matrix(network) @ moved.ravel(), -total.ravel(), atol=1e-12)


def test_wall_contact_and_its_motion():
    """A disc on a floor: the particle's motion against the floor, and the floor's against the particle, are one."""
    floor = links([0], RIGID, [[0.0, -1.0]], (0.4, 0.0), 3.0, 2.0)
    network = build_network(np.zeros((1, 2)), floor)
    moved = np.array([[0.1, -0.2, 0.5]])
    strains = link_strains(network, moved)
    # t = (1, 0) for n = (0, -1): slip = -u_x - arm theta
    np.testing.assert_allclose([strains.extension[0], strains.slip[0, 0]], [-0.2, -0.1 - 0.2])
    lifted = link_strains(network, moved, imposed_strain(network, moved[:, :2]))
    np.testing.assert_allclose([lifted.extension[0], lifted.slip[0, 0]], [0.0, -0.2], atol=1e-16)
    np.testing.assert_allclose(stiffness_matrix(network).diagonal(), [2.0, 3.0, 2.0 * 0.16])


def test_joined_links_act_in_parallel():
    positions, radii, _ = cloud(2)
    one = pair_links(positions, radii, [(0, 1)], 1.0, 0.5)
    twice = stiffness_matrix(build_network(positions, joined(one, one)))
    once = stiffness_matrix(build_network(positions, one))
    np.testing.assert_allclose(twice.toarray(), 2.0 * once.toarray())


def test_anchor_in_tension_is_stiff_across_as_well():
    """The tangent of k (l - L) e: k along, T/l across; compressed it keeps only k along."""
    positions = np.zeros((3, 2))
    anchors = Anchors(
        np.array([0, 1, 2], dtype=np.int32),
        np.array([[2.0, 0.0], [2.0, 0.0], [0.0, 0.0]]),
        np.full(3, 10.0),
        np.array([1.5, 2.5, 0.0]),
    )
    network = build_network(
        positions, pair_links(positions, np.ones(3), [], []), anchor_springs(positions, anchors)
    )
    along_and_across = stiffness_matrix(network).diagonal().reshape(3, 3)[:, :2]
    np.testing.assert_allclose(along_and_across, [[10.0, 2.5], [10.0, 0.0], [10.0, 10.0]])


def test_stiffness_of_a_law():
    """Potyondy & Cundall 2004: kn A, ks A, ks J, kn I of the smaller radius; a strip between discs."""
    cement = parallel_bond.ParallelBondParameters(0.5, 2.0, 3.0, 1.0, 1.0)
    radius = {"radius_a": np.array([1.0, 4.0]), "radius_b": np.array([2.0, 2.0])}
    other = {"distance": np.array([3.0, 6.0]), "overlap": np.zeros(2)}
    found = law_stiffness(parallel_bond, 3, np.tile(cement, (2, 1)), **radius, **other)
    for row, r in zip(found, (0.5, 1.0), strict=True):
        area, inertia = np.pi * r**2, np.pi * r**4 / 4.0
        np.testing.assert_allclose(row, [2.0 * area, 3.0 * area, 3.0 * 2.0 * inertia, 2.0 * inertia])
    discs = law_stiffness(parallel_bond, 2, np.tile(cement, (2, 1)), **radius, **other)
    np.testing.assert_allclose(discs[0], [2.0, 3.0, 0.0, 2.0 * (2.0 * 0.5**3 / 3.0)])
