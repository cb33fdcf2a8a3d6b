"""Random sequential addition: particles one after the other at places where they overlap none that are there.

Placed particles lie in one grid of cells for each level of sizes, in a list per cell. Where hardly a place is free, the
box is cut into cubes ("voxels") and those that one placed particle alone makes useless are dropped; what is left is cut
further until a particle finds its place or no cube is left, which proves that there is none: Zhang & Torquato (2013),
Phys. Rev. E 88:053312. Places are drawn outside, so that no bit depends on the compiler.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from geodem import _jit

prange = range

# Set by the module that the kernels are compiled in.
DIMENSION = 3
PERIODIC = True

VOXEL_BLOCK = 4096


def separation(a, b, side):
    """Component of the way from a to b, through the nearest face of a periodic box."""
    step = b - a
    if PERIODIC:
        step = step - side if step > 0.5 * side else (step + side if step < -0.5 * side else step)
    return step


def covered(
    point, radius, half, place, size, first_in_cell, next_in_cell, levels, largest, shape, first, box, low, number
):  # fmt: skip
    """Whether one placed particle overlaps every particle of `radius` whose centre is in the cube around `point`.

    half: half the sides of the cube (d,), zeros for the point alone. low, number: room to work (3,).
    """
    for level in range(levels):
        reach = radius + largest[level]
        for axis in range(DIMENSION):
            count = shape[level, axis]
            scale = count / box[axis]
            low[axis] = int(np.floor((point[axis] - reach) * scale))
            high = int(np.floor((point[axis] + reach) * scale))
            if not PERIODIC:
                low[axis] = min(max(low[axis], 0), count - 1)
                high = min(max(high, 0), count - 1)
            number[axis] = min(high - low[axis] + 1, count)
        for nz in range(number[2]):
            z = (low[2] + nz) % shape[level, 2]
            for ny in range(number[1]):
                y = (low[1] + ny) % shape[level, 1]
                for nx in range(number[0]):
                    x = (low[0] + nx) % shape[level, 0]
                    i = first_in_cell[first[level] + (z * shape[level, 1] + y) * shape[level, 0] + x]
                    while i >= 0:
                        square = 0.0
                        for axis in range(DIMENSION):
                            way = abs(separation(point[axis], place[i, axis], box[axis])) + half[axis]
                            square += way * way
                        touch = radius + size[i]
                        if square < touch * touch:
                            return True
                        i = next_in_cell[i]
    return False


def insert(k, place, level, first_in_cell, next_in_cell, shape, first, box):
    """Enter particle k, whose place is known, into the cells of its level."""
    cell = 0
    for axis in range(DIMENSION - 1, -1, -1):
        count = shape[level, axis]
        index = int(np.floor(place[k, axis] / box[axis] * count))
        cell = cell * count + min(max(index, 0), count - 1)
    cell += first[level]
    next_in_cell[k] = first_in_cell[cell]
    first_in_cell[cell] = k


def add(
    drawn, k, tried, most, place, size, level, first_in_cell, next_in_cell, largest, shape, first, box,
):  # fmt: skip
    """Place particles from k on at drawn places (m, d), from 0 to 1 of the box; returns the next k, draws used, tries.

    Ends where a particle has been refused `most` times.
    """
    low = np.zeros(3, dtype=np.int64)
    number = np.ones(3, dtype=np.int64)
    point = np.zeros(3)
    half = np.zeros(3)
    used = 0
    while k < len(size) and used < len(drawn) and tried < most:
        for axis in range(DIMENSION):
            edge = 0.0 if PERIODIC else size[k]
            point[axis] = edge + drawn[used, axis] * (box[axis] - 2.0 * edge)
        used += 1
        if covered(
            point, size[k], half, place, size, first_in_cell, next_in_cell, level[k] + 1, largest, shape, first, box,
            low, number,
        ):  # fmt: skip
            tried += 1
            continue
        for axis in range(DIMENSION):
            place[k, axis] = point[axis]
        insert(k, place, level[k], first_in_cell, next_in_cell, shape, first, box)
        k += 1
        tried = 0
    return k, used, tried


def add_in_voxels(
    drawn, k, last, voxel, origin, side, place, size, level, first_in_cell, next_in_cell, largest, shape, first, box,
):  # fmt: skip
    """Place particles k to `last` at drawn places in voxels (m, d) of `side` (d,), counted from `origin` (d,).

    drawn: (m, 1 + d), the first says which voxel. Returns the next k.
    """
    low = np.zeros(3, dtype=np.int64)
    number = np.ones(3, dtype=np.int64)
    point = np.zeros(3)
    half = np.zeros(3)
    for used in range(len(drawn)):
        if k == last:
            break
        chosen = min(int(drawn[used, 0] * len(voxel)), len(voxel) - 1)
        inside = True
        for axis in range(DIMENSION):
            point[axis] = origin[axis] + (voxel[chosen, axis] + drawn[used, 1 + axis]) * side[axis]
            if not PERIODIC and (point[axis] < size[k] or point[axis] > box[axis] - size[k]):
                inside = False
        if not inside or covered(
            point, size[k], half, place, size, first_in_cell, next_in_cell, level[k] + 1, largest, shape, first, box,
            low, number,
        ):  # fmt: skip
            continue
        for axis in range(DIMENSION):
            place[k, axis] = point[axis]
        insert(k, place, level[k], first_in_cell, next_in_cell, shape, first, box)
        k += 1
    return k


def find_covered(
    voxel, origin, side, radius, levels, place, size, first_in_cell, next_in_cell, largest, shape, first, box, dead,
):  # fmt: skip
    """Note in `dead` (m,) which voxels have no room for a centre of a particle of `radius`."""
    for block in prange((len(voxel) + VOXEL_BLOCK - 1) // VOXEL_BLOCK):
        low = np.zeros(3, dtype=np.int64)
        number = np.ones(3, dtype=np.int64)
        point = np.zeros(3)
        half = np.zeros(3)
        for axis in range(DIMENSION):
            half[axis] = 0.5 * side[axis]
        for v in range(block * VOXEL_BLOCK, min(len(voxel), (block + 1) * VOXEL_BLOCK)):
            for axis in range(DIMENSION):
                point[axis] = origin[axis] + (voxel[v, axis] + 0.5) * side[axis]
            dead[v] = covered(
                point, radius, half, place, size, first_in_cell, next_in_cell, levels, largest, shape, first, box,
                low, number,
            )  # fmt: skip


@cache
def addition_kernel(dimension: int, periodic: bool) -> ModuleType:
    """The compiled functions for one dimension and kind of box."""
    constants = {"DIMENSION": dimension, "PERIODIC": periodic, "VOXEL_BLOCK": VOXEL_BLOCK}
    functions: list[Callable[..., Any]] = [separation, covered, insert, add, add_in_voxels, find_covered]
    return _jit.compile_kernel(functions, constants, parallel=True)
