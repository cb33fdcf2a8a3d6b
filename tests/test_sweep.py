"""A sweep in its folder: every run is done once, whatever interrupts it, and what fails ends nothing else."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from PIL import Image

from geodem import resume_case, run_case
from geodem.case.sweep_reading import load_sweep
from geodem.errors import InputError
from geodem.plotting.sweep_report import make_charts
from geodem.sweep_hands import Ended, UnderWay, do_runs
from geodem.sweep_record import carry_out, find_record
from geodem.sweep_run import FIRST_SECONDS, seconds_left, share_of, shares
from tests.ground_files import GROUND, ground_case
from tests.small_cases import SLOPE, environment, geodem, result_of

# without friction and dilation a factor of safety is cohesion over what equilibrium asks for
BANK = SLOPE.replace("particles = 500", "particles = 250").replace(', "gravity-increase"', "")
SWEEP = """\
workflow = "sweep"
title = "Cohesion and friction"
case = "bank.toml"
processes = 2
together = [["material.soil.friction_angle", "material.soil.dilation_angle"]]

[vary]
"material.soil.cohesion" = ["20 kPa", "0.04 MPa"]
"material.soil.friction_angle" = ["0 deg", "10 deg"]
"material.soil.dilation_angle" = ["0 deg", "10 deg"]
"""


def write_sweep(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bank.toml").write_text(BANK)
    (folder / "case.toml").write_text(SWEEP)
    return folder


@pytest.fixture(scope="module")
def sweep(tmp_path_factory) -> Path:
    return write_sweep(tmp_path_factory.mktemp("sweep"))


@pytest.fixture(scope="module")
def whole(sweep, tmp_path_factory) -> Path:
    """The folder of a sweep that nobody disturbed."""
    out = tmp_path_factory.mktemp("whole") / "out"
    done = geodem("sweep", sweep, "--out", out)
    assert done.returncode == 0, done.stderr
    assert "4 of 4 runs finished" in done.stdout
    return out


def content(folder: Path) -> dict[str, tuple[int, str]]:
    """When every file of a folder was written, and its digest."""
    return {
        str(path.relative_to(folder)): (
            path.stat().st_mtime_ns,
            hashlib.sha256(path.read_bytes()).hexdigest(),
        )
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def rows_of(out: Path) -> list[dict[str, str]]:
    with (out / "sweep.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_the_table_has_units_and_numbers(whole):
    rows = rows_of(whole)
    assert list(rows[0]) == [
        "run [-]", "material.soil.cohesion [kPa]", "material.soil.friction_angle [deg]",
        "material.soil.dilation_angle [deg]", "factor of safety [-]", "status [-]", "run time [s]",
    ]  # fmt: skip
    assert [(row["material.soil.cohesion [kPa]"], row["material.soil.friction_angle [deg]"]) for row in rows] == [
        ("20.0", "0.0"), ("20.0", "10.0"), ("40.0", "0.0"), ("40.0", "10.0"),
    ]  # fmt: skip
    for row in rows:
        factor = result_of(whole / "runs" / f"{int(row['run [-]']):04d}")["factors"][0]
        assert float(row["factor of safety [-]"]) == factor["value"]
        assert row["status [-]"] == "done"


def test_twice_the_cohesion_is_twice_the_factor_without_friction(whole):
    """Of dimensional analysis (Taylor 1937): F = c N / (gamma H), N of the geometry alone; brackets are 2 % wide."""
    first, frictional, second, _ = (float(row["factor of safety [-]"]) for row in rows_of(whole))
    assert second / first == pytest.approx(2.0, rel=0.03)
    assert frictional > 1.05 * first


def test_every_run_is_a_case_of_its_own(whole):
    text = (whole / "runs" / "0003" / "case.toml").read_text()
    assert 'cohesion = "40 kPa"' in text
    assert 'friction_angle = "0 deg"' in text
    assert (whole / "runs" / "0003" / "report.html").is_file()
    kept = json.loads((whole / "runs" / "0003.json").read_text())
    assert kept["values"]["material.soil.cohesion"] == "0.04 MPa"


def test_the_report_shows_and_leads_to_the_runs(whole):
    page = (whole / "report.html").read_text()
    links = re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)([^"']*)""", page)
    assert links == [f"runs/{number:04d}/report.html" for number in (1, 2, 3, 4)]
    assert all((whole / link).is_file() for link in links)
    assert page.count("data:image/png;base64,") == 5, "a chart, and a picture of each run"
    assert "factor of safety [-]" in page
    assert str(whole.parent) not in page.split("Command")[0]
    with Image.open(whole / "figures" / "chart-1.png") as picture:
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20


def test_killed_and_gone_on_with(sweep, whole, tmp_path):
    """kill -9 once a run is done: it is not touched again, and all have the bits of a sweep without disturbance."""
    out = tmp_path / "out"
    command = [sys.executable, "-m", "geodem", "sweep", str(sweep), "--out", str(out), "--threads", "1"]
    with subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL) as running:
        end = time.monotonic() + 60.0
        while not (finished := sorted((out / "runs").glob("*.json"))):
            assert time.monotonic() < end
            assert running.poll() is None
            time.sleep(0.02)
        running.send_signal(signal.SIGKILL)
    assert running.returncode == -signal.SIGKILL
    assert result_of(out)["status"] == "stopped"
    names = {path.stem for path in finished}
    before = {name: content(out / "runs" / name) for name in names}
    done = geodem("resume", out)
    assert done.returncode == 0, done.stderr
    assert result_of(out)["status"] == "done"
    assert {name: content(out / "runs" / name) for name in names} == before
    for run in ("0001", "0002", "0003", "0004"):
        assert result_of(out / "runs" / run)["digest"] == result_of(whole / "runs" / run)["digest"]
    assert [row["factor of safety [-]"] for row in rows_of(out)] == [
        row["factor of safety [-]"] for row in rows_of(whole)
    ]


def test_the_sweep_in_its_folder_has_the_same_table(whole, sweep, tmp_path):
    """What is tabulated where nothing is said: columns that no run fills are left out, of a resumed sweep as well."""
    assert load_sweep(sweep).default_table
    assert load_sweep(whole).default_table
    own = write_sweep(tmp_path / "own")
    (own / "case.toml").write_text(SWEEP + '[table]\n"gravity factor [-]" = "factors[0].value"\n')
    assert not load_sweep(own).default_table


def test_a_finished_sweep_is_not_done_again(sweep, whole):
    before = content(whole)
    result = run_case(sweep, whole)
    assert result["finished"] == 4
    assert resume_case(whole) == result
    assert content(whole) == before


def test_an_array_job(sweep, whole, tmp_path, call):
    """Runs by number, as a scheduler does them, then the table; only what is missing is done after that."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    shutil.rmtree(out / "runs" / "0002")
    (out / "runs" / "0002.json").unlink()
    kept = {name: content(out / "runs" / name) for name in ("0001", "0003", "0004")}
    missing = call("sweep", sweep, "--out", out, "--collect")
    assert missing.status == 0, missing.err
    assert "3 of 4 runs finished" in missing.out
    assert [row["status [-]"] for row in rows_of(out)] == ["done", "waiting", "done", "done"]
    again = call("sweep", sweep, "--out", out, "--task", "2/4", "--threads", "1")
    assert again.status == 0, again.err
    assert "Run 2 done" in again.out
    whole_again = call("sweep", sweep, "--out", out, "--collect")
    assert "4 of 4 runs finished" in whole_again.out
    assert result_of(out)["status"] == "done"
    assert {name: content(out / "runs" / name) for name in kept} == kept
    assert result_of(out / "runs" / "0002")["digest"] == result_of(whole / "runs" / "0002")["digest"]
    beyond = call("sweep", sweep, "--out", out, "--only", "5")
    assert beyond.status == 2
    assert "the sweep has the runs 1 to 4" in beyond.err


def test_another_sweep_is_not_written_over(sweep, whole, tmp_path, call):
    """With one value more it is another one; told to go on, it keeps the runs that are the same."""
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    more = write_sweep(tmp_path / "more")
    (more / "case.toml").write_text(SWEEP.replace('"0.04 MPa"]', '"0.04 MPa", "0.06 MPa"]'))
    before = content(out)
    refused = call("sweep", more, "--out", out)
    assert refused.status == 2
    assert "another" in refused.err
    assert content(out) == before
    (more / "case.toml").write_text(SWEEP.replace('"0.04 MPa"', '"0.05 MPa"'))
    changed = geodem("sweep", more, "--out", out, "--overwrite")
    assert changed.returncode == 0, changed.stderr
    kept = {
        name: times for name, times in content(out).items() if name.startswith(("runs/0001/", "runs/0002/"))
    }
    assert kept.items() <= before.items()
    assert float(rows_of(out)[2]["factor of safety [-]"]) > 1.2 * float(
        rows_of(whole)[2]["factor of safety [-]"]
    )


def test_a_run_that_fails_is_told_and_ends_nothing(tmp_path):
    """Particles too large for the body: seen when it is filled, by one run of three."""
    ground_case(tmp_path / "ground", GROUND.replace("particles = 1200", 'radius = "20 cm"'))
    (tmp_path / "sweep.toml").write_text(
        'workflow = "sweep"\ncase = "ground"\nprocesses = 1\n[vary]\n'
        '"particles.radius" = ["20 cm", "40 m", "40 cm"]\n[table]\n"particles [-]" = "particles"\n'
        '"mass of the seam [kg/m]" = "materials[name=seam].mass"\n'
    )
    done = geodem("sweep", tmp_path / "sweep.toml", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "2 of 3 runs finished, 1 failed" in done.stdout
    assert re.search(r"run 2 failed \(particles\.radius = \"40 m\"\): .*has no room", done.stdout), (
        done.stdout
    )
    rows = rows_of(tmp_path / "out")
    assert [row["status [-]"] for row in rows] == ["done", "failed", "done"]
    assert [row["particles.radius [cm]"] for row in rows] == ["20.0", "4000.0", "40.0"]
    assert rows[1]["particles [-]"] == ""
    for row in (rows[0], rows[2]):
        assert float(row["mass of the seam [kg/m]"]) == pytest.approx(12.0 * 2100.0)
    assert geodem("sweep", tmp_path / "sweep.toml", "--out", tmp_path / "out", "--only", 2).returncode == 2


def test_a_process_that_breaks_down_is_one_run(sweep, tmp_path):
    """A worker that cannot even read its sweep: told of every run that it was given, and no end of waiting."""
    ends: list[Ended] = []
    order = {"out": str(tmp_path), "threads": 1, "quick": False, "overwrite": False}
    do_runs([1, 2], order, processes=1, ended=ends.append, waiting=lambda running: None)
    assert [end.number for end in ends] == [1, 2]
    assert all("status" in end.gone for end in ends)
    assert find_record(load_sweep(sweep), load_sweep(sweep).runs[0], tmp_path, False).status == "waiting"


def test_a_second_stop_leaves_no_process_behind(monkeypatch):
    """Ctrl-C while a process is waited for: the others are ended as well."""
    begun: list[subprocess.Popen] = []

    class Sleeper(subprocess.Popen):
        def __init__(self, command, **options):
            super().__init__([sys.executable, "-c", "import time; time.sleep(60)"], **options)
            begun.append(self)

        def wait(self, timeout=None):
            if timeout is not None:
                raise KeyboardInterrupt
            return super().wait()

    monkeypatch.setattr("geodem.sweep_hands.subprocess.Popen", Sleeper)
    order = {"out": "nowhere", "threads": 1, "quick": False, "overwrite": False}
    with pytest.raises(KeyboardInterrupt):
        do_runs(
            [1, 2], order, processes=2, ended=lambda end: None, waiting=lambda running: None,
            stop_asked=lambda: len(begun) == 2,
        )  # fmt: skip
    ended = [process.poll() is not None for process in begun]
    for process in begun:
        process.kill()
    assert ended == [True, True]


def test_a_run_whose_checkpoint_is_spoilt_is_made_anew_where_that_is_asked_for(sweep, whole, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    (out / "runs" / "0002.json").unlink()
    (out / "runs" / "0002" / "checkpoint.h5").write_bytes(b"cut off")
    case = load_sweep(sweep)
    refused = carry_out(case, case.runs[1], out)
    assert refused.status == "failed"
    assert "--overwrite" in refused.message
    assert carry_out(case, case.runs[1], out, overwrite=True).status == "done"
    assert result_of(out / "runs" / "0002")["digest"] == result_of(whole / "runs" / "0002")["digest"]


def test_check_tells_how_many_and_how_long(sweep, tmp_path, call):
    found = call("check", sweep, "--out", tmp_path / "look.png")
    assert found.status == 0, found.err
    assert "Sweep: 4 runs of bank.toml, a case of the kind slope" in found.out
    assert re.search(r"Expected time: .*2 at a time", found.out)
    assert (tmp_path / "look.png").is_file()


def test_bad_input_runs_nothing(sweep, tmp_path, call):
    bad = write_sweep(tmp_path / "bad")
    (bad / "case.toml").write_text(SWEEP.replace('"0.04 MPa"', '"4 deg"'))
    answer = call("sweep", bad, "--out", tmp_path / "out")
    assert answer.status == 2
    assert "vary.material.soil.cohesion" in answer.err
    assert not (tmp_path / "out").exists()
    told = call("sweep", sweep, "--out", tmp_path / "out", "--only", "1", "--collect")
    assert told.status == 2
    assert "--only and --collect are given" in told.err


@pytest.mark.parametrize(("task", "numbers"), [("1/3", [1, 4]), ("3/3", [3]), ("2/9", [2]), ("6/9", [])])
def test_shares_of_an_array(task, numbers):
    assert share_of(task, 5) == numbers


@pytest.mark.parametrize("task", ["0/3", "4/3", "1", "a/b", "-1/3"])
def test_what_is_no_share(task):
    with pytest.raises(InputError, match="this is no share"):
        share_of(task, 5)


def test_cores_are_shared_out(sweep):
    case = load_sweep(sweep)
    assert shares(case, 1) == (2, 1)
    assert case.processes == 2


def test_axes_are_logarithmic_where_values_span_decades():
    """Seen in the picture: the line of y = x over three decades is as straight as over a small span."""
    from geodem.plotting.sweep_charts import sweep_chart

    def chart(values: list[float]):
        runs = [
            {"parameters": [value], "values": [value], "status": "done", "number": k, "told": ""}
            for k, value in enumerate(values, start=1)
        ]
        entry = {"key": "material.rock.strength", "unit": "MPa", "number": True}
        return {"parameters": [entry], "columns": ["strength [Pa]"], "runs": runs}

    wide, narrow = (sweep_chart(chart(values), 0) for values in ([1.0, 10.0, 1000.0], [1.0, 2.0, 10.0]))
    assert wide is not None
    assert narrow is not None
    assert (wide.axes[0].get_xscale(), wide.axes[0].get_yscale()) == ("log", "log")
    assert (narrow.axes[0].get_xscale(), narrow.axes[0].get_yscale()) == ("linear", "linear")
    assert wide.axes[0].get_xlabel() == "material.rock.strength [MPa]"
    assert set(make_charts(chart([1.0, 2.0]))) == {"chart-1"}
    assert make_charts(chart([1.0])) == {}


def test_the_time_left_of_a_sweep_is_told_by_runs_done_and_under_way():
    assert math.isnan(seconds_left([], [UnderWay(5.0, math.nan)], 3, 2)), "nobody has told anything"
    # one is done in 10 s, one tells 4 s after 8 s: 11 s in the mean; three wait
    assert seconds_left([10.0], [UnderWay(8.0, 4.0)], 3, 1) == pytest.approx(3 * 11.0 + 4.0)
    # one that tells nothing takes as long as the mean
    assert seconds_left([10.0], [UnderWay(4.0, math.nan)], 0, 2) == pytest.approx(6.0)
    assert seconds_left([10.0], [], 0, 2) == 0.0
    # the first of a process says too much of those that follow
    first = [UnderWay(8.0, 4.0)]
    assert seconds_left([], first, 3, 1) == pytest.approx(3 * (12.0 - FIRST_SECONDS) + 4.0)
    assert seconds_left([], [UnderWay(0.5, 0.5)], 3, 1) == pytest.approx(3 * 0.5 + 0.5)
