"""The parallel bond against the beam that it stands for (Potyondy & Cundall 2004, section 2.3)."""

from math import pi

import numpy as np
import pytest

from geodem.laws.bond import parallel_bond
from geodem.laws.bond.parallel_bond import ParallelBondParameters
from tests.contract.two_particles import Motion, Pair

YOUNG, SHEAR, LENGTH, RADIUS = 30e9, 12e9, 0.02, 0.01
# a beam of the length of the two radii: kn = E/L, ks = G/L of it
BEAM = ParallelBondParameters(1.0, YOUNG / LENGTH, SHEAR / LENGTH, 1e6, 1e6)


def test_the_round_beam_of_spheres():
    """E A/L, G A/L, G J/L, E I/L with A = pi R^2, I = pi R^4/4, J = pi R^4/2."""
    pair = Pair(parallel_bond, BEAM, 3, radii=(RADIUS, RADIUS))
    assert pair.stiffness() == pytest.approx(
        [
            YOUNG * pi * RADIUS**2 / LENGTH,
            SHEAR * pi * RADIUS**2 / LENGTH,
            SHEAR * pi * RADIUS**4 / 2.0 / LENGTH,
            YOUNG * pi * RADIUS**4 / 4.0 / LENGTH,
        ],
        rel=1e-14,
    )


def test_the_strip_of_discs():
    """One metre deep and 2 R high: A = 2 R, I = (2 R)^3/12 = 2/3 R^3; no twist in the plane."""
    pair = Pair(parallel_bond, BEAM, 2, radii=(RADIUS, RADIUS))
    assert pair.stiffness() == pytest.approx(
        [
            YOUNG * 2.0 * RADIUS / LENGTH,
            SHEAR * 2.0 * RADIUS / LENGTH,
            0.0,
            YOUNG * (2.0 * RADIUS) ** 3 / 12.0 / LENGTH,
        ],
        rel=1e-14,
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_stress_at_the_rim_is_that_of_the_strain_there(dimension):
    """Drawn by u and bent by theta the rim is drawn by u + R theta: sigma = kn (u + R theta), whatever the section."""
    pair = Pair(parallel_bond, BEAM, dimension, radii=(RADIUS, 3.0 * RADIUS))
    drawn, turn = 1e-7, 2e-5
    answer = pair.step(Motion(-drawn, np.zeros(3), 0.0, np.array([turn, 0.0, 0.0])))
    stress = BEAM.normal_stiffness * (drawn + RADIUS * turn)
    assert answer.utilisation[0] == pytest.approx(stress / BEAM.tensile_strength, rel=1e-12)


def test_twist_shears_the_rim():
    """Slip s and twist theta: tau = ks (s + R theta)."""
    pair = Pair(parallel_bond, BEAM, 3, radii=(3.0 * RADIUS, RADIUS))
    answer = pair.step(Motion(0.0, np.array([0.0, 3e-8, 4e-8]), -1e-5, np.zeros(3)))
    stress = BEAM.shear_stiffness * (5e-8 + RADIUS * 1e-5)
    assert answer.utilisation[1] == pytest.approx(stress / BEAM.shear_strength, rel=1e-12)


def test_beta_takes_the_moments_out_of_the_stress_and_not_out_of_the_forces():
    motion = Motion(-1e-7, np.array([1e-7, 0, 0]), 1e-5, np.array([1e-5, 0, 0]))
    full, none = (
        Pair(parallel_bond, BEAM._replace(moment_contribution=beta), 3, radii=(RADIUS, RADIUS)).step(motion)
        for beta in (1.0, 0.0)
    )
    assert np.array_equal(full.vector(), none.vector())
    expected = [
        BEAM.normal_stiffness * 1e-7 / BEAM.tensile_strength,
        BEAM.shear_stiffness * 1e-7 / BEAM.shear_strength,
    ]
    assert none.utilisation == pytest.approx(expected, rel=1e-12)
    assert full.utilisation[0] > none.utilisation[0]
