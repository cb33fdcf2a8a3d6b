"""Text that LIGGGHTS and LAMMPS share: particles in, frames and loop times out. Nothing is rounded."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from ..scenes import Scene
from .outcome import Floats
from .program import BackendError, last_words

COLUMNS = "id x y z vx vy vz omegax omegay omegaz"
SKIN = 0.1
"""Distance beyond contact to which neighbours are listed, over the largest radius."""


@dataclass(frozen=True)
class Spheres:
    """Spheres as a data file has them.

    Attributes
    ----------
    positions, velocities, spins : (n, 3) [m], [m/s], [rad/s]
        The velocities are those at the time of the positions.
    radii, density : (n,) [m], [kg/m3]
    kind : (n,) int
        Type, from 1.
    types : int
    low, high : (3,) [m]
        Corners of the domain.
    bonds : (b, 2) int
        From 0.
    bond_kind : (b,) int or None
        Type of every bond, from 1; all of type 1 where it is None.
    """

    positions: Floats
    velocities: Floats
    spins: Floats
    radii: Floats
    density: Floats
    kind: NDArray[np.int64]
    types: int
    low: Floats
    high: Floats
    bonds: NDArray[np.int64]
    bond_kind: NDArray[np.int64] | None = None


def domain(scene: Scene) -> tuple[Floats, Floats]:
    """Corners of a domain that holds the particles and the walls with a margin."""
    reach = 2.0 * scene.radii.max()
    low, high = scene.positions.min(0) - reach, scene.positions.max(0) + reach
    if scene.box is not None:
        low, high = np.minimum(low, scene.box[0] - reach), np.maximum(high, scene.box[1] + reach)
    return low, high


def spheres_of(scene: Scene, *, types: int) -> Spheres:
    """Those of a scene, all of type 1."""
    low, high = domain(scene)
    n = scene.particles
    bonds = scene.bonds.pairs if scene.bonds is not None else np.zeros((0, 2), dtype=np.int64)
    return Spheres(
        scene.positions, scene.velocities_at_start(), scene.spins, scene.radii, np.full(n, scene.density),
        np.ones(n, dtype=np.int64), types, low, high, bonds,
    )  # fmt: skip


def write_particles(path: Path, spheres: Spheres, *, bpm: bool = False) -> None:
    """Data file; `bpm`: with a molecule number, and with the bonds."""
    n = len(spheres.radii)
    bonds = spheres.bonds + 1 if bpm else np.zeros((0, 2), dtype=np.int64)
    kinds = np.ones(len(bonds), dtype=np.int64) if spheres.bond_kind is None else spheres.bond_kind
    with path.open("w") as out:
        out.write(f"spheres\n\n{n} atoms\n{spheres.types} atom types\n")
        if bpm:
            most = int(np.bincount(bonds.ravel()).max(initial=0))
            out.write(
                f"{len(bonds)} bonds\n{int(kinds.max(initial=1))} bond types\n"
                f"{most} extra bond per atom\n{most} extra special per atom\n"
            )
        for axis, name in enumerate("xyz"):
            out.write(f"{spheres.low[axis]:.17g} {spheres.high[axis]:.17g} {name}lo {name}hi\n")
        out.write("\nAtoms\n\n")
        number = np.arange(1.0, n + 1.0)
        head = [number, spheres.kind] if not bpm else [number, np.ones(n), spheres.kind]
        rows = np.column_stack([*head, 2.0 * spheres.radii, spheres.density, spheres.positions])
        np.savetxt(out, rows, "%d " * len(head) + "%.17g " * 5)
        out.write("\nVelocities\n\n")
        np.savetxt(out, np.column_stack([number, spheres.velocities, spheres.spins]), "%d" + " %.17g" * 6)
        if len(bonds):
            out.write("\nBonds\n\n")
            np.savetxt(out, np.column_stack([np.arange(1, len(bonds) + 1), kinds, bonds]), "%d")


def read_frames(
    path: Path,
    particles: int,
    first: int,
    *,
    columns: str = COLUMNS,
    steps: Sequence[int] | None = None,
    printed: str = "",
) -> Floats:
    """(frames, n, columns - 1) columns after the number, from step `first` on, in the order of the numbers.

    `steps`: those that must be there. Raises BackendError, with the last words of what was printed, where a frame,
    a particle or a column is absent, or a number is not finite.
    """
    frames: dict[int, Floats] = {}
    for step, names, rows in _frames(path, printed):
        if names != columns.split():
            raise BackendError(
                f"{path.name} has the columns {' '.join(names)} where {columns} was asked for. {last_words(printed)}"
            )
        table = _table(rows, len(names), f"{path.name}, step {step}", printed)
        if len(table) != particles:
            raise BackendError(
                f"{particles - len(table)} of {particles} particles were lost by step {step}. {last_words(printed)}"
            )
        table = table[np.argsort(table[:, 0])]
        if not np.array_equal(table[:, 0], np.arange(1, particles + 1)):
            raise BackendError(f"{path.name} has other particles at step {step}. {last_words(printed)}")
        if step >= first:
            frames[step] = table[:, 1:]
    if not frames:
        raise BackendError(f"{path.name} holds no frame. {last_words(printed)}")
    if steps is not None and sorted(frames) != list(steps):
        lost = sorted(set(steps) - set(frames))
        raise BackendError(
            f"{path.name} gives half an answer: {len(frames)} of {len(steps)} frames, the first that is absent is of "
            f"step {lost[0] if lost else 'none'}. {last_words(printed)}"
        )
    return np.array([frames[step] for step in sorted(frames)])


def read_local(path: Path, columns: int, steps: Sequence[int], printed: str) -> dict[int, Floats]:
    """(m, columns) of every step in `steps`: what a dump of pairs holds."""
    found = {}
    for step, _, rows in _frames(path, printed):
        if step in steps:
            found[step] = (
                _table(rows, columns, f"{path.name}, step {step}", printed)
                if rows
                else np.zeros((0, columns))
            )
    if len(found) != len(steps):
        raise BackendError(
            f"{path.name} gives half an answer: {len(found)} of {len(steps)} frames. {last_words(printed)}"
        )
    return found


def _frames(path: Path, printed: str) -> Iterator[tuple[int, list[str], list[str]]]:
    """Step, names of columns, lines of every frame."""
    if not path.exists():
        raise BackendError(f"there is no {path.name}. {last_words(printed)}")
    with path.open() as lines:
        while line := lines.readline():
            if not line.startswith("ITEM: TIMESTEP"):
                raise BackendError(f"{path.name} has {line!r} where a frame should begin")
            step, count, names = _head(lines, path, printed)
            yield step, names, [lines.readline() for _ in range(count)]


def _head(lines: TextIO, path: Path, printed: str) -> tuple[int, int, list[str]]:
    """Step, number of lines and names of columns."""
    try:
        step, count = int(lines.readline()), -1
        while line := lines.readline():
            if line.startswith("ITEM: NUMBER"):
                count = int(lines.readline())
            elif line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
                if count < 0:
                    break
                return step, count, line.split()[2:]
    except ValueError:
        pass
    raise BackendError(f"{path.name} is cut off or of another kind. {last_words(printed)}")


def _table(rows: list[str], columns: int, place: str, printed: str) -> Floats:
    try:
        table = np.loadtxt(rows, ndmin=2) if rows else np.zeros((0, columns))
    except ValueError as error:
        raise BackendError(f"{place}: a line is cut off ({error}). {last_words(printed)}") from error
    if table.shape[1:] != (columns,) or not np.isfinite(table).all():
        what = "numbers that are not finite" if table.shape[1:] == (columns,) else "columns that are absent"
        raise BackendError(f"{place}: {what}. {last_words(printed)}")
    return table


def loop_seconds(printed: str) -> float:
    """Seconds of all runs together, less those in which frames were written; nan where none is printed."""
    times = re.findall(r"Loop time of (\S+) on", printed)
    writing = re.findall(r"^Outpt\s+time \(%\) = (\S+)", printed, flags=re.M)
    return sum(map(float, times)) - sum(map(float, writing)) if times else math.nan


def last_loop_seconds(printed: str) -> float:
    """Seconds of the last run but one: the last is of no step and writes the end state."""
    times = re.findall(r"Loop time of (\S+) on \d+ procs for [1-9]\d* steps", printed)
    if not times:
        raise BackendError(f"no loop time was printed. {last_words(printed)}")
    return float(times[-1])
