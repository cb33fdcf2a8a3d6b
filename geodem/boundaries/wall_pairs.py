"""The list of particles near walls: which primitives each particle may touch before the next search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from ..assembly import Wall
from ..errors import InputError, InputErrors
from ..kernels.wall_geometry import BODY_CENTRE, BODY_DISPLACEMENT, BODY_EXTENT, WALL_CONSTANTS
from ..kernels.wall_search import SEARCH_FUNCTIONS
from .wall_table import WallTable

Floats = NDArray[np.float64]

CELLS_PER_PRIMITIVE = 4
"""Cells of the grid over bounded primitives, at most."""
SERVO_REACH = 1.0
"""Diameters of the largest particle that a servo wall may be away from the particles at the start."""


@dataclass
class WallPairs:
    """Pairs of a particle and a primitive, by particle and then by primitive.

    Attributes
    ----------
    chunk : int
        Particles per chunk.
    start : (chunks + 1,) int64
        First pair of every chunk.
    row : (n + 1,) int64
        First pair of every particle.
    particle, primitive : (w,) uint32
    touching : (w,) uint8
        1 while the two touched in the last step.
    history : (w, H) float64
        What the law remembers of the pair.
    normal : (w, 3) float64
        Contact normal in the last step.
    geometry : (w, 4) float64, feature : (w,) int8
        Overwritten in every step: normal and distance; where on the primitive, -1: no contact.
    """

    chunk: int
    start: NDArray[np.int64]
    row: NDArray[np.int64]
    particle: NDArray[np.uint32]
    primitive: NDArray[np.uint32]
    touching: NDArray[np.uint8]
    history: Floats
    normal: Floats
    geometry: Floats
    feature: NDArray[np.int8]

    @classmethod
    def allocate(cls, row: NDArray[np.int64], *, chunk: int, history_width: int) -> WallPairs:
        """A list with room for the pairs that `row` (n + 1,) counts, none of them touching."""
        particles, pairs = len(row) - 1, int(row[-1])
        edges = np.minimum(np.arange((particles + chunk - 1) // chunk + 1) * chunk, particles)
        return cls(
            chunk=chunk,
            start=row[edges],
            row=row,
            particle=np.zeros(pairs, dtype=np.uint32),
            primitive=np.zeros(pairs, dtype=np.uint32),
            touching=np.zeros(pairs, dtype=np.uint8),
            history=np.zeros((pairs, history_width)),
            normal=np.zeros((pairs, 3)),
            geometry=np.zeros((pairs, 4)),
            feature=np.full(pairs, -1, dtype=np.int8),
        )

    @classmethod
    def empty(cls, particles: int, *, chunk: int, history_width: int) -> WallPairs:
        """A list without pairs."""
        return cls.allocate(np.zeros(particles + 1, dtype=np.int64), chunk=chunk, history_width=history_width)


def find_wall_pairs(
    now: Floats,
    table: WallTable,
    *,
    buffer: float,
    chunk: int,
    history_width: int,
    old: WallPairs | None = None,
    old_row_of_new: NDArray[np.int64] | None = None,
) -> WallPairs:
    """Pairs whose gap is below `buffer` [m], with touch and history of those in the old list.

    Parameters
    ----------
    now : (n, 8) or (n, 12)
        Rows of the particles.
    buffer : float
        How far a particle and a wall may move towards each other before the next search, and how far the law reaches
        beyond touch [m].
    old_row_of_new : (n,) int64, optional
        Row of every particle in the old list, -1 for a new one; where it is None the order has not changed.
    """
    particles, radius = len(now), 2 if table.dimension == 2 else 3
    _extend_planes(now, table, radius)
    if len(table.kind) == 0 or particles == 0:
        return WallPairs.empty(particles, chunk=chunk, history_width=history_width)
    kernel = _kernel(table.dimension, table.walls_turn)
    corners = table.corners_now()
    corners[table.kind == 1, 2] = corners[table.kind == 1, 0]
    low, high = corners.min(axis=1), corners.max(axis=1)
    flat = table.kind == 0
    low[flat], high[flat] = 1.0, 0.0
    reach = 2.0 * (float(np.median(now[:, radius])) + buffer)
    origin, cell, cells = _grid(low[~flat], high[~flat], reach)
    start = np.zeros(int(np.prod(cells)) + 1, dtype=np.int64)
    kernel.bin_boxes(low, high, origin, cell, cells, start, np.empty(0, dtype=np.int64))
    start = np.cumsum(start)
    entries = np.empty(int(start[-1]), dtype=np.int64)
    if len(entries):
        kernel.bin_boxes(low, high, origin, cell, cells, start[:-1].copy(), entries)
    grid = (
        chunk, now, float(buffer), np.flatnonzero(flat), low, high, origin, cell, cells, start, entries,
        table.shape, table.kind, table.body, table.bodies,
    )  # fmt: skip
    counts = np.zeros(particles + 1, dtype=np.int64)
    kernel.count_wall_pairs(*grid, counts[1:])
    found = WallPairs.allocate(np.cumsum(counts), chunk=chunk, history_width=history_width)
    if old is None:
        old = WallPairs.empty(0, chunk=chunk, history_width=history_width)
        old_row_of_new = np.full(particles, -1, dtype=np.int64)
    elif old_row_of_new is None:
        old_row_of_new = np.arange(particles, dtype=np.int64)
    kernel.write_wall_pairs(
        *grid, found.row, found.particle, found.primitive, found.touching, found.history, found.normal,
        old_row_of_new, old.row, old.primitive, old.touching, old.history, old.normal,
    )  # fmt: skip
    return found


def check_servo_contact(
    now: Floats, table: WallTable, walls: Sequence[Wall], *, reach: float | None = None
) -> None:
    """Raise InputError for a servo wall with no particle within `reach` [m]: it would only run at its speed limit.

    reach: where it is None, SERVO_REACH diameters of the largest particle. To be called before the first step.
    """
    if not any(wall.servo for wall in walls):
        return
    radii = now[:, 2 if table.dimension == 2 else 3]
    if reach is None:
        reach = SERVO_REACH * 2.0 * float(radii.max(initial=0.0))
    pairs = find_wall_pairs(now, table, buffer=reach, chunk=max(len(now), 1), history_width=1)
    touched = np.unique(table.body[pairs.primitive])
    errors = [
        InputError(
            f"wall {wall.name!r}, servo",
            f"no particle is within {reach:.6g} m of the wall, so there is no force to control",
            "Move the wall to the particles, or give it a velocity instead of a servo.",
        )
        for number, wall in enumerate(walls)
        if wall.servo is not None and number not in touched
    ]
    if errors:
        raise InputErrors(errors) if len(errors) > 1 else errors[0]


def contact_sum(table: WallTable, pairs: WallPairs, values: Floats) -> Floats:
    """Sum over each body's touching pairs of a value (w,) per pair, (b,): of kn for the gain of a servo, say."""
    owner = table.body[pairs.primitive]
    return np.bincount(owner, weights=values * pairs.touching, minlength=len(table.bodies)).astype(np.float64)


@cache
def _kernel(dimension: int, walls_turn: bool) -> ModuleType:
    constants = {
        **WALL_CONSTANTS,
        "SPACE": dimension == 3,
        "RADIUS": dimension if dimension == 3 else 2,
        "WALLS_TURN": walls_turn,
        "FACETS": True,
    }
    return _jit.compile_kernel(SEARCH_FUNCTIONS, constants, parallel=True)


def _extend_planes(now: Floats, table: WallTable, radius: int) -> None:
    """An infinite plane that turns moves fastest where particles are farthest from its centre."""
    if not table.walls_turn or len(now) == 0:
        return
    places = np.zeros((len(now), 3))
    places[:, : table.dimension] = now[:, : table.dimension]
    for owner in np.unique(table.body[table.kind == 0]):
        b = table.bodies[owner]
        centre = b[BODY_CENTRE : BODY_CENTRE + 3] + b[BODY_DISPLACEMENT : BODY_DISPLACEMENT + 3]
        farthest = float((np.linalg.norm(places - centre, axis=1) + now[:, radius]).max())
        b[BODY_EXTENT] = max(b[BODY_EXTENT], farthest)


def _grid(low: Floats, high: Floats, reach: float) -> tuple[Floats, float, NDArray[np.int64]]:
    """Origin, size and numbers of the cells over boxes; cells as large as what is asked about and as most boxes."""
    if len(low) == 0:
        return np.zeros(3), 1.0, np.ones(3, dtype=np.int64)
    origin, extent = low.min(axis=0), high.max(axis=0) - low.min(axis=0)
    cell = max(reach, float((high - low).max(axis=1).mean()))
    while True:
        cells = np.maximum(np.ceil(extent / cell), 1.0)
        if cells.prod() <= CELLS_PER_PRIMITIVE * len(low) + 1:
            return origin, cell, cells.astype(np.int64)
        cell *= 1.25
