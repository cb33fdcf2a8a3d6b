"""Which triangle or tetrahedron holds a point, and whether a point lies inside a closed surface, by cells of a grid.

The cells list what reaches into them, in ascending order. A point is compared with the list of its own cell only, so
no bit depends on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

from .._jit import compile_kernel

prange = range

# Set by the module that the kernels are compiled in.
DIMENSION = 3
BLOCK = 1024


def count_members(first, last, shape, start):
    """Members of each cell, one place ahead: start (cells + 1,) int64, zeros before."""
    for item in range(len(first)):
        for z in range(first[item, 2], last[item, 2] + 1):
            for y in range(first[item, 1], last[item, 1] + 1):
                row = (z * shape[1] + y) * shape[0]
                for x in range(first[item, 0], last[item, 0] + 1):
                    start[row + x + 1] += 1
    for cell in range(1, len(start)):
        start[cell] += start[cell - 1]


def list_members(first, last, shape, start, member):
    """Items in each cell: member[start[c] : start[c + 1]]."""
    filled = start[:-1].copy()
    for item in range(len(first)):
        for z in range(first[item, 2], last[item, 2] + 1):
            for y in range(first[item, 1], last[item, 1] + 1):
                row = (z * shape[1] + y) * shape[0]
                for x in range(first[item, 0], last[item, 0] + 1):
                    member[filled[row + x]] = item
                    filled[row + x] += 1


def cell_of(point, low, inverse, shape, axes):
    """Number of the cell that holds a point, -1 outside of the grid."""
    cell = 0
    for back in range(axes):
        axis = axes - 1 - back
        place = (point[axis] - low[axis]) * inverse[axis]
        # a comparison with what is no number is false
        if not (place >= 0.0 and place <= shape[axis]):
            return -1
        cell = cell * shape[axis] + min(int(place), shape[axis] - 1)
    return cell


def hold_points(points, low, inverse, shape, start, member, origin, map_in, least, strict, found, second):
    """The simplex that holds each point deepest, and another that holds it by more than `strict`.

    Parameters
    ----------
    points : (n, d)
    low, inverse, shape, start, member
        The grid.
    origin : (m, d), map_in : (m, d, d)
        Barycentric coordinates 1 to d of a point p are map_in (p - origin).
    least, strict : float
        Smallest barycentric coordinate that is inside at all, and beyond doubt.
    found, second : (n,) int32
        Overwritten; -1 where there is none.
    """
    for block in prange((len(points) + BLOCK - 1) // BLOCK):
        for p in range(block * BLOCK, min(len(points), (block + 1) * BLOCK)):
            best, other = -1, -1
            depth, depth_of_other = least, strict
            cell = cell_of(points[p], low, inverse, shape, DIMENSION)
            if cell >= 0:
                for index in range(start[cell], start[cell + 1]):
                    item = member[index]
                    smallest = 1.0
                    rest = 1.0
                    for i in range(DIMENSION):
                        share = 0.0
                        for j in range(DIMENSION):
                            share += map_in[item, i, j] * (points[p, j] - origin[item, j])
                        rest -= share
                        smallest = min(smallest, share)
                    smallest = min(smallest, rest)
                    if smallest >= depth and (best < 0 or smallest > depth):
                        if best >= 0 and depth > depth_of_other:
                            other = best
                            depth_of_other = depth
                        best = item
                        depth = smallest
                    elif smallest > depth_of_other:
                        other = item
                        depth_of_other = smallest
            found[p] = best
            second[p] = other


def side(ax, ay, bx, by, px, py):
    """+1 where p lies left of a to b, -1 where right; whole numbers, exact.

    A point on the line is moved by a vanishing step along x and a still smaller one along y (simulation of
    simplicity, Edelsbrunner & Mucke 1990, ACM Transactions on Graphics 9:66), so that every point is on one side.
    0 only where a and b coincide.
    """
    twice = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    if twice != 0:
        return 1 if twice > 0 else -1
    if by != ay:
        return -1 if by > ay else 1
    if bx != ax:
        return 1 if bx > ax else -1
    return 0


def count_above(points, whole, low, inverse, shape, start, member, corner, height, crossings):
    """Number of facets above each point, along z.

    Parameters
    ----------
    points : (n, 3)
    whole : (n, 2) int64
        x and y of the points, on the grid of whole numbers.
    low, inverse, shape, start, member
        The grid of cells over x and y.
    corner : (m, 3, 2) int64, height : (m, 3)
        x and y of the corners on the grid of whole numbers, and their z.
    crossings : (n,) int32
        Overwritten.
    """
    for block in prange((len(points) + BLOCK - 1) // BLOCK):
        for p in range(block * BLOCK, min(len(points), (block + 1) * BLOCK)):
            crossings[p] = 0
            cell = cell_of(points[p], low, inverse, shape, 2)
            if cell < 0:
                continue
            px, py = whole[p, 0], whole[p, 1]
            for index in range(start[cell], start[cell + 1]):
                item = member[index]
                ax, ay = corner[item, 0, 0], corner[item, 0, 1]
                bx, by = corner[item, 1, 0], corner[item, 1, 1]
                cx, cy = corner[item, 2, 0], corner[item, 2, 1]
                first = side(ax, ay, bx, by, px, py)
                if first == 0 or side(bx, by, cx, cy, px, py) != first:
                    continue
                if side(cx, cy, ax, ay, px, py) != first:
                    continue
                of_a = float((bx - px) * (cy - py) - (by - py) * (cx - px))
                of_b = float((cx - px) * (ay - py) - (cy - py) * (ax - px))
                of_c = float((ax - px) * (by - py) - (ay - py) * (bx - px))
                total = of_a + of_b + of_c
                z = (of_a * height[item, 0] + of_b * height[item, 1] + of_c * height[item, 2]) / total
                if z > points[p, 2]:
                    crossings[p] += 1


@cache
def location_kernel(dimension: int) -> ModuleType:
    """The compiled functions for triangles (2) or tetrahedra (3)."""
    functions: list[Callable[..., Any]] = [count_members, list_members, cell_of, hold_points]
    constants = {"DIMENSION": dimension, "BLOCK": BLOCK}
    return compile_kernel(functions, constants, parallel=True)


@cache
def crossing_kernel() -> ModuleType:
    """The compiled functions for closed surfaces."""
    functions: list[Callable[..., Any]] = [count_members, list_members, cell_of, side, count_above]
    return compile_kernel(functions, {"BLOCK": BLOCK}, parallel=True)
