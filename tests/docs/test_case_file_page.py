"""The page of the case file knows the keys, units and defaults that the reader knows."""

import math
import re

import pytest

from geodem import units
from geodem.case import parse_case, table
from geodem.case.data import LAWS, METHODS, PACKINGS, SUPPORTS
from geodem.kinds import KINDS
from tests.docs.pages import DOCS, tables

PAGE = DOCS / "reference" / "case-file.md"

# asks for every table that there is; that image and regions exclude each other does not matter here
EVERYTHING = """
[section]
regions = [{material = "soil", polygon = [[0, 0], [32, 0], [32, 10], [20, 10]]}]
refine = [{material = "soil", spacing = "1 m"}]
[boundary]
[loads]
surcharge = [{from = [20, 10], to = [32, 10], pressure = "1 kPa"}]
[material.soil]
[reference]
"""

HEADINGS = {
    "": "Top level",
    "section": "[section]",
    "section.regions": "[[section.regions]]",
    "section.refine": "[[section.refine]]",
    "boundary": "[boundary]",
    "loads": "[loads]",
    "loads.surcharge": "[[loads.surcharge]]",
    "material.soil": "[material.NAME]",
    "reference": "[reference]",
}


def _rows(heading):
    return {row[0].strip("`"): row for row in tables(PAGE)[heading]}


def test_keys_are_those_of_the_reader(monkeypatch, tmp_path):
    asked = {}
    original = table.Table.__init__

    def spy(self, findings, place, content, known):
        asked[re.sub(r"\[\d+\]", "", place)] = tuple(known)
        original(self, findings, place, content, known)

    monkeypatch.setattr(table.Table, "__init__", spy)
    with pytest.raises(ValueError, match="workflow"):
        parse_case(EVERYTHING, tmp_path)
    asked.pop("material")  # its keys are the names of the materials
    assert set(asked) == set(HEADINGS)
    for place, known in asked.items():
        assert set(_rows(HEADINGS[place])) == set(known), place


def _smallest(tmp_path, **changes):
    text = PAGE.read_text()
    block = text[text.index("    workflow =") : text.index("`geodem new slope DIR`")]
    block = re.sub(r"^ {4}", "", block, flags=re.M)
    for old, new in changes.values():
        assert old in block
        block = block.replace(old, new)
    return parse_case(block, tmp_path / "some-slope")


def test_defaults_are_those_of_the_reader(tmp_path):
    case = _smallest(tmp_path)
    top, section, sides, loads, material = (
        {key: row[2] for key, row in _rows(heading).items()}
        for heading in ("Top level", "[section]", "[boundary]", "[loads]", "[material.NAME]")
    )
    assert int(top["particles"]) == case.particles
    assert case.spacing is None
    assert top["packing"] == f'`"{case.packing}"`'
    assert top["methods"] == "both"
    assert case.methods == METHODS
    assert float(top["tolerance"]) == case.tolerance
    assert int(top["seed"]) == case.seed
    assert top["title"] == "name of the folder"
    assert case.title == "some-slope"
    assert int(section["layers"]) == case.section.layers
    assert section["thin"] == f'`"{case.section.thin}"`'
    assert sides["left"] == sides["top"] == f'`"{case.boundary.left}"`' == f'`"{case.boundary.top}"`'
    assert loads["horizontal_acceleration"] == '`"0 g"`'
    assert case.loads.horizontal_acceleration == 0.0
    soil = case.materials["soil"]
    assert material["dilation_angle"] == "the friction angle"
    assert soil.dilation_angle == soil.friction_angle
    assert material["tensile_strength"] == '`"none"`'
    assert math.isinf(soil.tensile_strength)


def test_defaults_of_a_picture_are_those_of_the_reader(tmp_path):
    from PIL import Image

    Image.new("RGB", (32, 20), "#8c6d31").save(tmp_path / "section.png")
    picture = 'image = "../section.png"\nscale = "1 m/px"\nlegend = {"#8c6d31" = "soil"}'
    regions = 'regions = [{material = "soil", polygon = [[0, 0], [32, 0], [32, 10], [20, 10]]}]'
    (tmp_path / "some-slope").mkdir()
    section = _smallest(tmp_path, picture=(regions, picture)).section
    rows = {key: row[2] for key, row in _rows("[section]").items()}
    assert rows["background"] == f'`["{section.background[0]}"]`'
    assert rows["y_axis"] == f'`"{section.y_axis}"`'
    assert rows["origin"] == "`[0, 0]`"
    assert section.origin == (0.0, 0.0)


@pytest.mark.parametrize(
    "missing",
    [
        (place, key)
        for place in ("[material.NAME]",)
        for key, row in _rows(place).items()
        if row[2] == "required"
    ],
)
def test_what_is_called_required_is(missing, tmp_path):
    _, key = missing
    line = next(line for line in PAGE.read_text().splitlines() if line.strip().startswith(f"{key} ="))
    with pytest.raises(ValueError, match=rf"material\.soil\.{key}: missing"):
        _smallest(tmp_path, gone=(line.strip() + "\n", "\n"))


def test_choices_are_named():
    text = PAGE.read_text()
    for choice in (*KINDS, *METHODS, *PACKINGS, *SUPPORTS, *LAWS):
        assert f'`"{choice}"`' in text, choice


def test_units_are_those_that_can_be_read():
    for name, listed in (row for row in tables(PAGE)["Units"]):
        known = units._DIMENSIONS[name.replace("picture scale", "pixel_scale").replace(" ", "_")].units
        assert listed.split(", ") == list(known), name
