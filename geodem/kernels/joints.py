"""A pair of particles on opposite sides of a joint: geometry along the joint's own normal, its law, force on both.

Compiled in a generated module like `geodem.kernels.pairs`, and only where a scene has joints.

With the joint's normal N instead of the line of centres, the distance that counts is the part of the centres' distance
along N, and the overlap is measured from what that was when nothing had moved. N keeps its direction in space; so does
the frame of the shear force. Where N is not the line of centres the forces on the two particles make a couple, of no
account on the whole: along a joint the centres lie ahead of each other as often as behind.
"""

from __future__ import annotations

from typing import Any

# Set by the module that the kernel is compiled in.
SPACE = True
BONDS = True
ENERGY = True
RELAX = True
SCALED = True
FREEDOMS = 6
JOINT = 0  # first column of a pair's history, see below
JOINT_ROWS = 0  # row of the first joint in the table of bonds, which theirs are joined to
VELOCITY = 4
SPIN = 8
STORED = 0
STATE = 0
STEP = 1
RELEASED = 2
PLACE = 3
FRICTION = 0
BROKEN = 2
ELASTIC = 3

# Columns of the history from JOINT on: 1 + row of the joint's material, negative while the two are too far apart to
# act on each other; unit normal from a to b (d columns); its part of the centres' distance when nothing had moved;
# area; then what the law remembers.

joint_parameters: Any = None
joint: Any = None
joint_energy: Any = None
load_joint: Any = None
store_joint: Any = None
account: Any = None


def joint_pair(
    p, number, a, b, i, j, dx, dy, dz, rows, pair_bond, history, bond_table, bond_scale, time_step, step, breaking,
    loads, energy, utilisation, record,
):  # fmt: skip
    """Forces of the pair p: rows begin at a and b, loads at i and j; number: of its bond, 0 where there is none.

    Returns
    -------
    carries, thrust : float
        1 where it carries force, and the size of its normal force [N].
    """
    parameters = joint_parameters(bond_table, JOINT_ROWS + int(history[p, JOINT]) - 1)
    nx = history[p, JOINT + 1]
    ny = history[p, JOINT + 2]
    nz = 0.0
    at = JOINT + 3
    if SPACE:
        nz = history[p, JOINT + 3]
        at = JOINT + 4
    area = history[p, at + 1]
    distance = dx * nx + dy * ny
    if SPACE:
        distance += dz * nz
    overlap = history[p, at] - distance
    arm_a = 0.5 * distance
    arm_b = arm_a
    dvx = rows[b + VELOCITY] - rows[a + VELOCITY]
    dvy = rows[b + VELOCITY + 1] - rows[a + VELOCITY + 1]
    slip_y = 0.0
    slip_z = 0.0
    if SPACE:
        dvz = rows[b + VELOCITY + 2] - rows[a + VELOCITY + 2]
        along = dvx * nx + dvy * ny + dvz * nz
        wx = arm_a * rows[a + SPIN] + arm_b * rows[b + SPIN]
        wy = arm_a * rows[a + SPIN + 1] + arm_b * rows[b + SPIN + 1]
        wz = arm_a * rows[a + SPIN + 2] + arm_b * rows[b + SPIN + 2]
        slip_x = (dvx - along * nx - (wy * nz - wz * ny)) * time_step
        slip_y = (dvy - along * ny - (wz * nx - wx * nz)) * time_step
        slip_z = (dvz - along * nz - (wx * ny - wy * nx)) * time_step
    else:
        slip_x = (dvy * nx - dvx * ny - arm_a * rows[a + SPIN] - arm_b * rows[b + SPIN]) * time_step
    scale = bond_scale[number - 1] if BONDS and SCALED and number > 0 else 1.0
    intact = 1.0 if BONDS and number > 0 else 0.0
    before = load_joint(history, p)
    normal, shear_x, shear_y, shear_z, kept, tension, cut = joint(
        parameters, overlap, slip_x, slip_y, slip_z, area, intact, scale, before
    )
    if BONDS and number > 0:
        if RELAX:
            utilisation[number - 1, 0] = tension
            utilisation[number - 1, 1] = cut
        if tension >= breaking or cut >= breaking:
            intact = 0.0
            pair_bond[p] = 0
            record[number - 1, STATE] = 1 if tension >= cut else 2
            record[number - 1, STEP] = step
            record[number - 1, PLACE] = rows[a] + 0.5 * dx
            record[number - 1, PLACE + 1] = rows[a + 1] + 0.5 * dy
            if SPACE:
                record[number - 1, PLACE + 2] = rows[a + 2] + 0.5 * dz
            # the same step of the broken face
            normal, shear_x, shear_y, shear_z, kept, tension, cut = joint(
                parameters, overlap, slip_x, slip_y, slip_z, area, intact, scale, before
            )
    store_joint(history, p, kept)
    if ENERGY:
        stored = joint_energy(parameters, overlap, area, intact, kept)
        lost, _ = account(
            history, p, stored, 0.0, slip_x, slip_y, slip_z, 0.0, 0.0, 0.0, 0.0, overlap,
            normal, shear_x, shear_y, shear_z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        )  # fmt: skip
        energy[ELASTIC] += stored
        if BONDS and number > 0 and intact == 0.0:
            energy[BROKEN] += lost
            record[number - 1, RELEASED] = lost
        else:
            energy[FRICTION] += lost
    if SPACE:
        fx = shear_x - normal * nx
        fy = shear_y - normal * ny
        fz = shear_z - normal * nz
        tx = ny * shear_z - nz * shear_y
        ty = nz * shear_x - nx * shear_z
        tz = nx * shear_y - ny * shear_x
        loads[i] += fx
        loads[i + 1] += fy
        loads[i + 2] += fz
        loads[i + 3] += arm_a * tx
        loads[i + 4] += arm_a * ty
        loads[i + 5] += arm_a * tz
        loads[j] -= fx
        loads[j + 1] -= fy
        loads[j + 2] -= fz
        loads[j + 3] += arm_b * tx
        loads[j + 4] += arm_b * ty
        loads[j + 5] += arm_b * tz
    else:
        fx = -normal * nx - shear_x * ny
        fy = -normal * ny + shear_x * nx
        loads[i] += fx
        loads[i + 1] += fy
        loads[i + 2] += arm_a * shear_x
        loads[j] -= fx
        loads[j + 1] -= fy
        loads[j + 2] += arm_b * shear_x
    carries = 1.0 if normal != 0.0 or intact > 0.0 else 0.0
    return carries, abs(normal)


FUNCTIONS = (joint_pair,)
