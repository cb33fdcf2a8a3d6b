"""Ground that yields, against closed forms and limit analysis: `python -m reference run ground`."""

from __future__ import annotations

from .ground_collapse import footing_plate, footing_pressure, tunnel
from .ground_elastic import geostatic, kirsch, lame
from .rows import Row

PARTICLES = (2500, 10_000)


def run() -> list[Row]:
    """Every problem at every number of particles; the names say how many."""
    rows: list[Row] = []
    for particles in PARTICLES:
        found = [*geostatic(particles), *kirsch(particles), *lame(particles)]
        found += [
            tunnel(cover, kind, particles) for cover in (1.0, 2.0) for kind in ("surcharge", "self-weight")
        ]
        for friction in (0.0, 30.0):
            found.append(footing_pressure(friction, particles))
            for rough in (True, False):
                found += footing_plate(friction, particles, rough=rough)
        rows += [row._replace(name=f"{row.name}, {particles} particles") for row in found]
    return rows
