"""Tests along the axis: what a record tells, how much the rate counts, what never fails."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.axial import compress, pull
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.record import UNITS, TestRecord
from geodem.laboratory.specimen import make_specimen

MATERIAL = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=20e6, shear_strength=60e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip
SEEDS = (1, 2, 3)
# strains at the peaks of these specimens, roughly
FAR, NEAR = 3.5e-3, 3.5e-4


@cache
def compressed(seed: int, pace: float = 340.0) -> TestRecord:
    return compress(make_specimen(2, across=12, seed=seed), MATERIAL, expected_strain=FAR, pace=pace)


@cache
def pulled(seed: int) -> TestRecord:
    return pull(make_specimen(2, across=12, seed=seed), MATERIAL, expected_strain=NEAR, pace=340.0)


def test_record_is_whole():
    found = compressed(1)
    assert found.failed
    assert found.warnings == ()
    assert "of its peak" in found.reason
    assert found.kind == "uniaxial-compression"
    assert set(found.curves) <= set(UNITS)
    assert len({len(curve) for curve in found.curves.values()}) == 1
    stress = found.curves["axial_stress"]
    assert found.strength == stress.max() == stress[found.peak]
    assert stress[-1] < 0.7 * found.strength
    # every crack that the curves count is listed, with a place in the specimen and a stress on the curve
    counted = found.curves["tension_cracks"][-1] + found.curves["shear_cracks"][-1]
    assert len(found.cracks.mode) == counted == found.cracks.tension + found.cracks.shear
    assert (found.cracks.stress <= found.strength).all()
    assert np.linalg.norm(found.cracks.direction, axis=1) == pytest.approx(np.ones(len(found.cracks.mode)))
    assert 0.0 < found.numbers["crack_initiation_stress"] <= found.strength
    assert found.numbers["crack_damage_stress"] <= found.strength


def test_curve_begins_with_the_modulus_that_was_solved_for():
    found = compressed(1)
    stress, strain = found.curves["axial_stress"], found.curves["gauge_axial"]
    assert stress[0] / strain[0] == pytest.approx(found.numbers["young_modulus"], rel=0.02)
    assert found.curves["gauge_lateral"][0] / strain[0] == pytest.approx(
        -found.numbers["poisson_ratio"], rel=0.05
    )


def test_rock_is_much_weaker_in_tension_and_breaks_there_by_tension():
    press, tear = compressed(1), pulled(1)
    assert tear.failed
    assert tear.strength < press.strength / 4.0
    # a straight crack is about as many bonds as particles lie across, not a tenth of all
    assert tear.cracks.tension > 10.0 * tear.cracks.shear
    assert tear.cracks.tension < 0.1 * tear.numbers["bonds"]


def test_half_the_rate_hardly_changes_the_peak():
    usual = [compressed(seed).strength for seed in SEEDS]
    slow = [compressed(seed, 680.0).strength for seed in SEEDS]
    # 12 across: single specimens go other ways, their mean does not
    assert np.mean(usual) == pytest.approx(np.mean(slow), rel=0.05)


def test_pressure_on_the_sides_makes_it_stronger():
    specimen = make_specimen(2, across=12, seed=1)
    sides = 0.2 * compressed(1).strength
    found = compress(specimen, MATERIAL, confinement=sides, expected_strain=3.0 * FAR, pace=340.0)
    assert found.kind == "triaxial-compression"
    slope = (found.strength - compressed(1).strength) / sides
    # Coulomb with 20 to 60 degrees
    assert 2.0 < slope < 14.0
    assert found.numbers["confinement"] == sides


def test_what_never_fails_says_so():
    specimen = make_specimen(2, across=8, packing="triangular")
    found = compress(specimen, MATERIAL.unbreakable(), expected_strain=1e-4)
    assert not found.failed
    assert "no failure up to" in found.reason
    assert any("not a peak" in warning for warning in found.warnings)
    assert "NOT failed" in found.summary()
    assert found.cracks.tension == found.cracks.shear == 0
    assert math.isnan(found.numbers["crack_initiation_stress"])


def test_same_specimen_gives_the_same_bits():
    first, second = compressed(1), compress(
        make_specimen(2, across=12, seed=1), MATERIAL, expected_strain=FAR, pace=340.0
    )  # fmt: skip
    assert np.array_equal(first.curves["axial_stress"], second.curves["axial_stress"])
    assert np.array_equal(first.positions, second.positions)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"confinement": -1.0}, "confinement"),
        ({"confinement": math.nan}, "confinement"),
        ({"pace": 0.0}, "pace"),
    ],
)
def test_what_cannot_be_is_refused(arguments, word):
    with pytest.raises(InputError, match=word):
        compress(make_specimen(2, across=12, seed=1), MATERIAL, **arguments)


def test_disc_is_not_compressed_along_an_axis():
    with pytest.raises(InputError, match="splitting"):
        pull(make_specimen(2, across=12, shape="disc"), MATERIAL)
