"""Cases of the laboratory and of a calibration: what good ones mean, and that bad ones are told what to do."""

from __future__ import annotations

import math
import re
from dataclasses import asdict, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from geodem.calibration.estimate import Estimate
from geodem.calibration.targets import RockTargets
from geodem.case import (
    Calibrated,
    CalibrationCase,
    Case,
    LaboratoryCase,
    load_any,
    load_calibration,
    load_case,
    load_laboratory,
    parse_calibration,
    parse_laboratory,
    write_material,
)
from geodem.case.laboratory_reading import KINDS
from geodem.errors import InputError, InputErrors
from geodem.laboratory.material import BondedMaterial

TEMPLATES = Path(str(files("geodem") / "templates"))

LABORATORY = """\
workflow = "laboratory"
title = "Granite"
seed = 3
seeds = 2

[specimen]
dimension = 2
packing = "random"
width = "5 cm"
height = "110 mm"
across = 40
size_ratio = 1.5

[material]
law = "rock"
density = "2.64 t/m3"
effective_modulus = "60 GPa"
stiffness_ratio = 2.5
tensile_strength = "15000 kPa"
shear_strength = "90 MPa"
friction_coefficient = 0.8
bonding_range = 1.3
strength_variation = 0.2
strength_distribution = "normal"

[[test]]
kind = "uniaxial-compression"

[[test]]
kind = "triaxial-compression"
confinement = ["5 MPa", "10 MPa"]

[[test]]
kind = "direct-shear"
normal_stress = "2 MPa"
"""

CALIBRATION = """\
workflow = "calibration"
title = "Sandstone"
seed = 7

[specimen]
across = 30
width = "50 mm"

[rock]
density = "2300 kg/m3"
young_modulus = "15 GPa"
poisson_ratio = 0.22
uniaxial_compressive_strength = "70 MPa"
tensile_strength = "5 MPa"
friction_angle = "43 deg"
"""


def change(text: str, old: str, new: str) -> str:
    """`text` with the first `old` replaced; it must be there, so that no test passes on an unchanged case."""
    assert old in text
    return text.replace(old, new, 1)


def errors_of(text: str, folder: Path) -> list[str]:
    """Every error of a case of either kind."""
    parse = parse_calibration if "calibration" in text.splitlines()[0] else parse_laboratory
    with pytest.raises(InputError) as caught:
        parse(text, folder)
    error = caught.value
    return [str(each) for each in error.errors] if isinstance(error, InputErrors) else [str(error)]


def test_every_number_of_a_laboratory_arrives_in_si(tmp_path: Path) -> None:
    case = parse_laboratory(LABORATORY, tmp_path)
    assert (case.workflow, case.title, case.seed, case.seeds) == ("laboratory", "Granite", 3, 2)
    assert case.specimen.arguments() == {
        "dimension": 2, "packing": "random", "shape": "prism", "width": 0.05, "height": 0.11, "across": 40.0,
        "size_ratio": 1.5,
    }  # fmt: skip
    material = case.material
    material.check()
    assert (material.name, material.density, material.bond_law) == ("Granite", 2640.0, "rock")
    assert material.bond == {
        "effective_modulus": 60e9, "stiffness_ratio": 2.5, "tensile_strength": 15e6, "shear_strength": 90e6,
        "friction_coefficient": 0.8, "moment_contribution": 0.0,
    }  # fmt: skip
    assert material.contact == {
        "effective_modulus": 60e9,
        "stiffness_ratio": 2.5,
        "friction_coefficient": 0.5,
    }
    assert (material.bonding_range, material.variation, material.distribution) == (1.3, 0.2, "normal")
    assert [(test.kind, test.stresses) for test in case.tests] == [
        ("uniaxial-compression", ()),
        ("triaxial-compression", (5e6, 10e6)),
        ("direct-shear", (2e6,)),
    ]
    assert case.material_file is None
    assert case.text == LABORATORY


def test_every_number_of_a_calibration_arrives_in_si(tmp_path: Path) -> None:
    case = parse_calibration(CALIBRATION, tmp_path)
    assert (case.workflow, case.title, case.seed) == ("calibration", "Sandstone", 7)
    assert case.targets == RockTargets(2300.0, 15e9, 0.22, 70e6, 5e6, 43.0 * math.pi / 180.0)
    assert (case.specimen.dimension, case.specimen.across, case.specimen.packing) == (2, 30.0, "random")


def test_every_default_is_said(tmp_path: Path) -> None:
    text = re.sub(r"\[specimen\].*?\n\n", "", LABORATORY, flags=re.DOTALL)
    for key in ("title", "seed", "seeds", "bonding_range", "strength_variation", "strength_distribution"):
        text = re.sub(rf"^{key} = .*\n", "", text, flags=re.MULTILINE)
    case = parse_laboratory(text, tmp_path)
    told = [notice.split(" is not given: ")[0] for notice in case.notices]
    assert told == [
        "title", "seed", "seeds", "specimen.dimension", "specimen.packing", "specimen.shape", "specimen.width",
        "specimen.height", "specimen.across", "specimen.size_ratio", "material.bonding_range",
        "material.strength_variation", "material.moment_contribution", "material.contact.law",
        "material.contact.effective_modulus", "material.contact.stiffness_ratio",
        "material.contact.friction_coefficient",
    ]  # fmt: skip
    assert (case.seed, case.seeds, case.title) == (1, 4, tmp_path.name)
    assert asdict(case.specimen) == {
        "dimension": 2, "packing": "random", "shape": "prism", "width": 0.05, "height": None, "across": 40.0,
        "size_ratio": 1.66,
    }  # fmt: skip
    coarse = parse_laboratory(change(LABORATORY, "across = 40", "across = 24"), tmp_path)
    assert any("strength and friction still depend on how many there are" in note for note in coarse.notices)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ('"laboratory"', '"labaratory"', "workflow", 'Did you mean "laboratory"'),
        ("seeds = 2", "seeds = 0", "seeds", "below 1"),
        ("seeds = 2", "seeds = 1000000000", "seeds", "years"),
        ("seeds = 2", "sedes = 2", "sedes", 'Did you mean "seeds"'),
        ("dimension = 2", "dimension = 4", "specimen.dimension", "Write 2 or 3"),
        ("dimension = 2", "dimension = 3", "specimen.across", ""),
        ('"random"', '"triangle"', "specimen.packing", 'Did you mean "triangular"'),
        ('"random"', '"fcc"', "specimen.packing", 'Write one of "random", "triangular", "square"'),
        ('"5 cm"', "50", "specimen.width", 'Write "50 m" if m is meant'),
        ('"5 cm"', '"-5 cm"', "specimen.width", ""),
        ('"110 mm"', '"11 mm"', "specimen.height", "0.22 times the width"),
        ("across = 40", "across = 8", "specimen.across", "Write 10 at least, better 30"),
        ("across = 40", "across = 3000", "specimen.across", "a test takes days"),
        ("size_ratio = 1.5", "size_ratio = 0.6", "specimen.size_ratio", "between 1 and 10"),
        ("across", "accros", "specimen.accros", 'Did you mean "across"'),
        ('law = "rock"', 'law = "rok"', "material.law", 'Did you mean "rock"'),
        ('law = "rock"', 'law = "two_springs"', "material.law", 'Write one of'),
        ('law = "rock"\n', "", "material.law", 'Write law = "rock"'),
        ('"2.64 t/m3"', '"26.4 kN/m3"', "material.density", "is a unit weight, not a density"),
        ('"2.64 t/m3"', '"264 kg/m3"', "material.density", "1000 to 5100"),
        ('"60 GPa"', "60e9", "material.effective_modulus", "a bare number; a stress needs its unit"),
        ('"60 GPa"', '"60 kPa"', "material.effective_modulus", "so soft a bond"),
        ('"60 GPa"', '"60 deg"', "material.effective_modulus", "unit of an angle"),
        ("stiffness_ratio = 2.5", "stiffness_ratio = -1", "material.stiffness_ratio", "must be greater than 0"),
        ("stiffness_ratio = 2.5", 'stiffness_ratio = "2.5 Pa"', "material.stiffness_ratio", "without a unit"),
        ('"15000 kPa"', '"15 GPa"', "material.tensile_strength", 'Did you mean "15 MPa"'),
        ('shear_strength = "90 MPa"\n', "", "material.shear_strength", 'Write shear_strength = "60 MPa"'),
        ("coefficient = 0.8", "coefficient = 40", "material.friction_coefficient", "Did you mean 0.839"),
        ("bonding_range = 1.3", "bonding_range = 0.9", "material.bonding_range", "nothing is bonded"),
        ("strength_variation = 0.2", "strength_variation = 20", "material.strength_variation", "between 0 and 2"),
        ('"normal"', '"gauss"', "material.strength_distribution", '"normal", "lognormal"'),
        ("[[test]]", "[[tset]]", "tset", 'Did you mean "test"'),
        ('kind = "uniaxial-compression"', 'kind = "uniaxial"', "test[0].kind", 'Did you mean "uniaxial-compression"'),
        ('kind = "uniaxial-compression"', 'kind = "direct-shear"', "test[0].normal_stress", 'Write normal_stress'),
        ('confinement = ["5 MPa", "10 MPa"]\n', "", "test[1].confinement", 'Write confinement = ["5 MPa"'),
        ('["5 MPa", "10 MPa"]', "[]", "test[1].confinement", "the list is empty"),
        ('["5 MPa", "10 MPa"]', '["5 MPa", 10]', "test[1].confinement[1]", 'Write "10 kPa" if kPa is meant'),
        ('["5 MPa", "10 MPa"]', '["-5 MPa"]', "test[1].confinement[0]", "without the sign"),
        ('["5 MPa", "10 MPa"]', '["5000 MPa"]', "test[1].confinement[0]", 'Did you mean "5 MPa"'),
        ('["5 MPa", "10 MPa"]', '["5 MPa", "5000 kPa"]', "test[1]", "at 5 MPa is asked for twice"),
        ("normal_stress", "confinement", "test[2].confinement", "a test of direct-shear has none"),
        ('"direct-shear"\nnormal_stress = "2 MPa"', '"uniaxial-compression"', "test[2]", "asked for twice"),
    ],
)  # fmt: skip
def test_bad_laboratories(old: str, new: str, place: str, words: str, tmp_path: Path) -> None:
    text = LABORATORY
    if new == "dimension = 3":
        text = change(text, "across = 40", "across = 400")
    errors = errors_of(change(text, old, new), tmp_path)
    assert any(error.startswith((f"{place} ", f"{place}:")) for error in errors), errors
    assert any(words in error for error in errors), errors


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ('"5 MPa"', '"20 MPa"', "rock.tensile_strength", "leaves at least 5.29. Give at most 13.2 MPa"),
        ('"70 MPa"', '"70 kPa"', "rock.uniaxial_compressive_strength", 'Did you mean "70 MPa"'),
        ('"43 deg"', '"80 deg"', "rock.friction_angle", "no rock has so much"),
        ('"43 deg"', "43", "rock.friction_angle", "needs its unit"),
        ("poisson_ratio = 0.22", "poisson_ratio = 22", "rock.poisson_ratio", "Did you mean 0.22"),
        ("poisson_ratio = 0.22\n", "", "rock.poisson_ratio", "missing. Write poisson_ratio = 0.25"),
        ("young_modulus", "youngs_modulus", "rock.youngs_modulus", 'Did you mean "young_modulus"'),
        ("[rock]", "[material]", "rock", "missing"),
        ("across = 30", 'packing = "square"', "specimen.packing", "unknown key"),
        ("seed = 7", 'seed = "7"', "seed", "a whole number is needed"),
    ],
)
def test_bad_calibrations(old: str, new: str, place: str, words: str, tmp_path: Path) -> None:
    errors = errors_of(change(CALIBRATION, old, new), tmp_path)
    assert any(error.startswith((f"{place} ", f"{place}:")) for error in errors), errors
    assert any(words in error for error in errors), errors


def test_all_errors_come_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = change(LABORATORY, "across = 40", "across = 5")
    text = change(change(text, '"60 GPa"', "60"), '"direct-shear"', '"shear"')
    text = change(text, "seed = 3", "seed = -1")
    places = [error.split(" = ")[0] for error in errors_of(text, tmp_path)]
    assert places == ["seed", "specimen.across", "material.effective_modulus", "test[2].kind"]
    empty = errors_of('workflow = "laboratory"\n', tmp_path)
    assert [error.split(":")[0] for error in empty] == ["material", "test"]
    assert len(errors_of('workflow = "calibration"\n[rock]\n', tmp_path)) == 6
    # a value that could not be read is not told to be missing as well
    bare = errors_of(change(CALIBRATION, '"15 GPa"', "15"), tmp_path)
    assert len(bare) == 1


def test_an_implausible_value_can_be_meant(tmp_path: Path) -> None:
    text = change(CALIBRATION, '"15 GPa"', '"1 GPa"')
    (error,) = errors_of(text, tmp_path)
    (consent,) = re.findall(r"allow_implausible = \[.*?\]", error)
    case = parse_calibration(change(text, "[specimen]", f"{consent}\n[specimen]"), tmp_path)
    assert case.allow_implausible == ("rock.young_modulus",)
    assert any("allowed by allow_implausible" in notice for notice in case.notices)


def test_a_lattice_with_bonds_all_alike_is_tested_once(tmp_path: Path) -> None:
    text = change(LABORATORY, '"random"', '"triangular"')
    assert parse_laboratory(text, tmp_path).seeds == 2
    alike = parse_laboratory(change(text, "strength_variation = 0.2", "strength_variation = 0.0"), tmp_path)
    assert alike.seeds == 1
    assert any("is the same for every seed" in notice for notice in alike.notices)


MATERIAL = BondedMaterial.rock(
    density=2640.0, effective_modulus=61e9, stiffness_ratio=2.4, tensile_strength=14.7e6, shear_strength=90.1e6,
    friction_angle=0.61, bonding_range=1.3, name="Granite of the quarry",
)  # fmt: skip
CALIBRATED = Calibrated(
    targets=RockTargets(2640.0, 69e9, 0.26, 200e6, 9.3e6, 1.0),
    achieved={"uniaxial_compressive_strength": Estimate(198.4e6, 190e6, 207.1e6)},
    dimension=2, packing="random", width=0.05, across=30.0, size_ratio=1.66, seed=1, tests=12,
)  # fmt: skip


def with_file(text: str, name: str) -> str:
    return re.sub(r"\[material\].*?\n\n", f'[material]\nfile = "{name}"\n\n', text, flags=re.DOTALL)


def test_a_material_from_a_file(tmp_path: Path) -> None:
    write_material(tmp_path / "granite.toml", MATERIAL, CALIBRATED)
    case = parse_laboratory(with_file(LABORATORY, "granite.toml"), tmp_path)
    assert case.material == MATERIAL
    assert case.material_file == tmp_path / "granite.toml"
    assert case.questions == ()
    spheres = change(with_file(LABORATORY, "granite.toml"), "dimension = 2", "dimension = 3")
    (question,) = parse_laboratory(spheres, tmp_path).questions
    assert "the material was calibrated in 2D" in question
    high = change(with_file(LABORATORY, "granite.toml"), '"10 MPa"', '"210 MPa"')
    (error,) = errors_of(high, tmp_path)
    assert "210 MPa is more than the material's compressive strength, 198 MPa" in error
    assert "here 99 MPa" in error


def test_what_is_wrong_in_a_material_file_is_told_with_its_name(tmp_path: Path) -> None:
    (missing,) = errors_of(with_file(LABORATORY, "none.toml"), tmp_path)
    assert missing.startswith("material.file = 'none.toml': there is no such material file")
    write_material(tmp_path / "granite.toml", MATERIAL)
    text = (tmp_path / "granite.toml").read_text()
    text = change(change(text, "61 GPa", "61"), "stiffness_ratio", "stifness_ratio")
    (tmp_path / "granite.toml").write_text(text)
    errors = errors_of(with_file(LABORATORY, "granite.toml"), tmp_path)
    assert any(
        error.startswith("granite.toml, effective_modulus = '61': the unit is missing") for error in errors
    )
    assert any(
        'granite.toml, stifness_ratio: unknown key. Did you mean "stiffness_ratio"' in error
        for error in errors
    )
    both = change(LABORATORY, "[material]\n", '[material]\nfile = "granite.toml"\n')
    assert any("unknown key" in error for error in errors_of(both, tmp_path))


@pytest.mark.parametrize("text", [LABORATORY, CALIBRATION])
def test_the_case_as_it_is_run_goes_round(text: str, tmp_path: Path) -> None:
    parse: Any = parse_calibration if text is CALIBRATION else parse_laboratory
    first = parse(text, tmp_path)
    again = parse(first.as_run_text(), tmp_path / "elsewhere")
    assert again.notices == again.questions == ()
    plain = {"text": "", "notices": ()}
    # the height that was left out is written out
    specimen = replace(first.specimen, height=first.specimen.height if text is LABORATORY else None)
    one, other = replace(first, **plain, specimen=specimen), replace(again, **plain)
    assert one.__dict__ == other.__dict__


@pytest.mark.parametrize("kind", ["laboratory", "calibration"])
def test_templates_say_everything(kind: str) -> None:
    """No default is left to be taken, and every key is there."""
    case = load_any(TEMPLATES / kind)
    assert case.notices == case.questions == ()
    assert isinstance(case, LaboratoryCase if kind == "laboratory" else CalibrationCase)


def test_which_case_is_for_which_command(tmp_path: Path) -> None:
    assert isinstance(load_any(TEMPLATES / "slope"), Case)
    assert (
        load_laboratory(TEMPLATES / "laboratory").title == load_calibration(TEMPLATES / "calibration").title
    )
    with pytest.raises(InputError, match="Run it with: geodem lab CASE"):
        load_case(TEMPLATES / "laboratory")
    with pytest.raises(InputError, match="Run it with: geodem run CASE"):
        load_laboratory(TEMPLATES / "slope")
    with pytest.raises(InputError, match="Run it with: geodem calibrate CASE"):
        load_laboratory(TEMPLATES / "calibration")
    with pytest.raises(InputError, match="there is no such case file"):
        load_any(tmp_path / "none.toml")


def test_every_test_of_the_laboratory_can_be_asked_for() -> None:
    from geodem.laboratory.orders import KINDS as MADE

    assert MADE.keys() <= KINDS.keys()
    for name, kind in MADE.items():
        assert bool(kind.stress) == bool(KINDS[name]), name
