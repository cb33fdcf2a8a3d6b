"""Straight lines through the points of outlines: where one ends, and where it runs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

_CORNER_POINTS = 2  # points next to a corner see both of its sides
_FEW = 3
_BREAK_REACH = 6
_STEPPED = 0.5  # a larger tolerance is that of stairs [px]
_BENT_BY_CHANCE = 0.75  # how far a stair of one or two steps may seem to bend [px]
_BEND = 1.0  # how far a bend may leave the line at the ends of a run, as a part of the tolerance


@dataclass
class Line:
    """A straight line: ``normal . (x, y) = offset`` [px].

    Parameters
    ----------
    normal, direction : ndarray of float64, shape (2,)
        Unit vectors.
    centre : ndarray of float64, shape (2,)
        Mean of the points [px].
    offset : float
        Distance from the origin [px].
    span : float
        Length over which there are points [px].
    count : int
        Number of points.
    fixed : dict of int to float
        The coordinate (0: x, 1: y) that the line holds constant, where it is upright or level.
    """

    normal: NDArray[np.float64]
    direction: NDArray[np.float64]
    centre: NDArray[np.float64]
    offset: float
    span: float
    count: int
    fixed: dict[int, float] = field(default_factory=dict)

    def hold(self, axis: int, value: float) -> None:
        """Make the line upright (axis 0) or level (axis 1) at the given coordinate."""
        self.normal = np.eye(2)[axis]
        self.direction = np.eye(2)[1 - axis]
        self.offset = value
        self.fixed = {axis: value}


def fit_line(points: NDArray[np.float64]) -> Line:
    """Line of least squared distances (total least squares); of a single point, a level one."""
    centre = points.mean(axis=0)
    away = points - centre
    xx, yy, xy = (away[:, 0] ** 2).sum(), (away[:, 1] ** 2).sum(), (away[:, 0] * away[:, 1]).sum()
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    direction = np.array([math.cos(angle), math.sin(angle)])
    normal = np.array([-direction[1], direction[0]])
    along = away @ direction
    return Line(normal, direction, centre, float(normal @ centre), float(np.ptp(along)), len(points))


def trimmed(first: int, last: int) -> slice:
    """Points first..last without those next to the corners, where enough remain."""
    count = last - first + 1
    cut = _CORNER_POINTS if count >= 14 else 1 if count >= 5 else 0
    return slice(first + cut, last + 1 - cut)


def best_line(points: NDArray[np.float64], tolerance: NDArray[np.float64]) -> tuple[Line, float]:
    """Fitted line, and the largest distance from it as a part of the tolerance.

    A straight edge drawn without blending has all its points within half a pixel; with a single step near one
    end the line of least squares leaves that end by nearly a pixel. Then the middle of the narrowest strip
    that holds all points is taken.
    """
    line = fit_line(points)
    if len(points) <= 2:
        return line, 0.0
    worst = _worst(line, points, tolerance)
    if worst > 1.0 and float(tolerance.max()) > _STEPPED:
        middle = _strip(points, line)
        other = _worst(middle, points, tolerance)
        if other < worst:
            return middle, other
    return line, worst


def _worst(line: Line, points: NDArray[np.float64], tolerance: NDArray[np.float64]) -> float:
    return float((np.abs(points @ line.normal - line.offset) / tolerance).max())


def _strip(points: NDArray[np.float64], line: Line) -> Line:
    """Middle of the narrowest strip that holds all points; one of its sides runs along their convex hull."""
    import shapely

    hull = shapely.convex_hull(shapely.MultiPoint(points))
    if hull.geom_type != "Polygon":
        return line
    corners = shapely.get_coordinates(hull)
    side = np.diff(corners, axis=0)
    length = np.hypot(*side.T)
    normals = np.stack([-side[:, 1], side[:, 0]], axis=1) / length[:, None]
    across = (corners[None, :-1] - corners[:-1, None]) @ normals[:, :, None]
    low, high = across[..., 0].min(axis=1), across[..., 0].max(axis=1)
    best = int(np.argmin(high - low))
    normal = normals[best]
    offset = float(normal @ corners[best]) + 0.5 * float(low[best] + high[best])
    direction = np.array([normal[1], -normal[0]])
    centre = line.centre + normal * (offset - float(normal @ line.centre))
    return Line(normal, direction, centre, offset, float(np.ptp(points @ direction)), line.count)


def misfit(points: NDArray[np.float64], tolerance: NDArray[np.float64], whole: float = 0.0) -> float:
    """Largest distance from the best line, as a part of the tolerance.

    ``whole`` is the length of the run [px] where the points next to its corners were left out: a steady bend
    is carried on to there, so that a curve is cut where its chord would leave it.
    """
    _, worst = best_line(points, tolerance)
    if len(points) >= 6 and whole > 0.0:
        line = fit_line(points)
        along = (points - line.centre) @ line.direction
        bend = along**2 - (along**2).mean()
        away = points @ line.normal - line.offset
        # the ends of a shallow arc lie 2/3 of its height off the line that fits it best
        end = abs(float(away @ bend) / float(bend @ bend)) * (whole / 2.0) ** 2 * 2.0 / 3.0
        allowed = _BEND * float(tolerance.mean())
        if allowed > _STEPPED:
            steps = line.span * float(np.abs(line.direction).min())
            allowed = _STEPPED if steps >= 2.0 else _BENT_BY_CHANCE
        worst = max(worst, end / allowed)
    return worst


def split_into_lines(
    points: NDArray[np.float64], tolerance: NDArray[np.float64], closed: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[tuple[int, int]]]:
    """Cut a row of points into few straight runs.

    The row is split where it is farthest from its chord (Ramer 1972, Douglas and Peucker 1973) until every
    run fits a line; then runs are joined while the joint line still fits, and the cuts are moved to where the
    two lines fit best.

    Returns
    -------
    points, tolerance : ndarray
        As given; a closed row starts at a corner.
    runs : list of (int, int)
        First and last point of each run.
    """
    if closed:
        # the point farthest from the middle is near a corner, if there is one
        start = int(np.argmax(((points - points.mean(axis=0)) ** 2).sum(axis=1)))
        points, tolerance = np.roll(points, -start, axis=0), np.roll(tolerance, -start)
    runs = _split(points, tolerance)
    runs = _join(points, tolerance, runs)
    runs = _drop_corner_crumbs(points, runs)
    for _ in range(2):
        runs = _move_cuts(points, runs)
    runs = _join(points, tolerance, runs)
    runs = _move_cuts(points, runs)
    if closed and len(runs) > 3:
        points, tolerance, runs = _close(points, tolerance, runs)
    return points, tolerance, runs


def _split(points: NDArray[np.float64], tolerance: NDArray[np.float64]) -> list[tuple[int, int]]:
    runs: list[tuple[int, int]] = []
    pending = [(0, len(points) - 1)]
    while pending:
        first, last = pending.pop()
        part = trimmed(first, last)
        length = float(np.hypot(*(points[last] - points[first])))
        closed = length < 0.25 * (last - first)
        if last - first < 2 or (not closed and misfit(points[part], tolerance[part], length) <= 1.0):
            runs.append((first, last))
            continue
        chord = points[last] - points[first]
        away = points[first + 1 : last] - points[first]
        if closed or length < 1e-9:
            distance = np.hypot(*away.T)
        else:
            distance = np.abs(away @ np.array([-chord[1], chord[0]])) / length
        cut = first + 1 + int(np.argmax(distance / tolerance[first + 1 : last]))
        pending += [(cut, last), (first, cut - 1)] if cut - first >= 2 else [(cut, last), (first, cut)]
    return _in_order(runs)


def _in_order(runs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Runs that follow each other without a common point."""
    result: list[tuple[int, int]] = []
    for first, last in sorted(runs):
        begin = max(first, result[-1][1] + 1) if result else first
        if begin <= last:
            result.append((begin, last))
    return result


def _join(
    points: NDArray[np.float64], tolerance: NDArray[np.float64], runs: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    def joint(k: int) -> float:
        first, last = runs[k][0], runs[k + 1][1]
        length = float(np.hypot(*(points[last] - points[first])))
        if length < 0.5 * (last - first):
            return math.inf  # it turns back
        part = trimmed(first, last)
        return misfit(points[part], tolerance[part], length)

    runs = list(runs)
    cost = [joint(k) for k in range(len(runs) - 1)]
    while cost and min(cost) <= 1.0:
        k = cost.index(min(cost))
        runs[k : k + 2] = [(runs[k][0], runs[k + 1][1])]
        del cost[k]
        for near in (k - 1, k):
            if 0 <= near < len(cost):
                cost[near] = joint(near)
    return runs


def _drop_corner_crumbs(points: NDArray[np.float64], runs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Take away short runs that only round off the corner between two long ones."""
    result = list(runs)
    k = 1
    while k < len(result) - 1:
        before, crumb, after = result[k - 1], result[k], result[k + 1]
        short = crumb[1] - crumb[0] < _FEW
        long = min(before[1] - before[0], after[1] - after[0]) >= 5
        if short and long:
            lines = [fit_line(points[trimmed(*run)]) for run in (before, after)]
            corner = crossing(lines[0], lines[1])
            middle = points[crumb[0] : crumb[1] + 1].mean(axis=0)
            if corner is not None and np.hypot(*(corner - middle)) <= 1.5:
                cut = (crumb[0] + crumb[1] + 1) // 2
                result[k - 1 : k + 2] = [(before[0], cut - 1), (cut, after[1])]
                continue
        k += 1
    return result


def _move_cuts(points: NDArray[np.float64], runs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Move every cut by a few points to where the two lines beside it fit best."""
    centred = points - points.mean(axis=0)
    x, y = centred.T
    sums = np.zeros((len(points) + 1, 5))
    sums[1:] = np.cumsum(np.stack([x, y, x * x, y * y, x * y], axis=1), axis=0)

    def squares(first: int, end: int) -> float:
        count = end - first
        sx, sy, sxx, syy, sxy = sums[end] - sums[first]
        xx, yy, xy = sxx - sx * sx / count, syy - sy * sy / count, sxy - sx * sy / count
        return float(0.5 * (xx + yy) - math.hypot(0.5 * (xx - yy), xy))

    result = list(runs)
    for k in range(len(result) - 1):
        first, cut, end = result[k][0], result[k + 1][0], result[k + 1][1] + 1
        low, high = max(first + 2, cut - _BREAK_REACH), min(end - 2, cut + _BREAK_REACH)
        choices = sorted(range(low, high + 1), key=lambda c: abs(c - cut))
        if choices:
            best = min(choices, key=lambda c: squares(first, c) + squares(c, end))
            result[k], result[k + 1] = (first, best - 1), (best, end - 1)
    return result


def _close(
    points: NDArray[np.float64], tolerance: NDArray[np.float64], runs: list[tuple[int, int]]
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[tuple[int, int]]]:
    """Mend the start of a ring: begin at the cut in its middle and treat the old start as any other cut."""
    turn = runs[len(runs) // 2][0]
    count = len(points)
    points, tolerance = np.roll(points, -turn, axis=0), np.roll(tolerance, -turn)
    runs = sorted(((first - turn) % count, (last - turn) % count) for first, last in runs)
    runs = _drop_corner_crumbs(points, _join(points, tolerance, runs))
    return points, tolerance, _move_cuts(points, _join(points, tolerance, _move_cuts(points, runs)))


def crossing(one: Line, other: Line) -> NDArray[np.float64] | None:
    """Where two lines cross, upright and level ones exactly; None where they are parallel."""
    determinant = one.normal[0] * other.normal[1] - one.normal[1] * other.normal[0]
    if abs(determinant) < 1e-3:
        return None
    point = np.array(
        [
            (one.offset * other.normal[1] - other.offset * one.normal[1]) / determinant,
            (one.normal[0] * other.offset - other.normal[0] * one.offset) / determinant,
        ]
    )
    for line in (one, other):
        for axis, value in line.fixed.items():
            point[axis] = value
    return point


def meeting(
    lines: list[Line], near: NDArray[np.float64], limit: float, frame: dict[int, float] | None = None
) -> NDArray[np.float64]:
    """Point closest to several lines, not far from ``near``.

    Parameters
    ----------
    lines : list of Line
        At least one; those with many points weigh more.
    near : ndarray of float64, shape (2,)
        Where the point is to a pixel or so [px].
    limit : float
        How far it may lie from there [px].
    frame : dict of int to float, optional
        Coordinates that the edge of the picture prescribes [px].
    """
    held: dict[int, float] = {}
    for line in sorted(lines, key=lambda line: -line.span):
        for axis, value in line.fixed.items():
            held.setdefault(axis, value)
    held.update(frame or {})
    for softness in (1e-4, 0.02, 0.3, 10.0):
        matrix = softness * np.eye(2)
        right = softness * near
        for line in lines:
            weight = min(line.count, 20) / 20.0
            matrix += weight * np.outer(line.normal, line.normal)
            right = right + weight * line.offset * line.normal
        free = [axis for axis in (0, 1) if axis not in held]
        point = np.array([held.get(0, 0.0), held.get(1, 0.0)])
        if free:
            rest = right[free] - matrix[np.ix_(free, list(held))] @ np.array(list(held.values()))
            point[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        if np.hypot(*(point - near)) <= limit:
            return point
    point = near.copy()
    for axis, value in (frame or {}).items():
        point[axis] = value
    return point
