"""The folder of a run: what it refuses, what it keeps of a run that is stopped or killed, what it takes away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geodem import resume_case
from geodem.errors import InputError, StoppedError
from geodem.io import run_folder
from geodem.io.files import read_json
from geodem.io.run_folder import RunFolder, resumable

CASE = 'workflow = "pile"\n'
HEAD = {"workflow": "pile", "threads": 1}


def folder_of(path, identity="a", **options):
    return RunFolder(path, CASE, identity, written=("frames-*.vtkhdf",), **options)


def finish(path, identity="a"):
    run = folder_of(path, identity)
    run.claim()
    with run.going(HEAD):
        run.keep("first", {"x": np.arange(3.0)})
        (path / "report.html").write_text("report")
        (path / "frames-0.vtkhdf").write_text("frame")
        return run.finish({"height_m": 3.0})


def content(path):
    return {
        str(file.relative_to(path)): file.read_bytes() for file in sorted(path.rglob("*")) if file.is_file()
    }


def test_a_finished_run_is_found_again(tmp_path):
    assert folder_of(tmp_path / "out").finished() is None
    result = finish(tmp_path / "out")
    assert result["status"] == "done"
    assert result["workflow"] == "pile"
    assert result["height_m"] == 3.0
    assert {"identity", "sources_digest", "versions", "wall_time_s"} <= set(result)
    assert folder_of(tmp_path / "out").finished() == result == read_json(tmp_path / "out" / "result.json")
    assert folder_of(tmp_path / "out", "b").finished() is None
    assert (tmp_path / "out" / "case.toml").read_text() == CASE
    assert not resumable(tmp_path / "out")
    (tmp_path / "out" / "report.html").unlink()
    assert folder_of(tmp_path / "out").finished() is None


def test_another_version_is_not_this_one(tmp_path, monkeypatch):
    finish(tmp_path)
    monkeypatch.setattr(run_folder, "sources_digest", lambda: "another")
    run = folder_of(tmp_path)
    assert run.finished() is None
    assert run.part("first") is None
    assert run.claim(), "it is the same case, and may be run again without --overwrite"


def test_parts_are_kept_to_the_bit(tmp_path):
    tree = {"x": np.array([1.0 / 3.0, np.pi]), "inside": {"n": np.arange(4)}, "cracks": [1, 2], "why": "ü"}
    run = folder_of(tmp_path)
    assert run.part("first") is None
    run.claim()

    def stopped_after_the_first_part() -> None:
        with run.going(HEAD, lambda: {"height_m": 1.0}):
            run.keep("first", tree)
            raise StoppedError("stopped")

    with pytest.raises(StoppedError):
        stopped_after_the_first_part()
    stopped = read_json(tmp_path / "result.json")
    assert stopped["status"] == "stopped"
    assert stopped["height_m"] == 1.0
    assert resumable(tmp_path)
    again = folder_of(tmp_path)
    assert again.claim()
    found = again.part("first")
    assert np.array_equal(found["x"], tree["x"])
    assert np.array_equal(found["inside"]["n"], tree["inside"]["n"])
    assert (found["cracks"], found["why"]) == (tree["cracks"], tree["why"])
    assert folder_of(tmp_path, "b").part("first") is None, "of another case"
    file = tmp_path / "parts" / "first.h5"
    file.write_bytes(file.read_bytes()[:200])
    assert again.part("first") is None, "damaged"


def test_a_run_that_is_killed_can_be_resumed(tmp_path):
    """Between `begin` and the end there is a result that says so, and the time goes on from it."""
    run = folder_of(tmp_path)
    run.claim()
    run.begin(HEAD)
    assert resumable(tmp_path)
    first = read_json(tmp_path / "result.json")["wall_time_s"]
    later = folder_of(tmp_path)
    later.claim()
    later.begin(HEAD)
    assert later.finish({})["wall_time_s"] >= first


def test_what_is_not_ours_is_refused_and_kept(tmp_path):
    finish(tmp_path / "out")
    before = content(tmp_path / "out")
    with pytest.raises(InputError, match="results of another case"):
        folder_of(tmp_path / "out", "b").claim()
    assert content(tmp_path / "out") == before
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "case.toml").write_text("mine")
    with pytest.raises(InputError, match="would write over"):
        folder_of(tmp_path / "mine").claim(overwrite=True)
    assert content(tmp_path / "mine") == {"case.toml": b"mine"}
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="a file of that name"):
        folder_of(tmp_path / "file").claim()


def test_overwriting_takes_away_what_a_run_wrote_and_nothing_else(tmp_path):
    finish(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    assert not folder_of(tmp_path, "b").claim(overwrite=True)
    assert set(content(tmp_path)) == {"notes.txt", "case.toml", "result.json"}
    assert read_json(tmp_path / "result.json") == {"workflow": "pile", "status": "cleared"}


@pytest.mark.parametrize("ended", [0, 1, 2, "case"])
def test_overwriting_that_was_ended_by_force_is_done_again(ended, tmp_path, monkeypatch):
    """Whatever was taken away by then: the user has said once that it may be."""
    out = tmp_path / "out"
    finish(out)
    left = iter([True] * ended if isinstance(ended, int) else [])
    plain = Path.unlink

    def unlink(path, **options):
        if isinstance(ended, int) and not next(left, False):
            raise KeyboardInterrupt
        plain(path, **options)

    other = RunFolder(out, CASE + "# other\n", "b", written=("frames-*.vtkhdf",))
    with monkeypatch.context() as patch:
        patch.setattr(Path, "unlink", unlink)
        if ended == "case":
            other.claim(overwrite=True)
            other.write_case()
        else:
            with pytest.raises(KeyboardInterrupt):
                other.claim(overwrite=True)
    assert not resumable(out)
    with pytest.raises(InputError, match="being replaced"):
        resume_case(out)
    again = RunFolder(out, CASE + "# other\n", "b", written=("frames-*.vtkhdf",))
    assert not again.claim()
    with again.going(HEAD):
        assert again.finish({})["status"] == "done"
    assert set(content(out)) == {"case.toml", "result.json"}


def test_files_that_a_case_names_are_beside_it(tmp_path):
    (tmp_path / "given").mkdir()
    (tmp_path / "given" / "a.png").write_bytes(b"a")
    (tmp_path / "given" / "scan").mkdir()
    (tmp_path / "given" / "scan" / "0.png").write_bytes(b"0")
    sources = {
        "source/a.png": tmp_path / "given" / "a.png",
        "source/scan": tmp_path / "given" / "scan",
    }
    run = folder_of(tmp_path / "out", sources=sources)
    run.claim()
    (tmp_path / "out" / "source" / "scan").mkdir(parents=True)
    (tmp_path / "out" / "source" / "scan" / "stale.png").write_bytes(b"")
    run.begin(HEAD)
    found = content(tmp_path / "out" / "source")
    assert found == {"a.png": b"a", "scan/0.png": b"0"}
