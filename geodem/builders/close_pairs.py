"""Pairs of discs or spheres that lie close together, whatever the spread of their sizes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Cell
from geodem.neighbors import lattice, make_copies

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]
Reach = Callable[[Floats, Floats], Floats]

# Radii within one class differ by less than this, so that few of the pairs a class search finds are too far.
CLASS_RATIO = 1.6


def close_pairs(
    positions: Floats, radii: Floats, reach: Reach, cell: Cell | None = None
) -> tuple[Pairs, Floats]:
    """Every pair whose distance is at most `reach` of its two radii.

    Parameters
    ----------
    positions : (n, d) float [m]
    radii : (n,) float [m]
    reach : function of two arrays of radii
        Largest distance [m]; must not fall where a radius grows.
    cell : Cell, optional
        Periodic: distances are those of the nearest images.

    Returns
    -------
    pairs : (p, 2) int64
        The lower number first; in ascending order.
    distance : (p,) float64 [m]
    """
    from scipy.spatial import cKDTree

    if len(positions) < 2:
        return np.empty((0, 2), dtype=np.int64), np.empty(0)
    if cell is not None:
        return _close_images(positions, radii, reach, cell)
    classes = np.floor(np.log(radii / radii.min()) / np.log(CLASS_RATIO)).astype(np.int64)
    groups = [np.flatnonzero(classes == number) for number in np.unique(classes)]
    trees = [cKDTree(positions[group]) for group in groups]
    largest = np.array([radii[group].max() for group in groups])
    found = []
    for i, (tree, group) in enumerate(zip(trees, groups, strict=True)):
        for j in range(i, len(groups)):
            # a hair wider: the tree's own distances may be rounded differently
            limit = float(reach(largest[i : i + 1], largest[j : j + 1])[0]) * (1.0 + 1e-12)
            if limit <= 0.0:
                continue
            if i == j:
                near = tree.query_pairs(limit, output_type="ndarray")
                near = group[near]
            else:
                # only index pairs are wanted; a distance of zero is an entry all the same
                matrix = tree.sparse_distance_matrix(trees[j], limit, output_type="ndarray")
                near = np.column_stack([group[matrix["i"]], groups[j][matrix["j"]]])
            found.append(_within(near.astype(np.int64), positions, radii, reach))
    pairs = np.concatenate(found) if found else np.empty((0, 2), dtype=np.int64)
    pairs.sort(axis=1)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs, distances(positions, pairs)


def _close_images(positions: Floats, radii: Floats, reach: Reach, cell: Cell) -> tuple[Pairs, Floats]:
    """`close_pairs` in a periodic cell, among the particles in it and copies of them around it."""
    largest = radii.max(keepdims=True)
    beyond = max(0.0, float((reach(largest, largest) - 2.0 * largest)[0]))
    rows = np.column_stack([positions, radii])
    copies = make_copies(
        rows, lattice(cell.vectors, cell.periodic), buffer=beyond, dimension=positions.shape[1]
    )
    of = np.concatenate([np.arange(len(radii)), copies.of])
    pairs, _ = close_pairs(np.ascontiguousarray(copies.rows[:, :-1]), copies.rows[:, -1].copy(), reach)
    pairs = np.sort(of[pairs[pairs[:, 0] < len(radii)]], axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return pairs, distances(positions, pairs, cell)


def distances(positions: Floats, pairs: Pairs, cell: Cell | None = None) -> Floats:
    """Distance [m] between the centres of every pair, in a cell that of the nearest images."""
    apart = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    if cell is not None:
        apart = cell.nearest(apart)
    return np.asarray(np.linalg.norm(apart, axis=1))


def _within(pairs: Pairs, positions: Floats, radii: Floats, reach: Reach) -> Pairs:
    limit = reach(radii[pairs[:, 0]], radii[pairs[:, 1]])
    return pairs[distances(positions, pairs) <= limit]
