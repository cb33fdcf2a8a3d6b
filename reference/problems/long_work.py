"""Long work: the time left that is told, memory that stays as it is, results that are written as they come.

The error of a time left is taken over the time of the whole run, and looked at after its first tenth.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from geodem.case import load_case
from geodem.io.history import read_history
from geodem.particle_recorder import Recorder
from geodem.simulation import Simulation
from geodem.workflow import run_case

from . import interruptions_scenes as scenes
from .fuzzing_judge import ROOT
from .interruptions_particles import falling_block
from .rows import Row, at_most

STEPS = 100_000
GROWTH = 10.0
"""Largest growth of resident memory over so many steps [MB]."""
ERROR = 0.2
"""Largest error of the time left over the time of the whole run, after its first tenth."""
FINE = 6000
"""Particles of the slope whose time left is looked at: three models, a minute or so."""

Told = list[tuple[float, float]]
"""Time since the beginning, and time left that was told then [s]."""


def run() -> Sequence[Row]:
    """Times left, memory, histories of killed runs."""
    return [
        *slope_time(),
        *laboratory_time(),
        *recorder_time(),
        *memory_of_particles(),
        *memory_of_slope(),
        *histories(),
    ]


def worst(told: Told, whole: float) -> float:
    """Largest error of what was told after the first tenth, over the whole time."""
    errors = [abs(at + left - whole) / whole for at, left in told if at > 0.1 * whole and math.isfinite(left)]
    return max(errors, default=math.inf)


def at_tenth(told: Told, whole: float) -> float:
    """Error of the first time left that was told after the first tenth, over the whole time."""
    return next((at + left - whole) / whole for at, left in told if at > 0.1 * whole and math.isfinite(left))


def _time_rows(name: str, told: Told, whole: float) -> list[Row]:
    source = f"{len(told)} times told in {whole:.1f} s"
    first, last = at_tenth(told, whole), worst(told, whole)
    return [
        Row(name, "time left after a tenth: error over all", first, 0.0, first, ERROR, whole, source),
        Row(name, "largest error after that, over all", last, 0.0, last, ERROR, whole, source),
    ]


def _told(case: str, field: Callable[[Any], float], **options: Any) -> tuple[Told, float]:
    """Times left that a case's run tells, as the command line shows them."""
    told: Told = []
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "case.toml").write_text(case)
        begun = time.perf_counter()
        run_case(
            Path(name), Path(name) / "out", threads=1, **options,
            watch=lambda update: told.append((time.perf_counter() - begun, field(update))),
        )  # fmt: skip
        return told, time.perf_counter() - begun


def slope_time() -> list[Row]:
    """The search for a slope's factor by both methods, through three models."""
    case = scenes.SLOPE.replace("particles = 1650", f"particles = {FINE}").replace(
        "tolerance = 0.05", "tolerance = 0.01"
    )
    told, whole = _told(case, lambda update: float(update.seconds_left))
    return _time_rows("slope, time left", told, whole)


def laboratory_time() -> list[Row]:
    """Tests of particles through the command line's way: two kinds of them, four specimens each, one at a time."""
    text = scenes.LABORATORY.replace("seeds = 6", "seeds = 4") + '\n[[test]]\nkind = "uniaxial-compression"\n'
    told, whole = _told(text, lambda update: float(update.seconds_left))
    return _time_rows("laboratory, time left", told, whole)


def recorder_time() -> list[Row]:
    """A recorded run of discs: the time that its bar shows."""
    from rich.progress import Progress, Task

    told: Told = []
    begun = time.perf_counter()
    update = Progress.update

    def listen(self: Progress, task: Any, **fields: Any) -> None:
        update(self, task, **fields)
        own: Task = self.tasks[0]
        if own.time_remaining is not None:
            told.append((time.perf_counter() - begun, own.time_remaining))

    with tempfile.TemporaryDirectory() as name, _replaced(Progress, "update", listen):
        Recorder(falling_block(), name, show=True).run_to(4 * STEPS)
    return _time_rows("recorded discs, time left", told, time.perf_counter() - begun)


@contextmanager
def _replaced(owner: type, name: str, value: object) -> Iterator[None]:
    old = getattr(owner, name)
    setattr(owner, name, value)
    try:
        yield
    finally:
        setattr(owner, name, old)


def memory_of_particles() -> list[Row]:
    """Recorded discs over so many steps."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        recorder = Recorder(falling_block(), name, checkpoint_seconds=0.5, show=False)
        recorder.run_to(STEPS // 10)
        before = resident()
        recorder.run_to(STEPS // 10 + STEPS)
        grown = resident() - before
    seconds = time.perf_counter() - begun
    return [
        at_most(
            "recorded discs",
            f"memory grown over {STEPS} steps [MB]",
            max(grown, 0.0),
            GROWTH,
            seconds,
            "wanted",
        )
    ]


def memory_of_slope() -> list[Row]:
    """A slope at rest, looked at as a search does."""
    from geodem.building import make_model, make_particles, make_section

    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "case.toml").write_text(scenes.SLOPE)
        case = load_case(name)
    particles = make_particles(case, make_section(case), particles=500)
    simulation = Simulation(make_model(case, particles))
    simulation.begin(simulation.elastic.stress)
    before = 0.0
    looks = []
    for batch in range(STEPS // 50 + 200):
        looks.append(simulation.run(50))
        if batch == 200:
            before = resident()
    grown = resident() - before
    seconds = time.perf_counter() - begun
    return [
        at_most("slope", f"memory grown over {STEPS} steps [MB]", max(grown, 0.0), GROWTH, seconds, "wanted")
    ]


def resident() -> float:
    """Resident memory of this process [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmRSS:"))) / 1024.0


def histories() -> list[Row]:
    """Lines that runs killed half-way leave in history.csv, each a beginning of the whole one."""
    rows = []
    for name in ("slope", "laboratory", "particles"):
        begun = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            lines, whole, fits = _killed_history(scenes.SCENES[name], Path(folder))
        seconds = time.perf_counter() - begun
        source = f"the whole run has {whole}; killed after 0.7 of its time"
        rows.append(
            Row(
                name,
                "lines of a killed run's history, none",
                lines,
                1.0,
                float(lines < 1),
                0.0,
                seconds,
                source,
            )
        )
        rows.append(
            Row(name, "lines that the whole run has not", 1.0 - fits, 0.0, 1.0 - fits, 0.0, seconds, "wanted")
        )
    return rows


def _killed_history(scene: scenes.Scene, folder: Path) -> tuple[int, int, float]:
    """Lines of a killed run and of the whole one, and the share of the first that stand in the second."""
    scene.prepare(folder)
    command = [sys.executable, "-m", *scene.command(folder, folder / "whole")]
    begun = time.perf_counter()
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    whole = time.perf_counter() - begun
    command = [sys.executable, "-m", *scene.command(folder, folder / "killed")]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        time.sleep(0.7 * whole)
        running.send_signal(signal.SIGKILL)
    path = folder / "killed" / "history.csv"
    if not path.is_file():
        return 0, 0, 1.0
    kept, held = (read_history(place / "history.csv") for place in (path.parent, folder / "whole"))
    # wall times differ
    names = [name for name in kept if name != "time [s]" or "test [-]" not in kept]
    first, second = (
        list(zip(*(table[name].tolist() for name in names), strict=True)) for table in (kept, held)
    )
    there = set(map(repr, second))
    fits = float(np.mean([repr(line) in there for line in first])) if first else 1.0
    return len(first), len(second), fits
