"""Ground drawn by polygons or given as a box of layers, as bodies that are filled with particles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from geodem.builders.body import OUTSIDE, Surface
from geodem.builders.section import Section
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True)
class SectionBody:
    """A `geodem.builders.body.Body` in 2D: polygons.

    Parameters
    ----------
    section : Section
    """

    section: Section
    remarks: Sequence[str] = ()

    @property
    def dimension(self) -> int:
        """2."""
        return 2

    @property
    def materials(self) -> tuple[str, ...]:
        """In order of first appearance."""
        return self.section.materials

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, 2) [m]."""
        return np.array(self.section.bounds, dtype=np.float64).reshape(2, 2)

    @cached_property
    def sizes(self) -> Floats:
        """Area of each material (m,) [m2]."""
        return np.array([self.section.area(name) for name in self.materials])

    @cached_property
    def surfaces(self) -> Sequence[Surface]:
        """The outline, one surface "rest"."""
        corners = []
        for part in self.section.parts:
            for ring, exterior in ((part.exterior, True), *((hole, False) for hole in part.interiors)):
                points = shapely.get_coordinates(ring)
                if ring.is_ccw != exterior:
                    points = points[::-1]
                corners.append(np.stack([points[:-1], points[1:]], axis=1))
        return (Surface("rest", np.concatenate(corners)),)

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, 2) [m], -1 outside; (n,) int32."""
        found = np.full(len(points), OUTSIDE, dtype=np.int32)
        for region in self.section.regions:
            shapely.prepare(region.polygon)
            inside = shapely.intersects_xy(region.polygon, points[:, 0], points[:, 1])
            found[inside & (found == OUTSIDE)] = self.materials.index(region.material)
        return found


@dataclass(frozen=True)
class BoxBody:
    """A `geodem.builders.body.Body`: a rectangle or a block, of layers from the top.

    Attributes
    ----------
    low, high : tuple of float [m]
        Corners.
    layers : tuple of (str, float)
        Material and thickness [m] from the top downwards; the last one reaches to the bottom.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    layers: tuple[tuple[str, float], ...]
    remarks: Sequence[str] = ()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.low)

    @property
    def materials(self) -> tuple[str, ...]:
        """In order of first appearance, from the top."""
        return tuple(dict.fromkeys(name for name, _ in self.layers))

    @property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, d) [m]."""
        return np.array([self.low, self.high])

    @cached_property
    def floors(self) -> Floats:
        """Heights (l,) [m] at which each layer ends."""
        depth = np.cumsum([thickness for _, thickness in self.layers])
        floors = self.high[-1] - depth
        floors[-1] = self.low[-1]
        return np.asarray(floors)

    @property
    def sizes(self) -> Floats:
        """Area or volume of each material (m,) [m2 or m3]."""
        tops = np.append(self.high[-1], self.floors[:-1])
        across = float(np.prod(np.array(self.high[:-1]) - np.array(self.low[:-1])))
        found = np.zeros(len(self.materials))
        for (name, _), top, floor in zip(self.layers, tops, self.floors, strict=True):
            found[self.materials.index(name)] += across * (top - floor)
        return found

    @property
    def surfaces(self) -> Sequence[Surface]:
        """None: its sides are named as they are."""
        return ()

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, d) [m], -1 outside; (n,) int32."""
        inside = ((points >= self.low) & (points <= self.high)).all(axis=1)
        # floors fall from the top downwards
        layer = np.minimum((points[:, -1, None] < self.floors).sum(axis=1), len(self.layers) - 1)
        own = np.array([self.materials.index(name) for name, _ in self.layers], dtype=np.int32)
        return np.where(inside, own[layer], OUTSIDE).astype(np.int32)


def box_body(
    size: Sequence[float], layers: Sequence[tuple[str, float]], origin: ArrayLike | None = None
) -> BoxBody:
    """A rectangle or block of that size, (d,) [m], with its lower corner at the origin (d,) [m].

    Raises
    ------
    InputError
        A size that is none; layers that are none, or thicker than it is high.
    """
    sides = np.asarray(size, dtype=float)
    if sides.shape not in ((2,), (3,)) or not (np.isfinite(sides).all() and (sides > 0.0).all()):
        raise InputError(
            "box", "these are not two or three sides", "Give metres above 0", value=sides.tolist()
        )
    low = np.zeros(len(sides)) if origin is None else np.asarray(origin, dtype=float)
    if low.shape != sides.shape:
        raise InputError("origin", "it has another dimension than the box", f"Give {len(sides)} lengths")
    if not layers or any(not thickness > 0.0 for _, thickness in layers):
        raise InputError("layers", "there is none, or one has no thickness", "Give material and thickness")
    above = float(sum(thickness for _, thickness in layers[:-1]))
    if above >= sides[-1]:
        raise InputError(
            "layers", f"those above the last are {above:g} m thick and the box is {sides[-1]:g} m high",
            "Leave room for the last one, which reaches to the bottom",
        )  # fmt: skip
    return BoxBody(tuple(low.tolist()), tuple((low + sides).tolist()), tuple(layers))
