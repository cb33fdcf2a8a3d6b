"""Point location: the triangle or tetrahedron that holds each of many points, and whether a surface encloses them."""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from geodem.kernels.point_location import crossing_kernel, location_kernel

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

INSIDE = -1e-9
"""Smallest barycentric coordinate of a point that counts as inside: rounding leaves no seam between neighbours."""
STRICTLY_INSIDE = 1e-6
"""Smallest barycentric coordinate of a point that lies in a simplex and not on its boundary."""
WHOLE = 2.0**29
"""Whole numbers over the span of a surface; products of two differences are exact in 64 bits."""
MOST_PER_ITEM = 40.0
"""Entries of the grid per item; a finer grid does not pay."""
MOST_CELLS = 20_000_000


class _Grid:
    """Equal cells over a box, each with a list of the items whose bounding box meets it."""

    def __init__(self, low: Floats, high: Floats, kernel: ModuleType) -> None:
        """`low`, `high` (m, k) [m]: bounding boxes of the items."""
        axes = low.shape[1]
        self.low = low.min(axis=0)
        extent = np.maximum(high.max(axis=0) - self.low, 1e-300)
        cells = min(2.0 * len(low) + 1.0, MOST_CELLS)
        while True:
            side = (float(np.prod(extent)) / cells) ** (1.0 / axes)
            shape = np.maximum(np.ceil(extent / side), 1.0).astype(np.int64)
            shape = np.minimum(shape, 2_000_000_000)
            self.inverse = shape / extent
            first = self._cells(low, shape)
            last = self._cells(high, shape)
            entries = float((last - first + 1).prod(axis=1).sum())
            if entries <= MOST_PER_ITEM * len(low) + 1000.0 or cells < 8.0:
                break
            cells *= 0.5
        self.shape = np.ones(3, dtype=np.int64)
        self.shape[:axes] = shape
        whole_first = np.zeros((len(low), 3), dtype=np.int64)
        whole_last = np.zeros((len(low), 3), dtype=np.int64)
        whole_first[:, :axes], whole_last[:, :axes] = first, last
        self.start = np.zeros(int(self.shape.prod()) + 1, dtype=np.int64)
        kernel.count_members(whole_first, whole_last, self.shape, self.start)
        self.member = np.empty(int(self.start[-1]), dtype=np.int32)
        kernel.list_members(whole_first, whole_last, self.shape, self.start, self.member)

    def _cells(self, points: Floats, shape: NDArray[np.int64]) -> NDArray[np.int64]:
        place = ((points - self.low) * self.inverse).astype(np.int64)
        return np.asarray(np.minimum(np.maximum(place, 0), shape - 1))


class SimplexLocator:
    """Finds the triangles or tetrahedra that hold points.

    Parameters
    ----------
    corners : (m, d + 1, d) float [m]
        None without size.
    """

    def __init__(self, corners: Floats) -> None:
        self.dimension = corners.shape[2]
        self._kernel = location_kernel(self.dimension)
        low, high = corners.min(axis=1), corners.max(axis=1)
        # what counts as inside reaches a little out of the box
        reach = 2.0 * abs(INSIDE) * (high - low).max(axis=1, keepdims=True)
        self._grid = _Grid(low - reach, high + reach, self._kernel)
        self._origin = np.ascontiguousarray(corners[:, 0])
        edges = corners[:, 1:] - corners[:, :1]
        self._map_in = np.ascontiguousarray(np.linalg.inv(np.swapaxes(edges, 1, 2)))

    def locate(self, points: Floats) -> tuple[Integers, Integers]:
        """Number of the simplex that holds each point (n, d) deepest, and of another that holds it too; -1: none.

        The second does not count those that have the point on their boundary.
        """
        given = np.ascontiguousarray(points, dtype=np.float64)
        found = np.empty(len(given), dtype=np.int32)
        second = np.empty(len(given), dtype=np.int32)
        grid = self._grid
        self._kernel.hold_points(
            given, grid.low, grid.inverse, grid.shape, grid.start, grid.member, self._origin, self._map_in,
            INSIDE, STRICTLY_INSIDE, found, second,
        )  # fmt: skip
        return found, second


class SurfaceLocator:
    """Tells which points a closed surface of triangles encloses: those with an odd number of facets above them.

    The surface is looked at from above on a grid of whole numbers, 2e-9 of its span wide, on which it is decided
    exactly over which facet a point lies; one that lies over an edge or a corner is over one facet of those around.

    Parameters
    ----------
    corners : (m, 3, 3) float [m]
        Every edge belongs to an even number of facets.
    """

    def __init__(self, corners: Floats) -> None:
        self._kernel = crossing_kernel()
        self.low, self.high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self._unit = float((self.high - self.low)[:2].max()) / WHOLE or math.ulp(1.0)
        self._corner = self._whole(corners[..., :2])
        self._height = np.ascontiguousarray(corners[..., 2])
        seen = corners[..., :2]
        reach = 2.0 * self._unit
        self._grid = _Grid(seen.min(axis=1) - reach, seen.max(axis=1) + reach, self._kernel)

    def _whole(self, points: Floats) -> NDArray[np.int64]:
        return np.rint((points - self.low[:2]) / self._unit).astype(np.int64)

    def encloses(self, points: Floats) -> NDArray[np.bool_]:
        """Whether each point (n, 3) [m] lies inside; (n,) bool."""
        given = np.asarray(points, dtype=np.float64)
        inside = np.zeros(len(given), dtype=bool)
        near = np.flatnonzero(((given >= self.low) & (given <= self.high)).all(axis=1))
        here = np.ascontiguousarray(given[near])
        crossings = np.empty(len(here), dtype=np.int32)
        grid = self._grid
        self._kernel.count_above(
            here, self._whole(here[:, :2]), grid.low, grid.inverse, grid.shape, grid.start, grid.member,
            self._corner, self._height, crossings,
        )  # fmt: skip
        inside[near] = crossings % 2 == 1
        return inside
