"""LIGGGHTS' convention (3.8.0), from its documentation and its answers.

Slip is measured at the middle of the overlap; a remembered vector is laid across the normal anew, not turned about it
and not brought back to its size. Velocities are those at the start, as velocity Verlet wants it, and the first forces
act for half a step. Local damping does not exist there.

Reference: Kloss et al. (2012), Models, algorithms and validation for opensource DEM and CFD-DEM, Prog. Comput. Fluid
Dyn. 12:140-152.
"""

from __future__ import annotations

from .end_of_step import parting_velocity, relative_motion

NAME = "liggghts"
VELOCITIES_BEFORE = False
AT_MIDDLE = False

__all__ = [
    "branches",
    "half_turn",
    "parting_velocity",
    "relative_motion",
    "spin_about",
    "transported",
    "wall_branches",
]


def branches(distance, radius_a, radius_b):
    """Factor on the relative velocity of the centres [-], and the arms of the spins [m], for the slip."""
    arm_a = 0.5 * (distance + radius_a - radius_b)
    return 1.0, arm_a, distance - arm_a


def wall_branches(distance, radius):
    """The same of a sphere that touches a wall, to the middle of the overlap, and the arm of the force [m]."""
    return 1.0, 0.5 * (radius + distance), 0.5 * (radius + distance)


def half_turn(dx, dy, dz, distance, nx, ny, nz, dvx, dvy, dvz, along, lapse):
    """Nothing: the change of the normal is not asked for."""
    return 0.0, 0.0, 0.0


def spin_about(nx, ny, nz, turn_x, turn_y, turn_z, sum_x, sum_y, sum_z, lapse):
    """Nothing: a contact does not turn about its normal."""
    return 0.0


def transported(x, y, z, nx, ny, nz, turn_x, turn_y, turn_z, spin):
    """A remembered vector s without its part along the normal: s - (s.n) n."""
    out = x * nx + y * ny + z * nz
    return x - out * nx, y - out * ny, z - out * nz
