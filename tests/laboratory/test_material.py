"""What a specimen is made of."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.material import BondedMaterial

GRANITE = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=20e6, shear_strength=80e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip


def test_contacts_of_rock_are_as_stiff_as_its_bonds():
    GRANITE.check()
    assert GRANITE.bond["friction_coefficient"] == pytest.approx(1.0 / math.sqrt(3.0))
    for key in ("effective_modulus", "stiffness_ratio"):
        assert GRANITE.contact[key] == GRANITE.bond[key]


def test_another_value_leaves_the_first_material_as_it_was():
    other = GRANITE.with_bond(tensile_strength=1e6)
    assert other.bond["tensile_strength"] == 1e6
    assert GRANITE.bond["tensile_strength"] == 20e6
    assert other.contact == GRANITE.contact


def test_unbreakable_has_no_strength_that_could_be_reached():
    held = replace(GRANITE, variation=0.2).unbreakable()
    held.check()
    assert held.bond["tensile_strength"] == held.bond["shear_strength"] == math.inf
    assert held.bond["effective_modulus"] == 60e9
    assert held.scatter(1) == 1.0


@pytest.mark.parametrize("distribution", ["normal", "lognormal"])
def test_strength_scatters_as_it_should(distribution):
    factors = replace(GRANITE, variation=0.2, distribution=distribution).scatter(7)
    found = factors.factors(40_000)
    # four standard errors of the mean, and of the standard deviation of a normal scatter
    assert found.mean() == pytest.approx(1.0, abs=4.0 * 0.2 / math.sqrt(40_000))
    assert found.std() == pytest.approx(0.2, rel=0.03)
    assert np.array_equal(found, factors.factors(40_000))


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (replace(GRANITE, bond_law="rok"), ("bond law", "rok")),
        (replace(GRANITE, contact_law="glue"), ("contact law", "glue")),
        (replace(GRANITE, distribution="uniform"), ("distribution", "lognormal")),
        (GRANITE.with_bond(tensile_strength=-1.0), ("tensile_strength",)),
        (GRANITE.with_bond(effective_modulus=math.nan), ("effective_modulus",)),
        (GRANITE.with_bond(cohesion=1.0), ("cohesion",)),
        (replace(GRANITE, contact={"effective_modulus": 1e9}), ("stiffness_ratio",)),
    ],
)
def test_what_is_wrong_is_named(wrong, words):
    with pytest.raises(InputError) as told:
        wrong.check()
    for word in words:
        assert word in str(told.value)
