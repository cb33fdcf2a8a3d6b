"""Run, resume and redraw a case of any kind in its folder: what the commands and the Python interface call."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .case import load_any, load_kind
from .errors import InputError
from .io.checkpoint import read_checkpoint
from .io.files import read_json
from .io.run_folder import RESULTS, is_cleared
from .kinds import KINDS, AnyCase, Kind, kind_of_result


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
    return KINDS[loaded.workflow].run(
        loaded, folder, threads=threads, quickly=quickly, overwrite=overwrite, watch=watch,
        stop_asked=stop_asked, command=command,
    )  # fmt: skip


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
        Nothing of a run there, something damaged or of another version, or the case beside it was changed.
    StoppedError
        Stopped again.
    """
    folder = Path(folder)
    kind, case = _held(folder)
    return kind.resume(folder, case, threads=threads, watch=watch, stop_asked=stop_asked, command=command)


def redraw(folder: Path | str) -> Path:
    """Make the report, its figures and the frames again from what a folder holds; returns the report's path.

    Raises
    ------
    InputError
        Nothing of a run there, or of another version.
    """
    folder = Path(folder)
    kind, case = _held(folder)
    return kind.redraw(folder, case)


def _held(folder: Path) -> tuple[Kind, AnyCase]:
    """Kind and case of the run that a folder holds."""
    if is_cleared(folder):
        raise InputError(
            str(folder), "its results were being replaced when that was interrupted, and nothing is left of them",
            f"Run the case again: geodem run CASE --out {folder}",
        )  # fmt: skip
    kind = kind_of_result(read_json(folder / "result.json"))
    if not any((folder / name).exists() for name in RESULTS):
        read_checkpoint(folder / "checkpoint.h5")  # before the case: its absence explains more
    return kind, load_kind(kind, folder / "case.toml")


def default_folder(case: Path | None, quickly: bool = False) -> Path:
    """Where results go when nothing is said: into the working folder, named after the case."""
    if case is None:
        return Path("result")
    stem = case.resolve().name if case.is_dir() or case.name == "case.toml" else case.stem
    if case.name == "case.toml":
        stem = case.resolve().parent.name
    return Path(f"{stem}-quick" if quickly else f"{stem}-result")
