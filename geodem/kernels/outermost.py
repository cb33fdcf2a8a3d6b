"""Which particle lies outermost along each of many parallel rays: a depth buffer from two sides.

Rays go along one axis, through the middles of the cells of a grid across it. A cell's ray is given to the particle
whose surface it meets first, the earlier one where two lie equally far.
"""

from __future__ import annotations

import math
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .._jit import compile_kernel

Floats = NDArray[np.float64]


def meet_lines(along, across, radii, low, spacing, front, owner):
    """Rays of discs, one row of cells: front, owner (2, m), seen from below and from above."""
    count = front.shape[1]
    for i in range(len(along)):
        r = radii[i]
        begin = max(math.ceil((across[i, 0] - r - low[0]) / spacing - 0.5), 0)
        end = min(math.floor((across[i, 0] + r - low[0]) / spacing - 0.5), count - 1)
        for j in range(begin, end + 1):
            away = low[0] + (j + 0.5) * spacing - across[i, 0]
            reach = r * r - away * away
            if reach > 0.0:
                half = math.sqrt(reach)
                if along[i] - half < front[0, j]:
                    front[0, j] = along[i] - half
                    owner[0, j] = i
                if -along[i] - half < front[1, j]:
                    front[1, j] = -along[i] - half
                    owner[1, j] = i


def meet_grid(along, across, radii, low, spacing, front, owner):
    """Rays of spheres: front, owner (2, m, k), seen from below and from above."""
    for i in range(len(along)):
        r = radii[i]
        first = max(math.ceil((across[i, 0] - r - low[0]) / spacing - 0.5), 0)
        last = min(math.floor((across[i, 0] + r - low[0]) / spacing - 0.5), front.shape[1] - 1)
        begin = max(math.ceil((across[i, 1] - r - low[1]) / spacing - 0.5), 0)
        end = min(math.floor((across[i, 1] + r - low[1]) / spacing - 0.5), front.shape[2] - 1)
        for j in range(first, last + 1):
            aside = low[0] + (j + 0.5) * spacing - across[i, 0]
            for k in range(begin, end + 1):
                away = low[1] + (k + 0.5) * spacing - across[i, 1]
                reach = r * r - aside * aside - away * away
                if reach > 0.0:
                    half = math.sqrt(reach)
                    if along[i] - half < front[0, j, k]:
                        front[0, j, k] = along[i] - half
                        owner[0, j, k] = i
                    if -along[i] - half < front[1, j, k]:
                        front[1, j, k] = -along[i] - half
                        owner[1, j, k] = i


@cache
def _kernel() -> ModuleType:
    return compile_kernel([meet_lines, meet_grid], {}, parallel=False)


def outermost(
    along: Floats, across: Floats, radii: Floats, low: Floats, spacing: float, cells: tuple[int, ...]
) -> NDArray[np.int64]:
    """Particle that each ray meets first, -1 where it meets none.

    Parameters
    ----------
    along : (n,) [m]
        Coordinates on the axis of the rays.
    across : (n, d - 1) [m]
    radii : (n,) [m]
    low : (d - 1,) [m]
        Corner of the grid.
    spacing : float [m]
    cells : tuple of d - 1 int

    Returns
    -------
    (2, *cells) int64
        From the low side, from the high side.
    """
    front = np.full((2, *cells), math.inf)
    owner = np.full((2, *cells), -1, dtype=np.int64)
    meet = _kernel().meet_lines if len(cells) == 1 else _kernel().meet_grid
    meet(along, np.ascontiguousarray(across), radii, low, spacing, front, owner)
    return owner
