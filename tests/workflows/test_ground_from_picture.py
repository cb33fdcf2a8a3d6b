"""The workflow as it is shipped: areas and masses of the drawing, which `geodem new ground` copies."""

from __future__ import annotations

import runpy
import subprocess
import sys
import tomllib
from math import pi, sin

import pytest
import shapely
from PIL import Image

from tests.small_cases import ROOT, environment, geodem, result_of

WORKFLOW = ROOT / "workflows" / "ground_from_picture"
EXPECTED = tomllib.loads((WORKFLOW / "expected.toml").read_text())


@pytest.fixture(scope="module")
def drawn():
    return runpy.run_path(str(WORKFLOW / "draw.py"), run_name="imported")


def test_it_checks_itself(tmp_path):
    command = [sys.executable, str(WORKFLOW / "run.py"), str(tmp_path / "out")]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{tmp_path}/out/report.html" in done.stdout
    found = result_of(tmp_path / "out")
    assert found["particles"] == pytest.approx(8000, rel=0.01)
    again = geodem("run", tmp_path / "out", "--out", tmp_path / "again", "--threads", 1)
    assert again.returncode == 0, again.stderr
    assert result_of(tmp_path / "again")["digest"] == found["digest"]


def test_the_expected_areas_are_those_of_the_polygons(drawn):
    wide = drawn["WIDTH"]
    fill, clay, rock = (
        shapely.Polygon([*drawn[name], (wide, 0.0), (0.0, 0.0)])
        for name in ("FILL_TOP", "CLAY_TOP", "ROCK_TOP")
    )
    boulders = sum(24.0 * sin(pi / 24.0) * a * b for _, _, a, b, _ in drawn["BOULDERS"])
    areas = {
        "rock": rock.area, "clay": clay.difference(rock).area, "boulder": boulders,
        "gravel": fill.difference(clay).area - boulders,
    }  # fmt: skip
    assert {name: EXPECTED["areas"][name] for name in areas} == pytest.approx(areas, abs=1e-3)


def test_the_picture_is_the_one_that_is_drawn(drawn, tmp_path):
    drawn["draw"](tmp_path / "section.png")
    template = ROOT / "geodem" / "templates" / "ground" / "section.png"
    with Image.open(tmp_path / "section.png") as new:
        for path in (WORKFLOW / "section.png", template):
            with Image.open(path) as old:
                assert new.convert("RGB").tobytes() == old.convert("RGB").tobytes()
