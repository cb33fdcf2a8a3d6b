"""Chunks at rest are skipped: when they fall asleep, and what wakes them.

Serial, and only where a scene asks for it; compiled in a generated module like `geodem.kernels.pairs`. A chunk falls
asleep when it and all chunks that share pairs with it have been slow for some steps, and no wall that moves is near.
It wakes when one of those chunks gets fast, or a wall that moves comes near. While it sleeps beside one that is awake,
the pairs that it lists are computed all the same, for the other's sake.
"""

from __future__ import annotations

# Columns, as in pairs, motion and wall_geometry.
VELOCITY = 4
SPIN = 8
FASTEST = 0
KINETIC = 4
INERTIA = 6
ROLLING = 16
BODY_VELOCITY = 3
BODY_SPIN = 15
BODY_GAIN = 33
SPACE = True


def near_moving_wall(chunk, wall_start, wall_primitive, body, bodies):
    """Whether a wall that moves, or may move, is listed for the chunk."""
    for p in range(wall_start[chunk], wall_start[chunk + 1]):
        owner = int(body[wall_primitive[p]])
        if bodies[owner, BODY_GAIN] > 0.0:
            return True
        for axis in range(3):
            if bodies[owner, BODY_VELOCITY + axis] != 0.0 or bodies[owner, BODY_SPIN + axis] != 0.0:
                return True
    return False


def rest(chunk, chunk_size, rows, present, sums):
    """A chunk falls asleep: its particles stand still, in both sets of rows."""
    base = chunk * chunk_size
    for i in range(base, min(base + chunk_size, rows.shape[1])):
        for column in range(rows.shape[2]):
            rows[present, i, column] = rows[1 - present, i, column]
        for axis in range(3 if SPACE else 2):
            rows[0, i, VELOCITY + axis] = 0.0
            rows[1, i, VELOCITY + axis] = 0.0
        for axis in range(3 if SPACE else 1):
            rows[0, i, SPIN + axis] = 0.0
            rows[1, i, SPIN + axis] = 0.0
    sums[chunk, FASTEST] = 0.0
    sums[chunk, ROLLING] = 0.0
    sums[chunk, KINETIC] = 0.0
    sums[chunk, INERTIA] = 0.0


def sleep_and_wake(
    chunk_size, rows, present, sums, asleep, quiet, neighbour_start, neighbour, sleep_speed, sleep_steps,
    wall_start, wall_primitive, body, bodies,
):  # fmt: skip
    """After a step from rows[present]: who falls asleep, who wakes."""
    chunks = len(asleep)
    for chunk in range(chunks):
        if asleep[chunk] == 0:
            slow = sums[chunk, FASTEST] < sleep_speed and sums[chunk, ROLLING] < sleep_speed
            quiet[chunk] = quiet[chunk] + 1 if slow else 0
    for chunk in range(chunks):
        if asleep[chunk] == 0:
            still = quiet[chunk] >= sleep_steps
            for k in range(neighbour_start[chunk], neighbour_start[chunk + 1]):
                still = still and (asleep[neighbour[k]] != 0 or quiet[neighbour[k]] >= sleep_steps)
            if still and not near_moving_wall(chunk, wall_start, wall_primitive, body, bodies):
                asleep[chunk] = 1
                rest(chunk, chunk_size, rows, present, sums)
        else:
            called = near_moving_wall(chunk, wall_start, wall_primitive, body, bodies)
            for k in range(neighbour_start[chunk], neighbour_start[chunk + 1]):
                called = called or (asleep[neighbour[k]] == 0 and quiet[neighbour[k]] == 0)
            if called:
                asleep[chunk] = 0
                # not 0, which would wake those around it in turn, before anything moves there
                quiet[chunk] = 1


FUNCTIONS = (near_moving_wall, rest, sleep_and_wake)
"""Functions to compile, callees first."""
