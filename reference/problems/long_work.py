"""Long work: the time left that is told while a run of every kind goes on.

The error of a time left is taken over the time of the whole run, and looked at after its first tenth. Every run is a
process of its own, from its first import on, as a user's is; a quick one goes before it, so that its kernels are
compiled. What is asked of memory and of results on the way is in `long_memory`.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from geodem.run_progress import Work

from .fuzzing_judge import ROOT
from .rows import Row

ERROR = 0.2
"""Largest error of the time left over the time of the whole run, after its first tenth."""
DRUM = "drum"
GRAINS, STEPS, FEW = 150, 2_000_000, 2_000
"""Of the recorded drum, and of the one before it."""


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


class LongRun(NamedTuple):
    """A run that takes a minute or so.

    Attributes
    ----------
    name : str
    template : str
        Of `geodem new`; or `DRUM`.
    changes : tuple of (old, new)
        Of the text of its files.
    """

    name: str
    template: str
    changes: tuple[tuple[str, str], ...] = ()


def run() -> Sequence[Row]:
    """A run of every kind, one after the other."""
    rows = []
    for each in RUNS:
        told, whole = tell(each)
        rows += time_rows(each.name, told, whole)
    return rows


def tell(each: LongRun) -> tuple[list[Telling], float]:
    """What a run tells, and how long it took [s]."""
    with tempfile.TemporaryDirectory() as name:
        case = Path(name) / "case"
        case.mkdir()
        if each.template != DRUM:
            _write(each, case)
        answer = Path(name) / "told.json"
        for how in ("quick", "whole"):
            command = [sys.executable, "-m", __name__, each.template, str(case), how, str(answer)]
            subprocess.run(command, cwd=ROOT, check=True)
        content = json.loads(answer.read_text())
    told = [
        Telling(at, left, most, None if work is None else Work(*work))
        for at, left, most, work in content["told"]
    ]
    return told, content["whole"]


def _write(each: LongRun, folder: Path) -> None:
    """The files of a template, changed; every change is found in one of them."""
    files = {
        path.name: path.read_bytes() for path in (ROOT / "geodem" / "templates" / each.template).iterdir()
    }
    for old, new in each.changes:
        holding = [name for name, content in files.items() if old.encode() in content]
        assert len(holding) == 1, (each.template, old)
        files[holding[0]] = files[holding[0]].replace(old.encode(), new.encode())
    for name, content in files.items():
        (folder / name).write_bytes(content)


def time_rows(name: str, told: Sequence[Telling], whole: float) -> list[Row]:
    """Errors of the first time left that was told after the first tenth, of the middle one, and of the worst one."""
    after = [each for each in told if each.at > 0.1 * whole and math.isfinite(each.left)]
    errors = [(each.at + each.left - whole) / whole for each in after] or [math.inf]
    middle = sorted(errors, key=abs)[len(errors) // 2]
    source = f"told {len(after)} times in {whole:.1f} s"
    words = (
        ("first time left that was told: error over all", errors[0]),
        ("the middle one: error over all", middle),
        ("the worst one: error over all", max(errors, key=abs)),
    )
    rows = [Row(name, word, error, 0.0, error, ERROR, whole, source) for word, error in words]
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


RUNS = (
    LongRun("slope, both methods", "slope", (("particles = 5000", "particles = 16000"),)),
    LongRun("tunnel, three stages and a factor", "tunnel", (("particles = 4000", "particles = 12000"),)),
    LongRun("breaking ground, four stages", "breaking", (("particles = 2500", "particles = 7500"),)),
    LongRun("cutting", "cutting"),
    LongRun("run-out", "runout", (("discs = 2000", "discs = 4000"),)),
    LongRun("laboratory, sixteen tests", "laboratory"),
    LongRun("calibration", "calibration"),
    LongRun("sweep, twelve slopes", "sweep", (("particles = 1500", "particles = 4000"),)),
    LongRun("recorded drum of discs", DRUM),
)
"""A run of every kind that takes long: what `geodem new` makes, some of it with more particles."""


def _main() -> None:
    """Carry out one run: template, folder, "quick" or "whole", and the file for what it told."""
    begun = time.perf_counter()
    template, folder, how, answer = sys.argv[1:]
    told: list[tuple[float, float, float, Any]] = []

    def watch(update: Any) -> None:
        left, most = (float(getattr(update, name, math.nan)) for name in ("seconds_left", "seconds_most"))
        told.append((time.perf_counter() - begun, left, most, getattr(update, "work", None)))

    if template == DRUM:
        from geodem.particle_recorder import Recorder

        from .energy_account import drum

        recorder = Recorder(drum(GRAINS), Path(answer).with_suffix(f".{how}"), show=False, watch=watch)
        recorder.run_to(STEPS if how == "whole" else FEW)
    else:
        from geodem.workflow import run_case

        run_case(Path(folder), Path(answer).with_suffix(f".{how}"), quickly=how == "quick", watch=watch)
    Path(answer).write_text(json.dumps({"whole": time.perf_counter() - begun, "told": told}))


if __name__ == "__main__":
    _main()
