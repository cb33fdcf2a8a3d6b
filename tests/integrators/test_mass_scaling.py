"""One mass and one moment of inertia a particle: stable at a step of one, and not much longer."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.integrators.mass_scaling import scaled_inertia
from geodem.integrators.network import Links, build_network, stiffness_matrix
from geodem.integrators.relaxation import SHARE_OF_CRITICAL
from tests.integrators.test_elastic_network import block


def _scaled(dimension, unit=1.0):
    network, _, held = block(dimension, 6)
    bent = unit**2
    parts = network.links._replace(
        arms=unit * network.links.arms,
        k_bend=bent * network.links.k_bend,
        k_twist=bent * network.links.k_twist,
    )
    network = build_network(unit * network.positions, parts)
    mass, inertia = scaled_inertia(network, held)
    return network, held, mass, inertia


@pytest.mark.parametrize("dimension", [2, 3])
def test_share_of_the_critical_step(dimension):
    """The largest eigenvalue of M^-1 K by a dense solver; leap-frog's limit at a step of one is 4."""
    network, held, mass, inertia = _scaled(dimension)
    each = np.concatenate(
        [
            np.repeat(mass[:, None], dimension, axis=1),
            np.repeat(inertia[:, None], network.freedoms - dimension, 1),
        ],
        axis=1,
    )
    free = ~held.ravel()
    root = 1.0 / np.sqrt(each.ravel()[free])
    dense = stiffness_matrix(network).toarray()[np.ix_(free, free)] * root[:, None] * root[None, :]
    share = np.sqrt(np.linalg.eigvalsh(dense)[-1]) / 2.0
    assert 0.9 * SHARE_OF_CRITICAL < share < SHARE_OF_CRITICAL * 1.005


@pytest.mark.parametrize("dimension", [2, 3])
def test_units_of_length_do_not_matter(dimension):
    _, _, mass, inertia = _scaled(dimension)
    _, _, small_mass, small_inertia = _scaled(dimension, unit=1e-3)
    np.testing.assert_allclose(small_mass, mass, rtol=1e-9)
    np.testing.assert_allclose(small_inertia, 1e-6 * inertia, rtol=1e-9)


def test_a_particle_without_links_has_a_mass():
    network, held, _, _ = _scaled(2)
    away = (network.links.first == 20) | (network.links.second == 20)
    loose = build_network(network.positions, Links(*(v[~away] for v in network.links)))
    mass, inertia = scaled_inertia(loose, held)
    assert mass[20] == mass.max()
    assert (inertia > 0.0).all()
