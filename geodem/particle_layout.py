"""How an assembly becomes the arrays of the kernels, in the order of the rows, and back in the order of the user."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .assembly import Assembly
from .neighbors import PairList, lattice, spatial_order, wrapped

Floats = NDArray[np.float64]

UNBREAKABLE = 1e300
"""What stands for an infinite strength in the kernels, which know finite numbers only."""


NOTHING_AROUND = (np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))
"""Stands for the chunks around each chunk where nothing sleeps."""


class Sleep(NamedTuple):
    """When parts at rest are skipped.

    Chunks of particles (neighbours in space) slower than `speed` for `steps` steps, they and all chunks they touch, are
    taken to stand still and cost nothing until something near them moves faster.
    """

    speed: float  # [m/s]
    steps: int = 100


class Columns:
    """Columns of the rows by dimension."""

    def __init__(self, dimension: int) -> None:
        self.width = 8 if dimension == 2 else 12
        self.radius = 2 if dimension == 2 else 3
        self.material = 3 if dimension == 2 else 11
        self.velocity = slice(4, 4 + dimension)
        self.mass = 7
        self.spin = slice(6, 7) if dimension == 2 else slice(8, 11)
        self.position = slice(0, dimension)


@dataclass
class RowArrays:
    """Arrays by row that steps read but do not change.

    Attributes
    ----------
    ids : (n,) int64
        Particle of every row.
    inverse_mass, inverse_inertia : (n,)
    held : (n,) uint8
        Bit k holds freedom k.
    applied : (n, d + s) or (1, d + s)
        One empty row where nothing is applied.
    anchor_of : (n,) or (1,) int32
        Row of the anchors, or -1.
    """

    ids: NDArray[np.int64]
    inverse_mass: Floats
    inverse_inertia: Floats
    held: NDArray[np.uint8]
    applied: Floats
    anchor_of: NDArray[np.int32]

    def taken(self, order: NDArray[np.int64]) -> RowArrays:
        """The same in another order of the rows: row i becomes what row order[i] was."""
        return RowArrays(
            *(
                array if len(array) < len(order) else np.ascontiguousarray(array[order])
                for array in vars(self).values()
            )
        )


def first_order(assembly: Assembly) -> NDArray[np.int64]:
    """Particle of every row at the start."""
    places = assembly.positions
    if assembly.cell is not None:
        places = wrapped(places, lattice(assembly.cell.vectors, assembly.cell.periodic), assembly.dimension)
    return spatial_order(np.ascontiguousarray(places), assembly.radii)


def first_rows(assembly: Assembly, ids: NDArray[np.int64]) -> Floats:
    """Both buffers of rows (2, n, W) at the start."""
    columns = Columns(assembly.dimension)
    rows = np.zeros((2, assembly.particles, columns.width))
    now = rows[0]
    now[:, columns.position] = assembly.positions[ids]
    now[:, columns.radius] = assembly.radii[ids]
    now[:, columns.material] = assembly.material[ids]
    now[:, columns.velocity] = assembly.velocities[ids]
    now[:, columns.mass] = assembly.mass[ids]
    now[:, columns.spin] = assembly.spins[ids]
    rows[1] = now
    return rows


def row_arrays(assembly: Assembly, ids: NDArray[np.int64], *, applied: bool) -> RowArrays:
    """What steps read, in the order of the rows; `applied`: forces are or will be applied.

    No particle has several anchors.
    """
    bits = 1 << np.arange(assembly.held.shape[1])
    anchor_of = np.full(1, -1, dtype=np.int32)
    if assembly.anchors is not None:
        of_particle = np.full(assembly.particles, -1, dtype=np.int32)
        of_particle[assembly.anchors.particle] = np.arange(len(assembly.anchors.particle))
        anchor_of = of_particle[ids]
    return RowArrays(
        ids=ids,
        inverse_mass=1.0 / assembly.mass[ids],
        inverse_inertia=1.0 / assembly.inertia[ids],
        held=(assembly.held[ids] @ bits).astype(np.uint8),
        applied=np.ascontiguousarray(assembly.applied[ids])
        if applied
        else np.zeros((1, assembly.held.shape[1])),
        anchor_of=anchor_of,
    )


def anchor_table(assembly: Assembly) -> Floats:
    """Point, stiffness and length of every anchor (k, d + 2)."""
    anchors = assembly.anchors
    if anchors is None:
        return np.zeros((1, assembly.dimension + 2))
    return np.column_stack([anchors.point, anchors.stiffness, anchors.length])


def finite(table: Floats) -> Floats:
    """A parameter table with finite numbers only."""
    return np.ascontiguousarray(np.where(np.isinf(table), UNBREAKABLE, table))


def wall_parameters(assembly: Assembly) -> Floats:
    """Parameters of contacts with walls, row material * walls + wall."""
    rows = [tuple(wall.contact[name]) for name in assembly.material_names for wall in assembly.walls]
    width = assembly.contact_table.shape[1]
    return finite(np.array(rows, dtype=np.float64).reshape(-1, width))


def chunk_size(particles: int, serial: bool) -> int:
    """Particles a chunk: enough chunks to share among many cores, and chunks large enough to pay for themselves.

    It follows from the scene alone, so the bits do not depend on the machine.
    """
    if serial:
        return max(particles, 1)
    size = 128
    while size < 1024 and size * 64 < particles:
        size *= 2
    return size


def chunks_around(pairs: PairList) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Chunks that share pairs with each chunk, as compressed rows."""
    first, second = pairs.a.astype(np.int64) // pairs.chunk, pairs.b.astype(np.int64) // pairs.chunk
    across = first != second
    chunks = len(pairs.start) - 1
    key = np.unique(
        np.concatenate([first[across] * chunks + second[across], second[across] * chunks + first[across]])
    )
    start = np.zeros(chunks + 1, dtype=np.int64)
    np.cumsum(np.bincount(key // chunks, minlength=chunks), out=start[1:])
    neighbour = key % chunks
    return start, neighbour if len(neighbour) else np.zeros(1, np.int64)
