"""Runs into folders that are full or may not be written to: refused in words, nothing lost, gone on with later."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from .fuzzing_judge import ROOT
from .interruptions_files import broken_files, content, held
from .interruptions_scenes import Scene, overwriting

ROOMS = (200, 5_000, 60_000)
"""Largest file that may be written [B]; each ends a run in another of its files."""
WORDS = ("larger than is allowed", "not permitted", "disk is full", "read-only")


def undisturbed(scene: Scene, folder: Path) -> list[str]:
    """Have the scene prepared, and run undisturbed into "whole", where that is not so yet; what was wrong."""
    if (folder / "whole").is_dir():
        return []
    scene.prepare(folder)
    return _answer(scene, folder, folder / "whole", [], {0})


def full_disks(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """How many runs were ended by a file that became too large, and what was wrong."""
    problems, whole, out = undisturbed(scene, folder), folder / "whole", folder / "full"
    ended = 0
    for room in ROOMS:
        limit = ["prlimit", f"--fsize={room}", "--"]
        before = content(out)
        found = _answer(scene, folder, out, limit, {0, 2, 3})
        problems += [f"room for {room} B: {problem}" for problem in found]
        problems += [f"room for {room} B: {broken}" for broken in broken_files(out)]
        lost = [name for name in before if name not in content(out)]
        problems += [f"room for {room} B: {name} is gone" for name in lost if not name.endswith(".part")]
        ended += held(out) != held(whole)
    problems += _answer(scene, folder, out, [], {0})
    if held(out) != held(whole):
        problems.append("other bits once there was room")
    return ended, problems


def full_file_system(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """As `full_disks`, with a file system of its own that is full; no runs where this machine makes none."""
    ended, problems = 0, undisturbed(scene, folder)
    for size in (16, 100):
        out = folder / f"room-{size}"
        out.mkdir()
        # what is on it goes with the process, so it is copied out before
        script = (
            'mount -t tmpfs -o size="$1"k none "$2" || exit 77; inner="$2"; kept="$3"; shift 3; "$@"; status=$?; '
            'cp -a "$inner" "$kept"; exit $status'
        )
        prefix = [
            "unshare",
            "-rm",
            "sh",
            "-c",
            script,
            "sh",
            str(size),
            str(out),
            str(folder / f"kept-{size}"),
        ]
        command = [*prefix, sys.executable, "-m", *scene.command(folder, out)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
        if done.returncode == 77:
            return 0, []
        problems += [f"{size} kB: {problem}" for problem in _problems(done, {0, 2, 3})]
        problems += [f"{size} kB: {broken}" for broken in broken_files(folder / f"kept-{size}")]
        ended += done.returncode != 0
    return ended, problems


def read_only(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """How many runs were refused by folders that may not be written to, and what was wrong with how.

    The folder of a stranger's file, one below it, that of a run that was ended half-way, that of a finished run.
    """
    problems, whole, begun = undisturbed(scene, folder), folder / "whole", folder / "begun"
    _answer(scene, folder, begun, ["prlimit", f"--fsize={ROOMS[-1]}", "--"], {0, 2, 3})
    foreign = folder / "foreign"
    foreign.mkdir()
    (foreign / "mine.txt").write_text("mine")
    refused = 0
    trials: list[tuple[Path, Path, list[str], set[int]]] = [
        (locked, out, scene.command(folder, out), allowed)
        for locked, out, allowed in (
            (foreign, foreign, {2}),
            (foreign, foreign / "below", {2}),
            (begun, begun, {2}),
            (whole, whole, {0, 2}),  # a finished run has nothing left to do
        )
    ]
    if scene.overwrites:
        trials.append((whole, whole, overwriting(scene, folder, whole), {2}))
    for locked, out, command, allowed in trials:
        before = content(locked)
        places = [locked, *(place for place in locked.rglob("*") if place.is_dir())]
        for place in places:
            place.chmod(0o555)
        try:
            found = _told([*_as_others(), sys.executable, "-m", *command], allowed)
        finally:
            for place in places:
                place.chmod(0o755)
        problems += [f"{out.name}: {problem}" for problem in found]
        if content(locked) != before:
            problems.append(f"{out.name}: the folder was changed")
        refused += not found
    problems += _answer(scene, folder, begun, [], {0})
    if held(begun) != held(whole):
        problems.append("other bits once it was unlocked")
    return refused, problems


def _as_others() -> list[str]:
    """Root may write anywhere; it is made to heed permissions as everyone does."""
    if os.geteuid() != 0:
        return []
    return [str(shutil.which("setpriv")), "--bounding-set=-dac_override,-dac_read_search", "--"]


def _answer(scene: Scene, folder: Path, out: Path, prefix: list[str], allowed: set[int]) -> list[str]:
    """Run the scene; what is wrong with its status and its words."""
    return _told([*prefix, sys.executable, "-m", *scene.command(folder, out)], allowed)


def _told(command: list[str], allowed: set[int]) -> list[str]:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
    return _problems(done, allowed)


def _problems(done: subprocess.CompletedProcess[str], allowed: set[int]) -> list[str]:
    problems = []
    if done.returncode not in allowed:
        problems.append(f"status {done.returncode}: {done.stderr.strip()[-300:]}")
    if "Traceback" in done.stderr:
        problems.append(f"a traceback: {done.stderr.strip()[-300:]}")
    if done.returncode and not any(word in " ".join(done.stderr.split()) for word in WORDS):
        problems.append(f"it does not say why: {done.stderr.strip()[-300:]}")
    return problems
