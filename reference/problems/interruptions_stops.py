"""Runs that are stopped as Ctrl-C does, and runs whose worker processes are killed; then gone on with."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from geodem.io.run_folder import resumable

from .interruptions_disks import undisturbed
from .interruptions_files import broken_files, differences, done_runs, held, names
from .interruptions_processes import end_all, left_behind, marked, start
from .interruptions_scenes import Scene

LIMIT = 120.0
"""Longest time of one run, and of a stop [s]."""
EARLIEST, SHORTEST = 1.0, 4.0
"""Of the run; before the first the program is being loaded, and none is done before the second [s]."""
WORKER = "worker"
"""Stands in the commands of processes that do a part of the work."""


def ctrl_c(scene: Scene, folder: Path, times: int, rng: random.Random) -> tuple[int, list[str]]:
    """How many runs were stopped, and what was wrong: status, words, processes left, bits."""

    def press(scene: Scene, folder: Path, out: Path, after: float, twice: bool, problems: list[str]) -> int:
        # a script of the user's has no word in how Python ends
        return _press(scene, folder, out, after, twice and scene.overwrites, problems)

    return _disturb(scene, folder, times, rng, press)


def killed_worker(scene: Scene, folder: Path, times: int, rng: random.Random) -> tuple[int, list[str]]:
    """The same where one of the run's own processes is killed; the run says so and can be gone on with."""
    return _disturb(scene, folder, times, rng, _kill_worker)


How = Callable[[Scene, Path, Path, float, bool, list[str]], int]


def _disturb(scene: Scene, folder: Path, times: int, rng: random.Random, how: How) -> tuple[int, list[str]]:
    begun = time.perf_counter()
    problems, whole, out = undisturbed(scene, folder), folder / "whole", folder / "out"
    seconds = max(time.perf_counter() - begun, SHORTEST)
    digests, files = held(whole), names(whole)
    stopped = 0
    for number in range(times):
        if problems:
            break
        stopped += how(scene, folder, out, rng.uniform(EARLIEST, 0.75 * seconds), number % 2 == 1, problems)
        problems += broken_files(out)
        before = done_runs(out)
        _through(scene, folder, out, problems)
        problems += differences(out, digests, files)
        again = [name for name, at in before.items() if done_runs(out).get(name) != at]
        problems += [f"{name} was done, and written again" for name in again]
        shutil.rmtree(out)
    return stopped, problems


def _through(scene: Scene, folder: Path, out: Path, problems: list[str]) -> float:
    """Run to the end; seconds that it took."""
    begun = time.perf_counter()
    command = [sys.executable, "-m", *scene.command(folder, out)]
    running = start(command)
    errors = running.wait(LIMIT)
    if running.process.returncode:
        problems.append(f"status {running.process.returncode} of a run that goes on: {errors.strip()[-300:]}")
    return time.perf_counter() - begun


def _press(scene: Scene, folder: Path, out: Path, after: float, twice: bool, problems: list[str]) -> int:
    """Ctrl-C after so long, to the whole group as a terminal sends it; 1 where it stopped the run."""
    running = start([sys.executable, "-m", *scene.command(folder, out)])
    time.sleep(after)
    for pause in (0.2, 0.0) if twice else (0.0,):
        if running.process.poll() is None:
            os.killpg(running.process.pid, signal.SIGINT)
            time.sleep(pause)
    try:
        errors = running.wait(LIMIT)
    except subprocess.TimeoutExpired:
        problems.append(f"Ctrl-C after {after:.1f} s: it goes on")
        end_all(running.mark)
        return 0
    status = running.process.returncode
    now = held(out)
    if status == -signal.SIGINT and (
        now.get("result.json", "").startswith("done") or now == held(folder / "whole")
    ):
        status = 0  # the program was about to end
    if left := left_behind(running.mark, 1.0):
        problems.append(f"Ctrl-C after {after:.1f} s leaves {len(left)} processes behind")
        end_all(running.mark)
    if status not in (0, 3) or "Traceback" in errors:
        problems.append(f"Ctrl-C after {after:.1f} s: status {status}: {errors.strip()[-500:]}")
    elif status == 3:
        words = ("resume",) if resumable(out) else ("begins again", "nothing was begun")
        if not any(word in errors for word in words):
            problems.append(
                f"Ctrl-C after {after:.1f} s: it does not say how to go on: {errors.strip()[-300:]}"
            )
    return int(status == 3)


def _kill_worker(
    scene: Scene, folder: Path, out: Path, after: float, twice: bool, problems: list[str]
) -> int:
    """Kill -9 one process that does a part of the work, or all of them; 1 where the run noticed."""
    running = start([sys.executable, "-m", *scene.command(folder, out)])
    end = time.monotonic() + LIMIT
    while (
        not (found := marked(running.mark, WORKER))
        and running.process.poll() is None
        and time.monotonic() < end
    ):
        time.sleep(0.05)
    time.sleep(0.3 * after)
    for number in (found := marked(running.mark, WORKER) if twice else marked(running.mark, WORKER)[:1]):
        os.kill(number, signal.SIGKILL)
    errors = running.wait(LIMIT)
    if left_behind(running.mark, 1.0):
        problems.append("processes left behind")
        end_all(running.mark)
    if running.process.returncode not in (0, 2) or "Traceback" in errors:
        problems.append(f"a worker killed: status {running.process.returncode}: {errors.strip()[-500:]}")
    if running.process.returncode and "ended from outside" not in errors:
        problems.append(f"a worker killed: it does not say so: {errors.strip()[-300:]}")
    return int(bool(found))
