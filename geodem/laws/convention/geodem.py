"""geodem's own convention: slip at the middle of the overlap, the frame turned to second order in the step.

Velocities are those of the middle of a step, and so are the normal and the arms that they are set against: a rigid
motion of the pair over a step, of any direction, is no slip and no approach to the fourth order in its angle. What a
contact remembers keeps its size and stays across the normal to second order.
"""

from __future__ import annotations

import math

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


def parting_velocity(swept, half):
    """Change of the distance over the step [m/s]: swept = (d1^2 - d0^2)/(2 d1 lapse), half = lapse/(2 d1) [s/m].

    What a law adds up from step to step is then that of the distance itself, exactly: (d1 - d0)/lapse.
    """
    return 2.0 * swept / (1.0 + math.sqrt(abs(1.0 - 4.0 * swept * half)))


def relative_motion(distance, nx, ny, nz, dvx, dvy, dvz, along, enlarged, wx, wy, wz, turned, lapse):
    """Velocities of approach, negative, and slip [m/s]: dv = vb - va, w = arm_a wa + arm_b wb, turned = |wa + wb|^2.

    With m = n - dv lapse/(2 d), half the sum of the old and the new branch over the new distance, a rigid turn by the
    angle t moves b against a by 2 tan(t/2) across m: spins count by 2 tan(t/2)/t. What is along m is no slip, and what
    remains is laid across n.
    """
    half = 0.5 * lapse / distance
    mx = nx - dvx * half
    my = ny - dvy * half
    mz = nz - dvz * half
    # the largest of two ends what the compiler may multiply in another order from kernel to kernel
    angle = max(math.sqrt(turned) * lapse, 1e-30)
    chord = math.sqrt(1.0 + angle * angle * (1.0 / 24.0))
    vx = dvx - chord * (wy * mz - wz * my)
    vy = dvy - chord * (wz * mx - wx * mz)
    vz = dvz - chord * (wx * my - wy * mx)
    # m over m.n, to second order: exactly n where the line of centres does not turn
    lx = nx - (dvx - along * nx) * half
    ly = ny - (dvy - along * ny) * half
    lz = nz - (dvz - along * nz) * half
    out = vx * nx + vy * ny + vz * nz
    parting = parting_velocity(dvx * mx + dvy * my + dvz * mz, half)
    return parting, vx - out * lx, vy - out * ly, vz - out * lz


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
