"""The pair list in a periodic cell against every particle compared with every image of every other."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from geodem.neighbors import bond_pairs, lattice, rebuild, spatial_order, wrapped
from tests.neighbors.scenes import assert_well_formed, memory, random_rows, write_memory


def sheared_cell(side, dimension):
    edges = side * np.eye(dimension)
    edges[1, 0] = 0.4 * side
    edges[-1, 0] = -0.3 * side
    return edges


def scene(dimension, ratio, particles=401):
    """Rows whose places lie in many cells around the one that is meant."""
    rng = np.random.default_rng(dimension)
    rows = random_rows(rng, particles, dimension, ratio=ratio)
    places = rows[:, :dimension]
    edges = sheared_cell(float(places.max()), dimension)
    rows[:, :dimension] = rng.uniform(-2.0, 3.0, places.shape) @ edges
    return rows, edges


def images_by_brute_force(rows, edges, buffer, periodic):
    """Branches of all pairs of rows that are near, by pair; fails where two images are."""
    dimension = len(edges)
    places, radii = rows[:, :dimension], rows[:, dimension]
    i, j = np.triu_indices(len(rows), 1)
    share = (places[j] - places[i]) @ np.linalg.inv(edges)
    share[:, periodic] -= np.floor(share[:, periodic])
    found = {}
    for image in itertools.product(*[(-2, -1, 0, 1) if each else (0,) for each in periodic]):
        branch = (share + image) @ edges
        near = np.sqrt((branch**2).sum(axis=1)) < radii[i] + radii[j] + buffer
        for a, b, way in zip(i[near], j[near], branch[near], strict=True):
            assert (a, b) not in found
            found[int(a), int(b)] = way
    return found


def search(rows, ids, old, *maps, edges, periodic, chunk=64, buffer=0.2):
    dimension = len(edges)
    pairs = rebuild(
        rows, ids, old, *maps, chunk=chunk, buffer=buffer, dimension=dimension, history_width=2,
        cell=lattice(edges, periodic),
    )  # fmt: skip
    assert_well_formed(pairs, ids)
    return pairs


@pytest.mark.parametrize("ratio", [1.0, 6.0])
@pytest.mark.parametrize("periodic", ["all", "but one"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_finds_the_nearest_images_and_no_other(dimension, periodic, ratio):
    rows, edges = scene(dimension, ratio)
    along = np.ones(dimension, dtype=bool)
    along[1] = periodic == "all"
    ids = np.random.default_rng(9).permutation(len(rows))
    pairs = search(rows, ids, None, edges=edges, periodic=tuple(along))
    expected = images_by_brute_force(rows, edges, 0.2, along)
    assert pairs.pairs == len(expected) > 50
    branch = rows[pairs.b, :dimension] - rows[pairs.a, :dimension] + pairs.image @ edges
    for a, b, way in zip(pairs.a.tolist(), pairs.b.tolist(), branch, strict=True):
        assert np.allclose(way if a < b else -way, expected[min(a, b), max(a, b)], atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_pairs_remember_survives_a_new_order_and_other_edges_of_the_same_lattice(dimension):
    rows, edges = scene(dimension, 1.0)
    ids = np.arange(len(rows))
    along = (True,) * dimension
    first = search(rows, ids, None, edges=edges, periodic=along)
    write_memory(first, ids, np.random.default_rng(1))
    before = memory(first, ids)
    order = spatial_order(wrapped(rows, lattice(edges, along), dimension), rows[:, dimension].copy())
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    edges = edges.copy()
    edges[1] += edges[0]
    again = search(rows[order], ids[order], first, order, back, edges=edges, periodic=along)
    assert memory(again, ids[order]) == before


def test_a_bond_longer_than_near_is_listed_once_with_its_image():
    edges = 20.0 * np.eye(2)
    rows = np.full((3, 8), np.nan)
    rows[:, :3] = [(1.0, 1.0, 1.0), (37.0, 1.0, 1.0), (10.0, 10.0, 1.0)]
    ids = np.arange(3)
    pairs = bond_pairs(
        rows, ids, np.array([[0, 1]]), np.zeros((1, 1)), offset=1, chunk=64, buffer=0.2, dimension=2, history_width=2,
        cell=lattice(edges, (True, True)),
    )  # fmt: skip
    assert pairs.pairs == pairs.far == 1
    # 37 - 40 - 1: four apart, to the left
    assert pairs.image.tolist() == [[-2, 0]]
    rows[1, 0] = 39.5
    near = search(rows, ids, pairs, edges=edges, periodic=(True, True))
    assert (near.pairs, near.far, near.bond.tolist()) == (1, 0, [1])


def test_a_lost_particle_is_near_to_nothing():
    rows, edges = scene(2, 1.0)
    rows[7, 0] = np.nan
    pairs = search(rows, np.arange(len(rows)), None, edges=edges, periodic=(True, True))
    assert 7 not in pairs.a
    assert 7 not in pairs.b
