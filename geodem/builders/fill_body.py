"""Particles for any body: a lattice, or a dense random packing made once on a periodic box, repeated and cut.

A particle belongs to the material at its centre, so at a boundary it reaches out by up to its radius. What the
particles stand for differs from the source by the chance of how their centres fall; the arrangement is moved as a
whole until that is small, and the density of the particles makes up for the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body import OUTSIDE, Body
from geodem.builders.body_filling import BodyFilling, few_remarks
from geodem.builders.interactions import nearest
from geodem.builders.memory import refuse_too_large
from geodem.builders.packings import Packing, lattice, volumes
from geodem.builders.random_packing import Grading, random_packing
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

ARRANGEMENTS = {
    2: ("random", "square", "hexagonal", "pixel"),
    3: ("random", "simple_cubic", "bcc", "fcc", "hcp", "pixel"),
}
PIXEL_LATTICE = {2: "square", 3: "simple_cubic"}
TILE = {2: 3000, 3: 4000}
"""Particles in the periodic box of a random arrangement."""
TOLERANCE = 0.005
"""Of the represented size of every material, relative."""
# positions of the arrangement are tried until all sizes are within this
GOOD = 0.002
# points that are asked for their material at once
CHUNK = 400_000
# particles across a layer below which a remark is made, and particles that are looked at for it
ACROSS = 3.0
SAMPLE = 2000


@runtime_checkable
class Grained(Protocol):
    """A body whose grains or blocks are told apart."""

    def group_at(self, points: Floats) -> Integers:
        """Number of the grain at points (n, d) [m], -1 for none; (n,) int32."""
        ...


@runtime_checkable
class Gridded(Protocol):
    """A body of cells, which can have one particle each."""

    @property
    def spacing(self) -> Floats:
        """Sides of a cell (d,) [m]."""
        ...


def fill_body(
    body: Body,
    *,
    arrangement: str = "random",
    radius: float | None = None,
    particles: int | None = None,
    size_ratio: float = 1.5,
    grading: Grading | None = None,
    solid_fraction: float | None = None,
    seed: int = 1,
    shifts: int = 16,
    tile: int | None = None,
) -> BodyFilling:
    """Fill a body with discs or spheres.

    The same arguments give the same bits on any number of threads.

    Parameters
    ----------
    body : Body
    arrangement : str
        ``"random"``: a dense random packing, periodic, repeated every few tens of particles. 2D lattices:
        ``"square"``, ``"hexagonal"``. 3D: ``"simple_cubic"``, ``"bcc"``, ``"fcc"``, ``"hcp"``. ``"pixel"``: one
        particle in each cell of a body that is made of cells.
    radius : float, optional
        Radius [m], of a random arrangement the largest.
    particles : int, optional
        Instead of `radius`, about how many the whole body gets.
    size_ratio : float
        Of a random arrangement: largest over smallest radius, equally frequent in between.
    grading : sequence of (float, float), optional
        Instead of `radius` and `size_ratio`: sieve curve as in `random_packing`.
    solid_fraction : float, optional
        Of a random arrangement; 0.83 in 2D and 0.62 in 3D where it is left out.
    seed : int
        Of a random arrangement.
    shifts : int
        Positions of the arrangement that are tried at most. The first whose represented sizes are all within
        0.2 % of the source is taken, else the best.
    tile : int, optional
        Particles in the periodic box of a random arrangement; 3000 discs or 4000 spheres where it is left out.

    Raises
    ------
    InputError
        An arrangement or size that cannot be; more particles than memory holds; a material that gets none.
    """
    pattern = _pattern(body, arrangement, radius, particles, size_ratio, grading, solid_fraction, seed, tile)
    mean = float(volumes(pattern.radii, body.dimension).mean()) / pattern.solid_fraction
    expected = float(body.sizes.sum()) / mean
    refuse_too_large(body.dimension, int(expected), place="fill_body")
    fixed = arrangement == "pixel"
    start = 0.5 * np.asarray(pattern.unit)
    best: _Cut | None = None
    for offset in _offsets(pattern.unit, 1 if fixed else _count("shifts", shifts)):
        cut = _cut(body, pattern, start + offset)
        if best is None or cut.worst < best.worst:
            best = cut
        if best.worst <= GOOD:
            break
    assert best is not None
    _refuse_empty(body, best, pattern)
    groups = (
        body.group_at(best.positions)
        if isinstance(body, Grained)
        else np.full(len(best.positions), -1, dtype=np.int32)
    )
    filling = BodyFilling(
        positions=best.positions,
        radii=best.radii,
        material=best.material,
        materials=tuple(body.materials),
        sources=np.array(body.sizes, dtype=np.float64),
        solid_fraction=pattern.solid_fraction,
        arrangement=arrangement,
        group=np.asarray(groups, dtype=np.int32),
    )
    remarks = [*body.remarks, *few_remarks(filling.shares, TOLERANCE), *_thin_remarks(body, filling, mean)]
    return replace(filling, remarks=tuple(remarks))


@dataclass(frozen=True)
class _Pattern:
    """A periodic arrangement: particles in a box, and the smallest box that repeats."""

    positions: Floats
    radii: Floats
    box: Floats
    unit: Floats
    solid_fraction: float


def _pattern(
    body: Body,
    arrangement: str,
    radius: float | None,
    particles: int | None,
    size_ratio: float,
    grading: Grading | None,
    solid_fraction: float | None,
    seed: int,
    tile: int | None,
) -> _Pattern:
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
        particles = _count("particles", particles)
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
    most = TILE[dimension] if tile is None else _count("tile", tile)
    curve, scale = None, radius
    if grading is not None:
        pairs = [(float(a), float(b)) for a, b in grading]
        scale = pairs[-1][0] if pairs else 1.0
        if not scale > 0.0:
            raise InputError("fill_body, grading", "not all radii are positive", "Mend them.", value=grading)
        curve = tuple((a / scale, b) for a, b in pairs)
    packed = periodic_tile(dimension, most, float(size_ratio), curve, solid_fraction, seed)
    if particles is not None:
        mean = float(volumes(packed.radii, dimension).mean())
        scale = float((size / particles * packed.solid_fraction / mean) ** (1.0 / dimension))
    assert scale is not None
    box = packed.box * scale
    return _Pattern(packed.positions * scale, packed.radii * scale, box, box, packed.solid_fraction)


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


def _lattice_pattern(kind: str, radius: float) -> _Pattern:
    dimension = 2 if kind in ARRANGEMENTS[2] else 3
    unit = lattice(kind, radius, cells=(1,) * dimension)
    # a block of cells: what is near in space is near in memory
    block = lattice(kind, radius, cells=(16,) * 2 if dimension == 2 else (6,) * 3)
    centred = block.positions + 0.5 * _free_side(unit)
    return _Pattern(centred, block.radii, block.box, unit.box, unit.solid_fraction)


def _free_side(unit: Packing) -> Floats:
    """Side of the unit cell that no particle's centre stands in, so that half of it is left on either side."""
    return np.asarray(unit.box - unit.positions.max(axis=0))


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


def _count(key: str, value: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InputError(f"fill_body, {key}", "this is not a whole number from 1", "Mend it.", value=value)
    return int(value)


def _offsets(unit: Floats, count: int) -> Floats:
    """Shifts (count, d) [m] of the arrangement, 0 first, the others spread evenly over the repeating box."""
    dimension = len(unit)
    # generalised golden ratio: x^(d+1) = x + 1
    ratio = 1.324717957244746 if dimension == 2 else 1.2207440846057596
    steps = ratio ** -np.arange(1.0, dimension + 1.0)
    return np.asarray((np.arange(count)[:, None] * steps) % 1.0 * unit)


@dataclass(frozen=True)
class _Cut:
    """Particles of the arrangement whose centres lie in the body, and the worst difference in size."""

    positions: Floats
    radii: Floats
    material: Integers
    worst: float


def _cut(body: Body, pattern: _Pattern, offset: Floats) -> _Cut:
    low, high = np.asarray(body.bounds, dtype=np.float64)
    # boxes start at or below the lower corner, wherever the shift puts them
    first = np.floor((-offset - pattern.box) / pattern.box)
    start = low + offset + first * pattern.box
    counts = np.maximum(np.ceil((high - start) / pattern.box), 1).astype(int)
    corners = np.stack(np.meshgrid(*(np.arange(c) for c in counts), indexing="ij"), axis=-1)
    corners = corners.reshape(-1, len(low)) * pattern.box + start
    at_once = max(1, CHUNK // len(pattern.radii))
    positions, radii, material = [], [], []
    for k in range(0, len(corners), at_once):
        points = (corners[k : k + at_once, None, :] + pattern.positions).reshape(-1, len(low))
        size = np.tile(pattern.radii, len(corners[k : k + at_once]))
        near = ((points >= low) & (points <= high)).all(axis=1)
        points, size = points[near], size[near]
        kind = np.asarray(body.material_at(points), dtype=np.int32)
        inside = kind != OUTSIDE
        positions.append(points[inside])
        radii.append(size[inside])
        material.append(kind[inside])
    sizes, kinds = np.concatenate(radii), np.concatenate(material)
    own = np.bincount(kinds, volumes(sizes, len(low)), minlength=len(body.materials))
    worst = np.abs(own / pattern.solid_fraction / np.asarray(body.sizes) - 1.0).max()
    return _Cut(np.concatenate(positions), sizes, kinds, float(worst))


def _refuse_empty(body: Body, cut: _Cut, pattern: _Pattern) -> None:
    count = np.bincount(cut.material, minlength=len(body.materials))
    for name, number, size in zip(body.materials, count, body.sizes, strict=True):
        if number == 0:
            unit = "m2" if body.dimension == 2 else "m3"
            raise InputError(
                "fill_body", f"{name!r}, of {size:.4g} {unit}, gets no particle of radius up to "
                f"{pattern.radii.max():.4g} m", "Take smaller ones, or more of them.",
            )  # fmt: skip


def _thin_remarks(body: Body, filling: BodyFilling, mean: float) -> Sequence[str]:
    """Words on materials that are fewer than three particles thick along an axis.

    Of a layer `t` spacings thick, a share 2 / t of the points has its end within a spacing along the axis across.
    """
    spacing = mean ** (1.0 / body.dimension)
    remarks = []
    for number, name in enumerate(filling.materials):
        mine = np.flatnonzero(filling.material == number)
        mine = mine[:: -(-len(mine) // SAMPLE)]
        centre = filling.positions[mine]
        across = np.inf
        for axis in range(body.dimension):
            step = np.zeros(body.dimension)
            step[axis] = spacing
            ends = sum(float((body.material_at(centre + sign * step) != number).mean()) for sign in (-1, 1))
            across = min(across, 2.0 / ends if ends > 0.0 else np.inf)
        if across < ACROSS:
            remarks.append(
                f"{name} is about {across:.1f} particles across, too few for its own deformation: "
                f"take particles {ACROSS / across:.1f} times smaller."
            )
    return remarks
