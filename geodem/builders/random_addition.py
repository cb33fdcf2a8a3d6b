"""Loose random samples without any overlap, by random sequential addition; in a box or in a periodic cell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.builders.packings import Packing, box_sides, volumes
from geodem.builders.sizes import Sizes
from geodem.errors import InputError
from geodem.kernels.random_addition import addition_kernel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SATURATION = {2: 0.547074, 3: 0.384131}
"""Solid fraction at which no further equal particle finds room: Zhang & Torquato (2013), Phys. Rev. E 88:053312."""

LEVEL_RATIO = 2.0
"""Largest over smallest radius in one grid of cells."""
MOST_TRIES = 1000
"""A particle refused so many times is looked for in the voxels that are left."""
DRAWS = 1 << 18
"""Places drawn at once."""
CLASS = 0.98
"""Particles down to this share of a radius share the voxels made for the smallest of them."""
FINEST = 10
"""Times that voxels are halved: a gap of a thousandth of a radius is found."""
MOST_VOXELS = 20_000_000
POOR = 0.1
"""Share of draws that find room below which voxels are made finer."""


def scatter_particles(
    dimension: int,
    sizes: Sizes,
    *,
    box: Sequence[float] | None = None,
    count: int | None = None,
    solid_fraction: float | None = None,
    periodic: bool = True,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> Packing:
    """Particles at random places where none overlaps another, the largest placed first.

    Two of `box`, `count` and `solid_fraction` are given, the third follows. The same arguments give the same bits on
    any number of threads.

    Parameters
    ----------
    dimension : int
        2 or 3.
    sizes : Sizes
        See `geodem.builders.sizes`.
    box : (d,) float, optional
        Sides [m]; a square or cube where it is left out.
    count : int, optional
    solid_fraction : float, optional
        Of the box [-], met as closely as whole particles allow. Equal particles reach 0.547 in 2D and 0.384 in 3D,
        others more.
    periodic : bool
        True: particles reach through the faces. False: all lie inside.
    seed : int
    progress : callable, optional
        Is told the particles placed and their number now and then.

    Raises
    ------
    InputError
        A number that cannot be, or a box that is full before all are placed; the message names the solid
        fraction that was reached.
    """
    if dimension not in (2, 3):
        raise InputError("dimension", "particles are discs or spheres", "Give 2 or 3.", value=dimension)
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InputError("random addition, seed", "this is not a whole number from 0", "Give 1.", value=seed)
    if sizes.dimension not in (None, dimension):
        raise InputError(
            "random addition, sizes", f"this grading is for {sizes.dimension}D", f"Make it with dimension={dimension}."
        )  # fmt: skip
    rng = np.random.default_rng(seed)
    number, sides = _number_and_sides(dimension, sizes, box, count, solid_fraction)
    radii = sizes.draw(number, rng)
    if sides is None:
        assert solid_fraction is not None
        room = float(volumes(radii, dimension).sum()) / solid_fraction
        sides = np.full(dimension, room ** (1.0 / dimension))
    _refuse_too_much(radii, sides, dimension)
    order = np.argsort(-radii, kind="stable")
    addition = _Addition(radii[order], sides, periodic, rng)
    placed = addition.place(progress)
    fraction = float(volumes(radii[order][:placed], dimension).sum() / np.prod(sides))
    if placed < number:
        raise InputError(
            "random addition",
            f"the box is full with {placed} of {number} particles at a solid fraction of {fraction:.4g}: no room is "
            f"found for one of {radii[order][placed]:.4g} m radius",
            f"Give a solid fraction of at most {0.98 * fraction:.3f} and make it denser afterwards (grow_radii, "
            "compact), or use random_packing.",
        )  # fmt: skip
    positions = np.empty_like(addition.place_of)
    positions[order] = addition.place_of
    return Packing(
        positions=positions,
        radii=radii,
        box=sides,
        periodic=periodic,
        solid_fraction=fraction,
        largest_overlap=0.0,
        seed=int(seed),
    )


def _number_and_sides(
    dimension: int,
    sizes: Sizes,
    box: Sequence[float] | None,
    count: int | None,
    solid_fraction: float | None,
) -> tuple[int, Floats | None]:
    """Number of particles, and the box where it is given."""
    if sum(value is not None for value in (box, count, solid_fraction)) != 2:
        raise InputError(
            "random addition", "it takes two of box, count and solid_fraction", "Leave one of the three out."
        )
    sides = None if box is None else box_sides("random addition", box, dimension)
    if solid_fraction is not None and not (np.isfinite(solid_fraction) and 0.0 < solid_fraction < 1.0):
        raise InputError(
            "random addition, solid_fraction", "this is no share of a box", "Give 0.3.", value=solid_fraction
        )
    if count is not None:
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
            raise InputError(
                "random addition, count", "this is not a whole number from 1", "Give 10000.", value=count
            )
        return int(count), sides
    assert sides is not None
    assert solid_fraction is not None
    number = round(solid_fraction * float(np.prod(sides)) / sizes.mean_volume(dimension))
    if number < 1:
        raise InputError(
            "random addition, box", "it is too small for one particle at this solid fraction",
            "Give a larger one, or smaller particles.", value=sides.tolist(),
        )  # fmt: skip
    return number, sides


def _refuse_too_much(radii: Floats, sides: Floats, dimension: int) -> None:
    """Raise for a particle that does not fit, and for equal particles far beyond what can be reached."""
    largest = float(radii.max())
    if sides.min() < 2.0 * largest:
        raise InputError(
            "random addition, box",
            f"a side of {sides.min():.4g} m is narrower than a particle of {largest:.4g} m radius",
            f"Make all sides at least {2.0 * largest:.4g} m.", value=sides.tolist(),
        )  # fmt: skip
    fraction = float(volumes(radii, dimension).sum() / np.prod(sides))
    # a small sample may by chance go a little beyond the limit of a large one
    most = SATURATION[dimension] * (1.0 + 1.0 / np.sqrt(len(radii))) + 0.005
    if float(radii.min()) == largest and fraction > most:
        raise InputError(
            "random addition, solid_fraction",
            f"{fraction:.4g} is more than equal {'discs' if dimension == 2 else 'spheres'} placed at random reach, "
            f"{SATURATION[dimension]:.3f}",
            f"Give at most {0.98 * SATURATION[dimension]:.2f} and make it denser afterwards (grow_radii, compact), or "
            "use random_packing.",
        )  # fmt: skip


@dataclass
class _Voxels:
    """Cubes that may have room: corners by number (m, d), sides (d,) [m], and where counting begins (d,) [m]."""

    corner: NDArray[np.int32]
    side: Floats
    origin: Floats
    radius: float
    last: int


class _Addition:
    """Places particles, whose radii fall, one after the other."""

    def __init__(self, radii: Floats, sides: Floats, periodic: bool, rng: np.random.Generator) -> None:
        self.radii, self.sides, self.periodic, self.rng = radii, sides, periodic, rng
        self.dimension = len(sides)
        self.kernel = addition_kernel(self.dimension, periodic)
        level = np.floor(np.log(radii[0] / radii) / np.log(LEVEL_RATIO) + 1e-12).astype(np.int64)
        self.level: Integers = np.unique(level, return_inverse=True)[1].astype(np.int64)
        levels = int(self.level.max()) + 1
        self.largest = np.array([radii[self.level == number].max() for number in range(levels)])
        self.shape = np.ones((levels, 3), dtype=np.int64)
        for number, bound in enumerate(self.largest):
            # no finer than one particle to a cell
            share = np.count_nonzero(self.level == number)
            side = max(2.0 * bound, float((np.prod(sides) / share) ** (1.0 / self.dimension)))
            self.shape[number, : self.dimension] = np.maximum(np.floor(sides / side), 1.0)
        self.first = np.concatenate([[0], np.cumsum(self.shape.prod(axis=1))])
        self.first_in_cell = np.full(self.first[-1], -1, dtype=np.int32)
        self.next_in_cell = np.full(len(radii), -1, dtype=np.int32)
        self.place_of = np.zeros((len(radii), self.dimension))
        self.cells = (self.first_in_cell, self.next_in_cell, self.largest, self.shape, self.first, sides)

    def place(self, progress: Callable[[int, int], None] | None) -> int:
        """Place all; returns how many found room."""
        k, tried = 0, 0
        while k < len(self.radii):
            drawn = self.rng.random((min(DRAWS, 20 * len(self.radii)), self.dimension))
            k, _, tried = self.kernel.add(
                drawn, k, tried, MOST_TRIES, self.place_of, self.radii, self.level, *self.cells
            )
            if tried == MOST_TRIES:
                before, tried = k, 0
                k = self._place_in_voxels(k)
                if k == before:
                    break
            if progress is not None:
                progress(k, len(self.radii))
        return int(k)

    def _place_in_voxels(self, k: int) -> int:
        """Place the particles of nearly the radius of k where voxels are left; returns the next one."""
        voxels = self._first_voxels(k)
        for halving in range(FINEST + 1):
            while k < voxels.last and len(voxels.corner):
                draws = max(4096, min(DRAWS, 2 * len(voxels.corner)))
                drawn = self.rng.random((draws, 1 + self.dimension))
                before = k
                k = int(self.kernel.add_in_voxels(
                    drawn, k, voxels.last, voxels.corner, voxels.origin, voxels.side, self.place_of, self.radii,
                    self.level, *self.cells,
                ))  # fmt: skip
                if k - before < POOR * draws:
                    break
            if k == voxels.last or halving == FINEST or len(voxels.corner) > MOST_VOXELS:
                break
            self._halve(voxels)
            if not len(voxels.corner):
                break
        return k

    def _first_voxels(self, k: int) -> _Voxels:
        """Cubes of about half a radius that have room for the smallest particle of the class of k."""
        last = int(np.searchsorted(-self.radii, -CLASS * self.radii[k], side="right"))
        radius = float(self.radii[last - 1])
        origin = np.zeros(self.dimension) if self.periodic else np.full(self.dimension, radius)
        room = self.sides - 2.0 * origin
        counts = np.maximum(np.ceil(room / (0.5 * radius)), 1.0).astype(np.int64)
        voxels = _Voxels(np.empty((0, self.dimension), np.int32), room / counts, origin, radius, last)
        kept = []
        total = int(counts.prod())
        for begin in range(0, total, 1 << 21):
            chosen = np.unravel_index(np.arange(begin, min(begin + (1 << 21), total)), tuple(counts))
            kept.append(self._with_room(np.stack(chosen, axis=1).astype(np.int32), voxels))
        voxels.corner = np.concatenate(kept)
        return voxels

    def _halve(self, voxels: _Voxels) -> None:
        """Cut every voxel in two along every axis and drop the parts without room."""
        voxels.side = 0.5 * voxels.side
        corners = np.stack(np.meshgrid(*[[0, 1]] * self.dimension, indexing="ij"), axis=-1)
        offsets: Any = corners.reshape(-1, self.dimension).astype(np.int32)
        kept = []
        for begin in range(0, len(voxels.corner), 1 << 18):
            parts = 2 * voxels.corner[begin : begin + (1 << 18), None, :] + offsets
            kept.append(self._with_room(parts.reshape(-1, self.dimension), voxels))
        voxels.corner = np.concatenate(kept)

    def _with_room(self, corner: NDArray[np.int32], voxels: _Voxels) -> NDArray[np.int32]:
        dead = np.empty(len(corner), dtype=np.bool_)
        self.kernel.find_covered(
            np.ascontiguousarray(corner), voxels.origin, voxels.side, voxels.radius, len(self.largest), self.place_of,
            self.radii, *self.cells, dead,
        )  # fmt: skip
        return corner[~dead]
