"""A scene posed once for geodem and for every other code, what a run of it gives, and how far two runs differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Memory:
    """What touching pairs and walls remember when the motion begins.

    Attributes
    ----------
    pairs : (k, 2) int
    shear : (k, 3) [N]
        Elastic shear force on the first of the two.
    along : (k, 3) [-]
        From the first to the second, of the step that left the shear force.
    spring : (k, 3) [m] or None
        Elastic tangential displacement of the first against the second, where the law remembers that.
    """

    pairs: Integers
    shear: Floats
    along: Floats
    spring: Floats | None = None


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
        Frames are recorded of the steps first, first + every, ... up to `steps`.
    pairs_at : tuple of int or None
        Those of these steps of which the forces between pairs are recorded, too; all of them where it is None.
    memory : Memory or None
        What is handed over; velocities and spins are then those half a step back in every convention.
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
        On the first of the two; nan where a code does not tell them.
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
        which = self.frame == frame
        parts = (self.frame, self.pairs, self.normal, self.shear, self.along)
        return PairForces(
            *(part[which] for part in parts), None if self.spring is None else self.spring[which]
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
    seconds : float
        Of the whole run, with the start of the program and the reading of its answer; 0 where it was run with others.
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
    seconds: float = field(default=0.0, compare=False)


QUANTITIES = (
    "positions", "velocities", "spins", "forces", "torques", "pair_shear", "pair_normal", "wall_forces", "broken",
)  # fmt: skip

ROUNDING = 1e-9
"""Share of its natural size up to which a quantity counts as zero: spins beside speed over radius, and the like."""


def differences(one: Trajectory, other: Trajectory, posed: Posed) -> dict[str, float]:
    """Largest |difference| over largest |value|, over all frames, of each quantity that is posed to be compared.

    A quantity that is zero but for rounding is held against its natural size. The difference is infinite where the
    two do not speak of the same steps, pairs or broken bonds, and where a number is not finite.
    """
    found = {}
    for name in posed.quantities:
        if name == "broken":
            found[name] = 0.0 if one.broken == other.broken else np.inf
        elif name in ("pair_shear", "pair_normal"):
            found[name] = _pairs_apart(one, other, name.removeprefix("pair_"), posed)
        else:
            found[name] = _apart(one, other, name, posed)
    return found


def _apart(one: Trajectory, other: Trajectory, name: str, posed: Posed) -> float:
    first, second = getattr(one, name), getattr(other, name)
    if not np.array_equal(one.steps, other.steps) or first is None or second is None:
        return np.inf
    if name not in ("positions", "velocities", "spins") and one.lag != other.lag:
        return np.inf
    if first.shape != second.shape:
        return np.inf
    if name in ("forces", "torques"):
        # a code that holds a freedom need not tell what holds it
        held = posed.assembly.held
        d = posed.assembly.dimension
        free = np.ones(first.shape[1:], dtype=bool)
        part = held[:, :d] if name == "forces" else held[:, d:]
        axes = part.shape[1]
        free[:, :axes] = ~part
        if name == "torques" and axes == 1:
            free[:] = ~part
        first, second = np.where(free, first, 0.0), np.where(free, second, 0.0)
    return _ratio(first, second, _natural(one, name, posed))


def _natural(one: Trajectory, name: str, posed: Posed) -> float:
    """Size that a quantity would have if it mattered."""
    radius = float(posed.assembly.radii.max())
    speed, force = float(np.abs(one.velocities).max()), float(np.abs(np.nan_to_num(one.forces)).max())
    return {
        "spins": speed / radius,
        "torques": force * radius,
        "velocities": radius / posed.time_step * 1e-6,
    }.get(name, force if name != "positions" else radius)


def _ratio(first: Floats, second: Floats, natural: float) -> float:
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        return np.inf
    size = max(float(np.abs(first).max(initial=0.0)), float(np.abs(second).max(initial=0.0)))
    apart = float(np.abs(first - second).max(initial=0.0))
    if size <= ROUNDING * natural:
        size = natural
    return apart / size if apart > 0.0 else 0.0


def _pairs_apart(one: Trajectory, other: Trajectory, part: str, posed: Posed) -> float:
    first, second = one.pair_forces, other.pair_forces
    if first is None or second is None or one.lag != other.lag:
        return np.inf
    if not (np.array_equal(first.frame, second.frame) and np.array_equal(first.pairs, second.pairs)):
        return np.inf
    force = float(np.abs(np.nan_to_num(one.forces)).max(initial=0.0))
    return _ratio(getattr(first, part), getattr(second, part), force)


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


def good(found: dict[str, float], bound: float) -> bool:
    """Whether something was compared and nothing differs by more than the bound."""
    return bool(found) and all(value <= bound for value in found.values())


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
    vectors = [(np.asarray(each).reshape(-1, 3) * sign)[order] for each in (normal, shear, along)]
    remembered = None if spring is None else (np.asarray(spring).reshape(-1, 3) * sign)[order]
    return PairForces(frames[order], pairs[order], *vectors, remembered)
