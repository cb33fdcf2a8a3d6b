"""The slopes and frames of DICE2D as they are shipped: quick runs within expected.toml; pictures as they are drawn."""

from __future__ import annotations

import runpy
import subprocess
import sys
import tomllib

import pytest
from PIL import Image

from geodem import units
from tests.small_cases import ROOT, environment, result_of

WORKFLOWS = ROOT / "workflows"
NAMES = ("rock_slope", "bolted_slope", "frame_on_rock", "frame_over_cavern")


@pytest.mark.parametrize("name", NAMES)
def test_the_quick_form_checks_itself(name, tmp_path):
    command = [sys.executable, str(WORKFLOWS / name / "run.py"), str(tmp_path / "out"), "--quick"]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = result_of(tmp_path / "out")
    assert found["status"] == "done"
    assert found["quick"]
    assert found["particles"] == pytest.approx(2500, rel=0.05)
    # the strength of the ground stays: forces of contacts grow with the particles
    case = tomllib.loads((tmp_path / "out" / "case.toml").read_text())
    own = tomllib.loads((WORKFLOWS / name / "case.toml").read_text())
    first = next(iter(own["material"]))
    forces = [units.parse(each["material"][first]["cohesion"], "force", place=first) for each in (case, own)]
    assert forces[0] / forces[1] == pytest.approx(found["diameter_m"] / 5.0, rel=1e-6)


@pytest.mark.parametrize(("script", "option", "plain", "other", "pixels"), [
    ("rock_slope", "bolted", "rock_slope", "bolted_slope", 10_951),
    ("frame_on_rock", "cavern", "frame_on_rock", "frame_over_cavern", 9_129),
])  # fmt: skip
def test_the_pictures_are_those_that_are_drawn(script, option, plain, other, pixels, tmp_path):
    draw = runpy.run_path(str(WORKFLOWS / script / "draw.py"), run_name="imported")["draw"]
    for name, chosen in ((plain, False), (other, True)):
        draw(tmp_path / "section.png", **{option: chosen})
        with Image.open(tmp_path / "section.png") as new, Image.open(WORKFLOWS / name / "section.png") as old:
            assert new.convert("RGB").tobytes() == old.convert("RGB").tobytes()
            if not chosen:
                # as many particles as the book has
                ground = sum(count for count, colour in old.getcolors() if colour != (255, 255, 255))
                assert ground == pytest.approx(pixels, rel=1e-3)
