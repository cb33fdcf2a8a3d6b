"""Which particles lie in a shape: what an excavation takes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


def inside_polygon(positions: Floats, corners: ArrayLike) -> Mask:
    """Centres (n, 2) [m] in a polygon (k, 2) [m], its outline included.

    Raises
    ------
    InputError
        Corners that are no polygon.
    """
    import shapely

    points = np.asarray(corners, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3 or not np.isfinite(points).all():
        raise InputError("polygon", "these are no corners", "Give three or more points (x, y)")
    polygon = shapely.Polygon(points)
    if not polygon.is_valid or polygon.area == 0.0:
        raise InputError(
            "polygon", "it crosses itself or has no area", "Give the corners in the order around it"
        )
    shapely.prepare(polygon)
    return np.asarray(shapely.intersects_xy(polygon, positions[:, 0], positions[:, 1]))


def inside_circle(positions: Floats, centre: ArrayLike, radius: float) -> Mask:
    """Centres (n, d) [m] in a circle or a ball."""
    _positive("radius", radius)
    away = positions - np.asarray(centre, dtype=float)
    return np.asarray((away**2).sum(axis=1) <= radius**2)


def inside_cylinder(positions: Floats, start: ArrayLike, end: ArrayLike, radius: float) -> Mask:
    """Centres (n, 3) [m] in a round cylinder from start to end (3,) [m]: a length of tunnel.

    Raises
    ------
    InputError
        No radius, or a start that is the end.
    """
    _positive("radius", radius)
    first, last = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length = float(np.linalg.norm(last - first))
    _positive("length", length)
    axis = (last - first) / length
    away = positions - first
    along = away @ axis
    aside = (away**2).sum(axis=1) - along**2
    return np.asarray((along >= 0.0) & (along <= length) & (aside <= radius**2))


def inside_box(positions: Floats, low: ArrayLike, high: ArrayLike) -> Mask:
    """Centres (n, d) [m] in a rectangle or block with these corners (d,) [m]; infinite ones reach beyond the ground.

    Raises
    ------
    InputError
        A box without an inside.
    """
    first, last = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    if first.shape != last.shape or not (first < last).all():
        raise InputError("box", "it has no inside", "Give low below high along every axis")
    return np.asarray(((positions >= first) & (positions <= last)).all(axis=1))


def _positive(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise InputError(name, "this is no length", "Give metres, more than 0", value=value)
