"""Cases of run-out from the file to the folder; stopped, resumed, drawn again, checked."""

from __future__ import annotations

import csv
import json
import math
import shutil

import numpy as np
import pytest

from geodem.case.runout import parse_runout
from geodem.errors import InputError, StoppedError
from geodem.io.history import HistoryWriter
from geodem.runout_run import redraw_runout, resume_runout, run_runout
from tests.small_cases import forecast_error, geodem, history_begun, works_of

TEXT = """
workflow = "runout"
title = "Cut in silt"
particles = 300
tolerance = 0.1
seed = 3
[section]
length_unit = "m"
regions = [{material = "silt", polygon = [[0,0],[24,0],[24,4],[16,4],[8,12],[0,12]]}]
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
[material.silt]
law = "mohr_coulomb"
density = "1900 kg/m3"
cohesion = "2 kPa"
friction_angle = "25 deg"
dilation_angle = "25 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
[runout]
start = "failing"
discs = 150
beyond = "12 m"
residual_friction_angle = "16 deg"
"""


@pytest.fixture(scope="module")
def told():
    """What the whole run tells."""
    return []


@pytest.fixture(scope="module")
def whole(told, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "out"
    return folder, run_runout(parse_runout(TEXT, folder.parent), folder, watch=told.append)


def test_the_work_left_is_told_within_a_fifth_of_all(whole, told):
    assert forecast_error(works_of(update for update in told if update.stage == "flow")) < 0.2


def test_the_hand_over_keeps_what_it_must(whole):
    _, result = whole
    for row in result["hand_over"]["conserved"]:
        if "energy" not in row["name"]:
            assert row["error"] < 1e-10, row["name"]
    assert result["hand_over"]["energy_jump"] < 0.01
    moved = result["moved"]
    assert moved["mass_kg_m"] == pytest.approx(1900.0 * moved["area_m2"], rel=1e-9)
    assert any(
        row["name"] == "kinetic energy" and row["before"] > 0.0 for row in result["hand_over"]["conserved"]
    )


def test_the_mass_runs_out_and_comes_to_rest(whole):
    folder, result = whole
    deposit, flow = result["deposit"], result["flow"]
    assert flow["at_rest"]
    assert deposit["run_out_m"] > 0.0
    # a sliding block travels down at its friction angle; a mass that is deformed loses more
    assert 16.0 < deposit["travel_angle_deg"] < 45.0
    angle = math.degrees(math.atan2(deposit["fall_height_m"], deposit["reach_m"]))
    assert deposit["angle_of_reach_deg"] == pytest.approx(angle)
    with (folder / "history.csv").open() as file:
        rows = list(csv.DictReader(file))
    terms = ("kinetic", "potential", "elastic", "dissipated")
    energy = np.array([[float(row[f"{name} energy [J/m]"]) for name in terms] for row in rows])
    assert energy.sum(axis=1) == pytest.approx(energy[0].sum(), rel=1e-12)
    assert energy[-1, 3] > 0.0
    assert float(rows[-1]["front [m]"]) == pytest.approx(deposit["front_m"])
    assert float(rows[-1]["centre of gravity, y [m]"]) < float(rows[0]["centre of gravity, y [m]"])


def test_the_folder_holds_what_is_told(whole):
    folder, result = whole
    for name in ("report.html", "case.toml", "history.csv", "discs-000000.vtkhdf"):
        assert (folder / name).is_file()
    for name in ("before", "during", "after", "history"):
        assert (folder / "figures" / f"{name}.png").stat().st_size > 10_000
    page = (folder / "report.html").read_text()
    assert f"Run-out {result['deposit']['run_out_m']:.3g} m" in page
    assert "angular momentum" in page
    assert "pore water is not modelled" in page


def test_a_stopped_run_ends_with_the_same_bits(whole, tmp_path):
    folder = tmp_path / "out"
    seen = []

    def stop_in_flow() -> bool:
        return sum(update.stage == "flow" for update in seen) > 6

    case = parse_runout(TEXT, tmp_path)
    with pytest.raises(StoppedError):
        run_runout(case, folder, watch=seen.append, stop_asked=stop_in_flow)
    assert json.loads((folder / "result.json").read_text())["status"] == "stopped"
    assert history_begun(folder, whole[0])
    again = parse_runout((folder / "case.toml").read_text(), folder)
    result = resume_runout(folder, again)
    assert result["digest"] == whole[1]["digest"]
    assert result["deposit"] == whole[1]["deposit"]
    assert (folder / "history.csv").read_bytes() == (whole[0] / "history.csv").read_bytes()


def test_what_is_done_is_not_run_again_and_can_be_drawn_again(whole):
    folder, result = whole
    case = parse_runout((folder / "case.toml").read_text(), folder)
    assert run_runout(case, folder, stop_asked=lambda: True) == result
    before = (folder / "figures" / "after.png").read_bytes()
    (folder / "report.html").unlink()
    assert redraw_runout(folder, case) == folder / "report.html"
    assert (folder / "figures" / "after.png").read_bytes() == before


def test_the_history_is_written_whole(whole, tmp_path, monkeypatch):
    """Never line by line under its own name, where a run that is killed would leave half of it."""
    folder = tmp_path / "out"
    shutil.copytree(whole[0], folder)
    (folder / "report.html").unlink()
    monkeypatch.setattr(HistoryWriter, "write", lambda self, *values: pytest.fail("line by line"))
    run_runout(parse_runout((folder / "case.toml").read_text(), folder), folder)
    assert (folder / "history.csv").read_bytes() == (whole[0] / "history.csv").read_bytes()


def test_a_folder_of_another_case_is_left_alone(whole, tmp_path):
    folder, _ = whole
    other = parse_runout(TEXT.replace("discs = 150", "discs = 160"), tmp_path)
    with pytest.raises(InputError, match="another case"):
        run_runout(other, folder)


def test_check_tells_what_a_run_will_cost(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where the picture goes
    path = tmp_path / "case.toml"
    path.write_text(TEXT)
    done = geodem("check", path)
    assert done.returncode == 0, done.stderr
    assert "150 discs" in done.stdout
    assert not (tmp_path / "result.json").exists()


def test_errors_come_with_exit_status_2(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(TEXT.replace('"16 deg"', '"50 deg"'))
    done = geodem("run", path, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "runout.residual_friction_angle" in done.stderr
    assert not (tmp_path / "out").exists()
