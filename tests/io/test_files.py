"""Files of a run: what is left unfinished is taken away, and what cannot be read is nothing."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from geodem.errors import InputError
from geodem.io.files import read_json, remove, remove_unfinished


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '"a"', "[" * 100_000, "null", '{"a": 1', b"\xff\xfe"])
def test_what_is_no_table_is_nothing(text, tmp_path):
    path = tmp_path / "result.json"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert not read_json(path)


def test_what_cannot_be_taken_away_is_told_in_words(tmp_path):
    remove(tmp_path / "is not there")
    (tmp_path / "report.html").mkdir()
    with pytest.raises(InputError, match="a folder has the name") as told:
        remove(tmp_path / "report.html")
    assert "--out" in told.value.remedy


def test_unfinished_files_of_dead_processes_are_taken_away_everywhere(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    (tmp_path / "figures").mkdir()
    left = [tmp_path / f".a.json.{dead.pid}.part", tmp_path / "figures" / f".b.png.{dead.pid}.part"]
    kept = [tmp_path / f".a.json.{os.getpid()}.part", tmp_path / "figures" / "b.png", tmp_path / ".mine.part"]
    for path in (*left, *kept):
        path.write_text("x")
    remove_unfinished(tmp_path)
    assert not any(path.exists() for path in left)
    assert all(path.exists() for path in kept)
