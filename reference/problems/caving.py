"""Caving ground: `python -m reference run caving`.

Dry broken rock drawn through one opening, after Nedderman & Tuzun (`caving_draw`).
"""

from __future__ import annotations

import numpy as np

from .caving_draw import Draw, drawn, measured_zone, spreading, zone
from .rows import Row, at_most, relative

SEEDS = (1, 2)
"""Arrangements of dry rock that are drawn."""


def within(
    name: str, quantity: str, value: float, low: float, high: float, seconds: float, source: str
) -> Row:
    """A row whose error is how far a value lies outside a published range, over the nearer end of it."""
    nearest = min(max(value, low), high)
    return Row(
        name, quantity, value, nearest, value / nearest - 1.0, 1e-9, seconds, f"{low:g} to {high:g}: {source}"
    )


def rows_of_draw(draws: list[Draw]) -> list[Row]:
    """Velocities, and where what was drawn was."""
    own = np.array([spreading(each.speed).mean() for each in draws])
    b = float(own.mean())
    kinematic = "Nedderman & Tuzun (1979), B as measured"
    zones = np.array([measured_zone(each) for each in draws]).mean(axis=0)
    height, width = zone(float(np.mean([each.area for each in draws])), b)
    level = np.mean([spreading(each.speed) for each in draws], axis=0)
    seeds = f"mean of {len(draws)} arrangements"
    rows = [
        within(
            "dry rock drawn", "B of the velocities downwards, over the mean diameter [-]", b, 1.3, 3.5,
            sum(each.seconds for each in draws), "Nedderman & Tuzun (1979), Choi et al. (2005)",
        ),
        at_most(
            "dry rock drawn", "B from level to level: largest difference from its mean, over it [-], at most",
            float(np.abs(level / level.mean() - 1.0).max()), 0.25, 0.0, "one B for all: Nedderman & Tuzun (1979)",
        ),
        relative(
            "dry rock drawn", f"height of the zone it came from, in diameters [-], {seeds}", float(zones[0]), height,
            0.15, 0.0, kinematic,
        ),
        relative(
            "dry rock drawn", f"greatest width of that zone, in diameters [-], {seeds}", float(zones[1]), width, 0.15,
            0.0, kinematic,
        ),
    ]  # fmt: skip
    lost = max(abs(sum(each.masses[1:]) / each.masses[0] - 1.0) for each in draws)
    return [*rows, at_most("dry rock drawn", "mass lost, over all [-]", lost, 1e-12, 0.0, "none is lost")]


def run() -> list[Row]:
    """All of it."""
    return rows_of_draw([drawn(seed) for seed in SEEDS])
