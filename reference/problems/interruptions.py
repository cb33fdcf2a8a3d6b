"""Runs ended by force at random moments and in the midst of what they write; then gone on with, to the same bits.

Every scene is run once undisturbed. Then it is begun, killed, begun again from what it left, killed again, ... until
it is done: it must hold the bits of the undisturbed run, and at every moment every file in its folder must be whole.
Then it is stopped as Ctrl-C does, run into full disks and locked folders, and resumed from spoilt files.
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
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from .interruptions_disks import full_disks, full_file_system, read_only
from .interruptions_files import broken_files, differences, done_runs, held, names
from .interruptions_killer import MOMENTS
from .interruptions_processes import end_all, left_behind, start
from .interruptions_scenes import SCENES, Scene, make_older, next_command
from .interruptions_shares import in_shares
from .interruptions_spoilt import spoilt
from .interruptions_stops import ctrl_c, killed_worker
from .rows import Row

KILLS = {
    "slope": 12,
    "ground": 33,
    "laboratory": 12,
    "particles": 36,
    "tunnel": 27,
    "breaking": 24,
    "cutting": 30,
    "runout": 21,
    "sweep": 9,
}
"""Of each scene; a third at random moments, a third while it writes what it goes on from, a third in its outputs."""
STOPS = 2
"""Ctrl-C of each scene; every second one is pressed twice."""
WORKERS = {"laboratory": 1, "sweep": 2}
"""Processes killed of scenes that have such."""
OVERWRITTEN = 0.4
"""Share of runs that are begun over the results of another case."""
SEED = 20261130
WORDS = {
    "time": "at a random moment",
    "checkpoint": "in writing what it goes on from",
    "outputs": "in writing its outputs",
}
LIMIT = 300.0
"""Longest time of one run [s]."""
ORPHANS = 60.0
"""Longest time that processes of a killed run go on for [s]."""
NEVER = ("never", 0, "x")


class Outcome(NamedTuple):
    """What came of a scene's kills."""

    kills: dict[str, int]
    finished: int
    problems: list[str]
    seconds: float


def run() -> Sequence[Row]:
    """Every scene: kills of each sort, runs that were brought to their end, and what was wrong."""
    return in_shares(
        list(KILLS),
        lambda name: [
            *_of_kills(name, KILLS[name], disturb(SCENES[name], KILLS[name], SEED)),
            *_of_others(name, SCENES[name]),
        ],
    )


def _of_kills(name: str, kills: int, outcome: Outcome) -> list[Row]:
    for problem in outcome.problems:
        print(f"{name}: {problem}")
    source = f"seed {SEED}; {outcome.finished} runs brought to their end"
    done, wrong = sum(outcome.kills.values()), len(outcome.problems)
    rows = [
        Row(name, f"kills {WORDS[sort]}", count, kills / 3, 0.0, 0.0, outcome.seconds, source)
        for sort, count in outcome.kills.items()
    ]
    short = min(done / kills - 1.0, 0.0)
    rows.append(Row(name, "kills in all", done, kills, short, 0.0, outcome.seconds, "asked for"))
    rows.append(
        Row(name, "broken files, other bits, errors", wrong, 0.0, wrong, 0.0, outcome.seconds, "wanted")
    )
    return rows


Examine = Callable[[Scene, Path], tuple[int, list[str]]]


def _of_others(name: str, scene: Scene) -> list[Row]:
    """Stops, full and locked disks, spoilt files: how many runs they met, and what was wrong with how."""

    def stopped(scene: Scene, folder: Path) -> tuple[int, list[str]]:
        return ctrl_c(scene, folder, STOPS, random.Random(SEED))

    def without_worker(scene: Scene, folder: Path) -> tuple[int, list[str]]:
        return killed_worker(scene, folder, WORKERS[name], random.Random(SEED))

    trials: dict[str, Examine] = {"ended by Ctrl-C": stopped}
    if name in WORKERS:
        trials["ended by a killed process of theirs"] = without_worker
    trials |= {
        "ended by a full file": full_disks,
        "ended by a full file system": full_file_system,
        "ended by a locked folder": read_only,
        "gone on with from spoilt files": spoilt,
    }
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for what, examine in trials.items():
            begun = time.perf_counter()
            met, problems = examine(scene, Path(folder))
            for problem in problems:
                print(f"{name}, {what}: {problem}")
            seconds, wrong = time.perf_counter() - begun, len(problems)
            rows.append(Row(name, f"runs {what}", met, met, 0.0, 0.0, seconds, "counted"))
            rows.append(Row(name, f"wrong with runs {what}", wrong, 0.0, wrong, 0.0, seconds, "wanted"))
    return rows


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
            if not out.exists() and scene.overwrites and rng.random() < OVERWRITTEN:
                make_older(folder / "whole", out)
            sort = min(counts, key=lambda key: counts[key])
            if _killed(scene, folder, out, sort, whole, rng, problems):
                counts[sort] += 1
            elif not problems:  # it came to its end before
                finished += 1
                problems += differences(out, whole.digests, whole.files)
                shutil.rmtree(out)
        if out.exists() and not problems:
            _run(scene, folder, out, NEVER, problems)
            finished += 1
            problems += differences(out, whole.digests, whole.files)
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
    _run(scene, folder, out, NEVER, problems, log=str(log))
    seconds = time.perf_counter() - begun
    problems += broken_files(out)
    return _Whole(held(out), names(out), log.read_text().split(), seconds)


def _killed(
    scene: Scene, folder: Path, out: Path, sort: str, whole: _Whole, rng: random.Random, problems: list[str]
) -> bool:
    """Begin or go on, and kill; False where it was done before that."""
    before = done_runs(out)
    if sort == "time":
        order, limit = NEVER, rng.uniform(0.3, 0.8 * whole.seconds)
    else:
        pattern = scene.kept if sort == "checkpoint" else scene.outputs
        moment = rng.choice(MOMENTS)
        writes = sum(bool(re.search(pattern, name)) for name in whole.written)
        order, limit = (moment, rng.randint(1, max(1, round(0.7 * writes))), pattern), LIMIT
    orphans = rng.choice(("killed", "waited", "left"))
    status = _run(scene, folder, out, order, problems, limit=limit, after=orphans)
    problems += broken_files(out)
    after = done_runs(out)
    problems += [f"{name} was done, and written again" for name in before if before[name] != after.get(name)]
    return status == -signal.SIGKILL


def _run(
    scene: Scene, folder: Path, out: Path, order: tuple[str, int, str], problems: list[str], *, limit: float = LIMIT,
    log: str = "-", after: str = "waited",
) -> int:  # fmt: skip
    """Run the scene's program, armed; its status, which is told where it is neither 0 nor SIGKILL's.

    `after`: what comes of its processes once the first one is killed after `limit`: "killed" as well, "waited" for, or
    "left" to end while the run is gone on with.
    """
    moment, number, pattern = order
    program = [
        sys.executable,
        "-m",
        f"{__package__}.interruptions_killer",
        moment,
        str(number),
        pattern,
        log,
        scene.often,
    ]
    running = start([*program, *next_command(scene, folder, out)])
    try:
        errors = running.wait(limit)
    except subprocess.TimeoutExpired:
        running.process.kill()
        if after == "killed":
            end_all(running.mark)
        errors = running.wait()
        if limit == LIMIT:
            problems.append(f"not done within {LIMIT:g} s")
    status = running.process.returncode
    if status not in (0, -signal.SIGKILL):
        problems.append(f"status {status} after {order}: {errors.strip()[-500:]}")
    if after == "waited" and left_behind(running.mark, ORPHANS):
        problems.append(f"its processes go on for {ORPHANS:g} s after it was killed, {order}")
        end_all(running.mark)
    return int(status)
