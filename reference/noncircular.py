"""Slip surfaces that are no circles: Spencer's method on given points, and a search for the critical block.

A block slides along a layer: a ramp up to the ground in front, a run along the layer, a scarp behind. The
search starts with such surfaces along the middle of each layer and moves their points by an evolution
strategy with a fixed seed, as far as the surface stays kinematically admissible: it may only steepen from toe
to crest. Idea of the random search: V.R. Greco, Efficient Monte Carlo technique for locating critical slip
surface, Journal of Geotechnical Engineering 122 (1996).

Surfaces with many free points are not searched on purpose. One inclination for all interslice forces leaves
the shear between blocks at a kink out of account, so that free points settle on surfaces with sharp kinks
whose factor lies below the limit analysis bounds: by 12 % for a 45 degree cut in clay (phi = 0) on a base one
height down.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reference.circles import admissible
from reference.ground import Array, Ground, NotASlopeError, Slices
from reference.slice_methods import Answer, remarks, solve_spencer

TITLE = "Spencer, non-circular"
KINKS = "The shear between the blocks at the kinks is left out of account: the factor errs to the low side."
STEEPEST = np.tan(np.radians(85.0))
DEEPEST_DIP = -2.0
# More boundary pieces than this and the random search looks up the soil at the middle of even slices only.
PIECES_MOST = 60


def spencer_on_points(ground: Ground, points: Array, slices: int = 50) -> Answer:
    """Spencer's method on a surface through points (n, 2) [m], from left to right or from right to left.

    Raises
    ------
    NotASlopeError
        The points do not make a surface over which each x occurs once, or the method finds no equilibrium.
    """
    if points[0, 0] > points[-1, 0]:
        points = points[::-1]
    if points.ndim != 2 or len(points) < 2 or np.any(np.diff(points[:, 0]) <= 0.0):
        raise NotASlopeError("a slip surface needs two points or more with increasing x")
    mirror = bool(points[0, 1] > points[-1, 1])
    if mirror:
        ground, points = ground.mirrored(), points[::-1] * [-1.0, 1.0]
    factor, tilt, cut, normal = _exact(ground, points, slices)
    if not np.isfinite(factor):
        raise NotASlopeError("Spencer's method finds no sound equilibrium on this surface")
    surface = points[::-1] * [-1.0, 1.0] if mirror else points
    count = int(np.count_nonzero(cut.width > 0.0))
    return Answer(TITLE, factor, None, None, surface, count, 1, tuple(remarks(ground, cut, normal)), tilt)


def _meetings(x: Array, y: Array, pieces: Array) -> Array:
    """The x (m, k) where surfaces (m, v) meet boundary pieces; their first x where they do not."""
    x1, y1, x2, y2 = pieces.T
    slope = (y2 - y1) / (x2 - x1)
    rise = np.diff(y, axis=1) / np.diff(x, axis=1)
    left, right = x[:, :-1, None], x[:, 1:, None]
    with np.errstate(all="ignore"):
        at = (y1 - slope * x1 - y[:, :-1, None] + rise[..., None] * left) / (rise[..., None] - slope)
        met = (at > left) & (at < right) & (at >= x1) & (at <= x2)
    return np.where(met, at, x[:, :1, None]).reshape(len(x), -1)


def _cut(ground: Ground, x: Array, y: Array, n: int, *, exact: bool) -> Slices:
    """Slices of surfaces (m, v), n even parts in each leg; exact ones end at every layer and bend."""
    share = np.arange(n) / n
    even = (x[:, :-1, None] + np.diff(x, axis=1)[..., None] * share).reshape(len(x), -1)
    edges = np.hstack([even, x[:, -1:]])
    if exact:
        breaks = np.clip(ground.breaks()[None, :], x[:, :1], x[:, -1:])
        edges = np.sort(np.hstack([edges, breaks, _meetings(x, y, ground.boundaries())]), axis=1)
    leg = np.minimum((edges[:, :, None] >= x[:, None, 1:]).sum(axis=2), x.shape[1] - 2)
    left, right = np.take_along_axis(x, leg, axis=1), np.take_along_axis(x, leg + 1, axis=1)
    low, high = np.take_along_axis(y, leg, axis=1), np.take_along_axis(y, leg + 1, axis=1)
    return ground.slices(edges, low + (high - low) * (edges - left) / (right - left))


def _solve(ground: Ground, cut: Slices, rounds: int, start: float) -> tuple[Array, Array, Array]:
    # A pole above the mass, about where the centre of a circle would be, keeps the two equations apart.
    reach = np.ptp(cut.x, axis=1)[:, None]
    pole = cut.x[:, :1] + 0.2 * reach, np.max(cut.y, axis=1)[:, None] + 0.5 * reach
    return solve_spencer(cut, pole, np.full(len(cut.x), start), tolerance=1e-6, rounds=rounds)


def _exact(ground: Ground, points: Array, slices: int) -> tuple[float, float, Slices, Array]:
    per_leg = max(2, -(-slices // (len(points) - 1)))
    x, y = points[None, :, 0], points[None, :, 1]
    cut = _cut(ground, x, y, per_leg, exact=True)
    if np.any(cut.height[cut.width > 0.0] < -1e-3 * ground.height):
        return float("nan"), float("nan"), cut, cut.height
    for start in (1.0, 1.5, 0.7, 3.0, 0.3):
        factor, tilt, normal = _solve(ground, cut, 100, start)
        if np.isfinite(factor[0]):
            return float(factor[0]), float(tilt[0]), cut, normal
    return float("nan"), float("nan"), cut, cut.height


# -- search --------------------------------------------------------------------------------------------------


def search_blocks(ground: Ground, slices: int = 50, seed: int = 1) -> Answer | None:
    """Critical block surface of a layered section by Spencer's method: ramp, run along a layer, scarp.

    Parameters
    ----------
    slices : int
        Least number of slices of the final surface.
    seed : int
        Of the random moves.

    Returns
    -------
    Answer or None
        None where the section has one material only, or no block can slide.
    """
    answers, tried = [], 0
    for mirror in (False, True):
        facing = ground.mirrored() if mirror else ground
        hunt = _Hunt(facing, seed)
        for points in hunt.run():
            try:
                answer = spencer_on_points(facing, points, slices)
            except NotASlopeError:
                continue
            answers.append(replace(answer, surface=answer.surface[::-1] * [-1.0, 1.0]) if mirror else answer)
        tried += hunt.tried
    if not answers:
        return None
    best = min(answers, key=lambda answer: answer.factor)
    return replace(best, circles_tried=tried, notes=(*best.notes, KINKS))


class _Hunt:
    """Random search in ground that slides towards -x. A surface is v points (v, 2), ends on the ground."""

    def __init__(self, ground: Ground, seed: int) -> None:
        self.ground = ground
        self.random = np.random.default_rng(seed)
        self.start = 1.3
        step = np.hypot(*np.diff(ground.surface, axis=0).T)
        self.along = np.concatenate([[0.0], np.cumsum(step)])
        self.exact = len(ground.boundaries()) <= PIECES_MOST
        self.tried = 0

    def run(self) -> list[Array]:
        """The best surfaces found, from separate starts."""
        blocks = self.blocks()
        if not len(blocks):
            return []
        value = self.factors(blocks)
        found = []
        for i in np.argsort(value, kind="stable")[:2]:
            if np.isfinite(value[i]):
                self.start = float(value[i])
                found.append(self.improve(blocks[i], rounds=80))
        return found

    def factors(self, points: Array) -> Array:
        """Factors (m,) of surfaces (m, v, 2); infinite where refused."""
        x, y = points[..., 0], points[..., 1]
        with np.errstate(all="ignore"):
            rise = np.diff(y, axis=1) / np.diff(x, axis=1)
        sound = np.all(np.diff(x, axis=1) > 1e-3 * self.ground.height, axis=1)
        with np.errstate(all="ignore"):
            sound &= np.all(np.diff(rise, axis=1) >= -1e-6, axis=1)
            sound &= (rise[:, 0] >= DEEPEST_DIP) & (rise[:, -1] <= STEEPEST)
        result = np.full(len(points), np.inf)
        usable = np.flatnonzero(sound)
        for first in range(0, len(usable), 200):
            rows = usable[first : first + 200]
            cut = _cut(self.ground, x[rows], y[rows], 14, exact=self.exact)
            value = _solve(self.ground, cut, 15, self.start)[0]
            allowed = admissible(self.ground, cut) & np.isfinite(value)
            result[rows] = np.where(allowed, value, np.inf)
        self.tried += int(np.count_nonzero(sound))
        return result

    def improve(self, points: Array, rounds: int, children: int = 64) -> Array:
        """Move points at random; the best child of a round becomes the parent where it is better."""
        best = float(self.factors(points[None])[0])
        size = 0.1 * self.ground.height
        for _ in range(rounds):
            if size < 3e-4 * self.ground.height:
                break
            trial = self.moved(points, children, size)
            value = self.factors(trial)
            winner = int(np.argmin(value))
            if value[winner] < best:
                points, best, size = (
                    trial[winner],
                    float(value[winner]),
                    min(1.3 * size, 0.2 * self.ground.height),
                )
            else:
                size *= 0.75
        return points

    def moved(self, points: Array, children: int, size: float) -> Array:
        """Children (m, v, 2) of a surface, repaired to be admissible where that is possible."""
        v = len(points)
        # Half of the children move all points, half move few: a run along a thin layer leaves it only as a
        # whole, while ramp and scarp turn about one end.
        mask = (
            self.random.random((children, v, 1)) < np.where(np.arange(children) % 2, 0.25, 1.0)[:, None, None]
        )
        reach = size * 10.0 ** self.random.uniform(-1.5, 0.0, (children, 1, 1))
        trial: Array = points + mask * reach * self.random.normal(size=(children, v, 2))
        # The ends go along the ground surface.
        for end in (0, v - 1):
            s = self.along_of(points[end]) + (trial[:, end] - points[end])[:, 0]
            trial[:, end] = self.on_surface(np.clip(s, 0.0, self.along[-1]))
        x, y = trial[..., 0], np.maximum(trial[..., 1], self.ground.bottom(trial[..., 0]))
        # Convex from below: each point at most on the line through its neighbours.
        # Points out of order give nonsense here and are refused later.
        with np.errstate(all="ignore"):
            for _ in range(2 * v):
                share = (x[:, 1:-1] - x[:, :-2]) / (x[:, 2:] - x[:, :-2])
                y[:, 1:-1] = np.minimum(y[:, 1:-1], y[:, :-2] + share * (y[:, 2:] - y[:, :-2]))
        return np.stack([x, y], axis=-1)

    def on_surface(self, s: Array) -> Array:
        """Points (m, 2) of the ground surface at lengths s (m,) along it."""
        return np.column_stack([np.interp(s, self.along, self.ground.surface[:, i]) for i in (0, 1)])

    def along_of(self, point: Array) -> float:
        """Length along the ground surface to the point of it that is nearest."""
        a, b = self.ground.surface[:-1], self.ground.surface[1:]
        leg = b - a
        share = np.clip(np.sum((point - a) * leg, axis=1) / np.sum(leg * leg, axis=1), 0.0, 1.0)
        k = int(np.argmin(np.hypot(*(a + share[:, None] * leg - point).T)))
        return float(self.along[k] + share[k] * (self.along[k + 1] - self.along[k]))

    def blocks(self) -> Array:
        """Surfaces (m, 4, 2) that run along the middle of a layer with other ground over or under it."""
        found = []
        for x, y in self.ground.layer_lines():
            stations = np.linspace(x[0], x[-1], 22)[1:-1]
            levels = np.interp(stations, x, y)
            points = list(zip(stations, levels, strict=True))
            toes = [[self.hit(*point, -1.0, ramp) for ramp in (-0.15, -0.5)] for point in points]
            crests = [[self.hit(*point, 1.0, scarp) for scarp in (1.0, 1.7, 3.0)] for point in points]
            for i, j in itertools.combinations(range(len(points)), 2):
                for toe, crest in itertools.product(toes[i], crests[j]):
                    if toe is not None and crest is not None:
                        found.append([toe, points[i], points[j], crest])
        return np.array(found) if found else np.empty((0, 4, 2))

    def hit(self, x: float, y: float, way: float, slope: float) -> Array | None:
        """First point of the ground on the ray from (x, y) to the side of the sign of way, of a slope."""
        a, b = self.ground.surface[:-1], self.ground.surface[1:]
        over_a = a[:, 1] - y - slope * (a[:, 0] - x)
        over_b = b[:, 1] - y - slope * (b[:, 0] - x)
        crosses: NDArray[np.bool_] = (over_a * over_b <= 0.0) & (over_a != over_b)
        share = over_a[crosses] / (over_a[crosses] - over_b[crosses])
        points = a[crosses] + share[:, None] * (b - a)[crosses]
        ahead = points[(points[:, 0] - x) * way > 0.0]
        return None if not len(ahead) else ahead[np.argmin(np.abs(ahead[:, 0] - x))]
