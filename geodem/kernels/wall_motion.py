"""Motion of walls: resultants of the chunks, servo, one step of every body. Serial: bodies are few."""

from __future__ import annotations

import math

from .wall_geometry import (
    BODY_DIRECTION,
    BODY_DISPLACEMENT,
    BODY_EXTENT,
    BODY_FORCE,
    BODY_GAIN,
    BODY_LIMIT,
    BODY_ROTATION,
    BODY_SPIN,
    BODY_TARGET,
    BODY_TORQUE,
    BODY_VELOCITY,
    BODY_WORK,
)


def gather_wall_forces(start, sums, bodies, time_step):
    """Add up the chunks' sums, in the order of the chunks, and the work that every body has done on the particles.

    start (chunks + 1,): pairs of every chunk; sums (chunks, b, 3 or 6): forces on the bodies and torques;
    bodies (b, BODY_WIDTH): force, torque and work are updated. Call before the bodies' velocities change: the work is
    that of the mean of the old and the new force on the way of the last step.
    """
    components = sums.shape[2]
    for wall in range(len(bodies)):
        fx = 0.0
        fy = 0.0
        fz = 0.0
        tx = 0.0
        ty = 0.0
        tz = 0.0
        for chunk in range(len(start) - 1):
            if start[chunk] == start[chunk + 1]:
                continue
            fx += sums[chunk, wall, 0]
            fy += sums[chunk, wall, 1]
            if components == 3:
                tz += sums[chunk, wall, 2]
            else:
                fz += sums[chunk, wall, 2]
                tx += sums[chunk, wall, 3]
                ty += sums[chunk, wall, 4]
                tz += sums[chunk, wall, 5]
        b = bodies[wall]
        power = (b[BODY_FORCE] + fx) * b[BODY_VELOCITY] + (b[BODY_TORQUE] + tx) * b[BODY_SPIN]
        power += (b[BODY_FORCE + 1] + fy) * b[BODY_VELOCITY + 1] + (b[BODY_TORQUE + 1] + ty) * b[
            BODY_SPIN + 1
        ]
        power += (b[BODY_FORCE + 2] + fz) * b[BODY_VELOCITY + 2] + (b[BODY_TORQUE + 2] + tz) * b[
            BODY_SPIN + 2
        ]
        b[BODY_WORK] -= 0.5 * power * time_step
        b[BODY_FORCE] = fx
        b[BODY_FORCE + 1] = fy
        b[BODY_FORCE + 2] = fz
        b[BODY_TORQUE] = tx
        b[BODY_TORQUE + 1] = ty
        b[BODY_TORQUE + 2] = tz


def turn_body(b, time_step):
    """Turn a body by its spin over one step: Rodrigues' formula, made orthonormal again."""
    wx = b[BODY_SPIN] * time_step
    wy = b[BODY_SPIN + 1] * time_step
    wz = b[BODY_SPIN + 2] * time_step
    angle = math.sqrt(wx * wx + wy * wy + wz * wz)
    if angle == 0.0:
        return
    wx /= angle
    wy /= angle
    wz /= angle
    cosine = math.cos(angle)
    sine = math.sin(angle)
    r = b[BODY_ROTATION : BODY_ROTATION + 9]
    for k in range(3):
        x = r[k]
        y = r[k + 3]
        z = r[k + 6]
        along = (wx * x + wy * y + wz * z) * (1.0 - cosine)
        r[k] = cosine * x + sine * (wy * z - wz * y) + along * wx
        r[k + 3] = cosine * y + sine * (wz * x - wx * z) + along * wy
        r[k + 6] = cosine * z + sine * (wx * y - wy * x) + along * wz
    size = math.sqrt(r[0] * r[0] + r[3] * r[3] + r[6] * r[6])
    r[0] /= size
    r[3] /= size
    r[6] /= size
    along = r[0] * r[1] + r[3] * r[4] + r[6] * r[7]
    r[1] -= along * r[0]
    r[4] -= along * r[3]
    r[7] -= along * r[6]
    size = math.sqrt(r[1] * r[1] + r[4] * r[4] + r[7] * r[7])
    r[1] /= size
    r[4] /= size
    r[7] /= size
    r[2] = r[3] * r[7] - r[6] * r[4]
    r[5] = r[6] * r[1] - r[0] * r[7]
    r[8] = r[0] * r[4] - r[3] * r[1]


def move_walls(bodies, time_step):
    """One step of every body: the servo sets the velocity along its direction, then the body moves and turns.

    bodies (b, BODY_WIDTH), whose force is that of this step. Returns the largest speed of a point that a particle may
    touch [m/s].
    """
    largest = 0.0
    for wall in range(len(bodies)):
        b = bodies[wall]
        if b[BODY_GAIN] > 0.0:
            dx = b[BODY_DIRECTION]
            dy = b[BODY_DIRECTION + 1]
            dz = b[BODY_DIRECTION + 2]
            # particles push the wall back against its direction
            felt = -(b[BODY_FORCE] * dx + b[BODY_FORCE + 1] * dy + b[BODY_FORCE + 2] * dz)
            speed = b[BODY_GAIN] * (b[BODY_TARGET] - felt)
            speed = min(max(speed, -b[BODY_LIMIT]), b[BODY_LIMIT])
            change = speed - (b[BODY_VELOCITY] * dx + b[BODY_VELOCITY + 1] * dy + b[BODY_VELOCITY + 2] * dz)
            b[BODY_VELOCITY] += change * dx
            b[BODY_VELOCITY + 1] += change * dy
            b[BODY_VELOCITY + 2] += change * dz
        square = 0.0
        for k in range(3):
            b[BODY_DISPLACEMENT + k] += b[BODY_VELOCITY + k] * time_step
            square += b[BODY_VELOCITY + k] * b[BODY_VELOCITY + k]
        spin = (
            b[BODY_SPIN] * b[BODY_SPIN]
            + b[BODY_SPIN + 1] * b[BODY_SPIN + 1]
            + b[BODY_SPIN + 2] * b[BODY_SPIN + 2]
        )
        largest = max(largest, math.sqrt(square) + math.sqrt(spin) * b[BODY_EXTENT])
        turn_body(b, time_step)
    return largest


MOTION_FUNCTIONS = (gather_wall_forces, turn_body, move_walls)
"""Functions to compile, callees first; they need `wall_geometry.WALL_CONSTANTS`."""
