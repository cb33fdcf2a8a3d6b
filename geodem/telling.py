"""What a run tells on the terminal: a line while it goes on, its answer at the end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .check_printing import escaped
from .kinds import kind_of_result
from .run_progress import duration, time_left

if TYPE_CHECKING:
    from rich.console import Console

    from .analysis import Update
    from .calibration.fit import Progress
    from .laboratory.workers import Overview
    from .run_progress import RunUpdate

TOLD_EVERY = 60.0
"""Seconds between two lines on one stage where there is no terminal."""
TOLD_FROM = 5.0
"""Seconds of compiling from which on a line is printed where there is no terminal."""


@contextmanager
def progress_line(console: Console) -> Iterator[Callable[[Any], None]]:
    """A live line; plain lines, one a trial or a test, where there is no terminal."""
    from ._jit import told_of_compiling
    from .plotting.wording import closing

    live = console.status("starting") if console.is_terminal else None
    shown: dict[str, Any] = {"trial": None, "stage": "", "time": 0.0}

    def watch(update: Any) -> None:
        # what a kind of case tells is known by what it holds: naming the classes would load them all
        if hasattr(update, "detail"):
            _watch_run(update, live, console, shown)
        elif hasattr(update, "running"):
            _watch_tests(update, live, console)
        elif hasattr(update, "rounds"):
            _watch_calibration(update, live, console, shown)
        else:
            watch_search(update)

    def watch_search(update: Update) -> None:
        stage = f"{update.stage}: {update.text}"
        progress = update.progress
        if live is None:
            if stage != shown["stage"]:
                console.print(stage)
            if progress is not None and progress.trials and (stage, progress.trials) != shown["trial"]:
                console.print(f"  {closing(update.progress, update.seconds_left, update.seconds_most)}")
                shown["trial"] = (stage, progress.trials)
            shown["stage"] = stage
        elif progress is None:
            live.update(stage)
        elif time.perf_counter() - shown["time"] > 0.1:
            shown["time"] = time.perf_counter()
            # two lines, so that nothing is cut off at 80 columns
            live.update(
                f"{update.text}: {closing(progress, update.seconds_left, update.seconds_most)}\n"
                f"  trying {progress.factor:.4g}: step {progress.steps:,}, "
                f"unbalanced {progress.unbalanced_ratio:.0e}, moved {progress.displacement_settlements:.2f} settlements"
            )

    def compiling(seconds: float) -> None:
        # what takes no longer than a line is read needs none
        if live is None and seconds >= TOLD_FROM:
            console.print(f"compiling, about {duration(seconds)}")
        elif live is not None:
            live.update(f"{shown['stage']}\n  compiling, about {duration(seconds)}".lstrip())

    with told_of_compiling(compiling), live or nullcontext():
        yield watch


def _watch_tests(overview: Overview, live: Any, console: Console) -> None:
    from .plotting.laboratory_wording import overview_lines

    head, lines = overview_lines(overview)
    if not math.isnan(overview.seconds_left) and overview.finished < overview.total:
        head += f", about {duration(overview.seconds_left)} left"
    if live is not None:
        live.update("\n  ".join([head, *lines]))
    elif overview.last is not None:
        console.print(f"{escaped(overview.last.record.summary())}\n  {head}")


def _watch_calibration(progress: Progress, live: Any, console: Console, shown: dict[str, Any]) -> None:
    line = progress.text
    left = time_left(progress.seconds_left, progress.seconds_most)
    if live is not None:
        live.update(f"{line}\n  {left}" if left else line)
    elif line != shown["stage"]:
        console.print(f"{line}, {left}" if left else line)
    shown["stage"] = line


def _watch_run(update: RunUpdate, live: Any, console: Console, shown: dict[str, Any]) -> None:
    line = f"{update.stage}: {update.text}"
    left = time_left(update.seconds_left, update.seconds_most)
    if live is None:
        if line != shown["stage"]:
            console.print(escaped(f"{line}, {left}" if left else line))
            shown.update(stage=line, time=time.perf_counter())
        elif left and time.perf_counter() - shown["time"] > TOLD_EVERY:
            console.print(escaped("  " + ", ".join(text for text in (update.detail, left) if text)))
            shown["time"] = time.perf_counter()
    elif line != shown["stage"] or time.perf_counter() - shown["time"] > 0.1:
        shown.update(stage=line, time=time.perf_counter())
        more = ", ".join(text for text in (update.detail, left) if text)
        live.update(escaped(f"{line}\n  {more}" if more else line))


def tell(result: dict[str, Any], folder: Path, console: Console) -> None:
    """The answer of a run, in the words of its report, and where that is."""
    kind = kind_of_result(result)
    for bold, plain in kind.answer(result):
        console.print(f"[bold]{escaped(bold)}[/]{escaped(plain)}" if bold else escaped(plain))
    for warning in result["warnings"]:
        console.print(f"[yellow]note[/] {escaped(warning)}")
    count = f"{result['particles']:,} particles, " if "particles" in result else ""
    steps = f"{result['steps']:,} steps, " if result.get("steps") else ""
    # several processes compile at a time
    of = "in all processes " if kind.processes else "of which "
    compiling = f", {of}{result['compile_time_s']:.1f} s compiling" if "compile_time_s" in result else ""
    console.print(f"{count}{steps}{duration(result['wall_time_s'])}{compiling}")
    if "material_file" in result:
        console.print(f"Material: {escaped(str(folder / result['material_file']))}")
    console.print(f"Report: {escaped(str(folder / 'report.html'))}")
