"""Dense random packings of discs or spheres with a spread of sizes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geodem.builders.packings import Packing, box_sides, volumes
from geodem.errors import InputError
from geodem.kernels.overlap_removal import BUFFER, remove_overlaps

Floats = NDArray[np.float64]
Grading = Sequence[tuple[float, float]]

SOLID_FRACTION = {2: 0.83, 3: 0.62}
"""Dense, and just below where random particles jam (about 0.84 and 0.64): no overlap is left."""
DENSEST = {2: 0.91, 3: 0.75}
"""No equal particles are denser."""
# radii are this much larger while overlaps are removed, so that none is left once they shrink back
INFLATION = 1e-3
# what the inflated particles may overlap, over the smaller radius; a hair less for rounding
TOLERANCE = 2.0 * INFLATION / (1.0 + INFLATION) * (1.0 - 1e-9)
MOST_STEPS = 4000


def random_packing(
    dimension: int,
    *,
    radius: float | None = None,
    size_ratio: float = 1.0,
    grading: Grading | None = None,
    box: Sequence[float] | None = None,
    count: int | None = None,
    solid_fraction: float | None = None,
    periodic: bool = True,
    seed: int,
    most_steps: int = MOST_STEPS,
) -> Packing:
    """Discs or spheres thrown into a box at random and pushed apart.

    The same arguments give the same bits on any number of threads.

    Parameters
    ----------
    dimension : int
        2 or 3.
    radius : float, optional
        Largest radius [m].
    size_ratio : float
        Largest over smallest radius; in between all radii are equally frequent.
    grading : sequence of (float, float), optional
        Instead of `radius`: sieve curve of (radius [m], share of area or volume of smaller particles [-]), from
        share 0 to 1, straight in between. Two equal radii: that share is of that one size.
    box : (d,) float, optional
        Sides [m].
    count : int, optional
        Instead of `box`, the number of particles: the box is a square or cube.
    solid_fraction : float, optional
        Of the box [-]; 0.83 in 2D and 0.62 in 3D where it is left out. Above that, up to about 0.84 and 0.64,
        particles jam and overlap by some hundredths of a radius, which `Packing.largest_overlap` tells.
    periodic : bool
        False: all particles lie inside the box. At its walls they are less dense, so a narrow box jams earlier.
    seed : int
    most_steps : int
        After these, what overlap is left stays.

    Raises
    ------
    InputError
        A size, share or number that cannot be, a grading that falls, or a periodic box narrower than particles
        need to keep off their own images.
    """
    if dimension not in (2, 3):
        raise InputError("dimension", "particles are discs or spheres", "Give 2 or 3.", value=dimension)
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InputError("random packing, seed", "this is not a whole number from 0", "Give 1.", value=seed)
    share = SOLID_FRACTION[dimension] if solid_fraction is None else solid_fraction
    if not 0.0 < share <= DENSEST[dimension]:
        raise InputError(
            "random packing, solid_fraction", f"this is not between 0 and {DENSEST[dimension]:g}",
            f"Give at most 0.{84 if dimension == 2 else 64}, where random particles jam.", value=solid_fraction,
        )  # fmt: skip
    curve = _curve(radius, size_ratio, grading)
    if (box is None) == (count is None):
        raise InputError("random packing", "it takes either a box or a count", "Give one of the two.")
    rng = np.random.default_rng(seed)
    if box is not None:
        sides = box_sides("random packing", box, dimension)
        room = share * float(np.prod(sides))
        radii = _draw(rng, curve, grading is None, dimension, room=room)
    else:
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
            raise InputError(
                "random packing, count", "this is not a whole number from 1", "Give 10000.", value=count
            )
        radii = _draw(rng, curve, grading is None, dimension, count=int(count))
        sides = np.full(dimension, float((volumes(radii, dimension).sum() / share) ** (1.0 / dimension)))
    _refuse_narrow(radii, sides, periodic)
    start = _scatter(rng, radii, sides, periodic)
    separated = remove_overlaps(
        start,
        radii * (1.0 + INFLATION),
        sides,
        periodic=periodic,
        tolerance=TOLERANCE,
        most_steps=most_steps,
    )
    measured = remove_overlaps(
        separated.positions, radii, sides, periodic=periodic, tolerance=0.0, most_steps=0
    )
    return Packing(
        positions=measured.positions,
        radii=radii,
        box=sides,
        periodic=periodic,
        solid_fraction=float(volumes(radii, dimension).sum() / np.prod(sides)),
        largest_overlap=max(0.0, measured.largest_overlap),
        seed=int(seed),
    )


def _curve(radius: float | None, size_ratio: float, grading: Grading | None) -> Floats:
    """Sieve curve (k, 2); of a size ratio only its ends."""
    if (radius is None) == (grading is None):
        raise InputError("random packing", "it takes either a radius or a grading", "Give one of the two.")
    if radius is not None:
        if not (np.isfinite(radius) and radius > 0.0):
            raise InputError(
                "random packing, radius", "this is not a positive number", "Give m.", value=radius
            )
        if not (np.isfinite(size_ratio) and size_ratio >= 1.0):
            raise InputError(
                "random packing, size_ratio", "the largest radius over the smallest is at least 1", "Give 1.5.",
                value=size_ratio,
            )  # fmt: skip
        return np.array([[radius / size_ratio, 0.0], [radius, 1.0]])
    curve = np.asarray(grading, dtype=np.float64)
    if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 2:
        raise InputError(
            "random packing, grading",
            "these are not at least two pairs",
            "Give (radius, share) pairs.",
            value=grading,
        )
    if not (np.isfinite(curve).all() and (curve[:, 0] > 0.0).all()):
        raise InputError("random packing, grading", "not all radii are positive", "Mend them.", value=grading)
    if (np.diff(curve, axis=0) < 0.0).any() or curve[0, 1] != 0.0 or curve[-1, 1] != 1.0:
        raise InputError(
            "random packing, grading", "radii and shares do not grow, or shares do not go from 0 to 1",
            "Give for instance [(0.1, 0.0), (0.2, 0.4), (0.5, 1.0)].", value=grading,
        )  # fmt: skip
    return curve


def _draw(
    rng: np.random.Generator,
    curve: Floats,
    by_number: bool,
    dimension: int,
    *,
    room: float | None = None,
    count: int | None = None,
) -> Floats:
    """Radii that follow the curve, as many as fill `room` or `count` of them, in random order."""
    low, high = curve[:-1, 0], curve[1:, 0]
    if by_number:
        per_volume = np.array([1.0 / _mean_volume(low[0], high[0], dimension)])
    else:
        per_volume = np.diff(curve[:, 1]) * _numbers(low, high, dimension)
    total = per_volume.sum()
    wanted = total * room if room is not None else float(count or 1)
    # rounded so that the sum is right: the curve is met whatever the number
    ends = np.round(np.concatenate([[0.0], np.cumsum(per_volume)]) / total * max(round(wanted), 1)).astype(
        int
    )
    parts = []
    for a, b, number in zip(low, high, np.diff(ends), strict=True):
        # one draw from each of as many equal shares: the total hardly scatters
        level = (np.arange(number) + rng.random(number)) / max(number, 1)
        if by_number:
            parts.append(a + (b - a) * level)
        elif dimension == 2:
            parts.append(1.0 / (1.0 / a + (1.0 / b - 1.0 / a) * level))
        else:
            parts.append((a**-2 + (b**-2 - a**-2) * level) ** -0.5)
    return rng.permutation(np.concatenate(parts))


def _mean_volume(a: float, b: float, dimension: int) -> float:
    """Mean area or volume of particles whose radii are equally frequent from a to b."""
    powers = [a**k * b ** (dimension - k) for k in range(dimension + 1)]
    return float(volumes(np.array(1.0), dimension) * sum(powers) / (dimension + 1))


def _numbers(a: Floats, b: Floats, dimension: int) -> Floats:
    """Particles per area or volume of them that is spread evenly over the radii from a to b."""
    mean = 1.0 / (a * b) if dimension == 2 else 0.5 * (a + b) / (a * b) ** 2  # of 1/r^d
    return mean / volumes(np.array(1.0), dimension)


def _refuse_narrow(radii: Floats, sides: Floats, periodic: bool) -> None:
    largest = float(radii.max())
    least = 2.0 * largest
    if periodic:
        least = 2.0 * (2.0 * largest * (1.0 + INFLATION) + BUFFER * float(radii.mean()) * (1.0 + INFLATION))
    if sides.min() < least:
        raise InputError(
            "random packing, box",
            f"a side of {sides.min():.4g} m is too narrow for particles of {largest:.4g} m radius",
            f"Make all sides at least {least:.4g} m (more particles, or smaller ones).",
            value=sides.tolist(),
        )


def _scatter(rng: np.random.Generator, radii: Floats, sides: Floats, periodic: bool) -> Floats:
    """Random places, near in memory where they are near in space."""
    edge = 0.0 if periodic else float(radii.max())
    places = edge + rng.random((len(radii), len(sides))) * (sides - 2.0 * edge)
    cell = np.floor(places / (3.0 * float(radii.mean()))).astype(np.int64)
    return places[np.lexsort(cell.T)]
