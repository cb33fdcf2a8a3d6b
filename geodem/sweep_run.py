"""Run a sweep in its folder: every run in a folder of its own, several at a time, and a table of what came of them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from .case.sweep import SweepCase, SweepRun
from .errors import InputError
from .io.checkpoint import checksum
from .io.files import read_json
from .io.run_folder import RunFolder
from .plotting.sweep_report import write_sweep_report
from .run_progress import RunUpdate
from .sweep_hands import Ended, UnderWay, do_runs
from .sweep_record import RunRecord, carry_out, find_record, keep_record
from .sweep_result import assemble, write_table

WRITTEN = ("sweep.csv", "figures/*.png")
"""What a sweep writes beside the files of every run, and beside its runs."""

FIRST_SECONDS = 2.5
"""What the first run of a process takes longer than those after it, about: libraries and kernels are loaded [s]."""

Watch = Callable[[RunUpdate], None]


def run_sweep(
    case: SweepCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Do all runs of a sweep that are not done yet, and tabulate them.

    Parameters
    ----------
    case : SweepCase
    out : pathlib.Path
        Folder of the sweep.
    threads : int, optional
        Threads altogether; as many as cores if left out. The bits do not depend on it.
    quickly : bool
        Every run as a first look.
    overwrite : bool
        The folder may hold another sweep; of its runs those of the same case are kept.
    watch : callable, optional
        Is given a `RunUpdate` now and then.
    stop_asked : callable, optional
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json. Runs that failed are named in it, and are tried again by the next call.

    Raises
    ------
    InputError
        Bad input; nothing has been written over.
    StoppedError
        `stop_asked` said so; the same call goes on.
    """
    processes, each = shares(case, threads)
    folder = sweep_folder(case, out, quickly)
    folder.claim(overwrite=overwrite)
    records = {run.number: find_record(case, run, out, quickly) for run in case.runs}
    _refuse_changed(case, records, out, overwrite)
    left = [run for run in case.runs if records[run.number].status != "done"]
    if not left and (stored := folder.finished(("report.html", "sweep.csv"))) is not None:
        return stored
    facts = {"quick": quickly, "processes": processes, "threads": each, "command": command}

    def tabulate(status: str) -> dict[str, Any]:
        result = folder.whole(assemble(case, records, out) | facts, status)
        write_table(out / "sweep.csv", result)
        write_sweep_report(out / "report.html", result, folder.case_text)
        return result

    with folder.going(assemble(case, records, out) | facts, lambda: tabulate("stopped")):
        course = _Course(case, records, out, quickly, processes, watch)
        course.tell({})
        order = {"out": str(out.resolve()), "threads": each, "quick": quickly, "overwrite": overwrite}
        do_runs(
            [run.number for run in left], order, processes=processes, ended=course.ended,
            waiting=course.tell, stop_asked=stop_asked,
        )  # fmt: skip
        if any(record.status not in ("done", "failed") for record in records.values()):
            folder.stop(tabulate("stopped"))
            raise InputError(
                "geodem", "it was changed while the sweep went on", "The same command does what is left"
            )
        return folder.finish(tabulate("done"))


def run_some(
    case: SweepCase,
    numbers: Sequence[int],
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    watch: Callable[[Any], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
) -> list[RunRecord]:
    """Do some runs of a sweep in this process, as a scheduler's array job does; nothing is tabulated.

    Raises
    ------
    InputError
        There is no such run, or the folder holds another sweep.
    StoppedError
        `stop_asked` said so; the same call goes on.
    """
    for number in numbers:
        if not 1 <= number <= len(case.runs):
            raise InputError(
                "--only", f"the sweep has the runs 1 to {len(case.runs)}", "Give one of them", value=number
            )
    folder = sweep_folder(case, out, quickly)
    if not folder.claim(shared=True):
        _begin(folder, assemble(case, {}, out) | {"quick": quickly})
    return [
        carry_out(
            case, case.runs[number - 1], out, threads=threads, quickly=quickly, watch=watch, stop_asked=stop_asked
        )
        for number in numbers
    ]  # fmt: skip


def _begin(folder: RunFolder, head: Mapping[str, Any]) -> None:
    """Begin a sweep that other tasks of an array job begin at the same moment, with the same content."""
    try:
        folder.begin(head)
    except InputError:
        if not folder.stored():
            raise


def share_of(task: str, runs: int) -> list[int]:
    """Numbers of the runs of a share "I/N": I, I + N, I + 2 N and so on.

    Raises
    ------
    InputError
        It is no such share.
    """
    part, _, parts = task.partition("/")
    if not (part.strip().isdecimal() and parts.strip().isdecimal() and 1 <= int(part) <= int(parts)):
        raise InputError("--task", "this is no share", "Write 3/8 for the third of eight shares", value=task)
    return list(range(int(part), runs + 1, int(parts)))


def collect(case: SweepCase, out: Path, *, quickly: bool = False, command: str = "") -> dict[str, Any]:
    """Tabulate the runs that are there, and do none; the content of result.json.

    Raises
    ------
    InputError
        The folder holds another sweep, or none.
    """
    folder = sweep_folder(case, out, quickly)
    if not folder.stored():
        raise InputError(
            "--out", "the folder does not hold this sweep",
            "Give the folder that its runs were written to, and --quick where they were quick", value=str(out),
        )  # fmt: skip
    records = {run.number: find_record(case, run, out, quickly) for run in case.runs}
    facts = {key: folder.stored()[key] for key in ("processes", "threads") if key in folder.stored()}
    ended = all(record.status in ("done", "failed") for record in records.values())
    spent = {"wall_time_s": sum(record.seconds for record in records.values())}
    result = assemble(case, records, out) | facts | spent | {"quick": quickly, "command": command}
    result = folder.whole(result, "done" if ended else "stopped")
    write_table(out / "sweep.csv", result)
    write_sweep_report(out / "report.html", result, folder.case_text)
    return folder.finish(result) if ended else folder.stop(result)


def resume_sweep(folder: Path, case: SweepCase, **options: Any) -> dict[str, Any]:
    """Go on with a stopped sweep; `case` is the one in its folder, options and errors as of `run_sweep`."""
    return run_sweep(case, folder, quickly=_quick(folder), **options)


def redraw_sweep(folder: Path, case: SweepCase) -> Path:
    """Table and report again, from what the runs hold; returns the report's path. Raises InputError as `collect`."""
    stored = read_json(folder / "result.json") or {}
    collect(case, folder, quickly=_quick(folder), command=str(stored.get("command") or ""))
    return folder / "report.html"


def sweep_folder(case: SweepCase, out: Path, quickly: bool) -> RunFolder:
    """The folder of a sweep, its case beside it."""
    beside, copies = case.beside()
    identity = checksum(
        {"runs": [case.identity(run, quickly) for run in case.runs], "table": dict(case.table)}
    )
    return RunFolder(out, beside.as_run_text(), identity, written=WRITTEN, sources=copies)


def shares(case: SweepCase, threads: int | None) -> tuple[int, int]:
    """Runs at a time, and threads of each: all cores, each run on one, where nothing is said."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    cores = min(cores, threads) if threads is not None else cores
    processes = case.processes or cores
    return processes, case.threads or max(1, cores // processes)


class _Course:
    """How far a sweep is, and how long it will still take."""

    def __init__(
        self,
        case: SweepCase,
        records: dict[int, RunRecord],
        out: Path,
        quickly: bool,
        processes: int,
        watch: Watch | None,
    ) -> None:
        self.case, self.records, self.out, self.quickly = case, records, out, quickly
        self.processes = processes
        self.watch = watch or (lambda update: None)

    def ended(self, end: Ended) -> None:
        run = self.case.runs[end.number - 1]
        record = find_record(self.case, run, self.out, self.quickly)
        if end.gone and record.status not in ("done", "failed"):
            record = RunRecord(
                "failed", 0.0, f"its process was ended from outside or broke down ({end.gone})"
            )
            keep_record(self.case, run, self.out, self.quickly, record)
        self.records[end.number] = record
        self.tell({})

    def tell(self, running: dict[int, UnderWay]) -> None:
        states = [record.status for record in self.records.values()]
        failed = states.count("failed")
        text = f"{states.count('done')} of {len(states)} runs finished" + (
            f", {failed} failed" if failed else ""
        )
        runs = [self.case.runs[number - 1] for number in sorted(running)]
        detail = "; ".join(
            f"run {run.number} ({run.told}) for {running[run.number].seconds:.0f} s" for run in runs
        )
        waiting = sum(record.status not in ("done", "failed") for record in self.records.values())
        times = [record.seconds for record in self.records.values() if record.status == "done"]
        left = seconds_left(times, list(running.values()), waiting - len(running), self.processes)
        self.watch(RunUpdate("sweep", text, detail, left))


def seconds_left(done: Sequence[float], running: Sequence[UnderWay], waiting: int, processes: int) -> float:
    """Until all runs of a sweep are done, so many at a time [s]; NaN while no run has told anything.

    Runs that wait take as long as those that are done, and those under way as long as they tell, do in the mean. While
    none is done all are the first of their process, which takes longer.

    Parameters
    ----------
    done : sequence of float
        What runs took [s].
    running : sequence of UnderWay
    waiting : int
        Runs that have not begun.
    processes : int
    """
    known = [*done, *(run.seconds + run.left for run in running if not math.isnan(run.left))]
    if not known:
        return math.nan
    mean = sum(known) / len(known)
    later = mean if done else max(mean - FIRST_SECONDS, 0.5 * mean)
    own = [max(mean - run.seconds, 0.0) if math.isnan(run.left) else run.left for run in running]
    return max([(later * waiting + sum(own)) / processes, *own])


def _refuse_changed(case: SweepCase, records: dict[int, RunRecord], out: Path, overwrite: bool) -> None:
    changed: list[SweepRun] = [run for run in case.runs if records[run.number].status == "changed"]
    if changed and not overwrite:
        raise InputError(
            "--out", f"the folder holds runs of another case, as number {changed[0].number}",
            "Choose another folder, or add --overwrite: runs that are the same are kept", value=str(out),
        )  # fmt: skip


def _quick(folder: Path) -> bool:
    return bool((read_json(folder / "result.json") or {}).get("quick"))
