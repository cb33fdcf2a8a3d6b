"""Run, resume and redraw a case in its folder: what the commands and the Python interface call."""

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
from .case import CalibrationCase, Case, GroundCase, LaboratoryCase, load_any, load_case
from .errors import InputError, StoppedError
from .io.checkpoint import read_checkpoint
from .io.files import cannot_write, read_json, remove_unfinished
from .outputs import draw_outputs, write_case, write_outputs
from .provenance import sources_digest

NEIGHBOUR_SECONDS = 60.0

AnyCase = Case | LaboratoryCase | CalibrationCase | GroundCase


def run_case(
    case: Path | str | AnyCase,
    out: Path | str | None = None,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Callable[[Any], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a case and write its folder.

    Parameters
    ----------
    case : path of a case file or of the folder that holds case.toml, or what was read from one
    out : path, optional
        Folder of the results; in the working folder, named after the case, if left out.
    threads : int, optional
        All cores if left out; the bits of the result do not depend on it.
    quickly : bool
        About 1,000 particles and a wide tolerance, or coarse specimens, or 2,000 particles of a case of ground, for a
        first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch, stop_asked : callables
        As in `Analysis`; of other cases as in `run_laboratory` and `run_ground`.
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
    path = Path(case) if isinstance(case, (str, Path)) else None
    loaded: AnyCase = load_any(Path(case)) if isinstance(case, (str, Path)) else case
    folder = Path(out) if out is not None else default_folder(path, quickly)
    if not isinstance(loaded, Case):
        return _run_other(
            loaded, folder, threads=threads, quickly=quickly, overwrite=overwrite, watch=watch,
            stop_asked=stop_asked, command=command,
        )  # fmt: skip
    if quickly:
        loaded = quick(loaded)
    set_threads(threads)
    standing = _standing(folder, loaded, path)
    if standing == "other" and not overwrite:
        raise InputError(
            "--out", "the folder holds results of another case", "Choose another folder, or add --overwrite",
            value=str(folder),
        )  # fmt: skip
    if standing == "same" and not overwrite:
        return _go_on(
            Analysis.from_checkpoint(loaded, folder, watch=watch, stop_asked=stop_asked), folder, command
        )
    analysis = Analysis(loaded, folder, watch=watch, stop_asked=stop_asked)
    analysis.build()
    _make_folder(folder)
    if standing is not None:
        _clear(folder)
    write_case(analysis, folder)
    analysis.save()
    return _finish(analysis, folder, command)


def _run_other(
    case: LaboratoryCase | CalibrationCase | GroundCase, folder: Path, **options: Any
) -> dict[str, Any]:
    """A case of tests on specimens, or of ground alone."""
    if isinstance(case, GroundCase):
        from .ground_run import run_ground

        return run_ground(case, folder, **options)
    if isinstance(case, LaboratoryCase):
        from .laboratory_run import run_laboratory

        return run_laboratory(case, folder, **options)
    from .calibration_run import run_calibration

    return run_calibration(case, folder, **options)


def resume_case(
    folder: Path | str,
    *,
    threads: int | None = None,
    watch: Callable[[Any], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Go on with a stopped run, to the bits of a run that was never stopped.

    Raises
    ------
    InputError
        No checkpoint there, a damaged one, one of another version, or the case beside it was changed.
    StoppedError
        Stopped again.
    """
    folder = Path(folder)
    if _is_other(folder):
        other = load_any(folder / "case.toml")
        options: dict[str, Any] = {
            "threads": threads,
            "watch": watch,
            "stop_asked": stop_asked,
            "command": command,
        }
        if isinstance(other, LaboratoryCase):
            from .laboratory_run import resume_laboratory

            return resume_laboratory(folder, other, **options)
        if isinstance(other, CalibrationCase):
            from .calibration_run import resume_calibration

            return resume_calibration(folder, other, **options)
        if isinstance(other, GroundCase):
            from .ground_run import resume_ground

            return resume_ground(folder, other, **options)
    set_threads(threads)
    read_checkpoint(folder / "checkpoint.h5")  # before the case: its absence explains more
    case = load_case(folder / "case.toml")
    return _go_on(Analysis.from_checkpoint(case, folder, watch=watch, stop_asked=stop_asked), folder, command)


def redraw(folder: Path | str) -> Path:
    """Make the report, its figures and the frames again from a folder's checkpoint; returns the report's path.

    Raises
    ------
    InputError
        No checkpoint there, or one of another version.
    """
    folder = Path(folder)
    if _is_other(folder):
        other = load_any(folder / "case.toml")
        if isinstance(other, LaboratoryCase):
            from .laboratory_run import redraw_laboratory

            return redraw_laboratory(folder, other)
        if isinstance(other, CalibrationCase):
            from .calibration_run import redraw_calibration

            return redraw_calibration(folder, other)
        if isinstance(other, GroundCase):
            from .ground_run import redraw_ground

            return redraw_ground(folder, other)
    read_checkpoint(folder / "checkpoint.h5")
    analysis = Analysis.from_checkpoint(load_case(folder / "case.toml"), folder)
    stored = read_json(folder / "result.json")
    if stored is None:
        write_outputs(analysis, folder, {"methods": [], "why": "the run was not finished"})
    else:
        draw_outputs(analysis, folder, stored)
    return folder / "report.html"


def _is_other(folder: Path) -> bool:
    """Whether a folder is that of a case without checkpoint: of a laboratory, a calibration or ground."""
    stored = read_json(folder / "result.json") or {}
    return stored.get("workflow") in ("laboratory", "calibration", "ground")


def default_folder(case: Path | None, quickly: bool = False) -> Path:
    """Where results go when nothing is said: into the working folder, named after the case."""
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


def _go_on(analysis: Analysis, folder: Path, command: str) -> dict[str, Any]:
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


def _standing(folder: Path, case: Case, source: Path | None) -> str | None:
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
    _spare_users_files(folder, case, source)
    if not any((folder / name).exists() for name in ("checkpoint.h5", "result.json")):
        return None
    try:
        tree = read_checkpoint(folder / "checkpoint.h5")
    except InputError:
        return "other"
    if tree.get("case") != case_identity(case):
        return "other"
    return "same" if tree.get("sources") == sources_digest() else "older"


def _spare_users_files(folder: Path, case: Case, source: Path | None) -> None:
    """Refuse a folder where a case.toml stands that no run has written."""
    written = folder / "case.toml"
    if not written.exists():
        return
    given = None if source is None else source / "case.toml" if source.is_dir() else source
    results = any((folder / name).exists() for name in ("checkpoint.h5", "result.json"))
    own = given is not None and given.exists() and given.samefile(written)
    text = written.read_text(encoding="utf-8", errors="replace")
    if (own and text != portable_text(case)) or (not results and text != portable_text(case)):
        raise InputError(
            "--out", "the folder holds a case file, which the results would write over",
            "Choose another folder, such as a new one within it", value=str(folder),
        )  # fmt: skip


def _clear(folder: Path) -> None:
    """Take away what an earlier run wrote, and nothing else."""
    remove_unfinished(folder)
    for pattern in (
        "result.json",
        "report.html",
        "history.csv",
        "checkpoint.h5",
        "*.vtkhdf",
        "figures/*.png",
    ):
        for path in folder.glob(pattern):
            path.unlink()


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
