"""What `geodem check` and `geodem info` tell: the model as built, what it will cost, and what is installed."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._jit import cache_folder, set_threads
from .case import load_any
from .errors import InputError, UnstableError
from .kinds import KINDS
from .provenance import versions
from .workflow import default_folder

if TYPE_CHECKING:
    from rich.console import Console


def check_case(path: Path, picture: Path | None, console: Console) -> dict[str, Any]:
    """Build a case of any kind, draw it and estimate its cost.

    Parameters
    ----------
    path : path of a case
    picture : path of the PNG; named after the case if left out
    console : rich.console.Console

    Returns
    -------
    dict
        What was printed; "expected_s" among it: seconds of a run, or of each part of it.

    Raises
    ------
    InputError
    """
    if picture is not None and picture.suffix.lower() not in ("", ".png"):
        raise InputError(
            "--out",
            "the picture is a PNG file",
            f"Name it {picture.with_suffix('.png').name}",
            value=str(picture),
        )
    case = load_any(path)
    drawn = picture or Path(f"{default_folder(path).name.removesuffix('-result')}-check.png")
    try:
        return KINDS[case.workflow].check(case, drawn, console)
    except UnstableError as error:
        raise InputError(
            str(path), f"its first steps come to nothing: {str(error).rstrip('.')}",
            "Check the units of loads, stiffnesses, densities and sizes",
        ) from error  # fmt: skip


def show_info(console: Console) -> None:
    """Print versions, threads and what is found to compare with."""
    for name, version in versions().items():
        console.print(f"{name} {version}")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    console.print(f"threads {set_threads(None)} of {cores} cores")
    console.print(f"compiled kernels {cache_folder()}")
    for name, program in (("YADE", "yade"), ("LIGGGHTS", "liggghts")):
        console.print(f"{name}: {shutil.which(program) or f'not found (Debian: apt-get install {program})'}")
    beside = Path(__file__).resolve().parent.parent / "reference" / "limit_equilibrium.py"
    console.print(
        f"limit equilibrium: {'found' if beside.is_file() else 'not found (comes with the source checkout)'}"
    )
