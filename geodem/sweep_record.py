"""One run of a sweep: carried out in a folder of its own, and what is kept of how it went."""

from __future__ import annotations

import fcntl
import os
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from .case.sweep import SweepCase, SweepRun
from .errors import InputError, StoppedError
from .io.files import cannot_write, read_json, write_json
from .provenance import sources_digest

LEFT = "left"
"""What a process that does a run says before the seconds that it still takes."""
RUNS = "runs"
POLL = 0.2
"""Seconds between looks at whether a folder is free."""


class RunRecord(NamedTuple):
    """How a run went.

    Attributes
    ----------
    status : str
        "waiting" (or stopped on its way), "done", "failed", or "changed": the folder holds a run of another case.
    seconds : float
        Wall time.
    message : str
        Why it failed.
    """

    status: str
    seconds: float = 0.0
    message: str = ""


def folder_of(run: SweepRun, out: Path) -> Path:
    """Where the results of a run are, in the folder of the sweep."""
    return out / RUNS / run.name


def find_record(case: SweepCase, run: SweepRun, out: Path, quickly: bool) -> RunRecord:
    """What the folder of the sweep says of a run."""
    kept = read_json(_file(run, out))
    if kept is None:
        return RunRecord("waiting")
    if kept.get("identity") != case.identity(run, quickly):
        return RunRecord("changed")
    status = str(kept.get("status"))
    known = status in ("done", "failed") and kept.get("sources_digest") == sources_digest()
    if status == "done":
        result = read_json(folder_of(run, out) / "result.json") or {}
        known = known and result.get("status") == "done"
    if not known:
        return RunRecord("waiting")
    return RunRecord(status, float(kept.get("seconds") or 0.0), str(kept.get("message") or ""))


def keep_record(case: SweepCase, run: SweepRun, out: Path, quickly: bool, record: RunRecord) -> None:
    """Write down how a run went, beside its folder."""
    write_json(
        _file(run, out),
        {
            "number": run.number,
            "values": dict(run.values),
            "identity": case.identity(run, quickly),
            "sources_digest": sources_digest(),
            **record._asdict(),
        },
    )


def carry_out(
    case: SweepCase,
    run: SweepRun,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Callable[[Any], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
) -> RunRecord:
    """Do a run, or go on with it, unless it is done; another process that does it is waited for.

    Parameters
    ----------
    case, run : SweepCase, SweepRun
    out : pathlib.Path
        Folder of the sweep.
    threads : int, optional
    quickly, overwrite : bool
        As of `geodem.run_case`; only a run of another case is written over.
    watch, stop_asked : callable, optional

    Raises
    ------
    InputError
        The folder of the run holds one of another case, and is not to be written over.
    StoppedError
        `stop_asked` said so.
    """
    folder = folder_of(run, out)
    with _alone(folder, stop_asked):
        record = find_record(case, run, out, quickly)
        if record.status == "done":
            return record
        if record.status == "changed" and not overwrite:
            raise InputError(
                "--out", f"{RUNS}/{run.name} holds the run of another case",
                "Choose another folder, or add --overwrite", value=str(out),
            )  # fmt: skip
        begun = time.perf_counter()

        def do(*, anew: bool) -> dict[str, Any]:
            return case.of.run(
                case.read(run), folder, threads=threads, quickly=quickly, overwrite=anew,
                watch=watch, stop_asked=stop_asked, command=f"run {run.number} of a sweep: {run.told}",
            )  # fmt: skip

        try:
            try:
                result = do(anew=record.status == "changed")
            except InputError as error:
                # what it left cannot be gone on with: of a case that was changed since, or damaged
                if not overwrite or error.place != "--out":
                    raise
                result = do(anew=True)
            record = RunRecord("done", float(result.get("wall_time_s") or time.perf_counter() - begun))
        except StoppedError:
            raise
        except InputError as error:
            record = RunRecord("failed", time.perf_counter() - begun, str(error))
        except Exception:
            told = f"a defect of geodem, please report it:\n{traceback.format_exc()}"
            record = RunRecord("failed", time.perf_counter() - begun, told)
        keep_record(case, run, out, quickly, record)
        return record


@contextmanager
def _alone(folder: Path, stop_asked: Callable[[], bool] | None) -> Iterator[None]:
    """Hold a folder, so that no other process works in it; freed by the system, however the process ends."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        held = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise cannot_write(folder, error) from error
    try:
        while not _locked(held):
            if stop_asked is not None and stop_asked():
                raise StoppedError("stopped")
            time.sleep(POLL)
        yield
    finally:
        os.close(held)


def _locked(held: int) -> bool:
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True  # a file system without locks
    return True


def _file(run: SweepRun, out: Path) -> Path:
    return out / RUNS / f"{run.name}.json"
