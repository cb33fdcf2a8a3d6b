"""Joints, bolts and initial stress in bonded particles: `python -m reference run ground-joints`."""

from __future__ import annotations

import math

from . import ground_bolts, ground_initial_stress
from .ground_jaeger import ANGLES, intact, jaeger
from .ground_priest import priest
from .rows import Row

ACROSS = 30.0
"""Particles across Jaeger's specimens."""
IN_SPACE = 12.0
"""Of spheres."""


def run() -> list[Row]:
    """Jaeger's specimens at all angles, Priest's block dry and with water, bolts, initial stress."""
    rock = intact(ACROSS)
    return [
        *(jaeger(angle, ACROSS, rock) for angle in ANGLES),
        jaeger(50.0, IN_SPACE, math.inf, 3),
        *priest(wet=False),
        *priest(wet=True),
        *ground_bolts.run(),
        *ground_initial_stress.run(),
    ]
