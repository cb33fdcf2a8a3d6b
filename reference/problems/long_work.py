"""Long work: the time left that is told while a run of every kind goes on.

The error of a time left is taken over the time of the whole run, and looked at after its first tenth. Kernels were
compiled before, so that a small run is not a run of the compiler. What is asked of memory and of results on the way is
in `long_memory`.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from geodem.particle_recorder import Recorder
from geodem.run_progress import RunUpdate, Work
from geodem.workflow import run_case

from . import interruptions_scenes as scenes
from .fuzzing_judge import ROOT
from .interruptions_particles import falling_block
from .rows import Row

STEPS = 400_000
"""Of the recorded run."""
ERROR = 0.2
"""Largest error of the time left over the time of the whole run, after its first tenth."""
FINE = 6000
"""Particles of the slope whose time left is looked at: three models, a minute or so."""


class Telling(NamedTuple):
    """What a run told at a moment.

    Attributes
    ----------
    at : float
        Since its beginning [s].
    left, most : float
        Time left as expected, and at most where it may be more [s].
    work : Work or None
        What the times are made of.
    """

    at: float
    left: float
    most: float
    work: Work | None


def run() -> Sequence[Row]:
    """A run of every kind, one after the other."""
    rows = []
    for name, tell in RUNS.items():
        told, whole = tell()
        rows += time_rows(name, told, whole)
    return rows


def time_rows(name: str, told: Sequence[Telling], whole: float) -> list[Row]:
    """Errors of the first time left that was told after the first tenth, and of the worst one."""
    after = [each for each in told if each.at > 0.1 * whole and math.isfinite(each.left)]
    errors = [(each.at + each.left - whole) / whole for each in after]
    first = errors[0] if errors else math.inf
    last = max(errors, key=abs, default=math.inf)
    source = f"told {len(after)} times in {whole:.1f} s"
    rows = [
        Row(name, "first time left that was told: error over all", first, 0.0, first, ERROR, whole, source),
        Row(name, "the worst one: error over all", last, 0.0, last, ERROR, whole, source),
    ]
    works = [each.work for each in told if each.work is not None]
    if works:
        error = worst_of_work(works)
        note = "no clock in it: steps, or steps times particles"
        rows.append(Row(name, "the worst work left: error over all", error, 0.0, error, ERROR, whole, note))
    bounded = [each for each in after if math.isfinite(each.most)]
    if bounded:
        above = sum(each.at + each.most < 0.95 * whole for each in bounded)
        note = f"of {len(bounded)} that told a most as well"
        rows.append(
            Row(name, "times that took longer than the most told", above, 0.0, above, 0.0, whole, note)
        )
    return rows


def worst_of_work(told: Sequence[Work]) -> float:
    """Largest error of the work told to be left, over all of it, once a tenth is done."""
    whole = max(work.done for work in told)
    errors = [(work.done + work.left - whole) / whole for work in told if work.done > 0.1 * whole]
    return max(errors, key=abs, default=math.inf)


Told = tuple[list[Telling], float]


def _told(
    case: str, *, quickly: bool = False, threads: int = 1, beside: Mapping[str, str] | None = None
) -> Told:
    """What a case's run tells, as the command line shows it, and how long it took [s]."""
    told: list[Telling] = []
    with tempfile.TemporaryDirectory() as name:
        for file, text in {"case.toml": case, **(beside or {})}.items():
            (Path(name) / file).write_text(text)
        begun = time.perf_counter()

        def watch(update: Any) -> None:
            left, most = (
                float(getattr(update, field, math.nan)) for field in ("seconds_left", "seconds_most")
            )
            told.append(Telling(time.perf_counter() - begun, left, most, getattr(update, "work", None)))

        run_case(Path(name), Path(name) / "out", threads=threads, quickly=quickly, watch=watch)
        return told, time.perf_counter() - begun


def slope() -> Told:
    """The search for a slope's factor by both methods, through three models."""
    text = scenes.SLOPE.replace("particles = 1650", f"particles = {FINE}")
    return _told(text.replace("tolerance = 0.05", "tolerance = 0.01"))


def laboratory() -> Told:
    """Two kinds of tests, four specimens each, one at a time."""
    text = scenes.LABORATORY.replace("seeds = 6", "seeds = 4").replace("across = 10", "across = 20")
    return _told(text + '\n[[test]]\nkind = "uniaxial-compression"\n')


def recorded() -> Told:
    """A recorded run of discs."""
    told: list[Telling] = []
    begun = time.perf_counter()

    def watch(update: RunUpdate) -> None:
        told.append(
            Telling(time.perf_counter() - begun, update.seconds_left, update.seconds_most, update.work)
        )

    with tempfile.TemporaryDirectory() as name:
        Recorder(falling_block(), name, show=False, watch=watch).run_to(STEPS)
    return told, time.perf_counter() - begun


def template(kind: str, **changes: str) -> Told:
    """The case that `geodem new` makes, in its quick form."""
    text = (ROOT / "geodem" / "templates" / kind / "case.toml").read_text()
    return _told(text, quickly=True)


def sweep() -> Told:
    """Six small slopes, two at a time."""
    case = """\
workflow = "sweep"
title = "Cohesion of a small slope"
case = "slope.toml"
processes = 2

[vary]
"material.soil.cohesion" = {from = "8 kPa", to = "18 kPa", count = 6}
"""
    return _told(case, threads=2, beside={"slope.toml": scenes.SLOPE})


RUNS: dict[str, Callable[[], Told]] = {
    "slope, both methods, three models": slope,
    "laboratory, eight tests": laboratory,
    "recorded discs": recorded,
    "breaking ground, four stages": lambda: template("breaking"),
    "cutting": lambda: template("cutting"),
    "tunnel, three stages and a factor": lambda: template("tunnel"),
    "run-out": lambda: template("runout"),
    "sweep, six runs": sweep,
    "calibration": lambda: template("calibration"),
}
"""Small runs of every kind that takes long."""
