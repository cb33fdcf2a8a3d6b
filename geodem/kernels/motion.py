"""The loop over the particles of a chunk: leap-frog with damping, supports and applied forces; and the steps.

Like `geodem.kernels.pairs`, these functions are compiled in a generated module, with the constants set to what the
scene has. Leap-frog: velocities at n - 1/2 and forces at n give velocities at n + 1/2 and positions at n + 1.

Sources: Cundall & Strack 1979 (scheme, local damping), Cundall 1987; mass-proportional damping in centred form as in
TRUBAL (Cundall 1988). Kinetic energy is m v(n-1/2).v(n+1/2)/2, which with the elastic energy at n is what a
leap-frog of a linear system keeps exactly.
"""

from __future__ import annotations

import math

# What a scene may lack; set by the module that the kernel is compiled in.
SPACE = True
ROTATION = True
ORIENTATION = True
GRAVITY = True
APPLIED = True
HELD = True
ANCHORS = True
LOCAL = True
AT_MIDDLE = False  # local damping looks at the velocity in the middle of the step
GLOBAL = True
RELAX = True
ENERGY = True
SLEEP = True

# Columns of the rows: 3D (2D).
RADIUS = 3  # (2)
VELOCITY = 4  # (4)
MASS = 7  # (7)
SPIN = 8  # (6)
FREEDOMS = 6  # (3)

# Columns of the sums of a chunk: those of the last step first, then what adds up over all steps.
FASTEST = 0  # largest speed [m/s]
UNBALANCED = 1  # sum of squares of the resultant forces of free freedoms [N2]
CONTACTS = 2  # contacts that carry force
THRUST = 3  # sum of their normal forces [N]
KINETIC = 4  # [J]
SOFTENING = 5  # v.(old force - new force) [N m/s]
INERTIA = 6  # v.m.v [J]
ANCHORED = 7  # elastic energy of anchors [J]
TOTAL_FRICTION = 8  # [J], and so on
TOTAL_VISCOUS = 9
TOTAL_BROKEN = 10
TOTAL_ELASTIC = 11  # of contacts and bonds, last step
DAMPING = 12
DRIVEN = 13  # work of held freedoms that move
GRAVITATION = 14
FORCING = 15  # work of applied forces
ROLLING = 16  # largest speed of a surface by spin, where SLEEP [m/s]


def direction(velocity):
    """Its sign; without a branch, which would be guessed wrong every other time."""
    return (1.0 if velocity > 0.0 else 0.0) - (1.0 if velocity < 0.0 else 0.0)


def move(
    base, size, now, following, force, inverse_mass, inverse_inertia, gravity, applied, held, anchor_of, anchors,
    angle, span, time_step, local_damping, global_damping, old_force, sums,
):  # fmt: skip
    """Move the `size` particles from `base` one step; now, following (n, 8 or 12): rows before and after.

    force (size, 3 or 6) [N, N m]: of contacts and walls; the resultant is left in it. inverse_mass,
    inverse_inertia (n,); gravity (d,); applied (n, 3 or 6); held (n,) uint8: bit k holds freedom k; anchor_of (n,)
    int32: row of anchors (k, d + 2) or -1; angle (n, 1 or 4): angle or quaternion; old_force (n, 3 or 6) [N, N m],
    updated where RELAX; span [s]: how long the forces act on the velocities; sums (17,), see the columns above.
    """
    space = 3 if SPACE else 2
    turns = 3 if SPACE else 1
    # in the first step forces act for half of it, and nothing has moved before
    before = 2.0 * span / time_step - 1.0
    drag_before = 0.5 * global_damping * time_step * before
    keep = (1.0 - 0.5 * global_damping * time_step) / (1.0 + drag_before)
    push = span / (1.0 + drag_before)
    fastest = 0.0
    turning = 0.0
    unbalanced = 0.0
    kinetic = 0.0
    softening = 0.0
    inertia = 0.0
    damped = 0.0
    driven = 0.0
    # work of constant forces on the way to where the particle is now, which is where its energies are those of
    fallen = 0.0
    forced = 0.0
    anchored = 0.0
    for k in range(size):
        i = base + k
        mass = now[i, MASS]
        mask = 0
        if HELD:
            mask = int(held[i])
        if ANCHORS and anchor_of[i] >= 0:
            spring = anchor_of[i]
            square = 0.0
            for axis in range(space):
                square += (now[i, axis] - anchors[spring, axis]) ** 2
            length = math.sqrt(square)
            stretch = length - anchors[spring, space + 1]
            pull = -anchors[spring, space] * stretch
            anchored += 0.5 * anchors[spring, space] * stretch * stretch
            if length > 0.0:
                for axis in range(space):
                    force[k, axis] += pull * (now[i, axis] - anchors[spring, axis]) / length
        speed = 0.0
        for axis in range(space):
            f = force[k, axis]
            v = now[i, VELOCITY + axis]
            given = 0.0
            weight = 0.0
            if APPLIED:
                given = applied[i, axis]
                f += given
            if GRAVITY:
                weight = mass * gravity[axis]
                f += weight
            force[k, axis] = f
            w = v
            free = not (HELD and (mask >> axis) & 1 == 1)
            if RELAX:
                if free:
                    softening += v * (old_force[i, axis] - f)
                    inertia += v * v / inverse_mass[i]
                old_force[i, axis] = f
            if free:
                unbalanced += f * f
                drag = 0.0
                if LOCAL:
                    drag = (
                        local_damping
                        * abs(f)
                        * direction(v + 0.5 * time_step * f * inverse_mass[i] if AT_MIDDLE else v)
                    )
                w = (keep * v if GLOBAL else v) + (push if GLOBAL else span) * (f - drag) * inverse_mass[i]
                if ENERGY:
                    # velocity half a step ago, and the way since then that was gone
                    u = v - (1.0 - before) * (w - v)
                    way = 0.5 * (before * v + w) * time_step
                    kinetic += 0.5 * u * w / inverse_mass[i]
                    if LOCAL:
                        damped += drag * way
                    if GLOBAL:
                        damped += global_damping * 0.5 * (u + w) * way / inverse_mass[i]
                    fallen += weight * v * before * time_step
                    forced += given * v * before * time_step
            elif ENERGY:
                driven -= (f - weight - given) * v * span
            speed += w * w
            following[i, VELOCITY + axis] = w
            following[i, axis] = now[i, axis] + w * time_step
        fastest = max(fastest, speed)
        if ROTATION:
            for axis in range(turns):
                f = force[k, space + axis]
                v = now[i, SPIN + axis]
                given = 0.0
                if APPLIED:
                    given = applied[i, space + axis]
                    f += given
                force[k, space + axis] = f
                w = v
                free = not (HELD and (mask >> (space + axis)) & 1 == 1)
                if RELAX:
                    if free:
                        softening += v * (old_force[i, space + axis] - f)
                        inertia += v * v / inverse_inertia[i]
                    old_force[i, space + axis] = f
                if free:
                    drag = 0.0
                    if LOCAL:
                        drag = (
                            local_damping
                            * abs(f)
                            * direction(v + 0.5 * time_step * f * inverse_inertia[i] if AT_MIDDLE else v)
                        )
                    w = (keep * v if GLOBAL else v) + (push if GLOBAL else span) * (
                        f - drag
                    ) * inverse_inertia[i]
                    if ENERGY:
                        u = v - (1.0 - before) * (w - v)
                        way = 0.5 * (before * v + w) * time_step
                        kinetic += 0.5 * u * w / inverse_inertia[i]
                        if LOCAL:
                            damped += drag * way
                        if GLOBAL:
                            damped += global_damping * 0.5 * (u + w) * way / inverse_inertia[i]
                        forced += given * v * before * time_step
                elif ENERGY:
                    driven -= (f - given) * v * span
                following[i, SPIN + axis] = w
                if SLEEP:
                    turning = max(turning, (w * now[i, RADIUS]) ** 2)
            if ORIENTATION:
                if SPACE:
                    turn(
                        angle,
                        i,
                        following[i, SPIN],
                        following[i, SPIN + 1],
                        following[i, SPIN + 2],
                        time_step,
                    )
                else:
                    angle[i, 0] += following[i, SPIN] * time_step
    sums[FASTEST] = math.sqrt(fastest)
    if SLEEP:
        sums[ROLLING] = math.sqrt(turning)
    sums[UNBALANCED] = unbalanced
    if RELAX:
        sums[SOFTENING] = softening
        sums[INERTIA] = inertia
    if ENERGY:
        sums[KINETIC] = kinetic
        sums[ANCHORED] = anchored
        sums[DAMPING] += damped
        sums[DRIVEN] += driven
        sums[GRAVITATION] += fallen
        sums[FORCING] += forced


def turn(angle, i, wx, wy, wz, time_step):
    """Turn the quaternion (w, x, y, z) of a particle by the rotation w dt: q = rot(|w| dt, w/|w|) q."""
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    half = 0.5 * size * time_step
    # sin(half)/size, whose limit for small spins is dt/2
    factor = math.sin(half) / size if half > 1e-9 else 0.5 * time_step
    c = math.cos(half)
    x = wx * factor
    y = wy * factor
    z = wz * factor
    q0 = angle[i, 0]
    q1 = angle[i, 1]
    q2 = angle[i, 2]
    q3 = angle[i, 3]
    p0 = c * q0 - x * q1 - y * q2 - z * q3
    p1 = c * q1 + x * q0 + y * q3 - z * q2
    p2 = c * q2 - x * q3 + y * q0 + z * q1
    p3 = c * q3 + x * q2 - y * q1 + z * q0
    inverse = 1.0 / math.sqrt(p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
    angle[i, 0] = p0 * inverse
    angle[i, 1] = p1 * inverse
    angle[i, 2] = p2 * inverse
    angle[i, 3] = p3 * inverse
