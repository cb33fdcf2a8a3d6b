"""Splitting of discs: the elastic stress in the middle, where it splits, and when it is crushed instead."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.brazilian import jaws, split, split_at, splitting_stress
from geodem.laboratory.driven import Driven
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.specimen import make_specimen

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=10e6, shear_strength=40e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip


def test_the_middle_of_an_elastic_disc_has_the_closed_forms_stresses():
    # Timoshenko & Goodier 1970, art. 41: 2P/(pi D t) across and three times that along the loaded diameter; their means
    # over a circle of s times the diameter are less by s^2 and s^2/3 of them (integrated from the same solution)
    disc = make_specimen(2, width=0.05, across=40, shape="disc", packing="triangular")
    driven = Driven(disc, ROCK.unbreakable(), jaws(disc))
    driven.begin(0.0)
    unit = splitting_stress(disc, driven.force())
    share = 0.25
    stress = driven.stress_in(0.5 * disc.size, 0.5 * share * disc.width)
    assert -stress[0, 0] == pytest.approx((1.0 - share**2) * unit, rel=0.04)
    assert stress[1, 1] == pytest.approx((3.0 - share**2) * unit, rel=0.04)
    assert abs(stress[0, 1]) < 0.01 * unit


def test_the_stress_of_twenty_kilonewtons():
    # D 50 mm, t 25 mm, P 20 kN: 2P/(pi D t) = 10.186 MPa
    disc = make_specimen(3, width=0.05, across=8, shape="disc", packing="fcc")
    assert disc.height == 0.05
    assert splitting_stress(disc, 20e3) == pytest.approx(10.186e6, rel=1e-4)


def test_a_disc_splits_along_the_loaded_diameter():
    disc = make_specimen(2, width=0.05, across=24, shape="disc", seed=1)
    record = split(disc, ROCK)
    assert record.failed
    assert not record.warnings
    assert record.numbers["crushing"] <= 0.5
    # by tension, and the halves move apart
    assert record.cracks.tension > 5 * record.cracks.shear
    right = disc.positions[:, 0] > 0.5 * disc.width
    apart = record.displacements[right, 0].mean() - record.displacements[~right, 0].mean()
    assert apart > 2.0 * np.abs(record.displacements[:, 1]).min()
    # bonds across the loaded diameter break, not those along it
    assert (record.cracks.direction[:, 0] ** 2).mean() > 0.6
    # direct tensile strength is 0.5 to 0.6 of that of a bond; Brazilian over direct tension of rock is 1 to 1.4
    assert 4e6 < record.strength < 9e6
    assert record.strength == pytest.approx(splitting_stress(disc, record.curves["force"].max()), rel=1e-12)


def test_what_is_strong_in_tension_is_crushed_at_the_loads():
    weak = ROCK.with_bond(tensile_strength=1e9, shear_strength=20e6, friction_coefficient=0.0)
    record = split(make_specimen(2, width=0.05, across=24, shape="disc", seed=1), weak)
    assert record.numbers["crushing"] > 0.5
    assert any("crushed" in warning for warning in record.warnings)


def test_a_second_peak_is_that_of_the_halves():
    assert split_at(np.array([0.0, 1.0, 2.0, 1.9, 2.1, 1.8, 3.0])) == 4
    assert split_at(np.array([0.0, 1.0, 2.0, 1.9, 2.1])) == 4


def test_only_discs_between_short_jaws_are_split():
    with pytest.raises(InputError, match="is a disc"):
        split(make_specimen(2, width=0.05, across=10, packing="square"), ROCK)
    with pytest.raises(InputError, match="short arc"):
        split(make_specimen(2, width=0.05, across=10, shape="disc", packing="square"), ROCK, arc=2.0)
