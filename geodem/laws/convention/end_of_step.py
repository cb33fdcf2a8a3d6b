"""What YADE and LIGGGHTS share: velocities of the middle of a step, set against the normal at its end."""

from __future__ import annotations


def parting_velocity(swept, half):
    """As it is [m/s]: first order in the step."""
    return swept


def relative_motion(distance, nx, ny, nz, dvx, dvy, dvz, along, enlarged, wx, wy, wz, turned, lapse):
    """Velocities of approach, negative, and of slip x, y, z [m/s], across n: e (dv - along n) - w x n."""
    return (
        along,
        enlarged * (dvx - along * nx) - (wy * nz - wz * ny),
        enlarged * (dvy - along * ny) - (wz * nx - wx * nz),
        enlarged * (dvz - along * nz) - (wx * ny - wy * nx),
    )
