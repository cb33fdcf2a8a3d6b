"""Long work: memory that stays as it is over many steps, and histories that are written as the results come."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from geodem.breaking.watching import Silent
from geodem.breaking_building import build_works
from geodem.case import load_case
from geodem.case.breaking_reading import parse_breaking
from geodem.case.cutting_reading import parse_cutting
from geodem.cutting_building import make_cut, quick
from geodem.io.history import read_history
from geodem.particle_recorder import Recorder
from geodem.simulation import Simulation

from . import interruptions_scenes as scenes
from .fuzzing_judge import ROOT
from .interruptions_particles import falling_block
from .rows import Row, at_most

STEPS = 100_000
GROWTH = 10.0
"""Largest growth of resident memory over so many steps [MB]."""


HISTORIES = ("slope", "laboratory", "particles", "breaking", "cutting", "tunnel", "runout")
"""Kinds of runs that write a history as they go on."""


def run() -> Sequence[Row]:
    """Memory, histories of killed runs."""
    return [
        *memory_of_particles(),
        *memory_of_slope(),
        *memory_of_breaking(),
        *memory_of_cutting(),
        *histories(),
    ]


def memory_of_particles() -> list[Row]:
    """Recorded discs over so many steps."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name:
        recorder = Recorder(falling_block(), name, checkpoint_seconds=0.5, show=False)
        recorder.run_to(STEPS // 10)
        before = resident()
        recorder.run_to(STEPS // 10 + STEPS)
    return [_grown("recorded discs", STEPS, before, begun)]


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
    return [_grown("slope", STEPS, before, begun)]


def memory_of_breaking() -> list[Row]:
    """Bonded ground in motion, with a line of the history every hundred steps."""
    case = parse_breaking(_template("breaking").replace("particles = 2500", "particles = 500"), Path())
    begun = time.perf_counter()
    site = build_works(case).site
    site.advance(STEPS // 10, Silent())
    before = resident()
    site.advance(STEPS, Silent())
    return [_grown("breaking ground", STEPS, before, begun)]


def memory_of_cutting() -> list[Row]:
    """A cut, which keeps every look at the tool and every frame."""
    begun = time.perf_counter()
    course = make_cut(quick(parse_cutting(_template("cutting"), Path()))).begin()
    course.advance()
    before, first = resident(), course.simulation.steps
    while not course.finished:
        course.advance()
    return [_grown("cutting", course.simulation.steps - first, before, begun)]


def _template(kind: str) -> str:
    """The case that `geodem new` makes."""
    return (ROOT / "geodem" / "templates" / kind / "case.toml").read_text()


def _grown(name: str, steps: int, before: float, begun: float) -> Row:
    grown = max(resident() - before, 0.0)
    return at_most(
        name, f"memory grown over {steps} steps [MB]", grown, GROWTH, time.perf_counter() - begun, "wanted"
    )


def resident() -> float:
    """Resident memory of this process [MB]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmRSS:"))) / 1024.0


def histories() -> list[Row]:
    """Lines that runs killed half-way leave in history.csv, each a beginning of the whole one."""
    rows = []
    for name in (name for name in HISTORIES if name in scenes.SCENES):
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
