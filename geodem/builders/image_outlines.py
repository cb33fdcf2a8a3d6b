"""Polygons of a labelled picture, to a part of a pixel, with every common boundary drawn once."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.image_arcs import Arc, Node, find_arcs
from geodem.builders.image_labels import LabelImage
from geodem.builders.image_lines import (
    Line,
    best_line,
    crossing,
    fit_line,
    meeting,
    misfit,
    split_into_lines,
    trimmed,
)

_CORNER_MOVE = 1.5  # how far a corner may move from the traced one [px], where its sides are not parallel
_SHARP_CORNER_MOVE = 6.0  # the tip of a wedge covers less than half of its last pixels
_STRAIGHTENED = 0.35  # drift over its length below which a line is upright or level [px]
_SHORTEST_STRAIGHTENED = 6.0
_ALIGNED = 0.5  # upright (level) lines this close in x (y) become one [px]
_FRAME_ALIGNED = 0.75
_SHORTEST_SIDE = 0.5
_PINNED = 2  # caution at which a meeting point stays at its pixel corner


def outline_polygons(image: LabelImage) -> list[tuple[int, shapely.Polygon]]:
    """Trace the pieces of a labelled picture.

    Parameters
    ----------
    image : LabelImage
        Labels with the colours that place the edges.

    Returns
    -------
    list of (int, shapely.Polygon)
        Label and outline of every connected piece of ground [px], x to the right from the left edge and y
        downwards from the upper edge. Neighbours share the vertices of their boundary exactly.
    """
    arcs, piece_label = find_arcs(image)
    height, width = image.labels.shape
    pixels = _pixels_per_piece(arcs, len(piece_label))
    # Where fitted outlines cross, their meeting points first move less, then not at all; then the outlines
    # themselves go back to the pixel edges, which never cross.
    caution: dict[Node, int] = {}
    raw: set[int] = set()
    for _ in range(10):
        lines = _draw(arcs, width, height, raw, caution)
        polygons, bad = _assemble(arcs, lines, piece_label, pixels)
        if not bad - raw:
            break
        raw |= {k for k in bad if all(caution.get(node, 0) == _PINNED for node in arcs[k].ends)}
        for node in {node for k in bad for node in arcs[k].ends}:
            caution[node] = min(caution.get(node, 0) + 1, _PINNED)
    if bad:
        everywhere = {node: _PINNED for arc in arcs for node in arc.ends}
        lines = _draw(arcs, width, height, set(range(len(arcs))), everywhere)
        polygons, _ = _assemble(arcs, lines, piece_label, pixels)
    return polygons


def _pixels_per_piece(arcs: list[Arc], count: int) -> NDArray[np.float64]:
    """Number of pixels of each piece, from the outlines alone (they bound all ground)."""
    result = np.zeros(count)
    for piece in range(1, count):
        mine = [shapely.LineString(arc.path) for arc in arcs if piece in arc.pieces]
        if mine:
            result[piece] = shapely.build_area(shapely.MultiLineString(mine)).area
    return result


def _draw(
    arcs: list[Arc], width: int, height: int, raw: set[int], caution: dict[Node, int]
) -> list[NDArray[np.float64]]:
    """Polyline of every arc; arcs of ``raw`` follow the pixels."""
    pinned = {node for node, level in caution.items() if level == _PINNED}
    runs: list[list[tuple[int, int]]] = []
    for k, arc in enumerate(arcs):
        if arc.on_frame or k in raw or len(arc.points) == 0:
            runs.append([])
            continue
        arc.points, arc.tolerance, found = split_into_lines(arc.points, arc.tolerance, arc.closed)
        runs.append(found)
    lines = _fit(arcs, runs, pinned)
    _straighten(list({id(line): line for row in lines for line in row}.values()), width, height)

    nodes = _place_nodes(arcs, lines, width, height, caution)
    drawn = []
    for k, arc in enumerate(arcs):
        if arc.on_frame or k in raw or not runs[k]:
            drawn.append(_along_pixels(arc, nodes))
        else:
            drawn.append(_along_lines(arc, runs[k], lines[k], nodes))
    return drawn


def _fit(arcs: list[Arc], runs: list[list[tuple[int, int]]], pinned: set[Node]) -> list[list[Line]]:
    """A line for every run; runs that go straight on through a meeting point get one line together."""
    group: dict[tuple[int, int], tuple[int, int]] = {
        (k, s): (k, s) for k, row in enumerate(runs) for s in range(len(row))
    }
    members = {key: [key] for key in group}

    def gathered(keys: list[tuple[int, int]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        parts = [(arcs[k], trimmed(*runs[k][s])) for k, s in keys]
        points = np.concatenate([arc.points[part] for arc, part in parts])
        return points, np.concatenate([arc.tolerance[part] for arc, part in parts])

    for node, ends in sorted(_ends(arcs, runs).items()):
        if node in pinned:
            continue
        bends = []
        for (one, away), (other, across) in combinations(ends, 2):
            bends.append((float(away @ across), one, other))
        used: set[tuple[int, int]] = set()
        for cosine, one, other in sorted(bends, key=lambda bend: bend[0]):
            few = min(runs[k][s][1] - runs[k][s][0] + 1 for k, s in (one, other)) < 5
            if one in used or other in used or group[one] == group[other]:
                continue
            if cosine > (-0.6 if few else -0.9):
                continue
            together = members[group[one]] + members[group[other]]
            if misfit(*gathered(together)) <= 1.0:
                used |= {one, other}
                gone = group[other]
                members[group[one]] = together
                for key in members.pop(gone):
                    group[key] = group[one]
    fitted = {name: best_line(*gathered(keys))[0] for name, keys in sorted(members.items())}
    return [[fitted[group[k, s]] for s in range(len(row))] for k, row in enumerate(runs)]


def _ends(
    arcs: list[Arc], runs: list[list[tuple[int, int]]]
) -> dict[Node, list[tuple[tuple[int, int], NDArray[np.float64]]]]:
    """Runs that end at each meeting point, with their direction away from it."""
    result: dict[Node, list[tuple[tuple[int, int], NDArray[np.float64]]]] = {}
    for k, arc in enumerate(arcs):
        if not runs[k] or not arc.at_node:
            continue
        for node, s, sense in ((arc.ends[0], 0, 1), (arc.ends[1], len(runs[k]) - 1, -1)):
            first, last = runs[k][s]
            points = arc.points[first : last + 1]
            if len(points) >= 4:
                direction = fit_line(points).direction
                direction = direction * (sense if direction @ (points[-1] - points[0]) >= 0 else -sense)
            else:
                far = arc.path[-1] if sense > 0 else arc.path[0]
                direction = (points[-1] if sense > 0 else points[0]) - np.array(node, dtype=float)
                if len(runs[k]) == 1:
                    direction = far - np.array(node, dtype=float)
                direction = direction / max(float(np.hypot(*direction)), 1e-12)
            result.setdefault(node, []).append(((k, s), direction))
    return result


def _straighten(lines: list[Line], width: int, height: int) -> None:
    """Make nearly upright and level lines exactly so, and align them with each other and the frame."""
    for axis, size in ((0, width), (1, height)):
        chosen = [
            line
            for line in lines
            if line.span >= _SHORTEST_STRAIGHTENED and abs(line.direction[axis]) * line.span <= _STRAIGHTENED
        ]
        chosen.sort(key=lambda line: (float(line.centre[axis]), line.span))
        start = 0
        for k in range(1, len(chosen) + 1):
            if k < len(chosen) and chosen[k].centre[axis] - chosen[start].centre[axis] <= _ALIGNED:
                continue
            together = chosen[start:k]
            value = sum(line.span * float(line.centre[axis]) for line in together)
            value /= sum(line.span for line in together)
            for edge in (0.0, float(size)):
                if abs(value - edge) <= _FRAME_ALIGNED:
                    value = edge
            for line in together:
                line.hold(axis, value)
            start = k


def _place_nodes(
    arcs: list[Arc], lines: list[list[Line]], width: int, height: int, caution: dict[Node, int]
) -> dict[Node, NDArray[np.float64]]:
    """Position of every meeting point: where the lines that end there cross."""
    ending: dict[Node, dict[int, Line]] = {}
    closest: dict[Node, float] = {}  # distance to the nearest meeting point along an arc [px]
    for arc, row in zip(arcs, lines, strict=True):
        if arc.at_node:
            for node, k in ((arc.ends[0], 0), (arc.ends[1], -1)):
                ending.setdefault(node, {})
                if row:
                    ending[node][id(row[k])] = row[k]
            gap = float(np.hypot(*(arc.path[0] - arc.path[-1])))
            for node in arc.ends if gap > 0.0 else ():
                closest[node] = min(closest.get(node, math.inf), gap)
    placed = {}
    for node, found in ending.items():
        near = np.array(node, dtype=float)
        if caution.get(node, 0) == _PINNED or not found:
            placed[node] = near
            continue
        frame = {axis: near[axis] for axis, size in ((0, width), (1, height)) if node[axis] in (0, size)}
        chosen = list(found.values())
        good = [line for line in chosen if line.count >= 4]
        if len(good) >= 2 and _largest_angle(good, {}) > 0.25:
            chosen = good
        sine = max(_largest_angle(chosen, frame), 1e-6)
        limit = min(_CORNER_MOVE / sine, _SHARP_CORNER_MOVE)
        if node in caution:
            # less than half way to the next meeting point, so that the two cannot change places
            limit = min(limit, _CORNER_MOVE, 0.45 * closest.get(node, math.inf))
        point = meeting(chosen, near, limit, frame)
        if frame:
            corner = np.array([round(near[0] / width) * width, round(near[1] / height) * height], dtype=float)
            if np.hypot(*(point - corner)) <= _FRAME_ALIGNED:
                point = corner
            point = np.clip(point, 0.0, [width, height])
        placed[node] = point
    return placed


def _largest_angle(lines: list[Line], frame: dict[int, float]) -> float:
    """Sine of the largest angle between two of the lines, or between one and the edge of the picture."""
    normals = [line.normal for line in lines] + [np.eye(2)[axis] for axis in frame]
    return max((abs(float(a[0] * b[1] - a[1] * b[0])) for a, b in combinations(normals, 2)), default=0.0)


def _along_pixels(arc: Arc, nodes: dict[Node, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Polyline of an arc along the pixel edges, between its placed ends."""
    path = arc.path.astype(float)
    step = np.diff(path, axis=0)
    turns = np.r_[True, (step[1:] != step[:-1]).any(axis=1), True]
    line = path[turns]
    if arc.at_node:
        line[0], line[-1] = nodes[arc.ends[0]], nodes[arc.ends[1]]
    return _without_short_sides(line)


def _along_lines(
    arc: Arc, runs: list[tuple[int, int]], lines: list[Line], nodes: dict[Node, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Polyline of an arc through the crossings of its lines."""
    corners = []
    following = list(range(1, len(runs))) + ([0] if arc.closed else [])
    for k, after in enumerate(following):
        one, other = lines[k], lines[after]
        if one is other:
            continue
        near = 0.5 * (arc.points[runs[k][1]] + arc.points[runs[after][0]])
        sine = abs(float(one.normal[0] * other.normal[1] - one.normal[1] * other.normal[0]))
        limit = _CORNER_MOVE
        if min(one.count, other.count) >= 8:
            limit = min(_CORNER_MOVE / max(sine, 1e-6), _SHARP_CORNER_MOVE)
        corner = crossing(one, other)
        if corner is None or np.hypot(*(corner - near)) > limit:
            corner = meeting([one, other], near, _CORNER_MOVE)
        corners.append(corner)
    if arc.closed:
        return (
            _without_short_sides(np.array([*corners, corners[0]]))
            if len(corners) >= 3
            else arc.path.astype(float)
        )
    return _without_short_sides(np.array([nodes[arc.ends[0]], *corners, nodes[arc.ends[1]]]))


def _without_short_sides(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """The polyline without corners that lie close to the one before; its ends stay."""
    kept = [line[0]]
    for corner in line[1:-1]:
        if np.hypot(*(corner - kept[-1])) >= _SHORTEST_SIDE:
            kept.append(corner)
    if len(kept) > 1 and np.hypot(*(line[-1] - kept[-1])) < _SHORTEST_SIDE:
        kept.pop()
    return np.array([*kept, line[-1]])


def _assemble(
    arcs: list[Arc],
    lines: list[NDArray[np.float64]],
    piece_label: NDArray[np.int64],
    pixels: NDArray[np.float64],
) -> tuple[list[tuple[int, shapely.Polygon]], set[int]]:
    """Polygons of the ground, and the arcs that cross or enclose a wrong area."""
    drawn = [shapely.LineString(line) for line in lines]
    bad = {k for k, line in enumerate(drawn) if not line.is_simple or line.length == 0.0}
    for k, other in shapely.STRtree(drawn).query(drawn, predicate="intersects").T.tolist():
        if k < other:
            common = shapely.get_coordinates(shapely.intersection(drawn[k], drawn[other]))
            ends = {tuple(lines[k][0]), tuple(lines[k][-1])} & {
                tuple(lines[other][0]),
                tuple(lines[other][-1]),
            }
            if any(tuple(point) not in ends for point in common.tolist()):
                bad |= {k, other}
    polygons: list[tuple[int, shapely.Polygon]] = []
    for piece in np.flatnonzero(piece_label).tolist():
        mine = [k for k, arc in enumerate(arcs) if piece in arc.pieces]
        area = shapely.build_area(shapely.MultiLineString([drawn[k] for k in mine]))
        parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon"]
        whole = len(parts) == 1 and parts[0].is_valid
        if not whole or abs(area.area - pixels[piece]) > 0.6 * math.fsum(drawn[k].length for k in mine):
            bad |= set(mine)
        polygons += [(int(piece_label[piece]), part) for part in parts]
    return polygons, bad
