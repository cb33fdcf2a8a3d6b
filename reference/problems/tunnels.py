"""Tunnels in ground that yields, against closed forms and limit analysis: `python -m reference run tunnels`."""

from __future__ import annotations

from .rows import Row
from .tunnels_deep import bolts, convergence, far_boundary, grown_yield, lining, reaction_curve, two_stages
from .tunnels_shallow import COLLAPSE, collapse_pressure, shallow_strength, shallow_surcharge

PARTICLES = (1200, 2500, 5000, 10_000)


def run() -> list[Row]:
    """Every problem; the names say how many particles."""
    rows: list[Row] = []
    for particles in PARTICLES:
        rows += convergence(30.0, particles)
    for particles in PARTICLES:
        rows += grown_yield(particles)
    rows += far_boundary()
    rows += reaction_curve(5000)
    rows += lining(5000)
    rows += bolts(5000)
    rows += two_stages(2500)
    for cover, weight in COLLAPSE:
        rows += [
            shallow_surcharge(cover, weight, 5000),
            shallow_strength(cover, weight, 5000),
        ]
    for cover in (1.0, 2.0, 3.0):
        rows += collapse_pressure(cover, 0.0, 5000)
    return rows
