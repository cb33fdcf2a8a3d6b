"""What the folder of an interrupted run holds: what must have the same bits, and what is no whole file."""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
from PIL import Image

from geodem.case.any_kind import load_any
from geodem.errors import InputError
from geodem.io.checkpoint import FORMATS, checksum, read_checkpoint
from geodem.io.history import read_history
from geodem.io.run_folder import PART
from geodem.laboratory.orders import TEST


def held(out: Path) -> dict[str, str]:
    """Digests of what must have the same bits however the run was interrupted, by name."""
    found = {}
    for path in sorted(out.rglob("*")):
        name = str(path.relative_to(out))
        if path.name in ("history.csv", "filling.npz") or path.suffix in (".vtkhdf", ".series"):
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        elif path.name == "result.json":
            result = json.loads(path.read_text())
            found[name] = f"{result['status']} {result.get('digest')} {result.get('particles')}"
        elif path.name == "sweep.csv":
            with path.open(newline="") as table:
                found[name] = str([row[:-1] for row in csv.reader(table)])  # the last one is the run time
        elif name == "checkpoint.h5" and not (out / "result.json").exists() and (state := _state(path)):
            found[name] = state
    # times of tests stand in the laboratory's history and frames do not tell of them
    if (out / "tests").is_dir():
        found.pop("history.csv", None)
    return found


def _state(path: Path) -> str:
    """Positions, velocities and step of a checkpoint of particles; how batches were cut stands in it too."""
    try:
        state = read_checkpoint(path, FORMATS["geodem-particles"])["state"]
    except InputError:
        return ""  # of something else
    arrays = {name: value for name, value in state.items() if isinstance(value, np.ndarray)}
    return checksum(arrays) + str(state["plain"]["numbers"]["steps"])


def done_runs(out: Path) -> dict[str, int]:
    """When the results of finished runs of a sweep were written [ns], by name: they are not written again."""
    return {
        str(path.relative_to(out)): path.stat().st_mtime_ns
        for path in sorted(out.glob("runs/*/result.json"))
        if json.loads(path.read_text())["status"] == "done"
    }


def names(out: Path) -> set[str]:
    """Of all files."""
    return {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}


def content(folder: Path) -> dict[str, bytes]:
    """Of all files, by name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def differences(out: Path, digests: dict[str, str], files: set[str]) -> list[str]:
    """In what a finished folder is not as it should be."""
    found = held(out)
    wrong = [
        f"other bits in {name}: {found.get(name)}, not {digest}"
        for name, digest in digests.items()
        if found.get(name) != digest
    ]
    return wrong + [f"{name} is missing or too many" for name in sorted(names(out) ^ files)]


def broken_files(out: Path) -> list[str]:
    """What is wrong with the files of a folder; those under an unfinished name no reader takes."""
    if not out.exists():
        return []
    wrong = []
    for path in sorted(out.rglob("*")):
        if path.is_dir() or (path.name.startswith(".") and path.name.endswith(".part")):
            continue
        try:
            _READERS[path.suffix](path)
        except Exception as error:
            wrong.append(f"{path.name} is no whole file: {type(error).__name__} {error}")
    return wrong


def _checkpoint(path: Path) -> None:
    for form in (*FORMATS.values(), PART, TEST):
        try:
            read_checkpoint(path, form)
        except InputError:
            continue
        return
    raise ValueError("no checkpoint")


def _history(path: Path) -> None:
    if not path.read_bytes().endswith(b"\n"):
        # of a run in motion: the line that was being written; a resumed run cuts it off
        text = path.read_bytes()
        if b"\n" not in text:
            raise ValueError("no whole line")
    read_history(path)


def _html(path: Path) -> None:
    if not path.read_text(encoding="utf-8").rstrip().endswith("</html>"):
        raise ValueError("no end")


def _frame(path: Path) -> None:
    with h5py.File(path) as file:
        if "VTKHDF" not in file:
            raise ValueError("no frame")


def _picture(path: Path) -> None:
    with Image.open(path) as picture:
        picture.load()


def _archive(path: Path) -> None:
    with np.load(path, allow_pickle=False) as file:
        for name in file.files:
            file[name]


_READERS: dict[str, Callable[[Path], object]] = {
    ".h5": _checkpoint,
    ".json": lambda path: json.loads(path.read_text()),
    ".series": lambda path: json.loads(path.read_text()),
    ".toml": load_any,
    ".csv": _history,
    ".html": _html,
    ".vtkhdf": _frame,
    ".png": _picture,
    ".npz": _archive,
}
