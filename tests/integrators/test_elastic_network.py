"""The direct solve: both ways give one answer, and what cannot stand is named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geodem.errors import InputError
from geodem.integrators import elastic_network
from geodem.integrators.elastic_network import solve_network
from geodem.integrators.network import (
    RIGID,
    build_network,
    imposed_strain,
    joined,
    links,
    pair_links,
    stiffness_matrix,
)


def block(dimension, side, *, bending=0.3):
    """Bonded particles near the points of a grid, bonds diagonal across squares too; layer 0 held, gravity."""
    axes = np.meshgrid(*[np.arange(side, dtype=float)] * dimension, indexing="ij")
    positions = np.stack(axes, axis=-1).reshape(-1, dimension)
    layer = positions[:, -1].copy()
    positions += np.random.default_rng(2).uniform(-0.1, 0.1, positions.shape)
    pairs = cKDTree(positions).query_pairs(1.6, output_type="ndarray")
    bonds = pair_links(positions, np.full(len(positions), 0.5), np.sort(pairs), 2.0, 1.0, bending, bending)
    network = build_network(positions, bonds)
    held = np.zeros((len(positions), network.freedoms), dtype=bool)
    held[layer == 0.0] = True
    load = np.zeros(held.shape)
    load[:, dimension - 1] = -1e-3
    return network, load, held


@pytest.mark.parametrize(("dimension", "side"), [(2, 30), (3, 9)])
def test_factors_and_two_levels_give_the_same(monkeypatch, dimension, side):
    network, load, held = block(dimension, side)
    direct = solve_network(network, load, held=held)
    monkeypatch.setattr(elastic_network, "DIRECT_LIMIT", 0)
    monkeypatch.setattr(elastic_network, "SECOND_TRY_LIMIT", 0)
    # a bound on the iterations holds only where the coarse level does its work: Jacobi alone takes 100 to 200
    monkeypatch.setattr(elastic_network, "ITERATIONS", 60)
    iterated = solve_network(network, load, held=held)
    np.testing.assert_allclose(iterated, direct, atol=1e-8 * np.abs(direct).max())
    free = ~held.ravel()
    unbalanced = (load.ravel() - stiffness_matrix(network) @ direct.ravel())[free]
    assert np.abs(unbalanced).max() < 1e-9 * 1e-3


def test_lengths_in_other_units(monkeypatch):
    """The same block in millimetres: displacements times 1000, rotations as they were."""
    network, load, held = block(2, 12)
    metres = solve_network(network, load, held=held)
    scaled = network.links._replace(arms=1e3 * network.links.arms, k_bend=1e6 * network.links.k_bend)
    millimetres = build_network(1e3 * network.positions, scaled)
    for limit in (6000, 0):
        monkeypatch.setattr(elastic_network, "DIRECT_LIMIT", limit)
        found = solve_network(millimetres, 1e3 * load, held=held)
        np.testing.assert_allclose(found / [1e3, 1e3, 1.0], metres, atol=1e-8 * np.abs(metres).max())


def test_a_moved_wall_pushes():
    """Two springs in series between a wall that moves by w and a held disc: k1 w/(k1 + k2)."""
    positions = np.array([[0.0, 0.0], [1.0, 0.0]])
    bond = pair_links(positions, np.full(2, 0.5), [(0, 1)], 2.0, 1.0)
    wall = links([1], RIGID, [[1.0, 0.0]], (0.5, 0.0), 6.0)
    network = build_network(positions, joined(bond, wall))
    held = np.zeros((2, 3), dtype=bool)
    held[0] = True
    imposed = imposed_strain(network, np.array([[0.0, 0.0], [-0.1, 0.0]]))
    moved = solve_network(network, np.zeros((2, 3)), held=held, imposed=imposed)
    assert moved[1, 0] == pytest.approx(-0.1 * 6.0 / 8.0)


def test_prescribed_motion():
    network, load, held = block(2, 8)
    prescribed = np.zeros(held.shape)
    prescribed[:, 0] = 0.25
    moved = solve_network(network, 0.0 * load, held=held, prescribed=prescribed)
    np.testing.assert_allclose(moved[:, :2], np.tile([0.25, 0.0], (len(moved), 1)), atol=1e-9)


def test_a_particle_without_bonds_is_named():
    network, load, held = block(2, 6)
    away = (network.links.first == 20) | (network.links.second == 20)
    loose = build_network(network.positions, type(network.links)(*(v[~away] for v in network.links)))
    with pytest.raises(InputError, match="particle 20 can move"):
        solve_network(loose, load, held=held)
    # without a load it may float
    load[20] = 0.0
    moved = solve_network(loose, load, held=held)
    assert (moved[20] == 0.0).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_on_a_smooth_floor(dimension):
    """It stands under its weight; pushed along the floor there is no equilibrium, and all of it is named."""
    network, load, held = block(dimension, 4)
    lowest = np.flatnonzero(held[:, 0])
    down = np.tile(-np.eye(dimension)[-1], (len(lowest), 1))
    floor = links(lowest, RIGID, down, (0.5, 0.0), 5.0)
    network = build_network(network.positions, joined(network.links, floor))
    free = np.zeros_like(held)
    moved = solve_network(network, load, held=free)
    assert np.isfinite(moved).all()
    # the floor's springs carry the weight
    carried = -5.0 * moved[lowest, dimension - 1].sum()
    assert carried == pytest.approx(1e-3 * len(load))
    load[:, 0] = 1e-4
    with pytest.raises(InputError, match=f"and {len(load) - elastic_network.NAMED} more can move"):
        solve_network(network, load, held=free)


def test_a_hinge_is_found():
    """A chain of discs bonded without bending stiffness hangs, but does not stand out sideways under weight."""
    positions = np.stack([np.arange(6.0), np.zeros(6)], axis=1)
    pairs = np.stack([np.arange(5), np.arange(1, 6)], axis=1)
    held = np.zeros((6, 3), dtype=bool)
    held[0] = True
    across = np.zeros((6, 3))
    across[:, 1] = -1.0
    hinged = build_network(positions, pair_links(positions, np.full(6, 0.5), pairs, 1.0, 1.0))
    with pytest.raises(InputError, match="can move without resistance"):
        solve_network(hinged, across, held=held)
    along = np.roll(across, -1, axis=1)
    moved = solve_network(hinged, along, held=held)
    assert moved[-1, 0] == pytest.approx(-(5 + 4 + 3 + 2 + 1))
    stiff = build_network(positions, pair_links(positions, np.full(6, 0.5), pairs, 1.0, 1.0, 0.0, 1.0))
    assert np.isfinite(solve_network(stiff, across, held=held)).all()


def test_gears_do_no_harm():
    """Discs on a square grid without bending stiffness spin against each other freely; no load asks them to."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0))
    positions = np.stack([x.ravel(), y.ravel()], axis=1)
    pairs = cKDTree(positions).query_pairs(1.1, output_type="ndarray")
    bonds = pair_links(positions, np.full(16, 0.5), np.sort(pairs), 2.0, 1.0)
    network = build_network(positions, bonds)
    held = np.zeros((16, 3), dtype=bool)
    held[:4, :2] = True
    load = np.zeros((16, 3))
    load[-4:, 1] = -1.0
    moved = solve_network(network, load, held=held)
    np.testing.assert_allclose(moved[-4:, 1], -3.0 / 2.0, rtol=1e-9)
    assert math.isclose(np.abs(moved[:, 2]).max(), 0.0, abs_tol=1e-6)
