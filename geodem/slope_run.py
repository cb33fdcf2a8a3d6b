"""A slope in its folder: run, resume and redraw, with a checkpoint that any moment of a search can be gone on from."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ._jit import set_threads
from .analysis import Analysis, Update
from .building import case_identity, portable_text, quick
from .case import Case
from .errors import InputError, StoppedError
from .io.checkpoint import read_checkpoint
from .io.files import cannot_write, read_json, remove, remove_unfinished
from .io.run_folder import RESULTS
from .outputs import draw_outputs, write_case, write_outputs
from .provenance import sources_digest

NEIGHBOUR_SECONDS = 60.0

CLOSING = 5.0
"""Time of limit equilibrium, pictures and report, about [s]."""


def run_slope(
    case: Case,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Callable[[Update], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a slope and write its folder, or go on with what stands there.

    Parameters
    ----------
    case : Case
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        All cores if left out; the bits of the result do not depend on it.
    quickly : bool
        About 1,000 particles and a wide tolerance.
    overwrite : bool
        Replace the results of another case in that folder.
    watch, stop_asked : callables
        As in `Analysis`.
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
        `stop_asked` said so; `resume_slope` goes on.
    """
    if quickly:
        case = quick(case)
    set_threads(threads)
    standing = _standing(out, case)
    if standing == "other" and not overwrite:
        raise InputError(
            "--out", "the folder holds results of another case", "Choose another folder, or add --overwrite",
            value=str(out),
        )  # fmt: skip
    if standing == "same" and not overwrite:
        return _taken_up(case, out, watch, stop_asked, command)
    analysis = Analysis(case, out, watch=watch, stop_asked=stop_asked, closing=CLOSING)
    analysis.build()
    _make_folder(out)
    if standing is not None:
        _clear(out)
    write_case(analysis, out)
    analysis.save()
    return _finish(analysis, out, command)


def resume_slope(
    folder: Path,
    case: Case,
    *,
    threads: int | None = None,
    watch: Callable[[Update], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Go on with a stopped run, to the bits of a run that was never stopped; `case` is the one in the folder.

    Raises
    ------
    InputError
        No checkpoint there, a damaged one, one of another version, or the case beside it was changed.
    StoppedError
        Stopped again.
    """
    set_threads(threads)
    return _taken_up(case, folder, watch, stop_asked, command)


def redraw_slope(folder: Path, case: Case) -> Path:
    """Make the report, its figures and the frames again from a folder's checkpoint; returns the report's path.

    Raises
    ------
    InputError
        No checkpoint there, or one of another version.
    """
    analysis = Analysis.from_checkpoint(case, folder)
    stored = read_json(folder / "result.json")
    if stored is None:
        write_outputs(analysis, folder, {"methods": [], "why": "the run was not finished"})
    else:
        draw_outputs(analysis, folder, stored)
    return folder / "report.html"


def limit_equilibrium(case_file: Path) -> dict[str, Any]:
    """What Bishop and Spencer say of a case: ``{"methods": [...]}``, or ``{"methods": [], "why": "..."}``.

    They live beside this package, in `reference`, which it never imports: like the other codes that results are
    compared with, they run as a program of their own.
    """
    root = Path(__file__).resolve().parent.parent
    if not (root / "reference" / "__main__.py").is_file():
        return {"methods": [], "why": "limit equilibrium comes with the source checkout (folder reference/)"}
    program = [sys.executable, "-m", "reference", "limit-equilibrium", str(case_file.resolve()), "--json"]
    try:
        done = subprocess.run(
            program,
            cwd=root,
            capture_output=True,
            text=True,
            timeout=NEIGHBOUR_SECONDS,
            check=False,
            start_new_session=True,  # Ctrl-C asks this process to stop, not that one to die
        )
    except subprocess.TimeoutExpired:
        return {"methods": [], "why": f"limit equilibrium did not end within {NEIGHBOUR_SECONDS:g} s"}
    try:
        answer = json.loads(done.stdout)
    except json.JSONDecodeError:
        words = (done.stderr.strip() or done.stdout.strip() or "no output").splitlines()[-1]
        return {"methods": [], "why": f"limit equilibrium ended without an answer: {words}"}
    return dict(answer)


def _taken_up(
    case: Case,
    folder: Path,
    watch: Callable[[Update], None] | None,
    stop_asked: Callable[[], bool] | None,
    command: str,
) -> dict[str, Any]:
    """What a folder's checkpoint holds, gone on with to its end."""
    analysis = Analysis.from_checkpoint(case, folder, watch=watch, stop_asked=stop_asked, closing=CLOSING)
    remove_unfinished(folder)
    stored = read_json(folder / "result.json")
    if analysis.done() and stored is not None and stored.get("status") == "done":
        if (folder / "report.html").is_file():
            return stored
    write_case(analysis, folder)
    return _finish(analysis, folder, command)


def _finish(analysis: Analysis, folder: Path, command: str) -> dict[str, Any]:
    try:
        analysis.search()
    except StoppedError:
        why = "the run was stopped before it came to this"
        write_outputs(analysis, folder, {"methods": [], "why": why}, command)
        raise
    analysis.watch(Update("neighbours", "limit equilibrium"))
    neighbours = limit_equilibrium(folder / "case.toml")
    analysis.watch(Update("report", "pictures and report"))
    result = write_outputs(analysis, folder, neighbours, command)
    analysis.save()
    return result


def _standing(folder: Path, case: Case) -> str | None:
    """What is in the folder: None (nothing of ours), "same" (this case, this version), "older", or "other".

    Raises
    ------
    InputError
        It is no folder, or a file of the user's would be written over.
    """
    if not folder.exists():
        return None
    if not folder.is_dir():
        raise InputError("--out", "there is a file of that name", "Choose another folder", value=str(folder))
    _spare_users_files(folder, case)
    if not any((folder / name).exists() for name in RESULTS):
        return None
    try:
        tree = read_checkpoint(folder / "checkpoint.h5")
    except InputError:
        return "other"
    if tree.get("case") != case_identity(case):
        return "other"
    return "same" if tree.get("sources") == sources_digest() else "older"


def _spare_users_files(folder: Path, case: Case) -> None:
    """Refuse a folder where a case.toml stands that no run has written, or that this case was read from."""
    written = folder / "case.toml"
    if not written.exists():
        return
    results = any((folder / name).exists() for name in RESULTS)
    text = written.read_text(encoding="utf-8", errors="replace")
    if (text == case.text or not results) and text != portable_text(case):
        raise InputError(
            "--out", "the folder holds a case file, which the results would write over",
            "Choose another folder, such as a new one within it", value=str(folder),
        )  # fmt: skip


def _clear(folder: Path) -> None:
    """Take away what an earlier run wrote, and nothing else.

    Its checkpoint stays until another is written over it: without it, what a killed run leaves would look like files of
    the user's.
    """
    remove_unfinished(folder)
    for pattern in (
        "result.json",
        "report.html",
        "history.csv",
        "*.vtkhdf",
        "figures/*.png",
    ):
        for path in folder.glob(pattern):
            remove(path)


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
