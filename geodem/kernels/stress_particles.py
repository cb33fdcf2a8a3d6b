"""The loops of stress-carrying particles: gather strain, let the law update the stress, gather force, move.

These functions are never run as they stand here (but in tests): `geodem._jit.compile_kernel` joins their text with
that of a law and with the constants below, set to what the scene has.

Time is counted in steps: one step is one unit, and the inertial mass of a freedom is its stiffness sum scaled
so that this step is stable (see `geodem.integrators.relaxation`). True weight is kept. Leap-frog: after a step
the stress and the displacement belong to the same instant, the velocity to half a step later.
"""

from __future__ import annotations

import math

from ..laws.ground.mohr_coulomb import elastic_energy, update_stress
from .supports import hold, stretch

prange = range

# What a scene may lack; set by the module that the kernel is compiled in.
ONE_MATERIAL = False
ENERGY = True
SUPPORTED = False
CHUNK = 128


def deform(velocity, start, index, vector, area, material, table, stress, dissipation):
    """One step of strain and stress of every stress point.

    velocity (n, 2) [m/step]; start, index, vector: rows of stress points; area (s,); material (s,);
    table (materials, parameters); stress (s, 4): xx, yy, xy [Pa], plastic shear strain; dissipation (s,) [J/m3].
    """
    points = len(area)
    for chunk in prange((points + CHUNK - 1) // CHUNK):
        for point in range(chunk * CHUNK, min(points, chunk * CHUNK + CHUNK)):
            xx = 0.0
            yy = 0.0
            xy = 0.0
            for entry in range(start[point], start[point + 1]):
                particle = index[entry]
                gx = vector[entry, 0]
                gy = vector[entry, 1]
                vx = velocity[particle, 0]
                vy = velocity[particle, 1]
                xx += gx * vx
                yy += gy * vy
                xy += gx * vy + gy * vx
            inverse = 1.0 / area[point]
            row = 0 if ONE_MATERIAL else material[point]
            old_xx = stress[point, 0]
            old_yy = stress[point, 1]
            old_xy = stress[point, 2]
            new_xx, new_yy, new_xy, plastic_area, plastic_shear = update_stress(
                table[row, 0], table[row, 1], table[row, 2], table[row, 3], table[row, 4], table[row, 5],
                old_xx, old_yy, old_xy, xx * inverse, yy * inverse, 0.5 * xy * inverse,
            )  # fmt: skip
            stress[point, 0] = new_xx
            stress[point, 1] = new_yy
            stress[point, 2] = new_xy
            stress[point, 3] += plastic_shear
            if ENERGY and plastic_shear + abs(plastic_area) > 0.0:
                # what the stress worked and did not store, whatever the law's way back to its strength
                done = (
                    0.5 * (old_xx + new_xx) * xx + 0.5 * (old_yy + new_yy) * yy + 0.5 * (old_xy + new_xy) * xy
                )
                stored = elastic_energy(table[row, 0], table[row, 1], new_xx, new_yy, new_xy)
                stored -= elastic_energy(table[row, 0], table[row, 1], old_xx, old_yy, old_xy)
                dissipation[point] += done * inverse - stored


def move(
    stress, start, index, vector, external, inverse_mass, damping,
    velocity, displacement, force, sums,
):  # fmt: skip
    """One step of every particle: gather the force, damp, move; and the sums of each chunk.

    stress (s, 4); start, index, vector: rows of particles; external (n, 2) [N/m]; inverse_mass (n, 2) (0: held);
    damping [1/step]; velocity, displacement, force (n, 2), updated; sums (chunks, 4), overwritten: v.(F_old - F_new),
    v.m.v, |F|^2 of the free freedoms, work of damping.
    """
    particles = len(external)
    keep = (1.0 - 0.5 * damping) / (1.0 + 0.5 * damping)
    push = 1.0 / (1.0 + 0.5 * damping)
    for chunk in prange((particles + CHUNK - 1) // CHUNK):
        softening = 0.0
        inertia = 0.0
        unbalanced = 0.0
        damped = 0.0
        for particle in range(chunk * CHUNK, min(particles, chunk * CHUNK + CHUNK)):
            fx = external[particle, 0]
            fy = external[particle, 1]
            for entry in range(start[particle], start[particle + 1]):
                point = index[entry]
                gx = vector[entry, 0]
                gy = vector[entry, 1]
                xy = stress[point, 2]
                fx -= stress[point, 0] * gx + xy * gy
                fy -= xy * gx + stress[point, 1] * gy
            vx = velocity[particle, 0]
            vy = velocity[particle, 1]
            ix = inverse_mass[particle, 0]
            iy = inverse_mass[particle, 1]
            displacement[particle, 0] += vx
            displacement[particle, 1] += vy
            softening += vx * (force[particle, 0] - fx) + vy * (force[particle, 1] - fy)
            force[particle, 0] = fx
            force[particle, 1] = fy
            wx = keep * vx + push * fx * ix
            wy = keep * vy + push * fy * iy
            velocity[particle, 0] = wx
            velocity[particle, 1] = wy
            if ix > 0.0:
                unbalanced += fx * fx
                inertia += vx * vx / ix
                if ENERGY:
                    damped += 0.25 * (vx + wx) * (vx + wx) / ix
            if iy > 0.0:
                unbalanced += fy * fy
                inertia += vy * vy / iy
                if ENERGY:
                    damped += 0.25 * (vy + wy) * (vy + wy) / iy
        sums[chunk, 0] = softening
        sums[chunk, 1] = inertia
        sums[chunk, 2] = unbalanced
        sums[chunk, 3] = damped * damping


def relax(
    steps, damping_ratio, damping, external, inverse_mass,
    point_start, point_index, point_vector, area, material, table,
    particle_start, particle_index, particle_vector,
    velocity, displacement, force, stress, dissipation, sums,
    link_start, link_index, link_vector, link_table, holding_start, holding_index, holding_vector, support, pushed,
):  # fmt: skip
    """`steps` steps of adaptive viscous relaxation.

    The damping is `damping_ratio` times critical for the lowest frequency that the present motion shows, the Rayleigh
    quotient v.(change of force)/v.m.v; in plastic flow the quotient falls to zero and so does the damping. Links of
    supports, where there are any, push with the ground; `pushed` (n, 2) is room for the sum.

    Returns
    -------
    damping [1/step], unbalanced |F| [N/m], work of damping [J/m]
    """
    unbalanced = 0.0
    damped = 0.0
    for _ in range(steps):
        deform(velocity, point_start, point_index, point_vector, area, material, table, stress, dissipation)
        if SUPPORTED:
            stretch(velocity, link_start, link_index, link_vector, link_table, support)
            hold(support, holding_start, holding_index, holding_vector, external, pushed)
        move(
            stress, particle_start, particle_index, particle_vector, pushed if SUPPORTED else external, inverse_mass,
            damping, velocity, displacement, force, sums,
        )  # fmt: skip
        softening = 0.0
        inertia = 0.0
        unbalanced = 0.0
        for chunk in range(len(sums)):
            softening += sums[chunk, 0]
            inertia += sums[chunk, 1]
            unbalanced += sums[chunk, 2]
            damped += sums[chunk, 3]
        if inertia > 0.0:
            square = min(max(softening / inertia, 0.0), 1.0)
            damping = 2.0 * damping_ratio * math.sqrt(square)
    return damping, math.sqrt(unbalanced), damped
