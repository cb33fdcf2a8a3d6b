"""Caving ground: what was drawn, how it swelled, how the surface sank and how far beyond the opening."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Floats = NDArray[np.float64]


class Subsidence(NamedTuple):
    """How far a surface sank.

    Attributes
    ----------
    place : (k,) [m]
        Middle of every column.
    depth : (k,) [m]
        Positive downwards; nan where a column is empty now or was.
    """

    place: Floats
    depth: Floats

    @property
    def greatest(self) -> float:
        """[m]"""
        return float(np.nanmax(self.depth))

    @property
    def centre(self) -> float:
        """Centre of the trough: mean place, weighted by what sank [m]."""
        sunk = np.maximum(np.nan_to_num(self.depth), 0.0)
        return float((sunk * self.place).sum() / sunk.sum()) if sunk.any() else float("nan")

    @property
    def area(self) -> float:
        """Of the trough [m2]."""
        width = float(self.place[1] - self.place[0])
        return float(np.maximum(np.nan_to_num(self.depth), 0.0).sum()) * width

    def angle_of_draw(self, edge: float, depth: float, *, share: float = 0.05) -> float:
        """From the edge of an opening to the end of the trough, off the vertical [rad], positive outwards.

        Parameters
        ----------
        edge : float [m]
            Of the opening, whose inside is on the side of the trough's centre.
        depth : float [m]
            Of that edge below the surface.
        share : float
            The trough ends where this share of its greatest depth is left [-]; in between columns straight.

        Raises
        ------
        InputError
            A depth or share that cannot be; nothing sank, or the trough reaches the end of what was measured.
        """
        for name, value, most in (("depth", depth, math.inf), ("share", share, 1.0)):
            if not (math.isfinite(value) and 0.0 < value < most):
                raise InputError(f"angle of draw, {name}", "this cannot be", "Give more than 0", value=value)
        if not self.greatest > 0.0:
            raise InputError("angle of draw", "nothing sank", "Measure the surface when it has")
        # from the middle of the trough outwards, over the edge
        outwards = -1.0 if self.centre > edge else 1.0
        order = np.argsort(outwards * self.place)
        place = outwards * self.place[order]
        left = np.nan_to_num(self.depth[order]) - share * self.greatest
        last = int(np.flatnonzero(left >= 0.0)[-1])
        if last == len(place) - 1:
            raise InputError(
                "angle of draw", "the trough reaches the end of the surface", "Take a wider body"
            )
        end = place[last] + (place[last + 1] - place[last]) * left[last] / (left[last] - left[last + 1])
        return math.atan2(end - outwards * edge, depth)


def subsidence(
    before: Floats, radii_before: Floats, now: Floats, radii_now: Floats, *, columns: int = 20
) -> Subsidence:
    """Fall of the upper side of discs, in columns of equal width over where they were.

    Parameters
    ----------
    before, now : (n, 2), (m, 2) [m]
        Centres; other discs now where some were taken away.
    radii_before, radii_now : (n,), (m,) [m]
    columns : int

    Raises
    ------
    InputError
        Fewer than two columns.
    """
    if columns < 2:
        raise InputError("columns", "a trough has a width", "Give 20.", value=columns)
    edges = np.linspace(before[:, 0].min(), before[:, 0].max(), columns + 1)
    sunk = _top(before, radii_before, edges) - _top(now, radii_now, edges)
    return Subsidence(0.5 * (edges[1:] + edges[:-1]), sunk)


def drawn(positions: Floats, mass: Floats, level: float) -> float:
    """Mass of what lies below a level [kg, kg/m]; the last coordinate is upwards."""
    return float(mass[positions[:, -1] < level].sum())


def swelling(
    before: Floats, radii_before: Floats, box_before: Floats, now: Floats, radii_now: Floats, box_now: Floats
) -> float:
    """Volume of broken rock over the volume that it had: the solid share of a box before over that of a box now [-].

    Parameters
    ----------
    before, now : (n, d), (m, d) [m]
        Centres.
    radii_before, radii_now : (n,), (m,) [m]
    box_before, box_now : (2, d) [m]
        Corners of a box that was, and of one that is, filled; many particles across, for those whose centres lie in it
        count as a whole.

    Raises
    ------
    InputError
        No particle in one of the boxes.
    """
    shares = []
    for name, where, radii, box in (
        ("before", before, radii_before, box_before),
        ("now", now, radii_now, box_now),
    ):
        low, high = np.asarray(box, dtype=np.float64)
        inside = ((where >= low) & (where < high)).all(axis=1)
        if not inside.any():
            raise InputError(f"box, {name}", "there is no particle in it", "Mend its corners")
        d = where.shape[1]
        solid = (math.pi if d == 2 else 4.0 / 3.0 * math.pi) * (radii[inside] ** d).sum()
        shares.append(float(solid / np.prod(high - low)))
    return shares[0] / shares[1]


def _top(where: Floats, radii: Floats, edges: Floats) -> Floats:
    column = np.searchsorted(edges, where[:, 0], side="right") - 1
    column = np.where(where[:, 0] == edges[-1], len(edges) - 2, column)
    inside = (column >= 0) & (column < len(edges) - 1)
    top = np.full(len(edges) - 1, -np.inf)
    np.maximum.at(top, column[inside], (where[:, 1] + radii)[inside])
    return np.where(np.isfinite(top), top, np.nan)
