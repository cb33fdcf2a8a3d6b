"""Direct tension without time: the grips are drawn apart by small steps, and bonds break in equilibrium.

What the slow motion of the laboratory is held to: nothing moves here but from one equilibrium to the next.
"""

from __future__ import annotations

import time
from typing import NamedTuple

from geodem.laboratory.axial import SLOWEST
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import make_specimen
from geodem.particle_statics import displace, find_equilibrium

from .laboratory_points import Point

STEP = 0.02
"""Of the strain of the first break, in tension."""
BALANCED = 1e-3
"""Unbalanced ratio at which equilibrium is found."""
FALL = 0.85
MOST = 200


class Still(NamedTuple):
    """Strength [Pa]; how many bonds broke and how many steps of relaxation it took; whether it failed."""

    strength: float
    broken: int
    steps: int
    failed: bool
    seconds: float


def pull_still(point: Point) -> Still:
    """Tension of a specimen by statics."""
    begun = time.perf_counter()
    specimen = make_specimen(point.dimension, across=point.across, seed=point.seed)
    rig = Rig(specimen, point.material, seed=point.seed)
    rig.solve()
    rig.begin(-SLOWEST)
    top, broken, steps = -rig.axial_stress(), 0, 0
    for _ in range(MOST):
        # the elastic way of the whole specimen: what is broken already is left to the relaxation
        displace(rig.simulation, -STEP * rig.first_break * rig.squeezed)
        found = find_equilibrium(rig.simulation, tolerance=BALANCED, solve=False)
        stress = -rig.axial_stress()
        broken += len(found.broken)
        steps += found.steps
        top = max(top, stress)
        if stress < FALL * top:
            return Still(top, broken, steps, True, time.perf_counter() - begun)
    return Still(top, broken, steps, False, time.perf_counter() - begun)
