"""Codes run in turn on posed scenes, and what of their runs counts as an error.

The run time of all codes is that of the loop over the steps alone: starting a program, reading the scene, compiling
and the noting of frames are left out, and told once for each code.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import ours_posed
from ..backends import BACKENDS
from ..posed import Posed, Trajectory
from ..results_file import Row
from .checks import check

Floats = NDArray[np.float64]
Run = Callable[[Sequence[Posed]], list[Trajectory]]

GEODEM, YADE, LIGGGHTS = "geodem", "yade", "liggghts"
RUNS: dict[str, Run] = {
    GEODEM: ours_posed.run_posed,
    YADE: BACKENDS[YADE].run_posed,
    LIGGGHTS: BACKENDS[LIGGGHTS].run_posed,
}
CONVENTIONS = {GEODEM: "geodem", YADE: "yade", LIGGGHTS: "liggghts"}


class Measured(NamedTuple):
    """One scene in one code: a run of it, and the seconds in the loop of every round."""

    run: Trajectory
    seconds: list[float]


def in_turn(scenes: Mapping[str, Sequence[Posed]], rounds: int) -> dict[str, list[Measured]]:
    """All scenes of all codes, code after code, so many times; runs are those of the first round."""
    found: dict[str, list[Measured]] = {}
    for turn in range(rounds):
        for code, posed in scenes.items():
            runs = RUNS[code](posed)
            if any(math.isnan(run.loop_seconds) for run in runs):
                # something was compiled on the way
                runs = RUNS[code](posed)
            if turn == 0:
                found[code] = [Measured(run, []) for run in runs]
            for one, run in zip(found[code], runs, strict=True):
                one.seconds.append(run.loop_seconds)
    return found


def from_then_on(errors: Floats) -> Floats:
    """The largest error from every frame on: what swings about the answer has not come to rest where it passes it."""
    return np.asarray(np.maximum.accumulate(errors[::-1])[::-1])


def doubling(first: int, last: int) -> list[int]:
    """first, twice as much and so on, up to `last`."""
    found = [first]
    while 2 * found[-1] <= last:
        found.append(2 * found[-1])
    return found


def point(
    problem: str,
    code: str,
    driver: str,
    setting: float,
    unit: str,
    error: float,
    seconds: Sequence[float],
    **details: Any,
) -> Row:
    """A row: one point of the picture. `unit` says what the setting is."""
    return check(
        f"{problem}, {code}, {driver}, {setting:g} {unit}", [abs(error)], problem=problem, code=code, driver=driver,
        setting=setting, setting_unit=unit, seconds=list(seconds), **details,
    )  # fmt: skip


def starts(scenes: Mapping[str, Posed], rounds: int) -> list[Row]:
    """Seconds beside the loop: start of the program, reading and building the scene, the answer; and compiling."""
    rows = []
    for code, posed in scenes.items():
        found = []
        RUNS[code]([posed])
        for _ in range(rounds):
            begun = time.perf_counter()
            (run,) = RUNS[code]([posed])
            found.append(time.perf_counter() - begun - run.loop_seconds)
        rows.append(check(f"start, {code}", found, unit="s", problem="start", code=code, version=run.version))
    rows.append(
        check(
            f"start, {GEODEM}, nothing compiled yet", [_compiled_anew(scenes[GEODEM])], unit="s",
            problem="start", code=f"{GEODEM}, nothing compiled yet", version=run.version,
        )
    )  # fmt: skip
    return rows


_ANEW = """
import pickle, sys, time
from reference.ours_posed import run_posed
posed = pickle.load(sys.stdin.buffer)
times = [time.perf_counter()]
for _ in range(2):
    run_posed([posed])
    times.append(time.perf_counter())
print(times[1] - times[0] - (times[2] - times[1]))
"""


def _compiled_anew(posed: Posed) -> float:
    """Seconds that a first run takes longer than the next, in a process of its own with an empty folder of kernels."""
    import pickle

    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", _ANEW], input=pickle.dumps(posed), stdout=subprocess.PIPE, check=True,
            env=os.environ | {"GEODEM_CACHE": folder, "NUMBA_NUM_THREADS": "1"},
        )  # fmt: skip
    return float(done.stdout.split()[-1])


def ending(posed: Posed, time_step: float, steps: int, every: int = 0) -> Posed:
    """A scene with so many steps; frames every `every` steps, of the last only where it is 0."""
    often = every or steps
    return replace(
        posed, time_step=time_step, steps=steps // often * often, first=often, every=often, pairs_at=()
    )
