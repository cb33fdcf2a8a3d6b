"""Periodic arrangements that bodies are cut out of: lattices, and random packings that are made once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body import Body
from geodem.builders.interactions import nearest
from geodem.builders.packings import Packing, lattice, volumes
from geodem.builders.random_packing import Grading, random_packing
from geodem.errors import InputError

Floats = NDArray[np.float64]

ARRANGEMENTS = {
    2: ("random", "square", "hexagonal", "pixel"),
    3: ("random", "simple_cubic", "bcc", "fcc", "hcp", "pixel"),
}
PIXEL_LATTICE = {2: "square", 3: "simple_cubic"}
TILE = {2: 3000, 3: 4000}
"""Particles in the periodic box of a random arrangement."""


@runtime_checkable
class Gridded(Protocol):
    """A body of cells, which can have one particle each."""

    @property
    def spacing(self) -> Floats:
        """Sides of a cell (d,) [m]."""
        ...


@dataclass(frozen=True)
class Pattern:
    """A periodic arrangement: particles in a box, and the smallest box that repeats."""

    positions: Floats
    radii: Floats
    box: Floats
    unit: Floats
    solid_fraction: float


def body_pattern(
    body: Body,
    arrangement: str,
    radius: float | None,
    particles: int | None,
    size_ratio: float,
    grading: Grading | None,
    solid_fraction: float | None,
    seed: int,
    tile: int | None,
) -> Pattern:
    """The arrangement that `geodem.builders.fill_body.fill_body` is asked for; arguments and errors as there."""
    dimension = body.dimension
    if arrangement not in ARRANGEMENTS[dimension]:
        raise InputError(
            "fill_body, arrangement", f"there is no such arrangement in {dimension}D",
            nearest(str(arrangement), list(ARRANGEMENTS[dimension])), value=arrangement,
        )  # fmt: skip
    size = float(body.sizes.sum())
    if arrangement == "pixel":
        if radius is not None or particles is not None or grading is not None:
            raise InputError(
                "fill_body", "an arrangement by pixels has the size of the cells", "Leave the radius out."
            )
        return _lattice_pattern(PIXEL_LATTICE[dimension], 0.5 * _cell_side(body))
    given = [radius is not None, particles is not None, grading is not None]
    if sum(given) != 1:
        raise InputError(
            "fill_body", "it takes one of radius, particles and grading", "Give for instance particles=10000."
        )
    if particles is not None:
        particles = whole_number("particles", particles)
    if radius is not None and not (np.isfinite(radius) and radius > 0.0):
        raise InputError("fill_body, radius", "this is not a positive number", "Give metres.", value=radius)
    if arrangement != "random":
        if grading is not None:
            raise InputError("fill_body, grading", "a lattice has equal particles", "Give a radius.")
        if particles is not None:
            share = size / particles * lattice(arrangement, 1.0, cells=(1,) * dimension).solid_fraction
            radius = float((share / volumes(np.array(1.0), dimension)) ** (1.0 / dimension))
        assert radius is not None
        return _lattice_pattern(arrangement, radius)
    most = TILE[dimension] if tile is None else whole_number("tile", tile)
    curve: tuple[tuple[float, float], ...] | None = None
    scale = radius
    if grading is not None:
        curve, scale = _over_largest(grading)
    packed = periodic_tile(dimension, most, float(size_ratio), curve, solid_fraction, seed)
    if particles is not None:
        mean = float(volumes(packed.radii, dimension).mean())
        scale = float((size / particles * packed.solid_fraction / mean) ** (1.0 / dimension))
    assert scale is not None
    box = packed.box * scale
    return Pattern(packed.positions * scale, packed.radii * scale, box, box, packed.solid_fraction)


@lru_cache(maxsize=8)
def periodic_tile(
    dimension: int,
    count: int,
    size_ratio: float,
    grading: tuple[tuple[float, float], ...] | None,
    solid_fraction: float | None,
    seed: int,
) -> Packing:
    """A periodic random packing whose largest radius is 1 m; kept in memory for the next body."""
    return random_packing(
        dimension,
        radius=1.0 if grading is None else None,
        size_ratio=size_ratio,
        grading=grading,
        count=count,
        solid_fraction=solid_fraction,
        seed=seed,
    )


def _lattice_pattern(kind: str, radius: float) -> Pattern:
    dimension = 2 if kind in ARRANGEMENTS[2] else 3
    unit = lattice(kind, radius, cells=(1,) * dimension)
    # a block of cells: what is near in space is near in memory
    block = lattice(kind, radius, cells=(16,) * 2 if dimension == 2 else (6,) * 3)
    centred = block.positions + 0.5 * _free_side(unit)
    return Pattern(centred, block.radii, block.box, unit.box, unit.solid_fraction)


def _free_side(unit: Packing) -> Floats:
    """Side of the unit cell that no particle's centre stands in, so that half of it is left on either side."""
    return np.asarray(unit.box - unit.positions.max(axis=0))


def _over_largest(grading: Grading) -> tuple[tuple[tuple[float, float], ...], float]:
    """A sieve curve with radii over the largest, and the largest [m]."""
    pairs = np.asarray(grading, dtype=np.float64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not pairs[-1, 0] > 0.0:
        raise InputError(
            "fill_body, grading", "these are not pairs of a positive radius and a share",
            "Give for instance [(0.1, 0.0), (0.2, 0.4), (0.5, 1.0)].", value=grading,
        )  # fmt: skip
    largest = float(pairs[-1, 0])
    return tuple((radius / largest, share) for radius, share in pairs.tolist()), largest


def _cell_side(body: Body) -> float:
    if not isinstance(body, Gridded):
        raise InputError(
            "fill_body, arrangement", "the body is not made of pixels or voxels", "Take another arrangement.",
            value="pixel",
        )  # fmt: skip
    sides = np.asarray(body.spacing)
    if not np.allclose(sides, sides[0], rtol=1e-9):
        raise InputError(
            "fill_body, arrangement", "the cells are not square or cubic", "Take another arrangement.",
            value=sides.tolist(),
        )  # fmt: skip
    return float(sides[0])


def whole_number(key: str, value: int) -> int:
    """A whole number from 1, or `InputError`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InputError(f"fill_body, {key}", "this is not a whole number from 1", "Mend it.", value=value)
    return int(value)
