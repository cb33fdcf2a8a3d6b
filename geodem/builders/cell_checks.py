"""What is looked at before a periodic cell is taken."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.assembly import Cell, Wall
from geodem.boundaries.cell import refuse_thin
from geodem.errors import InputError

Floats = NDArray[np.float64]

FLATTEST = 1e-6
"""Volume of a cell over the product of its edges, below which they lie in a plane by mistake."""
ALONG = 1e-9
"""Sine of the angle between a wall's plane and a periodic edge that is rounding."""


def make_cell(dimension: int, vectors: ArrayLike, periodic: bool | Sequence[bool]) -> Cell:
    """A cell from sides (d,) or edges (d, d) [m]; raises InputError where they do not span one."""
    d = dimension
    try:
        given = np.asarray(vectors, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("cell", "these are not numbers", "Give metres.", value=vectors) from None
    if given.shape not in ((d,), (d, d)):
        raise InputError(
            "cell", f"an array of shape {given.shape} does not hold the edges of a cell in {d}D",
            f"Give {d} sides, or {d} rows of {d}, in metres.",
        )  # fmt: skip
    if not np.isfinite(given).all():
        raise InputError("cell", "its edges are not finite", "Give metres.", value=given.tolist())
    edges = np.diag(given) if given.ndim == 1 else given.copy()
    lengths = np.sqrt((edges**2).sum(axis=1))
    volume = float(np.linalg.det(edges))
    if not lengths.all() or abs(volume) < FLATTEST * float(lengths.prod()):
        raise InputError("cell", "its edges span no volume", "Give independent edges.", value=given.tolist())
    if volume < 0.0:
        raise InputError(
            "cell", "its edges are left-handed" if given.ndim == 2 else "a side is negative",
            "Exchange two edges, or give positive sides.", value=given.tolist(),
        )  # fmt: skip
    flags = np.asarray(periodic)
    if flags.dtype != bool or flags.shape not in ((), (d,)):
        raise InputError(
            "periodic",
            "this is not true or false for every edge",
            f"Give {d} of them, or one.",
            value=periodic,
        )
    along = tuple(bool(each) for each in np.broadcast_to(flags, (d,)))
    if not any(along):
        raise InputError("periodic", "no edge is periodic", "Leave the cell out.", value=periodic)
    return Cell(edges, along)


def cell_errors(cell: Cell, radii: Floats, walls: Sequence[Wall], *, anchored: bool) -> list[InputError]:
    """What does not go together with a periodic cell: particles too large, anchors, walls across it."""
    errors = []
    try:
        refuse_thin(cell.vectors, cell.periodic, 2.0 * float(radii.max()))
    except InputError as error:
        errors.append(error)
    if anchored:
        errors.append(
            InputError(
                "anchor", "in a periodic cell a point in space has images", "Bond it, or leave the cell out."
            )
        )
    edges = cell.vectors[np.array(cell.periodic)]
    edges = edges / np.sqrt((edges**2).sum(axis=1))[:, None]
    for wall in walls:
        if len(wall.segments) or len(wall.triangles):
            problem, remedy = "segments and triangles have no images in a periodic cell", "Use planes."
        elif len(wall.planes) and (np.abs(wall.planes[:, 1] @ edges.T) > ALONG).any():
            problem = "its plane cuts an edge along which the cell is periodic"
            remedy = "Lay it along the periodic edges, or give set_cell periodic=False for the edge that it bounds."
        else:
            continue
        errors.append(InputError(f"wall {wall.name!r}", problem, remedy))
    return errors
