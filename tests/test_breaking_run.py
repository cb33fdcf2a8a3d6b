"""A case of breaking ground through the whole chain: folder, result, stop and resume to the same bits, command."""

from __future__ import annotations

import csv
import json
import math
import shutil

import numpy as np
import pytest

from geodem.breaking_run import redraw_breaking, resume_breaking, run_breaking
from geodem.case.breaking_reading import parse_breaking
from geodem.errors import StoppedError
from geodem.io.history import HistoryWriter
from tests.small_cases import forecast_error, geodem, history_begun, works_of

# a beam that hangs out 8 m breaks at its root: 6 M/h2 = 1.6 MPa at 1 g, were it a slender one
CASE = """\
workflow = "breaking"
title = "Overhang"

[source]
regions = [{material = "rock", polygon = [[0, 0], [16, 0], [16, 2], [5, 2], [5, 8], [13, 8], [13, 11], [0, 11]]}]

[particles]
particles = 240
arrangement = "hexagonal"

[material.rock]
law = "rock"
density = "2500 kg/m3"
effective_modulus = "1 GPa"
stiffness_ratio = 2.0
tensile_strength = "5 MPa"
shear_strength = "15 MPa"
friction_coefficient = 0.5

[boundary]
left = "wall"
right = "wall"
bottom = "wall"

[[point]]
name = "tip"
at = [12.5, 10.5]

[[stage]]
kind = "settle"
rest = 1e-3

[[stage]]
kind = "gravity-increase"
tolerance = 0.3
rest = 1e-3

[[stage]]
kind = "excavate"
name = "undercut"
polygon = [[3, 2.5], [6, 2.5], [6, 5], [3, 5]]
shares = 2
come_to_rest = false

[[stage]]
kind = "run"
name = "fall"
time = "0.4 s"
frames_every = "0.2 s"
"""


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    return parse_breaking(CASE, tmp_path_factory.mktemp("case"))


@pytest.fixture(scope="module")
def told():
    """What the whole run tells."""
    return []


@pytest.fixture(scope="module")
def done(case, told, tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "out"
    return out, run_breaking(case, out, threads=1, watch=told.append)


def test_the_work_left_is_told(done, told):
    """A beam that hangs out comes to rest far more slowly than other ground; that is breaking/test_forecast's."""
    works = works_of(told)
    assert forecast_error(works) < 0.3
    assert forecast_error(works, after=0.5) < 0.2
    whole = works[-1].done
    assert all(work.done + work.most >= whole for work in works if not math.isnan(work.most))


def test_the_folder_holds_everything(done):
    out, result = done
    for name in ("result.json", "report.html", "history.csv", "case.toml", "figures/materials.png"):
        assert (out / name).is_file(), name
    frames = sorted((out / "frames").glob("particles-*.vtkhdf"))
    # one at the end of every stage, one in the middle of the last
    assert len(frames) == 5 - 1
    assert json.loads((out / "result.json").read_text())["digest"] == result["digest"]
    html = (out / "report.html").read_text()
    for words in ("Gravity factor", "not a factor of safety", "undercut", "Case file"):
        assert words in html


def test_the_result_tells_what_was_found(done):
    _, result = done
    (factor,) = result["factors"]
    assert factor["kind"] == "gravity-increase"
    assert factor["stable"] < factor["value"] < factor["failed"]
    assert "diameters" in factor["criterion"] or "still moving" in factor["criterion"]
    failure = factor["failure"]
    assert failure["new_cracks"] > 0
    # at the root of the beam, from its upper side down
    x, y = failure["first_centre_m"]
    assert 3.0 < x < 7.0
    assert 7.5 < y < 11.0
    assert [stage["kind"] for stage in result["stages"]] == ["settle", "gravity-increase", "excavate", "run"]
    cut = result["stages"][2]
    assert cut["particles_removed"] == result["particles"] - result["particles_left"] > 0
    by_pair = result["cracks"]["by_materials"]
    assert sum(row["tension"] + row["shear"] for row in by_pair) == sum(
        result["cracks"][mode] for mode in ("tension", "shear")
    )
    assert abs(result["energy"]["imbalance"]) < 1e-2
    # the floor bears what is there: the settled ground was at rest, and part of it is gone
    assert result["points"][0]["displacement_m"][1] < 0.0


def test_the_history_has_every_stage_and_trial(done):
    out, result = done
    with (out / "history.csv").open() as file:
        rows = list(csv.reader(file))
    head, lines = rows[0], np.array([[float(x) for x in row] for row in rows[1:]])
    assert all(name.endswith("]") for name in head)
    assert set(lines[:, 0]) == {1.0, 2.0, 3.0, 4.0}
    tried = {round(factor, 5) for factor in lines[:, 1] if not np.isnan(factor)}
    assert tried == {trial["factor"] for trial in result["factors"][0]["trials"]}
    bottom = lines[lines[:, 0] == 1.0][-1, head.index("force on bottom, y [N/m]")]
    area = 16 * 2 + 5 * 6 + 13 * 3
    assert -bottom == pytest.approx(2500 * 9.81 * area, rel=0.02)


def test_a_run_that_is_stopped_again_and_again_ends_with_the_same_bits(case, done, tmp_path):
    _, whole = done
    looks = iter(range(10**9))

    def every_so_often() -> bool:
        return next(looks) % 91 == 90

    stops = 0
    out = tmp_path / "out"
    found = None
    while found is None:
        try:
            if stops == 0:
                found = run_breaking(case, out, threads=2, stop_asked=every_so_often)
            else:
                found = resume_breaking(out, case, threads=2, stop_asked=every_so_often)
        except StoppedError:
            stops += 1
            assert json.loads((out / "result.json").read_text())["status"] == "stopped"
            assert history_begun(out, done[0])
            assert stops < 50
    assert stops > 1
    assert found["digest"] == whole["digest"]
    assert found["factors"][0]["value"] == whole["factors"][0]["value"]
    strip = ("seconds", "wall_time_s", "compile_time_s")
    stages = [{k: v for k, v in row.items() if k not in strip} for row in found["stages"]]
    assert stages == [{k: v for k, v in row.items() if k not in strip} for row in whole["stages"]]


def test_done_is_done_and_can_be_drawn_again(case, done):
    out, result = done
    again = run_breaking(case, out, threads=1)
    assert again["wall_time_s"] == result["wall_time_s"]
    (out / "report.html").unlink()
    assert redraw_breaking(out, case).is_file()
    assert "undercut" in (out / "report.html").read_text()


def test_the_history_is_written_whole(case, done, tmp_path, monkeypatch):
    """Never line by line under its own name, where a run that is killed would leave half of it."""
    out = tmp_path / "out"
    shutil.copytree(done[0], out)
    (out / "report.html").unlink()
    monkeypatch.setattr(HistoryWriter, "write", lambda self, *values: pytest.fail("line by line"))
    run_breaking(case, out, threads=1)
    assert (out / "history.csv").read_bytes() == (done[0] / "history.csv").read_bytes()


def test_the_command_checks_and_refuses(tmp_path):
    folder = tmp_path / "pillar"
    folder.mkdir()
    (folder / "case.toml").write_text(CASE)
    told = geodem("check", folder, "--out", tmp_path / "look.png")
    assert told.returncode == 0, told.stderr
    assert "Stage 3: undercut (excavate)" in told.stdout
    (folder / "case.toml").write_text(CASE.replace("[12.5, 10.5]", "[12.5, 21.5]"))
    told = geodem("run", folder, "--out", tmp_path / "out")
    assert told.returncode == 2
    assert "in the air" in told.stderr
    assert not (tmp_path / "out").exists()
