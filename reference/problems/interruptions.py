"""Runs ended by force at random moments and in the midst of what they write; then gone on with, to the same bits.

Every scene is run once undisturbed. Then it is begun, killed, begun again from what it left, killed again, ... until
it is done: it must hold the bits of the undisturbed run, and at every moment every file in its folder must be whole.
"""

from __future__ import annotations

import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from .fuzzing_judge import ROOT
from .interruptions_disks import full_disks, full_file_system, read_only
from .interruptions_killer import MOMENTS
from .interruptions_scenes import SCENES, Scene, broken_files, held
from .rows import Row

KILLS = {"slope": 24, "ground": 57, "laboratory": 51, "particles": 72}
"""Of each scene; a third at random moments, a third while it writes what it goes on from, a third in its outputs."""
SEED = 20261130
WORDS = {
    "time": "at a random moment",
    "checkpoint": "in writing what it goes on from",
    "outputs": "in writing its outputs",
}
LIMIT = 300.0
"""Longest time of one run [s]."""


class Outcome(NamedTuple):
    """What came of a scene's kills."""

    kills: dict[str, int]
    finished: int
    problems: list[str]
    seconds: float


def run() -> Sequence[Row]:
    """Every scene: kills of each sort, runs that were brought to their end, and what was wrong."""
    rows = []
    for name, kills in KILLS.items():
        outcome = disturb(SCENES[name], kills, SEED)
        for problem in outcome.problems:
            print(f"{name}: {problem}")
        source = f"seed {SEED}; {outcome.finished} runs brought to their end"
        done = sum(outcome.kills.values())
        for sort, count in outcome.kills.items():
            rows.append(
                Row(name, f"kills {WORDS[sort]}", count, kills / 3, 0.0, 0.0, outcome.seconds, source)
            )
        short = min(done / kills - 1.0, 0.0)
        rows.append(Row(name, "kills in all", done, kills, short, 0.0, outcome.seconds, "asked for"))
        wrong = len(outcome.problems)
        rows.append(
            Row(name, "broken files, other bits, errors", wrong, 0.0, wrong, 0.0, outcome.seconds, "wanted")
        )
    for name, scene in SCENES.items():
        rows += _of_disks(name, scene)
    return rows


def _of_disks(name: str, scene: Scene) -> list[Row]:
    """Full and locked disks: how many runs they ended, and what was wrong with how."""
    rows = []
    for what, examine in (
        ("a full file", full_disks),
        ("a full file system", full_file_system),
        ("a locked folder", _locked),
    ):
        begun = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            ended, problems = examine(scene, Path(folder))
        for problem in problems:
            print(f"{name}, {what}: {problem}")
        seconds = time.perf_counter() - begun
        rows.append(
            Row(name, f"runs ended by {what}", ended, 2.0, 0.0, 0.0, seconds, "as many as came of it")
        )
        rows.append(
            Row(
                name,
                f"not in words, or lost, with {what}",
                len(problems),
                0.0,
                len(problems),
                0.0,
                seconds,
                "wanted",
            )
        )
    return rows


def _locked(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    return 2, read_only(scene, folder)


def disturb(scene: Scene, kills: int, seed: int) -> Outcome:
    """Kill a scene so many times in all, and bring every run of it to its end."""
    rng = random.Random(seed)
    begun = time.perf_counter()
    counts = dict.fromkeys(WORDS, 0)
    problems: list[str] = []
    finished = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene.prepare(folder)
        whole = _whole(scene, folder, problems)
        out = folder / "out"
        while sum(counts.values()) < kills and not problems:
            sort = min(counts, key=lambda key: counts[key])
            if _killed(scene, folder, out, sort, whole, rng, problems):
                counts[sort] += 1
            elif not problems:  # it came to its end before
                finished += 1
                problems += _differences(out, whole)
                shutil.rmtree(out)
        if out.exists() and not problems:
            _run(scene, folder, out, ("never", 0, "x"), problems)
            finished += 1
            problems += _differences(out, whole)
    return Outcome(counts, finished, problems, time.perf_counter() - begun)


class _Whole(NamedTuple):
    """The undisturbed run: digests of what must be the same, names of all files, names in the order of writing."""

    digests: dict[str, str]
    files: set[str]
    written: list[str]
    seconds: float


def _whole(scene: Scene, folder: Path, problems: list[str]) -> _Whole:
    out, log = folder / "whole", folder / "written"
    begun = time.perf_counter()
    _run(scene, folder, out, ("never", 0, "x"), problems, log=str(log))
    seconds = time.perf_counter() - begun
    problems += broken_files(out)
    return _Whole(held(out), _names(out), log.read_text().split(), seconds)


def _killed(
    scene: Scene, folder: Path, out: Path, sort: str, whole: _Whole, rng: random.Random, problems: list[str]
) -> bool:
    """Begin or go on, and kill; False where it was done before that."""
    if sort == "time":
        order, limit = ("never", 0, "x"), rng.uniform(0.3, 1.1 * whole.seconds)
    else:
        pattern = scene.kept if sort == "checkpoint" else scene.outputs
        moment = rng.choice(MOMENTS)
        writes = sum(bool(re.search(pattern, name)) for name in whole.written)
        order, limit = (moment, rng.randint(1, max(1, writes)), pattern), LIMIT
    status = _run(scene, folder, out, order, problems, limit=limit)
    problems += broken_files(out)
    return status == -signal.SIGKILL


def _run(
    scene: Scene, folder: Path, out: Path, order: tuple[str, int, str], problems: list[str], *, limit: float = LIMIT,
    log: str = "-",
) -> int:  # fmt: skip
    """Run the scene's program, armed; its status, which is told where it is neither 0 nor SIGKILL's."""
    moment, number, pattern = order
    program = [sys.executable, "-m", f"{__package__}.interruptions_killer", moment, str(number), pattern, log]
    with subprocess.Popen(
        [*program, *scene.command(folder, out)],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        try:
            _, errors = running.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            running.kill()
            _, errors = running.communicate()
            if limit == LIMIT:
                problems.append(f"not done within {LIMIT:g} s")
    if running.returncode not in (0, -signal.SIGKILL):
        problems.append(f"status {running.returncode} after {order}: {errors.strip()[-500:]}")
    return running.returncode


def _differences(out: Path, whole: _Whole) -> list[str]:
    found = held(out)
    wrong = [f"other bits in {name}" for name, digest in whole.digests.items() if found.get(name) != digest]
    names = _names(out)
    return wrong + [f"{name} is missing or too many" for name in sorted(names ^ whole.files)]


def _names(out: Path) -> set[str]:
    return {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}
