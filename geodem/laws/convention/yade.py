"""YADE's convention with its default against granular ratcheting (2023.02a), from its documentation and its answers.

Slip is measured with the radii as arms and the velocity of the centres enlarged by (ra + rb)/distance; a remembered
force turns to first order and is not laid across the normal again. Shear begins to add up in the step of the first
touch, by that step's whole velocity. Velocities are those half a step back, also at the start.

References: Smilauer et al. (2021), Yade documentation, 3rd ed., "DEM formulation"; McNamara, Garcia-Rojo & Herrmann
(2008), Microscopic origin of granular ratcheting, Phys. Rev. E 77:031304.
"""

from __future__ import annotations

import math

from .end_of_step import parting_velocity, relative_motion

NAME = "yade"
VELOCITIES_BEFORE = True
AT_MIDDLE = True

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
    return (radius_a + radius_b) / distance, radius_a, radius_b


def wall_branches(distance, radius):
    """The same of a sphere that touches a wall, which counts as another of its size, and the arm of the force [m]."""
    return 2.0 * radius / (radius + distance), radius, 0.5 * (radius + distance)


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
