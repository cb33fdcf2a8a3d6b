"""What LIGGGHTS and LAMMPS share on posed scenes: groups that are held, and velocity Verlet read as a leap-frog.

Both begin with the velocities at the time of the positions and end with such; they are brought back by half a step
with the forces that are told with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geodem.assembly import Assembly

from ..posed import Posed, Trajectory, about_z, three
from .granular_text import COLUMNS, Floats, Spheres, read_frames
from .program import refuse

FORCES = " fx fy fz tqx tqy tqz"
MOST_GROUPS = 28
"""They have 32 groups, four of them their own or for all."""
SPAN = 1e-3
"""Half the height of the domain of discs [m]."""


def spheres_of_assembly(posed: Posed, types: int) -> Spheres:
    """Particles as the data file has them, in a domain that is never left."""
    a = posed.assembly
    reach = 2.0 * float(a.radii.max())
    positions = three(a.positions)
    low, high = positions.min(0) - reach, positions.max(0) + reach
    for wall in a.walls:
        for point, _ in wall.planes:
            low, high = np.minimum(low, three(point) - reach), np.maximum(high, three(point) + reach)
    # how far the fastest comes, falling and flying, with as much again
    time = posed.steps * posed.time_step
    way = (
        2.0
        * time
        * (float(np.abs(a.velocities).max(initial=0.0)) + time * float(np.abs(a.gravity).max(initial=0.0)))
    )
    low, high = _within_planes(a, low, low - way, high, high + way)
    if a.dimension == 2:
        low[2], high[2] = -SPAN, SPAN
    volume = np.pi * a.radii**2 if a.dimension == 2 else 4.0 / 3.0 * np.pi * a.radii**3
    return Spheres(
        positions, three(a.velocities), about_z(a.spins), a.radii, a.mass / volume, a.material.astype(np.int64) + 1,
        types, low, high, a.bonds.astype(np.int64).reshape(-1, 2),
    )  # fmt: skip


def _within_planes(
    a: Assembly, low: Floats, lowest: Floats, high: Floats, highest: Floats
) -> tuple[Floats, Floats]:
    """The wide corners, but for sides that a plane closes: there the near ones do, and cells to search stay few."""
    corners = lowest.copy(), highest.copy()
    for wall in a.walls:
        for _, normal in wall.planes:
            axis = int(np.argmax(np.abs(normal)))
            if normal[axis] > 0.0:
                corners[0][axis] = low[axis]
            else:
                corners[1][axis] = high[axis]
    return corners


def refuse_half_held(a: Assembly, code: str) -> None:
    """Raise BackendError for freedoms that cannot be held there."""
    turning = a.held[:, a.dimension :]
    if not (turning.all(axis=1) == turning.any(axis=1)).all():
        raise refuse(code, "rotations are held about all axes or about none")
    if (turning.all(axis=1) & ~a.held[:, : a.dimension].all(axis=1)).any():
        raise refuse(code, "a particle that moves freely cannot be kept from turning")


def held_lines(a: Assembly, code: str) -> list[str]:
    """Groups of particles with the same held freedoms or the same given forces."""
    d, lines, groups = a.dimension, [], 0
    still = a.held.all(axis=1)
    kinds = {tuple(row) for row in a.held[~still, :d] if row.any()}
    pushes = {tuple(row) for row in a.applied[:, :d] if row.any()}
    if len(kinds) + len(pushes) + 1 > MOST_GROUPS:
        raise refuse(code, f"it has groups for {MOST_GROUPS} kinds of held and loaded particles")

    def group(members: Any) -> str:
        nonlocal groups
        groups += 1
        lines.append(f"group g{groups} id " + " ".join(str(k + 1) for k in np.flatnonzero(members)))
        return f"g{groups}"

    for push in sorted(pushes):
        name = group((a.applied[:, :d] == push).all(axis=1))
        lines.append(
            f"fix push{name} {name} addforce " + " ".join(repr(float(c)) for c in three(np.array(push)))
        )
    for kind in sorted(kinds):
        name = group((a.held[:, :d] == kind).all(axis=1) & ~still)
        words = ["0.0" if held else "NULL" for held in kind] + ["NULL"] * (3 - d)
        lines.append(f"fix hold{name} {name} setforce " + " ".join(words))
    if still.any():
        name = group(still)
        lines.append(f"fix hold{name} {name} freeze")
    return lines


def columns_of(walls: Sequence[str]) -> str:
    """Columns of a frame; `walls`: arrays that hold the forces of a plane on the particles."""
    return COLUMNS + FORCES + "".join(f" {name}[{c}]" for name in walls for c in (1, 2, 3))


@dataclass(frozen=True)
class Read:
    """Frames as they stand in the file, and the run that they tell of.

    Attributes
    ----------
    before : int
        Steps that the file holds before the first frame.
    positions, velocities, spins : (f, n, 3)
        Of all that the file holds; velocities and spins half a step back.
    lag : int
    trajectory : Trajectory
    """

    before: int
    positions: Floats
    velocities: Floats
    spins: Floats
    lag: int
    trajectory: Trajectory


def steps_before(posed: Posed) -> int:
    """Steps before the first frame that are recorded: one for the forces, one more for what pairs remember there."""
    if posed.every > 1:
        return 0
    return 2 if posed.first > 2 else 1


def read_verlet(posed: Posed, folder: Path, printed: str, walls: Sequence[str]) -> Read:
    """Frames of a run. Raises BackendError where they are not all there."""
    a = posed.assembly
    n, lag = a.particles, 1 if posed.every == 1 else 0
    before = steps_before(posed)
    first = posed.first - before
    steps = range(first, posed.steps + 1, posed.every)
    table = read_frames(
        folder / "frames.txt", n, first, columns=columns_of(walls), steps=steps, printed=printed
    )
    parts: Sequence[Any] = [table[:, :, 3 * k : 3 * k + 3] for k in range(5)]
    positions, velocities, spins, forces, torques = parts
    held = np.zeros((n, 6), dtype=bool)
    held[:, : a.dimension] = a.held[:, : a.dimension]
    held[:, 6 - a.rotations :] = a.held[:, a.dimension :]
    half = 0.5 * posed.time_step
    velocities = velocities - np.where(held[:, :3], 0.0, half * forces / a.mass[:, None])
    spins = spins - np.where(held[:, 3:], 0.0, half * torques / a.inertia[:, None])
    owners = [k for k, wall in enumerate(a.walls) for _ in wall.planes]
    on_walls = np.zeros((len(table), len(a.walls), 3))
    for place, k in enumerate(owners):
        on_walls[:, k] -= table[:, :, 15 + 3 * place : 18 + 3 * place].sum(axis=1)
    kept, acting = slice(before, None), slice(before - lag, len(table) - lag)
    trajectory = Trajectory(
        code="", version="", law="", steps=np.array(posed.frames),
        positions=positions[kept], velocities=velocities[kept], spins=spins[kept],
        forces=forces[acting], torques=torques[acting], wall_forces=on_walls[acting], lag=lag,
    )  # fmt: skip
    return Read(before, positions, velocities, spins, lag, trajectory)
