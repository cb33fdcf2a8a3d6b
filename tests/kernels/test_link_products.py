"""Stiffness times displacement without a matrix, and the frequency from it, against the matrix."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.assembly import Anchors
from geodem.integrators.critical_step import largest_frequency, largest_frequency_of_products
from geodem.integrators.network import RIGID, anchor_springs, build_network, links, stiffness_matrix
from geodem.kernels.link_products import link_product


def network(dimension, count=40, seed=3):
    """Links at random between particles and with walls, and a few springs."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(0.0, 5.0, (count, dimension))
    first = np.repeat(np.arange(count), 4)
    second = (first + rng.integers(1, count, len(first))) % count
    second[::7] = RIGID
    normal = rng.normal(size=(len(first), dimension))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    kn, ks, twist, bend = rng.uniform(0.1, 2.0, (4, len(first)))
    found = links(first, second, normal, rng.uniform(0.2, 1.0, (len(first), 2)), kn, ks, twist, bend)
    anchors = Anchors(
        np.array([2, 5], dtype=np.int32), rng.uniform(0.0, 5.0, (2, dimension)), np.array([3.0, 1.0]),
        np.array([0.1, 0.0]),
    )  # fmt: skip
    springs = anchor_springs(positions, anchors)
    return positions, found, springs


@pytest.mark.parametrize("dimension", [2, 3])
def test_products_are_those_of_the_matrix(dimension):
    positions, found, springs = network(dimension)
    matrix = stiffness_matrix(build_network(positions, found, springs))
    moved = np.random.default_rng(5).normal(size=(len(positions), 3 if dimension == 2 else 6))
    expected = (matrix @ moved.ravel()).reshape(moved.shape)
    assert link_product(found, springs, moved) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_frequency_without_a_matrix(dimension):
    positions, found, springs = network(dimension, count=200)
    matrix = stiffness_matrix(build_network(positions, found, springs))
    freedoms = 3 if dimension == 2 else 6
    mass = np.random.default_rng(6).uniform(0.5, 2.0, (len(positions), freedoms))
    held = np.zeros(mass.shape, dtype=bool)
    held[:5] = True
    exact = largest_frequency(matrix, mass, held, accuracy=1e-9)
    quick = largest_frequency_of_products(lambda moved: link_product(found, springs, moved), mass, held)
    # the squared frequency is at most the residual too large, and that is added on top
    assert exact * (1.0 - 1e-6) <= quick <= exact * 1.005


def test_nothing_free():
    _, found, springs = network(2)
    held = np.ones((40, 3), dtype=bool)
    assert (
        largest_frequency_of_products(lambda u: link_product(found, springs, u), np.ones((40, 3)), held)
        == 0.0
    )
