"""Hertz's contact against numbers worked out by hand, and its mixtures."""

import math

import pytest

from geodem.laws.contact.hertz import HertzParameters, against_rigid, check, combine, energy, force, stiffness

STEEL = HertzParameters(210e9, 0.3)
RUBBER = HertzParameters(1e8, 0.5)


def test_force_energy_and_stiffness_by_hand():
    """E = 75 GPa, nu = 0.5: E* = 50 GPa. Radii 20 mm: R* = 10 mm. u = 0.1 mm: sqrt(R* u) = 1 mm, F = 20/3 kN."""
    normal, *shear = force(75e9, 0.5, 1e-4, 0.02, 0.02)
    assert normal == pytest.approx(20e3 / 3.0, rel=1e-14)
    assert shear == [0.0, 0.0, 0.0]
    assert energy(75e9, 0.5, 1e-4, 0.02, 0.02) == pytest.approx(0.4 * 20e3 / 3.0 * 1e-4, rel=1e-14)
    assert stiffness(75e9, 0.5, 1e-4, 0.02, 0.02) == pytest.approx((1e8, 0.0, 0.0, 0.0), rel=1e-14)


def test_nothing_before_they_touch():
    assert force(75e9, 0.5, -1e-4, 0.02, 0.02)[0] == 0.0
    assert energy(75e9, 0.5, -1e-4, 0.02, 0.02) == 0.0
    assert stiffness(75e9, 0.5, -1e-4, 0.02, 0.02)[0] == 0.0


def test_a_huge_second_radius_is_a_plane():
    assert force(75e9, 0.5, 1e-4, 0.01, 1e13)[0] == pytest.approx(20e3 / 3.0, rel=1e-12)


def modulus(parameters):
    """E* of the pair, from the force."""
    return force(*parameters, 1e-4, 0.02, 0.02)[0] / (4.0 / 3.0 * 1e-3 * 1e-4)


def test_two_materials_deform_one_after_the_other():
    """1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, and the stiff one hardly counts."""
    expected = 1.0 / (0.91 / 210e9 + 0.75 / 1e8)
    assert modulus(combine(STEEL, RUBBER)) == pytest.approx(expected, rel=1e-14)
    assert modulus(combine(RUBBER, STEEL)) == pytest.approx(expected, rel=1e-14)
    assert modulus(against_rigid(RUBBER)) == pytest.approx(1e8 / 0.75, rel=1e-14)
    assert combine(STEEL, STEEL) == STEEL


@pytest.mark.parametrize("ratio", [-1.0, 0.51, math.nan, math.inf])
def test_a_poisson_ratio_that_no_material_has_is_named(ratio):
    assert [fault.field for fault in check(STEEL._replace(poisson_ratio=ratio))] == ["poisson_ratio"]


def test_a_modulus_must_be_positive():
    assert [fault.field for fault in check(STEEL._replace(young_modulus=0.0))] == ["young_modulus"]
    assert check(STEEL) == []
