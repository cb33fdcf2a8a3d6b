"""`geodem lab` and `geodem calibrate` as a newcomer meets them."""

from __future__ import annotations

import re

import pytest
from PIL import Image

from tests.laboratory_cases import CALIBRATION, LABORATORY, TENSION, write_case
from tests.small_cases import SLOPE, geodem, result_of

ROCK = {
    "--young-modulus": "69 GPa",
    "--poisson-ratio": "0.26",
    "--compressive-strength": "200 MPa",
    "--tensile-strength": "9.3 MPa",
    "--friction-angle": "55 deg",
    "--density": "2630 kg/m3",
}


def options(**changed: str) -> list[str]:
    rock = ROCK | {f"--{name.replace('_', '-')}": value for name, value in changed.items()}
    return [text for option in rock.items() for text in option]


@pytest.mark.parametrize("kind", ["laboratory", "calibration"])
def test_new_then_check_the_template(tmp_path, call, kind):
    folder = tmp_path / "mine"
    made = call("new", kind, folder)
    assert made.status == 0, made.err
    assert f"geodem check {folder}" in made.out
    if kind == "calibration":
        return  # its check needs the map; tests/test_calibration_run.py has one
    looked = call("check", folder, "--out", tmp_path / "look.png")
    assert looked.status == 0, looked.err
    assert re.search(
        r"Specimen: 50 mm x 100 mm, 3,\d{3} particles \(random, seed 1\), 4\d(\.\d)? across", looked.out
    )
    assert re.search(r"Expected time: .* with \d+ tests at a time", looked.out)
    assert "Tests: 4 of uniaxial-compression" in looked.out
    with Image.open(tmp_path / "look.png") as picture:
        assert min(picture.size) > 200


def test_lab_run_resume_plot(tmp_path):
    """As a program, where there is no terminal."""
    case, out = write_case(tmp_path / "case", TENSION.replace("seeds = 6", "seeds = 2")), tmp_path / "out"
    done = geodem("lab", case, "--out", out, "--quick", "--threads", 1)
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout
    assert re.search(
        r"^direct-tension: [\d.]+ MPa, cracks \d+ in tension, \d+ in shear, [\d,]+ steps, [\d.]+ s\n"
        r"  1 of 2 tests finished, about \d[.\d]* (s|min) left\n",
        done.stdout,
        re.MULTILINE,
    ), done.stdout
    strength = result_of(out)["properties"]["tensile_strength_Pa"]
    assert f"Direct tensile strength {strength['mean'] / 1e6:.3g} MPa" in done.stdout
    assert f"{out}/report.html" in done.stdout
    digest = result_of(out)["digest"]
    (out / "tests" / "direct-tension-4.h5").unlink()
    again = geodem("resume", out)
    assert again.returncode == 0, again.stderr
    assert result_of(out)["digest"] == digest
    (out / "report.html").unlink()
    drawn = geodem("plot", out)
    assert drawn.returncode == 0, drawn.stderr
    assert (out / "report.html").is_file()


@pytest.mark.parametrize(
    ("command", "text", "said"),
    [
        ("lab", SLOPE, r"workflow = 'slope'.*kind laboratory.*geodem run"),
        ("lab", CALIBRATION, r"workflow = 'calibration'.*geodem calibrate"),
        ("calibrate", LABORATORY, r"workflow = 'laboratory'.*geodem lab"),
        ("lab", LABORATORY.replace("direct-tension", "direct-tention"), r"Did you mean .direct-tension"),
        ("lab", LABORATORY.replace('"15 MPa"', "15"), r"material\.tensile_strength = 15: a bare number"),
        ("calibrate", CALIBRATION.replace('"6.5 MPa"', '"65 MPa"'), r"rock\.tensile_strength.*at most"),
    ],
)
def test_a_mistake_ends_with_a_message_and_writes_nothing(tmp_path, call, command, text, said):
    out = tmp_path / "out"
    answer = call(command, write_case(tmp_path / "case", text), "--out", out)
    assert answer.status == 2
    assert re.search(said, answer.err.replace("\n", " ")), answer.err
    assert not out.exists()


def test_a_rock_by_options(tmp_path, call):
    out = tmp_path / "out"
    missing = call("calibrate", "--young-modulus", "69 GPa", "--out", out)
    assert missing.status == 2
    assert "rock.tensile_strength: missing" in missing.err
    unit = call("calibrate", *options(young_modulus="69"), "--out", out)
    assert unit.status == 2
    assert "rock.young_modulus = '69': the unit is missing" in unit.err
    contradicts = call("calibrate", *options(tensile_strength="40 MPa"), "--out", out)
    assert contradicts.status == 2
    assert "rock.tensile_strength" in contradicts.err
    nowhere = call("calibrate", *options())
    assert nowhere.status == 2
    assert "--out" in nowhere.err
    both = call("calibrate", write_case(tmp_path / "case", CALIBRATION), *options(), "--out", out)
    assert both.status == 2
    assert "by a case and by options" in both.err
    assert not out.exists()
