"""When the pair list must be made anew: once a particle has moved half the buffer."""

from __future__ import annotations

import math
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .. import _jit

prange = range

# Set by the module that the kernel is compiled in.
DIMENSION = 3
BLOCK = 2048


def farthest(rows, reference, block_square):
    """Largest squared distance of any row from its reference in every block of rows, overwritten."""
    particles = len(rows)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        largest = 0.0
        for particle in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            square = 0.0
            for axis in range(DIMENSION):
                step = rows[particle, axis] - reference[particle, axis]
                square += step * step
            # written so that nan gets through and stays: a lost particle must be noticed
            largest = largest if square <= largest or largest != largest else square
        block_square[block] = largest


def max_displacement(rows: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Largest distance of any particle from where it was.

    Parameters
    ----------
    rows : (n, W)
        Rows of the state.
    reference : (n, d) [m]
        Positions at the last search, in the same order.

    Returns
    -------
    float
        [m]; 0 without particles.
    """
    if len(rows) == 0:
        return 0.0
    square = np.empty((len(rows) + BLOCK - 1) // BLOCK)
    _kernel(reference.shape[1]).farthest(rows, reference, square)
    return math.sqrt(float(square.max()))


@cache
def _kernel(dimension: int) -> ModuleType:
    return _jit.compile_kernel([farthest], {"DIMENSION": dimension, "BLOCK": BLOCK}, parallel=True)
