"""Joints: flat faces that cut through a body, one by one, each of a joint material.

A face is a segment in 2D and a disc in 3D. A polyline is a joint of several faces, a plane a disc that reaches beyond
the body.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint.

    Attributes
    ----------
    material : str
        Of the joint.
    centres : (f, d) [m]
        Middles of its faces; those of a polyline in order.
    normals : (f, d)
        Unit vectors to their upper side: in 2D to the left of the way from the first to the last point.
    radii : (f,) [m]
        Half the length of a segment, radius of a disc.
    """

    material: str
    centres: Floats
    normals: Floats
    radii: Floats

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.centres.shape[1])

    @property
    def faces(self) -> int:
        """Number of faces."""
        return len(self.radii)

    @property
    def area(self) -> float:
        """Of all faces [m2]; in 2D their length [m]."""
        sizes = 2.0 * self.radii if self.dimension == 2 else math.pi * self.radii**2
        return float(sizes.sum())


def polyline(points: ArrayLike, material: str) -> Joint:
    """A joint along straight lines from point to point, 2D.

    Parameters
    ----------
    points : (k, 2) float [m]
        Two at least.
    material : str

    Raises
    ------
    InputError
        Points that are no line.
    """
    corners = _numbers("joint, points", points, "m")
    if corners.ndim != 2 or corners.shape[1:] != (2,) or len(corners) < 2:
        raise InputError(
            "joint, points", f"an array of shape {corners.shape} is no line in 2D",
            "Give two points or more, two coordinates each",
        )  # fmt: skip
    way = np.diff(corners, axis=0)
    length = np.sqrt((way**2).sum(axis=1))
    if (length == 0.0).any():
        point = corners[int(np.argmin(length))].tolist()
        raise InputError("joint, points", "two of them coincide", "Leave one out", value=point)
    normals = np.stack([-way[:, 1], way[:, 0]], axis=1) / length[:, None]
    return Joint(material, 0.5 * (corners[:-1] + corners[1:]), normals, 0.5 * length)


def segment(start: ArrayLike, end: ArrayLike, material: str) -> Joint:
    """A joint along a straight line, 2D; points [m]."""
    return polyline(np.stack([np.asarray(start, dtype=float), np.asarray(end, dtype=float)]), material)


def disc(centre: ArrayLike, normal: ArrayLike, radius: float, material: str) -> Joint:
    """A round joint, 3D.

    Parameters
    ----------
    centre : (3,) float [m]
    normal : (3,) float
        To its upper side; of any length. `dip_normal` gives it from dip and dip direction.
    radius : float [m]

    Raises
    ------
    InputError
        A normal without direction, or a radius that is none.
    """
    if not (math.isfinite(radius) and radius > 0.0):
        raise InputError("joint, radius", "this is no radius", "Give metres, more than 0", value=radius)
    middle = _vector("joint, centre", centre, 3)
    return Joint(material, middle[None], _unit("joint, normal", normal, 3)[None], np.array([float(radius)]))


def plane(point: ArrayLike, normal: ArrayLike, bounds: ArrayLike, material: str) -> Joint:
    """A joint through the whole of a body, 2D or 3D.

    Parameters
    ----------
    point : (d,) float [m]
        On the plane (2D: line).
    normal : (d,) float
    bounds : (2, d) float [m]
        Lowest and highest coordinates of the body.

    Raises
    ------
    InputError
        A normal without direction; a plane that passes by the body.
    """
    box = box_of(bounds)
    d = box.shape[1]
    upward = _unit("joint, normal", normal, d)
    middle = 0.5 * (box[0] + box[1])
    centre = middle - ((middle - _vector("joint, point", point, d)) @ upward) * upward
    whole = Joint(
        material, centre[None], upward[None], np.array([0.5 * float(np.linalg.norm(box[1] - box[0]))])
    )
    found = clipped(whole, box)
    if found is None:
        raise InputError("joint", "it passes by the body", "Move its point into the body", value=point)
    return found


def dip_normal(dip: float, dip_direction: float) -> Floats:
    """Upward normal (3,) of a plane: x is east, y north, z up.

    Parameters
    ----------
    dip : float
        Below the horizontal, 0 to pi/2 [rad].
    dip_direction : float
        Of the steepest way down, clockwise from north [rad].
    """
    if not 0.0 <= dip <= 0.5 * math.pi:
        raise InputError("joint, dip", "this is no dip", "Give 0 to pi/2 rad", value=dip)
    return np.array(
        [math.sin(dip) * math.sin(dip_direction), math.sin(dip) * math.cos(dip_direction), math.cos(dip)]
    )


def clipped(joint: Joint, bounds: ArrayLike) -> Joint | None:
    """What of a joint lies in a box (2, d) [m]; None where nothing does.

    Segments end at the box. Discs stay whole where they meet it: their area is counted in it alone.
    """
    box = box_of(bounds)
    if joint.dimension == 3:
        nearest = np.clip(joint.centres, box[0], box[1])
        inside = np.sqrt(((nearest - joint.centres) ** 2).sum(axis=1)) < joint.radii
        # the plane must meet the box, not only the ball around the disc
        reach = 0.5 * np.abs(joint.normals) @ (box[1] - box[0])
        inside &= np.abs(((0.5 * (box[0] + box[1]) - joint.centres) * joint.normals).sum(axis=1)) <= reach
        keep = np.flatnonzero(inside)
        return _faces(joint, keep) if len(keep) else None
    along = np.stack([joint.normals[:, 1], -joint.normals[:, 0]], axis=1)
    low, high = -joint.radii.copy(), joint.radii.copy()
    for axis in range(2):
        way = along[:, axis]
        moving = np.abs(way) > 1e-12
        safe = np.where(moving, way, 1.0)
        ends = (box[:, axis] - joint.centres[:, axis, None]) / safe[:, None]
        low = np.where(moving, np.maximum(low, ends.min(axis=1)), low)
        high = np.where(moving, np.minimum(high, ends.max(axis=1)), high)
        beside = (joint.centres[:, axis] < box[0, axis]) | (joint.centres[:, axis] > box[1, axis])
        high = np.where(~moving & beside, -math.inf, high)
    keep = np.flatnonzero(high - low > 1e-12 * joint.radii)
    if not len(keep):
        return None
    middle = 0.5 * (low + high)[keep]
    centres = joint.centres[keep] + middle[:, None] * along[keep]
    return replace(joint, centres=centres, normals=joint.normals[keep], radii=0.5 * (high - low)[keep])


def in_band(joint: Joint, positions: ArrayLike, thickness: float) -> NDArray[np.bool_]:
    """Which points (n, d) [m] lie in a filling of that thickness [m] along a joint, half of it on each side.

    Particles there make a fault with a filling when they are added with a material of their own.
    """
    if not (math.isfinite(thickness) and thickness > 0.0):
        raise InputError(
            "joint, thickness", "this is no thickness", "Give metres, more than 0", value=thickness
        )
    points = _numbers("positions", positions, "m")
    return np.asarray(distance_to(joint, points)[0] <= 0.5 * thickness)


def distance_to(joint: Joint, points: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Distance (n,) [m] of points (n, d) to the nearest face, and which one that is (n,)."""
    best = np.full(len(points), math.inf)
    nearest = np.zeros(len(points), dtype=np.int64)
    for face, (centre, normal, radius) in enumerate(
        zip(joint.centres, joint.normals, joint.radii, strict=True)
    ):
        away = points - centre
        height = away @ normal
        aside = np.sqrt(np.maximum((away**2).sum(axis=1) - height**2, 0.0))
        gap = np.hypot(height, np.maximum(aside - radius, 0.0))
        nearest[gap < best] = face
        best = np.minimum(best, gap)
    return best, nearest


def box_of(bounds: ArrayLike) -> Floats:
    """Bounds (2, d) as an array; raises InputError where they are none."""
    box = _numbers("bounds", bounds, "m")
    if box.shape not in ((2, 2), (2, 3)) or not (box[1] > box[0]).all():
        raise InputError(
            "bounds", "these are not the lowest and the highest coordinates of a body", "Give two rows",
            value=np.asarray(bounds).tolist(),
        )  # fmt: skip
    return box


def _faces(joint: Joint, keep: NDArray[np.int64]) -> Joint:
    return replace(joint, centres=joint.centres[keep], normals=joint.normals[keep], radii=joint.radii[keep])


def _numbers(place: str, values: ArrayLike, unit: str) -> Floats:
    try:
        found = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(place, "these are not numbers", f"Give numbers in {unit}") from None
    if not np.isfinite(found).all():
        raise InputError(place, "some of these are not finite", f"Give finite numbers in {unit}")
    return found


def _vector(place: str, values: ArrayLike, dimension: int) -> Floats:
    found = _numbers(place, values, "m")
    if found.shape != (dimension,):
        raise InputError(
            place, f"these are not {dimension} numbers", f"Give {dimension}", value=found.tolist()
        )
    return found


def _unit(place: str, values: ArrayLike, dimension: int) -> Floats:
    found = _vector(place, values, dimension)
    size = float(np.linalg.norm(found))
    if size == 0.0:
        raise InputError(place, "it has no direction", "Give a vector that is not zero", value=found.tolist())
    return np.asarray(found / size)
