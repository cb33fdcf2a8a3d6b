"""Run a tunnel case in its folder: stages, the ground's own reaction, factors; resumed to the same bits."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from ._jit import compile_seconds, set_threads
from .case.tunnel import TunnelCase
from .errors import InputError, InputErrors, StoppedError
from .io.checkpoint import checksum
from .io.files import read_json
from .io.run_folder import RunFolder
from .plotting.tunnel_report import write_tunnel_report
from .record import MethodRecord
from .run_progress import Pace, RunUpdate, Work, together
from .stability.forecast import Planned
from .stability.search import Search
from .tunnel_building import build_tunnel, quick, unsuited_section
from .tunnel_files import FRAMES, history_line, write_frame, write_history
from .tunnel_result import assemble
from .tunnel_view import make_view
from .tunnelling.collapse import FIRST_STEP, make_search
from .tunnelling.digging import Digging
from .tunnelling.forecast import WITHOUT, increments_of_plan, steps_left
from .tunnelling.ground import TunnelGround
from .tunnelling.plan import Plan
from .tunnelling.progress import Progress

WRITTEN = (FRAMES, "figures/*.png")
KEEP_SECONDS = 5.0
"""Wall time between two checkpoints within a stage."""

CLOSING = 8e-4
"""Time of frames, pictures and report for each particle, about [s]."""

Watch = Callable[[RunUpdate], None]


class TunnelRun:
    """One case being run into its folder.

    Parameters
    ----------
    case : TunnelCase
    run : RunFolder
    ground, plan : of `build_tunnel`
    watch, stop_asked : callables
    """

    def __init__(
        self,
        case: TunnelCase,
        run: RunFolder,
        ground: TunnelGround,
        plan: Plan,
        watch: Watch | None,
        stop_asked: Callable[[], bool] | None,
    ) -> None:
        self.case, self.run, self.ground, self.plan = case, run, ground, plan
        self.watch = watch or (lambda update: None)
        self.stop_asked = stop_asked or (lambda: False)
        self.digging: Digging | None = None
        self.reaction: Progress | None = None
        self.records: dict[str, MethodRecord] = {}
        self._begun: dict[str, Digging] = {}  # "stages", "reaction"
        self._searches: dict[str, Search] = {}
        self._pace = Pace(compile_seconds, closing=CLOSING * ground.model.particles)
        self._paced = False

    def work(self) -> None:
        """Everything that is computed.

        Raises
        ------
        StoppedError
        """
        self.digging = self._dig("stages", self.plan, "digging")
        if self.case.ground_reaction:
            self.reaction = self._dig(
                "reaction", self.plan.without_supports(), "the same without supports"
            ).progress
        for kind in self.case.methods:
            self._factor(kind)

    def partial(self) -> dict[str, Any]:
        """What is known of a run that stops."""
        if self.digging is None or not self.digging.progress.rows:
            return {}
        return assemble(self.case, self.digging, self.reaction, self.records)

    def _left(self) -> Work:
        """Steps times particles, of all parts."""
        particles = self.ground.model.particles
        done = left = 0.0
        increments = sum(increments_of_plan(self.plan, self.case.increments))
        whole = steps_left([], increments, particles)
        for name in ("stages", "reaction") if self.case.ground_reaction else ("stages",):
            digging = self._begun.get(name)
            if digging is None:
                left += whole
                continue
            now = digging.progress
            done += now.steps
            ended = now.collapse is not None or now.stage >= len(digging.plan.stages)
            rest = 0.0 if ended else steps_left(now.taken, increments, particles)
            left += rest
            whole = WITHOUT * (now.steps + rest)
        later = [kind for kind in self.case.methods if kind not in {*self._searches, *self.records}]
        searches = [search.work() for search in self._searches.values()]
        searches += [Planned(particles, self.case.tolerance, FIRST_STEP).work() for _ in later]
        return together([Work(done * particles, left * particles), *searches])

    def _tell(self, stage: str, text: str, detail: str) -> None:
        work = self._left()
        if not self._paced:
            # what was kept of a run before says nothing of the pace of this one
            self._paced = True
            self._pace.begin(work.done)
        self.watch(RunUpdate(stage, text, detail, *self._pace.left(work), work))

    def _dig(self, name: str, plan: Plan, words: str) -> Digging:
        kept = self.run.part(name)
        progress = None if kept is None else Progress.from_tree(kept)
        saved = time.perf_counter()
        stages = len(plan.stages)

        def on_increment(digging: Digging) -> None:
            nonlocal saved
            now = digging.progress
            row = now.rows[-1]
            stage = plan.stages[min(now.stage, stages - 1)]
            self._tell(
                name,
                f"{words}: {stage.name} ({now.stage + 1} of {stages})",
                f"{100.0 * row['relaxed']:.0f} % relaxed, mean convergence {1e3 * row['mean']:.4g} mm",
            )
            asked = self.stop_asked()
            if asked or time.perf_counter() - saved > KEEP_SECONDS:
                self.run.keep(name, now.to_tree())
                saved = time.perf_counter()
            if asked:
                raise StoppedError(f"stopped in stage {stage.name!r}")

        digging = Digging(
            self.ground, plan, increments=self.case.increments, progress=progress, on_increment=on_increment
        )
        self._begun[name] = digging
        with ExitStack() as stack:
            if name == "stages":
                self.digging = digging
                history = stack.enter_context(
                    write_history(self.run.path / "history.csv", digging.progress.rows)
                )
                digging.on_row = lambda row: history.write(*history_line(row))
            while digging.progress.stage < stages and digging.progress.collapse is None:
                digging.run_stage()
                self.run.keep(name, digging.progress.to_tree())
                if name == "stages":
                    self.run.keep(f"stage-{digging.progress.stage}", digging.progress.to_tree())
        return digging

    def _factor(self, kind: str) -> None:
        assert self.digging is not None
        kept = self.run.part(kind)
        record = MethodRecord(kind) if kept is None else MethodRecord.from_tree(kept)
        self.records[kind] = record
        if record.done:
            return
        search = make_search(self.digging, kind, tolerance=self.case.tolerance)
        search.trials, search.stable, search.failed = record.fine, record.stable, record.failed
        self._searches[kind] = search
        known = len(record.fine)

        def on_batch(search: Search) -> None:
            nonlocal known
            now = search.progress()
            self._tell(
                "search",
                f"{kind} on {now.trials} trials so far" if now.trials else kind,
                f"factor {now.factor:.4g}, {now.steps} steps",
            )
            if len(search.trials) > known:
                known = len(search.trials)
                record.stable, record.failed = search.stable, search.failed
                self.run.keep(kind, record.to_tree())
            if self.stop_asked():
                raise StoppedError(f"stopped in the search for {kind}")

        search.run(on_batch)
        record.stable, record.failed, record.done = search.stable, search.failed, True
        self.run.keep(kind, record.to_tree())

    def draw(self, result: dict[str, Any]) -> None:
        """History, frames, pictures and report of what was computed."""
        assert self.digging is not None
        write_history(self.run.path / "history.csv", self.digging.progress.rows).close()
        for number in range(1, self.digging.progress.stage + 1):
            kept = self.run.part(f"stage-{number}")
            if kept is not None:
                write_frame(self.run.path, number, self._again(Progress.from_tree(kept)))
        view = make_view(self.case, self.digging, self.reaction, self.records)
        write_tunnel_report(self.run.path / "report.html", result, view, self.run.case_text)

    def _again(self, progress: Progress) -> Digging:
        """The ground as a stage left it."""
        return Digging(self.ground, self.plan, increments=self.case.increments, progress=progress)


def run_tunnel(
    case: TunnelCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a case into a folder, or go on with what it holds.

    Parameters
    ----------
    case : TunnelCase
    out : pathlib.Path
    threads : int, optional
        All cores if left out; the bits do not depend on it.
    quickly : bool
        Few particles and increments, for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch, stop_asked : callables, optional
        Told after every increment and batch; asked there.
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
        `stop_asked` said so; `resume_tunnel` goes on.
    """
    count = set_threads(threads)
    compiled = compile_seconds()
    case = quick(case) if quickly else case
    beside, copies = case.beside()
    text = beside.as_run_text()
    run = RunFolder(out, text, _identity(text, copies), written=WRITTEN, sources=copies)
    if not overwrite and (done := run.finished()) is not None:
        return done
    work = _built(case, run, watch, stop_asked)
    run.claim(overwrite=overwrite)
    head = {
        "workflow": case.workflow, "title": case.title, "quick": quickly, "threads": count, "command": command,
    }  # fmt: skip
    with run.going(head, partial=work.partial):
        work.work()
        work.watch(RunUpdate("report", "pictures and report"))
        result = {**work.partial(), "compile_time_s": round(compile_seconds() - compiled, 3)}
        work.draw(run.whole(result))
        return run.finish(result)


def _built(
    case: TunnelCase, run: RunFolder, watch: Watch | None, stop_asked: Callable[[], bool] | None
) -> TunnelRun:
    """The ground with its initial stress, so that all that can be wrong is told before anything is written."""
    errors = unsuited_section(case)
    if errors:
        raise InputErrors(errors)
    if watch is not None:
        watch(RunUpdate("build", "placing particles"))
    ground, plan = build_tunnel(case)
    Digging(ground, plan, increments=case.increments)
    return TunnelRun(case, run, ground, plan, watch, stop_asked)


def resume_tunnel(folder: Path, case: TunnelCase, **options: Any) -> dict[str, Any]:
    """Go on with the run that a folder holds."""
    quickly = bool((read_json(folder / "result.json") or {}).get("quick"))
    return run_tunnel(case, folder, quickly=quickly, **options)


def redraw_tunnel(folder: Path, case: TunnelCase) -> Path:
    """Make the report, its figures and the frames again from what a folder holds; the report's path.

    Raises
    ------
    InputError
        The run is not finished.
    """
    stored = read_json(folder / "result.json") or {}
    case = quick(case) if stored.get("quick") else case
    beside, copies = case.beside()
    text = beside.as_run_text()
    run = RunFolder(folder, text, _identity(text, copies), written=WRITTEN, sources=copies)
    if stored.get("status") != "done":
        raise InputError(
            str(folder),
            "the run is not finished, so there is nothing to draw",
            f"Go on: geodem resume {folder}",
        )
    if run.part("stages") is None:
        raise InputError(
            str(folder / "parts"),
            "what is to be drawn is gone, or was written by another geodem or of another case",
            "Run the case again: geodem run CASE --out DIR --overwrite",
        )
    work = _built(case, run, None, None)
    work.work()  # every part is there, and is read
    work.draw(stored)
    return folder / "report.html"


def _identity(text: str, copies: dict[str, Path]) -> str:
    held: dict[str, Any] = {"case": text}
    for name, path in copies.items():
        try:
            held[name] = np.frombuffer(path.read_bytes(), dtype=np.uint8)
        except OSError as error:
            raise InputError(
                "section", f"the file cannot be read ({error.strerror})", "Put it back.", value=str(path)
            ) from error
    return checksum(held)
