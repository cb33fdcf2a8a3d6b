"""Fragments: what unbroken bonds hold together; how many there are, how heavy, how large."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

NO_PIECE = -1
"""Piece of a particle that is not counted."""


@dataclass(frozen=True, eq=False)
class Fragments:
    """Pieces in the order of their mass, the heaviest first; of equal ones that with the lowest particle number.

    Attributes
    ----------
    dimension : int
    piece_of : (n,) int64
        Piece of every particle; -1 of one that is not counted.
    particles : (p,) int64
        Of every piece; 1: a single grain.
    mass : (p,) [kg] (2D: kg per m)
    size : (p,) [m]
        Diameter of the disc or sphere of the same area or volume, pores between its grains included.
    low, high : (p, d) [m]
        Corners of the box around the piece, grains' surfaces included.
    centre : (p, d) [m]
        Of mass.
    """

    dimension: int
    piece_of: Integers
    particles: Integers
    mass: Floats
    size: Floats
    low: Floats
    high: Floats
    centre: Floats

    @property
    def count(self) -> int:
        """Number of pieces, single grains included."""
        return len(self.mass)

    @property
    def single(self) -> Mask:
        """Which pieces (p,) are single grains: crushed to the size of a particle, not a size that rock breaks to."""
        return np.asarray(self.particles == 1)

    @property
    def extent(self) -> Floats:
        """Sides of the boxes (p, d) [m]."""
        return np.asarray(self.high - self.low)

    def passing(self, sizes: ArrayLike, which: Mask | None = None) -> Floats:
        """Share of the mass in pieces of at most these sizes [m], as a sieve curve tells it.

        Parameters
        ----------
        sizes : (k,) [m]
        which : (p,) bool, optional
            Pieces that count; all where it is left out.

        Returns
        -------
        (k,) [-]; 0 where no piece counts.
        """
        size, mass = self._chosen(which)
        order = np.argsort(size, kind="stable")
        below = np.concatenate([[0.0], np.cumsum(mass[order])])
        found = below[np.searchsorted(size[order], np.asarray(sizes, dtype=float), side="right")]
        return np.asarray(found / below[-1] if below[-1] > 0.0 else found)

    def size_passing(self, share: float, which: Mask | None = None) -> float:
        """Size [m] of the smallest piece up to which this share of the mass lies (0.5: d50); nan without pieces.

        Raises
        ------
        InputError
            A share that is not above 0 and at most 1.
        """
        if not 0.0 < share <= 1.0:
            raise InputError(
                "fragments, share", "this is no share", "Give more than 0, at most 1", value=share
            )
        size, mass = self._chosen(which)
        if not len(size):
            return float("nan")
        order = np.argsort(size, kind="stable")
        below = np.cumsum(mass[order])
        # a sum that misses its own last digit must not be beyond the largest piece
        at = np.searchsorted(below, share * below[-1] * (1.0 - 1e-12))
        return float(size[order][min(int(at), len(size) - 1)])

    def _chosen(self, which: Mask | None) -> tuple[Floats, Floats]:
        chosen = np.ones(self.count, dtype=bool) if which is None else which
        return self.size[chosen], self.mass[chosen]


def find_fragments(
    positions: Floats,
    radii: Floats,
    mass: Floats,
    bonds: ArrayLike,
    intact: ArrayLike | None = None,
    *,
    among: Mask | None = None,
    solid_fraction: float = 1.0,
) -> Fragments:
    """Pieces that unbroken bonds hold together; a particle without any is one by itself.

    Of a simulation `s`: ``find_fragments(s.positions, a.radii, a.mass, a.bonds, s.intact())`` with ``a = s.assembly``.
    In a periodic cell positions must not be wrapped; a box around a piece joined to its own image means nothing.

    Parameters
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    mass : (n,) [kg] (2D: kg per m)
    bonds : (b, 2) int
        Particles of every bond.
    intact : (b,) bool, optional
        Which of them hold; all where it is left out.
    among : (n,) bool, optional
        Particles that count, their bonds to others do not; all where it is left out.
    solid_fraction : float
        Of the packing [-]: a piece's area or volume is that of its grains over this; a single grain's is its own.

    Raises
    ------
    InputError
        Shapes that do not fit, particles that do not exist, or a solid fraction that is none.
    """
    positions = np.asarray(positions, dtype=float)
    n, dimension = _refuse(positions, radii, mass, solid_fraction)
    ends = _ends(bonds, intact, n)
    counted = np.ones(n, dtype=bool) if among is None else np.asarray(among, dtype=bool)
    if counted.shape != (n,):
        raise InputError("fragments, among", f"there are {n} particles", "Give a truth value for each")
    ends = ends[counted[ends].all(axis=1)]
    part = _parts(ends, n)
    ids = np.flatnonzero(counted)
    _, first, piece = np.unique(part[ids], return_index=True, return_inverse=True)
    heavy = np.bincount(piece, weights=np.asarray(mass, dtype=float)[ids], minlength=len(first))
    order = np.lexsort((ids[first], -heavy))
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    piece_of = np.full(n, NO_PIECE, dtype=np.int64)
    piece_of[ids] = rank[piece]
    return _measured(positions, np.asarray(radii, dtype=float), np.asarray(mass, dtype=float), piece_of,
                     len(order), dimension, solid_fraction)  # fmt: skip


def _refuse(positions: Floats, radii: Floats, mass: Floats, solid_fraction: float) -> tuple[int, int]:
    n = len(positions)
    if positions.ndim != 2 or positions.shape[1] not in (2, 3):
        raise InputError(
            "fragments, positions", f"an array of shape {positions.shape} is none", "Give (n, 2) or (n, 3)"
        )
    if np.shape(radii) != (n,) or np.shape(mass) != (n,):
        raise InputError(
            "fragments", f"there are {n} positions, {np.size(radii)} radii and {np.size(mass)} masses",
            "Give one radius and one mass a particle",
        )  # fmt: skip
    if not 0.0 < solid_fraction <= 1.0:
        raise InputError(
            "fragments, solid_fraction", "this is no share of solids", "Give more than 0, at most 1",
            value=solid_fraction,
        )  # fmt: skip
    return n, int(positions.shape[1])


def _ends(bonds: ArrayLike, intact: ArrayLike | None, particles: int) -> Integers:
    """Particles (k, 2) of the bonds that hold."""
    ends = np.asarray(bonds, dtype=np.int64).reshape(-1, 2)
    if len(ends) and not (ends.min() >= 0 and ends.max() < particles):
        raise InputError(
            "fragments, bonds", f"there are particles 0 to {particles - 1}", "Give numbers of particles"
        )
    if intact is None:
        return ends
    holds = np.asarray(intact, dtype=bool)
    if holds.shape != (len(ends),):
        raise InputError(
            "fragments, intact", f"there are {len(ends)} bonds", "Give a truth value for each of them"
        )
    return ends[holds]


def _parts(ends: Integers, particles: int) -> Integers:
    """Number of the connected part (n,) of every particle."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(particles, particles))
    _, part = connected_components(graph.tocsr(), directed=False)
    return np.asarray(part, dtype=np.int64)


def _measured(
    positions: Floats, radii: Floats, mass: Floats, piece_of: Integers, pieces: int, dimension: int,
    solid_fraction: float,
) -> Fragments:  # fmt: skip
    ids = np.flatnonzero(piece_of >= 0)
    piece = piece_of[ids]

    def total(values: Floats) -> Floats:
        return np.asarray(np.bincount(piece, weights=values[ids], minlength=pieces))

    particles = np.bincount(piece, minlength=pieces).astype(np.int64)
    solids = total(radii**dimension) / np.where(particles > 1, solid_fraction, 1.0)
    heavy = total(mass)
    low = np.full((pieces, dimension), np.inf)
    high = np.full((pieces, dimension), -np.inf)
    np.minimum.at(low, piece, positions[ids] - radii[ids, None])
    np.maximum.at(high, piece, positions[ids] + radii[ids, None])
    centre = np.stack([total(mass * positions[:, k]) for k in range(dimension)], axis=1)
    # a piece without mass has no centre of mass: the middle of its box
    centre = np.where(
        heavy[:, None] > 0.0, centre / np.where(heavy > 0.0, heavy, 1.0)[:, None], 0.5 * (low + high)
    )
    return Fragments(
        dimension,
        piece_of,
        particles,
        heavy,
        np.asarray(2.0 * solids ** (1.0 / dimension)),
        low,
        high,
        centre,
    )
