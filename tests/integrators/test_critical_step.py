"""The largest frequency against a dense solver, and what damping does to the step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.spatial import Delaunay

from geodem.integrators.critical_step import critical_step, gershgorin_frequency, largest_frequency
from geodem.integrators.network import build_network, pair_links, stiffness_matrix


def discs(count, seed):
    """Discs at random with radii 0.3 to 1 and stiffness over two decades."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(0.0, math.sqrt(count), (count, 2))
    corners = Delaunay(positions).simplices
    pairs = np.unique(np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]]), axis=1), axis=0)
    radii = rng.uniform(0.3, 1.0, count)
    kn = 10.0 ** rng.uniform(-1.0, 1.0, len(pairs))
    network = build_network(positions, pair_links(positions, radii, pairs, kn, 0.4 * kn, 0.0, 0.1 * kn))
    mass = np.stack([radii**2, radii**2, 0.5 * radii**4], axis=1)
    held = np.zeros(mass.shape, dtype=bool)
    held[:3] = True
    return stiffness_matrix(network), mass, held


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("count", [15, 150])
def test_frequency_against_a_dense_solver(count, seed):
    matrix, mass, held = discs(count, seed)
    free = ~held.ravel()
    root = 1.0 / np.sqrt(mass.ravel()[free])
    dense = matrix.toarray()[np.ix_(free, free)] * root[:, None] * root[None, :]
    exact = math.sqrt(np.linalg.eigvalsh(dense)[-1])
    found = largest_frequency(matrix, mass, held)
    assert exact * (1.0 - 1e-9) <= found <= exact * 1.001
    assert exact <= gershgorin_frequency(matrix, mass, held) <= 2.5 * exact


def test_the_same_every_time():
    matrix, mass, held = discs(400, 1)
    assert largest_frequency(matrix, mass, held) == largest_frequency(matrix, mass, held)


def test_nothing_free_and_nothing_stiff():
    matrix, mass, held = discs(15, 1)
    assert largest_frequency(matrix, mass, np.ones_like(held)) == 0.0
    assert largest_frequency(csr_matrix(matrix.shape), mass) == 0.0
    assert critical_step(0.0) == math.inf


def test_steps_with_damping():
    """2/omega; times sqrt(1 + xi^2) - xi; over sqrt(1 + alpha). Both: xi and omega grow by sqrt(1 + alpha)."""
    assert critical_step(4.0) == 0.5
    assert critical_step(4.0, viscous=0.75) == pytest.approx(0.5 * (1.25 - 0.75))
    assert critical_step(4.0, local=0.8) == pytest.approx(0.5 / math.sqrt(1.8))
    assert critical_step(4.0, viscous=0.375, local=3.0) == pytest.approx(0.25 * (1.25 - 0.75))


def _oscillator(step, *, mass_proportional=0.0, viscous=0.0, steps=5000):
    """Largest displacement of u'' + a u' + 2 xi u' + u = 0 by leap-frog; the viscous force lags half a step."""
    position, velocity, largest = 1.0, 0.0, 0.0
    half = 0.5 * mass_proportional * step
    for _ in range(steps):
        force = -position - 2.0 * viscous * velocity
        velocity = (velocity * (1.0 - half) + step * force) / (1.0 + half)
        position += step * velocity
        largest = max(largest, abs(position))
        if largest > 1e6:
            break
    return largest


@pytest.mark.parametrize("ratio", [0.05, 0.3, 1.0])
def test_viscous_damping_at_its_limit(ratio):
    limit = critical_step(1.0, viscous=ratio)
    assert _oscillator(0.995 * limit, viscous=ratio) < 100.0
    assert _oscillator(1.005 * limit, viscous=ratio) > 1e6


def test_mass_proportional_damping_leaves_the_limit_alone():
    limit = critical_step(1.0)
    assert _oscillator(0.995 * limit, mass_proportional=0.5) < 100.0
    assert _oscillator(1.005 * limit, mass_proportional=0.5) > 1e6
