"""Cases of ground: what is read, what is refused and in which words, and that a case writes back what it is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from geodem.case import load_any, parse_ground, parse_laboratory, write_material
from geodem.case.ground import GroundCase
from geodem.errors import InputError
from geodem.laboratory.material import BondedMaterial
from tests.ground_files import BONDED, GROUND, ground_case

DENSITY = 'density = "2000 kg/m3"'
# sources whose files the case only names; what is in them is found when the body is made
SOURCES = {
    "photograph": ('photograph = "f"\nscale = "2 mm/px"\nmaterials = ["a", "none", "b"]\nthresholds = [0.3, 0.6]\n'
                   'smoothing = 1.5\nlighting = 40\nsmallest = 20\ngrains = "b"\napart = 12\norigin = ["0 m", "-2 m"]',
                   ("a", "b")),
    "slices": ('slices = "f"\nvoxel = ["0.1 mm", "0.1 mm", "0.3 mm"]\nlegend = {"#000000" = "a"}', ("a",)),
    "slices by brightness": ('slices = "f"\nvoxel = "0.1 mm"\nmaterials = ["a", "none"]', ("a",)),
    "grid": ('grid = "f"\nscalars = "density"\nthresholds = [-0.5, 1e3]\nmaterials = ["none", "a", "b"]', ("a", "b")),
    "mesh": ('mesh = "f"\nlength_unit = "mm"\nnames = {3 = "a", 4 = "b c"}\nmaterial_array = "region"', ("a", "b c")),
    "solids": ('solids = {a = "f", "b c" = "g"}\nlength_unit = "cm"', ("a", "b c")),
    "geometry": ('geometry = "f"\nsize = "0.3 m"', ("a",)),
    "terrain": ('terrain = "f"\nbase = "100 m"\nlayers = [{material = "a", depth = "2 m"}, {material = "b"}]\n'
                'cut_out = [[10, 40], [5, 20]]\ndegrees = false\nholes = "fill"', ("a", "b")),
}  # fmt: skip


def case_of(source: str, names: tuple[str, ...], particles: str = "particles = 500") -> str:
    tables = "".join(f'\n[material."{name}"]\n{DENSITY}\n' for name in names)
    return f'workflow = "ground"\n\n[source]\n{source}\n\n[particles]\n{particles}\n{tables}'


@pytest.fixture
def folder(tmp_path) -> Path:
    for name in "fg":
        (tmp_path / name).write_text("nothing")
    ground_case(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", SOURCES)
def test_a_case_as_run_is_the_same_case(folder, kind):
    case = parse_ground(case_of(*SOURCES[kind]), folder)
    again = parse_ground(case.as_run_text(), folder)
    assert again.as_run_text() == case.as_run_text()
    assert again.source == case.source
    assert again.particles == case.particles
    assert again.materials == case.materials
    assert case.source.kind == kind.split()[0]


def test_values_of_a_case(folder):
    case = parse_ground(case_of(*SOURCES["photograph"]), folder)
    options = case.source.options
    assert options["scale"] == 2e-3
    assert options["materials"] == ("a", None, "b")
    assert options["origin"] == (0.0, -2.0)
    terrain = parse_ground(case_of(*SOURCES["terrain"]), folder).source.options
    assert terrain["cut_out"] == ((5.0, 20.0), (10.0, 40.0)), "corners in ascending order"
    assert terrain["layers"][0] == ("a", 2.0)
    mesh = parse_ground(case_of(*SOURCES["mesh"]), folder).source
    assert mesh.options["names"] == {3: "a", 4: "b c"}
    assert mesh.materials is None, "only the file names them all"


def test_particles_as_they_are_given(folder):
    """Radii are metres, shares of a sieve curve no percentages."""
    curve = 'grading = [{radius = "5 mm", passing = "0 %"}, {radius = "9 mm", passing = 1.0}]'
    case = parse_ground(GROUND.replace("particles = 1200", curve), folder)
    assert case.particles.grading == ((5e-3, 0.0), (9e-3, 1.0))
    assert parse_ground(case.as_run_text(), folder).particles == case.particles
    sieves = 'grading = [{sieve = "10 mm", passing = "0 %"}, {sieve = "18 mm", passing = "100 %"}]'
    same = parse_ground(GROUND.replace("particles = 1200", sieves), folder)
    assert same.particles.grading == case.particles.grading
    pixel = parse_ground(GROUND.replace("particles = 1200\nseed = 4", 'arrangement = "pixel"'), folder)
    assert pixel.particles.particles is pixel.particles.radius is None
    bare = parse_ground(GROUND.replace("[particles]\nparticles = 1200\nseed = 4\n", ""), folder)
    assert bare.particles.particles == 10_000
    assert any("particles is not given" in text for text in bare.notices)


def test_materials_with_bonds_and_from_a_file(folder):
    material = BondedMaterial.rock(
        density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=12e6, shear_strength=60e6,
        friction_angle=0.6,
    )  # fmt: skip
    write_material(folder / "granite.toml", material)
    text = GROUND.replace('density = "1900 kg/m3"', 'file = "granite.toml"').replace(
        '"2100 kg/m3"', f'"2100 kg/m3"\n{BONDED}'
    )
    case = parse_ground(text, folder)
    assert case.materials["soil"].density == 2600.0, "that of the file"
    assert case.materials["soil"].bonded.bond == material.bond
    assert case.materials["seam"].bonded.bond["effective_modulus"] == 2e9
    assert case.materials["seam"].bonded.density == case.materials["seam"].density == 2100.0
    heavier = parse_ground(
        text.replace('file = "granite.toml"', 'file = "granite.toml"\nunit_weight = "19.62 kN/m3"'), folder
    )
    assert heavier.materials["soil"].density == pytest.approx(2000.0)
    assert heavier.materials["soil"].bonded.density == pytest.approx(2000.0)
    again = parse_ground(case.as_run_text(), folder)
    assert again.materials == case.materials


def test_any_case_is_read_as_what_it_is(folder):
    assert isinstance(load_any(folder), GroundCase)
    (folder / "case.toml").write_text(GROUND.replace('"ground"', '"grund"'))
    with pytest.raises(InputError, match=r"^workflow = 'grund'.*Did you mean \"ground\"") as caught:
        load_any(folder)
    assert "\n" not in str(caught.value), "the rest is right for ground"
    with pytest.raises(InputError, match="geodem run CASE"):
        parse_laboratory(GROUND, folder)


IMAGE = 'image = "bank.png"'


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (IMAGE, f'{IMAGE}\nmesh = "f"',
         r"^source: image and mesh are given\. Give exactly one of .image., .photograph."),
        (IMAGE, "", r"^source: nothing says what the ground is made from"),
        ("[source]", "[sauce]", r'^sauce: unknown key\. Did you mean "source"'),
        ("seed = 4", "sed = 4", r'^particles\.sed: unknown key\. Did you mean "seed"\?'),
        ("scale", "scael", r'^source\.scael: unknown key\. Did you mean "scale"\?'),
        ('"0.1 m/px"', "0.1", r'^source\.scale = 0\.1: a bare number; a picture scale.*Write "0\.1 m/px"'),
        ('"0.1 m/px"', '"10 px/m"', r'pixels per length, and length per pixel is needed\. Write "0\.1 m/px"'),
        ("bank.png", "bnak.png",
         r"^source\.image = 'bnak\.png': there is no such file\. Did you mean \"bank\.png\"\?"),
        ('scale = "0.1 m/px"', "", r'^source\.scale: missing\. Write scale = "2 mm/px"'),
        ("[material.seam]", "[material.saem]",
         r'^material\.seam: missing: the source has the material "seam"\. Did you mean '
         r'"saem"\? Add \[material\.seam\].*The source has "soil", "seam"; the case has "soil", "saem"'),
        ("[material.seam]", f"[material.peat]\n{DENSITY}\n[material.seam]",
         r'^material\.peat: the source has no such material.*one of "soil", "seam"'),
        ("particles = 1200", 'particles = 1200\nradius = "5 cm"', r"radius and particles are given\. Keep one of them"),
        ("particles = 1200", "particles = 1_000_000_000",
         r"^particles\.particles = 1000000000: so many particles take days and "
         r'tens of gigabytes.*allow_implausible = \["particles\.particles"\]'),
        ("particles = 1200", "radius = 0.05", r'^particles\.radius = 0\.05: a bare number; a length needs its unit'),
        ('"1900 kg/m3"', '"1.9 kg/m3"',
         r"^material\.soil\.density = '1\.9 kg/m3': ground has 500 kg/m3 to 5100 kg/m3\. Check "
         r"the unit"),
        ('density = "1900 kg/m3"', 'unit_weight = "1900 kg/m3"',
         r"^material\.soil\.unit_weight = '1900 kg/m3'.*is a density"),
        ('density = "1900 kg/m3"', "", r'^material\.soil\.density: missing\. Write density = "1900 kg/m3"'),
        ('density = "1900 kg/m3"', 'file = "g.toml"', r"^material\.soil\.file = 'g\.toml': there is no such file"),
        ('"1900 kg/m3"', '"1900 kg/m3"\nlaw = "rock"', r"^material\.soil\.effective_modulus: missing"),
        ("seed = 4", 'arrangement = "hexagonal"\nseed = 4',
         r'^particles\.seed = 4: this belongs to arrangement = "random"'),
        ("seed = 4", 'arrangement = "hexagon"', r'^particles\.arrangement = .hexagon.*Did you mean "hexagonal"'),
        ("seed = 4", "size_ratio = 0.5", r"^particles\.size_ratio = 0\.5: largest over smallest"),
        ("particles = 1200", 'grading = [{radius = "9 mm", passing = "0 %"}, {radius = "5 mm", passing = "100 %"}]',
         r"^particles\.grading: .*do not grow|^particles\.grading = .*do not grow"),
        ('scale = "0.1 m/px"', 'scale = "0.1 m/px"\nthresholds = [0.4]',
         r"^source\.thresholds = \[0\.4\]: this belongs to photograph"),
        ("#d62728", "#8C6D31", r"this colour stands in the legend twice"),
        ("particles = 1200", 'grading = "coarse"', r"^particles\.grading = 'coarse': a list is needed here, not text"),
    ],
)  # fmt: skip
def test_what_is_refused(folder, old, new, said):
    assert old in GROUND
    with pytest.raises(InputError) as caught:
        parse_ground(GROUND.replace(old, new), folder)
    assert re.search(said, str(caught.value), re.MULTILINE), str(caught.value)


@pytest.mark.parametrize(
    ("kind", "old", "new", "said"),
    [
        ("photograph", '["a", "none", "b"]', '["a", "b"]', r"2 thresholds part 3 materials, these are 2"),
        ("photograph", '["a", "none", "b"]', '["none", "none", "none"]', r"source\.materials.*no ground among these"),
        ("photograph", "[0.3, 0.6]", "[0.6, 0.3]", r"source\.thresholds.*do not grow"),
        ("photograph", "[0.3, 0.6]", "[30, 60]", r"brightness lies between 0, black, and 1, white"),
        ("photograph", 'grains = "b"', 'grains = "c"', r"source\.grains = 'c': this is none of the materials"),
        ("photograph", '"0 m", "-2 m"', "0, -2", r'source\.origin\.0 = 0: a bare number; a length needs its unit'),
        ("slices", '"0.3 mm"]', '"0 mm"]', r"source\.voxel\.2 = '0 mm': this must be above zero"),
        ("slices", 'voxel = ["0.1 mm", "0.1 mm", "0.3 mm"]', "", r"source\.voxel: missing"),
        ("grid", "thresholds = [-0.5, 1e3]", "", r"source\.thresholds: missing"),
        ("grid", "[-0.5, 1e3]", f"[1{'0' * 400}, 1]", r"source\.thresholds = .*numbers are needed here"),
        ("mesh", "3 = ", "three = ", r"source\.names\.three = 'a': the number of a group is needed"),
        ("mesh", '"mm"', '"mi"', r"source\.length_unit = 'mi'"),
        ("solids", 'a = "f"', 'a = "h"', r"source\.solids\.a = 'h': there is no such file"),
        ("terrain", ', depth = "2 m"', "", r"source\.layers\[0\]\.depth: missing"),
        ("terrain", "[5, 20]]", "[5]]", r"source\.cut_out\[1\] = \[5\]: two numbers are needed, this is 1 entries"),
        ("geometry", '"0.3 m"', '"-0.3 m"', r"source\.size = '-0\.3 m': this must be above zero"),
    ],
)  # fmt: skip
def test_what_is_refused_of_a_source(folder, kind, old, new, said):
    source, names = SOURCES[kind]
    assert old in source
    with pytest.raises(InputError) as caught:
        parse_ground(case_of(source.replace(old, new), names), folder)
    assert re.search(said, str(caught.value)), str(caught.value)
