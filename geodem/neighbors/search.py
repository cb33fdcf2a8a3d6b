"""The neighbour search: all pairs nearer than the buffer, with what the old list knows of them.

Three passes, each parallel over chunks: find the near particles of every row; find the old pairs that are kept
although they are farther; write the pairs and take over bonds and history from the old list.
Every chunk does its work alone and in one order, so no bit depends on the number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from ..errors import InputError
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
from .pair_list import PairList, chunks_of

prange = range

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3
HISTORY = 0
FEW = 32

RADIUS_COLUMN = {2: 2, 3: 3}
"""Column of the radius in the rows of the state, by dimension."""
ROOM_PER_PARTICLE = {2: 8, 3: 16}
"""Pairs per particle that a first search has room for; more where the old list had more."""


def find(
    rows, half_buffer, chunk, capacity, origin, reach, inverse, shape, offset, start, order, spot,
    stray_row, stray, near, count, failed,
):  # fmt: skip
    """Near rows of every row, ascending.

    The grid: origin, reach, inverse, shape, offset (`geodem.neighbors.cells.Levels`), start, order, spot.
    stray_row, stray: CSR of far rows to be listed all the same; no entries where stray_row is empty.
    Overwritten: near (chunks * capacity,) int32, one part for each chunk; count (n + 1,), of row i at i + 1;
    failed (chunks,) uint8: 1 where the capacity was too small.
    """
    particles = len(rows)
    levels = len(reach)
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        place = part * capacity
        limit = place + capacity
        full = False
        ordered = np.empty(FEW, np.int32)
        for particle in range(first, min(particles, first + chunk)):
            begin = place
            x = rows[particle, 0]
            y = rows[particle, 1]
            z = rows[particle, 2] if DIMENSION == 3 else 0.0
            own = spot_reach(rows[particle, RADIUS], half_buffer)
            for level in range(levels):
                if start[offset[level]] == start[offset[level + 1]]:
                    continue
                radius = (own + reach[level]) * (1.0 + MARGIN)
                columns = shape[level, 0]
                lines = shape[level, 1]
                layers = shape[level, 2]
                low = (x - origin[0] - radius) * inverse[level, 0]
                column = fold(low, columns)
                across = steps_between(low, (x - origin[0] + radius) * inverse[level, 0], columns)
                low = (y - origin[1] - radius) * inverse[level, 1]
                first_line = fold(low, lines)
                high_lines = steps_between(low, (y - origin[1] + radius) * inverse[level, 1], lines)
                layer = 0
                deep = 1
                if DIMENSION == 3:
                    low = (z - origin[2] - radius) * inverse[level, 2]
                    layer = fold(low, layers)
                    deep = steps_between(low, (z - origin[2] + radius) * inverse[level, 2], layers)
                wraps = column + across > columns
                for _ in range(deep):
                    line = first_line
                    for _ in range(high_lines):
                        base = offset[level] + (layer * lines + line) * columns
                        index = start[base + column]
                        last = start[base + (columns if wraps else column + across)]
                        again = wraps
                        while True:
                            while index < last:
                                stop = min(last, index + limit - place)
                                if stop == index:
                                    full = True
                                    break
                                for k in range(index, stop):
                                    dx = spot[k, 0] - x
                                    dy = spot[k, 1] - y
                                    square = dx * dx + dy * dy
                                    if DIMENSION == 3:
                                        dz = spot[k, 2] - z
                                        square += dz * dz
                                    both = own + spot[k, DIMENSION]
                                    other = order[k]
                                    near[place] = other
                                    place += np.int64(
                                        (square < both * both) & ((other > particle) | (other < first))
                                    )
                                index = stop
                            if not again:
                                break
                            again = False
                            index = start[base]
                            last = start[base + column + across - columns]
                        line = line + 1 if line + 1 < lines else 0
                    layer = layer + 1 if layer + 1 < layers else 0
            if len(stray_row) > 0:
                for k in range(stray_row[particle], stray_row[particle + 1]):
                    known = False
                    for index in range(begin, place):
                        known = known or near[index] == stray[k]
                    if not known:
                        if place == limit:
                            full = True
                            break
                        near[place] = stray[k]
                        place += 1
            listed = place - begin
            count[particle + 1] = listed
            if listed <= FEW:
                for index in range(listed):
                    other = near[begin + index]
                    before = 0
                    for k in range(listed):
                        before += int(near[begin + k] < other)
                    ordered[before] = other
                for index in range(listed):
                    near[begin + index] = ordered[index]
            else:
                near[begin:place].sort()
        failed[part] = full


def spot_reach(radius, half_buffer):
    """Reach of a particle, by the same expression as in `gather_spots`: a pair looks the same from both sides."""
    return radius + half_buffer


def steps_between(low, high, size):
    """Number of cells from one place to another, both counted in cells, each cell once."""
    first = low if low > -FAR else -FAR
    first = first if first < FAR else FAR
    last = high if high > -FAR else -FAR
    last = last if last < FAR else FAR
    steps = np.int64(math.floor(last)) - np.int64(math.floor(first)) + 1
    return steps if steps < size else size


def find_strays(rows, buffer, chunk, row, a, b, bond, touching, mapped, new_row_of_old, stray, count):
    """Old pairs that are intact bonds or touch, and are not nearer than the buffer.

    Each pair once. Overwritten: stray (p, 2) int32, the new rows, where the chunk's pairs begin; count (chunks,).
    """
    particles = len(row) - 1
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        place = row[first]
        for old in range(first, min(particles, first + chunk)):
            for pair in range(row[old], row[old + 1]):
                if bond[pair] == 0 and touching[pair] != 1:
                    continue
                i = np.int64(a[pair])
                j = np.int64(b[pair])
                if min(i, j) < old:
                    continue
                if mapped:
                    i = new_row_of_old[i]
                    j = new_row_of_old[j]
                square = 0.0
                for axis in range(DIMENSION):
                    step = rows[j, axis] - rows[i, axis]
                    square += step * step
                both = rows[i, RADIUS] + rows[j, RADIUS] + buffer
                # a little too many are harmless: what `find` finds itself is not listed twice
                if not square < both * both * (1.0 - 1e-9):
                    stray[place, 0] = i
                    stray[place, 1] = j
                    place += 1
        count[part] = place - row[first]


def list_strays(old_chunk, old_row, stray, count, chunk, stray_row, listed):
    """Strays under the rows that shall list them: stray_row (n + 2,), listed (2 * strays,) int32, overwritten.

    Row i lists listed[stray_row[i] : stray_row[i + 1]].
    """
    for fill in range(2):
        # counted two places ahead, so that the filling leaves the starts where they belong
        ahead = 1 if fill else 2
        for part in range(len(count)):
            place = old_row[part * old_chunk]
            for pair in range(place, place + count[part]):
                i = np.int64(min(stray[pair, 0], stray[pair, 1]))
                j = np.int64(max(stray[pair, 0], stray[pair, 1]))
                if fill:
                    listed[stray_row[i + 1]] = j
                stray_row[i + ahead] += 1
                if i // chunk != j // chunk:
                    if fill:
                        listed[stray_row[j + 1]] = i
                    stray_row[j + ahead] += 1
        if not fill:
            sum_up(stray_row)


def sum_up(row):
    """Running sum of counts in place."""
    total = 0
    for index in range(len(row)):
        total += row[index]
        row[index] = total


def write(
    chunk, capacity, near, ids, row, a, b, bond, touching, history,
    old_chunk, old_row, old_a, old_b, old_bond, old_touching, old_history, mapped, old_row_of_new,
):  # fmt: skip
    """Pairs of every row, with what the old list knows of them: a, b, bond, touching, history, overwritten."""
    particles = len(row) - 1
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        source = part * capacity - row[first]
        for particle in range(first, min(particles, first + chunk)):
            own = old_row_of_new[particle] if mapped else particle
            own_first = old_row[own]
            own_last = old_row[own + 1]
            own_part = own // old_chunk
            expected = own_first
            for pair in range(row[particle], row[particle + 1]):
                other = np.int64(near[source + pair])
                lower = ids[particle] < ids[other]
                a[pair] = particle if lower else other
                b[pair] = other if lower else particle
                theirs = old_row_of_new[other] if mapped else other
                begin = own_first
                end = own_last
                if theirs < own and theirs // old_chunk == own_part:
                    begin = old_row[theirs]
                    end = old_row[theirs + 1]
                both = own ^ theirs
                known = -1
                # mostly the lists are alike: the pair behind the last one found is the next
                if (
                    expected < own_last
                    and end == own_last
                    and np.int64(old_a[expected]) ^ np.int64(old_b[expected]) == both
                ):
                    known = expected
                else:
                    for k in range(begin, end):
                        if np.int64(old_a[k]) ^ np.int64(old_b[k]) == both:
                            known = k
                            break
                if known >= 0:
                    if end == own_last:
                        expected = known + 1
                    bond[pair] = old_bond[known]
                    touching[pair] = old_touching[known]
                    for k in range(HISTORY):
                        history[pair, k] = old_history[known, k]
                else:
                    bond[pair] = 0
                    touching[pair] = 0
                    for k in range(HISTORY):
                        history[pair, k] = 0.0


@cache
def _writer(history_width: int) -> ModuleType:
    return _jit.compile_kernel([write], {"HISTORY": history_width}, parallel=True)


@cache
def _kernel(dimension: int) -> ModuleType:
    functions: list[Callable[..., Any]] = [
        fold, steps_between, spot_reach, cells_of_particles, sort_by_cell, gather_spots, sum_up,
        find, find_strays, list_strays,
    ]  # fmt: skip
    constants = {
        "DIMENSION": dimension,
        "RADIUS": RADIUS_COLUMN[dimension],
        "FAR": FAR,
        "BLOCK": BLOCK,
        "MARGIN": MARGIN,
        "FEW": FEW,
    }
    return _jit.compile_kernel(functions, constants, parallel=True)


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
    order = np.empty(len(rows), dtype=np.int32)
    spot = np.empty((len(rows), dimension + 1))
    kernel.cells_of_particles(
        rows, levels.origin, levels.bound, levels.inverse, levels.shape, levels.offset, cell
    )
    kernel.sort_by_cell(cell, start, order)
    kernel.gather_spots(rows, half_buffer, order, spot)
    return _Grid(levels, start, order, spot)


def _strays(
    rows: Floats,
    kernel: ModuleType,
    old: PairList,
    buffer: float,
    chunk: int,
    new_row_of_old: Integers | None,
) -> tuple[Integers, NDArray[np.int32]]:
    """CSR of far rows to be listed under every row; empty where there are none."""
    none = np.empty(0, dtype=np.int32)
    if old.pairs == 0:
        return none.astype(np.int64), none
    stray = np.empty((old.pairs, 2), dtype=np.int32)
    count = np.empty(len(old.start) - 1, dtype=np.int64)
    mapped = new_row_of_old is not None
    kernel.find_strays(
        rows, buffer, old.chunk, old.row, old.a, old.b, old.bond, old.touching,
        mapped, none.astype(np.int64) if new_row_of_old is None else new_row_of_old, stray, count,
    )  # fmt: skip
    strays = int(count.sum())
    if strays == 0:
        return none.astype(np.int64), none
    stray_row = np.zeros(len(rows) + 2, dtype=np.int64)
    listed = np.empty(2 * strays, dtype=np.int32)
    kernel.list_strays(old.chunk, old.row, stray, count, chunk, stray_row, listed)
    return stray_row, listed


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
        The two permutations, where the rows were re-sorted since.
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

    Returns
    -------
    PairList
        New arrays; the old list is left as it is.
    """
    particles = len(rows)
    if old is None:
        old = PairList.empty(particles, chunk=chunk, history_width=history_width)
    if particles == 0:
        return PairList.empty(0, chunk=chunk, history_width=history_width)
    mapped = old_row_of_new is not None
    if old_row_of_new is None or new_row_of_old is None:
        old_row_of_new = new_row_of_old = np.empty(0, dtype=np.int64)

    kernel = _kernel(dimension)
    column = RADIUS_COLUMN[dimension]
    levels = plan_levels(
        rows, dimension=dimension, radius_column=column, buffer=buffer, multilevel=multilevel
    )
    grid = _fill_grid(rows, kernel, levels, 0.5 * buffer, dimension)
    stray_row, stray = _strays(rows, kernel, old, buffer, chunk, new_row_of_old if mapped else None)

    parts = chunks_of(particles, chunk)
    row = np.zeros(particles + 1, dtype=np.int64)
    failed = np.zeros(parts, dtype=np.uint8)
    capacity = chunk * max(ROOM_PER_PARTICLE[dimension], 2 * old.pairs // particles)
    while True:
        near = np.empty(parts * capacity + 1, dtype=np.int32)
        kernel.find(
            rows, 0.5 * buffer, chunk, capacity,
            levels.origin, levels.reach, levels.inverse, levels.shape, levels.offset,
            grid.start, grid.order, grid.spot, stray_row, stray, near, row, failed,
        )  # fmt: skip
        if not failed.any():
            break
        capacity *= 2
    kernel.sum_up(row)

    new = PairList.allocate(row, chunk=chunk, history_width=history_width)
    _writer(history_width).write(
        chunk, capacity, near, ids, row, new.a, new.b, new.bond, new.touching, new.history,
        old.chunk, old.row, old.a, old.b, old.bond, old.touching, old.history, mapped, old_row_of_new,
    )  # fmt: skip
    return new


def bond_pairs(
    rows: Floats,
    ids: NDArray[np.int64] | NDArray[np.int32],
    bonds: NDArray[np.int64] | NDArray[np.int32],
    histories: Floats,
    *,
    offset: int,
    chunk: int,
    buffer: float,
    dimension: int,
    history_width: int,
    multilevel: bool = True,
) -> PairList:
    """Make the first list: all near pairs, and every bond however long it is.

    Parameters
    ----------
    rows, ids, chunk, buffer, dimension, history_width, multilevel
        As of `rebuild`.
    bonds : (b, 2)
        Particle ids of every bond; bond k gets the number k + 1.
    histories : (b, Hb)
        What each bond remembers at first.
    offset : int
        First column of the bonds' own history in that of the pairs.

    Raises
    ------
    InputError
        Where a bond joins a particle to itself, or two bonds join the same particles.
    """
    first = _bond_list(rows, ids, bonds, histories, offset=offset, chunk=chunk, history_width=history_width)
    return rebuild(
        rows, ids, first,
        chunk=chunk, buffer=buffer, dimension=dimension, history_width=history_width, multilevel=multilevel,
    )  # fmt: skip


def _bond_list(
    rows: Floats,
    ids: NDArray[np.int64] | NDArray[np.int32],
    bonds: NDArray[np.int64] | NDArray[np.int32],
    histories: Floats,
    *,
    offset: int,
    chunk: int,
    history_width: int,
) -> PairList:
    """A list of nothing but the bonds."""
    row_of = np.empty(len(rows), dtype=np.int64)
    row_of[ids] = np.arange(len(rows))
    ordered = np.sort(np.asarray(bonds, dtype=np.int64).reshape(-1, 2), axis=1)
    _check_bonds(ordered)
    a = row_of[ordered[:, 0]]
    b = row_of[ordered[:, 1]]
    across = a // chunk != b // chunk
    bond = np.concatenate([np.arange(len(a)), np.flatnonzero(across)])
    under = np.concatenate([np.minimum(a, b), np.maximum(a, b)[across]])
    order = np.lexsort((bond, under))
    bond = bond[order]
    row = np.concatenate([[0], np.cumsum(np.bincount(under, minlength=len(rows)))])
    pairs = PairList.allocate(row, chunk=chunk, history_width=history_width)
    pairs.a[:] = a[bond]
    pairs.b[:] = b[bond]
    pairs.bond[:] = bond + 1
    pairs.touching[:] = 0
    pairs.history[:] = 0.0
    pairs.history[:, offset : offset + histories.shape[1]] = histories[bond]
    return pairs


def _check_bonds(ordered: Integers) -> None:
    itself = np.flatnonzero(ordered[:, 0] == ordered[:, 1])
    if len(itself):
        raise InputError(
            f"bonds[{itself[0]}]", "a bond joins a particle to itself", "Name two particles",
            value=ordered[itself[0]].tolist(),
        )  # fmt: skip
    unique, count = np.unique(ordered, axis=0, return_counts=True)
    if len(unique) < len(ordered):
        pair = unique[np.argmax(count > 1)]
        number = int(np.flatnonzero((ordered == pair).all(axis=1))[1])
        raise InputError(
            f"bonds[{number}]", "a second bond joins the same two particles", "Leave one of them out",
            value=pair.tolist(),
        )  # fmt: skip
