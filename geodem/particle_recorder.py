"""Recorder: a long run of discs or spheres; history, frames and checkpoints in one folder; can be stopped anywhere.

A script that resumes from ``checkpoint.h5`` where there is one, and begins otherwise, can be stopped or killed at any
moment and started again: in the end the folder holds the same bits as after a run that nobody disturbed.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import numpy as np

from ._jit import compile_seconds, told_of_compiling
from .errors import InputError, StoppedError, UnstableError
from .io.files import remove_unfinished
from .io.history import HistoryWriter, cut_history
from .io.particle_checkpoint import checkpoint_step
from .io.particle_frames import last_whole_frame, remove_later_frames, write_frame
from .measure.particle_energy import ParticleEnergy
from .particle_simulation import ParticleSimulation
from .run_progress import Pace, RunUpdate, Work, duration, time_left

LOOK_SECONDS = 0.3
"""How often a run looks whether it is to stop, and tells how far it is."""


class Recorder:
    """Runs a simulation and writes down what happens.

    The folder holds ``history.csv``, frames for ParaView (see `geodem.io.particle_frames`) and ``checkpoint.h5``.

    Parameters
    ----------
    simulation : ParticleSimulation
        New, or resumed from the folder's checkpoint.
    folder : path
        Made where it is missing. What it holds of later steps than the simulation's is written anew.
    history_every : int
        Steps between the lines of the history.
    frame_every : int, optional
        Steps between frames; none where it is left out.
    checkpoint_seconds : float
        Wall time between checkpoints [s]; one is always written at the end and when the run is stopped.
    show : bool, optional
        Show a bar with the time left; where left out, on terminals only.
    stop_asked : callable, optional
        Asked a few times a second; True stops the run as Ctrl-C does.
    watch : callable, optional
        Is given a `geodem.run_progress.RunUpdate` a few times a second: how far the run is, and the time left.

    Raises
    ------
    InputError
        The folder's checkpoint is further on than the simulation, or the folder cannot be written to.
    """

    def __init__(
        self,
        simulation: ParticleSimulation,
        folder: Path | str,
        *,
        history_every: int = 100,
        frame_every: int | None = None,
        checkpoint_seconds: float = 60.0,
        show: bool | None = None,
        stop_asked: Callable[[], bool] | None = None,
        watch: Callable[[RunUpdate], None] | None = None,
    ) -> None:
        for name, every in (("history_every", history_every), ("frame_every", frame_every)):
            if every is not None and every < 1:
                raise InputError(name, "this is no number of steps", "Give 1 or more", value=every)
        if not checkpoint_seconds >= 0.0:
            raise InputError(
                "checkpoint_seconds", "this is no time", "Give 60.0, say", value=checkpoint_seconds
            )
        self.simulation = simulation
        self.folder = Path(folder)
        self.history_every = history_every
        self.frame_every = frame_every
        self.checkpoint_seconds = checkpoint_seconds
        self.show = show
        self.stop_asked = stop_asked
        self.watch = watch
        self.columns = history_columns(simulation)
        self._part = 10  # steps between two looks
        self._recorded = self._drawn = -1  # last steps in the history and in frames
        self._wind_back()

    @property
    def checkpoint(self) -> Path:
        """The checkpoint's place."""
        return self.folder / "checkpoint.h5"

    def run_to(self, step: int) -> None:
        """Advance until so many steps have been done since the start of the simulation, and record them.

        Steps of searches for equilibrium count too.

        Raises
        ------
        UnstableError
            The motion has come to mean nothing; ``last_good.h5`` holds the last state that did not.
        StoppedError
            Stopped by Ctrl-C, SIGTERM or `stop_asked`; the checkpoint holds where.
        """
        s = self.simulation
        saved = time.perf_counter()
        with (
            _interruptible() as interrupted,
            _progress(self.show, self.watch, s.steps, step) as told,
            self._history() as history,
        ):
            while True:
                self._record(history)
                told(s)
                if s.steps >= step:
                    break
                if interrupted() or (self.stop_asked is not None and self.stop_asked()):
                    s.save(self.checkpoint)
                    raise StoppedError(f"stopped at step {s.steps:,}; resume from {self.checkpoint} to go on")
                if time.perf_counter() - saved > self.checkpoint_seconds:
                    s.save(self.checkpoint)
                    saved = time.perf_counter()
                self._advance(step)
            s.save(self.checkpoint)

    def _advance(self, last: int) -> None:
        """Up to the next record, in parts short enough to stop between."""
        s = self.simulation
        due = min(
            last, *(s.steps + every - s.steps % every for every in (self.history_every, self._frames()))
        )
        begun, done = time.perf_counter(), s.steps
        try:
            s.run(min(due - done, self._part))
        except UnstableError:
            s.last_good().save(self.folder / "last_good.h5")
            raise
        rate = (s.steps - done) / max(time.perf_counter() - begun, 1e-9)
        # a first call that compiles is slow, so the part may grow tenfold at once
        self._part = max(1, min(int(LOOK_SECONDS * rate), 10 * self._part))

    def _frames(self) -> int:
        return self.frame_every or self.history_every

    def _record(self, history: HistoryWriter) -> None:
        s = self.simulation
        if s.steps % self.history_every == 0 and s.steps > self._recorded:
            history.write(*history_values(s))
            self._recorded = s.steps
        if self.frame_every and s.steps % self.frame_every == 0 and s.steps > self._drawn:
            write_frame(self.folder, s)
            self._drawn = s.steps

    def _history(self) -> HistoryWriter:
        return HistoryWriter(self.folder / "history.csv", self.columns, append=True)

    def _wind_back(self) -> None:
        """Drop what was recorded after the checkpoint: it will be recorded again."""
        step = self.simulation.steps
        remove_unfinished(self.folder)
        if self.checkpoint.is_file() and checkpoint_step(self.checkpoint) > step:
            raise InputError(
                str(self.checkpoint),
                f"it is at step {checkpoint_step(self.checkpoint)}, beyond the simulation's step {step}",
                "Resume from it with ParticleSimulation.resume, or choose another folder",
            )
        path = self.folder / "history.csv"
        if path.is_file():
            # mends a line that was not finished, and refuses other columns
            HistoryWriter(path, self.columns, append=True).close()
            self._recorded = int(max(cut_history(path, step), -1))
        remove_later_frames(self.folder, step)
        # one that was being written as the run ended is written again
        self._drawn = last_whole_frame(self.folder, self.simulation)


def history_columns(s: ParticleSimulation) -> tuple[str, ...]:
    """Names with units of what `history_values` gives."""
    deep = "" if s.dimension == 3 else "/m"
    names = [
        "step [-]", "time [s]", f"kinetic energy [J{deep}]", "unbalanced force ratio [-]", "largest speed [m/s]",
        "contacts [-]", "bonds broken in tension [-]", "bonds broken in shear [-]",
    ]  # fmt: skip
    for wall in s.assembly.walls:
        names += [f"force on {wall.name}, {axis} [N{deep}]" for axis in "xyz"[: s.dimension]]
        names += [f"displacement of {wall.name}, {axis} [m]" for axis in "xyz"[: s.dimension]]
    if s.cell is not None:
        axes = "xyz"[: s.dimension]
        for what, unit in (("stress", "Pa"), ("strain", "-")):
            names += [f"{what} {i}{j} [{unit}]" for i in axes for j in axes if i <= j]
    if s.features.energy:
        names += [f"energy account, {term} [J{deep}]" for term in ParticleEnergy._fields]
    return tuple(names)


def history_values(s: ParticleSimulation) -> list[float | int]:
    """One line of the history: the simulation as it is now."""
    mode = s.record[: len(s.assembly.bonds), 0]
    velocities = s.velocities
    values: list[float | int] = [
        s.steps, s.time, s.kinetic_energy(), s.unbalanced_ratio(),
        float(np.sqrt((velocities**2).sum(axis=1)).max(initial=0.0)), s.contact_count(),
        int((mode == 1).sum()), int((mode == 2).sum()),
    ]  # fmt: skip
    for force, way in zip(s.walls.forces(), s.walls.displacements(), strict=True):
        values += [*force.tolist(), *way.tolist()]
    if s.cell is not None:
        upper = np.triu_indices(s.dimension)
        stress = s.stress()
        values += [*(0.5 * (stress + stress.T))[upper].tolist(), *s.strain()[upper].tolist()]
    if s.features.energy:
        values += list(s.energy())
    return values


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Ctrl-C and SIGTERM ask to stop between two batches of steps; a second one ends at once."""
    asked = False

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if asked:
            raise KeyboardInterrupt
        asked = True

    if threading.current_thread() is not threading.main_thread():
        # only the main thread may be told of signals
        yield lambda: False
        return
    old = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: asked
    finally:
        for number, handler in old.items():
            signal.signal(number, handler)


Telling = Callable[[ParticleSimulation], None]


@contextmanager
def _progress(
    show: bool | None, watch: Callable[[RunUpdate], None] | None, first: int, last: int
) -> Iterator[Telling]:
    """Tells how far the run is and how long it still takes, and shows it as a bar where that is wanted."""
    pace = Pace(compile_seconds, done=first)
    with _bar(show, first, last) as shown:

        def told(s: ParticleSimulation) -> None:
            work = Work(s.steps, max(last - s.steps, 0))
            broken = int((s.record[: len(s.assembly.bonds), 0] > 0).sum())
            state = f"{s.time:.4g} s" + (f", {broken:,} bonds broken" if len(s.assembly.bonds) else "")
            update = RunUpdate("motion", f"to step {last:,}", state, *pace.left(work), work)
            shown(update)
            if watch is not None:
                watch(update)

        yield told


@contextmanager
def _bar(show: bool | None, first: int, last: int) -> Iterator[Callable[[RunUpdate], None]]:
    """A bar with steps, breaks and the time left, where it is wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    console = Console(stderr=True)
    if not (console.is_terminal if show is None else show):
        yield lambda _: None
        return
    columns = ("step", MofNCompleteColumn(), BarColumn(), "{task.fields[state]}")
    with Progress(*(TextColumn(c) if isinstance(c, str) else c for c in columns), console=console) as bar:
        task = bar.add_task("", total=last, completed=first, state="")

        def told(update: RunUpdate) -> None:
            assert update.work is not None
            left = time_left(update.seconds_left)
            state = f"{update.detail}, {left}" if left else update.detail
            bar.update(task, completed=update.work.done, state=state)

        def compiling(seconds: float) -> None:
            bar.update(task, state=f"compiling, about {duration(seconds)}")

        with told_of_compiling(compiling):
            yield told
