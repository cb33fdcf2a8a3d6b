"""Circular slip surfaces through two points of the ground surface, one or many at once."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reference.ground import Array, Ground, NotASlopeError, Slices
from reference.slice_methods import THICKNESS_LEAST, solve_bishop, solve_spencer

SPENCER_NEAR_BISHOP = 0.3
Method = Literal["bishop", "spencer"]


@dataclass(frozen=True)
class Arcs:
    """Lower arcs of circles: ends (m, 1) with x_toe < x_crest, centre and radius (m, 1) [m]."""

    x_toe: Array
    x_crest: Array
    x_centre: Array
    y_centre: Array
    radius: Array

    def level(self, x: Array) -> Array:
        """Level y of the arcs at x (m, n) [m]."""
        return self.y_centre - np.sqrt(np.clip(self.radius**2 - (x - self.x_centre) ** 2, 0.0, None))

    def even_edges(self, n: int) -> Array:
        """Slice sides (m, n + 1) of chords of equal length, which serve the steep end best [m]."""
        first = np.arcsin(np.clip((self.x_toe - self.x_centre) / self.radius, -1.0, 1.0))
        last = np.arcsin(np.clip((self.x_crest - self.x_centre) / self.radius, -1.0, 1.0))
        x = self.x_centre + self.radius * np.sin(first + (last - first) * np.linspace(0.0, 1.0, n + 1))
        x[:, :1], x[:, -1:] = self.x_toe, self.x_crest
        return np.maximum.accumulate(x, axis=1)


def arcs_through(toe: Array, crest: Array, share: Array) -> tuple[Arcs, NDArray[np.bool_]]:
    """Arcs (m,) through toe (m, 2) and crest (m, 2); share 0..1 of the greatest central angle.

    The arc is steepest, upright, at the crest for share 1; it dips by 70 degrees at most at the toe.
    """
    dx, dy = (crest - toe).T
    chord = np.hypot(dx, dy)
    tilt = np.arctan2(dy, dx)
    half_angle = share * np.minimum(0.5 * np.pi - tilt, tilt + np.radians(70.0))
    sound = (dx > 0.0) & (half_angle > 1e-3) & (chord > 0.0)
    half_angle = np.where(sound, half_angle, 0.1)
    chord = np.where(sound, chord, 1.0)
    radius = chord / (2.0 * np.sin(half_angle))
    drop = radius * np.cos(half_angle)
    x_centre = 0.5 * (toe[:, 0] + crest[:, 0]) - drop * np.sin(tilt)
    y_centre = 0.5 * (toe[:, 1] + crest[:, 1]) + drop * np.cos(tilt)
    columns = (toe[:, 0], crest[:, 0], x_centre, y_centre, radius)
    return Arcs(*(column[:, None] for column in columns)), sound


def follow(ground: Ground, arcs: Arcs, x: Array, composite: bool) -> tuple[Array, NDArray[np.bool_]]:
    """Level of the surface at x, and which masses may be used; without composite none leaves the section."""
    y, floor = arcs.level(x), ground.bottom(x)
    if composite:
        return np.maximum(y, floor), np.ones(len(x), dtype=bool)
    return y, np.all(y >= floor - ground.tolerance, axis=1)


def admissible(ground: Ground, slices: Slices, spare: float = 1.0) -> NDArray[np.bool_]:
    """Which masses (m,) lie in the ground and are thick enough, by a factor `spare`."""
    # Outlines traced from pictures are rough by so much.
    slack = 1e-3 * ground.height
    real = slices.width > 0.0
    inside = np.all((slices.height >= -slack) | ~real, axis=1)
    return inside & (np.max(slices.height, axis=1) >= spare * THICKNESS_LEAST * ground.height)


def exact_edges(ground: Ground, arcs: Arcs, n: int) -> Array:
    """Sides (1, k) of at least n slices of one arc that end wherever the arc meets a layer or a bend [m]."""
    pieces = ground.boundaries()
    x1, y1, x2, y2 = pieces.T
    slope = (y2 - y1) / (x2 - x1)
    xc, yc, radius = (float(v[0, 0]) for v in (arcs.x_centre, arcs.y_centre, arcs.radius))
    # (x - xc)^2 + (y1 + slope (x - x1) - yc)^2 = radius^2
    offset = y1 - slope * x1 - yc
    a, b, c = 1.0 + slope**2, slope * offset - xc, xc**2 + offset**2 - radius**2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * c)
    meets = np.concatenate([(-b - root) / a, (-b + root) / a])
    inside = (meets >= np.tile(x1, 2)) & (meets <= np.tile(x2, 2))
    x = np.concatenate([ground.breaks(), meets[inside]])
    x = x[(x > arcs.x_toe[0, 0]) & (x < arcs.x_crest[0, 0])]
    return np.unique(np.concatenate([x, arcs.even_edges(n)[0]]))[None, :]


def circle_of(ground: Ground, circle: tuple[float, float, float]) -> Arcs:
    """The arc that cuts the largest mass off ground that rises towards +x."""
    xc, yc, radius = circle
    x1, y1 = ground.surface[:-1].T
    x2, y2 = ground.surface[1:].T
    ex, ey, fx, fy = x2 - x1, y2 - y1, x1 - xc, y1 - yc
    a, b, c = ex**2 + ey**2, fx * ex + fy * ey, fx**2 + fy**2 - radius**2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * c)
    share = np.concatenate([(-b - root) / a, (-b + root) / a])
    on = (share >= 0.0) & (share <= 1.0)
    x = (np.tile(x1, 2) + share * np.tile(ex, 2))[on]
    y = (np.tile(y1, 2) + share * np.tile(ey, 2))[on]
    order = np.argsort(x)
    ends = [(float(x[i]), float(y[i])) for i in order if y[i] <= yc + ground.tolerance]
    best, found = 0.0, None
    for (x_toe, y_toe), (x_crest, y_crest) in itertools.pairwise(ends):
        if x_crest - x_toe <= ground.tolerance or y_crest <= y_toe:
            continue
        arcs = Arcs(*(np.array([[v]]) for v in (x_toe, x_crest, xc, yc, radius)))
        edges = exact_edges(ground, arcs, 50)
        cut = ground.slices(edges, arcs.level(edges))
        area = float(np.sum(cut.height * cut.width))
        if area > best:
            best, found = area, arcs
    if found is None:
        raise NotASlopeError(
            f"the circle about ({xc:.6g}, {yc:.6g}) m of radius {radius:.6g} m cuts no slope"
        )
    return found


def solve(
    method: Method, slices: Slices, arcs: Arcs, *, tolerance: float, spare: float = 1.0
) -> tuple[Array, Array | None, Array]:
    """Factor (m,), inclination (m,) or None, normal forces (m, n) of the masses above arcs."""
    factor, normal = solve_bishop(slices, arcs.x_centre, arcs.y_centre, tolerance=tolerance, spare=spare)
    if method == "bishop":
        return factor, None, normal
    first = factor
    factor, inclination, normal = solve_spencer(
        slices, (arcs.x_centre, arcs.y_centre), first, tolerance=tolerance, spare=spare
    )
    # The two equations of Spencer's method have further roots without meaning; on a circle the moments of
    # both methods agree but for the normal forces, so that the true one is never far from Bishop's.
    near = ~(np.abs(factor - first) > SPENCER_NEAR_BISHOP * first)
    return np.where(near, factor, np.nan), inclination, normal


def exact(
    ground: Ground, arcs: Arcs, method: Method, n: int, composite: bool
) -> tuple[float, float | None, Array, Slices, Array]:
    """Factor, inclination, surface (k, 2), slices and normal forces of one arc."""
    x = exact_edges(ground, arcs, n)
    y, allowed = follow(ground, arcs, x, composite)
    cut = ground.slices(x, y)
    factor, inclination, normal = solve(method, cut, arcs, tolerance=1e-10)
    good = bool(allowed[0] and admissible(ground, cut)[0])
    value = float(factor[0]) if good else float("nan")
    tilt = None if inclination is None else float(inclination[0])
    return value, tilt, np.column_stack([x[0], y[0]]), cut, normal
