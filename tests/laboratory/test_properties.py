"""All properties of a specimen in one call."""

from __future__ import annotations

import math

import pytest

from geodem.laboratory.axial import compress, pull
from geodem.laboratory.envelope import fit_envelope
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.properties import CONFINED, FALL, measure_properties
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import make_specimen

MATERIAL = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=20e6, shear_strength=60e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip
EXPECTED = {"compression": 3.5e-3, "tension": 3.5e-4, "confined": 8e-3}


def test_properties_are_those_of_the_single_tests():
    specimen = make_specimen(2, across=10, seed=3)
    found = measure_properties(specimen, MATERIAL, expected=EXPECTED)
    assert [record.kind for record in found.records] == [
        "direct-tension", "uniaxial-compression", "triaxial-compression",
    ]  # fmt: skip
    press = compress(specimen, MATERIAL, expected_strain=EXPECTED["compression"], fall=FALL)
    tear = pull(specimen, MATERIAL, expected_strain=EXPECTED["tension"], fall=FALL)
    assert found.compressive_strength == press.strength
    assert found.tensile_strength == tear.strength
    assert (found.young_modulus, found.poisson_ratio) == Rig(specimen, MATERIAL).elastic_constants()
    sides = CONFINED * press.strength
    assert found.records[2].numbers["confinement"] == sides
    line = fit_envelope([0.0, sides], [press.strength, found.records[2].strength])
    assert found.friction_angle == line.friction_angle
    assert found.seconds == pytest.approx(sum(record.seconds for record in found.records))


def test_pilots_find_what_is_not_known():
    specimen = make_specimen(2, across=10, seed=3)
    known = measure_properties(specimen, MATERIAL, expected=EXPECTED)
    found = measure_properties(specimen, MATERIAL)
    # another rate, the same peaks within what the rate does
    assert found.compressive_strength == pytest.approx(known.compressive_strength, rel=0.08)
    assert found.tensile_strength == pytest.approx(known.tensile_strength, rel=0.08)


def test_stress_scales_with_stress():
    # the same grains a thousand times softer and weaker: the same numbers in other units
    specimen = make_specimen(2, across=10, seed=3)
    weak = BondedMaterial.rock(
        density=2600.0, effective_modulus=60e6, stiffness_ratio=2.5, tensile_strength=20e3,
        shear_strength=60e3, friction_angle=math.radians(30.0),
    )  # fmt: skip
    strong = compress(specimen, MATERIAL, expected_strain=EXPECTED["compression"])
    found = compress(specimen, weak, expected_strain=EXPECTED["compression"])
    assert found.strength == pytest.approx(1e-3 * strong.strength, rel=0.02)
    assert Rig(specimen, weak).elastic_constants()[0] == pytest.approx(
        1e-3 * Rig(specimen, MATERIAL).elastic_constants()[0], rel=1e-6
    )
