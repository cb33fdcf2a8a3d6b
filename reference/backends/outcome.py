"""What a run of another code gives back, and how such a code is started."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..scene_packings import touching_pairs
from ..scenes import Scene

Floats = NDArray[np.float64]

WARM_UP = 20
"""Steps before a timed run: contacts are found, memory is touched."""


class BackendError(RuntimeError):
    """Another code is missing, failed, or cannot stand for the scene."""


@dataclass(frozen=True)
class Outcome:
    """A run of another code.

    Attributes
    ----------
    seconds_per_step : float
        Measured inside the code, after the warm-up, without its start. It includes the recording of frames.
    law : str
        The laws that the code used, and where they differ from the scene's.
    version : str
    positions, velocities, spins : (frames, n, 3) [m], [m/s], [rad/s]
        Of every recorded step, the last one always. YADE gives velocities half a step back; LIGGGHTS and LAMMPS,
        which step by velocity Verlet, at the same time as the positions.
    """

    seconds_per_step: float
    law: str
    version: str
    positions: Floats
    velocities: Floats
    spins: Floats


@dataclass(frozen=True)
class Speed:
    """Speed of one code on one scene.

    Attributes
    ----------
    seconds_per_step : float
    contacts : int
        Bonds, or pairs of particles that touch at the end.
    law, version : str
    """

    seconds_per_step: float
    contacts: int
    law: str
    version: str


def speed(run: Callable[..., Outcome], scene: Scene, steps: int, threads: int) -> Speed:
    """Time `steps` steps after a warm-up."""
    outcome = run(scene, steps, threads=threads, warm_up=WARM_UP)
    return Speed(outcome.seconds_per_step, contacts(scene, outcome), outcome.law, outcome.version)


def contacts(scene: Scene, outcome: Outcome) -> int:
    """Bonds of a bonded scene, else the pairs that touch in the last frame."""
    if scene.bonds is not None:
        return len(scene.bonds.pairs)
    return len(touching_pairs(outcome.positions[-1], scene.radii))


def start(
    name: str, command: Sequence[str], folder: Path, environment: dict[str, str], timeout: float
) -> str:
    """Run a program in `folder`; return what it printed. Raise BackendError where it failed."""
    try:
        done = subprocess.run(
            list(command), cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, timeout=timeout, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise BackendError(f"{name} was not done after {timeout:.0f} s") from error
    if done.returncode or "ERROR" in done.stdout:
        raise BackendError(f"{name} failed (status {done.returncode}):\n{done.stdout[-2000:]}")
    return done.stdout


def clean_environment(**more: str) -> dict[str, str]:
    """This process's environment without what belongs to its own Python."""
    own = ("PYTHONHOME", "PYTHONPATH", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
    kept = {name: value for name, value in os.environ.items() if name not in own}
    return kept | more


def refuse(name: str, reason: str) -> BackendError:
    """The error for a scene that a code's laws cannot stand for."""
    return BackendError(f"{name} cannot run this scene: {reason}")
