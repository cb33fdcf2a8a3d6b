"""Particles for any body: a lattice, or a dense random packing made once on a periodic box, repeated and cut.

A particle belongs to the material at its centre, so at a boundary it reaches out by up to its radius. What the
particles stand for differs from the source by the chance of how their centres fall; the arrangement is moved as a
whole until that is small, and the density of the particles makes up for the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body import OUTSIDE, Body
from geodem.builders.body_filling import BodyFilling, few_remarks
from geodem.builders.body_pattern import Pattern, body_pattern, whole_number
from geodem.builders.memory import refuse_too_large
from geodem.builders.packings import volumes
from geodem.builders.random_packing import Grading
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

TOLERANCE = 0.005
"""Of the represented size of every material, relative."""
# positions of the arrangement are tried until all sizes are within this
GOOD = 0.002
# particles that all tries together may have, and tries that there are at least
WORK = 2_000_000
FEWEST_TRIES = 8
# points of the repeated arrangement that all tries together may look at
LOOKS = 300_000_000
# looks over particles: in a box that is emptier the ground is scattered
EMPTIEST = 50.0
# of a particle: a body thinner than that is mistaken
THINNEST = 0.1
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
    shifts: int = 64,
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
        Positions of the arrangement that are tried at most, evenly spread; of more than 31,000 particles fewer, down
        to 8. The first whose represented sizes are all within 0.2 % of the source is taken, else the best.
    tile : int, optional
        Particles in the periodic box of a random arrangement; 3000 discs or 4000 spheres where it is left out.

    Raises
    ------
    InputError
        An arrangement or size that cannot be; more particles than memory holds; a material that gets none.
    """
    pattern = body_pattern(
        body, arrangement, radius, particles, size_ratio, grading, solid_fraction, seed, tile
    )
    mean = float(volumes(pattern.radii, body.dimension).mean()) / pattern.solid_fraction
    expected = float(body.sizes.sum()) / mean
    refuse_too_large(body.dimension, int(expected), place="fill_body")
    _refuse_thin(body, mean)
    looks = len(pattern.radii) * float(np.prod(np.ceil(np.ptp(body.bounds, axis=0) / pattern.box) + 1.0))
    _refuse_scattered(body, looks, expected)
    fixed = arrangement == "pixel"
    tries = min(whole_number("shifts", shifts), max(FEWEST_TRIES, WORK // max(1, int(expected))))
    tries = max(1, min(tries, int(LOOKS / looks)))
    best: _Cut | None = None
    for offset in _offsets(pattern.unit, 1 if fixed else tries):
        cut = _cut(body, pattern, offset)
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


def _cut(body: Body, pattern: Pattern, offset: Floats) -> _Cut:
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


def _refuse_thin(body: Body, mean: float) -> None:
    """Raise InputError where a body is far thinner than one of its particles, `mean` [m2, m3] with its voids."""
    sides = np.ptp(body.bounds, axis=0)
    spacing = mean ** (1.0 / body.dimension)
    if sides.min() < THINNEST * spacing:
        shown = " by ".join(f"{side:.4g} m" for side in sides)
        raise InputError(
            "fill_body", f"the ground is {shown}, far thinner than a particle of about {spacing:.4g} m",
            "Check the units of its sides, or take smaller particles, or more of them.",
        )  # fmt: skip


def _refuse_scattered(body: Body, looks: float, expected: float) -> None:
    """Raise InputError where the box around a body is nearly empty, and so large that it cannot be looked through."""
    if looks > max(LOOKS, EMPTIEST * expected):
        sides = np.ptp(body.bounds, axis=0)
        shown = " by ".join(f"{side:.4g} m" for side in sides)
        share = float(body.sizes.sum()) / float(np.prod(sides))
        raise InputError(
            "fill_body", f"the ground reaches over {shown} and fills {share:.2g} of it",
            "Check the units of its corners, and leave out what lies far away.",
        )  # fmt: skip


def _refuse_empty(body: Body, cut: _Cut, pattern: Pattern) -> None:
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
