"""Specimens: particles of a lattice or a random packing in the shape that a test asks for.

A random specimen is cut open from a periodic packing, so that its surface is as dense as its inside: a packing poured
between walls would be weaker there. Its nominal size is that of the periodic cell, and stresses refer to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..builders.packings import lattice
from ..builders.random_packing import random_packing
from ..errors import InputError

Floats = NDArray[np.float64]

PACKINGS = {2: ("random", "triangular", "square"), 3: ("random", "fcc")}
LATTICES = {"triangular": "hexagonal", "square": "square", "fcc": "fcc"}
SHAPES = {2: ("prism", "disc"), 3: ("prism", "cylinder", "disc")}

SIZE_RATIO = 1.66
"""Largest over smallest radius (Potyondy & Cundall 2004, table 1)."""

COARSEST = 8
"""Particles across, below which a specimen is a handful of grains and no test is made."""

COARSE = 30
"""Particles across, below which strengths depend much on how many there are; from 30 to 60 they still fall by 6 %."""

SOLID_FRACTION = {2: 0.83, 3: 0.62}
"""Of random specimens: dense, and not pressed into one another, so that nothing bursts where a bond breaks."""


@dataclass(frozen=True, eq=False)
class Specimen:
    """Particles cut to shape; the axis of loading is the last one.

    Attributes
    ----------
    positions : (n, d) [m]
        From the corner of the box around the specimen.
    radii : (n,) [m]
    size : (d,) [m]
        Of that box; the last is the height.
    shape : str
        Of the cross-section, constant over the height: prism or cylinder; disc: a circle in the plane of the first and
        the last axis, for splitting tests.
    packing : str
    seed : int or None
        Of a random packing.
    """

    positions: Floats
    radii: Floats
    size: Floats
    shape: str
    packing: str
    seed: int | None

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[1])

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.radii)

    @property
    def height(self) -> float:
        """Along the axis of loading [m]."""
        return float(self.size[-1])

    @property
    def width(self) -> float:
        """Across it [m]."""
        return float(self.size[0])

    @property
    def area(self) -> float:
        """Cross-section across the axis [m2]; in 2D per metre of depth."""
        if self.shape == "cylinder":
            return 0.25 * math.pi * self.width**2
        return float(np.prod(self.size[:-1]))

    @property
    def diameter(self) -> float:
        """Mean diameter of the particles [m]."""
        return 2.0 * float(self.radii.mean())

    @property
    def across(self) -> float:
        """Particles across the width [-]."""
        return self.width / self.diameter


def make_specimen(
    dimension: int,
    *,
    width: float = 0.05,
    height: float | None = None,
    across: float = 40.0,
    packing: str = "random",
    shape: str = "prism",
    size_ratio: float = SIZE_RATIO,
    solid_fraction: float | None = None,
    seed: int = 1,
) -> Specimen:
    """A specimen, the same for the same arguments.

    Parameters
    ----------
    dimension : int
        2 or 3.
    width : float
        Of a prism, also in the third direction; the diameter of a cylinder or disc [m].
    height : float, optional
        Twice the width where it is left out; of a disc in 3D its thickness, half the diameter where it is left out [m].
    across : float
        Particles across the width.
    packing : str
        random; in 2D triangular or square, in 3D fcc.
    shape : str
        prism; in 3D cylinder; disc for splitting.
    size_ratio : float
        Largest over smallest radius of a random packing, all in between equally frequent [-].
    solid_fraction : float, optional
        Of a random packing [-].
    seed : int

    Raises
    ------
    InputError
        A packing or shape that there is not in this dimension, a size that is none, or a specimen too coarse.
    """
    if dimension not in (2, 3):
        raise InputError(
            "specimen, dimension", "particles are discs or spheres", "Give 2 or 3", value=dimension
        )
    for name, value, known in (
        ("packing", packing, PACKINGS[dimension]),
        ("shape", shape, SHAPES[dimension]),
    ):
        if value not in known:
            remedy = f"In {dimension}D choose one of: {', '.join(known)}"
            raise InputError(f"specimen, {name}", f"there is none such in {dimension}D", remedy, value=value)
    disc = shape == "disc"
    if height is None:
        height = (width if dimension == 2 else 0.5 * width) if disc else 2.0 * width
    for name, length in (("width", width), ("height", height)):
        if not (math.isfinite(length) and length > 0.0):
            raise InputError(
                f"specimen, {name}", "this is no length", "Give metres, more than 0", value=length
            )
    if not (math.isfinite(across) and across >= COARSEST):
        raise InputError(
            "specimen, across", f"{across:g} particles are no continuum: the specimen is too coarse",
            f"Give at least {COARSEST}, better {COARSE} or more, where strength depends less on it",
            value=across,
        )  # fmt: skip
    size: tuple[float, ...]
    if dimension == 2:
        size = (width, width if disc else height)
    else:
        size = (width, height, width) if disc else (width, width, height)
    mean = 0.5 * width / across
    share = SOLID_FRACTION[dimension] if solid_fraction is None else solid_fraction
    if packing == "random":
        positions, radii = _random(size, mean, size_ratio, share, seed)
    else:
        positions, radii = _regular(packing, size, mean)
        seed = 0
    box = np.array(size)
    positions, radii = _cut(positions, radii, box, shape)
    return Specimen(positions, radii, box, shape, packing, seed if packing == "random" else None)


@lru_cache(maxsize=16)
def _random(
    size: tuple[float, ...], mean: float, ratio: float, share: float, seed: int
) -> tuple[Floats, Floats]:
    largest = 2.0 * mean * ratio / (1.0 + ratio)
    found = random_packing(
        len(size), radius=largest, size_ratio=ratio, box=size, solid_fraction=share, seed=seed
    )
    return found.positions, found.radii


def _regular(packing: str, size: tuple[float, ...], radius: float) -> tuple[Floats, Floats]:
    """A lattice that fills the box, its middle in the middle."""
    found = lattice(LATTICES[packing], radius, box=size)
    middle = 0.5 * (found.positions.min(axis=0) + found.positions.max(axis=0))
    return found.positions - middle + 0.5 * np.array(size), found.radii


def _cut(positions: Floats, radii: Floats, size: Floats, shape: str) -> tuple[Floats, Floats]:
    """Particles whose centres lie in the shape."""
    if shape == "prism":
        return positions, radii
    axes = [0, len(size) - 1] if shape == "disc" else [0, 1]
    away = positions[:, axes] - 0.5 * size[axes]
    # a particle belongs to the disc where most of it does
    inside = np.sqrt((away**2).sum(axis=1)) <= 0.5 * size[0] - 0.25 * float(radii.mean())
    return np.ascontiguousarray(positions[inside]), np.ascontiguousarray(radii[inside])
