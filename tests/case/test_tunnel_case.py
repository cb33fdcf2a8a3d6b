"""Tunnel cases: what is read, what is refused and with which remedy, and the way back to text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geodem.case.tunnel_reading import parse_tunnel
from geodem.errors import InputErrors
from geodem.tunnel_building import build_tunnel
from geodem.tunnelling.plan import DepthStress, UniformStress

HERE = Path(__file__).parents[2] / "geodem" / "templates" / "tunnel"
TEMPLATE = (HERE / "case.toml").read_text()

SMALL = """
workflow = "tunnel"
title = "small"
particles = 900
wall_spacing = "0.5 m"
increments = 4
section.regions = [{material = "clay", polygon = [[-15, -10], [15, -10], [15, 12], [-15, 12]]}]
boundary = {left = "roller", right = "roller", bottom = "fixed"}
initial_stress.k0 = 0.7
excavation = [{name = "tunnel", circle = {centre = [0, 0], diameter = "4 m"}}]
stage = [{excavate = "tunnel", relax = 0.5}, {install = "shell"}, {relax = 1.0}]
lining = [{name = "shell", thickness = "20 cm", young_modulus = "15 GPa"}]

[material.clay]
law = "mohr_coulomb"
unit_weight = "20 kN/m3"
cohesion = "60 kPa"
friction_angle = "20 deg"
dilation_angle = "20 deg"
young_modulus = "50 MPa"
poisson_ratio = 0.3
tensile_strength = "none"
"""


def errors_of(text: str) -> list[str]:
    with pytest.raises(InputErrors) as caught:
        parse_tunnel(text, HERE)
    return [f"{error.place}: {error.problem}. {error.remedy}" for error in caught.value.errors]


def changed(old: str, new: str, text: str = SMALL) -> str:
    assert old in text
    return text.replace(old, new)


def test_the_template_is_read_in_si_units():
    case = parse_tunnel(TEMPLATE, HERE)
    assert case.initial == DepthStress(0.7)
    assert [stage.relax for stage in case.stages] == [0.4, None, 1.0]
    (lining,) = case.linings
    assert (lining.thickness, lining.young_modulus, lining.compressive_strength) == (0.25, 15e9, 30e6)
    (bolts,) = case.plan().bolts
    assert bolts.area == pytest.approx(np.pi * 0.025**2 / 4.0)
    assert (bolts.yield_force, bolts.spacing, bolts.grout_strength) == (200e3, 1.5, 200e3)
    # the bolt upwards begins on the crown, 8 m above the floor, and is 4 m long
    assert np.allclose(bolts.bars[2], [(0.0, 4.0), (0.0, 8.0)], atol=1e-6)


def test_text_as_run_reads_back_to_the_same_numbers():
    for text in (TEMPLATE, SMALL, changed("initial_stress.k0 = 0.7", UNIFORM)):
        case = parse_tunnel(text, HERE)
        again = parse_tunnel(case.as_run_text(), HERE)
        assert again.as_run_text() == case.as_run_text()
        assert again.plan().stages == case.plan().stages
        assert again.plan().linings == case.plan().linings
        assert again.plan().bolts == case.plan().bolts
        assert again.initial == case.initial


UNIFORM = 'initial_stress = {horizontal = "2 MPa", vertical = "3 MPa", shear = "100 kPa"}'


def test_a_uniform_stress_says_that_weight_is_left_out():
    case = parse_tunnel(changed("initial_stress.k0 = 0.7", UNIFORM), HERE)
    assert case.initial == UniformStress(2e6, 3e6, 1e5)
    assert any("weight" in notice and "left out" in notice for notice in case.notices)


def test_shapes_have_the_areas_of_the_textbook():
    """Circle pi d^2/4; horseshoe: half a circle over straight walls."""
    case = parse_tunnel(TEMPLATE, HERE)
    assert case.plan().openings[0].polygon.area == pytest.approx(np.pi * 4.5**2 / 2.0 + 9.0 * 3.5, rel=1e-4)
    circle = parse_tunnel(SMALL, HERE).plan().openings[0]
    assert circle.polygon.area == pytest.approx(np.pi * 4.0, rel=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("{install = \"shell\"}, {relax = 1.0}", "{relax = 1.0}", "stage", "no stage installs"),
        (
            '{excavate = "tunnel", relax = 0.5}, {install = "shell"}',
            '{install = "shell"}, {excavate = "tunnel", relax = 0.5}',
            "stage[0].install", "not excavated yet",
        ),
        ("{relax = 1.0}", "{relax = 0.3}", "stage[2].relax", "do not come back"),
        ("relax = 0.5", "relax = 1.5", "stage[0].relax", "between 0 and 1"),
        ('install = "shell"', 'install = "shel"', "stage[1].install", 'Did you mean "shell"'),
        ('thickness = "20 cm"', "thickness = 20", "lining[0].thickness", "unit"),
        ("initial_stress.k0 = 0.7\n", "", "initial_stress", "missing"),
        ('bottom = "fixed"', 'bottom = "free"', "boundary.bottom", "nothing carries the weight"),
        ('left = "roller"', 'left = "far"', "boundary.left", "uniform stress"),
        ('diameter = "4 m"}}', 'diameter = "4 m"}, polygon = [[0,0],[1,0],[1,1]]}', "excavation[0]", "exactly one"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_remedy(old, new, place, words):
    found = errors_of(changed(old, new))
    assert any(error.startswith(place) and words in error for error in found), found


def test_what_looks_mistaken_is_refused_without_errors_that_follow_from_it():
    (error,) = errors_of(changed('thickness = "20 cm"', 'thickness = "20 m"'))
    assert error.startswith(
        "lining[0].thickness: no lining is as thick or thin as this. Usual are 1 mm to 5 m"
    )
    (error,) = errors_of(changed("increments = 4", "increments = 1000000000"))
    assert error.startswith("increments: so many take days")


def test_all_errors_come_at_once():
    text = changed("relax = 0.5", "relax = 1.5", changed('thickness = "20 cm"', 'thickness = "-1 m"'))
    assert len(errors_of(text)) >= 2


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("centre = [0, 0]", "centre = [40, 0]", "excavation[0]", "outside the ground"),
        ("centre = [0, 0]", "centre = [0, 11]", "excavation[0]", "reaches over the top side"),
        (
            '{name = "tunnel", circle = {centre = [0, 0], diameter = "4 m"}}',
            '{name = "tunnel", circle = {centre = [0, 0], diameter = "4 m"}}, '
            '{name = "other", circle = {centre = [3, 0], diameter = "4 m"}}',
            "excavation[1]", "overlaps",
        ),
    ],
)  # fmt: skip
def test_openings_must_lie_in_the_ground(old, new, place, words):
    text = changed(old, new)
    if "other" in new:
        text = changed("{relax = 1.0}", '{excavate = "other"}, {relax = 1.0}', text)
        text = changed('{name = "shell",', '{name = "shell", excavation = "tunnel",', text)
    with pytest.raises(InputErrors) as caught:
        build_tunnel(parse_tunnel(text, HERE))
    assert any(e.place == place and words in e.problem for e in caught.value.errors), caught.value.errors


@pytest.mark.parametrize(
    ("bars", "words"),
    [("[[[0, 2], [0, 30]]]", "the outside of the ground"), ("[[[0, 7], [0, 9]]]", "not on a wall")],
)
def test_bolts_must_lie_in_the_ground(bars, words):
    bolt = (
        f'bolt = [{{name = "b", bars = {bars}, diameter = "25 mm", yield_force = "1 kN", spacing = "1 m"}}]\n'
    )
    text = changed("\n[material.clay]", f"{bolt}\n[material.clay]")
    text = changed('{install = "shell"}', '{install = ["shell", "b"]}', text)
    with pytest.raises(InputErrors) as caught:
        build_tunnel(parse_tunnel(text, HERE))
    assert any(e.place == "bolt[0]" and words in e.problem for e in caught.value.errors)


def test_half_a_tunnel_on_a_line_of_symmetry_is_cut_there():
    text = changed("[[-15, -10], [15, -10], [15, 12], [-15, 12]]", "[[0, -10], [15, -10], [15, 12], [0, 12]]")
    ground, _ = build_tunnel(parse_tunnel(text, HERE))
    assert ground.openings[0].polygon.area == pytest.approx(np.pi * 2.0, rel=1e-3)


def test_a_picture_is_dug_into_as_polygons_are(tmp_path):
    """22 m by 30 m at 0.25 m a pixel: clay over rock, the tunnel through both."""
    from PIL import Image

    picture = Image.new("RGB", (120, 88), "#8c6d31")
    picture.paste("#5f7f9f", (0, 44, 120, 88))
    picture.save(tmp_path / "section.png")
    regions = (
        'section.regions = [{material = "clay", polygon = [[-15, -10], [15, -10], [15, 12], [-15, 12]]}]'
    )
    image = (
        'section = {image = "section.png", scale = "0.25 m/px", origin = [-15, -11], '
        'legend = {"#8c6d31" = "clay", "#5f7f9f" = "rock"}}'
    )
    text = changed(regions, image)
    clay = text[text.index("[material.clay]") :]
    text = changed("particles = 900", "particles = 1000", text)
    case = parse_tunnel(text + clay.replace("material.clay", "material.rock"), tmp_path)
    ground, plan = build_tunnel(case)
    assert set(ground.material_of) == {"clay", "rock"}
    inside = [m for m, o in zip(ground.material_of, ground.opening_of, strict=True) if o == 0]
    assert sorted(inside) == ["clay", "rock"]
    assert case.beside()[1] == {"section.png": tmp_path / "section.png"}
    assert plan.openings[0].name == "tunnel"
