"""The scaled mass makes a step of one stable, and hardly shorter than it could be."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.integrators.direct_solve import stiffness
from geodem.integrators.relaxation import SHARE_OF_CRITICAL, scaled_mass
from tests.meshes import slope


def shake(matrix, mass, steps):
    """Leap-frog without damping from random noise of 1e-6; the size after each step."""
    position = np.random.default_rng(1).normal(size=len(mass)) * 1e-6
    velocity = np.zeros_like(position)
    sizes = []
    for _ in range(steps):
        velocity -= (matrix @ position) / mass
        position += velocity
        sizes.append(np.abs(position).max())
    return np.array(sizes)


@pytest.fixture(scope="module", params=[0.3, 0.49], ids=["nu 0.3", "nu 0.49"])
def system(request):
    """Free part of the stiffness and its scaled mass."""
    ground = slope(0.9, nu=request.param)
    matrix, free = stiffness(ground), ~ground.held.ravel()
    return matrix[free][:, free], scaled_mass(matrix, ground.held).ravel()[free]


def test_the_step_is_stable(system):
    matrix, mass = system
    assert shake(matrix, mass, 3000).max() < 1e-4


def test_a_step_a_tenth_beyond_critical_is_not(system):
    """A step longer by x is the same as a mass smaller by x^2."""
    matrix, mass = system
    assert shake(matrix, mass * (SHARE_OF_CRITICAL / 1.1) ** 2, 600).max() > 1.0


def test_the_largest_eigenvalue(system):
    """The critical step is 2/omega; a dense solver says what omega is."""
    matrix, mass = system
    root = 1.0 / np.sqrt(mass)
    largest = np.linalg.eigvalsh((matrix.toarray() * root[:, None]) * root[None, :])[-1]
    share = np.sqrt(largest) / 2.0
    assert SHARE_OF_CRITICAL * 0.96 < share < SHARE_OF_CRITICAL * 1.005


def test_held_freedoms_do_not_matter(system):
    ground = slope(0.9)
    mass = scaled_mass(stiffness(ground), np.ones_like(ground.held))
    assert (mass > 0.0).all()
