"""YADE's convention without its device against granular ratcheting (avoidGranularRatcheting=False, noRatch=False).

Slip is measured where the surfaces meet, as geodem does; all else as in `geodem.laws.convention.yade`.
"""

from __future__ import annotations

import math

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


def half_turn(dx, dy, dz, distance, nx, ny, nz, dvx, dvy, dvz, along, lapse):
    """Half the change of the normal n since the laws were last asked, from where the centres were."""
    x = dx - dvx * lapse
    y = dy - dvy * lapse
    z = dz - dvz * lapse
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    return 0.5 * (nx - x * inverse), 0.5 * (ny - y * inverse), 0.5 * (nz - z * inverse)


def spin_about(nx, ny, nz, turn_x, turn_y, turn_z, sum_x, sum_y, sum_z, lapse):
    """Angle by which the contact turns about its old normal: half the sum of the spins [rad]."""
    return (
        0.5
        * lapse
        * (sum_x * (nx - 2.0 * turn_x) + sum_y * (ny - 2.0 * turn_y) + sum_z * (nz - 2.0 * turn_z))
    )


def transported(x, y, z, nx, ny, nz, turn_x, turn_y, turn_z, spin):
    """A remembered vector s turned with the contact, m the old normal: s + (m x n) x s, then s + w m x s."""
    mx = nx - 2.0 * turn_x
    my = ny - 2.0 * turn_y
    mz = nz - 2.0 * turn_z
    ox = my * nz - mz * ny
    oy = mz * nx - mx * nz
    oz = mx * ny - my * nx
    tx = x + oy * z - oz * y
    ty = y + oz * x - ox * z
    tz = z + ox * y - oy * x
    return (
        tx + spin * (my * tz - mz * ty),
        ty + spin * (mz * tx - mx * tz),
        tz + spin * (mx * ty - my * tx),
    )
