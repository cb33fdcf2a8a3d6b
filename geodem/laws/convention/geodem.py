"""geodem's own convention: slip at the middle of the overlap, the frame turned to second order in the step.

A rigid motion of the pair is no slip, and what a contact remembers keeps its size and stays across the normal.
"""

from __future__ import annotations

NAME = "geodem"
VELOCITIES_BEFORE = False
AT_MIDDLE = False


def branches(distance, radius_a, radius_b):
    """Factor on the relative velocity of the centres [-], and the arms of the spins [m], for the slip."""
    arm_a = 0.5 * (distance + radius_a - radius_b)
    return 1.0, arm_a, distance - arm_a


def wall_branches(distance, radius):
    """The same of a sphere that touches a wall, and the arm of the force on the sphere [m]."""
    return 1.0, distance, distance


def half_turn(dx, dy, dz, distance, nx, ny, nz, dvx, dvy, dvz, along, lapse):
    """Half the change of the normal n since the laws were last asked, from the relative velocity dv."""
    inverse = 1.0 / distance
    return (
        (dvx - along * nx) * inverse * (0.5 * lapse),
        (dvy - along * ny) * inverse * (0.5 * lapse),
        (dvz - along * nz) * inverse * (0.5 * lapse),
    )


def spin_about(nx, ny, nz, turn_x, turn_y, turn_z, sum_x, sum_y, sum_z, lapse):
    """Angle by which the contact turns about its normal: half the sum of the spins [rad]."""
    return 0.5 * lapse * (sum_x * nx + sum_y * ny + sum_z * nz)


def transported(x, y, z, nx, ny, nz, turn_x, turn_y, turn_z, spin):
    """A remembered vector s turned with the contact, to second order.

    With h half the change of n and w the spin about n: s' = s - (s.n)(n - h), then (1 - w^2/2) s' + w n x s'.
    """
    out = x * nx + y * ny + z * nz
    x -= out * (nx - turn_x)
    y -= out * (ny - turn_y)
    z -= out * (nz - turn_z)
    keep = 1.0 - 0.5 * spin * spin
    return (
        keep * x + spin * (ny * z - nz * y),
        keep * y + spin * (nz * x - nx * z),
        keep * z + spin * (nx * y - ny * x),
    )
