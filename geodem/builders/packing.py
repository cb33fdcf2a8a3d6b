"""Particles inside a section: irregular and dense, or on a hexagonal lattice."""

from __future__ import annotations

from typing import Any

import numpy as np

from geodem.builders.outline import Boundary, Floats, Ints, Mask, first_hits, segment_distance
from geodem.builders.size_field import FACING, SizeField

# nearer than this share of the spacing to a line, a particle would spoil the triangles that stand on the line
CLEARANCE = 0.6
# random insertion jams at 0.70 / radius^2 particles per area, an equilateral pattern has 1.155 / spacing^2;
# a little wider than the ratio of the two, so that the last few go where the gaps are widest
RADIUS = 0.80
# side of a cell of the background over the spacing: one trial a cell and round
CELL = 0.7
ROUNDS = 4


class Inside:
    """Asks whether points lie in the ground and keep clear of its lines.

    Parameters
    ----------
    ground : shapely geometry
    boundary : Boundary
    """

    def __init__(self, ground: Any, boundary: Boundary) -> None:
        import shapely
        from scipy.spatial import cKDTree

        shapely.prepare(ground)
        self.ground = ground
        self.a = boundary.positions[boundary.edges[:, 0]]
        self.b = boundary.positions[boundary.edges[:, 1]]
        self.middles = cKDTree(0.5 * (self.a + self.b))

    def clearance(self, points: Floats) -> Floats:
        """Distance [m] to the nearest line; exact below about one spacing, elsewhere a lower bound."""
        count = min(4, len(self.a))
        _, near = self.middles.query(points, k=count)
        near = near.reshape(len(points), count)
        distances = [segment_distance(points, self.a[near[:, k]], self.b[near[:, k]]) for k in range(count)]
        return np.min(distances, axis=0)

    def __call__(self, points: Floats, spacing: Floats, clearance: float = CLEARANCE) -> Mask:
        """True where a point lies in the ground and `clearance` spacings from its lines."""
        import shapely

        inside = shapely.contains_xy(self.ground, points[:, 0], points[:, 1])
        index = np.flatnonzero(inside)
        inside[index] = self.clearance(points[index]) >= clearance * spacing[index]
        return inside


def independent(points: Floats, radius: Floats, priority: Floats) -> Mask:
    """Choose points none of which lies within the other's radius, those of high priority first.

    Parameters
    ----------
    points : (n, 2) float64 [m]
    radius : (n,) float64 [m]
        Varies slowly from point to point.
    priority : (n,) float64
        Distinct.

    Returns
    -------
    (n,) bool
    """
    from scipy.spatial import cKDTree

    chosen = np.zeros(len(points), dtype=bool)
    open_ = np.arange(len(points))
    while len(open_) > 1:
        count = min(9, len(open_))
        distance, near = cKDTree(points[open_]).query(points[open_], k=count)
        i = np.repeat(np.arange(len(open_)), count)
        j = near.ravel()
        # of points in the same place, a point need not be its own first neighbour
        close = (distance < radius[open_, None]).ravel() & (i != j)
        i, j = i[close], j[close]
        rank = priority[open_]
        loses = np.zeros(len(open_), dtype=bool)
        loses[np.where(rank[i] < rank[j], i, j)] = True
        won = ~loses
        chosen[open_[won]] = True
        gone = won.copy()
        gone[i[won[j]]] = True
        gone[j[won[i]]] = True
        open_ = open_[~gone]
    chosen[open_] = True
    return chosen


def cells(
    size: SizeField, bounds: tuple[float, float, float, float], inside: Inside
) -> tuple[Floats, Floats]:
    """Square cells about CELL spacings wide that cover the ground: centres (n, 2) [m] and sides (n,) [m]."""
    import shapely

    side = CELL * size.base
    columns = max(1, int(np.ceil((bounds[2] - bounds[0]) / side)))
    rows = max(1, int(np.ceil((bounds[3] - bounds[1]) / side)))
    x = 0.5 * (bounds[0] + bounds[2]) + (np.arange(columns) - 0.5 * (columns - 1)) * side
    y = 0.5 * (bounds[1] + bounds[3]) + (np.arange(rows) - 0.5 * (rows - 1)) * side
    centres = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    quarters = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])
    done, sides = [], []
    while len(centres):
        inner = shapely.contains_xy(inside.ground, centres[:, 0], centres[:, 1])
        outer = np.flatnonzero(~inner)
        # half the diagonal, and the distance from a line to the middle of its longest edge
        inner[outer] = inside.middles.query(centres[outer])[0] < 0.71 * side + 0.7 * size.base
        centres = centres[inner]
        large = np.zeros(len(centres), dtype=bool) if size.uniform else side > 1.4 * CELL * size(centres)
        done.append(centres[~large])
        sides.append(np.full(int((~large).sum()), side))
        centres = (centres[large][:, None] + side * quarters).reshape(-1, 2)
        side *= 0.5
    return np.concatenate(done), np.concatenate(sides)


def insert_at_random(
    fixed: Floats, size: SizeField, grid: tuple[Floats, Floats], inside: Inside, rng: np.random.Generator
) -> Floats:
    """Random sequential insertion: particles no nearer to each other or to `fixed` than RADIUS spacings.

    Returns
    -------
    (n, 2) float64 [m]
    """
    from scipy.spatial import cKDTree

    centres, sides = grid
    taken = fixed
    count = len(fixed)
    for _ in range(ROUNDS):
        trial = centres + sides[:, None] * (rng.random((len(centres), 2)) - 0.5)
        priority = rng.permutation(len(trial)).astype(np.float64)
        spacing = size(trial)
        open_ = np.flatnonzero(cKDTree(taken).query(trial)[0] >= RADIUS * spacing)
        open_ = open_[inside(trial[open_], spacing[open_])]
        won = open_[independent(trial[open_], RADIUS * spacing[open_], priority[open_])]
        taken = np.concatenate([taken, trial[won]])
    return taken[count:]


def lattice(
    size: SizeField, bounds: tuple[float, float, float, float], inside: Inside, fixed: Floats
) -> Floats:
    """Hexagonal lattice with horizontal rows, centred in `bounds`, where the spacing is the base.

    Returns
    -------
    (n, 2) float64 [m]
    """
    from scipy.spatial import cKDTree

    step = size.base
    rise = 0.5 * np.sqrt(3.0) * step
    half = int(np.ceil(0.5 * (bounds[3] - bounds[1]) / rise)) + 1
    wide = int(np.ceil(0.5 * (bounds[2] - bounds[0]) / step)) + 1
    row, column = np.meshgrid(np.arange(-half, half + 1), np.arange(-wide, wide + 1), indexing="ij")
    x = 0.5 * (bounds[0] + bounds[2]) + (column + 0.5 * (row % 2)) * step
    y = 0.5 * (bounds[1] + bounds[3]) + row * rise
    points = np.column_stack([x.ravel(), y.ravel()])
    local = size(points)
    points = points[local > 0.95 * step]
    points = points[inside(points, np.full(len(points), step))]
    return points[cKDTree(fixed).query(points)[0] >= CLEARANCE * step] if len(points) else points


def rows_across(boundary: Boundary, size: SizeField, inside: Inside, layers: int) -> Floats:
    """Rows of particles between the faces of regions that are `layers` spacings thick.

    The k-th row lies at k / layers of the way across. Odd rows stand over the middles of the edges of a face
    and even ones over their ends, so that the triangles between two rows are near equilateral.

    Returns
    -------
    (n, 2) float64 [m]
    """
    import shapely

    if layers < 2:
        return np.empty((0, 2))
    a, b = boundary.positions[boundary.edges[:, 0]], boundary.positions[boundary.edges[:, 1]]
    run = b - a
    normal = np.column_stack([-run[:, 1], run[:, 0]]) / np.hypot(*run.T)[:, None]
    edge = np.arange(len(a))
    points, spacings, first = [], [], []
    for share in (0.5, 0.0, 1.0) if layers > 2 else (0.5,):
        # a ray from an end starts just inside its edge, so that it cannot slip past a neighbour's end
        base = a + (0.5 + 0.998 * (share - 0.5)) * run
        local = size(base)
        for direction in (normal, -normal):
            thickness, hit = first_hits(base, direction, (layers + 1.0) * local, a, b, edge)
            far = run[hit]
            turned = np.abs(direction[:, 0] * far[:, 1] - direction[:, 1] * far[:, 0]) / np.hypot(*far.T)
            fits = (hit >= 0) & (turned >= FACING)
            fits &= (thickness > (layers - 0.4) * local) & (thickness < (layers + 0.5) * local)
            start = (a + share * run)[fits]
            # of two faces that see each other, one is leading: rows seen from both would not agree
            leading = boundary.chain[edge[fits]] < boundary.chain[hit[fits]]
            across = thickness[fits, None] * direction[fits]
            for k in range(1, layers):
                if (k % 2 == 1) == (share == 0.5):
                    points.append(start + k / layers * across)
                    spacings.append(local[fits])
                    first.append(leading)
    place, spacing = np.concatenate(points), np.concatenate(spacings)
    rank = np.concatenate(first).astype(np.float64) - np.arange(len(place)) / (len(place) + 1.0)
    order = np.argsort(-rank, kind="stable")
    place, spacing = place[order], spacing[order]
    clear = shapely.contains_xy(inside.ground, place[:, 0], place[:, 1])
    clear &= inside.clearance(place) >= 0.55 * spacing
    place, spacing = place[clear], spacing[clear]
    return place[independent(place, 0.7 * spacing, -np.arange(len(place), dtype=np.float64))]


def smooth(
    points: Floats, triangles: Ints, movable: Mask, spacing: Floats, clear: Any, *, relaxation: float
) -> Floats:
    """One sweep towards the centroid of each particle's triangles, weighted so that the grading stays.

    A triangle's weight is its area / spacing^4: with the area alone, the large triangles of the coarse side
    would pull particles out of the fine side.

    Parameters
    ----------
    points : (n, 2) float64 [m]
    triangles : (m, 3) int
    movable : (n,) bool
    spacing : (n,) float64 [m]
    clear : callable
        (points, indices) -> bool, whether the particles may stand there.
    relaxation : float
        1 goes to the centroid.
    """
    corners = points[triangles]
    centre = corners.mean(axis=1)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    weight = area / spacing[triangles].mean(axis=1) ** 4
    n = len(points)
    who = triangles.ravel()
    total = np.bincount(who, np.repeat(weight, 3), n)
    x = np.bincount(who, np.repeat(weight * centre[:, 0], 3), n)
    y = np.bincount(who, np.repeat(weight * centre[:, 1], 3), n)
    index = np.flatnonzero(movable & (total > 0))
    goal = np.column_stack([x[index], y[index]]) / total[index, None]
    step = np.clip(
        relaxation * (goal - points[index]), -0.3 * spacing[index, None], 0.3 * spacing[index, None]
    )
    goal = points[index] + step
    allowed = clear(goal, index)
    moved = points.copy()
    moved[index[allowed]] = goal[allowed]
    return moved
