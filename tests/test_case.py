"""Case files: what a good one means, and that every bad one is told where and what to do."""

from __future__ import annotations

import math
import re
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geodem.case import Case, ImageSection, RegionSection, load_case, parse_case
from geodem.errors import InputError, InputErrors

TEMPLATE = Path(str(files("geodem") / "templates" / "slope"))

GOOD = """\
workflow = "slope"
title = "Two layers"
particles = 5000
packing = "random"
methods = ["strength-reduction"]
tolerance = 0.01
seed = 7

[section]
length_unit = "m"
regions = [
  {material = "soil", polygon = [[0,0],[40,0],[40,15],[25,15],[10,5],[0,5]]},
  {material = "weak seam", polygon = [[0,3],[40,3],[40,4],[0,4]]},
]
layers = 3
thin = "refuse"
refine = [{material = "weak seam", spacing = "0.2 m"}, {box = [[20,10],[10,2]], spacing = "30 cm"}]

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
top = "free"

[loads]
horizontal_acceleration = "0.15 g"
surcharge = [{from = [25,15], to = [40,15], pressure = "20 kPa"}]

[material.soil]
law = "mohr_coulomb"
unit_weight = "19.62 kN/m3"
cohesion = "28.5 kPa"
friction_angle = "30 deg"
dilation_angle = "20 deg"
young_modulus = "100 MPa"
poisson_ratio = 0.3
tensile_strength = "5 kPa"

[material."weak seam"]
law = "mohr_coulomb"
density = "1.8 t/m3"
cohesion = "0 kPa"
friction_angle = "10 deg"
young_modulus = "50 MPa"
poisson_ratio = 0.25

[reference]
factor = 1.26
source = "somebody 1989"
"""

IMAGE = re.sub(
    r"regions = .*?\n\]\n",
    'image = "section.png"\nscale = "0.5 m/px"\nlegend = {"#8C6D31" = "soil", "#d00" = "weak seam"}\n'
    'background = ["#ffffff"]\ny_axis = "up"\norigin = [0, 0]\n',
    GOOD,
    flags=re.DOTALL,
)


def change(text: str, old: str, new: str) -> str:
    """`text` with the first `old` replaced; it must be there, so that no test passes on an unchanged case."""
    assert old in text
    return text.replace(old, new, 1)


def without(text: str, start: str) -> str:
    """`text` without the first line that begins with `start`."""
    return change(text, next(line + "\n" for line in text.splitlines() if line.startswith(start)), "")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a picture of 80 x 30 pixels in it."""
    from PIL import Image

    Image.new("RGB", (80, 30), "#8c6d31").save(tmp_path / "section.png")
    (tmp_path / "notes.png").write_text("this is no picture")
    return tmp_path


def test_every_number_arrives_in_si(tmp_path: Path) -> None:
    case = parse_case(GOOD, tmp_path)
    assert (case.workflow, case.title, case.particles, case.spacing) == ("slope", "Two layers", 5000, None)
    assert (case.packing, case.methods, case.tolerance, case.seed) == (
        "random",
        ("strength-reduction",),
        0.01,
        7,
    )
    assert isinstance(case.section, RegionSection)
    assert case.section.materials == ("soil", "weak seam")
    assert case.section.bounds == (0.0, 0.0, 40.0, 15.0)
    np.testing.assert_array_equal(case.section.regions[1][1], [[0, 3], [40, 3], [40, 4], [0, 4]])
    assert (case.section.layers, case.section.thin) == (3, "refuse")
    by_material, by_box = case.section.refine
    assert (by_material.material, by_material.box, by_material.spacing) == ("weak seam", None, 0.2)
    assert (by_box.material, by_box.box, by_box.spacing) == (None, (10.0, 2.0, 20.0, 10.0), 0.3)
    assert asdict(case.boundary) == {"left": "roller", "right": "roller", "bottom": "fixed", "top": "free"}
    assert case.loads.horizontal_acceleration == pytest.approx(0.15 * 9.81, rel=1e-15)
    (surcharge,) = case.loads.surcharge
    assert (surcharge.start, surcharge.end, surcharge.pressure) == ((25.0, 15.0), (40.0, 15.0), 20e3)
    soil, seam = case.materials["soil"], case.materials["weak seam"]
    # 19.62 kN/m3 / 9.81 m/s2
    assert soil.density == pytest.approx(2000.0, rel=1e-15)
    assert (soil.cohesion, soil.young_modulus, soil.poisson_ratio, soil.tensile_strength) == (
        28.5e3,
        1e8,
        0.3,
        5e3,
    )
    assert soil.friction_angle == pytest.approx(math.pi / 6, rel=1e-15)
    assert soil.dilation_angle == pytest.approx(math.pi / 9, rel=1e-15)
    assert soil.dilation_given
    assert (seam.density, seam.tensile_strength) == (1800.0, math.inf)
    assert seam.dilation_angle == seam.friction_angle
    assert not seam.dilation_given
    assert case.reference is not None
    assert (case.reference.factor, case.reference.source) == (1.26, "somebody 1989")
    assert case.text == GOOD


def test_every_default_is_said(tmp_path: Path) -> None:
    text = """
workflow = "slope"
[section]
regions = [{material = "soil", polygon = [[0,0],[40,0],[40,15],[0,5]]}]
[boundary]
bottom = "fixed"
[material.soil]
law = "mohr_coulomb"
density = "2 t/m3"
cohesion = "10 kPa"
friction_angle = "30 deg"
young_modulus = "50 MPa"
poisson_ratio = 0.3
"""
    case = parse_case(text, tmp_path)
    assert (case.particles, case.spacing, case.packing, case.seed, case.tolerance) == (
        5000,
        None,
        "random",
        1,
        0.01,
    )
    assert case.methods == ("strength-reduction", "gravity-increase")
    assert (case.section.layers, case.section.thin, case.section.refine) == (2, "refine", ())
    assert (case.loads.horizontal_acceleration, case.loads.surcharge) == (0.0, ())
    assert case.reference is None
    said = {notice.split(" is not given: ")[0]: notice for notice in case.notices}
    expected = {
        "title": tmp_path.name,
        "particles": "5000",
        "packing": "random",
        "methods": "gravity-increase",
        "tolerance": "0.01",
        "seed": "1",
        "section.length_unit": '"m"',
        "section.layers": "2",
        "section.thin": "refine",
        "boundary.left": "free",
        "boundary.right": "free",
        "boundary.top": "free",
        "loads": "none",
        "material.soil.dilation_angle": "30 deg",
        "material.soil.tensile_strength": "none",
    }
    assert set(said) == set(expected)
    for place, value in expected.items():
        assert value in said[place]


def test_a_picture(folder: Path) -> None:
    case = parse_case(IMAGE, folder)
    section = case.section
    assert isinstance(section, ImageSection)
    assert section.image == (folder / "section.png").resolve()
    assert (section.scale, section.y_axis, section.origin, section.pixels) == (
        0.5,
        "up",
        (0.0, 0.0),
        (80, 30),
    )
    assert dict(section.legend) == {"#8c6d31": "soil", "#dd0000": "weak seam"}
    assert section.background == ("#ffffff",)
    assert section.bounds == (0.0, 0.0, 40.0, 15.0)
    assert section.materials == ("soil", "weak seam")


def test_a_picture_beside_or_above_the_folder(folder: Path) -> None:
    (folder / "case").mkdir()
    beside = parse_case(change(IMAGE, "section.png", "../section.png"), folder / "case")
    absolute = parse_case(change(IMAGE, "section.png", str(folder / "section.png")), folder / "case")
    assert isinstance(beside.section, ImageSection)
    assert isinstance(absolute.section, ImageSection)
    assert beside.section.image == absolute.section.image == (folder / "section.png").resolve()


def test_white_is_background_unless_it_is_ground(folder: Path) -> None:
    silent = change(IMAGE, 'background = ["#ffffff"]\n', "")
    section = parse_case(silent, folder).section
    assert isinstance(section, ImageSection)
    assert section.background == ("#ffffff",)
    section = parse_case(change(silent, "#8C6D31", "#fff"), folder).section
    assert isinstance(section, ImageSection)
    assert section.background == ()


def test_lengths_in_feet(tmp_path: Path) -> None:
    case = parse_case(change(GOOD, 'length_unit = "m"', 'length_unit = "ft"'), tmp_path)
    assert isinstance(case.section, RegionSection)
    assert case.section.bounds == pytest.approx((0.0, 0.0, 40 * 0.3048, 15 * 0.3048), rel=1e-15)
    assert case.loads.surcharge[0].start == pytest.approx((25 * 0.3048, 15 * 0.3048), rel=1e-15)
    assert case.section.refine[1].box == pytest.approx((3.048, 0.6096, 6.096, 3.048), rel=1e-15)


# (what to change, into what, the place the message must name, a word of the remedy)
BAD = [
    # the file itself
    ('"slope"\ntitle', '"dam"\ntitle', "workflow", '"slope"'),
    ('workflow = "slope"\n', "", "workflow", 'workflow = "slope"'),
    ('"slope"\ntitle', '"slop"\ntitle', "workflow", 'Did you mean "slope"'),
    ("particles", "particels", "particels", 'Did you mean "particles"'),
    ('title = "Two layers"', "title = 3", "title", "title ="),
    ('title = "Two layers"', 'title = " "', "title", "title ="),
    ("particles = 5000", 'particles = 5000\nspacing = "0.5 m"', "spacing", "Keep one"),
    ("particles = 5000", "particles = 5000.0", "particles", "Write 5000."),
    ("particles = 5000", 'particles = "5000"', "particles", "whole number"),
    ("particles = 5000", "particles = true", "particles", "whole number"),
    ("particles = 5000", "particles = 2", "particles", "5000"),
    ("particles = 5000", "particles = 10", "particles", "2500 to 20000"),
    ("particles = 5000", "particles = 1000000000", "particles", "2500 to 20000"),
    ("particles = 5000", "particles = 1e9", "particles", "Write 1000000000."),
    ("particles = 5000", f"particles = {2**70}", "particles", "5000"),
    ("particles = 5000", "spacing = 0.5", "spacing", '"0.5 m"'),
    ("particles = 5000", 'spacing = "-0.5 m"', "spacing", "positive"),
    ("particles = 5000", 'spacing = "50 m"', "spacing", "smaller spacing"),
    ("particles = 5000", 'spacing = "0.5 mm"', "spacing", "larger spacing"),
    ('packing = "random"', 'packing = "hexagon"', "packing", 'Did you mean "hexagonal"'),
    ('["strength-reduction"]', '["strength_reduction"]', "methods[0]", 'Did you mean "strength-reduction"'),
    ('["strength-reduction"]', '"strength-reduction"', "methods", "methods = ["),
    ('["strength-reduction"]', "[]", "methods", "methods = ["),
    ('["strength-reduction"]', '["gravity-increase", "gravity-increase"]', "methods[1]", "once"),
    ('["strength-reduction"]', "[3]", "methods[0]", "Known"),
    ("tolerance = 0.01", "tolerance = 0.5", "tolerance", "0.01"),
    ("tolerance = 0.01", "tolerance = 0.00001", "tolerance", "0.01"),
    ("tolerance = 0.01", "tolerance = nan", "tolerance", "0.3"),
    ("seed = 7", "seed = -1", "seed", "whole number"),
    ("seed = 7", "seed = 1979-05-27", "seed", "whole number"),
    ("seed = 7", "seed = 7\nallow_implausible = [4]", "allow_implausible[0]", "material.soil.density"),
    ("seed = 7", 'seed = 7\nallow_implausible = ["material.soil.cohesino"]', "allow_implausible", "cohesion"),
    # the section
    ("[section]", "[sektion]", "sektion", 'Did you mean "section"'),
    ("[section]", "[sektion]", "section", "Add [section]"),
    ('length_unit = "m"', 'length_unit = "metre"', "section.length_unit", '"m"'),
    ('length_unit = "m"', 'length_unit = "mm"', "section.length_unit", "right one"),
    ('length_unit = "m"', 'length_unit = "km"', "section.length_unit", "right one"),
    ("regions = [\n", "regoins = [\n", "section.regoins", 'Did you mean "regions"'),
    ("regions = [\n", "regoins = [\n", "section", "exactly one"),
    ("layers = 3", 'layers = 3\nimage = "a.png"', "section", "exactly one"),
    ("layers = 3", 'layers = 3\nmesh = "a.msh"', "section", "exactly one"),
    ("layers = 3", 'layers = 3\nscale = "1 m/px"', "section.scale", "Remove scale"),
    ("layers = 3", "layers = 1", "section.layers", "from 2"),
    ("layers = 3", "layers = 1000", "section.layers", "from 2"),
    ('thin = "refuse"', 'thin = "refuze"', "section.thin", 'Did you mean "refuse"'),
    (
        'material = "soil", poly',
        'material = "sol", poly',
        "section.regions[0].material",
        'Did you mean "soil"',
    ),
    ('material = "soil", poly', 'stuff = "soil", poly', "section.regions[0].stuff", "Known"),
    ('material = "soil", poly', 'stuff = "soil", poly', "section.regions[0].material", "material ="),
    ('material = "soil", poly', "material = 3, poly", "section.regions[0].material", "Name a material"),
    ("[40,0]", '["40 m",0]', "section.regions[0].polygon[1][0]", "bare number in m"),
    ("[section]", "section = 3\n[sections]", "section", "[section] with"),
    ("[40,0]", "[40,0,0]", "section.regions[0].polygon[1]", "[x, y]"),
    ("[40,0]", "40", "section.regions[0].polygon[1]", "[x, y]"),
    ("[40,0]", "[nan,0]", "section.regions[0].polygon[1][0]", "bare number in m"),
    ("[40,0]", "[inf,0]", "section.regions[0].polygon[1][0]", "bare number in m"),
    ("[[0,3],[40,3],[40,4],[0,4]]", "[[0,3],[40,3]]", "section.regions[1].polygon", "[x, y]"),
    ("[[0,3],[40,3],[40,4],[0,4]]", "[[0,3],[40,3],[0,3]]", "section.regions[1].polygon", "[x, y]"),
    ("[[0,3],[40,3],[40,4],[0,4]]", "[[0,3],[40,3],[20,3]]", "section.regions[1].polygon", "in order round"),
    (
        "[[0,3],[40,3],[40,4],[0,4]]",
        "[[0,3],[40,4],[40,3],[0,4]]",
        "section.regions[1].polygon",
        "in order round",
    ),
    ("[[0,3],[40,3],[40,4],[0,4]]", '"square"', "section.regions[1].polygon", "polygon = [["),
    (
        '  {material = "weak seam", polygon = [[0,3],[40,3],[40,4],[0,4]]},',
        "  7,",
        "section.regions[1]",
        "polygon",
    ),
    ('spacing = "0.2 m"', 'spacing = "0 m"', "section.refine[0].spacing", "positive"),
    ('spacing = "0.2 m"', 'spacing = "200 m"', "section.refine[0].spacing", "smaller spacing"),
    (
        'material = "weak seam", spacing = "0.2 m"',
        'material = "weak seam"',
        "section.refine[0].spacing",
        "spacing =",
    ),
    ('{material = "weak seam", sp', "{sp", "section.refine[0]", "exactly one"),
    ('{material = "weak seam", sp', '{material = "weak", sp', "section.refine[0].material", '"weak seam"'),
    ("[[20,10],[10,2]]", "[[20,10],[20,2]]", "section.refine[1].box", "opposite corners"),
    ("[[20,10],[10,2]]", "[[20,10]]", "section.refine[1].box", "box ="),
    ("[[20,10],[10,2]]", "[[120,10],[110,2]]", "section.refine[1].box", "Move it"),
    # supports and loads
    ('bottom = "fixed"', 'bottom = "free"', "boundary.bottom", 'bottom = "fixed"'),
    ('bottom = "fixed"\n', "", "boundary.bottom", 'bottom = "fixed"'),
    (
        '"roller"\nright = "roller"\nbottom = "fixed"',
        '"free"\nright = "free"\nbottom = "roller"',
        "boundary",
        "left =",
    ),
    ('left = "roller"', 'left = "rollers"', "boundary.left", 'Did you mean "roller"'),
    ('left = "roller"', 'lift = "roller"', "boundary.lift", 'Did you mean "left"'),
    ('top = "free"', 'top = "fixed"', "boundary.top", "remove it"),
    ("[boundary]", "[boundry]", "boundary", "[boundary]"),
    ('"0.15 g"', "0.15", "loads.horizontal_acceleration", '"0.15 g"'),
    ('"0.15 g"', '"0.15 m"', "loads.horizontal_acceleration", "m/s2"),
    ('"0.15 g"', '"15 g"', "loads.horizontal_acceleration", '"0.4 g"'),
    ("horizontal_acceleration", "horizontal_accel", "loads.horizontal_accel", '"horizontal_acceleration"'),
    ('"20 kPa"}]', '"20 kN/m"}]', "loads.surcharge[0].pressure", "25 kPa"),
    ('"20 kPa"}]', '"-20 kPa"}]', "loads.surcharge[0].pressure", "without the sign"),
    ('"20 kPa"}]', '"20 GPa"}]', "loads.surcharge[0].pressure", '"20 MPa"'),
    ("from = [25,15]", "from = [40,15]", "loads.surcharge[0]", "two ends"),
    ("from = [25,15]", "from = [25,150]", "loads.surcharge[0].from", "Move it"),
    ("from = [25,15]", "start = [25,15]", "loads.surcharge[0].from", "from ="),
    ("surcharge = [", "surcharge = 3 #", "loads.surcharge", "surcharge = ["),
    # materials
    ("[material.soil]", "[materials.soil]", "materials", 'Did you mean "material"'),
    ("[material.soil]", "[material.soill]", "section.regions[0].material", 'Did you mean "soill"'),
    ('law = "mohr_coulomb"', 'law = "mohr-coulom"', "material.soil.law", 'Did you mean "mohr_coulomb"'),
    ('law = "mohr_coulomb"\n', "", "material.soil.law", "mohr_coulomb"),
    ('"19.62 kN/m3"', '"19.62 kN/m3"\ndensity = "2 t/m3"', "material.soil", "exactly one"),
    ('unit_weight = "19.62 kN/m3"\n', "", "material.soil", "exactly one"),
    ('"19.62 kN/m3"', "19.62", "material.soil.unit_weight", '"19.62 kN/m3"'),
    ('"19.62 kN/m3"', '"19.62 kPa"', "material.soil.unit_weight", '"20 kN/m3"'),
    ('"19.62 kN/m3"', '"2000 kN/m3"', "material.soil.unit_weight", '"2000 kg/m3"'),
    ('"19.62 kN/m3"', '"2.6 kN/m3"', "material.soil.unit_weight", '"2.6 t/m3"'),
    ('"19.62 kN/m3"', '"0 kN/m3"', "material.soil.unit_weight", "positive"),
    ('density = "1.8 t/m3"', 'density = "1.8 kg/m3"', 'material."weak seam".density', "1.8 t/m3"),
    ('density = "1.8 t/m3"', 'density = "1800 t/m3"', 'material."weak seam".density', "1800 kg/m3"),
    ('"28.5 kPa"', "28.5", "material.soil.cohesion", '"28.5 kPa"'),
    ('"28.5 kPa"', '"28,5 kPa"', "material.soil.cohesion", '"28.5 kPa"'),
    ('"28.5 kPa"', '"28.5 kN/m3"', "material.soil.cohesion", "25 kPa"),
    ('"28.5 kPa"', '"28.5 t/m2"', "material.soil.cohesion", "279.585 kPa"),
    ('"28.5 kPa"', '"28500 kPa"', "material.soil.cohesion", '"28.5 kPa"'),
    ('"28.5 kPa"', '"-1 kPa"', "material.soil.cohesion", "zero"),
    ('"28.5 kPa"', '"inf kPa"', "material.soil.cohesion", "25 kPa"),
    ('cohesion = "28.5 kPa"\n', "", "material.soil.cohesion", "0 kPa"),
    ('cohesion = "28.5 kPa"', 'c = "28.5 kPa"', "material.soil.c", "cohesion"),
    ('friction_angle = "10 deg"', 'friction_angle = "0 deg"', 'material."weak seam".cohesion', "strength"),
    ('"30 deg"', '"0.6 deg"', "material.soil.friction_angle", '"0.6 rad" (34.4 deg)'),
    ('"30 deg"', '"62 deg"', "material.soil.friction_angle", "0 to 45"),
    ('"30 deg"', '"90 deg"', "material.soil.friction_angle", "0 to 45"),
    ('"30 deg"', '"-3 deg"', "material.soil.friction_angle", "zero"),
    ('"30 deg"', '"30 rad"', "material.soil.friction_angle", "45"),
    ('friction_angle = "30 deg"\n', "", "material.soil.friction_angle", "0 deg"),
    ('"20 deg"', '"40 deg"', "material.soil.dilation_angle", "at most the friction angle"),
    ('"20 deg"', '"-5 deg"', "material.soil.dilation_angle", "0 deg"),
    ('"100 MPa"', '"100 Pa"', "material.soil.young_modulus", '"100 MPa"'),
    ('"100 MPa"', '"100 TPa"', "material.soil.young_modulus", "GPa"),
    ('"100 MPa"', '"1e6 GPa"', "material.soil.young_modulus", "Did you mean"),
    ('young_modulus = "100 MPa"\n', "", "material.soil.young_modulus", "10 to 100 MPa"),
    ("poisson_ratio = 0.3\n", "", "material.soil.poisson_ratio", "Any plausible value"),
    ("poisson_ratio = 0.3", "poisson_ratio = 30", "material.soil.poisson_ratio", "Did you mean 0.3"),
    ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "material.soil.poisson_ratio", "0.49"),
    ("poisson_ratio = 0.3", "poisson_ratio = -0.1", "material.soil.poisson_ratio", "0.2 to 0.4"),
    (
        'tensile_strength = "5 kPa"',
        'tensile_strength = "nothing"',
        "material.soil.tensile_strength",
        '"none"',
    ),
    ('tensile_strength = "5 kPa"', 'tensile_strength = "-5 kPa"', "material.soil.tensile_strength", '"none"'),
    ('[material."weak seam"]', "[material.seam]", "section.regions[1].material", "weak seam"),
    ("[material.soil]", "[material]\nsoil = 4\n[other]", "material.soil", "[material.soil]"),
    # the reference value
    ("factor = 1.26", "factor = 0", "reference.factor", "positive"),
    ("factor = 1.26\n", "", "reference.factor", "[reference]"),
    ('source = "somebody 1989"', 'sauce = "x"', "reference.sauce", '"source"'),
]

BAD_IMAGE = [
    ('"section.png"', '"sektion.png"', "section.image", "relative to the case file"),
    ('"section.png"', '"../sektion.png"', "section.image", "relative to the case file"),
    ('"section.png"', '"a\\u0000b"', "section.image", "relative to the case file"),
    ('"section.png"', '"."', "section.image", "Name a file"),
    ('"section.png"', '"notes.png"', "section.image", "PNG"),
    ('"section.png"', "7", "section.image", "image ="),
    ('"0.5 m/px"', '"0.5 m"', "section.scale", "0.25 m/px"),
    ('"0.5 m/px"', '"0 m/px"', "section.scale", "positive"),
    ('"0.5 m/px"', '"0.5 mm/px"', "section.scale", "Check it"),
    ('"0.5 m/px"', '"0.5 km/px"', "section.scale", "Check it"),
    ('scale = "0.5 m/px"\n', "", "section.scale", "0.25 m/px"),
    ("#8C6D31", "brown", "section.legend.brown", "#8c6d31"),
    ('"#8C6D31" = "soil"', '"#8C6D31" = "sole"', 'section.legend."#8C6D31"', 'Did you mean "soil"'),
    ('"#8C6D31" = "soil"', '"#8C6D31" = 3', 'section.legend."#8C6D31"', "Name a material"),
    ("#8C6D31", "#DD0000", 'section.legend."#d00"', "Keep one"),
    ('{"#8C6D31" = "soil", "#d00" = "weak seam"}', "{}", "section.legend", "legend ="),
    ('["#ffffff"]', '["#d00"]', "section.background[0]", "one of the two"),
    ('["#ffffff"]', '["white"]', "section.background[0]", "hexadecimal"),
    ('["#ffffff"]', '"#ffffff"', "section.background", "background = ["),
    ('y_axis = "up"', 'y_axis = "upwards"', "section.y_axis", '"up"'),
    ("origin = [0, 0]", "origin = 0", "section.origin", "[x, y]"),
]


def expect(text: str, folder: Path, place: str, word: str) -> None:
    """Reading `text` brings up an error at `place` whose remedy contains `word`."""
    with pytest.raises(InputErrors) as caught:
        parse_case(text, folder)
    at_place = [error for error in caught.value.errors if error.place == place]
    assert at_place, f"nothing said about {place}:\n{caught.value}"
    assert any(word in error.remedy for error in at_place), str(caught.value)
    assert len(caught.value.errors) <= 5, f"one mistake makes a flood:\n{caught.value}"


@pytest.mark.parametrize(("old", "new", "place", "word"), BAD)
def test_bad_case(old: str, new: str, place: str, word: str, tmp_path: Path) -> None:
    expect(change(GOOD, old, new), tmp_path, place, word)


@pytest.mark.parametrize(("old", "new", "place", "word"), BAD_IMAGE)
def test_bad_picture_case(old: str, new: str, place: str, word: str, folder: Path) -> None:
    expect(change(IMAGE, old, new), folder, place, word)


def test_all_errors_come_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = change(GOOD, "seed = 7", "seed = -7")
    text = change(text, "[40,0]", "[40]")
    text = change(text, 'bottom = "fixed"', 'bottom = "glued"')
    text = change(text, '"28.5 kPa"', "28.5")
    text = change(text, 'density = "1.8 t/m3"', 'density = "1.8 kg/m3"')
    text = change(text, "factor = 1.26", "factor = -1")
    with pytest.raises(InputErrors) as caught:
        parse_case(text, tmp_path)
    assert [error.place for error in caught.value.errors] == [
        "seed",
        "section.regions[0].polygon[1]",
        "boundary.bottom",
        "material.soil.cohesion",
        'material."weak seam".density',
        "reference.factor",
    ]


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("particles = 5000", "particles = 10", "particles"),
        ("particles = 5000", 'spacing = "20 m"', "spacing"),
        ('length_unit = "m"', 'length_unit = "mm"', "section.length_unit"),
        ('top = "free"', 'top = "roller"', "boundary.top"),
        ('"0.15 g"', '"15 g"', "loads.horizontal_acceleration"),
        ('"20 kPa"}]', '"-20 kPa"}]', "loads.surcharge[0].pressure"),
        ('"19.62 kN/m3"', '"2000 kN/m3"', "material.soil.unit_weight"),
        ('density = "1.8 t/m3"', 'density = "2.6 kg/m3"', 'material."weak seam".density'),
        ('"28.5 kPa"', '"28500 kPa"', "material.soil.cohesion"),
        ('"30 deg"', '"62 deg"', "material.soil.friction_angle"),
        ('"20 deg"', '"31 deg"', "material.soil.dilation_angle"),
        ('"100 MPa"', '"1000 GPa"', "material.soil.young_modulus"),
    ],
)
def test_the_implausible_is_run_where_it_is_allowed(old: str, new: str, place: str, tmp_path: Path) -> None:
    text = without(change(GOOD, old, new), "refine")
    with pytest.raises(InputErrors) as caught:
        parse_case(text, tmp_path)
    (error,) = caught.value.errors
    consent = re.search(r"allow_implausible = \[.*\]", error.remedy)
    assert consent is not None
    # the line that the message proposes is the line that helps
    allowed = parse_case(f"{consent.group()}\n{text}", tmp_path)
    assert allowed.allow_implausible == (place,)
    assert any(notice.startswith(place) and "allowed" in notice for notice in allowed.notices)
    assert_round_trip(allowed, tmp_path)


def test_permission_that_is_not_needed_is_noted(tmp_path: Path) -> None:
    case = parse_case('allow_implausible = ["material.soil.cohesion"]\n' + GOOD, tmp_path)
    assert any("material.soil.cohesion is plausible" in notice for notice in case.notices)


def test_what_stops_nothing_is_said(tmp_path: Path) -> None:
    text = change(GOOD, '"0.15 g"', '"-0.15 g"')
    text = change(text, '"20 deg"', '"0 deg"')
    text = change(text, 'tensile_strength = "5 kPa"', 'tensile_strength = "50 kPa"')
    text += '\n[material.spare]\nlaw = "mohr_coulomb"\ndensity = "2 t/m3"\ncohesion = "1 kPa"\n'
    text += 'friction_angle = "30 deg"\nyoung_modulus = "50 MPa"\npoisson_ratio = 0.3\n'
    case = parse_case(text, tmp_path)
    assert any("loads.horizontal_acceleration" in question for question in case.questions)
    assert any("material.soil.dilation_angle" in q and "mesh" in q for q in case.questions)
    # c / tan(phi) = 28.5 / tan(30 deg) = 49.36 kPa
    assert any("no effect" in notice and "49.36" in notice for notice in case.notices)
    assert any("'spare' is not used" in notice for notice in case.notices)


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("workflow = slope", "line 1", "not TOML"),
        ('workflow = "slope"\nworkflow = "slope"\n', "line 2", "overwrite"),
        ('title = "a\n', "line 1", "not TOML"),
        ("[section]\n[section]\n", "line 2", "not TOML"),
        ("a = " + "[" * 100_000, "case file", "too deep"),
        (".".join("a" * 40) + " = 1", "case file", "nested"),
        ("particles = " + "9" * 5000, "case file", "too long"),
    ],
    ids=["bare word", "key twice", "open text", "table twice", "deep list", "deep table", "long number"],
)
def test_what_is_no_toml(text: str, where: str, what: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        parse_case(text, tmp_path)
    assert where in caught.value.place
    assert what in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.toml", tmp_path / "none.toml" / "case.toml", Path("a\0b")):
        with pytest.raises(InputError) as caught:
            load_case(path)
        assert caught.value.place == str(path / "case.toml" if path == tmp_path else path)
    (tmp_path / "latin.toml").write_bytes(b'workflow = "slope"\ntitle = "B\xf6schung"\n')
    with pytest.raises(InputError, match="line 2 is not UTF-8"):
        load_case(tmp_path / "latin.toml")


def test_byte_order_mark_and_windows_line_ends(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_case(tmp_path).particles == load_case(tmp_path / "case.toml").particles == 5000


def numbers(case: Case) -> dict[str, object]:
    """All of a case that decides what is computed."""
    found = {name: getattr(case, name) for name in case.__dataclass_fields__}
    for name in ("notices", "questions", "text", "allow_implausible", "section"):
        del found[name]
    section = {name: getattr(case.section, name) for name in case.section.__dataclass_fields__}
    if isinstance(case.section, RegionSection):
        section["regions"] = [(material, polygon.tobytes()) for material, polygon in case.section.regions]
    return {**found, "section": section}


def assert_round_trip(case: Case, folder: Path) -> None:
    """The text of a case as run reads back to the same numbers, wherever it lies, and to the same text."""
    again = parse_case(case.as_run_text(), folder / "elsewhere")
    assert numbers(again) == numbers(case)
    assert again.as_run_text() == case.as_run_text()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("seed = 7", "seed = 7"),
        ('length_unit = "m"', 'length_unit = "ft"'),
        ("particles = 5000", 'spacing = "1.7 ft"'),
        ('"30 deg"', '"0.577 rad"'),
        ('"28.5 kPa"', '"613 psf"'),
        ('"19.62 kN/m3"', '"123.456 pcf"'),
        ("0.01", "0.0123456789"),
        ("Two layers", 'Qu\\"ote\\\\ \\u0007 \\u00f6'),
        ("weak seam", 'weak \\"seam\\".x'),
        ('[reference]\nfactor = 1.26\nsource = "somebody 1989"\n', ""),
    ],
)
def test_as_run_text_reads_back_to_the_same_bits(old: str, new: str, tmp_path: Path) -> None:
    assert old in GOOD
    assert_round_trip(parse_case(GOOD.replace(old, new), tmp_path), tmp_path)


def test_as_run_text_of_a_picture(folder: Path) -> None:
    assert_round_trip(parse_case(IMAGE, folder), folder)


def test_as_run_text_leaves_no_default_unsaid(tmp_path: Path) -> None:
    text = re.sub(r"(?m)^(title|packing|methods|tolerance|seed|layers|thin|left|right|top) = .*\n", "", GOOD)
    again = parse_case(parse_case(text, tmp_path).as_run_text(), tmp_path)
    # the dilation angle stays left out, since the report treats a given one differently
    assert [notice.split(" is not")[0] for notice in again.notices] == ['material."weak seam".dilation_angle']


def test_the_template_is_complete(tmp_path: Path) -> None:
    case = load_case(TEMPLATE)
    assert case.questions == ()
    # the example of the published problem: cohesion, friction, unit weight and its factor
    soil, seam = case.materials["soil"], case.materials["seam"]
    assert (soil.cohesion, seam.cohesion) == (28.5e3, 0.0)
    assert seam.friction_angle == pytest.approx(math.radians(10), rel=1e-15)
    assert soil.density == pytest.approx(18840 / 9.81, rel=1e-15)
    assert case.reference is not None
    assert case.reference.factor == 1.26
    # every line that is offered in a comment works too
    offered = re.sub(r"(?m)^#(?=\w)", "", case.text)
    full = parse_case(offered, tmp_path)
    assert full.loads.horizontal_acceleration > 0.0
    assert len(full.loads.surcharge) == 1
    assert len(full.section.refine) == 2
    assert full.notices == ()


def test_the_template_names_every_key() -> None:
    from geodem.case import data, material, reading, section

    text = (TEMPLATE / "case.toml").read_text(encoding="utf-8")
    keys = {*reading.KEYS, *section.KEYS, *material.KEYS, *data.Boundary.__dataclass_fields__}
    keys |= {"horizontal_acceleration", "surcharge", "from", "to", "pressure", "factor", "source"}
    for key in keys:
        assert re.search(rf"\b{key}\b", text), key


TOKENS = [
    "0",
    "-1",
    "1e400",
    "nan",
    "inf",
    "true",
    "[]",
    "{}",
    '""',
    '"25 kPa"',
    '"\\u0000"',
    "1979-05-27",
    "0x" + "f" * 5000,
]
LINES = GOOD.splitlines()


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_mutation_brings_anything_but_an_input_error(data: st.DataObject, folder: Path) -> None:
    lines = list(IMAGE.splitlines() if data.draw(st.booleans()) else LINES)
    for _ in range(data.draw(st.integers(1, 3))):
        index = data.draw(st.integers(0, len(lines) - 1))
        line = lines[index]
        kind = data.draw(st.sampled_from(["value", "characters", "drop", "twice", "number"]))
        if kind == "value" and " = " in line:
            lines[index] = line.split(" = ", 1)[0] + " = " + data.draw(st.sampled_from(TOKENS))
        elif kind == "characters":
            at = data.draw(st.integers(0, len(line)))
            lines[index] = (
                line[:at] + data.draw(st.text(max_size=3)) + line[at + data.draw(st.integers(0, 3)) :]
            )
        elif kind == "drop":
            del lines[index]
        elif kind == "twice":
            lines.insert(index, line)
        else:
            token = data.draw(st.sampled_from(TOKENS))
            lines[index] = re.sub(r"\d+(\.\d+)?", lambda _, token=token: token, line, count=1)
    refused: InputError | None = None
    try:
        case = parse_case("\n".join(lines), folder)
    except InputError as error:
        refused = error
    if refused is None:
        assert_round_trip(case, folder)
    else:
        assert all(len(error.remedy) > 3 for error in getattr(refused, "errors", [refused]))
        assert str(refused)
