"""A run can be stopped anywhere: what follows has the same bits. Kills are in tests/stability/test_interruptions.py."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from geodem import cli
from geodem.analysis import Analysis, Update
from geodem.case import load_case
from geodem.errors import InputError, StoppedError
from geodem.io.checkpoint import read_checkpoint, write_checkpoint
from geodem.io.history import read_history
from geodem.result import assemble
from geodem.workflow import run_case
from tests.small_cases import (
    SLOPE,
    STAGES,
    environment,
    forecast_error,
    geodem,
    result_of,
    works_of,
    write_case,
)


@pytest.fixture(scope="module")
def case(tmp_path_factory) -> Path:
    """A case that goes through every stage: coarse model, refined model, search without dilation."""
    return write_case(tmp_path_factory.mktemp("case"), STAGES)


@pytest.fixture(scope="module")
def whole(case, tmp_path_factory) -> Path:
    """Its results, by one program on one thread that nobody disturbs."""
    out = tmp_path_factory.mktemp("whole") / "out"
    done = geodem("run", case, "--out", out, "--threads", 1)
    assert done.returncode == 0, done.stderr
    assert result_of(out)["threads"] == 1
    return out


@pytest.fixture(scope="module")
def told() -> list[Update]:
    """What a run without a stop tells."""
    return []


@pytest.fixture(scope="module")
def stages(case, told) -> list[str]:
    """What a run without a stop is doing, batch by batch."""
    seen: list[str] = []
    now = ""

    def watch(update: Update) -> None:
        nonlocal now
        told.append(update)
        if update.progress is None:
            now = update.text
        else:
            flat = "flat " if "without dilation" in now and update.progress.model == "coarse" else ""
            seen.append(f"{flat}{update.progress.kind} {update.progress.model}")

    analysis = Analysis(load_case(case), watch=watch)
    analysis.build()
    analysis.search()
    return seen


def test_the_work_left_is_told(stages, told):
    """A few trials of a small model take a large part of all its steps, and nobody knows which: a third at worst."""
    works = works_of(told)
    assert forecast_error(works) < 0.34
    assert forecast_error(works, after=0.5) < 0.2
    assert all(work.done + work.most >= works[-1].done for work in works)


def after(batches: int) -> Any:
    """A stop that is asked for after so many batches of steps."""
    left = batches

    def asked() -> bool:
        nonlocal left
        left -= 1
        return left <= 0

    return asked


def begin(case: Path, folder: Path, **options: Any) -> Analysis:
    folder.mkdir(exist_ok=True)
    analysis = Analysis(load_case(case), folder, **options)
    analysis.build()
    analysis.save()
    return analysis


def test_threads_do_not_change_the_bits(case, whole, tmp_path):
    done = geodem("run", case, "--out", tmp_path / "out", "--threads", 2)
    assert done.returncode == 0, done.stderr
    assert result_of(tmp_path / "out")["threads"] == 2
    assert result_of(tmp_path / "out")["digest"] == result_of(whole)["digest"]
    assert (tmp_path / "out" / "history.csv").read_bytes() == (whole / "history.csv").read_bytes()


def test_another_seed_changes_the_bits(tmp_path):
    """The digest tells runs apart at all."""
    digests = set()
    for seed in (3, 4):
        analysis = begin(
            write_case(tmp_path / f"case{seed}", SLOPE.replace("seed = 3", f"seed = {seed}")),
            tmp_path / "out",
        )
        analysis.search()
        digests.add(assemble(analysis)["digest"])
    assert len(digests) == 2


STAGE_NAMES = (
    "strength-reduction coarse",
    "gravity-increase coarse",
    "strength-reduction fine",
    "flat strength-reduction coarse",
    "gravity-increase fine",
)


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_stopped_half_way_through_a_stage(stage, stages, case, whole, tmp_path):
    batches = [number for number, name in enumerate(stages, start=1) if name == stage]
    assert batches, f"the case has no {stage} stage: {sorted(set(stages))}"
    analysis = begin(case, tmp_path, stop_asked=after(batches[len(batches) // 2]))
    with pytest.raises(StoppedError):
        analysis.search()
    assert not analysis.done()
    resumed = Analysis.from_checkpoint(load_case(case), tmp_path)
    resumed.search()
    result = assemble(resumed)
    assert result["digest"] == result_of(whole)["digest"]
    # and everything else that does not tell of time
    for key in ("factors", "steps", "energy", "notices", "warnings", "particles"):
        assert timeless(result[key]) == timeless(result_of(whole)[key]), key


def timeless(value: Any) -> Any:
    """Without wall times, and without what is measured after the search."""
    if isinstance(value, dict):
        return {k: timeless(v) for k, v in value.items() if k not in ("seconds", "failure", "reference")}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def test_stopped_again_and_again(case, whole, tmp_path):
    """Every 37 batches, from the first fine one on; a batch is a look, so a trial is cut several times."""
    analysis = begin(case, tmp_path)
    stops = 0

    def on_fine() -> bool:
        return analysis.bracketed

    analysis.stop_asked = on_fine
    while True:
        try:
            analysis.search()
            break
        except StoppedError:
            stops += 1
            analysis = Analysis.from_checkpoint(load_case(case), tmp_path, stop_asked=after(37))
    assert stops > 4
    assert assemble(analysis)["digest"] == result_of(whole)["digest"]


def test_interrupted_by_the_user(case, whole, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "geodem", "run", str(case), "--out", str(out)]
    with subprocess.Popen(
        command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        for line in running.stdout:
            if "on 1,650 particles" in line:
                break
        running.send_signal(signal.SIGINT)
        _, errors = running.communicate(timeout=60)
    assert running.returncode == 3, errors
    assert f"geodem resume {out}" in errors
    assert "Traceback" not in errors
    stopped = result_of(out)
    assert stopped["status"] == "stopped"
    assert any("was stopped before its bracket was closed" in text for text in stopped["warnings"])
    assert "was stopped" in (out / "report.html").read_text()
    done = geodem("resume", out)
    assert done.returncode == 0, done.stderr
    assert result_of(out)["digest"] == result_of(whole)["digest"]
    assert result_of(out)["notices"] == result_of(whole)["notices"]
    assert result_of(out)["wall_time_s"] > stopped["wall_time_s"]


def test_the_history_grows_while_it_runs(case, whole, tmp_path, monkeypatch):
    """What a killed run leaves is a part of what is there in the end, the trial under way included."""
    monkeypatch.setattr("geodem.analysis.CHECKPOINT_SECONDS", 0.0)
    lengths = []

    def watch(update: Update) -> None:
        if update.progress is not None and (tmp_path / "history.csv").exists():
            lengths.append(len(read_history(tmp_path / "history.csv")["step [-]"]))

    analysis = begin(case, tmp_path, watch=watch, stop_asked=after(60))
    with pytest.raises(StoppedError):
        analysis.search()
    assert lengths == sorted(lengths)
    # a line of the look before is there at each
    assert lengths[-1] >= 58
    kept, there = (
        {repr(line) for line in zip(*read_history(folder / "history.csv").values(), strict=True)}
        for folder in (tmp_path, whole)
    )
    assert kept < there


def test_a_checkpoint_that_lacks_a_part_is_refused(folder, capsys):
    """One that was made by hand, with a checksum that fits."""
    tree = read_checkpoint(folder / "checkpoint.h5")
    del tree["methods"]
    write_checkpoint(folder / "checkpoint.h5", tree)
    (folder / "result.json").unlink()
    assert call("resume", folder)[0] == 2
    assert "the checkpoint lacks a part ('methods')" in " ".join(capsys.readouterr().err.split())


def test_stopped_before_anything_is_known(case, tmp_path):
    """On the coarse model: a report that says so, and a folder to go on in."""
    with pytest.raises(StoppedError):
        run_case(case, tmp_path / "out", stop_asked=after(3))
    result = result_of(tmp_path / "out")
    assert result["status"] == "stopped"
    assert [entry["value"] for entry in result["factors"]] == [None, None]
    assert "was stopped" in (tmp_path / "out" / "report.html").read_text()
    assert not Analysis.from_checkpoint(load_case(case), tmp_path / "out").done()


# --- folders that a run is to go on in


@pytest.fixture
def folder(whole, tmp_path) -> Path:
    """A copy of finished results that may be spoilt."""
    return Path(shutil.copytree(whole, tmp_path / "copy"))


def call(*arguments: object) -> tuple[int, str]:
    """Exit status and message of a command, in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["geodem", *map(str, arguments)])
        try:
            cli.main()
        except SystemExit as end:
            return int(end.code or 0), ""
    return 0, ""


def content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.clock
def test_what_is_done_is_not_done_again(case, folder, capsys):
    before = content(folder)
    for arguments in (("resume", folder), ("run", case, "--out", folder)):
        start = time.perf_counter()
        assert call(*arguments)[0] == 0
        assert time.perf_counter() - start < 2.0
        assert "Factor of safety" in capsys.readouterr().out
        assert content(folder) == before


def test_a_missing_report_is_made_again(folder):
    (folder / "report.html").unlink()
    (folder / "result.json").unlink()
    assert call("resume", folder)[0] == 0
    assert result_of(folder)["status"] == "done"
    assert (folder / "report.html").exists()


def test_a_moved_folder_goes_on(folder, tmp_path):
    moved = folder.rename(tmp_path / "moved")
    (moved / "result.json").unlink()
    assert call("resume", moved)[0] == 0


def test_a_damaged_checkpoint_is_refused(folder, capsys):
    path = folder / "checkpoint.h5"
    data = bytearray(path.read_bytes())
    (folder / "result.json").unlink()
    spoilt = {
        "cut": bytes(data[: len(data) // 2]),
        "empty": b"",
        "flipped": bytes(data[:-5000]) + bytes(b ^ 255 for b in data[-5000:]),
    }
    for name, bits in spoilt.items():
        path.write_bytes(bits)
        for command in ("resume", "plot"):
            assert call(command, folder)[0] == 2, name
            message = capsys.readouterr().err
            assert "checkpoint.h5" in message
            assert "geodem run CASE --out DIR --overwrite" in message
        assert path.read_bytes() == bits


def test_a_checkpoint_of_another_version_is_refused(folder, monkeypatch, capsys):
    monkeypatch.setattr("geodem.analysis.sources_digest", lambda: "another")
    before = content(folder)
    assert call("resume", folder)[0] == 2
    message = capsys.readouterr().err
    assert "written by another geodem" in message
    assert "--overwrite" in message
    assert content(folder) == before


def test_a_changed_case_is_refused(folder, capsys):
    text = (folder / "case.toml").read_text()
    assert '"10 kPa"' in text
    (folder / "case.toml").write_text(text.replace('"10 kPa"', '"11 kPa"'))
    assert call("resume", folder)[0] == 2
    assert "not what the checkpoint beside it was made of" in capsys.readouterr().err


def test_results_of_another_case_are_kept(folder, tmp_path, capsys):
    other = write_case(tmp_path / "other", SLOPE.replace('"20 deg"', '"21 deg"'))
    before = content(folder)
    assert call("run", other, "--out", folder)[0] == 2
    message = capsys.readouterr().err
    assert "results of another case" in message
    assert "--overwrite" in message
    assert content(folder) == before
    assert call("run", other, "--out", folder, "--overwrite")[0] == 0
    assert result_of(folder)["title"] == "Small slope"
    assert result_of(folder)["particles"] == 500


def test_a_picture_that_was_drawn_anew_is_another_case(tmp_path):
    """The case file is the same to the letter; what it names is not."""
    from PIL import Image, ImageDraw

    regions = SLOPE[SLOPE.index("regions") : SLOPE.index("\n\n[boundary]")]
    image = (
        'image = "section.png"\nscale = "0.5 m/px"\nlegend = {"#c8a464" = "soil"}\nbackground = ["#ffffff"]'
    )
    source = write_case(tmp_path / "case", SLOPE.replace(regions, image))

    def draw(crest: int) -> None:
        picture = Image.new("RGB", (80, 30), "#ffffff")
        pen = ImageDraw.Draw(picture)
        pen.polygon([(0, 29), (79, 29), (79, 0), (crest, 0), (20, 19), (0, 19)], fill="#c8a464")
        picture.save(source / "section.png")

    draw(50)
    analysis = begin(source, tmp_path / "out")
    from geodem.outputs import write_case as write_run

    write_run(analysis, tmp_path / "out")
    assert (tmp_path / "out" / "section.png").read_bytes() == (source / "section.png").read_bytes()
    assert Analysis.from_checkpoint(load_case(tmp_path / "out"), tmp_path / "out").particles is not None
    draw(60)
    with pytest.raises(InputError, match="the case or its picture"):
        Analysis.from_checkpoint(load_case(source), tmp_path / "out")
    assert call("run", source, "--out", tmp_path / "out")[0] == 2
