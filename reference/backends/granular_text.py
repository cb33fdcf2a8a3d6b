"""Text that LIGGGHTS and LAMMPS share: particles in, frames and loop times out. Nothing is rounded."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..scenes import Scene
from .outcome import Floats
from .program import BackendError

COLUMNS = "id x y z vx vy vz omegax omegay omegaz"
SKIN = 0.1
"""Distance beyond contact to which neighbours are listed, over the largest radius."""


def domain(scene: Scene) -> tuple[Floats, Floats]:
    """Corners of a domain that holds the particles and the walls with a margin."""
    reach = 2.0 * scene.radii.max()
    low, high = scene.positions.min(0) - reach, scene.positions.max(0) + reach
    if scene.box is not None:
        low, high = np.minimum(low, scene.box[0] - reach), np.maximum(high, scene.box[1] + reach)
    return low, high


def write_particles(path: Path, scene: Scene, *, types: int, bpm: bool = False) -> None:
    """Data file of spheres of type 1; `bpm`: with a molecule number, and with the scene's bonds."""
    n = scene.particles
    low, high = domain(scene)
    bonds = scene.bonds.pairs + 1 if bpm and scene.bonds is not None else np.zeros((0, 2), dtype=np.int64)
    with path.open("w") as out:
        out.write(f"spheres\n\n{n} atoms\n{types} atom types\n")
        if bpm:
            most = int(np.bincount(bonds.ravel()).max(initial=0))
            out.write(
                f"{len(bonds)} bonds\n1 bond types\n{most} extra bond per atom\n{most} extra special per atom\n"
            )
        for axis, name in enumerate("xyz"):
            out.write(f"{low[axis]:.17g} {high[axis]:.17g} {name}lo {name}hi\n")
        out.write("\nAtoms\n\n")
        number = np.arange(1.0, n + 1.0)
        head = [number, np.ones(n)] if not bpm else [number, np.ones(n), np.ones(n)]
        rows = np.column_stack([*head, 2.0 * scene.radii, np.full(n, scene.density), scene.positions])
        np.savetxt(out, rows, "%d " * len(head) + "%.17g " * 5)
        out.write("\nVelocities\n\n")
        np.savetxt(
            out, np.column_stack([number, scene.velocities_at_start(), scene.spins]), "%d" + " %.17g" * 6
        )
        if len(bonds):
            out.write("\nBonds\n\n")
            np.savetxt(out, np.column_stack([np.arange(1, len(bonds) + 1), np.ones(len(bonds)), bonds]), "%d")


def read_frames(path: Path, particles: int, first: int) -> Floats:
    """(frames, n, 9) columns after the number, of the frames from step `first` on, in the order of the numbers."""
    frames: dict[int, Floats] = {}
    with path.open() as lines:
        while line := lines.readline():
            if not line.startswith("ITEM: TIMESTEP"):
                raise BackendError(f"{path.name} has {line!r} where a frame should begin")
            step = int(lines.readline())
            while not line.startswith("ITEM: ATOMS"):
                line = lines.readline()
            table = np.loadtxt(lines, max_rows=particles, ndmin=2)
            if len(table) != particles:
                raise BackendError(
                    f"{particles - len(table)} of {particles} particles were lost by step {step}"
                )
            if step >= first:
                frames[step] = table[np.argsort(table[:, 0]), 1:]
    if not frames:
        raise BackendError(f"{path.name} holds no frame")
    return np.array([frames[step] for step in sorted(frames)])


def last_loop_seconds(printed: str) -> float:
    """Seconds of the last run but one: the last is of no step and writes the end state."""
    times = re.findall(r"Loop time of (\S+) on \d+ procs for [1-9]\d* steps", printed)
    if not times:
        raise BackendError(f"no loop time in:\n{printed[-2000:]}")
    return float(times[-1])
