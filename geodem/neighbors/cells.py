"""Grids of cells over the particles: one grid for each level of particle size.

A grid is a torus: cells are counted from an origin and folded into a fixed number of cells along each axis.
Neighbouring cells stay neighbours, so no pair is lost however far a particle flies; what is folded onto others is
rejected by its distance. The number of cells is thus bounded by the number of particles, whatever the extent.

The kernels are joined by `geodem.neighbors.search`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

prange = range

Floats = NDArray[np.float64]

# Set by the module that the kernels are compiled in.
DIMENSION = 3
RADIUS = 3
FAR = 1e9
BLOCK = 4096

LEVEL_RATIO = 3.2
"""Largest over smallest radius on one level, about, where there are several; measured."""
ONE_LEVEL_RATIO = {2: 20.0, 3: 4.5}
"""Largest over smallest radius up to which one level holds all particles, by dimension; measured."""
MOST_LEVELS = 16
"""Particles smaller than the finest level's bound share it."""
CELLS_PER_PARTICLE = 4
"""Bound on the number of cells of a level, and of memory: beyond it the grid is folded."""
SPLITS = (4, 3, 2, 1)
"""How often a cell is cut along x, along which neighbouring cells lie side by side in memory; the first that fits."""
SAMPLE = 2048
"""Particles from whose places the size of the grid is chosen."""
MARGIN = 1e-5
"""Widening of a search, so that rounding cannot put a near particle outside the searched cells [-]."""


@dataclass(frozen=True)
class Levels:
    """Shape of the grids, coarsest first.

    Attributes
    ----------
    origin : (3,) [m]
    bound : (levels,) [m]
        Largest radius on every level.
    reach : (levels,) [m]
        Largest radius and half the buffer.
    inverse : (levels, 3) [1/m]
        One over the sides of a cell.
    shape : (levels, 3) int64
        Number of cells along x, y, z.
    offset : (levels + 1,) int64
        First cell of every level.
    """

    origin: Floats
    bound: Floats
    reach: Floats
    inverse: Floats
    shape: NDArray[np.int64]
    offset: NDArray[np.int64]


def plan_levels(
    rows: Floats, *, dimension: int, radius_column: int, buffer: float, multilevel: bool = True
) -> Levels:
    """Choose levels and cells from the largest radius and from a sample of the particles.

    Parameters
    ----------
    rows : (n, W)
        At least one.
    dimension : int
    radius_column : int
    buffer : float
        [m]
    multilevel : bool
        False: one level whatever the sizes.
    """
    sample = rows[:: len(rows) // SAMPLE + 1]
    radii = sample[:, radius_column]
    largest = float(rows[:, radius_column].max())
    smallest = float(radii.min())
    levels = 1
    ratio = largest / smallest
    if multilevel and ratio > ONE_LEVEL_RATIO[dimension]:
        levels = min(max(round(math.log(ratio, LEVEL_RATIO)), 2), MOST_LEVELS)
    # equal steps, so that no level is left with the few smallest particles only
    bound = largest * ratio ** (-np.arange(levels) / levels)
    level = np.searchsorted(-bound, -radii, side="right") - 1
    share = (np.bincount(level, minlength=levels) + 1) / len(sample)

    low, extent = usual_extent(rows[:, :dimension])
    origin = np.zeros(3)
    # half a cell aside: a lattice that begins where the grid does would lie on the edges of the cells
    origin[:dimension] = low - (bound[-1] + 0.5 * buffer)
    inverse = np.ones((levels, 3))
    shape = np.ones((levels, 3), dtype=np.int64)
    for index in range(levels):
        side = 2.0 * bound[index] + buffer
        most = int(CELLS_PER_PARTICLE * min(share[index], 1.0) * len(rows)) + 64
        sides, counts = _cells(extent, side, most)
        inverse[index, :dimension] = 1.0 / sides
        shape[index, :dimension] = counts
    offset = np.concatenate([[0], np.cumsum(shape.prod(axis=1))])
    return Levels(origin, bound, bound + 0.5 * buffer, inverse, shape, offset)


def usual_extent(positions: Floats) -> tuple[Floats, Floats]:
    """Lower corner and size of the box of a sample of the particles, without those that flew away."""
    sample = positions[:: len(positions) // SAMPLE + 1]
    ordered = np.sort(sample[np.isfinite(sample).all(axis=1)], axis=0)
    if len(ordered) == 0:
        return np.zeros(positions.shape[1]), np.zeros(positions.shape[1])
    last = len(ordered) - 1
    cut = last // 50
    inner = ordered[last - cut] - ordered[cut]
    low = np.maximum(ordered[0], ordered[cut] - 0.5 * inner)
    high = np.minimum(ordered[last], ordered[last - cut] + 0.5 * inner)
    return low, high - low


def _cells(extent: Floats, side: float, most: int) -> tuple[Floats, list[int]]:
    """Sides of a cell and the number of cells along each axis, at most about `most` in all."""
    sides = np.full(len(extent), side)
    wanted = np.empty(0)
    for split in SPLITS:
        sides[0] = side / split
        # two empty cells behind the last one keep the far ends of the torus apart
        wanted = np.floor(np.minimum(extent / sides, FAR)) + 3.0
        if wanted.prod() <= most:
            return sides, [int(count) for count in wanted]
    while wanted.prod() > most:
        axis = int(np.argmax(wanted))
        wanted[axis] = max(np.floor(0.7 * wanted[axis]), 1.0)
    counts: list[int] = []
    for count in wanted:
        # without common divisors a line of particles along a diagonal is folded onto all cells
        number = int(count)
        while any(math.gcd(number, other) > 1 for other in counts):
            number -= 1
        counts.append(number)
    return sides, counts


def fold(place, size):
    """Number of the cell, in [0, size), of a place counted in cells from the origin."""
    # a comparison with nan is false: such a particle lies in the first cell, and is near to nothing
    inside = place if place > -FAR else -FAR
    inside = inside if inside < FAR else FAR
    cell = np.int64(math.floor(inside))
    # no division of whole numbers, which a vectorised loop would do for every particle
    cell -= np.int64(math.floor(inside / size)) * size
    # the quotient is rounded
    cell = cell if cell < size else cell - size
    return cell if cell >= 0 else cell + size


def cells_of_particles(rows, origin, bound, inverse, shape, offset, cell):
    """Cell of every particle: cell (n,) int32, overwritten."""
    particles = len(rows)
    levels = len(bound)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        for particle in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            level = 0
            while level + 1 < levels and rows[particle, RADIUS] <= bound[level + 1]:
                level += 1
            place = fold((rows[particle, 1] - origin[1]) * inverse[level, 1], shape[level, 1])
            if DIMENSION == 3:
                layer = fold((rows[particle, 2] - origin[2]) * inverse[level, 2], shape[level, 2])
                place += layer * shape[level, 1]
            column = fold((rows[particle, 0] - origin[0]) * inverse[level, 0], shape[level, 0])
            cell[particle] = offset[level] + place * shape[level, 0] + column


def sort_by_cell(cell, start, order):
    """Particles cell by cell, in the order of their rows: start (cells + 2,) int32 and order (n,) int32, overwritten.

    Particles of cell c are order[start[c] : start[c + 1]].
    """
    # counted two places ahead, so that the filling below leaves the starts where they belong
    for index in range(len(start)):
        start[index] = 0
    for particle in range(len(cell)):
        start[cell[particle] + 2] += 1
    total = 0
    for index in range(2, len(start)):
        total += start[index]
        start[index] = total
    for particle in range(len(cell)):
        index = cell[particle] + 1
        order[start[index]] = particle
        start[index] += 1


def gather_spots(rows, half_buffer, order, spot):
    """Centres and reaches (radius and half the buffer) in the order of the cells.

    Overwritten: spot, axis by axis, each len(order) numbers long, more than there are particles.
    """
    particles = len(rows)
    span = np.uint64(len(order))
    for block in prange((particles + BLOCK - 1) // BLOCK):
        for index in range(np.uint64(block * BLOCK), np.uint64(min(particles, block * BLOCK + BLOCK))):
            particle = np.uint64(order[index])
            for axis in range(DIMENSION):
                spot[np.uint64(axis) * span + index] = rows[particle, axis]
            spot[np.uint64(DIMENSION) * span + index] = rows[particle, RADIUS] + half_buffer
