"""geodem itself on a scene of `reference.scenes`: the one place where benchmarks call it."""

from __future__ import annotations

import importlib.util

from .backends.outcome import BackendError, Speed
from .scenes import Scene

NAME = "geodem"


def available() -> str | None:
    """None where geodem has its particle simulation, else what is missing."""
    found = importlib.util.find_spec("geodem.particle_simulation")
    return (
        None
        if found
        else "geodem.particle_simulation is missing: this version of geodem moves no particles yet"
    )


def run_speed(scene: Scene, steps: int, threads: int, *, damping: float = 0.0) -> Speed:
    """Seconds of one step after a warm-up, without building and compiling; `damping` is the local one.

    Raises BackendError where geodem has no particle simulation.
    """
    missing = available()
    raise BackendError(missing or "geodem.particle_simulation is not called here yet")


def chunk_of(scene: Scene) -> int | None:
    """Particles a chunk of geodem's pair list on this scene; None where it is not known."""
    return None
