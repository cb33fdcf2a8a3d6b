"""The loop over the contacts of discs or spheres with walls.

Compiled as `geodem.kernels.pairs` is, together with it and with `geodem.kernels.wall_geometry`: it needs the columns
of the rows and the energy account of pairs, and the adapters that are made from the contact law for walls. It
contains no physics.

For a wall, particle a is the particle and b the wall: the normal points to the wall. A wall is rigid, so the whole
overlap lies in the particle and its arm is the distance to the wall. In 2D a law is called in the contact's own
frame: x is along t = (-ny, nx).
"""

from __future__ import annotations

from typing import Any

from .pairs import (
    ELASTIC,
    ENERGY,
    FRICTION,
    MASS,
    MATERIAL,
    MOMENT,
    RADIUS,
    SPACE,
    SPIN,
    STORED,
    VELOCITY,
    VISCOUS,
    VISCOUS_CONTACT,
    account,
)
from .wall_geometry import (
    BODY_CENTRE,
    BODY_DISPLACEMENT,
    BODY_SPIN,
    BODY_VELOCITY,
    FACETS,
    GEOMETRY_FUNCTIONS,
    RESOLUTION_FUNCTIONS,
    RIGID,
    SAME_POINT,
    WALLS_TURN,
    closest_on_wall,
    drop_shared,
    move_history,
)

# Written by geodem.kernels.adapters from the contact law of the scene.
wall_parameters: Any = None
wall: Any = None
wall_viscous: Any = None
wall_energy: Any = None
wall_reach: Any = None
wall_branches: Any = None  # of the convention, see geodem.laws.convention
spin_about: Any = None
load_wall: Any = None
store_wall: Any = None
no_wall: Any = None
transport_wall: Any = None


def wall_contacts(
    begin,
    end,
    i,
    now,
    primitive,
    touching,
    history,
    normal,
    geometry,
    feature,
    shape,
    kind,
    body,
    vertex,
    bodies,
    table,
):
    """Which of the pairs `begin` to `end` of one particle are contacts: those whose feature is 0 to 6 afterwards."""
    x = now[i, 0]
    y = now[i, 1]
    z = now[i, 2] if SPACE else 0.0
    radius = now[i, RADIUS]
    first_row = int(now[i, MATERIAL]) * len(bodies)
    near = SAME_POINT * radius
    contacts = 0
    for p in range(begin, end):
        owner = body[primitive[p]]
        nx, ny, nz, distance, which = closest_on_wall(x, y, z, near, shape, kind, bodies, primitive[p], owner)
        reach = wall_reach(wall_parameters(table, first_row + owner), radius, RIGID * radius)
        within = distance < radius + reach
        geometry[p, 0] = nx
        geometry[p, 1] = ny
        geometry[p, 2] = nz
        geometry[p, 3] = distance
        feature[p] = which if within else -1
        if within:
            contacts += 1
    if FACETS and end - begin > 1:
        if contacts > 1:
            drop_shared(begin, end, primitive, body, vertex, geometry, feature, near)
        move_history(begin, end, primitive, body, vertex, touching, history, normal, geometry, feature)
    for p in range(begin, end):
        # a contact may hold beyond touch, but it begins there
        if feature[p] >= 8 or (touching[p] == 0 and geometry[p, 3] >= radius):
            feature[p] = -1


def wall_forces(
    now, base, first, last, particle, primitive, touching, history, normal, geometry, feature,
    shape, kind, body, vertex, bodies, table, time_step, force, energy, sums,
):  # fmt: skip
    """Forces of wall pairs `first` to `last` of the chunk that owns the particles from row `base`.

    now (n, 8 or 12): rows. particle, primitive (w,) uint32: the wall pairs, sorted by particle; touching (w,) uint8,
    history (w, H), normal (w, 3): kept from step to step; geometry (w, 4), feature (w,) int8: overwritten. shape, kind,
    body, vertex: the primitives; bodies (b, BODY_WIDTH); table: parameters, row material * b + body. force (size,
    3 or 6), energy (4,): added to; sums (b, 3 or 6): overwritten with the force of this chunk on every body and its
    torque about the body's centre.

    Returns
    -------
    contacts, thrust : float
        Number of contacts and the sum of their normal forces [N].
    """
    for owner in range(sums.shape[0]):
        for k in range(sums.shape[1]):
            sums[owner, k] = 0.0
    contacts = 0.0
    thrust = 0.0
    begin = first
    while begin < last:
        i = int(particle[begin])
        end = begin + 1
        while end < last and particle[end] == particle[begin]:
            end += 1
        wall_contacts(
            begin, end, i, now, primitive, touching, history, normal, geometry, feature, shape, kind, body, vertex,
            bodies, table,
        )  # fmt: skip
        radius = now[i, RADIUS]
        mass = now[i, MASS]
        for p in range(begin, end):
            if feature[p] < 0 and not (ENERGY and touching[p] != 0):
                if touching[p] != 0:
                    touching[p] = 0
                    store_wall(history, p, no_wall())
                continue
            owner = int(body[primitive[p]])
            parameters = wall_parameters(table, int(now[i, MATERIAL]) * len(bodies) + owner)
            nx = geometry[p, 0]
            ny = geometry[p, 1]
            nz = geometry[p, 2]
            distance = geometry[p, 3]
            overlap = radius - distance
            # from the body's centre to the contact
            rx = now[i, 0] + distance * nx - bodies[owner, BODY_CENTRE] - bodies[owner, BODY_DISPLACEMENT]
            ry = (
                now[i, 1]
                + distance * ny
                - bodies[owner, BODY_CENTRE + 1]
                - bodies[owner, BODY_DISPLACEMENT + 1]
            )
            vx = bodies[owner, BODY_VELOCITY] - now[i, VELOCITY]
            vy = bodies[owner, BODY_VELOCITY + 1] - now[i, VELOCITY + 1]
            bx = bodies[owner, BODY_SPIN]
            by = bodies[owner, BODY_SPIN + 1]
            bz = bodies[owner, BODY_SPIN + 2]
            # half the change of the normal: on a facet it stays, whatever the way of the particle, so it is remembered
            turn_x = 0.0
            turn_y = 0.0
            turn_z = 0.0
            if touching[p] != 0:
                turn_x = 0.5 * (nx - normal[p, 0])
                turn_y = 0.5 * (ny - normal[p, 1])
                turn_z = 0.5 * (nz - normal[p, 2])
            spin = 0.0
            slip_y = 0.0
            slip_z = 0.0
            twist = 0.0
            bend_y = 0.0
            bend_z = 0.0
            ax = 0.0
            ay = 0.0
            arm = distance
            if SPACE:
                rz = (
                    now[i, 2]
                    + distance * nz
                    - bodies[owner, BODY_CENTRE + 2]
                    - bodies[owner, BODY_DISPLACEMENT + 2]
                )
                vz = bodies[owner, BODY_VELOCITY + 2] - now[i, VELOCITY + 2]
                ax = now[i, SPIN]
                ay = now[i, SPIN + 1]
                az = now[i, SPIN + 2]
                if WALLS_TURN:
                    # velocities are those of half a step ago, and so must be the place
                    half = 0.5 * time_step
                    hx = rx - half * (by * rz - bz * ry)
                    hy = ry - half * (bz * rx - bx * rz)
                    hz = rz - half * (bx * ry - by * rx)
                    vx += by * hz - bz * hy
                    vy += bz * hx - bx * hz
                    vz += bx * hy - by * hx
                enlarged, branch, arm = wall_branches(distance, radius)
                along = vx * nx + vy * ny + vz * nz
                vx += (enlarged - 1.0) * (vx - along * nx) - branch * (
                    ay * (nz - turn_z) - az * (ny - turn_y)
                )
                vy += (enlarged - 1.0) * (vy - along * ny) - branch * (
                    az * (nx - turn_x) - ax * (nz - turn_z)
                )
                vz += (enlarged - 1.0) * (vz - along * nz) - branch * (
                    ax * (ny - turn_y) - ay * (nx - turn_x)
                )
                along = vx * nx + vy * ny + vz * nz
                slip_x = (vx - along * nx) * time_step
                slip_y = (vy - along * ny) * time_step
                slip_z = (vz - along * nz) * time_step
                twist = ((bx - ax) * nx + (by - ay) * ny + (bz - az) * nz) * time_step
                bend_x = (bx - ax) * time_step - twist * nx
                bend_y = (by - ay) * time_step - twist * ny
                bend_z = (bz - az) * time_step - twist * nz
                if touching[p] != 0:
                    spin = spin_about(
                        nx, ny, nz, turn_x, turn_y, turn_z, ax + bx, ay + by, az + bz, time_step
                    )
            else:
                if WALLS_TURN:
                    vx -= bz * (ry - 0.5 * time_step * bz * rx)
                    vy += bz * (rx + 0.5 * time_step * bz * ry)
                along = vx * nx + vy * ny
                az = now[i, SPIN]
                slip_x = (vy * nx - vx * ny - distance * az) * time_step
                bend_x = (bz - az) * time_step
            approach = -along * time_step
            space = (
                nx, ny, nz, ax * time_step, ay * time_step, az * time_step, bx * time_step, by * time_step,
                bz * time_step, approach,
            )  # fmt: skip
            # one that parted has no force, but an account to close
            meets = not ENERGY or feature[p] >= 0
            held = no_wall()
            if meets and touching[p] != 0:
                held = transport_wall(load_wall(history, p), nx, ny, nz, turn_x, turn_y, turn_z, spin)
            (
                press, shear_x, shear_y, shear_z, twisting, bending_x, bending_y, bending_z, held,
            ) = wall(
                parameters, overlap, approach if touching[p] != 0 else overlap, slip_x, slip_y, slip_z,
                twist, bend_x, bend_y, bend_z, radius, RIGID * radius, distance, mass, RIGID * mass, time_step, space,
                held,
            )  # fmt: skip
            if not meets:
                press = 0.0
                shear_x = 0.0
                shear_y = 0.0
                shear_z = 0.0
                twisting = 0.0
                bending_x = 0.0
                bending_y = 0.0
                bending_z = 0.0
                held = no_wall()
            store_wall(history, p, held)
            damp = 0.0
            drag_x = 0.0
            drag_y = 0.0
            drag_z = 0.0
            if VISCOUS_CONTACT and meets:
                damp, drag_x, drag_y, drag_z = wall_viscous(
                    parameters, overlap, approach, slip_x, slip_y, slip_z, radius, RIGID * radius, distance,
                    mass, RIGID * mass, time_step,
                )  # fmt: skip
            if ENERGY:
                stored = 0.0
                if meets:
                    stored = wall_energy(
                        parameters, overlap, radius, RIGID * radius, distance, mass, RIGID * mass, held
                    )
                # a contact ends where its surfaces part, wherever they are at the end of the step
                ends = overlap if meets or wall_reach(parameters, radius, RIGID * radius) > 0.0 else 0.0
                lost, heat = account(
                    history, p, stored, approach, slip_x, slip_y, slip_z, twist,
                    bend_x, bend_y, bend_z, ends, press, shear_x, shear_y, shear_z, twisting, bending_x,
                    bending_y, bending_z, damp, drag_x, drag_y, drag_z,
                )  # fmt: skip
                if not meets:
                    history[p, STORED + 6] = 0.0
                energy[ELASTIC] += stored
                energy[VISCOUS] += heat
                energy[FRICTION] += lost
            touching[p] = 1 if meets else 0
            normal[p, 0] = nx
            normal[p, 1] = ny
            normal[p, 2] = nz
            press += damp
            shear_x += drag_x
            contacts += 1.0 if meets else 0.0
            thrust += abs(press)
            row = i - base
            if SPACE:
                shear_y += drag_y
                shear_z += drag_z
                fx = shear_x - press * nx
                fy = shear_y - press * ny
                fz = shear_z - press * nz
                mx = bending_x + twisting * nx if MOMENT else 0.0
                my = bending_y + twisting * ny if MOMENT else 0.0
                mz = bending_z + twisting * nz if MOMENT else 0.0
                force[row, 0] += fx
                force[row, 1] += fy
                force[row, 2] += fz
                force[row, 3] += arm * (ny * shear_z - nz * shear_y) + mx
                force[row, 4] += arm * (nz * shear_x - nx * shear_z) + my
                force[row, 5] += arm * (nx * shear_y - ny * shear_x) + mz
                sums[owner, 0] -= fx
                sums[owner, 1] -= fy
                sums[owner, 2] -= fz
                sums[owner, 3] -= ry * fz - rz * fy + mx
                sums[owner, 4] -= rz * fx - rx * fz + my
                sums[owner, 5] -= rx * fy - ry * fx + mz
            else:
                fx = -press * nx - shear_x * ny
                fy = -press * ny + shear_x * nx
                mz = bending_x if MOMENT else 0.0
                force[row, 0] += fx
                force[row, 1] += fy
                force[row, 2] += distance * shear_x + mz
                sums[owner, 0] -= fx
                sums[owner, 1] -= fy
                sums[owner, 2] -= rx * fy - ry * fx + mz
        begin = end
    return contacts, thrust


FACET_FUNCTIONS = (*GEOMETRY_FUNCTIONS, *RESOLUTION_FUNCTIONS, wall_contacts)
"""Functions to compile before `wall_forces`, callees first, after the adapters of the law and the energy account."""

PLANE_FUNCTIONS = (closest_on_wall, wall_contacts)
"""Those that are called where all walls are planes; short enough to be inlined."""
