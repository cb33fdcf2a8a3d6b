"""Runs that find what they would go on from cut off, changed or of another format: refused in words, or done anew."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py

from geodem.io.files import read_json

from .fuzzing_judge import ROOT
from .interruptions_disks import undisturbed
from .interruptions_files import content, held
from .interruptions_scenes import Scene, overwriting


def spoilt(scene: Scene, folder: Path) -> tuple[int, list[str]]:
    """How many times a killed run was gone on with from spoilt files, and what was wrong with how."""
    problems, whole, begun = undisturbed(scene, folder), folder / "whole", folder / "begun"
    tried = 0
    for spoil in (_cut_off, _changed, _old):
        _begin(scene, folder, begun)
        files = sorted(path for path in begun.rglob("*") if path.suffix in (".h5", ".npz"))
        if spoil is _old:
            files = [path for path in files if path.suffix == ".h5"]
        if not files:
            shutil.rmtree(begun)
            continue
        for path in files:
            spoil(path)
        before = content(begun)
        command = [sys.executable, "-m", *scene.command(folder, begun)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
        tried += 1
        words = " ".join(done.stderr.split())
        if done.returncode not in (0, 2) or "Traceback" in words:
            problems.append(f"{spoil.__name__}: status {done.returncode}: {done.stderr.strip()[-300:]}")
        elif done.returncode == 2 and not any(path.name in words for path in files):
            problems.append(f"{spoil.__name__}: it does not say which file: {words[-300:]}")
        elif done.returncode == 2 and {name: content(begun).get(name) for name in before} != before:
            problems.append(f"{spoil.__name__}: refused, and yet written over")
        elif done.returncode == 0:
            if (read_json(begun / "result.json") or {}).get("failed"):
                # a run of a sweep, told in its table with what to do
                command = [sys.executable, "-m", *overwriting(scene, folder, begun)]
                subprocess.run(command, cwd=ROOT, capture_output=True, check=False, timeout=300)
            if held(begun) != held(whole):
                problems.append(f"{spoil.__name__}: other bits: {held(begun)}, not {held(whole)}")
        shutil.rmtree(begun)
    return tried, problems


def _begin(scene: Scene, folder: Path, out: Path) -> None:
    """A run that was killed after the second of its files that it goes on from, or the first."""
    for number in ("2", "1"):
        shutil.rmtree(out, ignore_errors=True)
        order = ["after", number, scene.kept, "-", scene.often]
        program = [sys.executable, "-m", f"{__package__}.interruptions_killer", *order]
        done = subprocess.run(
            [*program, *scene.command(folder, out)], cwd=ROOT, capture_output=True, check=False, timeout=300
        )
        if done.returncode == -signal.SIGKILL:
            return


Spoil = Callable[[Path], None]


def _cut_off(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _changed(path: Path) -> None:
    """Other bytes in the middle, where the arrays are."""
    held = bytearray(path.read_bytes())
    middle = len(held) // 2
    held[middle : middle + 64] = bytes(byte ^ 0x55 for byte in held[middle : middle + 64])
    path.write_bytes(held)


def _old(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 0
