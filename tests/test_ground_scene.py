"""A case of ground that says what holds, cuts and reinforces it: told, drawn, kept and drawn again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geodem import run_case
from geodem.case.ground_reading import load_ground
from geodem.errors import InputErrors
from geodem.ground_check import check_ground
from geodem.ground_run import redraw_ground

CASE = """
workflow = "ground"
title = "Slope over a fault"
[source]
regions = [{material = "rock", polygon = [[0, 0], [20, 0], [20, 6], [14, 6], [10, 10], [0, 10]]}]
[particles]
particles = 800
[material.rock]
law = "rock"
density = "2600 kg/m3"
effective_modulus = "10 GPa"
stiffness_ratio = 2.0
tensile_strength = "10 MPa"
shear_strength = "30 MPa"
friction_coefficient = 0.6
[[joint]]
name = "fault"
points = [[0, 2], [20, 5]]
friction_angle = "30 deg"
normal_stiffness = "20 GPa/m"
[[bolt]]
name = "anchor"
from = [12, 8]
to = [7, 4]
count = 2
step = [0.5, -0.5]
axial_stiffness = "100 MN"
grout_stiffness = "100 MPa"
plate = true
[initial_stress]
k0 = 0.5
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def test_a_run_tells_and_draws_what_is_in_the_ground(case, tmp_path):
    result = run_case(case, tmp_path / "out")
    scene = result["scene"]
    assert [entry["side"] for entry in scene["supports"]] == ["left", "right", "bottom", "top"]
    assert scene["supports"][2]["support"] == "fixed"
    # sqrt(20^2 + 3^2)
    assert scene["joints"][0]["size_m"] == pytest.approx(20.2237, rel=1e-4)
    assert [entry["name"] for entry in scene["bolts"]] == ["anchor 1", "anchor 2"]
    # sqrt(5^2 + 4^2)
    assert scene["bolts"][0]["length_m"] == pytest.approx(6.4031, rel=1e-4)
    weight = 2600.0 * 9.81
    assert scene["initial_stress"]["pressure_at_bottom_Pa"][1][1] == pytest.approx(10.0 * weight)
    assert (tmp_path / "out" / "figures" / "scene.png").stat().st_size > 20_000
    html = (tmp_path / "out" / "report.html").read_text()
    for words in ("joint fault", "bolt anchor 1", "rollers (", "initial stress"):
        assert words in html
    # the case as it was run gives the same scene, and the report can be drawn from what is there
    again = load_ground(tmp_path / "out" / "case.toml")
    assert again.scene is not None
    assert again.as_run_text() == (tmp_path / "out" / "case.toml").read_text()
    redraw_ground(tmp_path / "out", again)
    assert "joint fault" in (tmp_path / "out" / "report.html").read_text()
    assert json.loads((tmp_path / "out" / "result.json").read_text())["scene"] == scene


def test_check_lists_joints_bolts_and_sides(case, tmp_path):
    from rich.console import Console

    console = Console(record=True, width=200)
    check_ground(load_ground(case), tmp_path / "check.png", console)
    told = console.export_text()
    for words in ("Joint fault: 20.22 m", "Bolt anchor 2: 6.403 m", "left rollers", "Initial stress: x"):
        assert words in told
    assert (tmp_path / "check.png").stat().st_size > 20_000


def test_materials_must_be_whole_where_the_ground_is_held(case):
    text = CASE.replace('law = "rock"\n', "")
    case.write_text(text)
    with pytest.raises(InputErrors, match=r"material\.rock\.law: missing"):
        load_ground(case)
