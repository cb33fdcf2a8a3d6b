"""Caving ground: what was drawn, how the surface sank."""

from __future__ import annotations

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


def _top(where: Floats, radii: Floats, edges: Floats) -> Floats:
    column = np.searchsorted(edges, where[:, 0], side="right") - 1
    column = np.where(where[:, 0] == edges[-1], len(edges) - 2, column)
    inside = (column >= 0) & (column < len(edges) - 1)
    top = np.full(len(edges) - 1, -np.inf)
    np.maximum.at(top, column[inside], (where[:, 1] + radii)[inside])
    return np.where(np.isfinite(top), top, np.nan)
