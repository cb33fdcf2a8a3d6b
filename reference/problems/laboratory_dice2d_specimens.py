"""Specimens of DICE2D's laboratory (Zhao 2015, sections 2.5 and 3.3), and their links as a network.

Discs have the radius 10 m that the text calls their mean particle size: rows of 20 and 19 of them are the 400 m of its
large specimen, 40 rows its 695.5 m. Bonds are those of two springs, every one of the same stiffness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.builders.close_pairs import close_pairs
from geodem.builders.packings import lattice
from geodem.builders.random_packing import random_packing
from geodem.integrators.network import Network, build_network, pair_links
from geodem.laws.bond.two_springs import stiffness

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]

RADIUS = 10.0  # [m]
STIFFNESS = 1e8  # kn, tables 2.6, 2.7 and 3.7 [N/m]
DENSITY = 1000.0  # [kg/m3]
HEIGHT = math.sqrt(3.0) * RADIUS
"""Of a row of the triangular packing [m]."""
SIZE_RATIO = 1.66
"""Largest over smallest radius of irregular packings, which the text does not give."""


@dataclass(frozen=True)
class Bonded:
    """Discs and the pairs of them that are bonded.

    Attributes
    ----------
    positions : (n, 2) [m]
        Inside a box from the origin.
    radii : (n,) [m]
    pairs : (b, 2) int64
    box : (2,) [m]
    """

    positions: Floats
    radii: Floats
    pairs: Pairs
    box: Floats

    @property
    def coordination(self) -> float:
        """Mean number of bonds of a disc [-]."""
        return 2.0 * len(self.pairs) / len(self.radii)

    def ends(self, axis: int = 1) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Discs (n,) within 1.2 of their radii of the low and of the high end of an axis."""
        along, reach = self.positions[:, axis], 1.2 * self.radii
        return along < reach, along > self.box[axis] - reach

    def network(self, ratio: float, width_ratio: float = 0.1) -> Network:
        """Its links, with ks/kn and WRT."""
        smaller = self.radii[self.pairs].min(axis=1)
        bending = [stiffness(STIFFNESS, 0.0, width_ratio, r, r)[3] for r in smaller]
        return build_network(
            self.positions,
            pair_links(
                self.positions, self.radii, self.pairs, STIFFNESS, ratio * STIFFNESS, 0.0, np.array(bending)
            ),
        )


def bonded(positions: Floats, radii: Floats, box: Floats, factor: float) -> Bonded:
    """Every pair within `factor` times the sum of its radii is bonded; discs without a bond are left out."""
    pairs, _ = close_pairs(positions, radii, lambda a, b: factor * (a + b), None)
    while True:
        kept = np.bincount(pairs.ravel(), minlength=len(radii)) > 1
        if kept.all():
            return Bonded(positions, radii, pairs, box)
        new = np.cumsum(kept) - 1
        pairs = new[pairs[kept[pairs].all(axis=1)]]
        positions, radii = positions[kept], radii[kept]


def square(wide: int, high: int) -> Bonded:
    """Discs on a square lattice, in columns and rows."""
    found = lattice("square", RADIUS, box=(2.0 * RADIUS * wide, 2.0 * RADIUS * high))
    return bonded(found.positions, found.radii, found.box, 1.01)


def triangular(wide: int, high: int) -> Bonded:
    """Horizontal rows, `high` of them, of `wide` and `wide` - 1 discs in turn."""
    found = lattice("hexagonal", RADIUS, box=(2.0 * RADIUS * wide, 2.0 * RADIUS + HEIGHT * (high - 1)))
    return bonded(found.positions, found.radii, found.box, 1.01)


def irregular(
    width: float, height: float, factor: float, seed: int, *, solid_fraction: float = 0.83
) -> Bonded:
    """A random packing between walls, of mean radius 10 m, bonded within `factor` times the sum of the radii."""
    largest = 2.0 * RADIUS * SIZE_RATIO / (1.0 + SIZE_RATIO)
    found = random_packing(
        2, radius=largest, size_ratio=SIZE_RATIO, box=(width, height), periodic=False, seed=seed,
        solid_fraction=solid_fraction,
    )  # fmt: skip
    return bonded(found.positions, found.radii, found.box, factor)
