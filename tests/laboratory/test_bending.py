"""Bending of beams at three points: the modulus from the deflection, the strength, and where it breaks."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.bending import bearings, bend, fibre_stress, modulus
from geodem.laboratory.driven import Driven
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.record import TestRecord
from geodem.laboratory.specimen import make_specimen

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=10e6, shear_strength=40e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip
BOND = 10e6


@cache
def broken() -> TestRecord:
    return bend(make_specimen(2, width=0.02, height=0.08, across=12, seed=1), ROCK)


@pytest.mark.parametrize("slender", [4.0, 6.0])
def test_the_deflection_gives_the_modulus_of_the_lattice(slender):
    # triangular lattice: E = 2 sqrt3 kn (kn + ks)/(3 kn + ks), nu = (kn - ks)/(3 kn + ks), kn = Ec for equal discs
    beam = make_specimen(2, width=0.05, height=0.05 * slender, across=20, packing="triangular")
    driven = Driven(beam, ROCK, bearings(beam))
    driven.solve()
    kn, ks = 60e9, 24e9
    young = 2.0 * math.sqrt(3.0) * kn * (kn + ks) / (3.0 * kn + ks)
    # rows of discs alternate by half a disc, so that the section is half a disc narrower than the box in the mean
    section = (20.0 - 0.5) / 20.0
    found = modulus(beam, driven, (kn - ks) / (3.0 * kn + ks))
    assert found == pytest.approx(young * section**3, rel=0.03)


def test_the_supports_bear_half_of_the_load_each():
    beam = make_specimen(2, width=0.05, height=0.2, across=20, packing="triangular")
    driven = Driven(beam, ROCK, bearings(beam))
    driven.begin(0.0)
    force = driven.simulation.forces[:, 0]
    pushed = driven.motion[:, 0]
    right = beam.positions[:, 1] > 0.5 * beam.height
    load = driven.force()
    assert force[pushed < 0.0].sum() == pytest.approx(load, rel=1e-3)
    for side in (right, ~right):
        assert -force[(pushed > 0.0) & side].sum() == pytest.approx(0.5 * load, rel=0.01)
    # 3 P L/(2 b h^2) with L = 0.9 of the length
    assert fibre_stress(beam, load) == pytest.approx(1.5 * load * 0.18 / 0.05**2, rel=1e-12)


def test_a_beam_breaks_in_the_middle_by_tension():
    record = broken()
    assert record.failed
    assert not record.warnings
    assert record.numbers["crack_offset"] < 0.15
    assert record.cracks.shear == 0
    # the fibre in tension is below, so the crack begins there
    assert record.cracks.place[0, 0] < 0.01
    assert np.abs(record.cracks.direction[:, 1]).mean() > 0.6
    # rock's flexural strength is 1.5 to 3 times the direct tensile one, that of a bond here 0.5 to 0.6
    assert 0.6 * BOND < record.strength < 2.0 * BOND


def test_the_start_is_no_shock():
    record = broken()
    stress = record.curves["axial_stress"]
    assert stress[0] == pytest.approx(0.8 * record.numbers["first_break_stress"], rel=0.01)
    assert np.all(np.diff(stress[:5]) > 0.0)


def test_what_is_no_beam_is_refused():
    with pytest.raises(InputError, match="no beam"):
        bend(make_specimen(2, width=0.05, height=0.1, across=10, packing="square"), ROCK)
    with pytest.raises(InputError, match="is a prism"):
        bend(make_specimen(2, width=0.05, across=10, packing="square", shape="disc"), ROCK)
