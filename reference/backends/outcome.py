"""What a run of another code on a scene gives back, and how its speed is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scene_packings import touching_pairs
from ..scenes import Scene

Floats = NDArray[np.float64]

WARM_UP = 20
"""Steps before a timed run: contacts are found, memory is touched."""


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
