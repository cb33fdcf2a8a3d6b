"""Delaunay triangles over particles that follow the lines of a section and have no slivers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from geodem.builders.outline import Floats, Ints, Mask
from geodem.builders.packing import CLEARANCE, Inside, independent, smooth
from geodem.builders.size_field import SizeField

if TYPE_CHECKING:
    from geodem.builders.section import Section

# particles of triangles with a smaller angle [rad] are moved; a relaxed packing has few such triangles
POLISHED_ANGLE = np.radians(30.0)
# triangles below this angle [rad] that no move mends lose or gain a particle
SLIVER_ANGLE = np.radians(21.0)
DIRECTIONS = 12
STEPS = (0.06, 0.15, 0.3)


@dataclass
class Mesh:
    """Particles with what is known about them, and their Delaunay triangles.

    Attributes
    ----------
    positions : (n, 2) float64 [m]
    edges : (e, 2) int64
        Pieces of the section's lines, each to be an edge of the triangulation.
    held, movable : (n,) bool
        Particle that must stay (of a line, or prescribed); particle that smoothing may move. Rows across thin
        regions are neither.
    spacing : (n,) float64 [m]
    inside : Inside
    triangles, neighbours : (m, 3) int
        All triangles of the convex hull, counter-clockwise; neighbour k lies across from corner k.
    fresh : bool
        The triangles belong to the positions.
    """

    positions: Floats
    edges: Ints
    held: Mask
    movable: Mask
    spacing: Floats
    inside: Inside
    triangles: Ints = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    neighbours: Ints = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    fresh: bool = False

    def triangulate(self) -> None:
        """Delaunay triangulation of the particles as they stand."""
        from scipy.spatial import Delaunay

        if self.fresh:
            return
        mesh = Delaunay(self.positions)
        triangles, neighbours = mesh.simplices.astype(np.int64), mesh.neighbors.astype(np.int64)
        flipped = areas(self.positions, triangles) < 0.0
        triangles[flipped, 1:] = triangles[flipped, :0:-1]
        neighbours[flipped, 1:] = neighbours[flipped, :0:-1]
        self.triangles, self.neighbours = triangles, neighbours
        self.fresh = True

    def add(self, points: Floats, spacing: Floats, *, held: bool) -> None:
        """Append particles; those not held may be moved."""
        count = len(points)
        if not count:
            return
        self.fresh = False
        self.positions = np.concatenate([self.positions, points])
        self.spacing = np.concatenate([self.spacing, spacing])
        self.held = np.concatenate([self.held, np.full(count, held)])
        self.movable = np.concatenate([self.movable, np.full(count, not held)])

    def remove(self, gone: Mask) -> None:
        """Drop particles, none of them held; triangles are void until the next triangulation."""
        if not gone.any():
            return
        self.fresh = False
        kept = ~gone
        number = np.cumsum(kept) - 1
        self.edges = number[self.edges]
        self.positions, self.spacing = self.positions[kept], self.spacing[kept]
        self.held, self.movable = self.held[kept], self.movable[kept]

    def follow_lines(self) -> None:
        """Triangulate until every piece of a line is an edge.

        What stands in the circle over a missing piece goes; where nothing does, the piece is halved.
        """
        from scipy.spatial import cKDTree

        most = 4 * len(self.edges) + 100
        while len(self.edges) < most:
            self.triangulate()
            missing = np.flatnonzero(~np.isin(self._keys(self.edges), self._keys(_sides(self.triangles))))
            if not len(missing):
                return
            a, b = self.positions[self.edges[missing, 0]], self.positions[self.edges[missing, 1]]
            free = np.flatnonzero(~self.held)
            found: list[list[int]] = [[] for _ in missing]
            if len(free):
                # an empty circle over the piece is what makes it an edge; a hair more settles ties
                radius = 0.5 * np.hypot(*(b - a).T) * (1.0 + 1e-9)
                found = list(cKDTree(self.positions[free]).query_ball_point(0.5 * (a + b), radius))
            split = missing[[not inside for inside in found]]
            gone = np.zeros(len(self.positions), dtype=bool)
            gone[free[np.unique(np.concatenate([np.asarray(f, dtype=np.int64) for f in found]))]] = True
            ends = self.edges[split]
            new = len(self.positions) + np.arange(len(split))
            self.add(
                0.5 * (self.positions[ends[:, 0]] + self.positions[ends[:, 1]]),
                0.5 * np.minimum(self.spacing[ends[:, 0]], self.spacing[ends[:, 1]]),
                held=True,
            )
            self.edges = np.concatenate(
                [
                    np.delete(self.edges, split, axis=0),
                    np.column_stack([ends[:, 0], new]),
                    np.column_stack([new, ends[:, 1]]),
                ]
            )
            self.remove(np.concatenate([gone, np.zeros(len(split), dtype=bool)]))
        raise RuntimeError(
            "the triangulation does not follow the lines of the section, however finely they are cut"
        )

    def relax(self, sweeps: int, relaxation: float) -> None:
        """Smooth the movable particles; triangulates before each sweep."""

        def clear(points: Floats, index: Ints) -> Mask:
            allowed = np.ones(len(points), dtype=bool)
            close = np.flatnonzero(near[index])
            allowed[close] = self.inside(points[close], self.spacing[index[close]])
            return allowed

        near = np.zeros(len(self.positions), dtype=bool)
        near[self.movable] = (
            self.inside.middles.query(self.positions[self.movable])[0] < 3.0 * self.spacing[self.movable]
        )
        for _ in range(sweeps):
            self.triangulate()
            self.positions = smooth(
                self.positions, self.triangles, self.movable, self.spacing, clear, relaxation=relaxation
            )
            self.fresh = False

    def polish(self, turns: int) -> None:
        """Move the particles of the worst triangles to wherever their smallest angle becomes largest."""
        ring = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
        circle = np.column_stack([np.cos(ring), np.sin(ring)])
        offsets = np.concatenate([np.zeros((1, 2)), *(step * circle for step in STEPS)])
        for turn in range(turns):
            sine = smallest_sine(self.positions, self.triangles)
            bad = sine < np.sin(POLISHED_ANGLE)
            bad &= self.movable[self.triangles].any(axis=1)
            worst = np.full(len(self.positions), np.inf)
            np.minimum.at(worst, self.triangles[bad].ravel(), np.repeat(sine[bad], 3))
            chosen = np.flatnonzero(self.movable & np.isfinite(worst))
            if not len(chosen):
                break
            # neighbours never move together: each judges its place by the others
            rank = worst[chosen] + 1e-12 * np.arange(len(chosen))
            chosen = chosen[independent(self.positions[chosen], 2.0 * self.spacing[chosen], -rank)]
            which = np.full(len(self.positions), -1)
            which[chosen] = np.arange(len(chosen))
            triangle, corner = np.nonzero(which[self.triangles] >= 0)
            owner = which[self.triangles[triangle, corner]]
            order = np.argsort(owner, kind="stable")
            triangle, corner, owner = triangle[order], corner[order], owner[order]
            p = self.positions[self.triangles[triangle, (corner + 1) % 3]][:, None]
            q = self.positions[self.triangles[triangle, (corner + 2) % 3]][:, None]
            turned = offsets if turn % 2 == 0 else offsets @ np.array([[0.966, 0.259], [-0.259, 0.966]])
            places = self.positions[chosen][:, None] + self.spacing[chosen][:, None, None] * turned
            quality = _sine(places[owner], p, q)
            starts = np.searchsorted(owner, np.arange(len(chosen)))
            quality = np.minimum.reduceat(quality, starts, axis=0)
            best = np.argmax(quality, axis=1)
            self.positions[chosen] = places[np.arange(len(chosen)), best]
            self.fresh = False
            # the old triangles serve twice: a move that helps them never turns one over
            if turn % 2 == 1:
                self.follow_lines()
        self.follow_lines()

    def mend_slivers(self, size: SizeField, turns: int) -> None:
        """Take a particle out of, or put one into, the slivers that polishing left."""
        for _ in range(turns):
            bad = smallest_sine(self.positions, self.triangles) < np.sin(SLIVER_ANGLE)
            bad &= ~self.held[self.triangles].all(axis=1)
            bad &= self._in_ground(self.triangles)
            index = np.flatnonzero(bad)
            if not len(index):
                return
            corners = self.triangles[index]
            p = self.positions[corners]
            lengths = np.stack([np.hypot(*(p[:, (k + 1) % 3] - p[:, k]).T) for k in range(3)], axis=1)
            local = self.spacing[corners].mean(axis=1)
            shortest = np.argmin(lengths, axis=1)
            every = np.arange(len(index))
            u, v = corners[every, shortest], corners[every, (shortest + 1) % 3]
            victim = np.where(~self.held[u], u, v)
            short = (lengths.min(axis=1) < 0.75 * local) & ~self.held[victim]
            gone = np.zeros(len(self.positions), dtype=bool)
            pick = independent(
                p[short].mean(axis=1), 2.0 * local[short], -np.arange(short.sum(), dtype=float)
            )
            gone[victim[short][pick]] = True
            centre, radius = circumcircles(p[~short])
            wide = (radius > 0.7 * local[~short]) & self.inside(centre, local[~short], 0.45)
            centre = centre[wide]
            centre = centre[independent(centre, local[~short][wide], -np.arange(len(centre), dtype=float))]
            if not len(centre) and not gone.any():
                return
            self.add(centre, size(centre), held=False)
            self.remove(np.concatenate([gone, np.zeros(len(centre), dtype=bool)]))
            self.follow_lines()
            self.polish(2)

    def reach_count(self, target: int, size: SizeField, *, turns: int = 6) -> None:
        """Insert particles where the gaps are widest, or take out those that stand closest."""
        for _ in range(turns):
            missing = target - len(self.positions)
            if missing == 0:
                return
            if missing > 0:
                centre, radius = circumcircles(self.positions[self.triangles])
                gap = radius / self.spacing[self.triangles].mean(axis=1)
                first = np.argsort(-gap, kind="stable")[: 6 * missing + 20]
                centre, gap = centre[first], gap[first]
                local = size(centre)
                clear = self.inside(centre, local, CLEARANCE)
                centre, local, gap = centre[clear], local[clear], gap[clear]
                # the triangles of one gap have nearly the same circle
                rank = -np.arange(len(centre), dtype=np.float64)
                pick = np.flatnonzero(independent(centre, 0.7 * local, rank))[:missing]
                if not len(pick):
                    return
                self.add(centre[pick], local[pick], held=False)
            else:
                side = np.sort(_sides(self.triangles), axis=1)
                side = np.unique(side[self.movable[side].any(axis=1)], axis=0)
                length = np.hypot(*(self.positions[side[:, 0]] - self.positions[side[:, 1]]).T)
                side = side[
                    np.argsort(length / self.spacing[side].mean(axis=1), kind="stable")[: -6 * missing + 20]
                ]
                victim = np.where(self.movable[side[:, 1]], side[:, 1], side[:, 0])
                _, once = np.unique(victim, return_index=True)
                victim = victim[np.sort(once)]
                rank = -np.arange(len(victim), dtype=np.float64)
                pick = victim[independent(self.positions[victim], 1.5 * self.spacing[victim], rank)][
                    :-missing
                ]
                if not len(pick):
                    return
                gone = np.zeros(len(self.positions), dtype=bool)
                gone[pick] = True
                self.remove(gone)
            self.triangulate()

    def shortage(self) -> float:
        """Particles missing in the free part for its triangles to be as large as the spacing asks.

        Each particle put inside makes two more triangles (Euler).
        """
        free = self.movable[self.triangles].any(axis=1) & self._in_ground(self.triangles)
        triangles = self.triangles[free]
        wanted = 0.25 * np.sqrt(3.0) * (self.spacing[triangles] ** 2).mean(axis=1)
        return float(0.5 * ((areas(self.positions, triangles) / wanted).sum() - len(triangles)))

    def _in_ground(self, triangles: Ints) -> Mask:
        import shapely

        centre = self.positions[triangles].mean(axis=1)
        inside: Mask = shapely.contains_xy(self.inside.ground, centre[:, 0], centre[:, 1])
        return inside

    def _keys(self, pairs: Ints) -> Ints:
        return pairs.min(axis=1) * len(self.positions) + pairs.max(axis=1)

    def label(self, section: Section) -> tuple[Ints, Ints]:
        """Triangles of the ground and the region of each.

        The lines cut the triangulation into pieces that lie in one region as a whole, so that one point of
        each piece decides, well away from any round-off. Flat triangles outside a slanted line are a piece of
        their own without area.

        Returns
        -------
        (m, 3) int64, (m,) int64
        """
        import shapely
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        m = len(self.triangles)
        opposite = _sides(self.triangles).reshape(3, m, 2)
        cut = np.isin(self._keys(opposite.reshape(-1, 2)), self._keys(self.edges)).reshape(3, m)
        links = []
        for k in range(3):
            other = self.neighbours[:, k]
            joined = np.flatnonzero(~cut[k] & (other >= 0))
            links.append(np.column_stack([joined, other[joined]]))
        link = np.concatenate(links)
        graph = coo_array((np.ones(len(link), dtype=np.int8), (link[:, 0], link[:, 1])), shape=(m, m))
        count, piece = connected_components(graph, directed=False)
        area = areas(self.positions, self.triangles)
        order = np.lexsort((-area, piece))
        largest = order[np.searchsorted(piece[order], np.arange(count))]
        centre = self.positions[self.triangles[largest]].mean(axis=1)
        region = np.full(count, -1, dtype=np.int64)
        for index, part in enumerate(section.regions):
            region[shapely.contains_xy(part.polygon, centre[:, 0], centre[:, 1])] = index
        region[area[largest] < 1e-9 * self.spacing[self.triangles[largest]].min(axis=1) ** 2] = -1
        kept = region[piece] >= 0
        return self.triangles[kept], region[piece][kept]


def _sides(triangles: Ints) -> Ints:
    """The three edges of each triangle, edge k opposite corner k, shape (3 m, 2), all edges 0 first."""
    return np.concatenate([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]])


def areas(positions: Floats, triangles: Ints) -> Floats:
    """Signed area of each triangle [m2]."""
    p = positions[triangles]
    u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    area: Floats = 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return area


def smallest_sine(positions: Floats, triangles: Ints) -> Floats:
    """Sine of the smallest angle of each triangle; negative for a clockwise one."""
    p = positions[triangles]
    return _sine(p[:, 0], p[:, 1], p[:, 2])


def _sine(a: Floats, b: Floats, c: Floats) -> Floats:
    # the smallest angle lies between the two longest sides: its sine is twice the area over their product
    u, v, w = b - a, c - b, a - c
    twice = u[..., 0] * -w[..., 1] + u[..., 1] * w[..., 0]
    squares = np.stack(np.broadcast_arrays(*((side**2).sum(axis=-1) for side in (u, v, w))))
    squares.sort(axis=0)
    return twice / np.sqrt(np.maximum(squares[1] * squares[2], 1e-300))


def circumcircles(corners: Floats) -> tuple[Floats, Floats]:
    """Centres (n, 2) [m] and radii (n,) [m] of the circles through the corners (n, 3, 2) of triangles."""
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    twice = 2.0 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    twice = np.where(np.abs(twice) < 1e-300, 1e-300, twice)
    uu, vv = (u**2).sum(axis=1), (v**2).sum(axis=1)
    centre = np.column_stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu]) / twice[:, None]
    return a + centre, np.hypot(*centre.T)
