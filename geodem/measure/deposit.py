"""Shape of what has run out: front, height, profile, angle of reach."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOUCHING = 0.05
"""Gap over the mean diameter up to which discs hang together."""

COLUMNS = 1.5
"""Width of a column of the profile, in mean diameters."""


class Deposit(NamedTuple):
    """Where a mass lies.

    Attributes
    ----------
    front : float
        Farthest point, in the direction of motion, of the discs that hang together with most of the others [m].
    height : float
        Greatest height above the ground below [m].
    run_out : float
        From the toe of the mass before to the front [m].
    fall_height : float
        From the highest point of the mass before to the ground at the front [m].
    reach : float
        Horizontal distance of these two [m].
    angle_of_reach : float
        Of the line between them; A. Heim's Fahrböschung [rad].
    centre : (2,) [m]
        Centre of gravity.
    travel_angle : float
        Of the line between the centres of gravity before and now; 0 where it has not moved [rad].
    profile : (k, 2) [m]
        Upper side of the mass, in the order of x.
    left_behind : float
        Share of the mass that has not come as far as half a mean diameter [-].
    loose : float
        Share of the mass that does not hang together with the rest [-].
    crest : (2,) [m]
        Highest point of the mass before.
    """

    front: float
    height: float
    run_out: float
    fall_height: float
    reach: float
    angle_of_reach: float
    centre: Floats
    travel_angle: float
    profile: Floats
    left_behind: float
    loose: float
    crest: Floats


def main_body(positions: Floats, radii: Floats) -> NDArray[np.bool_]:
    """Discs (n,) of the largest group, by area, that hangs together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    gap = TOUCHING * 2.0 * float(radii.mean())
    pairs = cKDTree(positions).query_pairs(2.0 * float(radii.max()) + gap, output_type="ndarray")
    apart = np.hypot(*(positions[pairs[:, 0]] - positions[pairs[:, 1]]).T)
    pairs = pairs[apart <= radii[pairs].sum(axis=1) + gap]
    n = len(radii)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    return np.asarray(label == np.bincount(label, radii**2).argmax())


def measure_deposit(
    positions: Floats, radii: Floats, mass: Floats, start: Floats, *, surface: Floats, downhill: float
) -> Deposit:
    """Shape of a mass of discs.

    Parameters
    ----------
    positions, start : (n, 2) [m]
        Centres now and before.
    radii, mass : (n,) [m, kg/m]
    surface : (k, 2) [m]
        Ground that was there before, what moves included, from left to right.
    downhill : float
        1 or -1: the direction of x that the mass moves in.
    """
    body = main_body(positions, radii)
    ahead = downhill * positions[:, 0] + radii
    front = float(ahead[body].max())
    toe = float((downhill * start[:, 0] + radii).max())
    crest = int(np.argmax(start[:, 1] + radii))
    top = float(start[crest, 1] + radii[crest])
    ground = float(np.interp(downhill * front, surface[:, 0], surface[:, 1]))
    fall = top - ground
    reach = front - downhill * float(start[crest, 0])
    total = float(mass.sum())
    before = (mass[:, None] * start).sum(axis=0) / total
    now = (mass[:, None] * positions).sum(axis=0) / total
    profile = upper_side(positions[body], radii[body])
    moved = np.hypot(*(positions - start).T)
    return Deposit(
        front=downhill * front,
        height=_height(positions[body], radii[body]),
        run_out=front - toe,
        fall_height=fall,
        reach=reach,
        angle_of_reach=math.atan2(fall, reach) if reach > 0.0 else 0.5 * math.pi,
        centre=now,
        travel_angle=_slope(before - now, downhill),
        profile=profile,
        left_behind=float(mass[moved < float(radii.mean())].sum()) / total,
        loose=float(mass[~body].sum()) / total,
        crest=np.array([start[crest, 0], top]),
    )


def upper_side(positions: Floats, radii: Floats) -> Floats:
    """Highest points of discs (k, 2) [m] in columns of equal width, those without discs left out."""
    width = COLUMNS * 2.0 * float(radii.mean())
    column = np.floor(positions[:, 0] / width).astype(int)
    first = int(column.min())
    top = np.full(int(column.max()) - first + 1, -np.inf)
    np.maximum.at(top, column - first, positions[:, 1] + radii)
    filled = np.flatnonzero(np.isfinite(top))
    return np.stack([(filled + first + 0.5) * width, top[filled]], axis=1)


def _height(positions: Floats, radii: Floats) -> float:
    """Greatest thickness of the columns [m]."""
    width = COLUMNS * 2.0 * float(radii.mean())
    column = np.floor(positions[:, 0] / width).astype(int)
    column -= int(column.min())
    top, low = np.full(column.max() + 1, -np.inf), np.full(column.max() + 1, np.inf)
    np.maximum.at(top, column, positions[:, 1] + radii)
    np.minimum.at(low, column, positions[:, 1] - radii)
    return float((top - low)[np.isfinite(top)].max())


def _slope(fallen: Floats, downhill: float) -> float:
    """Angle of a way that falls by fallen[1] and goes -fallen[0] downhill [rad]."""
    along = -downhill * float(fallen[0])
    return math.atan2(float(fallen[1]), along) if along > 0.0 else 0.0
