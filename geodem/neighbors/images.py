"""The neighbour search in a periodic cell: particles wrapped into it, copies around it, and the image of every pair.

The walk through the grid (`geodem.neighbors.near`) meets wrapped particles and, beyond the faces of the cell, copies of
those that lie near the opposite faces. What it finds is turned back into particles; a pair is listed under its lower
row, once, because the cell is at least twice as thick as a pair is long. Which image a pair means follows from where
its two particles are: the nearest.
"""

from __future__ import annotations

import math
from functools import cache
from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from .pair_list import PairList

prange = range

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3
BLOCK = 2048
FAR = 1e9

FARTHER = 1.0 + 1e-9
"""Copies are made of particles a hair farther from a face than need be, whatever rounding does."""


class Lattice(NamedTuple):
    """A periodic cell as the search reads it, 3 x 3 in 2D too.

    Attributes
    ----------
    vectors : (3, 3) [m]
        Rows: the edges of the cell.
    inverse : (3, 3) [1/m]
        A place times it is the place as shares of the edges; columns of directions without period are 0.
    slope : (3,) [1/m]
        One over the distance of opposite faces; 0 where there is no period.
    """

    vectors: Floats
    inverse: Floats
    slope: Floats


def lattice(vectors: Floats, periodic: tuple[bool, ...]) -> Lattice:
    """The lattice of a cell with the edges `vectors` (d, d) [m], periodic along some of them."""
    d = len(periodic)
    full = np.eye(3)
    full[:d, :d] = vectors
    inverse: Floats = np.asarray(np.linalg.inv(full), dtype=np.float64)
    slope: Floats = np.sqrt((inverse**2).sum(axis=0))
    for axis in range(3):
        if axis >= d or not periodic[axis]:
            inverse[:, axis] = 0.0
            slope[axis] = 0.0
    return Lattice(full, inverse, slope)


class Copies(NamedTuple):
    """Wrapped particles, and copies of them behind.

    Attributes
    ----------
    rows : (n + c, 3 or 4)
        Coordinates and radius [m], in the columns of the state.
    of : (c,) int64
        Particle that each copy is of.
    """

    rows: Floats
    of: Integers


def wrapped(rows: Floats, cell: Lattice, dimension: int) -> Floats:
    """Places (n, d) [m] in the cell, of rows (n, W) whose first columns are places anywhere."""
    places, _, _ = _wrap(rows, cell, 0.0, dimension)
    return places[:, :dimension]


def _wrap(
    rows: Floats, cell: Lattice, buffer: float, dimension: int
) -> tuple[Floats, NDArray[np.int8], Integers]:
    blocks = (len(rows) + BLOCK - 1) // BLOCK
    places = np.empty((len(rows), dimension + 1))
    side = np.empty((len(rows), 3), dtype=np.int8)
    count = np.zeros(blocks, dtype=np.int64)
    radius = 2 if dimension == 2 else 3
    largest = float(rows[:, radius].max(initial=0.0)) if rows.shape[1] > radius else 0.0
    source = rows if rows.shape[1] > radius else np.column_stack([rows, np.zeros(len(rows))])
    _kernel(dimension).wrap(
        source, cell.vectors, cell.inverse, cell.slope, (largest + buffer) * FARTHER, places, side, count
    )
    return places, side, count


def make_copies(rows: Floats, cell: Lattice, *, buffer: float, dimension: int) -> Copies:
    """Particles wrapped into the cell, and copies of all that may be near to one behind an opposite face.

    Parameters
    ----------
    rows : (n, W)
        Coordinates first [m], the radius in column 2 (2D) or 3 (3D).
    cell : Lattice
    buffer : float
        Distance of surfaces below which particles are near [m].
    dimension : int
    """
    places, side, count = _wrap(rows, cell, buffer, dimension)
    start = np.zeros(len(count) + 1, dtype=np.int64)
    np.cumsum(count, out=start[1:])
    found = np.empty((len(rows) + int(start[-1]), dimension + 1))
    of = np.empty(int(start[-1]), dtype=np.int64)
    _kernel(dimension).copy_sides(places, side, cell.vectors, start, found, of)
    return Copies(found, of)


def set_images(rows: Floats, pairs: PairList, cell: Lattice, dimension: int) -> None:
    """Note for every pair of a list which image of b is the nearest to a: pairs.image, overwritten."""
    pairs.image = np.empty((pairs.pairs, dimension), dtype=np.int32)
    _kernel(dimension).find_images(rows, pairs.a, pairs.b, cell.vectors, cell.inverse, pairs.image)


@cache
def _kernel(dimension: int) -> ModuleType:
    constants = {
        "DIMENSION": dimension, "RADIUS": 2 if dimension == 2 else 3, "BLOCK": BLOCK, "FAR": FAR,
    }  # fmt: skip
    return _jit.compile_kernel([wrap, copy_sides, find_images], constants, parallel=True)


def wrap(rows, vectors, inverse, slope, reach, places, side, count):
    """Put particles into the cell and see which faces they are near to.

    reach [m]: of a particle without its radius. Overwritten: places (n, d + 1): wrapped, and the radius; side (n, 3)
    int8: 1 near the low face, whose copy lies beyond the high one, -1 near the high face; count (blocks,): copies.
    """
    particles = len(rows)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        copies = 0
        for i in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            radius = rows[i, RADIUS]
            for axis in range(DIMENSION):
                places[i, axis] = rows[i, axis]
            places[i, DIMENSION] = radius
            many = 1
            for k in range(3):
                side[i, k] = 0
            for k in range(DIMENSION):
                share = 0.0
                for axis in range(DIMENSION):
                    share += rows[i, axis] * inverse[axis, k]
                # a place that is no number stays where it is, and is near to nothing
                whole = np.floor(share) if abs(share) < FAR else 0.0
                if whole != 0.0:
                    for axis in range(DIMENSION):
                        places[i, axis] -= whole * vectors[k, axis]
                share -= whole
                near = (reach + radius) * slope[k]
                if share < near:
                    side[i, k] = 1
                    many *= 2
                elif share > 1.0 - near:
                    side[i, k] = -1
                    many *= 2
            copies += many - 1
        count[block] = copies


def copy_sides(places, side, vectors, start, found, of):
    """Wrapped particles and their copies: found (n + c, d + 1), of (c,), overwritten; start (blocks + 1,)."""
    particles = len(places)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        copy = start[block]
        for i in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            for axis in range(DIMENSION + 1):
                found[i, axis] = places[i, axis]
            for which in range(1, 8):
                # a copy along every set of faces that the particle is near to
                here = True
                for k in range(3):
                    here = here and ((which >> k) & 1 == 0 or side[i, k] != 0)
                if not here:
                    continue
                for axis in range(DIMENSION + 1):
                    found[particles + copy, axis] = places[i, axis]
                for k in range(DIMENSION):
                    if (which >> k) & 1 == 1:
                        for axis in range(DIMENSION):
                            found[particles + copy, axis] += side[i, k] * vectors[k, axis]
                of[copy] = i
                copy += 1


def find_images(rows, pair_a, pair_b, vectors, inverse, image):
    """Images of b that are the nearest to a: image (p, d) int32, overwritten."""
    pairs = len(pair_a)
    for block in prange((pairs + BLOCK - 1) // BLOCK):
        for p in range(np.uint64(block * BLOCK), np.uint64(min(pairs, block * BLOCK + BLOCK))):
            a = np.uint64(pair_a[p])
            b = np.uint64(pair_b[p])
            x = rows[b, 0] - rows[a, 0]
            y = rows[b, 1] - rows[a, 1]
            z = rows[b, 2] - rows[a, 2] if DIMENSION == 3 else 0.0
            for k in range(DIMENSION):
                share = x * inverse[0, k] + y * inverse[1, k]
                if DIMENSION == 3:
                    share += z * inverse[2, k]
                share = share if abs(share) < FAR else 0.0
                image[p, k] = -np.int32(math.floor(share + 0.5))


def fold_copies(chunk, near, count, of):
    """Turn copies that the walk has found back into particles, and drop the pairs that other rows list.

    near (chunks, capacity), count (n + 1,), of row i at i + 1: as `geodem.neighbors.near.find` leaves them, changed; of
    (c,): particle of every copy, which is row n and so on.
    """
    particles = len(count) - 1
    for part in prange((particles + chunk - 1) // chunk):
        listed = near[part]
        source = 0
        target = 0
        for particle in range(part * chunk, min(particles, part * chunk + chunk)):
            begin = target
            found = count[particle + 1]
            # copies come last, as they have the highest rows; most particles are near to none
            if found == 0 or listed[source + found - 1] < particles:
                if source != target:
                    for k in range(found):
                        listed[target + k] = listed[source + k]
                source += found
                target += found
                continue
            for k in range(source, source + found):
                other = np.int64(listed[k])
                if other >= particles:
                    other = of[other - particles]
                    if other <= particle:
                        continue
                place = target
                while place > begin and listed[place - 1] > other:
                    place -= 1
                # a far pair that is to be listed all the same may have been found as well
                if place > begin and listed[place - 1] == other:
                    continue
                for later in range(target, place, -1):
                    listed[later] = listed[later - 1]
                listed[place] = other
                target += 1
            source += found
            count[particle + 1] = target - begin
