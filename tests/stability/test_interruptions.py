"""Runs that are killed or have no room go on to the same bits: the small form of `reference run interruptions`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile

import pytest

from reference.problems import interruptions
from reference.problems.fuzzing_judge import ROOT
from reference.problems.interruptions_disks import full_disks, read_only
from reference.problems.interruptions_processes import end_all, left_behind, marked, start
from reference.problems.interruptions_scenes import SCENES, broken_files, make_older, next_command
from reference.problems.interruptions_shares import in_shares
from reference.problems.rows import Row

SEED = 5
KILLS = {"slope": 3, "ground": 3, "laboratory": 3, "particles": 3}


@pytest.mark.parametrize("name", KILLS)
def test_killed_and_gone_on_with(name):
    outcome = interruptions.disturb(SCENES[name], KILLS[name], SEED)
    assert outcome.problems == [], f"seed {SEED}"
    assert sum(outcome.kills.values()) == KILLS[name]
    assert outcome.finished >= 1


def test_no_room_and_no_permission(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "locked").mkdir()
    ended, problems = full_disks(SCENES["particles"], tmp_path / "full")
    assert problems == []
    assert ended >= 2
    assert read_only(SCENES["particles"], tmp_path / "locked") == (4, [])


@pytest.mark.parametrize(("moment", "there"), [("half", False), ("whole", False), ("after", True)])
def test_the_killer_kills_at_its_moment(moment, there, tmp_path):
    """The second file whose name matches: nothing of it under its name but after."""
    (tmp_path / "program.py").write_text(
        "import sys\nfrom pathlib import Path\nfrom geodem.io.files import write_whole\n"
        "for name in ('a.txt', 'b.json', 'c.txt', 'd.txt'):\n    write_whole(Path(sys.argv[1]) / name, 'content')\n"
    )
    program = [
        "reference.problems.interruptions_killer",
        moment,
        "2",
        r"\.txt$",
        "-",
        "",
        "program",
        str(tmp_path / "out"),
    ]
    done = subprocess.run(
        [sys.executable, "-m", *program],
        env={"PYTHONPATH": f"{ROOT}:{tmp_path}"},
        check=False,
        capture_output=True,
    )
    assert done.returncode == -9
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {name for name in names if not name.startswith(".")} == {"a.txt", "b.json"} | (
        {"c.txt"} if there else set()
    )
    left = [path.read_text() for path in (tmp_path / "out").glob(".*.part")]
    assert left == {"half": ["con"], "whole": ["content"], "after": []}[moment]


@pytest.mark.parametrize("name", ["a.json", "a.html", "a.png", "a.vtkhdf", "a.h5", "a.npz", "a.toml"])
def test_half_a_file_is_seen(name, tmp_path):
    (tmp_path / name).write_bytes(b'{"a": 1' if name == "a.json" else b"<html><bo")
    assert len(broken_files(tmp_path)) == 1


def test_processes_that_are_left_behind_are_seen():
    """One that its parent started in a session of its own, after the parent has gone."""
    inner = "import time; time.sleep(60)"
    outer = (
        f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {inner!r}], start_new_session=True)"
    )
    running = start([sys.executable, "-c", outer])
    assert running.wait(30.0) == ""
    assert len(left_behind(running.mark, 0.2)) == 1
    assert marked(running.mark, "sleep") == marked(running.mark)
    end_all(running.mark)
    assert left_behind(running.mark, 0.0) == []


def test_results_of_another_case_are_written_over_until_they_are_gone(tmp_path):
    whole, out = tmp_path / "whole", tmp_path / "out"
    whole.mkdir()
    (whole / "case.toml").write_text('workflow = "cutting"\ntitle = "Small cut"\n')
    (whole / "result.json").write_text('{"status": "done", "identity": "abc"}')
    scene = SCENES["cutting"]
    make_older(whole, out)
    assert json.loads((out / "result.json").read_text()) == {"status": "done", "identity": "another"}
    command = next_command(scene, tmp_path, out)
    assert command[-1] == "--overwrite"
    assert command[command.index("--out") + 1] == str(out)
    (out / "case.toml").write_text((whole / "case.toml").read_text())
    assert "--overwrite" not in next_command(scene, tmp_path, out)


def test_a_long_run_is_done_in_shares(tmp_path, monkeypatch):
    """Stopped in its second scene it begins with that; what was done long ago, or with other sources, is done again."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    asked: list[str] = []

    def work(name: str, stopped: str = "") -> list[Row]:
        if name == stopped:
            raise KeyboardInterrupt
        asked.append(name)
        return [Row(name, "kills", len(asked), 0.0, 0.0, 0.0, 1.5, "seed 1")]

    with pytest.raises(KeyboardInterrupt):
        in_shares(["first", "second"], lambda name: work(name, "second"))
    rows = in_shares(["first", "second"], work)
    assert asked == ["first", "second"]
    assert rows == [Row(name, "kills", at, 0.0, 0.0, 0.0, 1.5, "seed 1") for at, name in enumerate(asked, 1)]
    (kept,) = tmp_path.glob("geodem-shares-*/first.json")
    os.utime(kept, (0, 0))
    in_shares(["first", "second"], work)
    assert asked == ["first", "second", "first"]
    monkeypatch.setattr("reference.problems.interruptions_shares.sources_digest", lambda: "another")
    in_shares(["first"], work)
    assert asked[3:] == ["first"]
