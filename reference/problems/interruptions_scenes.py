"""Small runs of every kind to be interrupted, and what their folders hold."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from PIL import Image

from geodem.case.any_kind import load_any
from geodem.errors import InputError
from geodem.io.checkpoint import FORMATS, checksum, read_checkpoint
from geodem.io.history import read_history
from geodem.io.run_folder import PART, resumable
from geodem.laboratory.orders import TEST

from . import fuzzing_files

SLOPE = """\
workflow = "slope"
title = "Small slope"
particles = 1650
methods = ["strength-reduction", "gravity-increase"]
tolerance = 0.05
seed = 3

[section]
regions = [{material = "soil", polygon = [[0,0],[40,0],[40,15],[25,15],[10,5],[0,5]]}]

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
""" + fuzzing_files.SOIL.replace("{name}", "soil")
"""Coarse model, particles placed anew where it failed, both methods, the search without dilation."""

GROUND = """\
workflow = "ground"
title = "Bank"

[source]
image = "section.png"
scale = "0.5 m/px"
legend = {"#8c6d31" = "soil", "#d62728" = "seam"}

[particles]
particles = 300

[material.soil]
density = "1900 kg/m3"

[material.seam]
density = "2100 kg/m3"
"""
LABORATORY = """\
workflow = "laboratory"
title = "Small granite"
seeds = 6

[specimen]
across = 10

[material]
law = "rock"
density = "2630 kg/m3"
effective_modulus = "80 GPa"
stiffness_ratio = 2.5
tensile_strength = "15 MPa"
shear_strength = "60 MPa"
friction_coefficient = 0.7

[[test]]
kind = "direct-tension"
"""


class Scene(NamedTuple):
    """A run to be interrupted.

    Attributes
    ----------
    prepare : callable
        Makes what it needs in a folder.
    command : callable
        (folder, out) -> module and arguments that begin it, or go on with what `out` holds.
    kept, outputs : str
        Patterns of the files that it goes on from, and of the others.
    """

    prepare: Callable[[Path], None]
    command: Callable[[Path, Path], list[str]]
    kept: str
    outputs: str


def _case(text: str, how: str = "run") -> Scene:
    def prepare(folder: Path) -> None:
        fuzzing_files.write_sources(folder / "case")
        (folder / "case" / "case.toml").write_text(text)

    def command(folder: Path, out: Path) -> list[str]:
        if resumable(out):
            return ["geodem", "resume", str(out), "--threads", "1"]
        return ["geodem", how, str(folder / "case"), "--out", str(out), "--threads", "1"]

    return Scene(prepare, command, r"\.h5$|filling\.npz$", r"^(?!.*\.(h5|npz)$)")


SCENES = {
    "slope": _case(SLOPE),
    "ground": _case(GROUND),
    "laboratory": _case(LABORATORY, "lab"),
    "particles": Scene(
        lambda folder: None,
        lambda folder, out: [f"{__package__}.interruptions_particles", str(out)],
        r"checkpoint\.h5$",
        r"^(?!.*\.h5$)",
    ),
}


def held(out: Path) -> dict[str, str]:
    """Digests of what must have the same bits however the run was interrupted, by name."""
    found = {}
    for path in sorted(out.rglob("*")):
        name = str(path.relative_to(out))
        if name in ("history.csv", "filling.npz") or path.suffix in (".vtkhdf", ".series"):
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        elif name == "result.json":
            result = json.loads(path.read_text())
            found[name] = f"{result['status']} {result.get('digest')} {result.get('particles')}"
        elif name == "checkpoint.h5" and not (out / "result.json").exists():
            found[name] = _state(path)
    # times of tests stand in the laboratory's history and frames do not tell of them
    if (out / "tests").is_dir():
        found.pop("history.csv", None)
    return found


def _state(path: Path) -> str:
    """Positions, velocities and step of a checkpoint of particles; how batches were cut stands in it too."""
    state = read_checkpoint(path, FORMATS["geodem-particles"])["state"]
    arrays = {name: value for name, value in state.items() if isinstance(value, np.ndarray)}
    return checksum(arrays) + str(state["plain"]["numbers"]["steps"])


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
