"""Small runs of every kind to be interrupted."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from geodem.io.run_folder import resumable

from . import fuzzing_files
from . import interruptions_cases as cases
from .interruptions_cases import GROUND, LABORATORY, SLOPE
from .interruptions_files import broken_files, held

__all__ = ["GROUND", "LABORATORY", "SCENES", "SLOPE", "Scene", "broken_files", "held"]

OTHERS = r"^(?!.*\.(h5|npz)$)"
"""Files that nothing is gone on from."""


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
    often : str
        MODULE:NAME of the time between two places that can be gone on from [s]. A small run would be over before the
        first one, so that it is made short.
    overwrites : bool
        It can be told to take away what is in its folder.
    """

    prepare: Callable[[Path], None]
    command: Callable[[Path, Path], list[str]]
    kept: str = r"\.h5$"
    outputs: str = OTHERS
    often: str = ""
    overwrites: bool = True


def _case(text: str, how: str = "run", *, kept: str = r"\.h5$", often: str = "") -> Scene:
    def prepare(folder: Path) -> None:
        fuzzing_files.write_sources(folder / "case")
        (folder / "case" / "case.toml").write_text(text)
        (folder / "case" / "bank.toml").write_text(cases.BANK)

    def command(folder: Path, out: Path) -> list[str]:
        if resumable(out):
            return ["geodem", "resume", str(out), "--threads", "1"]
        return ["geodem", how, str(folder / "case"), "--out", str(out), "--threads", "1"]

    return Scene(prepare, command, kept, OTHERS, often)


OLDER = "Another title"


def make_older(whole: Path, out: Path) -> None:
    """A folder that holds the finished run of another case of the same kind."""
    shutil.copytree(whole, out)
    for name, pattern, text in (
        ("case.toml", r"^title = .*$", f'title = "{OLDER}"'),
        ("result.json", r'"identity": ".*?"', '"identity": "another"'),
    ):
        held = (out / name).read_text()
        (out / name).write_text(re.sub(pattern, text, held, count=1, flags=re.MULTILINE))


def next_command(scene: Scene, folder: Path, out: Path) -> list[str]:
    """As of the scene; written over what `make_older` left, for as long as that stands there."""
    if not (out / "case.toml").is_file() or OLDER not in (out / "case.toml").read_text():
        return scene.command(folder, out)
    return overwriting(scene, folder, out)


def overwriting(scene: Scene, folder: Path, out: Path) -> list[str]:
    """The command that begins a run and takes away what is in its folder."""
    nowhere = folder / "nowhere"
    command = [str(out) if word == str(nowhere) else word for word in scene.command(folder, nowhere)]
    return [*command, "--overwrite"]


SEARCH = "geodem.analysis:CHECKPOINT_SECONDS"
SCENES = {
    "slope": _case(SLOPE.replace("tolerance = 0.05", "tolerance = 0.1"), often=SEARCH),
    "ground": _case(GROUND, kept=r"filling\.npz$"),
    "laboratory": _case(LABORATORY.replace("seeds = 6", "seeds = 3"), "lab"),
    "particles": Scene(
        lambda folder: None,
        lambda folder, out: [f"{__package__}.interruptions_particles", str(out)],
        overwrites=False,
    ),
    "tunnel": _case(cases.TUNNEL, often="geodem.tunnel_run:KEEP_SECONDS"),
    "breaking": _case(cases.BREAKING, often="geodem.breaking_run:KEEP_SECONDS"),
    "cutting": _case(cases.CUTTING),
    "runout": _case(cases.RUNOUT, often="geodem.runout_run:KEPT_SECONDS"),
    "sweep": _case(cases.SWEEP, "sweep", kept=r"\.h5$|^\d+\.json$", often=SEARCH),
}
