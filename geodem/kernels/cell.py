"""A periodic cell in the loops: images of particles, the motion of the cell, its control, and the work that it does.

Compiled in a generated module like `geodem.kernels.pairs`, and only where a scene has a cell.

A particle's position follows the cell, x += (v + L x) dt, where L is the cell's velocity gradient and v the particle's
velocity, a fluctuation about it; forces change v alone. Source: Cundall 1988, Computer simulations of dense sphere
assemblies, in Micromechanics of Granular Materials (TRUBAL). Stress is positive in tension and strain in extension.

The cell is one row of numbers; matrices are 3 x 3, row by row, in 2D too, where z is never read.
"""

from __future__ import annotations

import math

import numpy as np

# Set by the module that the kernel is compiled in.
PERIODIC = True
SPACE = True

# Places in a block, as in geodem.kernels.blocks.
LANES = 64
RELATIVE = 4 * LANES
FORCE = 60 * LANES

# Columns of the cell.
CELL_VECTORS = 0  # rows: the edges [m]
CELL_GRADIENT = 9  # velocity gradient dv_i/dx_j of the next motion [1/s]
CELL_LAST = 18  # that of the last motion, as seen from where it led to [1/s]
CELL_DEFORMATION = 27  # deformation gradient since the start [-]
CELL_SEARCHED = 36  # deformation gradient at the last search [-]
CELL_MOMENT = 45  # sum of force on a times branch from a to b, over pairs, last step [N m]
CELL_CONTROL = 54  # of every component: 0 given rate, 1 its own stress, 2 the mean stress
CELL_TARGET = 63  # stress [Pa]
CELL_LIMIT = 72  # largest rate [1/s]
CELL_GAIN = 81  # given gain [1/(Pa s)]; 0: the cell's own
CELL_OWN_GAIN = 90  # [1/(Pa s)]
CELL_WORK = 91  # done by the cell since the start [J]
CELL_REACH = 92  # longest distance of a pair that is listed because it is near [m]
CELL_WIDTH = 93

CELL_SUMS = 17
"""First column, in the sums of a chunk, of its part of the moment."""


def cell_matrix(cell, first):
    """Nine numbers of the cell."""
    return (
        cell[first], cell[first + 1], cell[first + 2], cell[first + 3], cell[first + 4], cell[first + 5],
        cell[first + 6], cell[first + 7], cell[first + 8],
    )  # fmt: skip


def image_shift(vectors, image, p):
    """Way from a particle to the image of it that a pair means [m]."""
    i = float(image[p, 0])
    j = float(image[p, 1])
    x = i * vectors[0] + j * vectors[3]
    y = i * vectors[1] + j * vectors[4]
    z = 0.0
    if SPACE:
        k = float(image[p, 2])
        x += k * vectors[6]
        y += k * vectors[7]
        z = i * vectors[2] + j * vectors[5] + k * vectors[8]
    return x, y, z


def affine(gradient, x, y, z):
    """A matrix times a vector."""
    if SPACE:
        return (
            gradient[0] * x + gradient[1] * y + gradient[2] * z,
            gradient[3] * x + gradient[4] * y + gradient[5] * z,
            gradient[6] * x + gradient[7] * y + gradient[8] * z,
        )
    return gradient[0] * x + gradient[1] * y, gradient[3] * x + gradient[4] * y, 0.0


def move_to_image(block, lane, vectors, gradient, image, p):
    """Make the pair in a lane of a block (`geodem.kernels.blocks`) one with an image, and its motion that of it."""
    at = 4 * lane
    x, y, z = image_shift(vectors, image, p)
    x += block[at]
    y += block[at + 1]
    z += block[at + 2]
    block[at] = x
    block[at + 1] = y
    block[at + 2] = z
    u, v, w = affine(gradient, x, y, z)
    block[RELATIVE + at] += u
    block[RELATIVE + at + 1] += v
    block[RELATIVE + at + 2] += w


def add_moments(block, filled, moment):
    """Add force times branch of the filled lanes of a block."""
    xx = xy = xz = yx = yy = yz = zx = zy = zz = 0.0
    for lane in range(filled):
        at = 4 * lane
        x = block[at]
        y = block[at + 1]
        z = block[at + 2]
        fx = block[FORCE + at]
        fy = block[FORCE + at + 1]
        fz = block[FORCE + at + 2]
        xx += fx * x
        xy += fx * y
        xz += fx * z
        yx += fy * x
        yy += fy * y
        yz += fy * z
        zx += fz * x
        zy += fz * y
        zz += fz * z
    moment[0] += xx
    moment[1] += xy
    moment[2] += xz
    moment[3] += yx
    moment[4] += yy
    moment[5] += yz
    moment[6] += zx
    moment[7] += zy
    moment[8] += zz


def multiply_matrices(first, second, product):
    """product = first second, all (9,)."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += first[3 * i + k] * second[3 * k + j]
            product[3 * i + j] = total


def cell_volume(cell):
    """Volume of the cell [m3] (2D: area [m2])."""
    h = cell[CELL_VECTORS : CELL_VECTORS + 9]
    if not SPACE:
        return h[0] * h[4] - h[1] * h[3]
    return (
        h[0] * (h[4] * h[8] - h[5] * h[7])
        - h[1] * (h[3] * h[8] - h[5] * h[6])
        + h[2] * (h[3] * h[7] - h[4] * h[6])
    )


def control_cell(cell):
    """Rates of the components that answer to a stress, for the next motion."""
    space = 3 if SPACE else 2
    volume = cell_volume(cell)
    mean = 0.0
    for i in range(space):
        mean += cell[CELL_MOMENT + 4 * i] / (space * volume)
    for i in range(space):
        for j in range(i, space):
            there = 3 * i + j
            kind = cell[CELL_CONTROL + there]
            if kind == 0.0:
                continue
            felt = 0.5 * (cell[CELL_MOMENT + there] + cell[CELL_MOMENT + 3 * j + i]) / volume
            if kind == 2.0:
                felt = mean
            gain = cell[CELL_GAIN + there]
            if gain == 0.0:
                gain = cell[CELL_OWN_GAIN]
            limit = cell[CELL_LIMIT + there]
            rate = gain * (cell[CELL_TARGET + there] - felt)
            rate = min(max(rate, -limit), limit)
            cell[CELL_GRADIENT + there] = rate
            cell[CELL_GRADIENT + 3 * j + i] = rate


def move_cell(sums, cell, lapse, time_step):
    """One step of the cell, after the forces and the motion of the particles.

    sums (chunks, 26): of this step; cell (CELL_WIDTH,): changed; lapse [s]: since the forces before. Returns how fast
    the two particles of a near pair may come nearer to each other by the motion of the cell [m/s].
    """
    power = 0.0
    for k in range(9):
        total = 0.0
        for chunk in range(len(sums)):
            total += sums[chunk, CELL_SUMS + k]
        # the mean of the old and the new forces on the way of the last step
        power += 0.5 * (cell[CELL_MOMENT + k] + total) * cell[CELL_LAST + k]
        cell[CELL_MOMENT + k] = total
    cell[CELL_WORK] += power * lapse
    # what the particles have just done: x becomes M x
    motion = np.empty(9)
    square = 0.0
    for k in range(9):
        square += cell[CELL_GRADIENT + k] ** 2
        motion[k] = cell[CELL_GRADIENT + k] * time_step + (1.0 if k % 4 == 0 else 0.0)
    product = np.empty(9)
    multiply_matrices(motion, cell[CELL_DEFORMATION : CELL_DEFORMATION + 9], product)
    for k in range(9):
        cell[CELL_DEFORMATION + k] = product[k]
    for row in range(CELL_VECTORS, CELL_VECTORS + 9, 3):
        x = cell[row]
        y = cell[row + 1]
        z = cell[row + 2]
        cell[row] = motion[0] * x + motion[1] * y + motion[2] * z
        cell[row + 1] = motion[3] * x + motion[4] * y + motion[5] * z
        cell[row + 2] = motion[6] * x + motion[7] * y + motion[8] * z
    # M^-1 L turns where a pair is into the way it has come, over the step
    m = motion
    inverse = np.empty(9)
    inverse[0] = m[4] * m[8] - m[5] * m[7]
    inverse[1] = m[2] * m[7] - m[1] * m[8]
    inverse[2] = m[1] * m[5] - m[2] * m[4]
    inverse[3] = m[5] * m[6] - m[3] * m[8]
    inverse[4] = m[0] * m[8] - m[2] * m[6]
    inverse[5] = m[2] * m[3] - m[0] * m[5]
    inverse[6] = m[3] * m[7] - m[4] * m[6]
    inverse[7] = m[1] * m[6] - m[0] * m[7]
    inverse[8] = m[0] * m[4] - m[1] * m[3]
    size = m[0] * inverse[0] + m[1] * inverse[3] + m[2] * inverse[6]
    multiply_matrices(inverse, cell[CELL_GRADIENT : CELL_GRADIENT + 9], product)
    for k in range(9):
        cell[CELL_LAST + k] = product[k] / size
    control_cell(cell)
    return math.sqrt(square) * cell[CELL_REACH]


INLINED = (cell_matrix, image_shift, affine)
BLOCK_INLINED = (move_to_image, add_moments)
FUNCTIONS = (multiply_matrices, cell_volume, control_cell, move_cell)
"""Functions to compile, callees first."""
