"""Running a simulation until it is at rest: looks at the balance, checkpoints, progress."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..assembly import Assembly
from ..errors import InputError
from ..particle_setup import SAFETY
from ..particle_simulation import ParticleSimulation
from ..particle_step import critical_time_step

LOOK = 200
"""Steps between two looks."""
TWICE = 2
"""Looks in a row that must find rest: forces may balance for a moment on the way."""
MEASURE = 20
"""Looks from one measurement of the critical time step to the next: contacts have become more, or stiffer."""
CONNECTED = 1.5
"""Contacts over particles from which on the measured critical step holds: before, it is that of the few that touch."""

Progress = Callable[[int, float], None]


@dataclass
class Checkpoint:
    """Where a preparation is saved while it runs, and how often.

    Attributes
    ----------
    path : Path
    seconds : float
        Between two writings.
    """

    path: Path
    seconds: float = 60.0

    def __post_init__(self) -> None:
        self.saved = time.perf_counter()

    def look(self, simulation: ParticleSimulation, *, now: bool = False) -> None:
        """Write it where it is due."""
        if now or time.perf_counter() - self.saved > self.seconds:
            simulation.save(self.path)
            self.saved = time.perf_counter()


def resumed(checkpoint: Checkpoint | None, begun: ParticleSimulation) -> ParticleSimulation:
    """The simulation of the checkpoint if there is one, else the one that has just begun.

    Raises InputError where the checkpoint is of another preparation.
    """
    if checkpoint is None or not checkpoint.path.exists():
        return begun
    found = ParticleSimulation.resume(checkpoint.path)
    mine, other = begun.assembly, found.assembly
    same = (
        mine.contact_law == other.contact_law
        and all(
            np.array_equal(getattr(mine, name), getattr(other, name))
            for name in ("positions", "radii", "mass", "contact_table", "gravity", "held")
        )
        and _of_walls(mine) == _of_walls(other)
        and (begun.local_damping, begun.global_damping) == (found.local_damping, found.global_damping)
    )
    if not same:
        raise InputError(
            str(checkpoint.path),
            "this checkpoint is of another preparation",
            "Remove it, or give another path",
        )
    return found


def _of_walls(assembly: Assembly) -> list[tuple[Any, ...]]:
    """Everything that tells the walls of two assemblies apart."""
    return [
        (
            wall.name,
            *(
                np.asarray(part).tolist()
                for part in (wall.planes, wall.segments, wall.triangles, wall.velocity)
            ),
            {material: tuple(map(float, numbers)) for material, numbers in wall.contact.items()},
        )
        for wall in assembly.walls
    ]


def run_to_rest(
    simulation: ParticleSimulation,
    *,
    tolerance: float,
    most_steps: int,
    slow: float = math.inf,
    deepest: float = -math.inf,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
) -> str:
    """Run until the unbalanced ratio is below `tolerance` and no particle faster than `slow` [m/s], twice in a row.

    Ends too where a particle has fallen below the height `deepest` [m]: nothing will catch it. `progress` is told the
    steps since the simulation's start and the unbalanced ratio. Returns why it ended before, or nothing.
    """
    s = simulation
    quiet = 0
    while s.steps < most_steps:
        s.run(min(LOOK, most_steps - s.steps))
        # counted from the simulation's start, so that one that was resumed does the same
        if s.steps % (MEASURE * LOOK) == 0:
            measure_time_step(s)
        ratio = s.unbalanced_ratio()
        rests = ratio < tolerance
        if rests and math.isfinite(slow):
            rests = float(np.sqrt((s.velocities**2).sum(axis=1)).max()) < slow
        quiet = quiet + 1 if rests else 0
        if progress is not None:
            progress(s.steps, ratio)
        if checkpoint is not None:
            checkpoint.look(s)
        if quiet == TWICE:
            return ""
        lost = int((s.now[:, s.columns.position][:, -1] < deepest).sum())
        if lost:
            return f"{lost:,} of the particles fell past the walls, below {deepest:.4g} m"
    ratio = s.unbalanced_ratio()
    return f"not at rest after {s.steps:,} steps: the unbalanced ratio is {ratio:.3g}"


def measure_time_step(simulation: ParticleSimulation) -> None:
    """Let the time step follow the critical one, where enough particles touch for it to be that of the sample."""
    s = simulation
    if s.contact_count() < CONNECTED * s.assembly.particles:
        return
    critical = critical_time_step(s, local_damping=s.local_damping)
    if math.isfinite(critical):
        s.critical_time_step = critical
        s.time_step = SAFETY * critical


def refuse_run(*, tolerance: float, most_steps: int, share: float = math.inf) -> None:
    """Raise InputError for a tolerance or a number of steps that cannot be."""
    if not (math.isfinite(tolerance) and 0.0 < tolerance < share):
        raise InputError("tolerance", "no balance is that good", "Give 1e-3, for instance", value=tolerance)
    if isinstance(most_steps, bool) or not isinstance(most_steps, (int, np.integer)) or most_steps < 1:
        raise InputError("most_steps", "this is no number of steps", "Give 1 or more", value=most_steps)
