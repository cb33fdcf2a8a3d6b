"""The order of the rows: along a Hilbert curve, so that particles near in space are near in memory.

A Hilbert curve, unlike a Morton curve, has no jumps: rows that follow each other are neighbours, chunks are compact and
few pairs lie across two of them. Coordinates become a place on the curve by Skilling's algorithm: J. Skilling,
Programming the Hilbert curve, AIP Conference Proceedings 707 (2004), 381-387.
"""

from __future__ import annotations

import math
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from .cells import usual_extent

prange = range

# Set by the module that the kernel is compiled in.
DIMENSION = 3
BLOCK = 4096
RADIX = 2048


def curve_keys(positions, origin, inverse, bits, key):
    """Place of every particle on the curve through 2^bits cells along each axis: key (n,) int64, overwritten."""
    particles = len(positions)
    size = np.int64(1) << bits
    for block in prange((particles + BLOCK - 1) // BLOCK):
        for particle in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            x = clamp((positions[particle, 0] - origin[0]) * inverse, size)
            y = clamp((positions[particle, 1] - origin[1]) * inverse, size)
            z = clamp((positions[particle, 2] - origin[2]) * inverse, size) if DIMENSION == 3 else np.int64(0)
            # undo excess work, from the coarsest octant to the finest (Skilling's first loop)
            octant = size >> 1
            while octant > 1:
                low = octant - 1
                if x & octant:
                    x ^= low
                if y & octant:
                    x ^= low
                else:
                    swap = (x ^ y) & low
                    x ^= swap
                    y ^= swap
                if DIMENSION == 3:
                    if z & octant:
                        x ^= low
                    else:
                        swap = (x ^ z) & low
                        x ^= swap
                        z ^= swap
                octant >>= 1
            # Gray code
            y ^= x
            z ^= y
            last = z if DIMENSION == 3 else y
            flip = np.int64(0)
            octant = size >> 1
            while octant > 1:
                if last & octant:
                    flip ^= octant - 1
                octant >>= 1
            x ^= flip
            y ^= flip
            z ^= flip
            place = np.int64(0)
            for bit in range(bits - 1, -1, -1):
                place = (place << 1) | ((x >> bit) & 1)
                place = (place << 1) | ((y >> bit) & 1)
                if DIMENSION == 3:
                    place = (place << 1) | ((z >> bit) & 1)
            key[particle] = place


def clamp(place, size):
    """Number of the cell, in [0, size); particles beyond the ends, and lost ones, are in the end cells."""
    inside = place if place > 0.0 else 0.0
    inside = inside if inside < size - 1.0 else size - 1.0
    return np.int64(math.floor(inside))


def sort_keys(key, bits, order, key_spare, order_spare):
    """Stable order of keys below 2^bits, by radix; order (n,) int64 is overwritten, key and the spares are used up.

    Returns 1 where the result stands in `order_spare`, else 0.
    """
    particles = len(key)
    for particle in range(particles):
        order[particle] = particle
    start = np.empty(RADIX + 1, np.int64)
    swapped = 0
    shift = 0
    while shift < bits:
        start[:] = 0
        for particle in range(particles):
            start[((key[particle] >> shift) & (RADIX - 1)) + 1] += 1
        for digit in range(RADIX):
            start[digit + 1] += start[digit]
        for particle in range(particles):
            digit = (key[particle] >> shift) & (RADIX - 1)
            key_spare[start[digit]] = key[particle]
            order_spare[start[digit]] = order[particle]
            start[digit] += 1
        key, key_spare = key_spare, key
        order, order_spare = order_spare, order
        swapped = 1 - swapped
        shift += 11
    return swapped


def spatial_order(
    positions: NDArray[np.float64], radii: NDArray[np.float64], cell: float | None = None
) -> NDArray[np.int64]:
    """Permutation that sorts particles along a Hilbert curve of cells; in a cell they keep their order.

    Parameters
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    cell : float, optional
        Side of a cell [m]; None: the mean diameter.

    Returns
    -------
    (n,) int64
        Old row of every new row.
    """
    particles, dimension = positions.shape
    if particles == 0:
        return np.empty(0, dtype=np.int64)
    side = 2.0 * float(radii.mean()) if cell is None else cell
    low, extent = usual_extent(positions)
    most = 31 if dimension == 2 else 20
    bits = min(max(math.ceil(math.log2(float(extent.max()) / side + 1.0)), 1), most)
    kernel = _kernel(dimension)
    key = np.empty(particles, dtype=np.int64)
    order = np.empty(particles, dtype=np.int64)
    # the particles' box in the middle of the curve's
    origin = low - 0.5 * (side * 2**bits - extent)
    kernel.curve_keys(positions, origin, 1.0 / side, bits, key)
    order_spare = np.empty_like(order)
    swapped = kernel.sort_keys(key, bits * dimension, order, np.empty_like(key), order_spare)
    return order_spare if swapped else order


@cache
def _kernel(dimension: int) -> ModuleType:
    constants = {"DIMENSION": dimension, "BLOCK": BLOCK, "RADIX": RADIX}
    return _jit.compile_kernel([clamp, curve_keys, sort_keys], constants, parallel=True)
