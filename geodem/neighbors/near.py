"""Which particles are near to which: the walk through the cells.

Rows that follow each other lie side by side, so a region of them shares one walk through the cells. What it meets is
copied side by side; from that each small group of rows copies what is near to the group, and each row is compared with
the copies of its group by vector instructions, without branches that can be guessed wrong.
These functions are joined by `geodem.neighbors.search`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .cells import FAR, MARGIN, fold

prange = range

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3
keep_near_box: Any = None  # see geodem.neighbors.lanes
keep_near_point: Any = None
sort_lanes: Any = None
WIDE = 8
LANES = 16

REGION = 64
"""Rows that may share a walk."""
REGION_SPREAD = 8.0
"""Sides of the box around such rows, over the distance at which two of the smallest particles are near; measured."""
GROUP = 12
"""Rows that may share copies of what is near."""
GROUP_SPREAD = 5.0
"""As REGION_SPREAD, for a group."""


def find(
    rows, half_buffer, chunk, origin, reach, inverse, shape, offset, start, order, spot,
    stray_row, stray, near, count, failed,
):  # fmt: skip
    """Near rows of every row, ascending.

    The grid: origin, reach, inverse, shape, offset (`geodem.neighbors.cells.Levels`), start, order, spot.
    stray_row, stray: CSR of far rows to be listed all the same; no entries where stray_row is empty.
    Overwritten: near (chunks, capacity) int32; count (n + 1,), of row i at i + 1; failed (chunks,) uint8: 1 where
    the capacity was too small.
    """
    particles = len(rows)
    for part in prange((particles + chunk - 1) // chunk):
        failed[part] = find_in_chunk(
            part * chunk, min(particles, part * chunk + chunk), rows, half_buffer,
            origin, reach, inverse, shape, offset, start, order, spot, stray_row, stray, near[part], count,
        )  # fmt: skip


def find_in_chunk(
    first, end, rows, half_buffer, origin, reach, inverse, shape, offset, start, order, spot,
    stray_row, stray, near, count,
):  # fmt: skip
    """`find` for the rows from `first` to `end`: near (capacity,) int32; returns whether the capacity was too small."""
    longest = 0
    if len(stray_row) > 0:
        for particle in range(first, end):
            longest = max(longest, stray_row[particle + 1] - stray_row[particle])
    room = 1024
    place = 0
    begin = first
    while begin < end:
        met_spot = np.empty((DIMENSION + 1) * room)
        met_row = np.empty(room, np.int32)
        near_spot = np.empty((DIMENSION + 1) * room)
        near_row = np.empty(room, np.int32)
        listed = np.empty(room + longest, np.int32)
        begin, place, room = find_with_room(
            begin, end, place, rows, half_buffer, origin, reach, inverse, shape, offset, start, order, spot,
            stray_row, stray, near, count, room, met_spot, met_row, near_spot, near_row, listed,
        )  # fmt: skip
    return place < 0


def find_with_room(
    begin, end, place, rows, half_buffer, origin, reach, inverse, shape, offset, start, order, spot,
    stray_row, stray, near, count, room, met_spot, met_row, near_spot, near_row, listed,
):  # fmt: skip
    """`find_in_chunk` for the rows from `begin`, their near rows written from near[place].

    met_spot, met_row, near_spot, near_row, listed: work space for `room` candidates. Returns the row and the place
    where it had to stop, and the room needed to go on; the last row and a negative place where the capacity was too
    small.
    """
    # not in one function with the allocation: an array that may be replaced is counted at every use
    finest = reach[len(reach) - 1]
    while begin < end:
        stop, large, x, x_half, y, y_half, z, z_half = rows_together(
            begin, min(REGION, end - begin), REGION_SPREAD, rows, half_buffer, finest
        )
        met = gather(
            begin, origin, x, x_half, y, y_half, z, z_half, large,
            reach, inverse, shape, offset, start, order, spot, room, met_spot, met_row,
        )  # fmt: skip
        if met < 0:
            return begin, place, 2 * (LANES - met)
        while begin < stop:
            close, large, x, x_half, y, y_half, z, z_half = rows_together(
                begin, min(GROUP, stop - begin), GROUP_SPREAD, rows, half_buffer, finest
            )
            kept = 0
            for source in range(0, met, WIDE):
                kept += keep_near_box(
                    met_spot, room, met_row, source, met, x, x_half, y, y_half, z, z_half, large * (1.0 + MARGIN),
                    begin, near_spot, room, near_row, kept,
                )  # fmt: skip
            for particle in range(np.uint64(begin), np.uint64(close)):
                own = spot_reach(rows[particle, RADIUS], half_buffer)
                pairs = 0
                for source in range(0, kept, LANES):
                    pairs += keep_near_point(
                        near_spot, room, near_row, source, kept,
                        rows[particle, 0], rows[particle, 1], rows[particle, DIMENSION - 1], own,
                        particle, listed, pairs,
                    )  # fmt: skip
                if len(stray_row) > 0:
                    pairs = add_missing(listed, pairs, stray, stray_row[particle], stray_row[particle + 1])
                count[particle + 1] = pairs
                if place + pairs + LANES > len(near):
                    return end, -1, room
                if pairs > LANES:
                    sort_many(listed, pairs, near, place)
                else:
                    sort_lanes(listed, pairs, near, place)
                place += pairs
            begin = close
    return end, place, room


def rows_together(begin, most, widest, rows, half_buffer, finest):
    """How many rows from `begin`, `most` or fewer, lie in a small box and are of such sizes that one reach serves all.

    Returns the row behind the last, the largest reach, and of the box the middle and half the side along each axis.
    """
    first = np.uint64(begin)
    many = np.uint64(most)
    while True:
        x_low = x_high = rows[first, 0]
        y_low = y_high = rows[first, 1]
        z_low = z_high = rows[first, 2] if DIMENSION == 3 else 0.0
        small = large = rows[first, RADIUS]
        for row in range(first, first + many):
            x = rows[row, 0]
            y = rows[row, 1]
            radius = rows[row, RADIUS]
            x_low = x if x < x_low else x_low
            x_high = x if x > x_high else x_high
            y_low = y if y < y_low else y_low
            y_high = y if y > y_high else y_high
            small = radius if radius < small else small
            large = radius if radius > large else large
            if DIMENSION == 3:
                z = rows[row, 2]
                z_low = z if z < z_low else z_low
                z_high = z if z > z_high else z_high
        least = spot_reach(small, half_buffer) + finest
        largest = spot_reach(large, half_buffer)
        spread = max(x_high - x_low, y_high - y_low, z_high - z_low)
        if many == 1 or (spread < widest * least and largest + finest < 1.5 * least):
            break
        many = (many + np.uint64(1)) // np.uint64(2)
    return (
        begin + np.int64(many), largest, 0.5 * (x_low + x_high), 0.5 * (x_high - x_low),
        0.5 * (y_low + y_high), 0.5 * (y_high - y_low), 0.5 * (z_low + z_high), 0.5 * (z_high - z_low),
    )  # fmt: skip


def gather(
    begin, origin, x, x_half, y, y_half, z, z_half, own,
    reach, inverse, shape, offset, start, order, spot, room, met_spot, met_row,
):  # fmt: skip
    """Copy side by side the particles that a reach of `own` from a box, its middle and half its sides, meets.

    Without the rows below `begin`, where the region begins: they list the pair themselves.
    Overwritten: met_spot, coordinates and reaches, axis by axis, each `room` numbers long; met_row (room,). Returns
    the number of copies, or the negative number of candidates where there may not be room for all.
    """
    wide = 1.0 + MARGIN
    candidates = np.int64(0)
    kept = 0
    for level in range(len(reach)):
        if start[offset[level]] == start[offset[level + 1]]:
            continue
        radius = (own + reach[level]) * wide
        columns = shape[level, 0]
        lines = shape[level, 1]
        layers = shape[level, 2]
        low = (x - origin[0] - (x_half + radius)) * inverse[level, 0]
        column = fold(low, columns)
        across = steps_between(low, (x - origin[0] + (x_half + radius)) * inverse[level, 0], columns)
        low = (y - origin[1] - (y_half + radius)) * inverse[level, 1]
        first_line = fold(low, lines)
        high = steps_between(low, (y - origin[1] + (y_half + radius)) * inverse[level, 1], lines)
        layer = np.int64(0)
        deep = 1
        if DIMENSION == 3:
            low = (z - origin[2] - (z_half + radius)) * inverse[level, 2]
            layer = fold(low, layers)
            deep = steps_between(low, (z - origin[2] + (z_half + radius)) * inverse[level, 2], layers)
        # a run of cells over the end of the torus goes on at its beginning
        rest = column + across - columns
        for _ in range(deep):
            line = first_line
            for _ in range(high):
                base = offset[level] + (layer * lines + line) * columns
                for piece in range(2 if rest > 0 else 1):
                    if piece == 0:
                        here = np.int64(start[base + column])
                        there = np.int64(start[base + min(column + across, columns)])
                    else:
                        here = np.int64(start[base])
                        there = np.int64(start[base + rest])
                    candidates += there - here
                    if candidates + WIDE > room:
                        continue
                    for source in range(here, there, WIDE):
                        kept += keep_near_box(
                            spot, len(order), order, source, there, x, x_half, y, y_half, z, z_half, own * wide,
                            begin, met_spot, room, met_row, kept,
                        )  # fmt: skip
                line = line + 1 if line + 1 < lines else 0
            layer = layer + 1 if layer + 1 < layers else np.int64(0)
    return kept if candidates + WIDE <= room else -candidates


def add_missing(listed, pairs, stray, begin, end):
    """Add those of stray[begin:end] that are not among the first `pairs` rows listed; returns how many are then."""
    near = pairs
    for index in range(begin, end):
        known = False
        for k in range(near):
            known = known or listed[k] == stray[index]
        if not known:
            listed[pairs] = stray[index]
            pairs += 1
    return pairs


def sort_many(listed, pairs, near, place):
    """near[place : place + pairs] = the first `pairs` of listed, ascending."""
    listed[:pairs].sort()
    for k in range(pairs):
        near[place + k] = listed[k]


def spot_reach(radius, half_buffer):
    """Reach of a particle."""
    return radius + half_buffer


def steps_between(low, high, size):
    """Number of cells from one place to another, both counted in cells, each cell once."""
    first = low if low > -FAR else -FAR
    first = first if first < FAR else FAR
    last = high if high > -FAR else -FAR
    last = last if last < FAR else FAR
    steps = np.int64(math.floor(last)) - np.int64(math.floor(first)) + 1
    return steps if steps < size else size
