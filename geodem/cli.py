"""The commands: geodem new | check | run | lab | calibrate | sweep | resume | plot | info.

Exit status 0: done; 2: bad input, nothing written over; 3: stopped, resumable; 1: a defect of ours.
"""

from __future__ import annotations

import atexit
import os
import shlex
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated, Any

import typer
from rich.console import Console

from .check_printing import escaped
from .errors import InputError, StoppedError, UnstableError
from .kinds import KINDS
from .telling import progress_line, tell

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Factor of safety and failure of the ground, and tests of rock, by particle models.",
)
console = Console(highlight=False, soft_wrap=True)
complaints = Console(stderr=True, highlight=False, soft_wrap=True)

CaseArgument = Annotated[
    Path, typer.Argument(metavar="CASE", help="A case file, or the folder that holds case.toml.")
]
FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="The folder that a run wrote to.")]


def _named(text: str) -> Path:
    """A path that is given; an empty one, of a variable of the shell that is not set, is not the working folder."""
    if not text.strip():
        raise typer.BadParameter("it is empty; name a folder or file, or leave the option out")
    return Path(text)


OutOption = Annotated[
    Path | None,
    typer.Option(help="Folder of the results. [default: NAME-result]", parser=_named, metavar="PATH"),
]
OverwriteOption = Annotated[bool, typer.Option("--overwrite", help="Replace the results of another case.")]
ThreadsOption = Annotated[
    int | None, typer.Option(min=1, help="Threads; all cores if left out. The bits do not change.")
]


@app.command()
def run(
    case: CaseArgument,
    out: OutOption = None,
    threads: ThreadsOption = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few particles: a first look.")] = False,
    overwrite: OverwriteOption = False,
) -> None:
    """Run a case of any kind and write its report."""
    _run(case, out, threads, quick, overwrite)


@app.command()
def lab(
    case: CaseArgument,
    out: OutOption = None,
    threads: ThreadsOption = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarse specimens, two of each: a first look.")
    ] = False,
    overwrite: OverwriteOption = False,
) -> None:
    """Test specimens of a rock: strength, stiffness, cracks and envelope."""
    _run(case, out, threads, quick, overwrite, workflow="laboratory")


@app.command()
def calibrate(
    case: Annotated[
        Path | None,
        typer.Argument(metavar="[CASE]", help="A case file or its folder; or give the rock by options."),
    ] = None,
    out: OutOption = None,
    young_modulus: Annotated[str | None, typer.Option(help='Such as "69 GPa".')] = None,
    poisson_ratio: Annotated[str | None, typer.Option(help="Such as 0.26.")] = None,
    compressive_strength: Annotated[str | None, typer.Option(help='Uniaxial, such as "200 MPa".')] = None,
    tensile_strength: Annotated[str | None, typer.Option(help='Direct, such as "9 MPa".')] = None,
    friction_angle: Annotated[str | None, typer.Option(help='Such as "55 deg".')] = None,
    friction_confinement: Annotated[
        str | None,
        typer.Option(help="Up to which the angle was fitted. [default: half the compressive strength]"),
    ] = None,
    density: Annotated[str | None, typer.Option(help='Such as "2630 kg/m3".')] = None,
    dimension: Annotated[int | None, typer.Option(help="Discs (2) or spheres (3). [default: 2]")] = None,
    seed: Annotated[int | None, typer.Option(help="Other specimens with another. [default: 1]")] = None,
    threads: ThreadsOption = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Coarse specimens, few of them: a first look.")
    ] = False,
    overwrite: OverwriteOption = False,
) -> None:
    """Find the bonds of particles that behave like a given rock, and write them as a material file."""
    given = {
        "young_modulus": young_modulus, "poisson_ratio": poisson_ratio,
        "uniaxial_compressive_strength": compressive_strength, "tensile_strength": tensile_strength,
        "friction_angle": friction_angle, "friction_confinement": friction_confinement,
        "density": density, "dimension": dimension, "seed": seed,
    }  # fmt: skip
    if case is not None:
        named = [name for name, value in given.items() if value is not None]
        if named:
            raise InputError(
                f"--{named[0].replace('_', '-')}", "the rock is given by a case and by options",
                "Give one of the two: change the case, or leave it out",
            )  # fmt: skip
        _run(case, out, threads, quick, overwrite, workflow="calibration")
        return
    if out is None:
        raise InputError("--out", "missing", "Without a case name the folder of the results: --out granite")
    from .calibration_run import calibration_of

    _run(calibration_of(given, out.name), out, threads, quick, overwrite)


@app.command()
def sweep(
    case: Annotated[
        Path, typer.Argument(metavar="SWEEP", help="A sweep file, or the folder that holds it as case.toml.")
    ],
    out: OutOption = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, help="Threads altogether; all cores if left out; with --only of the run."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Every run as a first look.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace another sweep; runs that are the same are kept.")
    ] = False,
    only: Annotated[int | None, typer.Option(min=1, help="Do the run of this number, and no other.")] = None,
    task: Annotated[
        str | None, typer.Option(metavar="I/N", help="Do the I-th of N shares of the runs (I from 1).")
    ] = None,
    collect: Annotated[bool, typer.Option("--collect", help="Tabulate what is done; run nothing.")] = False,
) -> None:
    """Run a case with many values of its keys, and tabulate what comes of it."""
    told = [name for name, given in (("--only", only), ("--task", task), ("--collect", collect)) if given]
    if len(told) > 1:
        raise InputError(told[1], f"{told[0]} and {told[1]} are given", "Give one of the two")
    if not told:
        _run(case, out, threads, quick, overwrite, workflow="sweep")
        return
    from .case.sweep_reading import load_unjudged
    from .sweep_run import collect as collect_runs
    from .sweep_run import run_some, share_of
    from .workflow import default_folder

    loaded = load_unjudged(case)
    folder = out if out is not None else default_folder(case, quick)
    if collect:
        tell(collect_runs(loaded, folder, quickly=quick, command=_command()), folder, console)
        return
    numbers = [only] if only is not None else share_of(str(task), len(loaded.runs))
    with _interruptible(folder) as stop_asked, progress_line(console) as watch:
        records = run_some(
            loaded, numbers, folder, threads=threads, quickly=quick, watch=watch, stop_asked=stop_asked
        )
    for number, record in zip(numbers, records, strict=True):
        console.print(f"Run {number} {record.status}, {record.seconds:.3g} s")
    failed = {n: record for n, record in zip(numbers, records, strict=True) if record.status == "failed"}
    for number, record in failed.items():
        raise InputError(f"run {number}", record.message.rstrip("."), "Other runs do not depend on it")


def _run(
    case: Any,
    out: Path | None,
    threads: int | None,
    quick: bool,
    overwrite: bool,
    workflow: str | None = None,
) -> None:
    """Run a case, given or at a path; `workflow` is the only kind that is taken."""
    from .case import load_any
    from .workflow import default_folder, run_case

    folder = out if out is not None else default_folder(case, quick)
    if workflow is not None:
        # the path says which case it is, what was read says which kind
        loaded = load_any(case)
        if loaded.workflow != workflow:
            raise InputError(
                "workflow", f"this command takes cases of the kind {workflow}",
                f"Run it with: {KINDS[loaded.workflow].command} {shlex.quote(str(case))}", value=loaded.workflow,
            )  # fmt: skip
    with _interruptible(folder) as stop_asked, progress_line(console) as watch:
        result = run_case(
            case, folder, threads=threads, quickly=quick, overwrite=overwrite,
            watch=watch, stop_asked=stop_asked, command=_command(),
        )  # fmt: skip
    tell(result, folder, console)


@app.command()
def resume(folder: FolderArgument, threads: ThreadsOption = None) -> None:
    """Go on with a run that was stopped."""
    from .workflow import resume_case

    with _interruptible(folder) as stop_asked, progress_line(console) as watch:
        result = resume_case(folder, threads=threads, watch=watch, stop_asked=stop_asked, command=_command())
    tell(result, folder, console)


@app.command()
def check(
    case: CaseArgument,
    out: Annotated[
        Path | None,
        typer.Option(help="Where the picture goes. [default: NAME-check.png]", parser=_named, metavar="PATH"),
    ] = None,
) -> None:
    """Build a case without running it: picture, counts, memory, expected run time, plausibility."""
    from .checking import check_case

    check_case(case, out, console)


@app.command()
def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=f"What to make: {', '.join(KINDS)}.")],
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that does not exist yet.")],
) -> None:
    """Make a folder with a case to start from."""
    from importlib.resources import files

    templates = files("geodem") / "templates"
    kinds = sorted(
        entry.name for entry in templates.iterdir() if entry.is_dir() and not entry.name.startswith("_")
    )
    if kind not in kinds:
        raise InputError(
            "KIND", "there is no such template", f"Choose one of: {', '.join(kinds)}", value=kind
        )
    if folder.exists():
        raise InputError(
            "DIR", "this already exists", "Name a folder that does not exist yet", value=str(folder)
        )
    from .io.files import write_whole

    for entry in sorted((templates / kind).iterdir(), key=lambda e: e.name):
        try:
            write_whole(folder / entry.name, entry.read_bytes())
        except InputError as error:
            raise InputError(str(folder), error.problem, "Choose another folder") from None
    console.print(f"Made {folder}/case.toml. Next: geodem check {shlex.quote(str(folder))}")


@app.command()
def plot(folder: FolderArgument) -> None:
    """Make the report and its pictures again from what a folder holds."""
    from .workflow import redraw

    console.print(f"Report: {redraw(folder)}")


@app.command()
def info() -> None:
    """Versions, threads, the folder of compiled kernels, and the codes found to compare with."""
    from .checking import show_info

    show_info(console)


class _Interrupted(BaseException):
    """Ctrl-C where no run is under way; click would call a KeyboardInterrupt a failure of the command."""


def _interrupted(number: int, frame: FrameType | None) -> None:
    raise _Interrupted


def main() -> None:
    """Run a command; errors become one clear message and an exit status."""
    # one that is ignored, as of a job in the background, stays so
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heeded:
        signal.signal(signal.SIGINT, _interrupted)
        # a second Ctrl-C while Python ends would take the place of the exit status
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    try:
        app()
    except _Interrupted:
        complaints.print("[yellow]Stopped at once. The same command begins again.[/]")
        sys.exit(3)
    except InputError as error:
        complaints.print(f"[bold red]Cannot go on.[/] {escaped(str(error))}")
        sys.exit(2)
    except UnstableError as error:
        complaints.print(f"[bold red]Cannot go on.[/] The motion {escaped(str(error))}")
        sys.exit(2)
    except StoppedError as error:
        complaints.print(f"[yellow]{escaped(str(error))}[/]")
        sys.exit(3)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception:
        traceback.print_exc()
        complaints.print(
            "[bold red]This is a defect of geodem, not of your case.[/] Please report the lines above."
        )
        sys.exit(1)
    finally:
        if heeded:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _command() -> str:
    return shlex.join(["geodem", *sys.argv[1:]])


@contextmanager
def _interruptible(folder: Path) -> Iterator[Callable[[], bool]]:
    """Ctrl-C asks to stop at the next batch; a second one ends at once, with the last checkpoint kept."""
    asked = False

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True
        complaints.print("[yellow]Stopping after this batch of steps; once more to stop at once.[/]")

    old = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: asked
    except (KeyboardInterrupt, StoppedError) as error:
        what = "Stopped at once" if isinstance(error, KeyboardInterrupt) else f"{str(error).capitalize()}"
        from .io.run_folder import resumable

        if resumable(folder):
            raise StoppedError(f"{what}. Go on with: geodem resume {shlex.quote(str(folder))}") from None
        raise StoppedError(f"{what}. Nothing was kept; the same command begins again.") from None
    finally:
        for number, handler in old.items():
            signal.signal(number, handler)


if __name__ == "__main__":
    main()
