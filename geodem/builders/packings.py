"""Packings of discs or spheres: the result type, and lattices."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geodem.builders.interactions import nearest
from geodem.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Packing:
    """Discs or spheres in a box from the origin to its sides.

    Attributes
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    box : (d,) [m]
    periodic : bool
        True: particles reach through the box's faces and touch those on the other side; can be tiled.
        False: all lie inside.
    solid_fraction : float
        Areas or volumes of the particles over that of the box [-]; what overlaps counts twice.
    largest_overlap : float
        Over the smaller radius [-]; 0 where none overlap.
    seed : int or None
        None for a lattice.
    """

    positions: Floats
    radii: Floats
    box: Floats
    periodic: bool
    solid_fraction: float
    largest_overlap: float
    seed: int | None = None

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.radii)

    def tile(self, *copies: int) -> Packing:
        """The periodic packing repeated along every axis; still periodic, neighbours in memory stay near in space.

        Parameters
        ----------
        *copies : int
            How often along each axis.

        Raises
        ------
        InputError
            The packing is not periodic, or there is not one whole positive number for every axis.
        """
        dimension = len(self.box)
        if not self.periodic:
            raise InputError("tile", "the packing is not periodic", "Make it with periodic=True.")
        if len(copies) != dimension or any(not isinstance(c, int) or c < 1 for c in copies):
            raise InputError(
                "tile",
                "this is not one whole number from 1 for every axis",
                f"Give {dimension}.",
                value=copies,
            )
        corners = np.array(list(itertools.product(*(range(count) for count in copies)))) * self.box
        positions = (corners[:, None, :] + self.positions[None, :, :]).reshape(-1, dimension)
        box = self.box * np.array(copies)
        return replace(self, positions=positions, radii=np.tile(self.radii, len(corners)), box=box)


def volumes(radii: Floats, dimension: int) -> Floats:
    """Areas of discs [m2] or volumes of spheres [m3]."""
    return np.pi * radii**2 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3


# side of the right-angled unit cell over the distance of neighbours, and the particles in it over its sides
_FACES: list[tuple[float, ...]] = [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)]
_LATTICES: dict[str, tuple[tuple[float, ...], Sequence[tuple[float, ...]]]] = {
    "square": ((1.0, 1.0), [(0.0, 0.0)]),
    "hexagonal": ((1.0, 3.0**0.5), [(0.0, 0.0), (0.5, 0.5)]),
    "simple_cubic": ((1.0, 1.0, 1.0), [(0.0, 0.0, 0.0)]),
    "bcc": ((2.0 / 3.0**0.5,) * 3, [(0.0, 0.0, 0.0), (0.5, 0.5, 0.5)]),
    "fcc": ((2.0**0.5,) * 3, _FACES),
    "hcp": (
        (1.0, 3.0**0.5, (8.0 / 3.0) ** 0.5),
        [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 5.0 / 6.0, 0.5), (0.0, 1.0 / 3.0, 0.5)],
    ),
}
# share of the neighbours' distance that a particle may stick out of the box by rounding
_ROUNDING = 1e-9


def lattice(
    kind: str,
    radius: float,
    *,
    box: Sequence[float] | None = None,
    cells: Sequence[int] | None = None,
    gap: float = 0.0,
) -> Packing:
    """Equal discs or spheres on a lattice.

    Parameters
    ----------
    kind : str
        2D: ``"square"``, ``"hexagonal"`` (rows along x). 3D: ``"simple_cubic"``, ``"bcc"``, ``"fcc"``, ``"hcp"``
        (layers across z).
    radius : float [m]
    box : (d,) float, optional
        Sides [m] of a box that is filled from the origin; all particles lie inside.
    cells : (d,) int, optional
        Instead of `box`, numbers of unit cells: the box is made of these and periodic.
    gap : float
        Between neighbouring surfaces [m]: 0 they touch, negative they overlap.

    Raises
    ------
    InputError
        An unknown lattice; a size that is not positive; box and cells at once; a box too small for one particle.
    """
    if kind not in _LATTICES:
        raise InputError("lattice", "there is no such lattice", nearest(kind, list(_LATTICES)), value=kind)
    unit, basis = _LATTICES[kind]
    dimension = len(unit)
    if not (np.isfinite(radius) and radius > 0.0):
        raise InputError("lattice, radius", "this is not a positive number", "Give metres.", value=radius)
    pitch = 2.0 * radius + gap
    if not (np.isfinite(gap) and gap > -radius):
        raise InputError(
            "lattice, gap",
            "this is not a number above minus one radius",
            "Give metres, 0 to touch.",
            value=gap,
        )
    if (box is None) == (cells is None):
        raise InputError("lattice", "it takes either a box or cells", "Give one of the two.")
    side = pitch * np.array(unit)
    if cells is not None:
        if len(cells) != dimension or any(int(c) != c or c < 1 for c in cells):
            raise InputError(
                "lattice, cells", f"these are not {dimension} whole numbers from 1", "Mend them.", value=cells
            )
        positions = _grid([int(count) for count in cells], basis) * side
        sides = side * np.array(cells)
    else:
        sides = box_sides("lattice", box, dimension)
        room = sides - 2.0 * radius + _ROUNDING * pitch
        if (room < 0.0).any():
            raise InputError(
                "lattice, box",
                "no particle fits into it",
                f"Make all sides at least {2 * radius:g} m.",
                value=box,
            )
        positions = _grid([int(count) for count in room // side + 1], basis) * side
        positions = positions[(positions <= room).all(axis=1)] + radius
    return Packing(
        positions=positions,
        radii=np.full(len(positions), float(radius)),
        box=sides,
        periodic=cells is not None,
        solid_fraction=float(len(positions) * volumes(np.array(radius), dimension) / np.prod(sides)),
        largest_overlap=max(0.0, -gap) / radius,
    )


def _grid(counts: Sequence[int], basis: Sequence[tuple[float, ...]]) -> Floats:
    """Particles of all unit cells, in cells."""
    corners = np.array(list(itertools.product(*(range(count) for count in counts))), dtype=np.float64)
    return np.asarray((corners[:, None, :] + np.array(basis)).reshape(-1, len(counts)))


def box_sides(place: str, box: Sequence[float] | None, dimension: int) -> Floats:
    """Sides of a box as an array, or `InputError`."""
    sides = np.asarray(box, dtype=np.float64)
    if sides.shape != (dimension,) or not (np.isfinite(sides) & (sides > 0.0)).all():
        raise InputError(
            f"{place}, box", f"these are not {dimension} positive numbers", "Give its sides in m.", value=box
        )
    return sides
