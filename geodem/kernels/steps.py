"""The steps: every chunk's forces and motion in one parallel region a step, then what must be done by one thread.

Like `geodem.kernels.pairs`, these functions are compiled in a generated module.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .motion import (
    CONTACTS,
    FASTEST,
    INERTIA,
    SOFTENING,
    THRUST,
    TOTAL_BROKEN,
    TOTAL_ELASTIC,
    TOTAL_FRICTION,
    TOTAL_VISCOUS,
    move,
)
from .pairs import pairs

prange = range
wall_forces: Any = None  # of the scene's dimension
gather_wall_forces: Any = None
move_walls: Any = None
sleep_and_wake: Any = None

WALLS = True
RELAX = True
ENERGY = True
SLEEP = True
FREEDOMS = 6


def watched(chunk, neighbour_start, neighbour, asleep):
    """Whether a chunk is awake that pairs listed by this one act on."""
    for k in range(neighbour_start[chunk], neighbour_start[chunk + 1]):
        # pairs are listed under the lower row
        if neighbour[k] > chunk and asleep[neighbour[k]] == 0:
            return True
    return False


def chunk_forces(
    chunk, chunk_size, now, pair_start, pair_a, pair_b, local_a, local_b, pair_bond, touching, history,
    table, bond_table, bond_scale, halo_start, lapse, step, breaking, utilisation, record, sums,
    force, halo_force, awake,
):  # fmt: skip
    """Forces of one chunk's pairs: on its own particles, where it is awake, and on those in its halo."""
    base = chunk * chunk_size
    size = min(chunk_size, len(now) - base)
    own = force[base : base + size]
    if SLEEP and not awake:
        # what it felt last is kept
        own = np.empty((size, FREEDOMS))
    energy = np.zeros(4)
    contacts, thrust = pairs(
        pair_start[chunk], pair_start[chunk + 1], now, pair_a, pair_b, local_a, local_b, pair_bond, touching, history,
        table, bond_table, bond_scale, lapse, step, breaking, own,
        halo_force[halo_start[chunk] : halo_start[chunk + 1]], energy, utilisation, record,
    )  # fmt: skip
    if awake:
        # else what they were with the walls' when it fell asleep
        sums[CONTACTS] = contacts
        sums[THRUST] = thrust
    if ENERGY:
        sums[TOTAL_FRICTION] += energy[0]
        sums[TOTAL_VISCOUS] += energy[1]
        sums[TOTAL_BROKEN] += energy[2]
        if awake:
            sums[TOTAL_ELASTIC] = energy[3]


def chunk_motion(
    chunk, chunk_size, now, following, into, source, target, inverse_mass, inverse_inertia, gravity, applied, held,
    anchor_of, anchors, angle, wall_start, wall_particle, wall_primitive, wall_touching, wall_history, wall_normal,
    wall_geometry, wall_feature, shape, kind, body, vertex, bodies, wall_table, wall_sums, lapse, span, time_step,
    local_damping, global_damping, old_force, sums, force, halo_force,
):  # fmt: skip
    """Take over what other chunks added up for this one's particles, add the forces of walls, and move them."""
    base = chunk * chunk_size
    size = min(chunk_size, len(now) - base)
    force = force[base : base + size]
    for k in range(into[chunk], into[chunk + 1]):
        place = source[k]
        particle = target[k]
        for axis in range(FREEDOMS):
            force[particle, axis] += halo_force[place, axis]
    if WALLS:
        energy = np.zeros(4)
        contacts, thrust = wall_forces(
            now, base, wall_start[chunk], wall_start[chunk + 1], wall_particle, wall_primitive, wall_touching,
            wall_history, wall_normal, wall_geometry, wall_feature, shape, kind, body, vertex, bodies, wall_table,
            lapse, force, energy, wall_sums[chunk],
        )  # fmt: skip
        sums[CONTACTS] += contacts
        sums[THRUST] += thrust
        if ENERGY:
            sums[TOTAL_FRICTION] += energy[0]
            sums[TOTAL_VISCOUS] += energy[1]
            sums[TOTAL_BROKEN] += energy[2]
            sums[TOTAL_ELASTIC] += energy[3]
    move(
        base, size, now, following, force, inverse_mass, inverse_inertia, gravity, applied, held, anchor_of, anchors,
        angle, span, time_step, local_damping, global_damping, old_force, sums,
    )  # fmt: skip


def advance(
    teams, steps, rows, phase, chunk_size, pair_start, pair_a, pair_b, local_a, local_b, pair_bond, touching, history,
    halo_start, into, source, target, lowest, table, bond_table, bond_scale, inverse_mass, inverse_inertia, gravity,
    applied, held, anchor_of, anchors, angle,
    wall_start, wall_particle, wall_primitive, wall_touching, wall_history, wall_normal, wall_geometry, wall_feature,
    shape, kind, body, vertex, bodies, wall_table, wall_sums,
    first_lapse, first_span, time_step, first_step, breaking, local_damping, global_damping, damping_ratio, old_force,
    utilisation, record, sums, force, halo_force, moved, carried, buffer, asleep, quiet, neighbour_start, neighbour,
    sleep_speed, sleep_steps,
):  # fmt: skip
    """Up to `steps` steps; fewer where particles may have moved farther than the pair list allows.

    teams: parts of the chunks that are computed at the same time, one a thread; no bit depends on their number.
    rows (2, n, 8 or 12), phase: which of the two holds the present; local_a to target: see `geodem.neighbors.halo`;
    sums (chunks, 17); force (n, 3 or 6): resultants of the last step, halo_force (h, 3 or 6); moved, carried [m]: how
    far particles and walls may have moved since the last search, added up here so that no rounding depends on where a
    batch of steps ended; buffer [m]: of the pair list. first_lapse [s]: how long things have moved since the laws were
    last asked, first_span [s]: how long the first forces act on the velocities, both one step from then on.
    global_damping, damping_ratio: where RELAX, the damping of the first step and its share of the critical one of the
    lowest frequency in motion.
    Sleep: asleep (chunks,) uint8, quiet (chunks,) steps that a chunk and all around it have been slower than
    sleep_speed; neighbour_start, neighbour: the chunks around each one.

    Returns
    -------
    done : int
        Steps taken.
    moved, carried : float
        Bounds of the ways that both particles of a pair, and any wall, have gone since the last search [m].
    global_damping : float
        Of the last step.
    """
    chunks = len(sums)
    for done in range(steps):
        present = (phase + done) & 1
        lapse = first_lapse if done == 0 else time_step
        span = first_span if done == 0 else time_step
        now = rows[present]
        following = rows[1 - present]
        # what a chunk takes over comes from chunks before it: where they are the same team's, its particles are moved
        # at once, while they are in the cache; the others when all teams are done
        for late in range(2):
            for team in prange(teams):
                first = team * chunks // teams
                for chunk in range(first, (team + 1) * chunks // teams):
                    awake = not SLEEP or asleep[chunk] == 0
                    if late == 0 and (awake or watched(chunk, neighbour_start, neighbour, asleep)):
                        chunk_forces(
                            chunk, chunk_size, now, pair_start, pair_a, pair_b, local_a, local_b, pair_bond, touching,
                            history, table, bond_table, bond_scale, halo_start, lapse, first_step + done, breaking,
                            utilisation, record, sums[chunk], force, halo_force, awake,
                        )  # fmt: skip
                    if awake and (lowest[chunk] < first) == (late == 1):
                        chunk_motion(
                            chunk, chunk_size, now, following, into, source, target, inverse_mass, inverse_inertia,
                            gravity, applied, held, anchor_of, anchors, angle, wall_start, wall_particle,
                            wall_primitive, wall_touching, wall_history, wall_normal, wall_geometry, wall_feature,
                            shape, kind, body, vertex, bodies, wall_table, wall_sums, lapse, span, time_step,
                            local_damping, global_damping, old_force, sums[chunk], force, halo_force,
                        )  # fmt: skip
        fastest = 0.0
        for chunk in range(chunks):
            fastest = max(fastest, sums[chunk, FASTEST])
        moved += 2.0 * fastest * time_step
        if WALLS:
            gather_wall_forces(wall_start, wall_sums, bodies, lapse)
            carried += move_walls(bodies, time_step) * time_step
        if RELAX:
            softening = 0.0
            inertia = 0.0
            for chunk in range(chunks):
                softening += sums[chunk, SOFTENING]
                inertia += sums[chunk, INERTIA]
            if inertia > 0.0:
                square = min(max(softening / inertia, 0.0), 1.0)
                global_damping = 2.0 * damping_ratio * np.sqrt(square)
        if SLEEP:
            sleep_and_wake(
                chunk_size, rows, present, sums, asleep, quiet, neighbour_start, neighbour, sleep_speed, sleep_steps,
                wall_start, wall_primitive, body, bodies,
            )  # fmt: skip
        # not "moved > buffer": a motion that is no number must stop the run too
        if not (moved + carried <= buffer):
            return done + 1, moved, carried, global_damping
    return steps, moved, carried, global_damping
