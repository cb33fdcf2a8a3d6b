"""The same as `geodem.kernels.pairs`, for spheres, over blocks of pairs: gather, laws on all lanes at once, scatter.

A processor works on four or eight pairs at once where nothing branches between them. So the pairs that carry force are
gathered into a small block that stays in its first cache, the law runs over the whole block in one loop without
branches, and a last loop adds up the forces. Always all lanes of a block are computed (the ones that are not filled
repeat the first), so that every pair meets the same instructions wherever it stands. Measured against the loop
over single pairs: 1.45 times as fast in 3D; in 2D, where a pair costs little, it does not pay.

Bonds first, contacts after: a bond that breaks hands its shear force over to the contact within the same step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

# What a scene may lack; set by the module that the kernel is compiled in.
BONDS = True
REPLACES = True
REACH = True
ONE_MATERIAL = False
MATERIALS = 1
MOMENT = True
VISCOUS_CONTACT = True
VISCOUS_BOND = True
ROTATION = True
ASKS_RADII = True  # a law asks for radii, for masses, for the approach
ASKS_MASS = True
ASKS_APPROACH = True
OFFSET = 0

LANES = 64
"""Pairs in a block: large enough to pay for its three loops, small enough for the first cache."""

# Rows of a block: what is gathered, and what takes its place.
APART = 0  # x, y, z from a to b
ZERO = 3  # distance without force
UNLIKE = 4  # ra - rb
RADIUS_A = 5
RADIUS_B = 6
RELATIVE = 7  # velocity of b against a
SUM = 10  # spins of a and b
DIFFERENCE = 13  # spin of a less that of b
MASS_A = 16
MASS_B = 17
SCALE = 18
PRESSED = 19  # 1 for a new contact
LEFT = 20  # share of the slip that is still to be taken: 0 where a bond broke in this step
FORCE = 21  # on a
TORQUE_A = 24
TORQUE_B = 27
TENSION = 30
CUT = 31
SHEAR = 32  # of an intact bond
HISTORY = 35
HEIGHT = 48  # set to HISTORY and the larger of the two laws' histories

# Columns of the record of a bond, as in pairs.
STATE = 0
STEP = 1
PLACE = 3

SPARE = 8
"""Rows of forces that take what belongs to other chunks; several, so that one need not wait for another."""

FREEDOMS = 6

HANDED_OVER = 2
"""In touching: the contact of a bond that broke in this step."""

contact_parameters: Any = None
contact: Any = None
contact_viscous: Any = None
contact_reach: Any = None
store_contact: Any = None
no_contact: Any = None
load_contact_lane: Any = None
store_contact_lane: Any = None
transport_contact: Any = None
bond_parameters: Any = None
bond: Any = None
bond_viscous: Any = None
load_bond_lane: Any = None
store_bond_lane: Any = None
transport_bond: Any = None
gather_contact: Any = None  # from a pair's history to a lane, and back:
gather_bond: Any = None
scatter_contact: Any = None
scatter_bond: Any = None
with_shear: Any = None
load_contact: Any = None


def gather(block, lane, now, a, b, offset):
    """Copy what a pair's law may ask for into one lane of a block."""
    i = 12 * int(
        a
    )  # the width of a row, known to the compiler, and an index that it knows not to be negative
    j = 12 * int(b)
    # all loads before all stores: the compiler cannot know that a block is not part of the rows
    ax = now[i]
    ay = now[i + 1]
    az = now[i + 2]
    radius_a = now[i + 3]
    avx = now[i + 4]
    avy = now[i + 5]
    avz = now[i + 6]
    awx = now[i + 8]
    awy = now[i + 9]
    awz = now[i + 10]
    bx = now[j]
    by = now[j + 1]
    bz = now[j + 2]
    radius_b = now[j + 3]
    bvx = now[j + 4]
    bvy = now[j + 5]
    bvz = now[j + 6]
    bwx = now[j + 8]
    bwy = now[j + 9]
    bwz = now[j + 10]
    mass_a = now[i + 7]
    mass_b = now[j + 7]
    block[APART, lane] = bx - ax
    block[APART + 1, lane] = by - ay
    block[APART + 2, lane] = bz - az
    block[ZERO, lane] = radius_a + radius_b + offset
    block[UNLIKE, lane] = radius_a - radius_b
    block[RELATIVE, lane] = bvx - avx
    block[RELATIVE + 1, lane] = bvy - avy
    block[RELATIVE + 2, lane] = bvz - avz
    block[SUM, lane] = awx + bwx
    block[SUM + 1, lane] = awy + bwy
    block[SUM + 2, lane] = awz + bwz
    block[DIFFERENCE, lane] = awx - bwx
    block[DIFFERENCE + 1, lane] = awy - bwy
    block[DIFFERENCE + 2, lane] = awz - bwz
    if ASKS_RADII:
        block[RADIUS_A, lane] = radius_a
        block[RADIUS_B, lane] = radius_b
    if ASKS_MASS:
        block[MASS_A, lane] = mass_a
        block[MASS_B, lane] = mass_b


def fill_up(block, row, own_a, own_b, filled, nobody):
    """Let the lanes that are not filled repeat the first one, for particles that are nobody's."""
    for lane in range(filled, LANES):
        row[lane] = row[0]
        own_a[lane] = nobody
        own_b[lane] = nobody
    for line in range(HEIGHT):
        for lane in range(filled, LANES):
            block[line, lane] = block[line, 0]


def scatter(block, filled, own_a, own_b, force):
    """Add the forces of the filled lanes to the chunk's particles; own_a, own_b: row of each one.

    Neighbouring lanes mostly share a particle, and a sum that was just stored takes a while to be read again:
    so lanes are taken eight apart.
    """
    for first in range(8):
        for lane in range(first, filled, 8):
            a = FREEDOMS * int(own_a[lane])
            b = FREEDOMS * int(own_b[lane])
            fx = block[FORCE, lane]
            fy = block[FORCE + 1, lane]
            fz = block[FORCE + 2, lane]
            force[a] += fx
            force[a + 1] += fy
            force[a + 2] += fz
            if ROTATION:
                force[a + 3] += block[TORQUE_A, lane]
                force[a + 4] += block[TORQUE_A + 1, lane]
                force[a + 5] += block[TORQUE_A + 2, lane]
            force[b] -= fx
            force[b + 1] -= fy
            force[b + 2] -= fz
            if ROTATION:
                force[b + 3] += block[TORQUE_B, lane]
                force[b + 4] += block[TORQUE_B + 1, lane]
                force[b + 5] += block[TORQUE_B + 2, lane]


def lane_geometry(block, lane, time_step):
    """Geometry and motion of the pair in a lane, as in `pairs`; at the end what turns the contact's frame."""
    dx = block[APART, lane]
    dy = block[APART + 1, lane]
    dz = block[APART + 2, lane]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / distance
    nx = dx * inverse
    ny = dy * inverse
    nz = dz * inverse
    dvx = block[RELATIVE, lane]
    dvy = block[RELATIVE + 1, lane]
    dvz = block[RELATIVE + 2, lane]
    along = dvx * nx + dvy * ny + dvz * nz
    across_x = (dvx - along * nx) * time_step
    across_y = (dvy - along * ny) * time_step
    across_z = (dvz - along * nz) * time_step
    sx = block[SUM, lane]
    sy = block[SUM + 1, lane]
    sz = block[SUM + 2, lane]
    rx = block[DIFFERENCE, lane]
    ry = block[DIFFERENCE + 1, lane]
    rz = block[DIFFERENCE + 2, lane]
    # arm_a wa + arm_b wb, with the arms (d + ra - rb)/2 and (d + rb - ra)/2
    half_distance = 0.5 * distance * time_step
    half_unlike = 0.5 * block[UNLIKE, lane] * time_step
    wx = half_distance * sx + half_unlike * rx
    wy = half_distance * sy + half_unlike * ry
    wz = half_distance * sz + half_unlike * rz
    slip_x = across_x - (wy * nz - wz * ny)
    slip_y = across_y - (wz * nx - wx * nz)
    slip_z = across_z - (wx * ny - wy * nx)
    twist = -(rx * nx + ry * ny + rz * nz) * time_step
    bend_x = -rx * time_step - twist * nx
    bend_y = -ry * time_step - twist * ny
    bend_z = -rz * time_step - twist * nz
    half = 0.5 * inverse
    spin = 0.5 * time_step * (sx * nx + sy * ny + sz * nz)
    return (
        distance, nx, ny, nz, block[ZERO, lane] - distance, -along * time_step, slip_x, slip_y, slip_z,
        twist, bend_x, bend_y, bend_z, across_x * half, across_y * half, across_z * half, spin,
    )  # fmt: skip


def set_forces(
    block,
    lane,
    distance,
    nx,
    ny,
    nz,
    normal,
    shear_x,
    shear_y,
    shear_z,
    twisting,
    bending_x,
    bending_y,
    bending_z,
):
    """Put the force on a and the torques on both into the lane."""
    block[FORCE, lane] = shear_x - normal * nx
    block[FORCE + 1, lane] = shear_y - normal * ny
    block[FORCE + 2, lane] = shear_z - normal * nz
    if ROTATION:
        tx = ny * shear_z - nz * shear_y
        ty = nz * shear_x - nx * shear_z
        tz = nx * shear_y - ny * shear_x
        mx = bending_x + twisting * nx if MOMENT else 0.0
        my = bending_y + twisting * ny if MOMENT else 0.0
        mz = bending_z + twisting * nz if MOMENT else 0.0
        arm_a = 0.5 * (distance + block[UNLIKE, lane])
        arm_b = distance - arm_a
        block[TORQUE_A, lane] = arm_a * tx + mx
        block[TORQUE_A + 1, lane] = arm_a * ty + my
        block[TORQUE_A + 2, lane] = arm_a * tz + mz
        block[TORQUE_B, lane] = arm_b * tx - mx
        block[TORQUE_B + 1, lane] = arm_b * ty - my
        block[TORQUE_B + 2, lane] = arm_b * tz - mz


def contact_block(block, table, row, own_a, own_b, size, time_step):
    """The contact law on every lane of a block. Returns the sum of weights and that of the weighted normal forces."""
    common = contact_parameters(table, 0)
    contacts = 0.0
    thrust = 0.0
    for lane in range(LANES):
        parameters = common if ONE_MATERIAL else contact_parameters(table, row[lane])
        (
            distance, nx, ny, nz, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            turn_x, turn_y, turn_z, spin,
        ) = lane_geometry(block, lane, time_step)  # fmt: skip
        radius_a = block[RADIUS_A, lane]
        radius_b = block[RADIUS_B, lane]
        mass_a = block[MASS_A, lane]
        mass_b = block[MASS_B, lane]
        held = transport_contact(load_contact_lane(block, lane), nx, ny, nz, turn_x, turn_y, turn_z, spin)
        left = block[LEFT, lane] if BONDS else 1.0
        step_in = overlap if ASKS_APPROACH and block[PRESSED, lane] != 0.0 else approach
        normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, held = contact(
            parameters, overlap, step_in, left * slip_x, left * slip_y, left * slip_z, twist, bend_x, bend_y, bend_z,
            radius_a, radius_b, distance, mass_a, mass_b, time_step, held,
        )  # fmt: skip
        store_contact_lane(block, lane, held)
        if VISCOUS_CONTACT:
            damp, drag_x, drag_y, drag_z = contact_viscous(
                parameters, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance, mass_a, mass_b,
                time_step,
            )  # fmt: skip
            normal += damp
            shear_x += drag_x
            shear_y += drag_y
            shear_z += drag_z
        set_forces(
            block, lane, distance, nx, ny, nz, normal, shear_x, shear_y, shear_z,
            twisting, bending_x, bending_y, bending_z,
        )  # fmt: skip
        # half for a pair across chunks
        weight = (0.5 if own_a[lane] < size else 0.0) + (0.5 if own_b[lane] < size else 0.0)
        contacts += weight
        thrust += weight * abs(normal)
    return contacts, thrust


def bond_block(block, table, row, own_a, own_b, size, time_step):
    """The bond law on every lane of a block. Returns the sum of weights and that of the weighted normal forces."""
    common = bond_parameters(table, 0)
    contacts = 0.0
    thrust = 0.0
    for lane in range(LANES):
        parameters = common if ONE_MATERIAL else bond_parameters(table, row[lane])
        (
            distance, nx, ny, nz, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            turn_x, turn_y, turn_z, spin,
        ) = lane_geometry(block, lane, time_step)  # fmt: skip
        radius_a = block[RADIUS_A, lane]
        radius_b = block[RADIUS_B, lane]
        mass_a = block[MASS_A, lane]
        mass_b = block[MASS_B, lane]
        kept = transport_bond(load_bond_lane(block, lane), nx, ny, nz, turn_x, turn_y, turn_z, spin)
        (
            normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, kept, tension, cut,
        ) = bond(
            parameters, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            radius_a, radius_b, distance, mass_a, mass_b, time_step, block[SCALE, lane], kept,
        )  # fmt: skip
        store_bond_lane(block, lane, kept)
        # the undamped shear is what a breaking bond hands over
        block[SHEAR, lane] = shear_x
        block[SHEAR + 1, lane] = shear_y
        block[SHEAR + 2, lane] = shear_z
        if VISCOUS_BOND:
            damp, drag_x, drag_y, drag_z = bond_viscous(
                parameters, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance, mass_a, mass_b,
                time_step,
            )  # fmt: skip
            normal += damp
            shear_x += drag_x
            shear_y += drag_y
            shear_z += drag_z
        block[TENSION, lane] = tension
        block[CUT, lane] = cut
        set_forces(
            block, lane, distance, nx, ny, nz, normal, shear_x, shear_y, shear_z,
            twisting, bending_x, bending_y, bending_z,
        )  # fmt: skip
        # half for a pair across chunks
        weight = (0.5 if own_a[lane] < size else 0.0) + (0.5 if own_b[lane] < size else 0.0)
        contacts += weight
        thrust += weight * abs(normal)
    return contacts, thrust


def break_bonds(
    block, filled, place, now, pair_a, pair_bond, touching, history, base, size, step, breaking, utilisation, record
):  # fmt: skip
    """Break the overstressed bonds of a block, or note how much they are overstressed; no force is left in the lane."""
    for lane in range(filled):
        p = place[lane]
        a = int(pair_a[p])
        mine = base <= a < base + size
        number = int(pair_bond[p])
        tension = block[TENSION, lane]
        cut = block[CUT, lane]
        if breaking != 1.0 and mine:
            utilisation[number - 1, 0] = tension
            utilisation[number - 1, 1] = cut
        if tension >= breaking or cut >= breaking:
            pair_bond[p] = 0
            if REPLACES:
                held = with_shear(
                    load_contact(history, p),
                    block[SHEAR, lane],
                    block[SHEAR + 1, lane],
                    block[SHEAR + 2, lane],
                )
                store_contact(history, p, held)
                touching[p] = HANDED_OVER
            if mine:
                record[number - 1, STATE] = 1 if tension >= cut else 2
                record[number - 1, STEP] = step
                distance = math.sqrt(
                    block[APART, lane] ** 2 + block[APART + 1, lane] ** 2 + block[APART + 2, lane] ** 2
                )
                share = 0.5 * (distance + block[UNLIKE, lane]) / distance
                for axis in range(3):
                    record[number - 1, PLACE + axis] = now[a, axis] + share * block[APART + axis, lane]
            for row in range(3):
                block[FORCE + row, lane] = 0.0
                block[TORQUE_A + row, lane] = 0.0
                block[TORQUE_B + row, lane] = 0.0


def pairs(
    first, last, base, size, now, pair_a, pair_b, pair_bond, touching, history, table, bond_table, bond_scale,
    time_step, step, breaking, force, energy, utilisation, record,
):  # fmt: skip
    """As `geodem.kernels.pairs.pairs`, without the energy account; force has SPARE rows more than the chunk has."""
    # rows a little longer than their lanes, so that a lane's rows do not fall into the same few lines of the cache
    block = np.empty((HEIGHT, LANES + 8))
    place = np.empty(LANES, np.uint32)
    own_a = np.empty(LANES, np.uint32)
    own_b = np.empty(LANES, np.uint32)
    row = np.zeros(LANES, np.uint32)
    contacts = 0.0
    thrust = 0.0
    # widths that the compiler knows
    rows = now.reshape(now.size)
    forces = force.reshape(force.size)
    chunk_rows = len(force) - SPARE
    p = first
    while BONDS and p < last:
        filled = 0
        while p < last and filled < LANES:
            pair = np.uint64(p)  # an index without a sign saves the question whether it counts from the end
            number = pair_bond[pair]
            if number > 0:
                a = pair_a[pair]
                b = pair_b[pair]
                # what lies before the chunk becomes a very large number
                nobody = chunk_rows + (filled & (SPARE - 1))
                own_a[filled] = min(int(np.uint32(int(a) - base)), nobody)
                own_b[filled] = min(int(np.uint32(int(b) - base)), nobody)
                gather(block, filled, rows, a, b, history[pair, OFFSET])
                gather_bond(block, filled, history, pair)
                block[SCALE, filled] = bond_scale[number - 1]
                if not ONE_MATERIAL:
                    row[filled] = int(now[a, 11]) * MATERIALS + int(now[b, 11])
                place[filled] = p
                filled += 1
            p += 1
        if filled > 0:
            fill_up(block, row, own_a, own_b, filled, chunk_rows)
            count, pressed = bond_block(block, bond_table, row, own_a, own_b, size, time_step)
            contacts += count
            thrust += pressed
            for lane in range(filled):
                scatter_bond(block, lane, history, place[lane])
            break_bonds(
                block, filled, place, now, pair_a, pair_bond, touching, history, base, size, step, breaking,
                utilisation, record,
            )  # fmt: skip
            scatter(block, filled, own_a, own_b, forces)
    p = first
    while p < last:
        filled = 0
        while p < last and filled < LANES:
            pair = np.uint64(p)
            bonded = BONDS and pair_bond[pair] > 0
            if REPLACES and bonded:
                p += 1
                continue
            i = 12 * int(pair_a[pair])
            j = 12 * int(pair_b[pair])
            dx = rows[j] - rows[i]
            dy = rows[j + 1] - rows[i + 1]
            dz = rows[j + 2] - rows[i + 2]
            limit = rows[i + 3] + rows[j + 3]
            if BONDS:
                limit += history[pair, OFFSET]
            material = 0 if ONE_MATERIAL else int(rows[i + 11]) * MATERIALS + int(rows[j + 11])
            state = touching[pair]
            if REACH and state != 0:
                limit += contact_reach(contact_parameters(table, material), rows[i + 3], rows[j + 3])
            touch = dx * dx + dy * dy + dz * dz < limit * limit
            # written whether it touches or not: nothing to guess, where a third of the pairs may be apart
            place[filled] = p
            if ASKS_APPROACH:
                block[PRESSED, filled] = 1.0 if state == 0 and not bonded else 0.0
            if BONDS:
                block[LEFT, filled] = 0.0 if state == HANDED_OVER else 1.0
            if not ONE_MATERIAL:
                row[filled] = material
            filled += 1 if touch else 0
            if state != (1 if touch else 0):
                touching[pair] = 1 if touch else 0
                if not touch:
                    store_contact(history, pair, no_contact())
                    if BONDS and not bonded and history[pair, OFFSET] > 0.0:
                        history[pair, OFFSET] = 0.0
            p += 1
        for lane in range(filled):
            pair = place[lane]
            a = pair_a[pair]
            b = pair_b[pair]
            nobody = chunk_rows + (lane & (SPARE - 1))
            own_a[lane] = min(int(np.uint32(int(a) - base)), nobody)
            own_b[lane] = min(int(np.uint32(int(b) - base)), nobody)
            gather(block, lane, rows, a, b, history[pair, OFFSET] if BONDS else 0.0)
            gather_contact(block, lane, history, pair)
        if filled > 0:
            fill_up(block, row, own_a, own_b, filled, chunk_rows)
            count, pressed = contact_block(block, table, row, own_a, own_b, size, time_step)
            contacts += count
            thrust += pressed
            for lane in range(filled):
                scatter_contact(block, lane, history, place[lane])
            scatter(block, filled, own_a, own_b, forces)
    return contacts, thrust


INLINED = (gather, fill_up, lane_geometry, set_forces, scatter, contact_block, bond_block)
FUNCTIONS: tuple[Callable[..., Any], ...] = (break_bonds, pairs)
"""Functions to compile, callees first; without bonds those of bonds are never called."""
