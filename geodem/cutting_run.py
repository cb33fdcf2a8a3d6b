"""Run a case of cutting into its folder: forces, chips and cracks of a tool moved through ground; stop and resume."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ._jit import compile_seconds, set_threads
from .case.cutting import CuttingCase
from .cutting.course import Course
from .cutting.outcome import outcome
from .cutting_building import Cut, make_cut, quick
from .cutting_result import assemble, history_names, history_row
from .errors import InputError, StoppedError
from .io.checkpoint import checksum
from .io.history import continued_history
from .io.particle_frames import remove_later_frames, write_frame
from .io.run_folder import RunFolder
from .plotting.cutting_pictures import cutting_pictures
from .plotting.cutting_report import write_cutting_report
from .run_progress import Pace, RunUpdate

PART = "cut"
WRITTEN = ("*.vtkhdf", "*.vtkhdf.series", "figures/*.png")
"""What a run writes beside the files of every run."""

CLOSING = 1.7
"""Time of measures, pictures and report, about [s]."""

Watch = Callable[[RunUpdate], None]


def run_cutting(
    case: CuttingCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Cut and write the folder, or go on with a cut that was stopped.

    Parameters
    ----------
    case : CuttingCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        All cores if left out; the bits do not depend on it.
    quickly : bool
        Few particles and half the way, for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch : callable, optional
        Is given a `RunUpdate` at every stage and now and then on the way.
    stop_asked : callable, optional
        Asked between frames.
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json.

    Raises
    ------
    InputError
        Bad input; nothing has been written over.
    StoppedError
        `stop_asked` said so; the cut goes on from its last frame.
    """
    count = set_threads(threads)
    case = quick(case) if quickly else case
    run = folder_of(case, out)
    if not overwrite and (done := run.finished()) is not None:
        return done
    tell = watch or _nobody
    tell(RunUpdate("build", "placing particles and tool"))
    cut = make_cut(case)
    run.claim(overwrite=overwrite)
    head = {
        "workflow": "cutting", "title": case.title, "quick": quickly, "threads": count, "command": command,
        "seed": case.seed, "particles": int(cut.assembly.particles),
    }  # fmt: skip
    with run.going(head):
        course = _carry_out(cut, run, tell, stop_asked)
        tell(RunUpdate("report", "drawing"))
        return _write(cut, course, run)


def folder_of(case: CuttingCase, out: Path) -> RunFolder:
    """The folder of a case's run."""
    beside, copies = case.beside()
    text = beside.as_run_text()
    held: dict[str, Any] = {"case": text}
    for name, path in copies.items():
        files = sorted(entry for entry in path.iterdir() if entry.is_file()) if path.is_dir() else [path]
        for file in files:
            try:
                held[f"{name} {file.name}"] = np.frombuffer(file.read_bytes(), dtype=np.uint8)
            except OSError as error:
                raise InputError(
                    "source", f"the file cannot be read ({error.strerror})", "Put it back.", value=str(file)
                ) from error
    return RunFolder(out, text, checksum(held), written=WRITTEN, sources=copies)


def _carry_out(cut: Cut, run: RunFolder, tell: Watch, stop_asked: Callable[[], bool] | None) -> Course:
    """The whole cut, from its last kept frame on."""
    kept = run.part(PART)
    if kept is None:
        tell(RunUpdate("cut", "bringing the ground to rest, compiling"))
        course = cut.begin()
        remove_later_frames(run.path, -1)
        write_frame(run.path, course.simulation)
    else:
        course = cut.resume(kept)
        remove_later_frames(run.path, course.simulation.steps)
    pace = Pace(compile_seconds, done=course.work().done, closing=CLOSING)
    kept_rows = map(history_row, course.rows)
    with continued_history(run.path / "history.csv", history_names(), kept_rows) as history:

        def looked(row: tuple[float, ...]) -> None:
            history.write(*history_row(row))
            work = course.work()
            done = f"{100.0 * course.way / cut.plan.distance:.0f} % of the way"
            tell(RunUpdate("cut", "cutting", done, *pace.left(work), work))

        while not course.finished:
            if stop_asked is not None and stop_asked():
                raise StoppedError("stopped")
            course.advance(looked=looked)
            write_frame(run.path, course.simulation)
            run.keep(PART, course.tree())
    return course


def _write(cut: Cut, course: Course, run: RunFolder) -> dict[str, Any]:
    """Everything that a run leaves; result.json last."""
    found = outcome(course, cut.solid_fraction)
    result = run.whole(assemble(cut, course, found))
    pictures = cutting_pictures(cut, course, found)
    write_cutting_report(run.path / "report.html", result, pictures, run.case_text)
    return run.finish(result)


def resume_cutting(folder: Path, case: CuttingCase, **options: Any) -> dict[str, Any]:
    """Go on with the cut that a folder holds; its case.toml is the case as it is run, a quick one already."""
    return run_cutting(case, folder, **options)


def redraw_cutting(folder: Path, case: CuttingCase) -> Path:
    """Make the report and its figures again from what a folder holds; returns the report's path.

    Raises
    ------
    InputError
        The folder holds no finished cut of this case by this version.
    """
    run = folder_of(case, folder)
    stored = run.stored()
    kept = run.part(PART)
    if not stored or kept is None:
        raise InputError(
            str(folder), "there is no finished cut of this version",
            f"Make it with: geodem run {folder} --out {folder} --overwrite",
        )  # fmt: skip
    cut = make_cut(case)
    course = cut.resume(kept)
    found = outcome(course, cut.solid_fraction)
    write_cutting_report(folder / "report.html", stored, cutting_pictures(cut, course, found), run.case_text)
    return folder / "report.html"


def _nobody(update: RunUpdate) -> None:
    """Nobody watches."""
