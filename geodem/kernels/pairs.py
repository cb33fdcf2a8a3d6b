"""The loop over pairs of discs or spheres, one pair at a time: geometry, call of the laws, force on both.

These functions are never run as they stand here: `geodem.kernels.particle_kernel` joins their text with that of the
laws, with small adapters made from the laws' own signatures (`geodem.kernels.adapters`), and with the constants
below, set to what the scene has. They contain no physics: what a contact does is in ``geodem/laws``.

Conventions (pair a, b; n from a to b; d the distance): the overlap is ra + rb - d, and where the pair was bonded it
is measured from the distance at bonding, so that neither a bond nor what is left of it starts with a force. The
arms (d + ra - rb)/2 and (d + rb - ra)/2 add up to d, so that a rigid rotation of the pair is no slip. Forces are
those on a: -normal n + shear. In 2D a law is called in the contact's own frame: x is along t = (-ny, nx).

A chunk owns a range of particles and the pairs that are listed under them. What a pair across two chunks does to the
other chunk's particle is added up in the halo of its own (`geodem.neighbors.halo`), so the bits never depend on
threads.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .cell import CELL_LAST, CELL_VECTORS

# What a scene may lack; set by the module that the kernel is compiled in.
SPACE = True  # spheres in 3D, not discs in 2D
BONDS = True
REPLACES = True  # the contact law sleeps while a bond is intact
LINGERS = True  # a bond that is cut acts to the end of the step
REACH = True  # a contact may hold beyond touch
ONE_MATERIAL = False
MATERIALS = 1
MOMENT = True
ENERGY = True
RELAX = True
PERIODIC = True
JOINTS = True  # pairs across joints, see geodem.kernels.joints
JOINT = 0
SCALED = True  # some bond is stronger or weaker than its material
FREEDOMS = 6  # (3)
VISCOUS_CONTACT = True
VISCOUS_BOND = True
OFFSET = 0  # column of the history: distance at bonding - ra - rb
STORED = 0  # first column of the energy account: elastic energy, then the forces of the last step

# Columns of the rows: 3D (2D), and how many there are.
WIDTH = 12  # (8)
RADIUS = 3  # (2)
VELOCITY = 4  # (4)
MASS = 7  # (7)
SPIN = 8  # (6)
MATERIAL = 11  # (3)

TWELFTH = 1.0 / 12.0

AHEAD = 24
"""Pairs between asking for rows and using them."""
FAR = 300_000
"""Numbers in the rows of all particles (2.4 MB) from which it pays to ask early."""

# Columns of the energy sums of a chunk.
FRICTION = 0
VISCOUS = 1
BROKEN = 2
ELASTIC = 3

# Columns of the record of a bond: 0 intact, 1 broken in tension, 2 in shear; step; energy released; place.
STATE = 0
STEP = 1
RELEASED = 2
PLACE = 3

# Written by geodem.kernels.adapters from the laws of the scene.
contact_parameters: Any = None
contact: Any = None
contact_viscous: Any = None
contact_energy: Any = None
contact_reach: Any = None
branches: Any = None  # of the convention, see geodem.laws.convention
relative_motion: Any = None
parting_velocity: Any = None
half_turn: Any = None
spin_about: Any = None
load_contact: Any = None
store_contact: Any = None
no_contact: Any = None
with_shear: Any = None
transport_contact: Any = None
bond_parameters: Any = None
bond: Any = None
bond_viscous: Any = None
bond_energy: Any = None
load_bond: Any = None
store_bond: Any = None
transport_bond: Any = None
fetch: Any = None  # see geodem.kernels.fours
cell_matrix: Any = None  # see geodem.kernels.cell
image_shift: Any = None
affine: Any = None
joint_pair: Any = None  # see geodem.kernels.joints


def fetch_ahead(rows, pair_a, pair_b, p):
    """Ask for the rows of a pair that comes later, without waiting for them.

    The processor foresees rows that follow each other, not those of neighbours in other chunks. Where the rows fill
    more than the second cache this takes 10 to 25 % off a step; where they do not it would cost 3 %.
    """
    ahead = min(p + AHEAD, len(pair_a) - 1)
    a = WIDTH * int(pair_a[ahead])
    b = WIDTH * int(pair_b[ahead])
    fetch(rows, a)
    fetch(rows, b)
    if SPACE:
        # a row of twelve lies in two lines
        fetch(rows, a + 8)
        fetch(rows, b + 8)


def account(
    history, p, stored, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, overlap,
    normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, damp, drag_x, drag_y, drag_z,
):  # fmt: skip
    """Energy of one contact in one step, from the means of the old and the new forces.

    A leap-frog's particles feel the forces of both ends of a step: those of a contact that parts work for half of the
    step in which it does, so it is to be called in that step too, with all forces zero.

    Returns
    -------
    lost : float
        Work done on the contact's springs and not stored [J].
    heat : float
        Work done on its dashpots [J].
    """
    # from the places, not from velocities: the normal turns within the step, and a contact is born inside it
    gained = overlap - history[p, STORED + 6]
    work = (
        0.5 * (normal + history[p, STORED + 1]) * gained + 0.5 * (shear_x + history[p, STORED + 2]) * slip_x
    )
    work += 0.5 * (bending_x + history[p, STORED + 3]) * bend_x
    heat = 0.5 * (damp + history[p, STORED + 4]) * approach + 0.5 * (drag_x + history[p, STORED + 5]) * slip_x
    if SPACE:
        work += (
            0.5 * (shear_y + history[p, STORED + 7]) * slip_y
            + 0.5 * (shear_z + history[p, STORED + 8]) * slip_z
        )
        work += 0.5 * (bending_y + history[p, STORED + 9]) * bend_y
        work += 0.5 * (bending_z + history[p, STORED + 10]) * bend_z
        work += 0.5 * (twisting + history[p, STORED + 11]) * twist
        heat += (
            0.5 * (drag_y + history[p, STORED + 12]) * slip_y
            + 0.5 * (drag_z + history[p, STORED + 13]) * slip_z
        )
        history[p, STORED + 7] = shear_y
        history[p, STORED + 8] = shear_z
        history[p, STORED + 9] = bending_y
        history[p, STORED + 10] = bending_z
        history[p, STORED + 11] = twisting
        history[p, STORED + 12] = drag_y
        history[p, STORED + 13] = drag_z
    lost = work - (stored - history[p, STORED])
    history[p, STORED] = stored
    history[p, STORED + 1] = normal
    history[p, STORED + 2] = shear_x
    history[p, STORED + 3] = bending_x
    history[p, STORED + 4] = damp
    history[p, STORED + 5] = drag_x
    history[p, STORED + 6] = overlap
    return lost, heat


def range_of_pairs(
    first, last, now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history, table, bond_table, bond_scale,
    time_step, step, breaking, force, energy, utilisation, record, fresh, image, cell, moment,
):  # fmt: skip
    """As `pairs`, but a bond that breaks is only noted in fresh (p,), and marked by a negative number in pair_bond.

    A pair that is so marked has broken in this step: it is computed as a contact.

    Returns
    -------
    contacts, thrust : float
    broken : int
        Numbers in fresh.
    """
    contacts = 0.0
    thrust = 0.0
    overstressed = 0
    # slices, so that no index can be negative, and flat rows, so that their width is a constant
    rows = now.reshape(now.size)
    loads = force.reshape(force.size)
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
    far = len(rows) > FAR
    # read once: the compiler cannot know that no force is written over them
    common = contact_parameters(table, 0)
    common_bond = bond_parameters(bond_table, 0) if BONDS else 0
    for p in range(last - first):
        if far:
            fetch_ahead(rows, pair_a, pair_b, p)
        a = WIDTH * int(pair_a[p])
        b = WIDTH * int(pair_b[p])
        dx = rows[b] - rows[a]
        dy = rows[b + 1] - rows[a + 1]
        dz = 0.0
        if SPACE:
            dz = rows[b + 2] - rows[a + 2]
        if PERIODIC:
            shift_x, shift_y, shift_z = image_shift(vectors, image, p)
            dx += shift_x
            dy += shift_y
            dz += shift_z
        square = dx * dx + dy * dy
        if SPACE:
            square += dz * dz
        radius_a = rows[a + RADIUS]
        radius_b = rows[b + RADIUS]
        zero = radius_a + radius_b
        number = 0
        if BONDS:
            zero += history[p, OFFSET]
            number = int(pair_bond[p])
        if JOINTS and history[p, JOINT] != 0.0:
            if history[p, JOINT] > 0.0:
                carries, pressing = joint_pair(
                    p, number, a, b, FREEDOMS * int(local_a[p]), FREEDOMS * int(local_b[p]), dx, dy, dz, rows,
                    pair_bond, history, bond_table, bond_scale, time_step, step, breaking, loads, energy, utilisation,
                    record,
                )  # fmt: skip
                contacts += carries
                thrust += pressing
            continue
        row = 0 if ONE_MATERIAL else int(rows[a + MATERIAL]) * MATERIALS + int(rows[b + MATERIAL])
        touched = touching[p] != 0
        touch = square < zero * zero
        if REACH and touched:
            parameters = common if ONE_MATERIAL else contact_parameters(table, row)
            limit = zero + contact_reach(parameters, radius_a, radius_b)
            touch = square < limit * limit
        # bonded first: where bonds swing about their length, nobody can guess what touches; a contact that parted has
        # no force, but an account to close
        if number != 0 or touch or (ENERGY and touched):
            distance = math.sqrt(square)
            inverse = 1.0 / distance
            nx = dx * inverse
            ny = dy * inverse
            nz = dz * inverse
            overlap = zero - distance
            arm_a = 0.5 * (distance + radius_a - radius_b)
            arm_b = distance - arm_a
            mass_a = rows[a + MASS]
            mass_b = rows[b + MASS]
            dvx = rows[b + VELOCITY] - rows[a + VELOCITY]
            dvy = rows[b + VELOCITY + 1] - rows[a + VELOCITY + 1]
            dvz = 0.0
            if SPACE:
                dvz = rows[b + VELOCITY + 2] - rows[a + VELOCITY + 2]
            if PERIODIC:
                cell_x, cell_y, cell_z = affine(gradient, dx, dy, dz)
                dvx += cell_x
                dvy += cell_y
                dvz += cell_z
            turn_x = 0.0
            turn_y = 0.0
            turn_z = 0.0
            spin = 0.0
            slip_y = 0.0
            slip_z = 0.0
            twist = 0.0
            bend_y = 0.0
            bend_z = 0.0
            ax = 0.0
            ay = 0.0
            bx = 0.0
            by = 0.0
            if SPACE:
                along = dvx * nx + dvy * ny + dvz * nz
                # the change of n over half a step and the mean spin about n turn the contact's frame
                turn_x, turn_y, turn_z = half_turn(
                    dx, dy, dz, distance, nx, ny, nz, dvx, dvy, dvz, along, time_step
                )
                ax = rows[a + SPIN]
                ay = rows[a + SPIN + 1]
                az = rows[a + SPIN + 2]
                bx = rows[b + SPIN]
                by = rows[b + SPIN + 1]
                bz = rows[b + SPIN + 2]
                spin = spin_about(nx, ny, nz, turn_x, turn_y, turn_z, ax + bx, ay + by, az + bz, time_step)
                enlarged, branch_a, branch_b = branches(distance, radius_a, radius_b)
                wx = branch_a * ax + branch_b * bx
                wy = branch_a * ay + branch_b * by
                wz = branch_a * az + branch_b * bz
                turned = (ax + bx) * (ax + bx) + (ay + by) * (ay + by) + (az + bz) * (az + bz)
                parting, slip_x, slip_y, slip_z = relative_motion(
                    distance, nx, ny, nz, dvx, dvy, dvz, along, enlarged, wx, wy, wz, turned, time_step
                )
                approach = -parting * time_step
                slip_x *= time_step
                slip_y *= time_step
                slip_z *= time_step
                twist = ((bx - ax) * nx + (by - ay) * ny + (bz - az) * nz) * time_step
                bend_x = (bx - ax) * time_step - twist * nx
                bend_y = (by - ay) * time_step - twist * ny
                bend_z = (bz - az) * time_step - twist * nz
            else:
                along = dvx * nx + dvy * ny
                across = dvy * nx - dvx * ny
                # as in 3D: what the distance has changed by; a turn by t moves b by d sin(t) across n
                half = 0.5 * time_step * inverse
                swept = along - half * (along * along + across * across)
                approach = -parting_velocity(swept, half) * time_step
                az = rows[a + SPIN]
                bz = rows[b + SPIN]
                # the largest of two ends what the compiler may multiply in another order from kernel to kernel
                turn = max(abs(az + bz) * time_step, 1e-30)
                slip_x = (
                    across - (arm_a * az + arm_b * bz) * math.sqrt(abs(1.0 - turn * turn * TWELFTH))
                ) * time_step
                bend_x = (bz - az) * time_step
            space = (
                nx, ny, nz, ax * time_step, ay * time_step, az * time_step, bx * time_step, by * time_step,
                bz * time_step, approach, breaking,
            )  # fmt: skip
            normal = 0.0
            shear_x = 0.0
            shear_y = 0.0
            shear_z = 0.0
            twisting = 0.0
            bending_x = 0.0
            bending_y = 0.0
            bending_z = 0.0
            damp = 0.0
            drag_x = 0.0
            drag_y = 0.0
            drag_z = 0.0
            stored = 0.0
            lingers = False
            left = 1.0
            held = load_contact(history, p)
            if not REPLACES or number >= 0:
                # what a bond has just handed over is turned already
                held = transport_contact(held, nx, ny, nz, turn_x, turn_y, turn_z, spin)
            if BONDS and number > 0:
                strength = common_bond if ONE_MATERIAL else bond_parameters(bond_table, row)
                kept = transport_bond(load_bond(history, p), nx, ny, nz, turn_x, turn_y, turn_z, spin)
                (
                    normal, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z,
                    kept, tension, cut,
                ) = bond(
                    strength, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z,
                    radius_a, radius_b, distance, mass_a, mass_b, time_step,
                    bond_scale[number - 1] if SCALED else 1.0, space, kept,
                )  # fmt: skip
                store_bond(history, p, kept)
                if RELAX:
                    utilisation[number - 1, 0] = tension
                    utilisation[number - 1, 1] = cut
                if tension >= breaking or cut >= breaking:
                    pair_bond[p] = -number
                    # for this step a bond that is cut may still act, with what it bears
                    lingers = LINGERS and tension < breaking
                    if lingers:
                        shear_x /= cut
                        shear_y /= cut
                        shear_z /= cut
                    if REPLACES and (touch or lingers):
                        # what the bond carried in shear is handed over; it has taken this step's slip already
                        store_contact(history, p, with_shear(held, shear_x, shear_y, shear_z))
                    record[number - 1, STATE] = 1 if tension >= cut else 2
                    record[number - 1, STEP] = step
                    record[number - 1, PLACE] = rows[a] + arm_a * nx
                    record[number - 1, PLACE + 1] = rows[a + 1] + arm_a * ny
                    if SPACE:
                        record[number - 1, PLACE + 2] = rows[a + 2] + arm_a * nz
                    if not lingers:
                        fresh[overstressed] = p
                        overstressed += 1
                        continue
                    pair_bond[p] = 0
                    touching[p] = 1
                if VISCOUS_BOND:
                    damp, drag_x, drag_y, drag_z = bond_viscous(
                        strength, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance,
                        mass_a, mass_b, time_step,
                    )  # fmt: skip
                if ENERGY and lingers:
                    # what the contact goes on with
                    if touch:
                        stored = contact_energy(
                            contact_parameters(table, row), overlap, radius_a, radius_b, distance, mass_a, mass_b,
                            load_contact(history, p),
                        )  # fmt: skip
                elif ENERGY:
                    stored = bond_energy(
                        strength, overlap, radius_a, radius_b, distance, mass_a, mass_b, kept
                    )
            if BONDS and number < 0:
                pair_bond[p] = 0
                if REPLACES:
                    left = 0.0
            if not (REPLACES and number > 0) and touch:
                parameters = common if ONE_MATERIAL else contact_parameters(table, row)
                step_in = approach if touched or number != 0 else overlap
                (
                    normal_c, shear_cx, shear_cy, shear_cz, twisting_c, bending_cx, bending_cy, bending_cz, held,
                ) = contact(
                    parameters, overlap, step_in, left * slip_x, left * slip_y, left * slip_z, twist, bend_x, bend_y,
                    bend_z, radius_a, radius_b, distance, mass_a, mass_b, time_step, space, held,
                )  # fmt: skip
                store_contact(history, p, held)
                if not touched:
                    touching[p] = 1
                normal += normal_c
                shear_x += shear_cx
                shear_y += shear_cy
                shear_z += shear_cz
                twisting += twisting_c
                bending_x += bending_cx
                bending_y += bending_cy
                bending_z += bending_cz
                if VISCOUS_CONTACT:
                    damp_c, drag_cx, drag_cy, drag_cz = contact_viscous(
                        parameters, overlap, approach, slip_x, slip_y, slip_z, radius_a, radius_b, distance,
                        mass_a, mass_b, time_step,
                    )  # fmt: skip
                    damp += damp_c
                    drag_x += drag_cx
                    drag_y += drag_cy
                    drag_z += drag_cz
                if ENERGY:
                    stored += contact_energy(
                        parameters, overlap, radius_a, radius_b, distance, mass_a, mass_b, held
                    )
            elif touched:
                touching[p] = 0
                store_contact(history, p, no_contact())
                if BONDS and ENERGY and number == 0 and history[p, OFFSET] > 0.0:
                    history[p, OFFSET] = 0.0
            if ENERGY:
                # a contact ends where its surfaces part, wherever they are at the end of the step
                ends = overlap if touch or number != 0 or REACH else 0.0
                lost, heat = account(
                    history, p, stored, approach, slip_x, slip_y, slip_z, twist,
                    bend_x, bend_y, bend_z, ends, normal, shear_x, shear_y, shear_z, twisting, bending_x,
                    bending_y, bending_z, damp, drag_x, drag_y, drag_z,
                )  # fmt: skip
                if not touch and number <= 0:
                    # the next touch begins without overlap
                    history[p, STORED + 6] = 0.0
                energy[ELASTIC] += stored
                energy[VISCOUS] += heat
                if BONDS and (number < 0 or lingers):
                    energy[BROKEN] += lost
                    record[abs(number) - 1, RELEASED] = lost
                else:
                    energy[FRICTION] += lost
            i = FREEDOMS * int(local_a[p])
            j = FREEDOMS * int(local_b[p])
            normal += damp
            shear_x += drag_x
            if SPACE:
                shear_y += drag_y
                shear_z += drag_z
                fx = shear_x - normal * nx
                fy = shear_y - normal * ny
                fz = shear_z - normal * nz
                tx = ny * shear_z - nz * shear_y
                ty = nz * shear_x - nx * shear_z
                tz = nx * shear_y - ny * shear_x
                mx = bending_x + twisting * nx if MOMENT else 0.0
                my = bending_y + twisting * ny if MOMENT else 0.0
                mz = bending_z + twisting * nz if MOMENT else 0.0
                loads[i] += fx
                loads[i + 1] += fy
                loads[i + 2] += fz
                loads[i + 3] += arm_a * tx + mx
                loads[i + 4] += arm_a * ty + my
                loads[i + 5] += arm_a * tz + mz
                loads[j] -= fx
                loads[j + 1] -= fy
                loads[j + 2] -= fz
                loads[j + 3] += arm_b * tx - mx
                loads[j + 4] += arm_b * ty - my
                loads[j + 5] += arm_b * tz - mz
            else:
                fx = -normal * nx - shear_x * ny
                fy = -normal * ny + shear_x * nx
                mz = bending_x if MOMENT else 0.0
                loads[i] += fx
                loads[i + 1] += fy
                loads[i + 2] += arm_a * shear_x + mz
                loads[j] -= fx
                loads[j + 1] -= fy
                loads[j + 2] += arm_b * shear_x - mz
            if PERIODIC:
                moment[0] += fx * dx
                moment[1] += fx * dy
                moment[3] += fy * dx
                moment[4] += fy * dy
                if SPACE:
                    moment[2] += fx * dz
                    moment[5] += fy * dz
                    moment[6] += fz * dx
                    moment[7] += fz * dy
                    moment[8] += fz * dz
            if touch or number != 0:
                contacts += 1.0
                thrust += abs(normal)
        elif touched:
            touching[p] = 0
            store_contact(history, p, no_contact())
            if BONDS and history[p, OFFSET] > 0.0:
                # apart: from now on the pair touches where its surfaces do
                history[p, OFFSET] = 0.0
    return contacts, thrust, overstressed


def pairs(
    first, last, now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history, table, bond_table, bond_scale,
    time_step, step, breaking, force, halo_force, energy, utilisation, record, image, cell, moment,
):  # fmt: skip
    """Forces of the pairs `first` to `last` of a chunk.

    now (n, 8 or 12): rows; pair_a, pair_b, local_a, local_b, pair_bond, touching (p,), history (p, H): the pair list
    and its halo; table, bond_table: parameters by pair of materials; bond_scale (b,); breaking: utilisation at which
    bonds break, 1 but in statics, where utilisation (b, 2) is noted; force (own
    particles, 3 or 6), halo_force (halo, 3 or 6): overwritten; energy (4,): added to; record (b, 5 or 6). image (p, d),
    cell: where PERIODIC, see `geodem.kernels.cell`; moment (9,): added to, sum of force on a times branch.

    Returns
    -------
    contacts, thrust : float
        Number of pairs that carry force and the sum of their normal forces [N].
    """
    load = np.zeros((len(force) + len(halo_force), FREEDOMS))
    fresh = np.empty(last - first if BONDS else 0, np.uint32)
    contacts, thrust, broken = range_of_pairs(
        first, last, now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history, table, bond_table, bond_scale,
        time_step, step, breaking, load, energy, utilisation, record, fresh, image, cell, moment,
    )  # fmt: skip
    if BONDS:
        # what broke is looked at once more as a contact: so the loop over intact bonds has no room for it
        for k in range(broken):
            p = first + int(fresh[k])
            more, pressed, _ = range_of_pairs(
                p, p + 1, now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history, table, bond_table,
                bond_scale, time_step, step, breaking, load, energy, utilisation, record, fresh[:0], image, cell,
                moment,
            )  # fmt: skip
            contacts += more
            thrust += pressed
    size = len(force)
    for k in range(size):
        for axis in range(FREEDOMS):
            force[k, axis] = load[k, axis]
    for k in range(len(halo_force)):
        for axis in range(FREEDOMS):
            halo_force[k, axis] = load[size + k, axis]
    return contacts, thrust
