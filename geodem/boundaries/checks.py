"""What a wall cannot be: facets without size, normals that are none, surfaces inside out, servos that cannot work."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..assembly import Wall
from ..errors import InputError, InputErrors

Floats = NDArray[np.float64]

SAME_CORNER = 1e-6
"""Corners nearer to each other than this share of a wall's shortest edge are one corner."""
FLAT = 1e-9
"""Twice the area of a triangle over the square of its longest edge: at or below it, the triangle has no plane."""
ORTHONORMAL = 1e-9
"""How far the length of a unit vector may be from 1."""


def refuse(walls: Sequence[Wall], dimension: int) -> None:
    """Raise InputErrors for all that is wrong with the walls of a scene of `dimension` 2 or 3."""
    errors = [error for wall in walls for error in wall_errors(wall, dimension)]
    if errors:
        raise InputErrors(errors) if len(errors) > 1 else errors[0]


def wall_errors(wall: Wall, dimension: int) -> list[InputError]:
    """All that is wrong with a wall in a scene of `dimension` 2 or 3."""
    place = f"wall {wall.name!r}"
    errors = []
    if dimension == 2 and len(wall.triangles):
        errors.append(InputError(place, "triangles bound spheres, not discs", "Make it of segments."))
    if dimension == 3 and len(wall.segments):
        errors.append(InputError(place, "segments bound discs, not spheres", "Make it of triangles."))
    for what, values, shape in (
        ("planes", wall.planes, (2, dimension)),
        ("segments", wall.segments, (2, 2)),
        ("triangles", wall.triangles, (3, 3)),
    ):
        if not len(values):
            continue
        if np.shape(values)[1:] != shape:
            problem = f"{what} of shape {np.shape(values)} do not fit (k, {shape[0]}, {shape[1]})"
            errors.append(InputError(place, problem, f"Make the wall for {dimension}D."))
        elif not np.isfinite(values).all():
            errors.append(InputError(place, f"its {what} are not all finite", "Give finite numbers in m."))
    for what, values, size in (
        ("velocity", wall.velocity, dimension),
        ("spin", wall.spin, 2 * dimension - 3),
        ("centre", wall.centre, dimension),
    ):
        if np.shape(values) != (size,) or not np.isfinite(values).all():
            problem = f"its {what} is not made of {size} finite numbers"
            errors.append(InputError(place, problem, "Mend it.", value=np.asarray(values).tolist()))
    if not (len(wall.planes) or len(wall.segments) or len(wall.triangles)):
        errors.append(
            InputError(place, "it has no plane, segment or triangle", "Give it one, or leave it out.")
        )
    if errors:
        return errors
    return _bad_planes(wall) + _bad_segments(wall) + _bad_triangles(wall) + _bad_servo(wall, dimension)


def _bad_planes(wall: Wall) -> list[InputError]:
    return [
        InputError(
            f"wall {wall.name!r}, plane {k}",
            "its normal is not of length 1",
            "Divide it by its length, or use geodem.boundaries.walls.plane.",
            value=normal.tolist(),
        )
        for k, (_, normal) in enumerate(wall.planes)
        if not abs(float(normal @ normal) - 1.0) <= ORTHONORMAL
    ]


def _bad_segments(wall: Wall) -> list[InputError]:
    return [
        InputError(
            f"wall {wall.name!r}, segment {k}",
            "its two ends are one point",
            "Leave one of the two points out.",
            value=wall.segments[k, 0].tolist(),
        )
        for k in np.flatnonzero((wall.segments[:, 0] == wall.segments[:, 1]).all(axis=1))
    ]


def _bad_triangles(wall: Wall) -> list[InputError]:
    a, b, c = (wall.triangles[:, k] for k in range(3))
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    flat = np.flatnonzero(twice_area <= FLAT * longest)
    if len(flat):
        first = int(flat[0])
        others = f", like {len(flat) - 1} more" if len(flat) > 1 else ""
        return [
            InputError(
                f"wall {wall.name!r}, triangle {first}",
                f"its corners lie on one line or point{others}",
                "Remove it, or let the program that made the mesh repair it.",
                value=wall.triangles[first].tolist(),
            )
        ]
    return _inside_out(wall)


def _inside_out(wall: Wall) -> list[InputError]:
    """A closed surface has an inside: its normals, by the right hand over the corners, must point out of it."""
    if len(wall.triangles) < 4:
        return []
    corner = merge_corners(wall.triangles)
    edges = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    _, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if not (uses == 2).all():
        return []
    directed, uses = np.unique(edges, axis=0, return_counts=True)
    if len(directed) < len(edges):
        owners = np.tile(np.arange(len(corner)), 3)
        doubled = directed[np.argmax(uses)]
        pair = owners[(edges == doubled).all(axis=1)]
        return [
            InputError(
                f"wall {wall.name!r}, triangles {pair[0]} and {pair[1]}",
                "the surface is closed, but these neighbours face opposite sides",
                "Reverse the order of one's corners, or let the program that made the mesh make its normals agree.",
            )
        ]
    origin = wall.triangles.mean(axis=(0, 1))
    a, b, c = (wall.triangles[:, k] - origin for k in range(3))
    volume = float((a * np.cross(b, c)).sum() / 6.0)
    if volume < 0.0:
        return [
            InputError(
                f"wall {wall.name!r}",
                f"the surface is closed and inside out: its normals point inwards (volume {volume:.6g} m3)",
                "Reverse the order of the corners: turn_over=True.",
            )
        ]
    return []


def _bad_servo(wall: Wall, dimension: int) -> list[InputError]:
    servo = wall.servo
    if servo is None:
        return []
    place = f"wall {wall.name!r}, servo"
    direction = np.asarray(servo.direction, dtype=np.float64)
    errors = []
    if direction.shape != (dimension,) or not np.isfinite(direction).all():
        problem = f"its direction is not made of {dimension} finite numbers"
        errors.append(InputError(place, problem, "Point it into the particles.", value=servo.direction))
    elif not abs(float(direction @ direction) - 1.0) <= ORTHONORMAL:
        problem = "its direction is no unit vector"
        errors.append(InputError(place, problem, "Divide it by its length.", value=servo.direction))
    if not np.isfinite(servo.force):
        errors.append(InputError(place, "its force is not finite", "Give it in N.", value=servo.force))
    if not (np.isfinite(servo.limit) and servo.limit > 0.0):
        remedy = "Give the largest speed of the wall in m/s, more than 0."
        errors.append(InputError(place, "its limit is no speed", remedy, value=servo.limit))
    if servo.gain is not None and not (np.isfinite(servo.gain) and servo.gain > 0.0):
        remedy = "Give it in m/(N s), more than 0, or leave it out."
        errors.append(InputError(place, "its gain cannot be used", remedy, value=servo.gain))
    return errors


def merge_corners(facets: Floats) -> NDArray[np.int32]:
    """Numbers of the corners of segments or triangles (k, c, d): equal corners have one number.

    Equal: nearer than SAME_CORNER of the shortest edge. Returns (k, c) int32.
    """
    count, corners, dimension = facets.shape
    if count == 0:
        return np.empty((0, corners), dtype=np.int32)
    spots = facets.reshape(-1, dimension)
    edges = np.linalg.norm(facets - np.roll(facets, 1, axis=1), axis=2)
    # exactly equal ones first: a corner of many triangles has many pairs
    unique, number = np.unique(spots, axis=0, return_inverse=True)
    near = cKDTree(unique).query_pairs(SAME_CORNER * float(edges.min()), output_type="ndarray")
    graph = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(unique), len(unique)))
    _, merged = connected_components(graph, directed=False)
    return np.asarray(merged[number.reshape(-1)], dtype=np.int32).reshape(count, corners)
