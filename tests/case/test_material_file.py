"""The material file: to the last bit there and back, and bad ones are told."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geodem.calibration.estimate import Estimate
from geodem.calibration.targets import RockTargets
from geodem.case import Calibrated, load_material, write_material
from geodem.case.bonded import bond_laws, contact_laws
from geodem.case.material_file import material_text, parse_material
from geodem.errors import InputError, InputErrors
from geodem.laboratory.material import BondedMaterial
from geodem.laws import BOND_LAWS

MATERIAL = BondedMaterial.rock(
    density=2637.9, effective_modulus=61.3e9, stiffness_ratio=2.437, tensile_strength=14.71e6, shear_strength=90.13e6,
    friction_angle=0.611, moment_contribution=0.1, residual_friction=0.43, bonding_range=1.3, name='A "rock", indeed',
)  # fmt: skip
CALIBRATED = Calibrated(
    targets=RockTargets(2638.0, 69e9, 0.26, 200e6, 9.3e6, math.radians(57.0)),
    achieved={
        "young_modulus": Estimate(68.91e9, 68.2e9, 69.6e9),
        "poisson_ratio": Estimate(0.2613, 0.2551, 0.2675),
        "uniaxial_compressive_strength": Estimate(198.43e6, 190.02e6, 207.19e6),
        "tensile_strength": Estimate(9.3e6 / 3.0, 3e6, 3.3e6),
        "friction_angle": Estimate(0.951, 0.92, 0.98),
    },
    dimension=2, packing="random", width=0.05, across=30.0, size_ratio=1.66, seed=1, tests=12, version="1.2.3",
    remarks=('a friction angle of 59 deg cannot be had: at most "57 deg"',),
)  # fmt: skip


def errors_of(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        parse_material(text)
    error = caught.value
    return [str(each) for each in error.errors] if isinstance(error, InputErrors) else [str(error)]


def change(old: str, new: str) -> str:
    text = material_text(MATERIAL, CALIBRATED)
    assert old in text
    return text.replace(old, new, 1)


def test_a_material_goes_round(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "rock.toml"
    write_material(path, MATERIAL, CALIBRATED)
    material, calibrated = load_material(path)
    assert material == MATERIAL
    assert calibrated == CALIBRATED
    write_material(path, MATERIAL)
    assert load_material(path) == (MATERIAL, None)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    modulus=st.floats(1e6, 1e13),
    ratio=st.floats(0.1, 50.0),
    strength=st.one_of(st.floats(1e-3, 1e5), st.just(math.inf)),
    friction=st.floats(0.0, 1.3),
    spread=st.floats(0.0, 2.0),
)
def test_every_number_goes_round(
    modulus: float, ratio: float, strength: float, friction: float, spread: float
) -> None:
    bond = {
        "effective_modulus": modulus, "stiffness_ratio": ratio, "tensile_strength": strength,
        "shear_strength": 3.0 * strength, "friction_coefficient": friction, "moment_contribution": spread,
    }  # fmt: skip
    contact = {"effective_modulus": modulus / 3.0, "stiffness_ratio": ratio, "friction_coefficient": friction}
    material = BondedMaterial(2600.0, bond, contact, variation=spread, distribution="normal")
    assert parse_material(material_text(material))[0] == material


def test_laws_of_a_modulus_can_be_given() -> None:
    """Those whose parameters do not depend on the size of the grains."""
    assert set(bond_laws()) == {"rock", "cement", "flat_joint"}
    assert contact_laws() == ("effective_modulus",)
    for name in bond_laws():
        law = BOND_LAWS[name]
        bond = dict.fromkeys(law.PARAMETERS._fields, 0.5)
        bond |= {"effective_modulus": 1e9, "tensile_strength": 1e6, "shear_strength": 1e7}
        material = BondedMaterial(2600.0, bond, dict(MATERIAL.contact), bond_law=name)
        assert parse_material(material_text(material))[0] == material


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("format = 1\n", "", "format", "missing. Write format = 1"),
        ("format = 1", "format = 2", "format", "another geodem wrote this file"),
        ('"61.3 GPa"', "61.3", "effective_modulus", 'Write "61.3 kPa" if kPa is meant'),
        ('"61.3 GPa"', '"61.3 kN"', "effective_modulus", "is the unit of a force"),
        ("bonding_range", "bonding_rnage", "bonding_rnage", 'Did you mean "bonding_range"'),
        ("tests = 12", "tests = 0", "calibration.tests", "below 1"),
        ("tests = 12\n", "", "calibration.tests", "take [calibration] out"),
        ("friction_angle = {", "phi = {", "calibration.achieved.phi", "Known in [calibration.achieved]"),
        ("low = 0.2551, ", "", "calibration.achieved.poisson_ratio.low", "both ends of its interval"),
        ('young_modulus = "69 GPa"', "young_modulus = 69", "calibration.targets.young_modulus", "a bare number"),
        ('[contact]\nlaw = "effective_modulus"', '[contact]\nlaw = "hertz"', "contact.law", '"effective_modulus"'),
        ("coefficient = 0.43", "coefficient = -0.43", "contact.friction_coefficient", "must not be negative"),
    ],
)  # fmt: skip
def test_bad_material_files(old: str, new: str, place: str, words: str) -> None:
    errors = errors_of(change(old, new))
    assert any(error.startswith((f"{place} ", f"{place}:")) and words in error for error in errors), errors


def test_unreadable_files_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such material file"):
        load_material(tmp_path / "none.toml")
    assert "this is not TOML" in errors_of("law =")[0]
    missing = errors_of("format = 1\n")
    assert [error.split(":")[0] for error in missing] == ["law", "density"]
