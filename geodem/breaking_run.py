"""Run a case of breaking ground, stage by stage, and write its folder; it can be stopped anywhere and gone on with."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._jit import compile_seconds, set_threads
from .breaking.forecast import Forecast
from .breaking.search import Search
from .breaking.site import UNBALANCED, Site
from .breaking.stages import FindFactor, Stage
from .breaking_building import Works, build_works
from .breaking_quick import quick
from .breaking_result import StageEnd, assemble
from .case.breaking import BreakingCase
from .errors import InputError
from .io.checkpoint import Tree, checksum
from .io.files import read_json
from .io.history import HistoryWriter, continued_history, write_history
from .io.particle_frames import write_frame
from .io.run_folder import RunFolder
from .plotting.breaking_pictures import breaking_pictures
from .plotting.breaking_report import write_breaking_report
from .run_progress import Pace, RunUpdate

KEEP_SECONDS = 60.0
"""Of a long stage: time between places that can be gone on from [s]."""
FRAMES = "frames"
WRITTEN = (f"{FRAMES}/*", "failed-*/*", "figures/*.png")

CLOSING = 2.7
"""Time of pictures and report, about [s]."""

Watch = Callable[[RunUpdate], None]


def run_breaking(
    case: BreakingCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Carry out the stages of a case and write its folder, or go on there.

    Parameters
    ----------
    case : BreakingCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        All cores if left out; the bits do not depend on it.
    quickly : bool
        About 2,500 particles and wide brackets, for a first look.
    overwrite : bool
        Replace what the folder holds.
    watch : callable, optional
        Is given a `RunUpdate` now and then.
    stop_asked : callable, optional
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json.

    Raises
    ------
    InputError, InputErrors
        Bad input; nothing has been written over.
    StoppedError
        `stop_asked` said so; what was done is kept.
    """
    count = set_threads(threads)
    case = quick(case) if quickly else case
    beside, copies = case.beside()
    text = beside.as_run_text()
    run = RunFolder(out, text, _identity(text, copies), written=WRITTEN, sources=copies)
    if not overwrite and (stored := run.finished()) is not None:
        return stored
    if watch is not None:
        watch(RunUpdate("build", "placing particles"))
    works = build_works(case)
    run.claim(overwrite=overwrite)
    head = {
        "workflow": case.workflow,
        "title": case.title,
        "quick": quickly,
        "threads": count,
        "command": command,
    }
    site = works.site
    forecast = Forecast(
        works.stages, particles=len(site.origin), dimension=site.simulation.dimension,
        time_step=site.simulation.time_step,
    )  # fmt: skip
    pace = Pace(compile_seconds, closing=CLOSING)
    with run.going(head):
        ends = [
            _carry_out(run, works, number, stage, watch, stop_asked, forecast, pace)
            for number, stage in enumerate(works.stages)
        ]
        return _write(run, case, works, ends)


def resume_breaking(folder: Path, case: BreakingCase, **options: Any) -> dict[str, Any]:
    """Go on with what a folder holds; options, result and errors as of `run_breaking`."""
    quickly = bool((read_json(folder / "result.json") or {}).get("quick"))
    return run_breaking(case, folder, quickly=quickly, **options)


def redraw_breaking(folder: Path, case: BreakingCase) -> Path:
    """Make the report and its figures again from what a folder holds; returns the report's path.

    Raises
    ------
    InputError
        A stage is not finished.
    """
    beside, copies = case.beside()
    text = beside.as_run_text()
    run = RunFolder(folder, text, _identity(text, copies), written=WRITTEN, sources=copies)
    stored = run.stored()
    works = build_works(case)
    ends = []
    for number, stage in enumerate(works.stages):
        end = _kept(run, number, stage)
        if end is None or not stored:
            raise InputError(
                str(folder), "the run is not finished, or another version of geodem made it",
                f"Go on with: geodem resume {folder}",
            )  # fmt: skip
        ends.append(end)
    pictures = breaking_pictures(ends)
    write_breaking_report(folder / "report.html", stored, pictures, text)
    return folder / "report.html"


# ---------------------------------------------------------------------- stages


@dataclass
class _Watcher:
    """Looks on while a stage is carried out: tells, writes frames, keeps places to go on from."""

    run: RunFolder
    number: int
    text: str
    watch: Watch | None
    asked: Callable[[], bool] | None
    history: HistoryWriter
    forecast: Forecast
    pace: Pace

    def __post_init__(self) -> None:
        self.kept = time.perf_counter()
        self.detail = ""
        self.tell()

    def recorded(self, row: tuple[float, ...], steps: int) -> None:
        self.history.write(*row)
        self.forecast.saw(steps, row[UNBALANCED])
        self.tell()

    def told(self, detail: str) -> None:
        self.detail = detail
        self.tell()

    def tell(self) -> None:
        if self.watch is not None:
            work = self.forecast.work()
            self.watch(RunUpdate("stage", self.text, self.detail, *self.pace.left(work), work))

    def stop_asked(self) -> bool:
        return self.asked is not None and self.asked()

    def frame(self, site: Site) -> None:
        write_frame(self.run.path / FRAMES, site.simulation)

    def may_keep(self, site: Site) -> None:
        if self.stop_asked() or time.perf_counter() - self.kept > KEEP_SECONDS:
            self.run.keep(_name(self.number), {"site": site.tree(), "plain": {"done": False}})
            self.kept = time.perf_counter()


def _carry_out(
    run: RunFolder,
    works: Works,
    number: int,
    stage: Stage,
    watch: Watch | None,
    stop_asked: Callable[[], bool] | None,
    forecast: Forecast,
    pace: Pace,
) -> StageEnd:
    """One stage, or what is kept of it."""
    text = f"stage {number + 1} of {len(works.stages)}: {stage.name}"
    done = _kept(run, number, stage)
    if done is not None:
        if number + 1 < len(works.stages) and _kept(run, number + 1, works.stages[number + 1]) is not None:
            return done
        # what is done stays as it is while the next stage moves on
        works.site.take_over(Site.from_tree(done.site.tree()))
        return done
    begun = time.perf_counter()
    site = works.site
    site.place = (number + 1, site.place[1])
    name = _name(number)
    part = run.part(name)
    search = Search(stage.plan, site.tree()) if isinstance(stage, FindFactor) else None
    if part is not None and search is not None:
        search.take_up(part["search"])
    elif part is not None:
        site.take_over(Site.from_tree(part["site"]))
    rows = site.history if search is None else [*site.history, *search.rows]
    with continued_history(run.path / "history.csv", site.columns(), rows) as history:
        forecast.begin(number, search, gone=site.done)
        watcher = _Watcher(run, number, text, watch, stop_asked, history, forecast, pace)
        if search is None:
            assert not isinstance(stage, FindFactor)
            facts = stage.carry_out(site, watcher)
            tree: Tree = {"site": site.tree()}
        else:
            found = search.run(
                watcher, lambda s: run.keep(name, {"search": s.tree(), "plain": {"done": False}})
            )
            site.take_over(found)
            facts = {}
            tree = {"site": site.tree(), "search": search.tree()}
    write_frame(run.path / FRAMES, site.simulation)
    if search is not None and search.failed is not None:
        write_frame(run.path / f"failed-{number + 1}", Site.from_tree(search.failed).simulation)
    facts["seconds"] = round(time.perf_counter() - begun, 3)
    run.keep(_name(number), {**tree, "plain": {"done": True, "facts": facts}})
    end = _kept(run, number, stage)
    assert end is not None  # it has just been written
    return end


def _kept(run: RunFolder, number: int, stage: Stage) -> StageEnd | None:
    """A stage that is done."""
    part = run.part(_name(number))
    if part is None or not part["plain"]["done"]:
        return None
    search = None
    if isinstance(stage, FindFactor):
        search = Search(stage.plan, {})
        search.take_up(part["search"])
    return StageEnd(stage, Site.from_tree(part["site"]), part["plain"]["facts"], search)


def _name(number: int) -> str:
    return f"stage-{number + 1}"


# ---------------------------------------------------------------------- what is written


def _write(run: RunFolder, case: BreakingCase, works: Works, ends: list[StageEnd]) -> dict[str, Any]:
    """Everything that a finished run leaves; result.json last."""
    result = assemble(case, works, ends)
    site = ends[-1].site
    write_history(run.path / "history.csv", site.columns(), site.history)
    pictures = breaking_pictures(ends)
    whole = run.whole(result)
    write_breaking_report(run.path / "report.html", whole, pictures, run.case_text)
    return run.finish(result)


def _identity(text: str, copies: dict[str, Path]) -> str:
    """Of a case as it is run and of what its files hold."""
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
    return checksum(held)
