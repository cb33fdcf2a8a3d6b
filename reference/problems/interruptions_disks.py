"""Runs into folders that are full or may not be written to: refused in words, nothing lost, gone on with later."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from .fuzzing_judge import ROOT
from .interruptions_scenes import Scene, broken_files, held

ROOMS = (200, 3_000, 20_000, 100_000)
"""Largest file that may be written [B]; each ends a run in another of its files."""
WORDS = ("larger than is allowed", "not permitted", "disk is full", "read-only")


def full_disks(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """How many runs were ended by a file that became too large, and what was wrong."""
    scene.prepare(folder)
    whole, out = folder / "whole", folder / "full"
    problems = _answer(scene, folder, whole, [], {0})
    ended = 0
    for room in ROOMS:
        limit = ["prlimit", f"--fsize={room}", "--"]
        before = _content(out)
        found = _answer(scene, folder, out, limit, {0, 2, 3})
        problems += [f"room for {room} B: {problem}" for problem in found]
        problems += [f"room for {room} B: {broken}" for broken in broken_files(out)]
        lost = [name for name in before if name not in _content(out)]
        problems += [f"room for {room} B: {name} is gone" for name in lost if not name.endswith(".part")]
        ended += held(out) != held(whole)
    problems += _answer(scene, folder, out, [], {0})
    if held(out) != held(whole):
        problems.append("other bits once there was room")
    return ended, problems


def full_file_system(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """As `full_disks`, with a file system of its own that is full; no runs where this machine makes none."""
    scene.prepare(folder)
    ended, problems = 0, []
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


def read_only(scene: Scene, folder: Path) -> list[str]:
    """What is wrong with how a folder that may not be written to is refused."""
    scene.prepare(folder)
    locked = folder / "locked"
    locked.mkdir()
    (locked / "mine.txt").write_text("mine")
    before = _content(locked)
    locked.chmod(0o555)
    try:
        problems = _answer(scene, folder, locked, _as_others(), {2, 3})
        problems += _answer(scene, folder, locked / "below", _as_others(), {2, 3})
    finally:
        locked.chmod(0o755)
    if _content(locked) != before:
        problems.append("the folder was changed")
    return problems


def _as_others() -> list[str]:
    """Root may write anywhere; it is made to heed permissions as everyone does."""
    if os.geteuid() != 0:
        return []
    return [str(shutil.which("setpriv")), "--bounding-set=-dac_override,-dac_read_search", "--"]


def _answer(scene: Scene, folder: Path, out: Path, prefix: list[str], allowed: set[int]) -> list[str]:
    """Run the scene; what is wrong with its status and its words."""
    command = [*prefix, sys.executable, "-m", *scene.command(folder, out)]
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


def _content(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
