"""Search for the primitives near every particle: boxes of the primitives in a grid of cells, then true distances."""

from __future__ import annotations

import numpy as np

from .wall_geometry import GEOMETRY_FUNCTIONS, SAME_POINT, closest_on_wall

prange = range

# What a scene may lack; set by the module that the kernel is compiled in.
SPACE = True
RADIUS = 3


def cell_of(value, origin, cell, cells):
    """Cell along one axis, the nearest one for what lies outside."""
    return min(max(int(np.floor((value - origin) / cell)), 0), cells - 1)


def bin_boxes(low, high, origin, cell, cells, start, entries):
    """Primitives by cell: counted in start (cells + 1,) where `entries` is empty, else written there.

    low, high (q, 3) [m]: boxes of the primitives, an empty one (low > high) for planes.
    """
    filling = len(entries) > 0
    for primitive in range(len(low)):
        if low[primitive, 0] > high[primitive, 0]:
            continue
        for ix in range(
            cell_of(low[primitive, 0], origin[0], cell, cells[0]),
            cell_of(high[primitive, 0], origin[0], cell, cells[0]) + 1,
        ):
            for iy in range(
                cell_of(low[primitive, 1], origin[1], cell, cells[1]),
                cell_of(high[primitive, 1], origin[1], cell, cells[1]) + 1,
            ):
                for iz in range(
                    cell_of(low[primitive, 2], origin[2], cell, cells[2]),
                    cell_of(high[primitive, 2], origin[2], cell, cells[2]) + 1,
                ):
                    number = (ix * cells[1] + iy) * cells[2] + iz
                    if filling:
                        entries[start[number]] = primitive
                        start[number] += 1
                    else:
                        start[number + 1] += 1


def near_particle(
    i,
    now,
    buffer,
    planes,
    low,
    high,
    origin,
    cell,
    cells,
    start,
    entries,
    shape,
    kind,
    body,
    bodies,
    found,
    at,
):
    """Primitives whose gap to particle i is below `buffer` [m]: their number; written to found[at:] where at >= 0."""
    x = now[i, 0]
    y = now[i, 1]
    z = now[i, 2] if SPACE else 0.0
    limit = now[i, RADIUS] + buffer
    near = SAME_POINT * now[i, RADIUS]
    count = 0
    for k in range(len(planes)):
        primitive = planes[k]
        _, _, _, distance, _ = closest_on_wall(x, y, z, near, shape, kind, bodies, primitive, body[primitive])
        if distance < limit:
            if at >= 0:
                found[at + count] = primitive
            count += 1
    if len(entries) == 0:
        return count
    first_x = cell_of(x - limit, origin[0], cell, cells[0])
    first_y = cell_of(y - limit, origin[1], cell, cells[1])
    first_z = cell_of(z - limit, origin[2], cell, cells[2])
    for ix in range(first_x, cell_of(x + limit, origin[0], cell, cells[0]) + 1):
        for iy in range(first_y, cell_of(y + limit, origin[1], cell, cells[1]) + 1):
            for iz in range(first_z, cell_of(z + limit, origin[2], cell, cells[2]) + 1):
                number = (ix * cells[1] + iy) * cells[2] + iz
                for entry in range(start[number], start[number + 1]):
                    primitive = entries[entry]
                    if (
                        low[primitive, 0] > x + limit or high[primitive, 0] < x - limit
                        or low[primitive, 1] > y + limit or high[primitive, 1] < y - limit
                        or low[primitive, 2] > z + limit or high[primitive, 2] < z - limit
                    ):  # fmt: skip
                        continue
                    # a primitive stands in many cells; it is seen in the first that it shares with the particle
                    if (
                        max(first_x, cell_of(low[primitive, 0], origin[0], cell, cells[0])) != ix
                        or max(first_y, cell_of(low[primitive, 1], origin[1], cell, cells[1])) != iy
                        or max(first_z, cell_of(low[primitive, 2], origin[2], cell, cells[2])) != iz
                    ):
                        continue
                    _, _, _, distance, _ = closest_on_wall(
                        x, y, z, near, shape, kind, bodies, primitive, body[primitive]
                    )
                    if distance < limit:
                        if at >= 0:
                            found[at + count] = primitive
                        count += 1
    return count


def count_wall_pairs(
    chunk,
    now,
    buffer,
    planes,
    low,
    high,
    origin,
    cell,
    cells,
    start,
    entries,
    shape,
    kind,
    body,
    bodies,
    counts,
):
    """Number of near primitives of every particle, counts (n,)."""
    particles = len(now)
    unused = np.empty(0, dtype=np.uint32)
    for block in prange((particles + chunk - 1) // chunk):
        for i in range(block * chunk, min(particles, block * chunk + chunk)):
            counts[i] = near_particle(
                i, now, buffer, planes, low, high, origin, cell, cells, start, entries, shape, kind, body, bodies,
                unused, -1,
            )  # fmt: skip


def write_wall_pairs(
    chunk, now, buffer, planes, low, high, origin, cell, cells, start, entries, shape, kind, body, bodies,
    row, particle, primitive, touching, history, normal,
    old_row_of_new, old_row, old_primitive, old_touching, old_history, old_normal,
):  # fmt: skip
    """Write the pairs that were counted, by particle and then by primitive, with what the old list knew of them.

    row (n + 1,): first pair of every particle; old_row_of_new (n,): a particle's row in the old list, -1: none.
    """
    particles = len(now)
    for block in prange((particles + chunk - 1) // chunk):
        for i in range(block * chunk, min(particles, block * chunk + chunk)):
            near_particle(
                i, now, buffer, planes, low, high, origin, cell, cells, start, entries, shape, kind, body, bodies,
                primitive, row[i],
            )  # fmt: skip
            for p in range(row[i], row[i + 1]):
                # cells depend on where particles are; a sorted list does not
                q = p
                mine = primitive[p]
                while q > row[i] and primitive[q - 1] > mine:
                    primitive[q] = primitive[q - 1]
                    q -= 1
                primitive[q] = mine
                particle[p] = i
            old = old_row_of_new[i]
            if old < 0:
                continue
            q = old_row[old]
            for p in range(row[i], row[i + 1]):
                while q < old_row[old + 1] and old_primitive[q] < primitive[p]:
                    q += 1
                if q < old_row[old + 1] and old_primitive[q] == primitive[p]:
                    touching[p] = old_touching[q]
                    for k in range(3):
                        normal[p, k] = old_normal[q, k]
                    for k in range(history.shape[1]):
                        history[p, k] = old_history[q, k]


SEARCH_FUNCTIONS = (
    *GEOMETRY_FUNCTIONS,
    cell_of,
    bin_boxes,
    near_particle,
    count_wall_pairs,
    write_wall_pairs,
)
"""Functions to compile, callees first."""
