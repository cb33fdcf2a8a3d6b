"""What the new list takes over from the old one: far pairs that are held, bonds, touching and history.

These functions are joined by `geodem.neighbors.search`.
"""

from __future__ import annotations

import numpy as np

prange = range

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3
HISTORY = 0
PERIODIC = True


def find_strays(
    rows, buffer, chunk, row, a, b, bond, touching, mapped, new_row_of_old, vectors, inverse, stray, count,
):  # fmt: skip
    """Old pairs that are intact bonds or touch, and are not nearer than the buffer.

    Each pair once. vectors, inverse: of the cell, where PERIODIC (`geodem.neighbors.images`). Overwritten: stray (p, 2)
    int32, the new rows, where the chunk's pairs begin; count (chunks,).
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
                if mapped:
                    i = new_row_of_old[i]
                    j = new_row_of_old[j]
                square = 0.0
                for axis in range(DIMENSION):
                    step = rows[j, axis] - rows[i, axis]
                    if PERIODIC:
                        for k in range(DIMENSION):
                            share = 0.0
                            for other in range(DIMENSION):
                                share += (rows[j, other] - rows[i, other]) * inverse[other, k]
                            step -= np.floor(share + 0.5) * vectors[k, axis]
                    square += step * step
                both = rows[i, RADIUS] + rows[j, RADIUS] + buffer
                # a little too many are harmless: what `find` finds itself is not listed twice
                if not square < both * both * (1.0 - 1e-9):
                    stray[place, 0] = i
                    stray[place, 1] = j
                    place += 1
        count[part] = place - row[first]


def list_strays(old_chunk, old_row, stray, count, stray_row, listed):
    """Strays under the rows that shall list them: stray_row (n + 2,), listed (strays,) int32, overwritten.

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
    old_row, old_a, old_b, old_bond, old_touching, old_history, mapped, old_row_of_new, lost,
):  # fmt: skip
    """Pairs of every row, with what the old list knows of them: a, b, bond, touching, history, overwritten.

    lost (chunks,) int64, overwritten: its sum is the number of old pairs that must be kept and are not listed.
    """
    particles = len(row) - 1
    for part in prange((particles + chunk - 1) // chunk):
        first = part * chunk
        end = min(particles, first + chunk)
        if mapped:
            lost[part] = look_up(
                first, end, near[part], ids, row, a, b, bond, touching, history,
                old_row, old_a, old_b, old_bond, old_touching, old_history, old_row_of_new,
            )  # fmt: skip
        else:
            lost[part] = merge(
                first, end, near[part], ids, row, a, b, bond, touching, history,
                old_row, old_a, old_b, old_bond, old_touching, old_history,
            )  # fmt: skip


def merge(
    first, end, near, ids, row, a, b, bond, touching, history,
    old_row, old_a, old_b, old_bond, old_touching, old_history,
):  # fmt: skip
    """`write` for the rows from `first` to `end` where both lists are in the same order; returns how many are lost."""
    missing = 0
    before = row[first]
    # rows from `alike` on list what they listed before
    alike = first
    for particle in range(first, end):
        start = row[particle]
        count = row[particle + 1] - start
        old = old_row[particle]
        old_end = old_row[particle + 1]
        if count == old_end - old:
            differ = np.uint32(0)
            at = np.uint64(start - before)
            source = np.uint64(old)
            for k in range(np.uint64(count)):
                differ |= (
                    np.uint32(near[at + k]) ^ old_a[source + k] ^ old_b[source + k] ^ np.uint32(particle)
                )
            if differ == 0:
                continue
        copy_pairs(
            row[alike], old_row[alike], old - old_row[alike], a, b, bond, touching, history,
            old_a, old_b, old_bond, old_touching, old_history,
        )  # fmt: skip
        alike = particle + 1
        for pair in range(start, start + count):
            other = np.int64(near[pair - before])
            theirs = old_other(old, old_end, particle, old_a, old_b)
            while theirs < other:
                missing += int((old_bond[old] > 0) | (old_touching[old] == 1))
                old += 1
                theirs = old_other(old, old_end, particle, old_a, old_b)
            if theirs == other:
                copy_pairs(
                    pair, old, 1, a, b, bond, touching, history,
                    old_a, old_b, old_bond, old_touching, old_history,
                )  # fmt: skip
                old += 1
            else:
                meet(pair, particle, other, ids, a, b, bond, touching, history)
        for k in range(old, old_end):
            missing += int((old_bond[k] > 0) | (old_touching[k] == 1))
    copy_pairs(
        row[alike], old_row[alike], old_row[end] - old_row[alike], a, b, bond, touching, history,
        old_a, old_b, old_bond, old_touching, old_history,
    )  # fmt: skip
    return missing


def old_other(old, end, particle, old_a, old_b):
    """Row that an old pair lists under a particle; beyond the last one, a number above all rows."""
    return np.int64(old_a[old] ^ old_b[old] ^ np.uint32(particle)) if old < end else np.int64(2**62)


def copy_pairs(
    pair, old, count, a, b, bond, touching, history, old_a, old_b, old_bond, old_touching, old_history,
):  # fmt: skip
    """Take over `count` pairs from `old` on as they are."""
    # without a sign, so that no index can count from the end: else nothing is copied by vector instructions
    to = np.uint64(pair)
    source = np.uint64(old)
    for k in range(np.uint64(count)):
        a[to + k] = old_a[source + k]
    for k in range(np.uint64(count)):
        b[to + k] = old_b[source + k]
    for k in range(np.uint64(count)):
        bond[to + k] = old_bond[source + k]
    for k in range(np.uint64(count)):
        touching[to + k] = old_touching[source + k]
    width = np.uint64(HISTORY)
    for k in range(np.uint64(count) * width):
        history[to * width + k] = old_history[source * width + k]


def meet(pair, particle, other, ids, a, b, bond, touching, history):
    """A pair that the old list does not know."""
    lower = ids[particle] < ids[other]
    a[pair] = particle if lower else other
    b[pair] = other if lower else particle
    bond[pair] = 0
    touching[pair] = 0
    for k in range(HISTORY):
        history[pair * HISTORY + k] = 0.0


def look_up(
    first, end, near, ids, row, a, b, bond, touching, history,
    old_row, old_a, old_b, old_bond, old_touching, old_history, old_row_of_new,
):  # fmt: skip
    """As `merge`, where rows were sorted anew. A part that another one lists the pairs of now counts below nought."""
    before = row[first]
    missing = 0
    for particle in range(first, end):
        own = old_row_of_new[particle]
        own_first = old_row[own]
        own_last = old_row[own + 1]
        expected = own_first
        for k in range(own_first, own_last):
            missing += int((old_bond[k] > 0) | (old_touching[k] == 1))
        for pair in range(row[particle], row[particle + 1]):
            other = np.int64(near[pair - before])
            theirs = old_row_of_new[other]
            begin = own_first
            stop = own_last
            if theirs < own:
                begin = old_row[theirs]
                stop = old_row[theirs + 1]
            both = own ^ theirs
            known = -1
            # mostly the lists are alike: the pair behind the last one found is the next
            if (
                expected < own_last
                and stop == own_last
                and np.int64(old_a[expected]) ^ np.int64(old_b[expected]) == both
            ):
                known = expected
            else:
                for k in range(begin, stop):
                    if np.int64(old_a[k]) ^ np.int64(old_b[k]) == both:
                        known = k
                        break
            meet(pair, particle, other, ids, a, b, bond, touching, history)
            if known >= 0:
                if stop == own_last:
                    expected = known + 1
                bond[pair] = old_bond[known]
                touching[pair] = old_touching[known]
                missing -= int((old_bond[known] > 0) | (old_touching[known] == 1))
                for k in range(HISTORY):
                    history[pair * HISTORY + k] = old_history[known * HISTORY + k]
    return missing
