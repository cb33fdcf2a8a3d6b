"""Lac du Bonnet granite of Potyondy & Cundall (2004) in 3D: the same tests on two specimens of 18,000 spheres."""

from __future__ import annotations

from .laboratory_granite import SPHERES, rows_of
from .rows import Row

SEEDS = (1, 2)


def run() -> list[Row]:
    """Two specimens of spheres, half an hour."""
    return rows_of(SPHERES, SEEDS)
