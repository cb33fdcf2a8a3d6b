"""How many steps a plan of digging still takes, for the time left that is told.

How many increments there are is known from the plan. Each takes longer than the one before, as ever more ground
yields: on the tunnels of the reference problems from 4 to 12 steps times the root of the number of particles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .plan import Plan

PRESSURE_WAY = 0.5
"""A stage that changes a pressure counts at least as this share of the kept forces."""

FIRST = 5.0
"""Steps of an increment over the root of the number of particles, before there was one."""

GROWTH = 0.55
"""Of the steps of an increment over half of all increments."""

WITHOUT = 0.85
"""Steps of all increments without supports over those with them."""


def increments_of(way: float, increments: int) -> int:
    """Increments of a stage that relaxes this share of the kept forces, where all of them take so many."""
    return max(1, math.ceil(increments * way - 1e-9))


def increments_of_plan(plan: Plan, increments: int) -> list[int]:
    """Increments of every stage of a plan, if nothing collapses."""
    shares: dict[int, float] = {}
    pressures: dict[int, float] = {}
    found = []
    for stage in plan.stages:
        for name in stage.excavate:
            shares[plan.opening(name)], pressures[plan.opening(name)] = 1.0, 0.0
        chosen = list(shares) if stage.opening is None else [plan.opening(stage.opening)]
        if not chosen or (stage.relax is None and stage.pressure is None):
            found.append(0)
            continue
        after = {k: shares[k] if stage.relax is None else 1.0 - stage.relax for k in chosen}
        pressed = {k: pressures[k] if stage.pressure is None else stage.pressure for k in chosen}
        way = max(abs(after[k] - shares[k]) for k in chosen)
        if pressed != {k: pressures[k] for k in chosen}:
            way = max(way, PRESSURE_WAY)
        shares |= after
        pressures |= pressed
        found.append(increments_of(way, increments))
    return found


def steps_left(taken: Sequence[int], increments: int, particles: int) -> float:
    """Steps of the increments that are still to come.

    Parameters
    ----------
    taken : sequence of int
        Steps of those that are done, of all stages.
    increments : int
        Of all stages.
    particles : int
    """
    left = increments - len(taken)
    if left <= 0:
        return 0.0
    last = taken[-2:]
    each = sum(last) / len(last) if last else FIRST * math.sqrt(particles)
    return left * each * (1.0 + GROWTH * left / increments)
