"""Which particles are near to which: the walk through the cells.

Rows that follow each other lie side by side, so a group of them shares one walk. The particles met are copied side by
side and compared with each row of the group by vector instructions, without branches that can be guessed wrong.
These functions are joined by `geodem.neighbors.search`.
"""

from __future__ import annotations

import math

import numpy as np

from .cells import FAR, MARGIN, fold

prange = range

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3

GROUP = 24
"""Rows that may share a walk."""
SPREAD = 3.5
"""Sides of the box around a group, over the distance at which two of the smallest particles are near; measured."""
LANES = 16
"""Candidates are compared in blocks of this many."""
FEW = 32
"""Up to this many near rows are sorted by a network and insertion."""


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
    # not in the parallel loop itself: numba does not see there that the work space is replaced by a larger one
    finest = reach[len(reach) - 1]
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
        blocks = copy_spots(
            begin, x_low, x_high, y_low, y_high, z_low, z_high, large,
            spot, order, index, found, place_of, row_of,
        )  # fmt: skip
        for particle in range(begin, stop):
            pairs = pick(
                rows[particle, 0], rows[particle, 1], rows[particle, DIMENSION - 1],
                spot_reach(rows[particle, RADIUS], half_buffer), particle,
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
            if place + pairs > len(near):
                full = True
            else:
                for k in range(pairs):
                    near[place + k] = listed[k]
                place += pairs
        begin = stop
    return full


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


def copy_spots(
    begin, x_low, x_high, y_low, y_high, z_low, z_high, own, spot, order, index, found, place_of, row_of,
):  # fmt: skip
    """Copy the candidates that matter side by side, for vector instructions.

    Those that a reach of `own` from the box meets, but no rows below `begin`, where the group begins: they list the
    pair themselves. place_of (DIMENSION + 1, m): centres and reaches, row_of (m,),
    overwritten. The last block of LANES is filled with some that are near to nothing. Returns the number of blocks.
    """
    xs = place_of[0]
    ys = place_of[1]
    zs = place_of[DIMENSION - 1]
    reaches = place_of[DIMENSION]
    wide = 1.0 + MARGIN
    # every candidate is written and the next one over it unless it matters: no branch can be guessed wrong
    kept = np.uint64(0)
    for k in range(found):
        source = np.uint32(index[k])
        x = spot[source, 0]
        y = spot[source, 1]
        dx = max(x_low - x, x - x_high, 0.0)
        dy = max(y_low - y, y - y_high, 0.0)
        square = dx * dx + dy * dy
        xs[kept] = x
        ys[kept] = y
        if DIMENSION == 3:
            z = spot[source, 2]
            dz = max(z_low - z, z - z_high, 0.0)
            square += dz * dz
            zs[kept] = z
        theirs = spot[source, DIMENSION]
        both = (own + theirs) * wide
        reaches[kept] = theirs
        row = order[source]
        row_of[kept] = row
        kept += np.uint64((square < both * both) & (row >= begin))
    found = np.int64(kept)
    blocks = (found + LANES - 1) // LANES
    for k in range(found, blocks * LANES):
        xs[k] = np.inf
        ys[k] = 0.0
        zs[k] = 0.0
        reaches[k] = 0.0
        row_of[k] = 0
    return blocks


def pick(x, y, z, own, particle, place_of, row_of, blocks, hit, listed):
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
        hits[k] = (square < both * both) & (other > particle)
    # written as in `copy_spots`
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
    # Batcher's odd-even merge network for eight: no branch that can be guessed wrong
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
