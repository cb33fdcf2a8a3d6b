"""Discs of ground that is handed over, and the rigid ground under and before it.

One dense packing fills what moves and a band of what stays, so that it goes on across the slip surface: below it are
discs of the same ground that are held. Where the section ends the ground goes on level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..builders.body import OUTSIDE
from ..builders.fill_body import fill_body
from ..builders.point_location import SimplexLocator
from ..errors import InputError
from .source import Source

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

SIZE_RATIO = 2.0
"""Largest over smallest disc: that of the packings whose friction was measured, see `geodem.runout.friction`."""

SOLID_FRACTION = 0.83
"""Of the packing: as dense as discs of these sizes come without being pressed, less a little."""

BAND = 2.5
"""Depth of the rigid ground in mean diameters."""

FEWEST = 100
"""Discs that a moving mass gets at least."""


@dataclass(frozen=True, eq=False)
class Discs:
    """Where discs are and what they are of.

    Attributes
    ----------
    positions : (n, 2) [m]
    radii : (n,) [m]
    material : (n,) int32
        As in the source.
    moving : (n,) bool
        False for those of the rigid ground.
    velocity : (n, 2) [m/s], spin : (n,) [rad/s]
        Of the source at the centres, as they were interpolated.
    surface : (k, 2) [m]
        Surface of the ground from left to right before it runs out, beyond the section as well.
    """

    positions: Floats
    radii: Floats
    material: Integers
    moving: NDArray[np.bool_]
    velocity: Floats
    spin: Floats
    surface: Floats

    @property
    def diameter(self) -> float:
        """Mean diameter of what moves [m]."""
        return 2.0 * float(self.radii[self.moving].mean())


class _Level(NamedTuple):
    """Ground that goes on level beyond an end of the section: from x to x, below y [m], of a material."""

    left: float
    right: float
    top: float
    material: int


class _Reach:
    """What is filled with discs, as a body: what moves, and a band of the ground around it."""

    dimension = 2
    surfaces: tuple[Any, ...] = ()
    remarks: tuple[str, ...] = ()

    def __init__(self, source: Source, band: float, beyond: float) -> None:
        import shapely

        self.source = source
        corners = source.positions[source.triangles]
        area = _signed(corners)
        self._kept = np.flatnonzero(area > 0.0)
        self._corners = corners[self._kept]
        self._locator = SimplexLocator(self._corners)
        outline = shapely.union_all(shapely.polygons(self._corners))
        levels = _levels(source, outline, beyond)
        whole = shapely.union_all(
            [outline, *(shapely.box(w.left, w.top - band, w.right, w.top) for w in levels)]
        )
        own = source.moving[source.triangles[self._kept]]
        mass = shapely.union_all(shapely.polygons(self._corners[own.any(axis=1)]))
        self.surface = free_surface(whole)
        crust = shapely.LineString(self.surface).buffer(band)
        self._area = shapely.union_all([mass.buffer(band), crust]).intersection(whole)
        shapely.prepare(self._area)
        self._levels = levels
        self.materials = source.materials
        low = np.array(self._area.bounds)
        self.bounds = low.reshape(2, 2)
        self.sizes = self._sizes()

    def _sizes(self) -> Floats:
        """Area (k,) of every material within reach [m2]; materials out of reach keep a trace."""
        import shapely

        share = shapely.area(shapely.intersection(shapely.polygons(self._corners), self._area))
        found = np.bincount(self.source.triangle_material[self._kept], share, minlength=len(self.materials))
        for level in self._levels:
            box = shapely.box(level.left, self.bounds[0, 1], level.right, level.top)
            found[level.material] += float(box.intersection(self._area).area)
        return np.asarray(found)

    def locate(self, points: Floats) -> tuple[Integers, Floats]:
        """Triangle of the source (n,), -1 for none, and barycentric coordinates (n, 3)."""
        found, _ = self._locator.locate(points)
        corner = self._corners[np.maximum(found, 0)]
        whole = _cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        weight = np.stack(
            [
                _cross(corner[:, (k + 1) % 3] - points, corner[:, (k + 2) % 3] - points) / whole
                for k in range(3)
            ],
            axis=1,
        )
        return np.where(found >= 0, self._kept[np.maximum(found, 0)], -1).astype(np.int32), weight

    def material_at(self, points: Floats) -> Integers:
        """As `geodem.builders.body.Body` asks."""
        import shapely

        triangle, _ = self.locate(points)
        kind = np.where(triangle >= 0, self.source.triangle_material[np.maximum(triangle, 0)], OUTSIDE)
        for level in self._levels:
            x, y = points[:, 0], points[:, 1]
            kind[(triangle < 0) & (x >= level.left) & (x <= level.right) & (y <= level.top)] = level.material
        kind[~shapely.contains_xy(self._area, points)] = OUTSIDE
        return np.asarray(kind, dtype=np.int32)


def place_discs(source: Source, *, discs: int, beyond: float, seed: int) -> Discs:
    """Fill what moves with about so many discs, and make the rigid ground.

    Parameters
    ----------
    source : Source
    discs : int
        Of what moves.
    beyond : float
        How far the ground goes on level beyond the section, on the side that the mass faces [m].
    seed : int

    Raises
    ------
    InputError
        Too few discs, or a material of the moving mass that gets none.
    """
    if discs < FEWEST:
        raise InputError(
            "discs", f"a mass of fewer than {FEWEST} discs does not flow", "Give 2000.", value=discs
        )
    mean_square = source.area * SOLID_FRACTION / (np.pi * discs)
    # radii equally frequent between r and r/2: mean square 7/12 of the largest
    largest = float(np.sqrt(mean_square / ((1.0 + 1.0 / SIZE_RATIO + 1.0 / SIZE_RATIO**2) / 3.0)))
    mean = 0.5 * largest * (1.0 + 1.0 / SIZE_RATIO)
    reach = _Reach(source, BAND * 2.0 * mean, beyond)
    filling = fill_body(
        reach, radius=largest, size_ratio=SIZE_RATIO, solid_fraction=SOLID_FRACTION, seed=seed, shifts=1
    )
    triangle, weight = reach.locate(filling.positions)
    corner = source.triangles[np.maximum(triangle, 0)]
    inside = triangle >= 0
    # the share of a triangle that a particle owns is where its coordinate is the largest
    owner = np.take_along_axis(corner, weight.argmax(axis=1)[:, None], axis=1)[:, 0]
    moving = inside & source.moving[owner]
    velocity = (weight[:, :, None] * source.velocity[corner]).sum(axis=1)
    spin = 0.5 * _curl(source, corner)
    for name, mass, number in zip(
        source.materials, source.material_mass,
        np.bincount(filling.material[moving], minlength=len(source.materials)), strict=True,
    ):  # fmt: skip
        if mass > 0.0 and number == 0:
            raise InputError(
                "discs", f"the moving part of {name!r} gets no disc", "Take more discs.", value=discs
            )
    return Discs(
        filling.positions, filling.radii, filling.material, moving,
        np.where(moving[:, None], velocity, 0.0), np.where(moving, spin, 0.0), reach.surface,
    )  # fmt: skip


def _levels(source: Source, outline: Any, beyond: float) -> list[_Level]:
    """Level ground beyond both ends of the section: as far as asked on the side that is faced, little on the other."""
    import shapely

    left, bottom, right, top = outline.bounds
    found = []
    for x, side in ((left, -1.0), (right, 1.0)):
        long = beyond if side == source.downhill else 0.1 * beyond
        if long <= 0.0:
            continue
        inside = x - side * 1e-6 * (right - left)
        line = shapely.intersection(
            shapely.LineString([(inside, bottom - 1.0), (inside, top + 1.0)]), outline
        )
        height = float(line.bounds[3])
        nearest = int(np.argmin(np.hypot(*(source.positions - (inside, height)).T)))
        owner = int(np.flatnonzero((source.triangles == nearest).any(axis=1))[0])
        ends = sorted((x, x + side * long))
        found.append(_Level(ends[0], ends[1], height, int(source.triangle_material[owner])))
    return found


def free_surface(whole: Any) -> Floats:
    """Upper side (k, 2) [m] of a polygon, from its left to its right end."""
    import shapely

    polygon = max(whole.geoms, key=lambda part: part.area) if hasattr(whole, "geoms") else whole
    ring = np.asarray(shapely.geometry.polygon.orient(polygon).exterior.coords)[:-1]
    near = 1e-6 * float(np.ptp(ring[:, 0]))
    ends = []
    for x in (ring[:, 0].max(), ring[:, 0].min()):
        side = np.flatnonzero(np.abs(ring[:, 0] - x) <= near)
        ends.append(int(side[ring[side, 1].argmax()]))
    right, left = ends
    # counter-clockwise, the way from the right end to the left one is over the top
    way = np.arange(right, left + 1) if left >= right else np.r_[right : len(ring), 0 : left + 1]
    return np.asarray(ring[way][::-1])


def _curl(source: Source, corner: Integers) -> Floats:
    """dv/dx - du/dy (n,) [1/s] in triangles with these corners (n, 3)."""
    p = source.positions[corner]
    v = source.velocity[corner]
    area = _cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    total = np.zeros(len(corner))
    for k in range(3):
        edge = p[:, (k + 2) % 3] - p[:, (k + 1) % 3]
        # gradient of the corner's shape function
        total += (-edge[:, 1] * v[:, k, 1] - edge[:, 0] * v[:, k, 0]) / area
    return total


def _cross(u: Floats, v: Floats) -> Floats:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _signed(corners: Floats) -> Floats:
    return 0.5 * _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
