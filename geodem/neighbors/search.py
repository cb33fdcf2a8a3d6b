"""The neighbour search: all pairs nearer than the buffer, with what the old list knows of them.

Two passes, each parallel over chunks: find the near particles of every row; write the pairs and take over bonds and
history from the old list. Where old pairs must be kept although they are far, they are found first.
Every chunk does its work alone and in one order, so no bit depends on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from ..errors import InputError
from .carry import copy_pairs, find_strays, list_strays, look_up, meet, merge, old_other, sum_up, write
from .cells import (
    BLOCK,
    FAR,
    MARGIN,
    Levels,
    cells_of_particles,
    fold,
    gather_spots,
    plan_levels,
    sort_by_cell,
)
from .images import Copies, Lattice, fold_copies, make_copies, set_images
from .lanes import WIDE, texts
from .near import (
    GROUP,
    GROUP_SPREAD,
    REGION,
    REGION_SPREAD,
    add_missing,
    find,
    find_in_chunk,
    find_with_room,
    gather,
    rows_together,
    sort_many,
    spot_reach,
    steps_between,
)
from .pair_list import PairList, chunks_of

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RADIUS_COLUMN = {2: 2, 3: 3}
"""Column of the radius in the rows of the state, by dimension."""
ROOM_PER_PARTICLE = {2: 8, 3: 16}
"""Pairs per particle that a first search has room for; more where the old list had more."""


NO_CELL = Lattice(np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3))


@cache
def _writer(history_width: int) -> ModuleType:
    return _jit.compile_kernel(
        [old_other, copy_pairs, meet, merge, look_up, write], {"HISTORY": history_width}, parallel=True
    )


@cache
def _kernel(dimension: int, periodic: bool) -> ModuleType:
    functions: list[Callable[..., Any]] = [
        fold, steps_between, spot_reach, cells_of_particles, sort_by_cell, gather_spots, sum_up,
        rows_together, gather, add_missing, sort_many, find_with_room, find_in_chunk, find, find_strays, list_strays,
    ]  # fmt: skip
    if periodic:
        functions.append(fold_copies)
    constants = {
        "DIMENSION": dimension,
        "PERIODIC": periodic,
        "RADIUS": RADIUS_COLUMN[dimension],
        "FAR": FAR,
        "BLOCK": BLOCK,
        "MARGIN": MARGIN,
        "GROUP": GROUP,
        "GROUP_SPREAD": GROUP_SPREAD,
        "REGION": REGION,
        "REGION_SPREAD": REGION_SPREAD,
    }
    return _jit.compile_kernel(functions, constants, parallel=True, texts=texts())


@dataclass(frozen=True)
class _Grid:
    """Levels and the particles in their cells."""

    levels: Levels
    start: NDArray[np.int32]
    order: NDArray[np.int32]
    spot: Floats


def _fill_grid(rows: Floats, kernel: ModuleType, levels: Levels, half_buffer: float, dimension: int) -> _Grid:
    cell = np.empty(len(rows), dtype=np.int32)
    start = np.empty(int(levels.offset[-1]) + 2, dtype=np.int32)
    # vector instructions read beyond the last
    order = np.empty(len(rows) + WIDE, dtype=np.int32)
    spot = np.empty((dimension + 1) * len(order))
    kernel.cells_of_particles(
        rows, levels.origin, levels.bound, levels.inverse, levels.shape, levels.offset, cell
    )
    kernel.sort_by_cell(cell, start, order)
    kernel.gather_spots(rows, half_buffer, order, spot)
    return _Grid(levels, start, order, spot)


@dataclass(frozen=True)
class _Strays:
    """Far pairs that are to be listed: row i lists listed[row[i] : row[i + 1]]; `row` is empty where there are none."""

    pairs: int
    row: Integers
    listed: NDArray[np.int32]


def _no_strays() -> _Strays:
    return _Strays(0, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int32))


def _find_strays(
    rows: Floats,
    kernel: ModuleType,
    old: PairList,
    buffer: float,
    chunk: int,
    new_row_of_old: Integers | None,
    cell: Lattice,
) -> _Strays:
    stray = np.empty((old.pairs, 2), dtype=np.int32)
    count = np.empty(len(old.start) - 1, dtype=np.int64)
    mapped = new_row_of_old is not None
    kernel.find_strays(
        rows, buffer, old.chunk, old.row, old.a, old.b, old.bond, old.touching,
        mapped, np.empty(0, dtype=np.int64) if new_row_of_old is None else new_row_of_old,
        cell.vectors, cell.inverse, stray, count,
    )  # fmt: skip
    pairs = int(count.sum())
    if pairs == 0:
        return _no_strays()
    row = np.zeros(len(rows) + 2, dtype=np.int64)
    listed = np.empty(pairs, dtype=np.int32)
    kernel.list_strays(old.chunk, old.row, stray, count, row, listed)
    return _Strays(pairs, row, listed)


def rebuild(
    rows: Floats,
    ids: NDArray[np.int64] | NDArray[np.int32],
    old: PairList | None,
    old_row_of_new: Integers | None = None,
    new_row_of_old: Integers | None = None,
    *,
    chunk: int,
    buffer: float,
    dimension: int,
    history_width: int,
    multilevel: bool = True,
    cell: Lattice | None = None,
) -> PairList:
    """List all pairs with d < ra + rb + buffer, and take over what the old list knows of them.

    Old pairs whose bond is intact, or which touched in the last step, stay listed however far apart they are.

    Parameters
    ----------
    rows : (n, W)
        Rows of the state: coordinates first [m], the radius in column 2 (2D) or 3 (3D).
    ids : (n,)
        Particle id of every row; a pair's a is the particle with the lower id.
    old : PairList, optional
        The list so far, in the order the rows had then.
    old_row_of_new, new_row_of_old : (n,) int64, optional
        The two permutations, where the rows were re-sorted since: both or neither.
    chunk : int
        Particles per chunk.
    buffer : float
        Distance of surfaces below which a pair is listed [m].
    dimension : int
        2 or 3.
    history_width : int
        Numbers that each pair remembers, H.
    multilevel : bool
        False: one grid whatever the sizes of the particles.
    cell : Lattice, optional
        A periodic cell: distances are those of the nearest images, and the list notes which.

    Returns
    -------
    PairList
        New arrays; the old list is left as it is.

    Raises
    ------
    InputError
        Where only one of the two permutations is given.
    """
    particles = len(rows)
    if old is None:
        old = PairList.empty(particles, chunk=chunk, history_width=history_width)
    if particles == 0:
        return PairList.empty(0, chunk=chunk, history_width=history_width)
    mapped = old_row_of_new is not None
    if mapped != (new_row_of_old is not None):
        raise InputError(
            "new_row_of_old" if mapped else "old_row_of_new",
            "one permutation is missing",
            "Give both or neither",
        )
    if old_row_of_new is None or new_row_of_old is None:
        old_row_of_new = new_row_of_old = np.empty(0, dtype=np.int64)

    kernel = _kernel(dimension, cell is not None)
    column = RADIUS_COLUMN[dimension]
    # what the walk meets
    met, copies = rows, None
    if cell is not None:
        copies = make_copies(rows, cell, buffer=buffer, dimension=dimension)
        met = copies.rows
    levels = plan_levels(met, dimension=dimension, radius_column=column, buffer=buffer, multilevel=multilevel)
    grid = _fill_grid(met, kernel, levels, 0.5 * buffer, dimension)
    capacity = chunk * max(ROOM_PER_PARTICLE[dimension], 2 * old.pairs // particles)
    lost = np.empty(chunks_of(particles, chunk), dtype=np.int64)
    # far pairs are rare: mostly it is cheaper to see afterwards that none is missing
    ask_first = old.far > 0
    while True:
        strays = _no_strays()
        if ask_first:
            strays = _find_strays(
                rows, kernel, old, buffer, chunk, new_row_of_old if mapped else None, cell or NO_CELL
            )
        near, row = _near_rows(met[:particles], copies, kernel, grid, strays, capacity, 0.5 * buffer, chunk)
        new = PairList.allocate(row, chunk=chunk, history_width=history_width)
        _writer(history_width).write(
            chunk, near, ids, row, new.a, new.b, new.bond, new.touching, new.history.reshape(-1),
            old.row, old.a, old.b, old.bond, old.touching, old.history.reshape(-1), mapped, old_row_of_new, lost,
        )  # fmt: skip
        new.far = strays.pairs
        if ask_first or lost.sum() == 0:
            if cell is not None:
                set_images(rows, new, cell, dimension)
            return new
        ask_first = True


def _near_rows(
    rows: Floats,
    copies: Copies | None,
    kernel: ModuleType,
    grid: _Grid,
    strays: _Strays,
    capacity: int,
    half_buffer: float,
    chunk: int,
) -> tuple[NDArray[np.int32], Integers]:
    """Rows near to every row, chunk by chunk (chunks, capacity), and where the pairs of every row begin (n + 1,)."""
    parts = chunks_of(len(rows), chunk)
    row = np.zeros(len(rows) + 1, dtype=np.int64)
    failed = np.zeros(parts, dtype=np.uint8)
    levels = grid.levels
    while True:
        near = np.empty((parts, capacity), dtype=np.int32)
        kernel.find(
            rows, half_buffer, chunk,
            levels.origin, levels.reach, levels.inverse, levels.shape, levels.offset,
            grid.start, grid.order, grid.spot, strays.row, strays.listed, near, row, failed,
        )  # fmt: skip
        if not failed.any():
            break
        capacity *= 2
    if copies is not None:
        kernel.fold_copies(chunk, near, row, copies.of)
    kernel.sum_up(row)
    return near, row
