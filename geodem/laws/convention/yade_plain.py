"""YADE's convention without its device against granular ratcheting (avoidGranularRatcheting=False, noRatch=False).

Slip is measured where the surfaces meet, as geodem does; all else as in `geodem.laws.convention.yade`.
"""

from __future__ import annotations

from .end_of_step import parting_velocity, relative_motion
from .yade import half_turn, spin_about, transported

__all__ = [
    "branches",
    "half_turn",
    "parting_velocity",
    "relative_motion",
    "spin_about",
    "transported",
    "wall_branches",
]

NAME = "yade-plain"
VELOCITIES_BEFORE = True
AT_MIDDLE = True


def branches(distance, radius_a, radius_b):
    """Factor on the relative velocity of the centres [-], and the arms of the spins [m], for the slip."""
    arm_a = 0.5 * (distance + radius_a - radius_b)
    return 1.0, arm_a, distance - arm_a


def wall_branches(distance, radius):
    """The same of a sphere that touches a wall, and the arm of the force on the sphere [m]."""
    return 1.0, distance, 0.5 * (radius + distance)
