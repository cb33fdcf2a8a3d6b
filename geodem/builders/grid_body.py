"""A body of pixels or voxels: what every cell of a regular grid is made of, and which grain it belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.body import OUTSIDE, Surface
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

SMALLEST_CELL, LARGEST_CELL = 1e-12, 1e9
"""Sides [m] beyond which areas and volumes are no longer told from zero or infinity."""


@dataclass(frozen=True)
class GridBody:
    """Materials on a regular grid, in 2D or 3D; a `geodem.builders.body.Body`.

    Attributes
    ----------
    labels : (nx, ny) or (nx, ny, nz) int16
        Material of every cell, -1 for none; the first index along x, all from the lowest corner up.
    materials : tuple of str
    spacing : (d,) float64 [m]
        Sides of a cell.
    origin : (d,) float64 [m]
        Lowest corner.
    grains : like `labels`, int32, or None
        Grain or block that a cell belongs to, -1 for none.
    remarks : tuple of str
    """

    labels: NDArray[np.int16]
    materials: tuple[str, ...]
    spacing: Floats
    origin: Floats
    grains: Integers | None = None
    remarks: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.labels.ndim

    @property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, d) [m]."""
        return np.stack([self.origin, self.origin + self.spacing * self.labels.shape])

    @cached_property
    def sizes(self) -> Floats:
        """Area or volume of each material (m,) [m2 or m3]: its cells."""
        cells = np.bincount(self.labels.ravel() + 1, minlength=len(self.materials) + 1)[1:]
        return np.asarray(cells * float(np.prod(self.spacing)))

    @property
    def surfaces(self) -> Sequence[Surface]:
        """None: a grid has no smooth boundary."""
        return ()

    @property
    def grain_number(self) -> int:
        """Number of grains or blocks that are told apart."""
        return 0 if self.grains is None else int(self.grains.max()) + 1

    def material_at(self, points: Floats) -> Integers:
        """Number of the material of the cells that points (n, d) [m] lie in, -1 outside; (n,) int32."""
        return self._read(self.labels, points, OUTSIDE)

    def group_at(self, points: Floats) -> Integers:
        """Number of the grain that points (n, d) [m] lie in, -1 for none; (n,) int32."""
        if self.grains is None:
            return np.full(len(points), -1, dtype=np.int32)
        return self._read(self.grains, points, -1)

    def crop(self, low: ArrayLike, high: ArrayLike) -> GridBody:
        """The cells between two corners (d,) [m], rounded to whole cells.

        Raises
        ------
        InputError
            No cell lies between them.
        """
        first, last = (np.asarray(corner, dtype=np.float64) for corner in (low, high))
        if first.shape != (self.dimension,) or last.shape != (self.dimension,):
            raise InputError("crop", f"a corner has {self.dimension} coordinates", "Give them in m.")
        start = np.clip(np.rint((first - self.origin) / self.spacing).astype(int), 0, self.labels.shape)
        stop = np.clip(np.rint((last - self.origin) / self.spacing).astype(int), 0, self.labels.shape)
        if (start >= stop).any():
            raise InputError(
                "crop", f"no cell lies between {first.tolist()} and {last.tolist()} m",
                f"Stay within {self.bounds[0].tolist()} and {self.bounds[1].tolist()} m.",
            )  # fmt: skip
        part = tuple(slice(a, b) for a, b in zip(start, stop, strict=True))
        grains = None if self.grains is None else _numbered(self.grains[part])
        return grid_body(
            self.labels[part],
            self.materials,
            self.spacing,
            origin=self.origin + start * self.spacing,
            grains=grains,
            remarks=self.remarks,
        )

    def with_grains(self, *materials: str) -> GridBody:
        """The same body, every connected piece of these materials being a grain of its own.

        Cells are connected through their faces.
        """
        from scipy import ndimage

        grains = np.full(self.labels.shape, -1, dtype=np.int32)
        for name in materials:
            if name not in self.materials:
                raise InputError(
                    "with_grains", "there is no such material", f"Known: {', '.join(self.materials)}.",
                    value=name,
                )  # fmt: skip
            mine = self.labels == self.materials.index(name)
            pieces, _ = ndimage.label(mine)
            grains[mine] = pieces[mine] + grains.max()
        return replace(self, grains=grains)

    def _read(self, field: NDArray[np.integer], points: Floats, outside: int) -> Integers:
        cell = np.floor((np.asarray(points) - self.origin) / self.spacing).astype(np.int64)
        within = ((cell >= 0) & (cell < field.shape)).all(axis=1)
        found = np.full(len(cell), outside, dtype=np.int32)
        found[within] = field[tuple(cell[within].T)]
        return found


def grid_body(
    labels: ArrayLike,
    materials: Sequence[str],
    spacing: float | ArrayLike,
    *,
    origin: ArrayLike = 0.0,
    grains: ArrayLike | None = None,
    remarks: Sequence[str] = (),
    place: str = "grid",
) -> GridBody:
    """A body from an array of labels; materials that no cell has are left out.

    Parameters
    ----------
    labels : (nx, ny) or (nx, ny, nz) int
        Index into `materials`, -1 for none.
    materials : sequence of str
    spacing : float or (d,) float [m]
        Side or sides of a cell.
    origin : float or (d,) float [m]
        Lowest corner.
    grains : like `labels`, int, optional
        Number of the grain, -1 for none.
    remarks : sequence of str
    place : str
        What the errors name.

    Raises
    ------
    InputError
        Labels that are not those of a material, no cell with one, a cell without positive sides.
    """
    given = np.asarray(labels)
    if given.ndim not in (2, 3) or not np.issubdtype(given.dtype, np.integer):
        raise InputError(
            f"{place}, labels", f"this is not a grid of whole numbers in 2D or 3D (shape {given.shape})",
            "Give an array (nx, ny) or (nx, ny, nz).",
        )  # fmt: skip
    if given.size == 0 or given.min() < OUTSIDE or given.max() >= len(materials):
        raise InputError(
            f"{place}, labels", f"labels go from -1 to {len(materials) - 1} here, one for each material",
            "Mend them.", value=None if given.size == 0 else [int(given.min()), int(given.max())],
        )  # fmt: skip
    sides = cell_sides(spacing, given.ndim, f"{place}, spacing")
    start = np.broadcast_to(np.asarray(origin, dtype=np.float64), (given.ndim,)).copy()
    if not np.isfinite(start).all():
        raise InputError(f"{place}, origin", "this is not a finite place", "Give metres.", value=origin)
    present = np.bincount(given.ravel() + 1, minlength=len(materials) + 1)[1:] > 0
    if not present.any():
        raise InputError(f"{place}, labels", "no cell has a material", "Look at the source of the labels.")
    number = np.concatenate([[OUTSIDE], np.where(present, np.cumsum(present) - 1, OUTSIDE)])
    notes = list(remarks)
    missing = [name for name, there in zip(materials, present, strict=True) if not there]
    if missing:
        notes.append(f"No cell is of {', '.join(missing)}.")
    groups = None
    if grains is not None:
        groups = np.asarray(grains, dtype=np.int32)
        if groups.shape != given.shape:
            raise InputError(
                f"{place}, grains", f"these have the shape {groups.shape}, the labels {given.shape}",
                "Give one number a cell.",
            )  # fmt: skip
    return GridBody(
        labels=number[given + 1].astype(np.int16),
        materials=tuple(name for name, there in zip(materials, present, strict=True) if there),
        spacing=sides,
        origin=start,
        grains=groups,
        remarks=tuple(notes),
    )


def cell_sides(spacing: float | ArrayLike | None, dimension: int, place: str) -> Floats:
    """Sides of a cell (d,) [m], or `InputError`."""
    try:
        sides = np.broadcast_to(np.asarray(spacing, dtype=np.float64), (dimension,)).copy()
    except (TypeError, ValueError):
        sides = np.full(dimension, np.nan)
    if not (np.isfinite(sides) & (sides > 0.0)).all():
        raise InputError(
            place,
            f"the sides of a cell are one or {dimension} positive lengths",
            "Give metres.",
            value=spacing,
        )
    if not ((sides > SMALLEST_CELL) & (sides < LARGEST_CELL)).all():
        raise InputError(
            place, f"cells of ground have sides of {SMALLEST_CELL:g} m to {LARGEST_CELL:g} m", "Check the unit.",
            value=spacing,
        )  # fmt: skip
    return sides


def _numbered(grains: Integers) -> Integers:
    """Grains numbered from 0 without gaps."""
    found, number = np.unique(grains, return_inverse=True)
    return np.asarray(number.reshape(grains.shape) - (1 if found[0] == -1 else 0), dtype=np.int32)
