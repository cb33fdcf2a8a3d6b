"""Runs that are killed or have no room go on to the same bits: the small form of `reference run interruptions`."""

from __future__ import annotations

import subprocess
import sys

import pytest

from reference.problems import interruptions
from reference.problems.fuzzing_judge import ROOT
from reference.problems.interruptions_disks import full_disks, read_only
from reference.problems.interruptions_scenes import SCENES, broken_files

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
    assert read_only(SCENES["particles"], tmp_path / "locked") == []


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
