"""Bonded ground in a case file: read, every mistake told at once, written back, built."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from geodem.breaking.materials import LooseMaterial
from geodem.case.document import parse_document
from geodem.case.scene import SceneCase
from geodem.case.scene_reading import SCENE_KEYS, read_scene, scene_head, scene_lines
from geodem.case.table import Findings, Table
from geodem.errors import InputError
from geodem.laboratory.material import BondedMaterial
from geodem.scene_building import make_scene

ROCK = """
[material.rock]
law = "rock"
density = "2600 kg/m3"
effective_modulus = "10 GPa"
stiffness_ratio = 2.0
tensile_strength = "10 MPa"
shear_strength = "30 MPa"
friction_coefficient = 0.6
"""
BOX = '[source]\nbox = ["20 m", "10 m"]\n[particles]\nparticles = 600\n'
ALL = f"""
grain_bonds = 0.5
[source]
length_unit = "cm"
regions = [
  {{material = "rock", polygon = [[0, 0], [2000, 0], [2000, 1000], [0, 1000]]}},
  {{material = "seam", polygon = [[0, 400], [2000, 500], [2000, 600], [0, 500]]}},
]
[particles]
particles = 1200
{ROCK}
[material.seam]
law = "rock"
unit_weight = "21 kN/m3"
effective_modulus = "1 GPa"
stiffness_ratio = 2.0
tensile_strength = "1 MPa"
shear_strength = "3 MPa"
friction_coefficient = 0.6
strength_variation = 0.2
[material.gouge]
bonds = "none"
density = "2000 kg/m3"
contact = {{effective_modulus = "0.1 GPa", stiffness_ratio = 2.0, friction_coefficient = 0.3}}
[[interface]]
between = ["rock", "seam"]
strength = 0.5
contact = {{friction_coefficient = 0.2}}
[[fault]]
material = "gouge"
thickness = "0.8 m"
points = [[1200, 0], [1500, 1000]]
[[joint]]
name = "j1"
centre = ["5 m", 200]
angle = "20 deg"
radius = "3 m"
friction_angle = "30 deg"
normal_stiffness = "20 GPa/m"
[[joint_set]]
name = "bedding"
angle = "70 deg"
spacing = "4 m"
trace = "2 m"
persistence = "50 %"
angle_scatter = "5 deg"
cohesion = "1 MPa"
friction_angle = "30 deg"
normal_stiffness = "20 GPa/m"
seed = 3
[[bolt]]
name = "roof"
from = [400, 1000]
to = [400, 600]
step = [200, 0]
count = 3
diameter = "25 mm"
yield_strength = "500 MPa"
grout_stiffness = "100 MPa"
out_of_plane = "2 m"
[[lining]]
name = "slab"
points = [[100, 1060], [900, 1060]]
thickness = "0.3 m"
young_modulus = "20 GPa"
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
[loads]
gravity = ["0.5 m/s2", "-9.81 m/s2"]
[initial_stress]
k0 = 0.7
unit_weight = "25 kN/m3"
surface = "12 m"
"""


def read(text: str) -> tuple[SceneCase | None, Findings]:
    document = parse_document(text)
    findings = Findings(document)
    return read_scene(Table(findings, "", document, SCENE_KEYS), Path(".")), findings


def scene(text: str) -> SceneCase:
    found, findings = read(text)
    assert not findings.errors, findings.errors
    assert found is not None
    return found


def written(case: SceneCase) -> str:
    return "\n".join([*scene_head(case), *scene_lines(case)])


def test_everything_is_read_in_si_and_written_back_to_the_last_bit():
    case = scene(ALL)
    assert case.source.options["regions"][0][1][1] == (20.0, 0.0)
    seam, gouge = case.materials["seam"], case.materials["gouge"]
    assert isinstance(seam, BondedMaterial)
    assert isinstance(gouge, LooseMaterial)
    assert seam.density == pytest.approx(21000.0 / 9.81)
    assert seam.variation == 0.2
    assert gouge.contact["effective_modulus"] == 1e8
    (bolt,) = case.bolts
    area = math.pi * 0.0125**2
    assert bolt.axial_stiffness == pytest.approx(area * 200e9)
    assert bolt.yield_force == pytest.approx(area * 500e6)
    assert bolt.density_per_length == pytest.approx(area * 7850.0)
    # persistence = trace / (trace + gap)
    assert case.joint_sets[0].gap == pytest.approx(2.0)
    assert case.joints[0].place.centre == (5.0, 2.0)
    assert case.gravity == (0.5, -9.81)
    text = written(case)
    again = scene(text)
    assert written(again) == text
    _, findings = read(text)
    assert not [words for words in findings.notices if words.startswith("material")]


def test_the_scene_of_a_case_has_what_the_case_says():
    body, made = make_scene(scene(ALL))
    assert made.materials == ("rock", "seam", "gouge")
    assert made.bonds[("gouge", "rock")].bonds == 0
    assert set(made.structures.joints) == {"j1", "bedding"}
    assert made.structures.joints["j1"].size == pytest.approx(6.0)
    assert set(made.structures.bolts) == {"roof 1", "roof 2", "roof 3"}
    # one bolt every 2 m out of the plane: half of its stiffness in a slice of 1 m
    joints = made.assembly.joints
    assert joints is not None
    row = joints.table[joints.names.index("roof 2 bar")]
    piece = float(np.diff(made.structures.bolts["roof 2"].along)[0])
    assert row[1] == pytest.approx(0.5 * math.pi * 0.0125**2 * 200e9 / piece)
    assert made.initial_stress is not None
    assert made.initial_stress.at(2.0) == pytest.approx(np.diag([-0.7 * 250e3, -250e3]))
    assert made.assembly.gravity.tolist() == [0.5, -9.81]
    assert body.body.dimension == 2


def test_k0_takes_the_weight_of_the_ground():
    case = scene(BOX + ROCK + "[initial_stress]\nk0 = 0.5\n")
    wanted = make_scene(case)[1].initial_stress
    assert wanted is not None
    assert wanted.at(0.0)[1, 1] == pytest.approx(-2600.0 * 9.81 * 10.0)
    assert wanted.at(0.0)[0, 0] == pytest.approx(-0.5 * 2600.0 * 9.81 * 10.0)


def test_components_are_pressures():
    text = BOX + ROCK + '[initial_stress]\nx = "10 MPa"\ny = "5 MPa"\n[boundary]\ntop = "roller"\n'
    wanted = make_scene(scene(text))[1].initial_stress
    assert wanted is not None
    assert wanted.at_top.tolist() == [[-1e7, 0.0], [0.0, -5e6]]


def test_numbers_per_contact_are_forces_and_stiffnesses():
    """As tables of DICE2D give them: N/m and N."""
    text = (
        BOX
        + """
[material.rock]
law = "two_springs"
density = "2500 kg/m3"
normal_stiffness = "1000 MN/m"
shear_stiffness = "4e8 N/m"
tensile_strength = "100 kN"
cohesion = "2e5 N"
friction_coefficient = 0.4
width_ratio = 0.5
"""
    )
    case = scene(text)
    rock = case.materials["rock"]
    assert isinstance(rock, BondedMaterial)
    assert rock.bond["normal_stiffness"] == 1e9
    assert rock.bond["tensile_strength"] == 1e5
    assert rock.contact_law == "linear_frictional"
    assert rock.contact["shear_stiffness"] == 4e8
    assert written(scene(written(case))) == written(case)
    assert make_scene(case)[1].assembly.bond_law == "two_springs"


def test_a_box_in_space_has_six_sides():
    text = (
        '[source]\nbox = ["4 m", "4 m", "4 m"]\n[particles]\nparticles = 300\n'
        + ROCK
        + (
            '[[joint]]\ncentre = [2, 2, 2]\ndip = "30 deg"\ndip_direction = "90 deg"\nfriction_angle = "30 deg"\n'
            'normal_stiffness = "1 GPa/m"\n'
        )
    )
    case = scene(text)
    assert case.boundary["front"] == "roller"
    made = make_scene(case)[1]
    assert set(made.held) == {"left", "right", "front", "back", "bottom"}
    assert made.structures.joints["joint 1"].pairs > 0


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ('box = ["20 m", "10 m"]', 'box = ["20 m"]', "source.box", "two sides"),
        ('box = ["20 m", "10 m"]', "box = [20, 10]", "source.box", "bare number"),
        ('law = "rock"', 'law = "rook"', "material.rock.law", "choices"),
        ('law = "rock"', 'law = {a = 1}', "material.rock.law", "choices"),
        ('tensile_strength = "10 MPa"', 'tensile_strength = "10 kN"', "material.rock.tensile_strength", "stress"),
        ("[particles]", '[boundary]\nfront = "wall"\n[particles]', "boundary.front", "unknown key"),
        ("[particles]", '[boundary]\nleft = "glue"\n[particles]', "boundary.left", "choices"),
        ("[particles]", "[loads]\ngravity = 9.81\n[particles]", "loads.gravity", "bare number"),
        ("[particles]", '[[joint]]\npoints = [[0, 0], [1, 1, 1]]\n[particles]', "joint[0].points[1]", "point"),
        ("[particles]", '[[joint]]\npoints = [[0, 0], [1, 1]]\n[particles]', "joint[0].friction_angle", "missing"),
        ("[particles]", '[[bolt]]\nfrom = [0, 0]\n[particles]', "bolt[0].to", "missing"),
        ("[particles]", "[[bolt]]\ncount = 1000000000\n[particles]", "bolt[0].count", "10,000 at most"),
        ("[particles]", '[[bolt]]\ndiameter = "25 m"\n[particles]', "bolt[0].diameter", "1 mm to 0.5 m"),
        ("[particles]", '[[lining]]\nthickness = "0.01 mm"\n[particles]', "lining[0].thickness", "1 mm to 5 m"),
        ("[particles]", '[[lining]]\nthickness = "1 m"\n[particles]', "lining[0].young_modulus", "missing"),
        ("[particles]", '[[interface]]\nbetween = ["rock", "x"]\n[particles]', "interface[0].between", "no [material"),
        ("[particles]", '[initial_stress]\nk0 = 1.0\nx = "1 MPa"\n[particles]', "initial_stress", "both"),
        ("[particles]", '[initial_stress]\nx = "1 MPa"\nz = "1 MPa"\n[particles]', "initial_stress.z", "2D"),
        ("[particles]", '[[fault]]\nmaterial = "gouge"\nthickness = "1 m"\npoints = [[0, 0], [9, 9]]\n[particles]',
         "material.gouge", "missing"),
    ],
)  # fmt: skip
def test_mistakes_name_their_place(old, new, place, words):
    text = (BOX + ROCK).replace(old, new)
    assert text != BOX + ROCK
    found, findings = read(text)
    assert found is None
    named = [str(error) for error in findings.errors if error.place.startswith(place)]
    assert named, [error.place for error in findings.errors]
    assert any(words in each for each in named), named


@pytest.mark.parametrize("material", ["3", "[{}]", '[{name = "rock"}]'])
def test_materials_that_are_no_tables_are_told(material):
    interface = '[[interface]]\nbetween = ["rock", "x"]\n[[bolt]]\nname = "b"\nfrom = [0, 0]\nto = [1, 1]\n'
    found, findings = read(f"material = {material}\n{BOX}{interface}")
    assert found is None
    assert any("a table is needed here" in str(error) for error in findings.errors), findings.errors


def test_all_mistakes_are_told_at_once():
    wrong = (
        (BOX + ROCK).replace('"20 m"', '"20 kg"').replace("2600 kg/m3", "2600 kg").replace("0.6", '"30 deg"')
    )
    assert len(read(wrong)[1].errors) == 3


@pytest.mark.parametrize(
    ("table", "match"),
    [
        (
            '[[bolt]]\nfrom = [0, 30]\nto = [0, 25]\naxial_stiffness = "1 MN"\ngrout_stiffness = "1 MPa"\n',
            "misses",
        ),
        (
            '[[joint]]\npoints = [[0, 30], [9, 30]]\nfriction_angle = "30 deg"\nnormal_stiffness = "1 GPa/m"\n',
            "passes",
        ),
        (
            '[[lining]]\ncentre = [50, 50]\nradius = "2 m"\nthickness = "0.3 m"\nyoung_modulus = "20 GPa"\n',
            "no ground",
        ),
    ],
)
def test_what_misses_the_ground_is_told_when_it_is_built(table, match):
    with pytest.raises(InputError, match=match):
        make_scene(scene(BOX + ROCK + table))
