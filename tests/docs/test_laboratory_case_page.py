"""The page of the case file knows the keys and defaults of laboratories, calibrations and material files."""

import re

import pytest

from geodem.calibration.targets import RockTargets
from geodem.case import parse_calibration, parse_laboratory, table
from geodem.case.bonded import bond_laws, contact_laws
from geodem.case.laboratory_reading import KINDS
from geodem.case.material_file import material_text, parse_material
from geodem.case.specimen import PACKINGS, SHAPES
from geodem.laws import BOND_LAWS
from tests.case.test_material_file import CALIBRATED, MATERIAL
from tests.docs.pages import DOCS, tables

PAGE = DOCS / "reference" / "case-file.md"


def rows(heading):
    """Rows of a table by key."""
    return {row[0].strip("`"): row for row in tables(PAGE)[heading]}


def smallest(workflow):
    """The smallest case of the page."""
    text = PAGE.read_text()
    start = text.index(f'    workflow = "{workflow}"')
    block = text[start : re.compile(r"^\S", re.MULTILINE).search(text, start).start()]
    return re.sub(r"^ {4}", "", block, flags=re.M)


@pytest.fixture
def asked(monkeypatch):
    """Keys that the reader knows, by the place of their table."""
    found = {}
    original = table.Table.__init__

    def spy(self, findings, place, content, known):
        found[re.sub(r"\[\d+\]", "", place)] = set(known)
        original(self, findings, place, content, known)

    monkeypatch.setattr(table.Table, "__init__", spy)
    return found


def test_keys_of_a_laboratory(asked, tmp_path):
    # of every law where none is named
    with pytest.raises(ValueError, match="law"):
        parse_laboratory(smallest("laboratory").replace('law = "rock"\n', ""), tmp_path)
    assert set(rows("Top level of a laboratory")) == asked[""]
    assert set(rows("[specimen]")) == asked["specimen"]
    assert set(rows("[material] of a laboratory")) == asked["material"]
    assert set(rows("[material.contact]")) == asked["material.contact"]
    assert set(rows("[[test]]")) == asked["test"]


def test_keys_of_a_calibration(asked, tmp_path):
    parse_calibration(smallest("calibration"), tmp_path)
    assert set(rows("Top level of a calibration")) == asked[""]
    assert set(rows("[specimen] of a calibration")) == asked["specimen"]
    assert set(rows("[rock]")) == asked["rock"] == set(RockTargets.__dataclass_fields__)


def test_keys_of_a_material_file(asked):
    parse_material(material_text(MATERIAL, CALIBRATED))
    of_material = set(rows("[material] of a laboratory")) - {"file"}
    assert asked[""] <= set(rows("Material file")) | of_material
    assert set(rows("Material file")) <= asked[""]
    assert set(rows("[calibration]")) == asked["calibration"]


def test_defaults(tmp_path):
    case = parse_laboratory(smallest("laboratory"), tmp_path)
    top, made, bonds, contact = (
        {key: row[2] for key, row in rows(heading).items()}
        for heading in (
            "Top level of a laboratory",
            "[specimen]",
            "[material] of a laboratory",
            "[material.contact]",
        )
    )
    assert (int(top["seed"]), int(top["seeds"])) == (case.seed, case.seeds)
    assert int(made["dimension"]) == case.specimen.dimension
    assert (made["packing"], made["shape"]) == (f'`"{case.specimen.packing}"`', f'`"{case.specimen.shape}"`')
    assert (made["width"], case.specimen.width) == ('`"50 mm"`', 0.05)
    assert (made["height"], case.specimen.height) == ("twice the width", None)
    assert float(made["size_ratio"]) == case.specimen.size_ratio
    for workflow, parse, heading in (
        ("laboratory", parse_laboratory, "[specimen]"),
        ("calibration", parse_calibration, "[specimen] of a calibration"),
    ):
        text = smallest(workflow)
        flat, deep = (
            parse(
                text.replace("workflow", f"specimen = {{dimension = {d}}}\nworkflow"), tmp_path
            ).specimen.across
            for d in (2, 3)
        )
        assert rows(heading)["across"][2] == f"{flat:g}, in 3D {deep:g}"
    assert float(bonds["bonding_range"]) == case.material.bonding_range
    assert float(bonds["strength_variation"]) == case.material.variation
    assert bonds["strength_distribution"] == f'`"{case.material.distribution}"`'
    assert float(bonds["moment_contribution"]) == case.material.bond["moment_contribution"]
    assert contact["law"] == f'`"{case.material.contact_law}"`'
    assert float(contact["friction_coefficient"]) == case.material.contact["friction_coefficient"]


def test_defaults_of_laws_are_those_of_the_page():
    row = rows("[material] of a laboratory")
    cement = BOND_LAWS["cement"].PARAMETERS._field_defaults
    assert cement["friction_coefficient"] == 0.0
    assert 'default 0 with `"cement"`' in row["friction_coefficient"][3]
    assert cement["moment_contribution"] == 1.0
    assert '1 with `"cement"`' in row["moment_contribution"][3]
    assert row["radius_factor"][2] == "required"
    assert "radius_factor" not in cement


def test_choices_are_named():
    text = PAGE.read_text()
    choices = {*KINDS, *bond_laws(), *contact_laws(), *sum(PACKINGS.values(), ()), *sum(SHAPES.values(), ())}
    for choice in choices:
        assert f'`"{choice}"`' in text, choice
