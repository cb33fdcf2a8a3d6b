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
LANES = 16
GROUP = 8
SPREAD = 2.5

RADIUS_COLUMN = {2: 2, 3: 3}
"""Column of the radius in the rows of the state, by dimension."""
ROOM_PER_PARTICLE = {2: 8, 3: 16}
"""Pairs per particle that a first search has room for; more where the old list had more."""


def find(
    rows, half_buffer, chunk, capacity, origin, reach, inverse, shape, offset, start, order, spot,
    stray_row, stray, near, count, failed,
):  # fmt: skip
    """Near rows of every row, ascending.

    Rows that follow each other lie side by side, so a few of them share one walk through the cells.

    The grid: origin, reach, inverse, shape, offset (`geodem.neighbors.cells.Levels`), start, order, spot.
    stray_row, stray: CSR of far rows to be listed all the same; no entries where stray_row is empty.
    Overwritten: near (chunks, capacity) int32; count (n + 1,), of row i at i + 1; failed (chunks,) uint8: 1 where
    the capacity was too small.
    """
    particles = len(rows)
    finest = reach[len(reach) - 1]
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        end = min(particles, first + chunk)
        place = 0
        full = False
        index = np.empty(512, np.int32)
        place_of = np.empty((DIMENSION + 1, 512 + LANES))
        row_of = np.empty(512 + LANES, np.int32)
        hit = np.empty(512 + LANES, np.uint8)
        listed = np.empty(512 + 2 * LANES, np.int32)
        begin = first
        while begin < end:
            # a group: rows in a small box, of such sizes that one search radius serves all
            x_low = rows[begin, 0]
            y_low = rows[begin, 1]
            z_low = rows[begin, 2] if DIMENSION == 3 else 0.0
            x_high, y_high, z_high = x_low, y_low, z_low
            small = spot_reach(rows[begin, RADIUS], half_buffer)
            large = small
            stop = begin + 1
            while stop < min(end, begin + GROUP):
                x = rows[stop, 0]
                y = rows[stop, 1]
                own = spot_reach(rows[stop, RADIUS], half_buffer)
                least = min(small, own)
                most = max(large, own)
                x_least = min(x_low, x)
                x_most = max(x_high, x)
                y_least = min(y_low, y)
                y_most = max(y_high, y)
                spread = max(x_most - x_least, y_most - y_least)
                if DIMENSION == 3:
                    z = rows[stop, 2]
                    z_least = min(z_low, z)
                    z_most = max(z_high, z)
                    spread = max(spread, z_most - z_least)
                if not (spread < SPREAD * (least + finest) and most + finest < 1.5 * (least + finest)):
                    break
                small, large = least, most
                x_low, x_high, y_low, y_high = x_least, x_most, y_least, y_most
                if DIMENSION == 3:
                    z_low, z_high = z_least, z_most
                stop += 1
            while True:
                found = gather(
                    x_low - origin[0], x_high - origin[0], y_low - origin[1], y_high - origin[1],
                    z_low - origin[2], z_high - origin[2], large, reach, inverse, shape, offset, start, index,
                )  # fmt: skip
                if found <= len(index):
                    break
                index = np.empty(2 * found, np.int32)
                place_of = np.empty((DIMENSION + 1, 2 * found + LANES))
                row_of = np.empty(2 * found + LANES, np.int32)
                hit = np.empty(2 * found + LANES, np.uint8)
                listed = np.empty(2 * found + 2 * LANES, np.int32)
            blocks = copy_spots(spot, order, index, found, place_of, row_of)
            for particle in range(begin, stop):
                pairs = pick(
                    rows[particle, 0], rows[particle, 1], rows[particle, DIMENSION - 1],
                    spot_reach(rows[particle, RADIUS], half_buffer), particle, first,
                    place_of, row_of, blocks, hit, listed,
                )  # fmt: skip
                if len(stray_row) > 0:
                    strays = stray[stray_row[particle] : stray_row[particle + 1]]
                    if pairs + len(strays) + 8 > len(listed):
                        longer = np.empty(2 * (pairs + len(strays)) + 8, np.int32)
                        longer[:pairs] = listed[:pairs]
                        listed = longer
                    pairs = add_missing(listed, pairs, strays)
                sort_rows(listed, pairs)
                count[particle + 1] = pairs
                if place + pairs > capacity:
                    full = True
                else:
                    for k in range(pairs):
                        near[part, place + k] = listed[k]
                    place += pairs
            begin = stop
        failed[part] = full


def gather(
    x_low, x_high, y_low, y_high, z_low, z_high, own, reach, inverse, shape, offset, start, index,
):  # fmt: skip
    """Particles in all cells that a reach of `own` from a box can meet; the box is counted from the grid's origin.

    index (m,) int32: their places in the order of the cells, overwritten. Returns the number found; where it is above
    m, not all were written.
    """
    found = 0
    room = len(index)
    for level in range(len(reach)):
        if start[offset[level]] == start[offset[level + 1]]:
            continue
        radius = (own + reach[level]) * (1.0 + MARGIN)
        columns = shape[level, 0]
        lines = shape[level, 1]
        layers = shape[level, 2]
        low = (x_low - radius) * inverse[level, 0]
        column = fold(low, columns)
        across = steps_between(low, (x_high + radius) * inverse[level, 0], columns)
        low = (y_low - radius) * inverse[level, 1]
        first_line = fold(low, lines)
        high = steps_between(low, (y_high + radius) * inverse[level, 1], lines)
        layer = 0
        deep = 1
        if DIMENSION == 3:
            low = (z_low - radius) * inverse[level, 2]
            layer = fold(low, layers)
            deep = steps_between(low, (z_high + radius) * inverse[level, 2], layers)
        # a run of cells over the end of the torus goes on at its beginning
        rest = column + across - columns
        for _ in range(deep):
            line = first_line
            for _ in range(high):
                base = offset[level] + (layer * lines + line) * columns
                for piece in range(2 if rest > 0 else 1):
                    if piece == 0:
                        begin = np.int64(start[base + column])
                        end = np.int64(start[base + min(column + across, columns)])
                    else:
                        begin = np.int64(start[base])
                        end = np.int64(start[base + rest])
                    if found + end - begin <= room:
                        for k in range(end - begin):
                            index[found + k] = begin + k
                    found += int(end - begin)
                line = line + 1 if line + 1 < lines else 0
            layer = layer + 1 if layer + 1 < layers else 0
    return found


def copy_spots(spot, order, index, found, place_of, row_of):
    """Copy the candidates side by side, and fill the last block of LANES with some that are near to nothing.

    place_of (DIMENSION + 1, m): centres and reaches, row_of (m,), overwritten. Returns the number of blocks.
    """
    blocks = (found + LANES - 1) // LANES
    xs = place_of[0]
    ys = place_of[1]
    zs = place_of[DIMENSION - 1]
    reaches = place_of[DIMENSION]
    for k in range(found):
        source = np.uint32(index[k])
        xs[k] = spot[source, 0]
        ys[k] = spot[source, 1]
        if DIMENSION == 3:
            zs[k] = spot[source, 2]
        reaches[k] = spot[source, DIMENSION]
        row_of[k] = order[source]
    for k in range(found, blocks * LANES):
        xs[k] = np.inf
        ys[k] = 0.0
        zs[k] = 0.0
        reaches[k] = 0.0
        row_of[k] = 0
    return blocks


def pick(x, y, z, own, particle, first, place_of, row_of, blocks, hit, listed):
    """Write the candidates that are near to a particle and that its row shall list; returns how many there are."""
    length = blocks * LANES
    xs = place_of[0, :length]
    ys = place_of[1, :length]
    zs = place_of[DIMENSION - 1, :length]
    reaches = place_of[DIMENSION, :length]
    candidates = row_of[:length]
    hits = hit[:length]
    for k in range(length):
        dx = xs[k] - x
        dy = ys[k] - y
        square = dx * dx + dy * dy
        if DIMENSION == 3:
            dz = zs[k] - z
            square += dz * dz
        both = own + reaches[k]
        other = candidates[k]
        hits[k] = (square < both * both) & ((other > particle) | (other < first))
    # every candidate is written and the next one over it unless it was near: no branch can be guessed wrong
    pairs = np.uint64(0)
    for k in range(length):
        listed[pairs] = candidates[k]
        pairs += np.uint64(hits[k])
    return np.int64(pairs)


def add_missing(listed, pairs, strays):
    """Add the strays that are not among the first `pairs` rows listed; returns how many rows are listed then."""
    near = pairs
    for stray in strays:
        known = False
        for k in range(near):
            known = known or listed[k] == stray
        if not known:
            listed[pairs] = stray
            pairs += 1
    return pairs


def swap(first, second):
    """Two rows, the lower first."""
    return min(first, second), max(first, second)


def sort_rows(listed, pairs):
    """Sort the first `pairs` of `listed`, which has room for eight or more; beyond `pairs` anything may be left."""
    if pairs > FEW:
        listed[:pairs].sort()
        return
    # Batcher's network for eight: no branch that can be guessed wrong
    none = np.int32(2147483647)
    a = listed[0] if pairs > 0 else none
    b = listed[1] if pairs > 1 else none
    c = listed[2] if pairs > 2 else none
    d = listed[3] if pairs > 3 else none
    e = listed[4] if pairs > 4 else none
    f = listed[5] if pairs > 5 else none
    g = listed[6] if pairs > 6 else none
    h = listed[7] if pairs > 7 else none
    a, b = swap(a, b)
    c, d = swap(c, d)
    e, f = swap(e, f)
    g, h = swap(g, h)
    a, c = swap(a, c)
    b, d = swap(b, d)
    e, g = swap(e, g)
    f, h = swap(f, h)
    b, c = swap(b, c)
    f, g = swap(f, g)
    a, e = swap(a, e)
    b, f = swap(b, f)
    c, g = swap(c, g)
    d, h = swap(d, h)
    c, e = swap(c, e)
    d, f = swap(d, f)
    b, c = swap(b, c)
    d, e = swap(d, e)
    f, g = swap(f, g)
    listed[0], listed[1], listed[2], listed[3] = a, b, c, d
    listed[4], listed[5], listed[6], listed[7] = e, f, g, h
    for index in range(8, pairs):
        row = listed[index]
        place = index
        while place > 0 and listed[place - 1] > row:
            listed[place] = listed[place - 1]
            place -= 1
        listed[place] = row


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
    chunk, near, ids, row, a, b, bond, touching, history,
    old_chunk, old_row, old_a, old_b, old_bond, old_touching, old_history, mapped, old_row_of_new,
):  # fmt: skip
    """Pairs of every row, with what the old list knows of them: a, b, bond, touching, history, overwritten."""
    particles = len(row) - 1
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        listed = near[part]
        before = row[first]
        for particle in range(first, min(particles, first + chunk)):
            own = old_row_of_new[particle] if mapped else particle
            own_first = old_row[own]
            own_last = old_row[own + 1]
            own_part = own // old_chunk
            expected = own_first
            for pair in range(row[particle], row[particle + 1]):
                other = np.int64(listed[pair - before])
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
        gather, copy_spots, pick, add_missing, swap, sort_rows, find, find_strays, list_strays,
    ]  # fmt: skip
    constants = {
        "DIMENSION": dimension,
        "RADIUS": RADIUS_COLUMN[dimension],
        "FAR": FAR,
        "BLOCK": BLOCK,
        "MARGIN": MARGIN,
        "FEW": FEW,
        "LANES": LANES,
        "GROUP": GROUP,
        "SPREAD": SPREAD,
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
        near = np.empty((parts, capacity), dtype=np.int32)
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
        chunk, near, ids, row, new.a, new.b, new.bond, new.touching, new.history,
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
