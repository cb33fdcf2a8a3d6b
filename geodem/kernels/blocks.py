"""The same as `geodem.kernels.pairs`, for spheres, over blocks of pairs: gather, laws on all lanes at once, scatter.

A processor works on four or eight pairs at once where nothing branches between them. So a first loop notes which
pairs touch, these are gathered into a small block that stays in the first cache, the law runs over the whole block in
one loop without branches, and a last loop adds up the forces. Always all lanes of a block are computed (the ones
that are not filled repeat the last pair), so that every pair meets the same instructions wherever it stands. Rows are
read and forces added four numbers at a time, which halves the time of these two loops. In 2D, where a pair costs
little, blocks do not pay.

A bond whose law works beside the contact's shares its lane with the contact: all lanes compute both, and the contact
counts where it touches, because nobody could guess where that is.

Bonds first, contacts after: a bond that breaks hands its shear force over to the contact within the same step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .cell import CELL_LAST, CELL_VECTORS

# What a scene may lack; set by the module that the kernel is compiled in.
BONDS = True
REPLACES = True
REACH = True
RELAX = True
PERIODIC = True
SCALED = True
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
IN_SPACE = 0.0  # no law that is computed in blocks asks for it

LANES = 64
"""Pairs in a block: large enough to pay for its three loops, small enough for the first cache."""

# Places in a block. The first slots lie in fours, a lane's four beside each other: value k of lane l at place
# + 4 l + k; a store to each of twenty lines of the cache would cost more than all the rest of a pair. Slot 15 and
# those after it are the history; what does not fill a four lies in rows, value of lane l at place + l, because a
# four that is not read whole makes the compiler do the last lanes one by one.
APART = 0  # x, y, z from a to b, and rb - ra
RELATIVE = 4 * LANES  # velocity of b against a, and the distance without force
SUM = 8 * LANES  # spins of a and b, and the weight: 0 where a lane repeats the last pair
DIFFERENCE = 12 * LANES  # spin of a less that of b
HISTORY_SLOT = 15
BESIDE_SLOT = 36
"""History of the contact beside a bond, in rows."""
BESIDE_AFTER = 16
"""The same after the step, counted from AFTER."""
HISTORIES = 16
"""Most values that a law may remember; one that remembers more is computed pair by pair."""
BESIDE_HISTORIES = 12
"""The same of a contact beside a bond."""
# In rows: what some laws ask for, and what the laws leave.
RADIUS_A = 48 * LANES
RADIUS_B = 49 * LANES
MASS_A = 50 * LANES
MASS_B = 51 * LANES
SCALE = 52 * LANES  # strength factor of a bond
PRESSED = 53 * LANES  # 1 for a new contact
LEFT = 54 * LANES  # share of the slip that is still to be taken: 0 where a bond broke in this step
TENSION = 55 * LANES
CUT = 56 * LANES
SHEAR = 57 * LANES  # of an intact bond that takes the contact's place, three rows
TOUCH = 57 * LANES  # in the same place, of any other bond: 1 where the contact beside it touches
# In fours again: what is added up, the fourth without meaning.
FORCE = 60 * LANES  # on a
MOMENT_A = 64 * LANES
MOMENT_B = 68 * LANES
AFTER = 72 * LANES  # the new history
SIZE = 104 * LANES

# Columns of the record of a bond, as in pairs.
STATE = 0
STEP = 1
PLACE = 3

# In touching, within a step: the contact of a bond that broke in this step; a contact that was born.
HANDED_OVER = 2
BORN = 3

relative_motion: Any = None  # of the convention, geodem's own: no other is computed in blocks
contact_parameters: Any = None
contact: Any = None
contact_viscous: Any = None
contact_reach: Any = None
store_contact: Any = None
no_contact: Any = None
load_contact_lane: Any = None
load_beside_contact_lane: Any = None
store_beside_contact_lane: Any = None
gather_beside_contact: Any = None
scatter_beside_contact: Any = None
contact_where: Any = None  # the history where a contact touches, else none
store_contact_lane: Any = None
add_fours: Any = None  # see geodem.kernels.fours
subtract_fours: Any = None
fetch_ahead: Any = None  # see geodem.kernels.pairs
FAR = 300_000
transport_contact: Any = None
cell_matrix: Any = None  # see geodem.kernels.cell
image_shift: Any = None
move_to_image: Any = None
add_moments: Any = None
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


def gather(block, lane, rows, a, b, offset, weight):
    """Copy what a pair's law may ask for into one lane of a block."""
    a *= 12
    b *= 12
    at = 4 * lane
    subtract_fours(block, APART + at, rows, b, rows, a)
    subtract_fours(block, RELATIVE + at, rows, b + 4, rows, a + 4)
    add_fours(block, SUM + at, rows, a + 8, rows, b + 8)
    subtract_fours(block, DIFFERENCE + at, rows, a + 8, rows, b + 8)
    radius_a = rows[a + 3]
    radius_b = rows[b + 3]
    block[RELATIVE + at + 3] = radius_a + radius_b + offset
    block[SUM + at + 3] = weight
    if ASKS_RADII:
        block[RADIUS_A + lane] = radius_a
        block[RADIUS_B + lane] = radius_b
    if ASKS_MASS:
        block[MASS_A + lane] = rows[a + 7]
        block[MASS_B + lane] = rows[b + 7]


def scatter(block, filled, place, local_a, local_b, load):
    """Add the forces of the filled lanes to the chunk's particles and its halo, in eights: a force, and a moment."""
    for lane in range(filled):
        a = 8 * int(local_a[place[lane]])
        b = 8 * int(local_b[place[lane]])
        at = 4 * lane
        add_fours(load, a, load, a, block, FORCE + at)
        subtract_fours(load, b, load, b, block, FORCE + at)
        if ROTATION:
            add_fours(load, a + 4, load, a + 4, block, MOMENT_A + at)
            add_fours(load, b + 4, load, b + 4, block, MOMENT_B + at)


def lane_geometry(block, lane, time_step):
    """Geometry and motion of the pair in a lane, as in `pairs`; at the end what turns the contact's frame."""
    dx = block[APART + 4 * lane]
    dy = block[APART + 4 * lane + 1]
    dz = block[APART + 4 * lane + 2]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / distance
    nx = dx * inverse
    ny = dy * inverse
    nz = dz * inverse
    dvx = block[RELATIVE + 4 * lane]
    dvy = block[RELATIVE + 4 * lane + 1]
    dvz = block[RELATIVE + 4 * lane + 2]
    along = dvx * nx + dvy * ny + dvz * nz
    sx = block[SUM + 4 * lane]
    sy = block[SUM + 4 * lane + 1]
    sz = block[SUM + 4 * lane + 2]
    rx = block[DIFFERENCE + 4 * lane]
    ry = block[DIFFERENCE + 4 * lane + 1]
    rz = block[DIFFERENCE + 4 * lane + 2]
    # arm_a wa + arm_b wb, with the arms (d + ra - rb)/2 and (d + rb - ra)/2
    half_distance = 0.5 * distance
    unlike = -block[APART + 4 * lane + 3]
    half_unlike = 0.5 * unlike
    wx = half_distance * sx + half_unlike * rx
    wy = half_distance * sy + half_unlike * ry
    wz = half_distance * sz + half_unlike * rz
    parting, slip_x, slip_y, slip_z = relative_motion(
        distance, nx, ny, nz, dvx, dvy, dvz, along, 1.0, wx, wy, wz, sx * sx + sy * sy + sz * sz, time_step
    )
    twist = -(rx * nx + ry * ny + rz * nz) * time_step
    bend_x = -rx * time_step - twist * nx
    bend_y = -ry * time_step - twist * ny
    bend_z = -rz * time_step - twist * nz
    half = 0.5 * time_step * inverse
    spin = 0.5 * time_step * (sx * nx + sy * ny + sz * nz)
    return (
        distance, unlike, nx, ny, nz, block[RELATIVE + 4 * lane + 3] - distance, -parting * time_step,
        slip_x * time_step, slip_y * time_step, slip_z * time_step, twist, bend_x, bend_y, bend_z,
        (dvx - along * nx) * half, (dvy - along * ny) * half, (dvz - along * nz) * half, spin,
    )  # fmt: skip


def set_forces(
    block, lane, distance, unlike, nx, ny, nz, normal, shear_x, shear_y, shear_z,
    twisting, bending_x, bending_y, bending_z,
):  # fmt: skip
    """Put the force on a and the moments on both into the lane."""
    at = 4 * lane
    block[FORCE + at] = shear_x - normal * nx
    block[FORCE + at + 1] = shear_y - normal * ny
    block[FORCE + at + 2] = shear_z - normal * nz
    block[FORCE + at + 3] = 0.0
    arm_a = 0.5 * (distance + unlike)
    arm_b = distance - arm_a
    tx = ny * shear_z - nz * shear_y
    ty = nz * shear_x - nx * shear_z
    tz = nx * shear_y - ny * shear_x
    mx = bending_x + twisting * nx if MOMENT else 0.0
    my = bending_y + twisting * ny if MOMENT else 0.0
    mz = bending_z + twisting * nz if MOMENT else 0.0
    block[MOMENT_A + at] = arm_a * tx + mx
    block[MOMENT_A + at + 1] = arm_a * ty + my
    block[MOMENT_A + at + 2] = arm_a * tz + mz
    block[MOMENT_A + at + 3] = 0.0
    block[MOMENT_B + at] = arm_b * tx - mx
    block[MOMENT_B + at + 1] = arm_b * ty - my
    block[MOMENT_B + at + 2] = arm_b * tz - mz
    block[MOMENT_B + at + 3] = 0.0


def contact_block(block, table, row, time_step):
    """The contact law on every lane of a block. Returns the sum of weights and that of the weighted normal forces."""
    common = contact_parameters(table, 0)
    contacts = 0.0
    thrust = 0.0
    for lane in range(LANES):
        parameters = common if ONE_MATERIAL else contact_parameters(table, row[lane])
        (
            distance, unlike, nx, ny, nz, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            turn_x, turn_y, turn_z, spin,
        ) = lane_geometry(block, lane, time_step)  # fmt: skip
        # nothing is read after the first store: the compiler would have to read it apart from its four
        weight = block[SUM + 4 * lane + 3]
        radius_a = block[RADIUS_A + lane]
        radius_b = block[RADIUS_B + lane]
        mass_a = block[MASS_A + lane]
        mass_b = block[MASS_B + lane]
        held = transport_contact(load_contact_lane(block, lane), nx, ny, nz, turn_x, turn_y, turn_z, spin)
        left = block[LEFT + lane] if BONDS else 1.0
        step_in = overlap if ASKS_APPROACH and block[PRESSED + lane] != 0.0 else approach
        normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, held = contact(
            parameters, overlap, step_in, left * slip_x, left * slip_y, left * slip_z, twist, bend_x, bend_y, bend_z,
            radius_a, radius_b, distance, mass_a, mass_b, time_step, IN_SPACE, held,
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
            block, lane, distance, unlike, nx, ny, nz, normal, shear_x, shear_y, shear_z,
            twisting, bending_x, bending_y, bending_z,
        )  # fmt: skip
        contacts += weight
        thrust += weight * abs(normal)
    return contacts, thrust


def bond_block(block, table, bond_table, row, time_step):
    """The bond law, and beside it the contact law, on every lane of a block.

    Returns the sum of weights and that of the weighted normal forces.
    """
    common = bond_parameters(bond_table, 0)
    common_contact = contact_parameters(table, 0)
    contacts = 0.0
    thrust = 0.0
    for lane in range(LANES):
        parameters = common if ONE_MATERIAL else bond_parameters(bond_table, row[lane])
        (
            distance, unlike, nx, ny, nz, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            turn_x, turn_y, turn_z, spin,
        ) = lane_geometry(block, lane, time_step)  # fmt: skip
        # nothing is read after the first store: the compiler would have to read it apart from its four
        weight = block[SUM + 4 * lane + 3]
        radius_a = block[RADIUS_A + lane]
        radius_b = block[RADIUS_B + lane]
        mass_a = block[MASS_A + lane]
        mass_b = block[MASS_B + lane]
        kept = transport_bond(load_bond_lane(block, lane), nx, ny, nz, turn_x, turn_y, turn_z, spin)
        (
            normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, kept, tension, cut,
        ) = bond(
            parameters, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
            radius_a, radius_b, distance, mass_a, mass_b, time_step, block[SCALE + lane], IN_SPACE, kept,
        )  # fmt: skip
        normal_c = 0.0
        shear_cx = 0.0
        shear_cy = 0.0
        shear_cz = 0.0
        if not REPLACES:
            # all lanes do the work, and it counts where they touch: nobody can guess where that is
            settings = common_contact if ONE_MATERIAL else contact_parameters(table, row[lane])
            touch = overlap > 0.0
            if REACH and block[PRESSED + lane] != 0.0:
                touch = overlap > -contact_reach(settings, radius_a, radius_b)
            held = transport_contact(
                load_beside_contact_lane(block, lane), nx, ny, nz, turn_x, turn_y, turn_z, spin
            )
            (
                normal_c, shear_cx, shear_cy, shear_cz, twisting_c, bending_cx, bending_cy, bending_cz, held,
            ) = contact(
                settings, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
                radius_a, radius_b, distance, mass_a, mass_b, time_step, IN_SPACE, held,
            )  # fmt: skip
            held = contact_where(touch, held)
            if VISCOUS_CONTACT:
                damp, drag_x, drag_y, drag_z = contact_viscous(
                    settings, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance, mass_a, mass_b,
                    time_step,
                )  # fmt: skip
                normal_c += damp
                shear_cx += drag_x
                shear_cy += drag_y
                shear_cz += drag_z
            normal_c = normal_c if touch else 0.0
            shear_cx = shear_cx if touch else 0.0
            shear_cy = shear_cy if touch else 0.0
            shear_cz = shear_cz if touch else 0.0
            twisting += twisting_c if touch else 0.0
            bending_x += bending_cx if touch else 0.0
            bending_y += bending_cy if touch else 0.0
            bending_z += bending_cz if touch else 0.0
            store_beside_contact_lane(block, lane, held)
            block[TOUCH + lane] = 1.0 if touch else 0.0
        store_bond_lane(block, lane, kept)
        if REPLACES:
            # the undamped shear is what a breaking bond hands over
            block[SHEAR + lane] = shear_x
            block[SHEAR + LANES + lane] = shear_y
            block[SHEAR + 2 * LANES + lane] = shear_z
        if VISCOUS_BOND:
            damp, drag_x, drag_y, drag_z = bond_viscous(
                parameters, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance, mass_a, mass_b,
                time_step,
            )  # fmt: skip
            normal += damp
            shear_x += drag_x
            shear_y += drag_y
            shear_z += drag_z
        normal += normal_c
        shear_x += shear_cx
        shear_y += shear_cy
        shear_z += shear_cz
        block[TENSION + lane] = tension
        block[CUT + lane] = cut
        set_forces(
            block, lane, distance, unlike, nx, ny, nz, normal, shear_x, shear_y, shear_z,
            twisting, bending_x, bending_y, bending_z,
        )  # fmt: skip
        contacts += weight
        thrust += weight * abs(normal)
    return contacts, thrust


def break_bonds(
    block, filled, place, now, pair_a, pair_bond, touching, history, step, breaking, utilisation, record
):  # fmt: skip
    """Break the overstressed bonds of a block, or note how much they are overstressed; no force is left in the lane.

    Returns the weight of the broken ones and that of their normal forces.
    """
    contacts = 0.0
    thrust = 0.0
    for lane in range(filled):
        p = place[lane]
        a = int(pair_a[p])
        number = int(pair_bond[p])
        tension = block[TENSION + lane]
        cut = block[CUT + lane]
        if RELAX:
            utilisation[number - 1, 0] = tension
            utilisation[number - 1, 1] = cut
        if tension >= breaking or cut >= breaking:
            pair_bond[p] = 0
            if REPLACES:
                held = with_shear(
                    load_contact(history, p),
                    block[SHEAR + lane],
                    block[SHEAR + LANES + lane],
                    block[SHEAR + 2 * LANES + lane],
                )
                store_contact(history, p, held)
                touching[p] = HANDED_OVER
            at = 4 * lane
            dx = block[APART + at]
            dy = block[APART + at + 1]
            dz = block[APART + at + 2]
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            record[number - 1, STATE] = 1 if tension >= cut else 2
            record[number - 1, STEP] = step
            share = 0.5 - 0.5 * block[APART + at + 3] / distance
            record[number - 1, PLACE] = now[a, 0] + share * dx
            record[number - 1, PLACE + 1] = now[a, 1] + share * dy
            record[number - 1, PLACE + 2] = now[a, 2] + share * dz
            along = block[FORCE + at] * dx + block[FORCE + at + 1] * dy + block[FORCE + at + 2] * dz
            contacts += block[SUM + at + 3]
            thrust += block[SUM + at + 3] * abs(along) / distance
            for k in range(at, at + 4):
                block[FORCE + k] = 0.0
                block[MOMENT_A + k] = 0.0
                block[MOMENT_B + k] = 0.0
    return contacts, thrust


def bonded_pairs(pair_bond, place):
    """Note the places of pairs with an intact bond; returns their number."""
    count = 0
    for p in range(len(pair_bond)):
        place[count] = p
        if pair_bond[p] > 0:
            count += 1
    return count


def touching_pairs(rows, pair_a, pair_b, pair_bond, touching, history, table, place, image, cell):
    """Note the places of pairs that touch, see to the beginning and end of contacts; returns their number."""
    far = len(rows) > FAR
    if PERIODIC:
        vectors = cell_matrix(cell, CELL_VECTORS)
    count = 0
    for p in range(len(pair_a)):
        if far:
            fetch_ahead(rows, pair_a, pair_b, p)
        a = 12 * int(pair_a[p])
        b = 12 * int(pair_b[p])
        dx = rows[b] - rows[a]
        dy = rows[b + 1] - rows[a + 1]
        dz = rows[b + 2] - rows[a + 2]
        if PERIODIC:
            shift_x, shift_y, shift_z = image_shift(vectors, image, p)
            dx += shift_x
            dy += shift_y
            dz += shift_z
        limit = rows[a + 3] + rows[b + 3]
        touched = touching[p] != 0
        bonded = BONDS and pair_bond[p] > 0
        if BONDS:
            limit += history[p, OFFSET]
        if REACH and touched:
            material = 0 if ONE_MATERIAL else int(rows[a + 11]) * MATERIALS + int(rows[b + 11])
            limit += contact_reach(contact_parameters(table, material), rows[a + 3], rows[b + 3])
        touch = dx * dx + dy * dy + dz * dz < limit * limit
        # with its bond
        if bonded:
            touch = touched = False
        place[count] = p
        if touch:
            count += 1
        # rare, so the processor guesses it right
        if touch != touched:
            if touch:
                touching[p] = BORN if ASKS_APPROACH and not bonded else 1
            else:
                touching[p] = 0
                store_contact(history, p, no_contact())
                if BONDS and not bonded and history[p, OFFSET] > 0.0:
                    history[p, OFFSET] = 0.0
    return count


def pairs(
    first, last, now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history, table, bond_table, bond_scale,
    time_step, step, breaking, force, halo_force, energy, utilisation, record, image, cell, moment,
):  # fmt: skip
    """As `geodem.kernels.pairs.pairs`, without the energy account."""
    # slices, so that no index can be negative, and rows flat, so that their width is a constant
    rows = now.reshape(now.size)
    pair_a = pair_a[first:last]
    pair_b = pair_b[first:last]
    local_a = local_a[first:last]
    local_b = local_b[first:last]
    touching = touching[first:last]
    history = history[first:last]
    if BONDS:
        pair_bond = pair_bond[first:last]
    if PERIODIC:
        image = image[first:last]
        vectors = cell_matrix(cell, CELL_VECTORS)
        gradient = cell_matrix(cell, CELL_LAST)
    block = np.empty(SIZE)
    place = np.empty(last - first + LANES, np.uint32)
    row = np.zeros(LANES, np.uint32)
    load = np.zeros(8 * (len(force) + len(halo_force)))
    contacts = 0.0
    thrust = 0.0
    for kind in range(0 if BONDS else 1, 2):
        if BONDS and kind == 0:
            found = bonded_pairs(pair_bond, place)
        else:
            found = touching_pairs(
                rows, pair_a, pair_b, pair_bond, touching, history, table, place, image, cell
            )  # fmt: skip
        # lanes that are not filled repeat the last pair, without weight
        for lane in range(LANES):
            place[found + lane] = place[max(found - 1, 0)]
        for begin in range(0, found, LANES):
            filled = min(LANES, found - begin)
            here = place[begin : begin + LANES]
            for lane in range(LANES):
                p = int(here[lane])
                a = int(pair_a[p])
                b = int(pair_b[p])
                gather(
                    block,
                    lane,
                    rows,
                    a,
                    b,
                    history[p, OFFSET] if BONDS else 0.0,
                    1.0,
                )
                if PERIODIC:
                    move_to_image(block, lane, vectors, gradient, image, p)
                if not ONE_MATERIAL:
                    row[lane] = int(rows[12 * a + 11]) * MATERIALS + int(rows[12 * b + 11])
                if BONDS and kind == 0:
                    gather_bond(block, lane, history, p)
                    if not REPLACES:
                        gather_beside_contact(block, lane, history, p)
                        if REACH:
                            block[PRESSED + lane] = float(touching[p])
                    block[SCALE + lane] = bond_scale[pair_bond[p] - 1] if SCALED else 1.0
                else:
                    gather_contact(block, lane, history, p)
                    if ASKS_APPROACH:
                        block[PRESSED + lane] = 1.0 if touching[p] == BORN else 0.0
                    if BONDS:
                        block[LEFT + lane] = 0.0 if touching[p] == HANDED_OVER else 1.0
            for lane in range(filled, LANES):
                block[SUM + 4 * lane + 3] = 0.0
            if BONDS and kind == 0:
                count_here, thrust_here = bond_block(block, table, bond_table, row, time_step)
                for lane in range(filled):
                    scatter_bond(block, lane, history, int(here[lane]))
                broken, loosened = break_bonds(
                    block, filled, here, now, pair_a, pair_bond, touching, history, step, breaking, utilisation, record,
                )  # fmt: skip
                contacts -= broken
                thrust -= loosened
                if not REPLACES:
                    for lane in range(filled):
                        # what broke is still to be computed as a contact
                        if pair_bond[here[lane]] > 0:
                            scatter_beside_contact(block, lane, history, int(here[lane]))
                            touching[here[lane]] = np.uint8(block[TOUCH + lane])
            else:
                count_here, thrust_here = contact_block(block, table, row, time_step)
                for lane in range(filled):
                    scatter_contact(block, lane, history, int(here[lane]))
                    if ASKS_APPROACH or BONDS:
                        touching[here[lane]] = 1
            contacts += count_here
            thrust += thrust_here
            scatter(block, filled, here, local_a, local_b, load)
            if PERIODIC:
                add_moments(block, filled, moment)
    size = len(force)
    for k in range(size):
        for axis in range(3):
            force[k, axis] = load[8 * k + axis]
            force[k, 3 + axis] = load[8 * k + 4 + axis]
    for k in range(len(halo_force)):
        at = 8 * (size + k)
        for axis in range(3):
            halo_force[k, axis] = load[at + axis]
            halo_force[k, 3 + axis] = load[at + 4 + axis]
    return contacts, thrust


INLINED = (
    gather, lane_geometry, set_forces, scatter, contact_block, bond_block, bonded_pairs, touching_pairs,
)  # fmt: skip
FUNCTIONS: tuple[Callable[..., Any], ...] = (break_bonds, pairs)
"""Functions to compile, callees first; without bonds those of bonds are never called."""
