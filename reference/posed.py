"""A scene posed once for geodem and for every other code, what a run of it gives, and how far two runs differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Memory:
    """What touching pairs remember.

    Attributes
    ----------
    pairs : (k, 2) int
    shear : (k, 3) [N]
        Elastic shear force on the first of the two.
    spring : (k, 3) [m] or None
        Elastic tangential displacement of the first against the second, where a code keeps that.
    """

    pairs: Integers
    shear: Floats
    spring: Floats | None = None


@dataclass(frozen=True)
class State:
    """Where a code stood one step before its first frame: to be handed over.

    Attributes
    ----------
    positions, velocities, spins : (n, 3) [m], [m/s], [rad/s]
        Velocities and spins are those half a step before the positions.
    memory : Memory
        What the pairs remember of the step that led to these positions.
    """

    positions: Floats
    velocities: Floats
    spins: Floats
    memory: Memory


@dataclass(frozen=True)
class Posed:
    """An assembly, how it is stepped, and what of it is compared.

    Attributes
    ----------
    name : str
    assembly : geodem.assembly.Assembly
    time_step : float
        [s]
    steps : int
    convention : str
        What geodem calls the other code's kinematics: "yade", "yade-plain", "liggghts", or its own, "geodem".
    local_damping : float
        Cundall's coefficient [-].
    first, every : int
        Frames are recorded of the steps first, first + every, ... up to `steps`. Where first is above 1 (2 with
        LIGGGHTS), the state one step before it is told as well.
    pairs_at : tuple of int or None
        Those of these steps of which the forces between pairs are recorded, too; all of them where it is None.
    memory : Memory or None
        What the pairs remember at the start, handed over from another code.
    quantities : tuple of str
        Those of `QUANTITIES` that are compared.
    bound : float
        Largest difference that is let pass, see `differences`.
    """

    name: str
    assembly: Assembly
    time_step: float
    steps: int
    convention: str
    local_damping: float = 0.0
    first: int = 1
    every: int = 1
    pairs_at: tuple[int, ...] | None = None
    memory: Memory | None = None
    quantities: tuple[str, ...] = ("positions", "velocities", "spins", "forces", "torques")
    bound: float = 1e-11

    @property
    def frames(self) -> range:
        """Steps of which frames are recorded."""
        return range(self.first, self.steps + 1, self.every)


@dataclass(frozen=True)
class PairForces:
    """Forces between pairs of particles, in all frames, frame after frame.

    Attributes
    ----------
    frame : (m,) int
        Number of the frame, from 0.
    pairs : (m, 2) int
        The lower number first, in ascending order within a frame.
    normal, shear : (m, 3) [N]
        On the first of the two; the shear force is that of the springs where dashpots act as well.
    along : (m, 3) [-]
        From the first to the second.
    spring : (m, 3) [m] or None
        Elastic tangential displacement of the first against the second, where a code remembers that.
    """

    frame: Integers
    pairs: Integers
    normal: Floats
    shear: Floats
    along: Floats
    spring: Floats | None = None

    def of_frame(self, frame: int) -> PairForces:
        """Those of one frame."""
        return self._those(self.frame == frame)

    def from_frame(self, frame: int) -> PairForces:
        """Those of a frame and all later ones."""
        return self._those(self.frame >= frame)

    def _those(self, which: NDArray[np.bool_]) -> PairForces:
        return PairForces(
            self.frame[which],
            self.pairs[which],
            self.normal[which],
            self.shear[which],
            self.along[which],
            None if self.spring is None else self.spring[which],
        )


@dataclass(frozen=True)
class Trajectory:
    """What one code made of a posed scene.

    In frame k, positions are those after k steps, velocities and spins those half a step before them, and forces
    those that led to these velocities: of the positions one step before, `lag` = 1. Codes that keep other moments
    are read accordingly; where a code records seldom, its forces may be those of the frame's positions, `lag` = 0.

    Attributes
    ----------
    code, version, law : str
    steps : (f,) int
    positions, velocities, spins : (f, n, 3) [m], [m/s], [rad/s]
    forces, torques : (f, n, 3) [N], [N m]
        Resultants, gravity included, before damping; nan where a code does not tell them.
    orientations : (f, n, 4) or None
        Quaternions, w first.
    pair_forces : PairForces or None
    wall_forces : (f, w, 3) [N] or None
        Of the particles on each wall of the assembly.
    broken : tuple of (first, second, step)
        Bonds, in the order of time; the step is that of the frame in which the break is first seen.
    lag : int
    start : State or None
        Where it stood one step before the first frame, if that is not the first or second step.
    seconds : float
        Of the whole run, with the start of the program and the reading of its answer; 0 where it was run with others.
    loop_seconds : float
        Of the steps alone: without start, building and the noting of frames; nan where a code does not tell, or
        where geodem compiled on the way.
    """

    code: str
    version: str
    law: str
    steps: Integers
    positions: Floats
    velocities: Floats
    spins: Floats
    forces: Floats
    torques: Floats
    orientations: Floats | None = None
    pair_forces: PairForces | None = None
    wall_forces: Floats | None = None
    broken: tuple[tuple[int, int, int], ...] = ()
    lag: int = 1
    start: State | None = None
    seconds: float = field(default=0.0, compare=False)
    loop_seconds: float = field(default=math.nan, compare=False)


def three(values: Floats) -> Floats:
    """Vectors (..., 2) of the plane as (..., 3); those of space as they are."""
    if values.shape[-1] == 3:
        return np.asarray(values, dtype=np.float64)
    return np.concatenate([values, np.zeros((*values.shape[:-1], 1))], axis=-1)


def about_z(values: Floats) -> Floats:
    """Rotations (..., 1) in the plane as (..., 3); those of space as they are."""
    if values.shape[-1] == 3:
        return np.asarray(values, dtype=np.float64)
    return np.concatenate([np.zeros((*values.shape[:-1], 2)), values], axis=-1)


def sorted_pairs(
    frame: Sequence[int] | Integers,
    pairs: Integers,
    normal: Floats,
    shear: Floats,
    along: Floats,
    spring: Floats | None = None,
) -> PairForces:
    """Forces on the first of each pair, in the order that `PairForces` asks for; all turned round with the pair."""
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    sign = np.where(pairs[:, 0] > pairs[:, 1], -1.0, 1.0)[:, None]
    pairs = np.sort(pairs, axis=1)
    frames = np.asarray(frame, dtype=np.int64)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], frames))

    def placed(values: Floats) -> Floats:
        return np.asarray((np.asarray(values).reshape(-1, 3) * sign)[order])

    remembered = None if spring is None else placed(spring)
    return PairForces(frames[order], pairs[order], placed(normal), placed(shear), placed(along), remembered)
