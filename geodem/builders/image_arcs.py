"""Cut the boundaries between labelled pixels into arcs, with points at a part of a pixel.

Coordinates are in pixels: x = column and y = row, from the upper left corner of the picture downwards.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.builders.image_labels import LabelImage
from geodem.builders.image_mixtures import blended

# How far a straight outline may pass from a point of it [px]: on stairs half a pixel and some for the fit;
# where mixed pixels place the edge, as much as rounded colours (FINE) or compressed ones (NOISY) are off.
COARSE = 0.62
FINE = 0.2
NOISY = 0.45

_LONGEST_BLEND = 4
Node = tuple[int, int]
_Shifts = tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]


@dataclass
class Arc:
    """Boundary between two pieces, from one meeting point of three or more to the next, or closed.

    Parameters
    ----------
    path : ndarray of int64, shape (n + 1, 2)
        Pixel corners (x, y) along the arc; first and last agree where the arc is closed.
    pieces : tuple of int
        The connected pieces on its two sides; 0 is outside the picture.
    points : ndarray of float64, shape (m, 2)
        Points on the outline [px].
    tolerance : ndarray of float64, shape (m,)
        How far the outline may pass from each point [px].
    """

    path: NDArray[np.int64]
    pieces: tuple[int, int]
    points: NDArray[np.float64]
    tolerance: NDArray[np.float64]

    @property
    def closed(self) -> bool:
        """Whether the arc is a ring without a meeting point."""
        return bool((self.path[0] == self.path[-1]).all()) and not self.at_node

    at_node: bool = False

    @property
    def on_frame(self) -> bool:
        """Whether the arc runs along the edge of the picture."""
        return 0 in self.pieces

    @property
    def ends(self) -> tuple[Node, Node]:
        """Pixel corners at which the arc starts and ends."""
        return (int(self.path[0, 0]), int(self.path[0, 1])), (int(self.path[-1, 0]), int(self.path[-1, 1]))


def find_arcs(image: LabelImage) -> tuple[list[Arc], NDArray[np.int64]]:
    """All arcs of a labelled picture, and the label of each piece.

    Parameters
    ----------
    image : LabelImage
        No two pixels of one label touch only at a corner.

    Returns
    -------
    arcs : list of Arc
        Without those between background and the outside of the picture.
    piece_label : ndarray of int64, shape (pieces + 1,)
        Label of each connected piece; piece 0 is outside the picture and has the label 0.
    """
    from skimage.measure import label

    pieces = np.pad(label(image.labels, background=-1, connectivity=1), 1)
    piece_label = np.zeros(int(pieces.max()) + 1, dtype=np.int64)
    piece_label[pieces[1:-1, 1:-1]] = image.labels
    upright = pieces[1:-1, :-1] != pieces[1:-1, 1:]
    level = pieces[:-1, 1:-1] != pieces[1:, 1:-1]
    shifts = (
        _shifts(image, np.swapaxes(upright, 0, 1), transposed=True),
        _shifts(image, level, transposed=False),
    )

    arcs = []
    for path, at_node in _paths(upright, level):
        sides = _sides(pieces, path[0], path[1])
        if piece_label[sides[0]] == 0 and piece_label[sides[1]] == 0:
            continue
        points, tolerance = _place(path, shifts, at_node, image.lossy)
        arcs.append(Arc(path, sides, points, tolerance, at_node))
    return arcs, piece_label


def _sides(pieces: NDArray[np.int64], start: NDArray[np.int64], end: NDArray[np.int64]) -> tuple[int, int]:
    """Pieces on the two sides of one pixel edge."""
    x, y = np.minimum(start, end) + 1  # the picture is padded by one pixel
    if start[0] == end[0]:
        return int(pieces[y, x - 1]), int(pieces[y, x])
    return int(pieces[y - 1, x]), int(pieces[y, x])


def _paths(upright: NDArray[np.bool_], level: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], bool]]:
    """Walk along the pixel edges: pixel corners of every arc, and whether it ends at meeting points."""
    height, width = upright.shape[0], level.shape[1]
    degree = np.zeros((height + 1, width + 1), dtype=np.int64)
    degree[:-1] += upright
    degree[1:] += upright
    degree[:, :-1] += level
    degree[:, 1:] += level
    edges = {(0, y, x) for y, x in zip(*(axis.tolist() for axis in np.nonzero(level)), strict=True)} | {
        (1, y, x) for y, x in zip(*(axis.tolist() for axis in np.nonzero(upright)), strict=True)
    }
    junction = degree >= 3

    def leaving(x: int, y: int) -> list[tuple[tuple[int, int, int], int, int]]:
        around = (
            ((0, y, x), x + 1, y),
            ((1, y, x), x, y + 1),
            ((0, y, x - 1), x - 1, y),
            ((1, y - 1, x), x, y - 1),
        )
        return [step for step in around if step[0] in edges]

    def walk(x: int, y: int, step: tuple[tuple[int, int, int], int, int]) -> NDArray[np.int64]:
        path = [(x, y)]
        first = (x, y)
        while True:
            edge, x, y = step
            edges.discard(edge)
            path.append((x, y))
            if junction[y, x] or (x, y) == first:
                return np.array(path, dtype=np.int64)
            step = leaving(x, y)[0]

    found: list[tuple[NDArray[np.int64], bool]] = []
    for y, x in zip(*(axis.tolist() for axis in np.nonzero(junction)), strict=True):
        while steps := leaving(x, y):
            found.append((walk(x, y, steps[0]), True))
    for kind, y, x in sorted(edges):
        if (kind, y, x) in edges:
            found.append((walk(x, y, leaving(x, y)[0]), False))
    return found


def _shifts(image: LabelImage, edge: NDArray[np.bool_], transposed: bool) -> _Shifts:
    """Where the outline crosses the column of pixel centres, from each level pixel edge.

    The parts of the pixels that one side covers add up along the column: their sum is the exact mean position
    of a straight outline within the width of the column, however the pixels were labelled. All arrays have
    the shape (rows + 1, columns).

    Returns
    -------
    shift : ndarray of float64
        Downwards [px].
    placed : ndarray of bool
        Whether plain pixels of both colours enclose the mixed ones.
    mixed : ndarray of bool
        Whether a pixel at the edge is mixed.
    """
    classes = image.classes.T if transposed else image.classes
    labels = image.labels.T if transposed else image.labels
    height = classes.shape[0]
    shift = np.zeros(edge.shape)
    placed = np.ones(edge.shape, dtype=bool)
    mixed = np.zeros(edge.shape, dtype=bool)
    rows, columns = np.nonzero(edge)
    inner = (rows > 0) & (rows < height)  # the edge of the picture is where it is
    rows, columns = rows[inner], columns[inner]
    if len(rows) == 0:
        return shift, placed, mixed
    upper = image.palette[classes[rows - 1, columns]]
    lower = image.palette[classes[rows, columns]]
    along = lower - upper
    squared = np.maximum((along**2).sum(axis=1), 1.0)
    plain = 0.12 if image.lossy else 0.03
    total = np.zeros(len(rows))
    enclosed = np.ones(len(rows), dtype=bool)
    blend = np.zeros(len(rows), dtype=bool)
    for downwards in (False, True):
        own = labels[rows, columns] if downwards else labels[rows - 1, columns]
        active = np.ones(len(rows), dtype=bool)
        for k in range(_LONGEST_BLEND + 1):
            row = rows + k if downwards else rows - 1 - k
            inside = (row >= 0) & (row < height)
            active &= inside
            here = np.flatnonzero(active)
            same = labels[row[here], columns[here]] == own[here]
            active[here[~same]] = False
            enclosed[here[~same]] = False
            here = here[same]
            colour = (
                blended(image.pixels, columns[here], row[here])
                if transposed
                else blended(image.pixels, row[here], columns[here])
            )
            part = ((colour - upper[here]) * along[here]).sum(axis=1) / squared[here]
            part = np.clip(part, 0.0, 1.0)  # of the lower side
            foreign = 1.0 - part if downwards else part
            if k == 0:
                blend[here] |= foreign > plain
            total[here] += foreign if downwards else -foreign
            active[here[foreign <= plain]] = False
        enclosed[active] = False
        if not downwards:
            enclosed &= rows > 0
    shift[rows, columns] = np.where(enclosed, total, 0.0)
    placed[rows, columns] = enclosed
    mixed[rows, columns] = blend
    return shift, placed, mixed


def _place(
    path: NDArray[np.int64],
    shifts: tuple[_Shifts, _Shifts],
    at_node: bool,
    lossy: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points of an arc and the tolerance of each."""
    start, end = path[:-1], path[1:]
    low = np.minimum(start, end)
    is_level = start[:, 1] == end[:, 1]
    points = (start + end) / 2.0
    placed = np.ones(len(points), dtype=bool)
    mixed = np.zeros(len(points), dtype=bool)
    for kind, (shift, good, blend) in enumerate(shifts):
        mine = np.flatnonzero(is_level == bool(kind))
        x, y = low[mine].T
        index = (y, x) if kind else (x, y)
        points[mine, kind] += shift[index]
        placed[mine] = good[index]
        mixed[mine] = blend[index]

    # A turn between plain pixels is the step of a stair: its runs place the outline only to half a pixel.
    count = len(points)
    hard = (is_level[1:] != is_level[:-1]) & ~(mixed[1:] | mixed[:-1])
    run = np.r_[0, np.cumsum(is_level[1:] != is_level[:-1])]
    stairs = np.zeros(run[-1] + 1, dtype=bool)
    stairs[run[1:][hard]] = True
    stairs[run[:-1][hard]] = True
    tolerance = np.full(count, NOISY) if lossy else np.where(stairs[run], COARSE, FINE)

    # Edges across the outline see no plain pixel nearby; they count only where no better point is close.
    window = np.convolve(placed, np.ones(5), mode="full")[2 : 2 + count] > 0
    keep = placed | ~window
    if not at_node and keep.sum() < 3:
        keep[:] = True
    tolerance[~placed] = COARSE + (NOISY if lossy else 0.0)
    return points[keep], tolerance[keep]
