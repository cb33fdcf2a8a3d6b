"""Regular packings of equal discs and spheres of diameter 1, periodic or finite."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.integrators.network import Links, links

Floats = NDArray[np.float64]

# sides of a right-angled cell, and the particles in it as shares of the sides
CELLS: dict[str, tuple[tuple[float, ...], list[tuple[float, ...]]]] = {
    "square": ((1.0, 1.0), [(0.0, 0.0)]),
    "hexagonal": ((1.0, math.sqrt(3.0)), [(0.0, 0.0), (0.5, 0.5)]),
    "SC": ((1.0, 1.0, 1.0), [(0.0, 0.0, 0.0)]),
    "BCC": ((2.0 / math.sqrt(3.0),) * 3, [(0.0, 0.0, 0.0), (0.5, 0.5, 0.5)]),
    "FCC": ((math.sqrt(2.0),) * 3, [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)]),
    "HCP": (
        (1.0, math.sqrt(3.0), math.sqrt(8.0 / 3.0)),
        [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 5.0 / 6.0, 0.5), (0.0, 1.0 / 3.0, 0.5)],
    ),
}
CONTACTS = {"square": 4, "hexagonal": 6, "SC": 6, "BCC": 8, "FCC": 12, "HCP": 12}
"""Of every particle."""


class Packing(NamedTuple):
    """Particles and their touching pairs.

    Attributes
    ----------
    positions : (n, d) [m]
    pairs : (p, 2) int64
    normal : (p, d)
        Unit vector from the first to the second particle, or to its image.
    volume : float
        Of the periodic cell [m3] (2D: m2).
    """

    positions: Floats
    pairs: NDArray[np.int64]
    normal: Floats
    volume: float

    def links(self, kn: float, ks: float) -> Links:
        """All contacts with the same stiffness [N/m]."""
        return links(self.pairs[:, 0], self.pairs[:, 1], self.normal, (0.5, 0.5), kn, ks)


def packing(kind: str, cells: int, *, periodic: bool = True) -> Packing:
    """`cells` cells of a packing along every side."""
    sides, basis = CELLS[kind]
    dimension = len(sides)
    corners = np.array(list(itertools.product(range(cells), repeat=dimension)), dtype=float)
    positions = ((corners[:, None] + np.array(basis)[None]) * np.array(sides)).reshape(-1, dimension)
    box = cells * np.array(sides)
    pairs, normals = [], []
    for image in itertools.product((-1, 0, 1) if periodic else (0,), repeat=dimension):
        branch = positions[None] + np.array(image) * box - positions[:, None]
        first, second = np.nonzero(np.abs((branch**2).sum(axis=2) - 1.0) < 1e-9)
        # of a pair and its reverse, the one whose normal points up
        normal = branch[first, second]
        order = normal @ np.array([1.0, 1e-3, 1e-6])[:dimension]
        pairs.append(np.stack([first, second], axis=1)[order > 0.0])
        normals.append(normal[order > 0.0])
    return Packing(positions, np.concatenate(pairs), np.concatenate(normals), float(box.prod()))
