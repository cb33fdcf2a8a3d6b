"""A scene of few particles and walls, with linear friction written for the tests: no law of geodem is in it."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from geodem._jit import compile_kernel
from geodem.boundaries.wall_pairs import find_wall_pairs
from geodem.boundaries.wall_table import wall_table
from geodem.kernels import pairs, wall_geometry, wall_motion, walls
from geodem.laws.convention import geodem as own_convention

KN, KS, FRICTION = 1e6, 5e5, 0.5
REACH = 0.0
SPACE = True


def wall_parameters(table, row):
    return table[row, 0], table[row, 1], table[row, 2]


def wall(
    parameters, overlap, approach, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b, distance,
    mass_a, mass_b, time_step, space, history,
):  # fmt: skip
    normal = parameters[0] * overlap
    x = history[0] + parameters[1] * slip_x
    y = history[1] + parameters[1] * slip_y
    z = history[2] + parameters[1] * slip_z
    size = math.sqrt(x * x + y * y + z * z)
    most = parameters[2] * max(normal, 0.0)
    share = most / size if size > most else 1.0
    x *= share
    y *= share
    z *= share
    return normal, x, y, z, 0.0, 0.0, 0.0, 0.0, (x, y, z)


def wall_viscous(
    parameters,
    overlap,
    approach,
    slip_x,
    slip_y,
    slip_z,
    radius_a,
    radius_b,
    distance,
    mass_a,
    mass_b,
    time_step,
):
    return 0.0, 0.0, 0.0, 0.0


def wall_energy(parameters, overlap, radius_a, radius_b, distance, mass_a, mass_b, history):
    square = history[0] * history[0] + history[1] * history[1] + history[2] * history[2]
    return 0.5 * parameters[0] * overlap * overlap + 0.5 * square / parameters[1]


def wall_reach(parameters, radius_a, radius_b):
    return REACH


def load_wall(history, p):
    return history[p, 0], history[p, 1], history[p, 2]


def store_wall(history, p, values):
    history[p, 0] = values[0]
    history[p, 1] = values[1]
    history[p, 2] = values[2]


def no_wall():
    return 0.0, 0.0, 0.0


def transport_wall(values, nx, ny, nz, turn_x, turn_y, turn_z, spin):
    x, y, z = values
    if not SPACE:
        return x, y, z
    out = x * nx + y * ny + z * nz
    keep = 1.0 - 0.5 * spin * spin
    return (
        keep * x - out * (nx - turn_x) + spin * (ny * z - nz * y),
        keep * y - out * (ny - turn_y) + spin * (nz * x - nx * z),
        keep * z - out * (nz - turn_z) + spin * (nx * y - ny * x),
    )


STAND_IN = (
    wall_parameters, wall, wall_viscous, wall_energy, wall_reach, load_wall, store_wall, no_wall, transport_wall,
)  # fmt: skip


@cache
def kernel(dimension, turn, reach=0.0):
    """The loops over walls, compiled with the stand-in."""
    space = dimension == 3
    constants = {
        **wall_geometry.WALL_CONSTANTS,
        "SPACE": space,
        "WALLS_TURN": turn,
        "FACETS": True,
        "RADIUS": 3 if space else 2,
        "MATERIAL": 11 if space else 3,
        "SPIN": 8 if space else 6,
        "VELOCITY": 4,
        "MASS": 7,
        "MOMENT": True,
        "ENERGY": True,
        "VISCOUS_CONTACT": False,
        "STORED": 3,
        "FRICTION": pairs.FRICTION,
        "VISCOUS": pairs.VISCOUS,
        "ELASTIC": pairs.ELASTIC,
        "REACH": reach,
    }
    functions = (
        *STAND_IN,
        own_convention.wall_branches,
        own_convention.spin_about,
        pairs.account,
        *walls.FACET_FUNCTIONS,
        walls.wall_forces,
        *wall_motion.MOTION_FUNCTIONS,
    )
    return compile_kernel(functions, constants, parallel=False, finite=True)


def particle_rows(dimension, positions, radii, mass=1.0):
    """Rows of particles at rest, of material 0."""
    positions = np.atleast_2d(np.asarray(positions, dtype=float))
    rows = np.zeros((len(positions), 8 if dimension == 2 else 12))
    rows[:, :dimension] = positions
    rows[:, dimension if dimension == 3 else 2] = radii
    rows[:, 7] = mass
    return rows


class WallScene:
    """Walls and particles whose motion the test prescribes."""

    def __init__(self, walls, rows, *, buffer=0.5, chunk=4, reach=0.0, dt=1e-3):
        self.walls = walls
        self.rows = rows
        self.dimension = 2 if rows.shape[1] == 8 else 3
        self.table = wall_table(walls, self.dimension)
        self.buffer, self.chunk, self.dt = buffer, chunk, dt
        self.parameters = np.tile([KN, KS, FRICTION], (max(len(walls), 1), 1))
        self.energy = np.zeros(4)
        self.kernel = kernel(self.dimension, self.table.walls_turn, reach)
        self.pairs = None
        self.search()

    def search(self, old_row_of_new=None):
        self.pairs = find_wall_pairs(
            self.rows, self.table, buffer=self.buffer, chunk=self.chunk, history_width=17, old=self.pairs,
            old_row_of_new=old_row_of_new,
        )  # fmt: skip

    def forces(self):
        """Force and torque on every particle, (n, 3 or 6); the sums on the bodies go into the table."""
        pairs, table = self.pairs, self.table
        columns = 3 if self.dimension == 2 else 6
        output = np.zeros((len(self.rows), columns))
        sums = np.zeros((len(pairs.start) - 1, len(table.bodies), columns))
        self.energy[3] = 0.0
        self.contacts = 0.0
        for chunk in range(len(pairs.start) - 1):
            base = chunk * self.chunk
            count, _ = self.kernel.wall_forces(
                self.rows, base, pairs.start[chunk], pairs.start[chunk + 1], pairs.particle, pairs.primitive,
                pairs.touching, pairs.history, pairs.normal, pairs.geometry, pairs.feature, table.shape, table.kind,
                table.body, table.vertex, table.bodies, self.parameters, self.dt, output[base:], self.energy,
                sums[chunk],
            )  # fmt: skip
            self.contacts += count
        self.kernel.gather_wall_forces(pairs.start, sums, table.bodies, self.dt)
        return output

    def slide(self, steps):
        """Let particles and walls move on with the velocities they have; the forces of every step."""
        found = []
        for step in range(steps):
            if step % 25 == 0:
                self.search()
            found.append(self.forces())
            self.rows[:, : self.dimension] += self.rows[:, 4 : 4 + self.dimension] * self.dt
            self.kernel.move_walls(self.table.bodies, self.dt)
        return np.array(found)
