"""Small cases for the tests of the whole chain, and how they are run as a program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from geodem.run_progress import Work

ROOT = Path(__file__).resolve().parent.parent

SLOPE = """\
workflow = "slope"
title = "Small slope"
particles = 500
methods = ["strength-reduction", "gravity-increase"]
tolerance = 0.02
seed = 3

[section]
regions = [{material = "soil", polygon = [[0,0],[40,0],[40,15],[25,15],[10,5],[0,5]]}]

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"

[material.soil]
law = "mohr_coulomb"
unit_weight = "20 kN/m3"
cohesion = "10 kPa"
friction_angle = "20 deg"
dilation_angle = "20 deg"
young_modulus = "100 MPa"
poisson_ratio = 0.3
"""

# a coarse model, a second set of particles where it failed, and the search without dilation: every stage of a run
STAGES = (
    SLOPE.replace("particles = 500", "particles = 1650")
    .replace("tolerance = 0.02", "tolerance = 0.05")
    .replace('dilation_angle = "20 deg"\n', "")
)


class Answer:
    """What a command printed and how it ended."""

    def __init__(self, status: int, out: str, err: str) -> None:
        self.status, self.out, self.err = status, out, err


def write_case(folder: Path, text: str = SLOPE) -> Path:
    """A folder that holds a case."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(text)
    return folder


def environment(**more: str) -> dict[str, str]:
    """Of a geodem that is started as a program; two threads are possible in it."""
    return {**os.environ, "NUMBA_NUM_THREADS": "2", "PYTHONPATH": str(ROOT), **more}


def geodem(*arguments: object, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a command of geodem as a user does."""
    command = [sys.executable, "-m", "geodem", *map(str, arguments)]
    return subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=120, check=False, **options
    )


def works_of(updates: Iterable[Any]) -> list[Work]:
    """What a run told of its work."""
    return [update.work for update in updates if getattr(update, "work", None) is not None]


def forecast_error(works: Sequence[Work], *, after: float = 0.1) -> float:
    """Largest error of the work that was told to be left, over all the work, once a share of it is done; no clock."""
    whole = max(work.done for work in works)
    late = [work for work in works if work.done > after * whole]
    assert len(late) > 3
    return max(abs(work.done + work.left - whole) for work in late) / whole


def history_begun(part: Path, whole: Path) -> bool:
    """Whether a run that was broken off has left lines of its history, and they are the first of the whole one's."""
    kept = (part / "history.csv").read_bytes()
    return kept.count(b"\n") > 1 and (whole / "history.csv").read_bytes().startswith(kept)


def result_of(folder: Path) -> dict[str, Any]:
    """What result.json holds."""
    return dict(json.loads((folder / "result.json").read_text()))
