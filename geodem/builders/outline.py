"""The lines of a section as a graph, and particles placed along them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from geodem.builders.section import Section

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
Spacing = Callable[[Floats], Floats]

CORNER_TURN = np.radians(12.0)
# a simplified line may show the turns of a whole arc in one vertex; only beyond any arc's it is a corner
SHARP_TURN = np.radians(45.0)
# smaller turns are round-off of a straight line
STRAIGHT_TURN = 1e-9
# features lower than this share of the spacing are noise of the line, not shape
NOISE = 0.05
# a vertex between two runs of at least this share of the spacing costs no refinement, so it is kept
LONG_RUN = 0.7


@dataclass(frozen=True)
class Graph:
    """Noded lines of a section.

    Attributes
    ----------
    vertices : (v, 2) float64 [m]
    arcs : tuple of int arrays
        Vertex numbers along each maximal run between junctions; first equals last in a closed run.
    pinned : (v,) bool
        Junctions and points that must become particles.
    """

    vertices: Floats
    arcs: tuple[Ints, ...]
    pinned: Mask


@dataclass(frozen=True)
class Chain:
    """Run of a line between two corners: (k, 2) points [m], and the vertex numbers of its two ends."""

    points: Floats
    first: int
    last: int


@dataclass(frozen=True)
class Boundary:
    """Particles along all lines.

    Attributes
    ----------
    positions : (n, 2) float64 [m]
    edges : (e, 2) int64
        Neighbours along the lines, in the direction of their chain.
    chain : (e,) int64
        Chain that an edge belongs to.
    """

    positions: Floats
    edges: Ints
    chain: Ints


def build_graph(section: Section, points: Floats, tolerance: float) -> tuple[Graph, Mask]:
    """Node the boundaries of all regions and pin the given points that lie on them.

    Parameters
    ----------
    section : Section
    points : (p, 2) float64 [m]
        Points that must become particles.
    tolerance : float [m]
        A point nearer to a line than this lies on it.

    Returns
    -------
    Graph, (p,) bool
        The second says which points lie on a line.
    """
    import shapely

    lines = shapely.unary_union([region.polygon.boundary for region in section.regions])
    coordinates, line = shapely.get_coordinates(shapely.get_parts(lines), return_index=True)
    follows = line[1:] == line[:-1]
    ends = np.hstack([coordinates[:-1][follows], coordinates[1:][follows]]).reshape(-1, 2, 2)
    on_line = np.zeros(len(points), dtype=bool)
    marks = []
    for index, point in enumerate(points):
        foot = _feet(point, ends[:, 0], ends[:, 1])
        distance = np.hypot(*(foot - point).T)
        nearest = int(np.argmin(distance))
        if distance[nearest] > tolerance:
            continue
        on_line[index] = True
        to_ends = np.hypot(*(ends[nearest] - point).T)
        if to_ends.min() <= tolerance:
            marks.append(ends[nearest, np.argmin(to_ends)].copy())
            continue
        # every copy of a shared segment is split at the same foot
        a, b = ends[nearest].copy()
        marks.append(foot[nearest])
        ends = np.concatenate([np.delete(ends, nearest, axis=0), [[a, foot[nearest]], [foot[nearest], b]]])
    vertices, number = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    pairs = np.sort(number.reshape(-1, 2), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    degree = np.bincount(pairs.ravel(), minlength=len(vertices))
    pinned = degree != 2
    for mark in marks:
        pinned |= (vertices == mark).all(axis=1)
    return Graph(vertices, tuple(_walk(pairs, pinned)), pinned), on_line


def _feet(point: Floats, a: Floats, b: Floats) -> Floats:
    """Nearest points of the segments ab to one or as many points."""
    run = b - a
    share = np.einsum("ij,ij->i", point - a, run) / np.einsum("ij,ij->i", run, run)
    return a + np.clip(share, 0.0, 1.0)[:, None] * run


def segment_distance(points: Floats, a: Floats, b: Floats) -> Floats:
    """Distance [m] of each point to its segment ab, row by row."""
    return np.hypot(*(_feet(points, a, b) - points).T)


def _walk(pairs: Ints, pinned: Mask) -> list[Ints]:
    """Maximal runs between pinned vertices, then closed runs without one."""
    around: list[list[int]] = [[] for _ in range(len(pinned))]
    for index, (a, b) in enumerate(pairs.tolist()):
        around[a].append(index)
        around[b].append(index)
    ends = pairs.tolist()
    used = [False] * len(ends)
    arcs = []
    starts = [*np.flatnonzero(pinned).tolist(), *np.flatnonzero(~pinned).tolist()]
    for start in starts:
        for first in around[start]:
            if used[first]:
                continue
            run, at, segment = [start], start, first
            while True:
                used[segment] = True
                a, b = ends[segment]
                at = b if at == a else a
                run.append(at)
                if at == start or pinned[at]:
                    break
                segment = next(other for other in around[at] if other != segment)
            arcs.append(np.array(run, dtype=np.int64))
    return arcs


def _is_corner_within(graph: Graph, ring: Ints, spacing: Floats, turns: Floats) -> bool:
    """Whether the start of a closed run is a corner: judged as any other, with the run begun on its far side."""
    import shapely

    half = len(ring) // 2
    run = np.concatenate([ring[half:-1], ring[: half + 1]])
    line = shapely.LineString(graph.vertices[run])
    rough = shapely.get_coordinates(line.simplify(NOISE * spacing[run].min(), preserve_topology=False))
    at = np.flatnonzero((rough[1:-1] == graph.vertices[ring[0]]).all(axis=1))
    if not len(at):
        return False
    turned = float(_turns(np.diff(rough, axis=0))[at[0]])
    return turned > SHARP_TURN or (turned > CORNER_TURN and float(turns[ring[0]]) > CORNER_TURN)


def split_at_corners(graph: Graph, spacing: Floats) -> tuple[list[Chain], Mask, tuple[Floats, Floats]]:
    """Cut the lines at their corners.

    A vertex is a corner where lines meet, where it lies between two runs that are long against the spacing,
    or where the line turns by more than 12 degrees and stands out of its neighbourhood by more than 3 % of
    the spacing. Smooth runs carry a limit from their curvature: one chord per 0.4 rad.

    Parameters
    ----------
    graph : Graph
    spacing : (v,) float64 [m]
        Spacing wanted at each vertex.

    Returns
    -------
    chains : list of Chain
    corner : (v,) bool
    curvature : ((k, 2), (k,)) float64
        Places on smooth runs and the spacing that their curvature allows.
    """
    import shapely

    corner = graph.pinned.copy()
    chains: list[Chain] = []
    places, limits = [np.empty((0, 2))], [np.empty(0)]
    for arc in graph.arcs:
        closed = arc[0] == arc[-1]
        # a closed run is seen twice round its start, so that its start is judged like any other vertex
        ring = np.concatenate([arc[-2:-1], arc, arc[1:2]]) if closed else arc
        sides = np.diff(graph.vertices[ring], axis=0)
        length = np.hypot(*sides.T)
        turn = _turns(sides)
        inner = ring[1:-1]
        shorter = np.minimum(length[:-1], length[1:])
        kept = (shorter >= LONG_RUN * spacing[inner]) & (turn > STRAIGHT_TURN)
        corner[inner[kept]] = True
        turns = np.zeros(len(graph.vertices))
        turns[inner] = turn
        for run in _pieces(arc, corner):
            line = shapely.LineString(graph.vertices[run])
            rough = shapely.get_coordinates(
                line.simplify(NOISE * spacing[run].min(), preserve_topology=False)
            )
            if len(rough) < 3:
                continue
            sides = np.diff(rough, axis=0)
            rough_turn = _turns(sides)
            # noise turns much in the line but little once simplified, and an arc the other way round
            found = []
            for place, turned in zip(rough[1:-1], rough_turn, strict=True):
                here = run[1:-1][(graph.vertices[run[1:-1]] == place).all(axis=1)]
                if turned > SHARP_TURN or (turned > CORNER_TURN and turns[here].max() > CORNER_TURN):
                    found.append(int(here[0]))
            start = int(run[0])
            if start == run[-1] and not corner[start] and _is_corner_within(graph, run, spacing, turns):
                found.append(start)
            corner[found] = True
            length = np.hypot(*sides.T)
            smooth = (rough_turn > STRAIGHT_TURN) & ~_rows_in(rough[1:-1], graph.vertices[found])
            places.append(rough[1:-1][smooth])
            limits.append((0.2 * (length[:-1] + length[1:]) / np.maximum(rough_turn, STRAIGHT_TURN))[smooth])
        chains += [Chain(graph.vertices[run], int(run[0]), int(run[-1])) for run in _pieces(arc, corner)]
    return chains, corner, (np.concatenate(places), np.concatenate(limits))


def _turns(sides: Floats) -> Floats:
    a, b = sides[:-1], sides[1:]
    return np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ij,ij->i", a, b)))


def _rows_in(rows: Floats, table: Floats) -> Mask:
    return (rows[:, None] == table[None]).all(axis=2).any(axis=1)


def _pieces(arc: Ints, corner: Mask) -> list[Ints]:
    """The arc cut at its corners; a closed one starts at its first corner where it has one."""
    if arc[0] == arc[-1]:
        at = np.flatnonzero(corner[arc[:-1]])
        if len(at):
            arc = np.concatenate([arc[at[0] : -1], arc[: at[0] + 1]])
    cuts = np.flatnonzero(corner[arc[1:-1]]) + 1
    return [piece for piece in _between(arc, [0, *cuts.tolist(), len(arc) - 1]) if len(piece) > 1]


def _between(arc: Ints, cuts: Sequence[int]) -> list[Ints]:
    return [arc[a : b + 1] for a, b in itertools.pairwise(cuts)]


def place_along(
    chains: Sequence[Chain], spacing: Spacing, smallest: float, *, density: float = 1.0
) -> tuple[list[Floats], list[Floats]]:
    """Points along each chain at the local spacing, its two ends included.

    The number of parts is the integral of 1/spacing along the chain, rounded so that no part is longer than
    1.25 of the spacing; parts are equal in that measure, hence equally long where the spacing is uniform.

    Parameters
    ----------
    chains : sequence of Chain
    spacing : callable, (n, 2) -> (n,) [m]
    smallest : float [m]
        Smallest value that `spacing` can take.
    density : float
        Points per spacing.

    Returns
    -------
    list of (n_i, 2) float64 [m], list of (n_i,) float64 [m]
        Points, and their arc lengths.
    """
    arcs = [
        np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(chain.points, axis=0).T))]) for chain in chains
    ]
    grids, values = _graded_grids(chains, arcs, spacing, smallest)
    wanted = np.concatenate(values) / density
    points, lengths = [], []
    offset = 0
    for chain, arc, grid in zip(chains, arcs, grids, strict=True):
        local = wanted[offset : offset + len(grid) - 1]
        offset += len(grid) - 1
        measure = np.concatenate([[0.0], np.cumsum(np.diff(grid) / local)])
        fewest = 3 if chain.first == chain.last else 1
        parts = max(fewest, int(np.ceil(measure[-1] - 0.25)))
        at = np.interp(np.linspace(0.0, measure[-1], parts + 1), measure, grid)
        if local.max() == local.min():
            at = np.linspace(0.0, arc[-1], parts + 1)
        placed = along(chain, arc, at)
        placed[0], placed[-1] = chain.points[0], chain.points[-1]
        points.append(placed)
        lengths.append(at)
    return points, lengths


def _graded_grids(
    chains: Sequence[Chain], arcs: Sequence[Floats], spacing: Spacing, smallest: float
) -> tuple[list[Floats], list[Floats]]:
    """Arc lengths that cut each chain into parts short against the spacing, and the spacing amid them."""
    # all chains as one line, with a gap of one between them, so that a point is found in one search
    offset = np.concatenate([[0.0], np.cumsum([arc[-1] + 1.0 for arc in arcs])[:-1]])
    line = Chain(np.concatenate([chain.points for chain in chains]), 0, 0)
    line_arc = np.concatenate([arc + start for arc, start in zip(arcs, offset, strict=True)])
    owner = np.repeat(np.arange(len(chains)), 2)
    low = np.concatenate([[0.0, 0.5 * arc[-1]] for arc in arcs])
    width = np.concatenate([[0.5 * arc[-1]] * 2 for arc in arcs])
    done: list[tuple[Ints, Floats, Floats, Floats]] = []
    while len(low):
        value = spacing(along(line, line_arc, offset[owner] + low + 0.5 * width))
        # the spacing cannot fall faster than its grading, so what is wide open needs no closer look
        split = (width > 0.5 * value) & (width > 0.1 * smallest)
        done.append((owner[~split], low[~split], width[~split], value[~split]))
        owner, low = np.repeat(owner[split], 2), np.repeat(low[split], 2)
        width = np.repeat(0.5 * width[split], 2)
        low[1::2] += width[1::2]
    who, start, _, value = (np.concatenate(part) for part in zip(*done, strict=True))
    order = np.lexsort((start, who))
    cuts = np.searchsorted(who[order], np.arange(1, len(chains)))
    grids = [np.append(part, arc[-1]) for part, arc in zip(np.split(start[order], cuts), arcs, strict=True)]
    return grids, np.split(value[order], cuts)


def along(chain: Chain, arc: Floats, at: Floats) -> Floats:
    """Points of the chain at the arc lengths `at`; ``arc`` holds those of its vertices."""
    index = np.clip(np.searchsorted(arc, at, side="right") - 1, 0, len(arc) - 2)
    share = (at - arc[index]) / (arc[index + 1] - arc[index])
    a, b = chain.points[index], chain.points[index + 1]
    return a + share[:, None] * (b - a)


def join(chains: Sequence[Chain], points: Sequence[Floats], vertices: Floats) -> Boundary:
    """Number the points of all chains so that chains which meet share their end particle."""
    ends = np.unique([end for chain in chains for end in (chain.first, chain.last)])
    number = {int(end): index for index, end in enumerate(ends)}
    positions: list[Any] = [vertices[ends]]
    edges, owner = [], []
    count = len(ends)
    for index, (chain, run) in enumerate(zip(chains, points, strict=True)):
        inner = np.arange(count, count + len(run) - 2)
        count += len(inner)
        positions.append(run[1:-1])
        ids = np.concatenate([[number[chain.first]], inner, [number[chain.last]]])
        edges.append(np.column_stack([ids[:-1], ids[1:]]))
        owner.append(np.full(len(ids) - 1, index))
    return Boundary(np.concatenate(positions), np.concatenate(edges), np.concatenate(owner))


def first_hits(
    origins: Floats, directions: Floats, reach: Floats, a: Floats, b: Floats, own: Ints
) -> tuple[Floats, Ints]:
    """Distance to the first segment ab that each ray meets, and the number of that segment.

    Where none lies within reach they are inf and -1. ``own`` is the number of the segment that a ray starts
    on, which it does not meet.
    """
    import shapely

    tree = shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))
    rays = shapely.linestrings(np.stack([origins, origins + reach[:, None] * directions], axis=1))
    ray, segment = tree.query(rays)
    other = own[ray] != segment
    ray, segment = ray[other], segment[other]
    run = b[segment] - a[segment]
    gap = a[segment] - origins[ray]
    d = directions[ray]
    cross = d[:, 0] * run[:, 1] - d[:, 1] * run[:, 0]
    parallel = np.abs(cross) <= 1e-12 * np.hypot(*run.T)
    cross = np.where(parallel, 1.0, cross)
    distance = (gap[:, 0] * run[:, 1] - gap[:, 1] * run[:, 0]) / cross
    share = (gap[:, 0] * d[:, 1] - gap[:, 1] * d[:, 0]) / cross
    # neighbours along a line are touched at distance zero by rays that start at a shared end
    met = ~parallel & (distance > 1e-9 * reach[ray]) & (distance <= reach[ray])
    met &= (share >= -1e-9) & (share <= 1.0 + 1e-9)
    ray, segment, distance = ray[met], segment[met], distance[met]
    order = np.lexsort((segment, distance, ray))
    ray, segment, distance = ray[order], segment[order], distance[order]
    first = np.ones(len(ray), dtype=bool)
    first[1:] = ray[1:] != ray[:-1]
    nearest = np.full(len(origins), np.inf)
    hit = np.full(len(origins), -1, dtype=np.int64)
    nearest[ray[first]] = distance[first]
    hit[ray[first]] = segment[first]
    return nearest, hit
