"""Run, resume and redraw a case in its folder: what the commands and the Python interface call."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import __version__
from ._jit import set_threads
from .analysis import Analysis, Update, quick, sources_digest
from .case import Case, load_case
from .errors import InputError, StoppedError
from .io.checkpoint import read_checkpoint
from .io.files import cannot_write
from .outputs import write_case, write_outputs

NEIGHBOUR_SECONDS = 60.0


def run_case(
    case: Path | str | Case,
    out: Path | str | None = None,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Callable[[Update], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a case and write its folder.

    Parameters
    ----------
    case : path of a case file or of the folder that holds case.toml, or Case
    out : path, optional
        Folder of the results; next to the case, named after it, if left out.
    threads : int, optional
        All cores if left out; the bits of the result do not depend on it.
    quickly : bool
        About 1,000 particles and a wide tolerance, for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch, stop_asked : callables
        As in `Analysis`.
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json. A case that is already done in that folder is not run again.

    Raises
    ------
    InputError
        Bad input; nothing has been written over.
    StoppedError
        `stop_asked` said so; `resume_case` goes on.
    """
    path = None if isinstance(case, Case) else Path(case)
    loaded = case if isinstance(case, Case) else load_case(Path(case))
    if quickly:
        loaded = quick(loaded)
    folder = Path(out) if out is not None else default_folder(path, quickly)
    set_threads(threads)
    standing = _standing(folder, loaded)
    if standing == "other" and not overwrite:
        raise InputError(
            "--out", "the folder holds results of another case", "Choose another folder, or add --overwrite",
            value=str(folder),
        )  # fmt: skip
    if standing == "same" and not overwrite:
        return resume_case(folder, watch=watch, stop_asked=stop_asked, command=command)
    analysis = Analysis(loaded, folder, watch=watch, stop_asked=stop_asked)
    analysis.build()
    _make_folder(folder)
    if standing is not None:
        _clear(folder)
    write_case(analysis, folder)
    analysis.save()
    return _finish(analysis, folder, command)


def resume_case(
    folder: Path | str,
    *,
    threads: int | None = None,
    watch: Callable[[Update], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Go on with a stopped run, to the bits of a run that was never stopped.

    Raises
    ------
    InputError
        No checkpoint there, a damaged one, or one of another version.
    StoppedError
        Stopped again.
    """
    folder = Path(folder)
    set_threads(threads)
    read_checkpoint(folder / "checkpoint.h5")  # before the case: its absence explains more
    case = load_case(folder / "case.toml")
    analysis = Analysis.from_checkpoint(case, folder, watch=watch, stop_asked=stop_asked)
    written = folder / "result.json"
    if analysis.done() and written.is_file() and (folder / "report.html").is_file():
        stored = json.loads(written.read_text())
        if stored.get("status") == "done":
            return dict(stored)
    return _finish(analysis, folder, command)


def redraw(folder: Path | str) -> Path:
    """Make the report and the frames again from a folder's checkpoint; returns the report's path.

    Raises
    ------
    InputError
        No checkpoint there.
    """
    folder = Path(folder)
    read_checkpoint(folder / "checkpoint.h5")
    analysis = Analysis.from_checkpoint(load_case(folder / "case.toml"), folder)
    written = folder / "result.json"
    stored = json.loads(written.read_text()) if written.is_file() else {}
    neighbours = {"methods": stored.get("neighbours", []), "why": stored.get("neighbours_why", "")}
    write_outputs(analysis, folder, neighbours, stored.get("command", ""))
    return folder / "report.html"


def default_folder(case: Path | None, quickly: bool = False) -> Path:
    """Where results go when nothing is said: beside the case, named after it."""
    if case is None:
        return Path("result")
    stem = case.resolve().name if case.is_dir() or case.name == "case.toml" else case.stem
    if case.name == "case.toml":
        stem = case.resolve().parent.name
    return Path(f"{stem}-quick" if quickly else f"{stem}-result")


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
            program, cwd=root, capture_output=True, text=True, timeout=NEIGHBOUR_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return {"methods": [], "why": f"limit equilibrium did not end within {NEIGHBOUR_SECONDS:g} s"}
    try:
        answer = json.loads(done.stdout)
    except json.JSONDecodeError:
        words = (done.stderr.strip() or done.stdout.strip() or "no output").splitlines()[-1]
        return {"methods": [], "why": f"limit equilibrium ended without an answer: {words}"}
    return dict(answer)


def _finish(analysis: Analysis, folder: Path, command: str) -> dict[str, Any]:
    try:
        analysis.search()
    except StoppedError:
        write_outputs(analysis, folder, {"methods": [], "why": "the run was stopped before it came to this"}, command)
        raise
    analysis.watch(Update("neighbours", "limit equilibrium"))
    neighbours = limit_equilibrium(folder / "case.toml")
    analysis.watch(Update("report", "pictures and report"))
    result = write_outputs(analysis, folder, neighbours, command)
    analysis.save()
    return result


def _standing(folder: Path, case: Case) -> str | None:
    """What is in the folder: None (nothing of ours), "same" (this case, this version), or "other"."""
    if not folder.exists():
        return None
    if not folder.is_dir():
        raise InputError("--out", "there is a file of that name", "Choose another folder", value=str(folder))
    ours = [name for name in ("checkpoint.h5", "result.json") if (folder / name).exists()]
    if not ours:
        return None
    try:
        tree = read_checkpoint(folder / "checkpoint.h5")
        stored = load_case(folder / "case.toml")
    except InputError:
        return "other"
    if stored.as_run_text() != case.as_run_text():
        return "other"
    if tree["geodem"] != __version__ or tree["sources"] != sources_digest():
        return "older"
    return "same"


def _clear(folder: Path) -> None:
    """Take away what an earlier run wrote, and nothing else."""
    for pattern in ("result.json", "report.html", "history.csv", "checkpoint.h5", "*.vtkhdf", "figures/*.png"):
        for path in folder.glob(pattern):
            path.unlink()


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
