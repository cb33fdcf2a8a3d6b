"""The moving mass of a failed slope and the surface it slides on, read off the displacements.

At failure the ground parts into a mass that moves and ground that stays. The displacement jumps across the
shear band between them, so that a level of its magnitude between the two clusters marks the band: the slip
surface is the contour of that level, traced through the triangles. Where the level lies between the clusters
hardly matters, since the contours crowd together inside the band.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.integer]

SHARE = 0.5
"""Share of the moving mass's typical displacement at which the contour is drawn: the middle of the jump."""

NOTHING = 1e-9
"""Displacements below this share of the section's size are rounding, not movement."""


class MovingMass(NamedTuple):
    """What moves and where it parts from the ground that stays.

    moving (n,) bool; slip_surface (k, 2) [m], from crest to toe, k = 0 where nothing parts; area [m2];
    threshold [m], the displacement at which the two part.
    """

    moving: NDArray[np.bool_]
    slip_surface: Floats
    area: float
    threshold: float


def moving_mass(
    positions: Floats,
    triangles: Integers,
    displacement: Floats,
    plastic_shear_strain: Floats | None = None,
    *,
    share: float = SHARE,
) -> MovingMass:
    """Find the largest connected mass that moves, and the surface between it and the ground that stays.

    Parameters
    ----------
    positions : (n, 2) [m]
        Particle centres, y upwards.
    triangles : (m, 3) integers
        Indices of particles.
    displacement : (n, 2) [m]
        From the settled state.
    plastic_shear_strain : (n,) [-], optional
        Where given and zero everywhere, nothing has yielded and nothing is taken to slide.
    share : float [-]
        Contour level over the typical displacement of what moves; between 0 and 1.

    Returns
    -------
    MovingMass
        Nothing moves: no particle, an empty surface, zero area. Everything moves as one body: every particle,
        an empty surface.

    Notes
    -----
    The two clusters are told apart by Otsu's threshold on the magnitude, weighted by particle area so that a
    locally finer packing does not tilt it; the level is then moved to `share` of the upper quartile of the
    upper cluster until it no longer changes (the quartile, since particles inside the band drag the median
    down, and since a few that have come loose decide the maximum). N. Otsu 1979, IEEE Transactions on
    Systems, Man, and Cybernetics 9:62-66.
    """
    triangles = np.asarray(triangles)
    magnitude = np.hypot(displacement[:, 0], displacement[:, 1])
    none = MovingMass(np.zeros(len(positions), dtype=bool), np.empty((0, 2)), 0.0, np.nan)
    size = float(np.ptp(positions, axis=0).max()) if len(positions) else 0.0
    if not len(triangles) or not np.isfinite(magnitude).all() or magnitude.max() <= NOTHING * size:
        return none
    if plastic_shear_strain is not None and not np.any(plastic_shear_strain > 0.0):
        return none

    area = triangle_areas(positions, triangles)
    weight = np.zeros(len(positions))
    np.add.at(weight, triangles, area[:, None] / 3.0)
    threshold = _threshold(magnitude, weight, share)
    moving = _largest_part(magnitude > threshold, triangles, weight)
    if not moving.any():
        return none
    surface = _contour(positions, triangles, magnitude, moving, threshold)
    spacing = float(np.sqrt(np.median(area) * 4.0 / np.sqrt(3.0)))
    return MovingMass(
        moving,
        _smooth(surface, spacing),
        _area_above(area, triangles, magnitude, moving, threshold),
        threshold,
    )


def shear_band_distance(
    positions: Floats, triangles: Integers, plastic_shear_strain: Floats, slip_surface: Floats
) -> float:
    """Mean distance between the slip surface and the ridge of plastic shear strain beside it [m].

    Both come from different fields of the same state, so that a small distance confirms the surface. The
    ridge is looked for along the normals of the surface, up to four mean triangle sides to each side.

    Parameters
    ----------
    positions : (n, 2) [m]
    triangles : (m, 3) integers
    plastic_shear_strain : (n,) [-]
    slip_surface : (k, 2) [m]

    Returns
    -------
    float
        NaN where there is no surface or no strain along it.
    """
    if len(slip_surface) < 3:
        return float("nan")
    spacing = float(np.sqrt(np.median(triangle_areas(positions, np.asarray(triangles))) * 4.0 / np.sqrt(3.0)))
    tangent = np.gradient(slip_surface, axis=0)
    tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    reach = np.linspace(-4.0 * spacing, 4.0 * spacing, 65)
    points = slip_surface[:, None, :] + reach[None, :, None] * normal[:, None, :]
    strain = interpolated(positions, np.asarray(triangles), plastic_shear_strain, points.reshape(-1, 2))
    strain = strain.reshape(points.shape[:2])
    top = strain.max(axis=1)
    seen = top > 0.05 * top.max()
    if not seen.any():
        return float("nan")
    return float(np.abs(reach[strain[seen].argmax(axis=1)]).mean())


def interpolated(positions: Floats, triangles: Integers, values: Floats, points: Floats) -> Floats:
    """Values (n,) at particles, linear over their triangles, at points (k, 2); zero outside of the ground."""
    import shapely

    corners = positions[triangles]
    # a tree of boxes: walking from triangle to triangle may take seconds where their sizes are graded
    tree = shapely.STRtree(shapely.polygons(corners))
    point, triangle = tree.query(shapely.points(points), predicate="intersects")
    point, first = np.unique(point, return_index=True)
    triangle = triangle[first]
    a, b, c = (corners[triangle, corner] for corner in range(3))
    at = points[point]
    weight_b = _cross(at - a, c - a) / _cross(b - a, c - a)
    weight_c = _cross(b - a, at - a) / _cross(b - a, c - a)
    of_a, of_b, of_c = (values[triangles[triangle, corner]] for corner in range(3))
    found = np.zeros(len(points))
    found[point] = of_a + weight_b * (of_b - of_a) + weight_c * (of_c - of_a)
    return found


def _cross(u: Floats, v: Floats) -> Floats:
    area: Floats = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return area


def triangle_areas(positions: Floats, triangles: Integers) -> Floats:
    """Areas (m,) [m2] of triangles (m, 3) over positions (n, 2) [m], positive whichever way they turn."""
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    return 0.5 * np.abs((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def _threshold(magnitude: Floats, weight: Floats, share: float) -> float:
    """Displacement [m] between the cluster that stays and the one that moves."""
    order = np.argsort(magnitude, kind="stable")
    value, mass = magnitude[order], weight[order]
    below = np.cumsum(mass)[:-1]
    above = below[-1] + mass[-1] - below
    first = np.cumsum(mass * value)
    mean_below = first[:-1] / np.maximum(below, 1e-300)
    mean_above = (first[-1] - first[:-1]) / np.maximum(above, 1e-300)
    cut = int(np.argmax(below * above * (mean_above - mean_below) ** 2))
    threshold = 0.5 * (value[cut] + value[cut + 1])
    for _ in range(20):
        moves = value > threshold
        if not moves.any():  # one cluster only: a body that moves as one
            return float(share * value[-1])
        typical = float(value[moves][np.searchsorted(np.cumsum(mass[moves]), 0.75 * mass[moves].sum())])
        if abs(share * typical - threshold) <= 1e-3 * threshold:
            break
        threshold = share * typical
    return float(threshold)


def _largest_part(moving: NDArray[np.bool_], triangles: Integers, weight: Floats) -> NDArray[np.bool_]:
    """Of the moving particles, those of the largest connected part (by area)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = ends[moving[ends].all(axis=1)]
    count = len(moving)
    graph = coo_array((np.ones(len(ends), dtype=np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    area = np.bincount(label, weights=weight * moving)
    return moving & (label == int(area.argmax()))


def _contour(
    positions: Floats, triangles: Integers, magnitude: Floats, moving: NDArray[np.bool_], threshold: float
) -> Floats:
    """The longest open contour between moving and staying particles (k, 2) [m], its higher end first.

    Open contours end on edges that only one triangle has, that is on the outline of the section; closed ones
    are islands inside the moving mass.
    """
    inside = moving[triangles]
    corners = inside.sum(axis=1)
    crossed = np.flatnonzero((corners == 1) | (corners == 2))
    # the corner that stands alone on its side; both crossings lie on its two edges
    lone = np.where(corners[crossed] == 1, inside[crossed].argmax(axis=1), (~inside[crossed]).argmax(axis=1))
    rows = triangles[crossed]
    pick = np.arange(len(crossed))
    apex = rows[pick, lone]
    links: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for tip, one, two in zip(
        apex.tolist(), rows[pick, (lone + 1) % 3].tolist(), rows[pick, (lone + 2) % 3].tolist(), strict=True
    ):
        left, right = (min(tip, one), max(tip, one)), (min(tip, two), max(tip, two))
        links.setdefault(left, []).append(right)
        links.setdefault(right, []).append(left)

    best, best_length = np.empty((0, 2)), 0.0
    used: set[tuple[int, int]] = set()
    for start, neighbours in links.items():
        if len(neighbours) != 1 or start in used:
            continue
        chain, previous = [start], start
        following: tuple[int, int] | None = neighbours[0]
        while following is not None:
            chain.append(following)
            onward = [edge for edge in links[following] if edge != previous]
            previous, following = following, onward[0] if onward else None
        used.update((chain[0], chain[-1]))
        ends = np.array(chain)
        low, high = magnitude[ends[:, 0]], magnitude[ends[:, 1]]
        along = np.clip((threshold - low) / (high - low), 0.0, 1.0)[:, None]
        line = positions[ends[:, 0]] * (1.0 - along) + positions[ends[:, 1]] * along
        length = float(np.hypot(*np.diff(line, axis=0).T).sum())
        if length > best_length:
            best, best_length = line, length
    return best[::-1] if len(best) and best[0, 1] < best[-1, 1] else best


def _smooth(line: Floats, spacing: float) -> Floats:
    """The line at even arc lengths, without the teeth that come from the triangles; the ends stay."""
    if len(line) < 3:
        return line
    from scipy.ndimage import gaussian_filter1d

    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    count = max(int(np.ceil(2.0 * length[-1] / spacing)) + 1, 5)
    even = np.linspace(0.0, length[-1], count)
    sampled = np.column_stack([np.interp(even, length, line[:, axis]) for axis in range(2)])
    # reflected through its ends (point reflection), the line keeps them and their direction
    pad = min(count - 1, 12)
    before = 2.0 * sampled[0] - sampled[pad:0:-1]
    after = 2.0 * sampled[-1] - sampled[-2 : -pad - 2 : -1]
    whole = np.concatenate([before, sampled, after])
    smooth = gaussian_filter1d(whole, sigma=3.0, axis=0, mode="nearest", truncate=4.0)[pad:-pad]
    smooth[0], smooth[-1] = sampled[0], sampled[-1]
    return smooth


def _area_above(
    area: Floats, triangles: Integers, magnitude: Floats, moving: NDArray[np.bool_], threshold: float
) -> float:
    """Area [m2] of the moving mass, triangles cut where the contour cuts them."""
    inside = moving[triangles]
    corners = inside.sum(axis=1)
    total = float(area[corners == 3].sum())
    for alone, sign in ((1, 1.0), (2, -1.0)):
        rows = np.flatnonzero(corners == alone)
        if not len(rows):
            continue
        side = inside[rows] if alone == 1 else ~inside[rows]
        lone = side.argmax(axis=1)
        value = magnitude[triangles[rows]]
        tip = np.take_along_axis(value, lone[:, None], axis=1)[:, 0]
        cut = np.ones(len(rows))
        for step in (1, 2):
            other = np.take_along_axis(value, ((lone + step) % 3)[:, None], axis=1)[:, 0]
            cut *= np.clip((tip - threshold) / (tip - other), 0.0, 1.0)
        share = cut if sign > 0 else 1.0 - cut
        total += float((area[rows] * share).sum())
    return total
