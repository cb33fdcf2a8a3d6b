"""Pushes overlapping discs or spheres apart, in a periodic box or between its walls.

Soft particles (energy: half the square of every overlap) slide down to a state without overlap, or to the least
energy where they are jammed. Minimiser: FIRE, Bitzek et al. (2006), Phys. Rev. Lett. 97:170201.
Every particle adds up its own neighbours in one order, and blocks of particles are added up in one order, so no bit
depends on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem import _jit

prange = range

Floats = NDArray[np.float64]

# Set by the module that the kernels are compiled in.
DIMENSION = 3
PERIODIC = True
BLOCK = 512

LEVEL_RATIO = 2.0
"""Largest over smallest radius in one grid of cells."""
BUFFER = 0.3
"""Pairs are listed up to this much more than touching, over the mean radius."""
# FIRE as published; the step is limited by the stiffest particle, with about 12 contacts of stiffness 1
GROW, SHRINK, MIX, UNMIX, PATIENCE = 1.1, 0.5, 0.1, 0.99, 5
FIRST_STEP, LARGEST_STEP = 0.1, 0.35
LARGEST_MOVE = 0.1
"""Largest move of a particle in one step, over the smallest radius."""
BALANCED = 1e-3
"""Unbalanced over contact force (root mean squares) at which particles are jammed."""


def separation(a, b, box):
    """Component of the vector from a to b, through the nearest face of a periodic box."""
    step = b - a
    if PERIODIC:
        step = step - box if step > 0.5 * box else (step + box if step < -0.5 * box else step)
    return step


def overlaps(
    position, radius, box, row, other, force, block_power, block_force, block_speed, block_contact, block_depth,
    velocity, mass,
):  # fmt: skip
    """Forces (n, d) on all particles, and sums over each block: F.v, F.F/m, m v.v, contact forces, largest overlap."""
    particles = len(radius)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        power = 0.0
        squared = 0.0
        speed = 0.0
        contact = 0.0
        depth = 0.0
        for i in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            fx = 0.0
            fy = 0.0
            fz = 0.0
            for index in range(row[i], row[i + 1]):
                j = other[index]
                dx = separation(position[i, 0], position[j, 0], box[0])
                dy = separation(position[i, 1], position[j, 1], box[1])
                square = dx * dx + dy * dy
                if DIMENSION == 3:
                    dz = separation(position[i, 2], position[j, 2], box[2])
                    square += dz * dz
                touch = radius[i] + radius[j]
                if square < touch * touch:
                    distance = np.sqrt(square)
                    overlap = touch - distance
                    push = -overlap / distance if distance > 0.0 else 0.0
                    fx += push * dx
                    fy += push * dy
                    if DIMENSION == 3:
                        fz += push * dz
                    contact += overlap * overlap
                    depth = max(depth, overlap / min(radius[i], radius[j]))
            if not PERIODIC:
                for axis in range(DIMENSION):
                    low = radius[i] - position[i, axis]
                    high = position[i, axis] + radius[i] - box[axis]
                    push = max(low, 0.0) - max(high, 0.0)
                    contact += push * push
                    depth = max(depth, max(low, high) / radius[i])
                    if axis == 0:
                        fx += push
                    elif axis == 1:
                        fy += push
                    else:
                        fz += push
            force[i, 0] = fx
            force[i, 1] = fy
            power += fx * velocity[i, 0] + fy * velocity[i, 1]
            squared += (fx * fx + fy * fy) / mass[i]
            speed += mass[i] * (velocity[i, 0] ** 2 + velocity[i, 1] ** 2)
            if DIMENSION == 3:
                force[i, 2] = fz
                power += fz * velocity[i, 2]
                squared += fz * fz / mass[i]
                speed += mass[i] * velocity[i, 2] ** 2
        block_power[block] = power
        block_force[block] = squared
        block_speed[block] = speed
        block_contact[block] = contact
        block_depth[block] = depth


def move(position, velocity, force, mass, keep, turn, step, most, start, block_moved):
    """One step: v = keep v + turn F/m + step F/m, x = x + step v; largest distance from `start` in each block."""
    particles = len(mass)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        farthest = 0.0
        for i in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            square = 0.0
            for axis in range(DIMENSION):
                v = keep * velocity[i, axis] + (turn + step) * force[i, axis] / mass[i]
                velocity[i, axis] = v
                advance = min(max(step * v, -most), most)
                position[i, axis] += advance
                gone = position[i, axis] - start[i, axis]
                square += gone * gone
            farthest = max(farthest, square)
        block_moved[block] = farthest


def relax(
    position, velocity, radius, mass, box, row, other, buffer, most, steps, tolerance, state, start, force, sums,
):  # fmt: skip
    """FIRE until a particle has left the list's buffer, the overlap is small, forces are balanced or steps are out.

    state: step size, mixing, downhill steps so far, largest overlap over the smaller radius, unbalanced ratio.
    Returns the number of steps.
    """
    done = 0
    moved = 0.0
    while True:
        overlaps(
            position,
            radius,
            box,
            row,
            other,
            force,
            sums[0],
            sums[1],
            sums[2],
            sums[3],
            sums[4],
            velocity,
            mass,
        )
        power = 0.0
        squared = 0.0
        speed = 0.0
        contact = 0.0
        depth = 0.0
        for block in range(sums.shape[1]):
            power += sums[0, block]
            squared += sums[1, block]
            speed += sums[2, block]
            contact += sums[3, block]
            depth = max(depth, sums[4, block])
        state[3] = depth
        state[4] = np.sqrt(squared / contact) if contact > 0.0 else 0.0
        if done == steps or depth <= tolerance or state[4] <= BALANCED or 2.0 * moved > buffer:
            break
        if power > 0.0:
            keep = 1.0 - state[1]
            turn = state[1] * np.sqrt(speed / squared)
            state[2] += 1.0
            if state[2] > PATIENCE:
                state[0] = min(state[0] * GROW, LARGEST_STEP)
                state[1] *= UNMIX
        else:
            keep = 0.0
            turn = 0.0
            if speed > 0.0:
                state[0] *= SHRINK
            state[0] = max(state[0], 0.02 * LARGEST_STEP)
            state[1] = MIX
            state[2] = 0.0
        move(position, velocity, force, mass, keep, turn, state[0], most, start, sums[5])
        square = 0.0
        for block in range(sums.shape[1]):
            square = max(square, sums[5, block])
        moved = np.sqrt(square)
        done += 1
    return done


def fill_cells(position, level, box, shape, first, start, order):
    """Particles cell by cell, level by level: start (cells + 1,), order (n,), overwritten."""
    cell = np.empty(len(level), dtype=np.int64)
    start[:] = 0
    for i in range(len(level)):
        place = 0
        for axis in range(DIMENSION - 1, -1, -1):
            count = shape[level[i], axis]
            index = int(np.floor(position[i, axis] / box[axis] * count))
            place = place * count + min(max(index, 0), count - 1)
        cell[i] = first[level[i]] + place
        start[cell[i] + 1] += 1
    for index in range(1, len(start)):
        start[index] += start[index - 1]
    filled = start[:-1].copy()
    for i in range(len(level)):
        order[filled[cell[i]]] = i
        filled[cell[i]] += 1


def list_neighbours(position, radius, box, largest, shape, first, start, order, buffer, row, other, counting):
    """Neighbours of every particle; counting: only how many, row[i + 1]."""
    particles = len(radius)
    levels = len(largest)
    for block in prange((particles + BLOCK - 1) // BLOCK):
        low = np.zeros(3, dtype=np.int64)
        number = np.ones(3, dtype=np.int64)
        for i in range(block * BLOCK, min(particles, block * BLOCK + BLOCK)):
            found = 0 if counting else row[i]
            for level in range(levels):
                reach = radius[i] + largest[level] + buffer
                for axis in range(DIMENSION):
                    count = shape[level, axis]
                    inverse = count / box[axis]
                    low[axis] = int(np.floor((position[i, axis] - reach) * inverse))
                    high = int(np.floor((position[i, axis] + reach) * inverse))
                    if not PERIODIC:
                        # who has left the box stands in its last cells
                        low[axis] = min(max(low[axis], 0), count - 1)
                        high = min(max(high, 0), count - 1)
                    number[axis] = min(high - low[axis] + 1, count)
                for nz in range(number[2]):
                    z = (low[2] + nz) % shape[level, 2]
                    for ny in range(number[1]):
                        y = (low[1] + ny) % shape[level, 1]
                        for nx in range(number[0]):
                            x = (low[0] + nx) % shape[level, 0]
                            cell = first[level] + (z * shape[level, 1] + y) * shape[level, 0] + x
                            for index in range(start[cell], start[cell + 1]):
                                j = order[index]
                                square = 0.0
                                for axis in range(DIMENSION):
                                    step = separation(position[i, axis], position[j, axis], box[axis])
                                    square += step * step
                                near = radius[i] + radius[j] + buffer
                                if square < near * near and i != j:
                                    if not counting:
                                        other[found] = j
                                    found += 1
            if counting:
                row[i + 1] = found


@dataclass(frozen=True)
class Separated:
    """Particles after their overlaps were removed.

    Attributes
    ----------
    positions : (n, d) [m]
    largest_overlap : float
        Over the smaller radius [-].
    unbalanced : float
        Unbalanced over contact force [-]: small where the particles are jammed.
    steps : int
    """

    positions: Floats
    largest_overlap: float
    unbalanced: float
    steps: int


def remove_overlaps(
    positions: Floats,
    radii: Floats,
    box: Floats,
    *,
    periodic: bool,
    tolerance: float,
    most_steps: int,
) -> Separated:
    """Move particles until none overlaps by more than `tolerance` times the smaller radius.

    Parameters
    ----------
    positions : (n, d) [m]
        In the box, from 0 to its sides.
    radii : (n,) [m]
    box : (d,) [m]
        Periodic: each side at least 4 times the largest radius and two buffers.
    periodic : bool
        False: walls at the box's sides push particles inwards.
    tolerance : float
        [-]
    most_steps : int
        Where particles are jammed or slow, an overlap is left; 0 only measures it.
    """
    kernel = _kernel(positions.shape[1], periodic)
    position = np.array(positions, dtype=np.float64)
    particles, dimension = position.shape
    buffer = BUFFER * float(radii.mean())
    level = np.floor(np.log(radii.max() / radii) / np.log(LEVEL_RATIO)).astype(np.int64)
    level = np.unique(level, return_inverse=True)[1].astype(np.int64)
    largest = np.array([radii[level == number].max() for number in range(level.max() + 1)])
    shape = np.ones((len(largest), 3), dtype=np.int64)
    for number, bound in enumerate(largest):
        # no finer than one particle to a cell
        share = np.count_nonzero(level == number)
        side = max(2.0 * bound + buffer, float((np.prod(box) / share) ** (1.0 / dimension)))
        shape[number, :dimension] = np.maximum(np.floor(box / side), 1.0)
    first = np.concatenate([[0], np.cumsum(shape.prod(axis=1))])
    start = np.empty(first[-1] + 1, dtype=np.int64)
    order = np.empty(particles, dtype=np.int32)
    row = np.zeros(particles + 1, dtype=np.int64)
    # a large particle touches more small ones: as much heavier as it is stiffer
    mass = (0.5 * (1.0 + radii / radii.min())) ** (dimension - 1)
    velocity = np.zeros_like(position)
    force = np.empty_like(position)
    sums = np.empty((6, (particles + BLOCK - 1) // BLOCK))
    state = np.array([FIRST_STEP, MIX, 0.0, np.inf, np.inf])
    none = np.empty(0, dtype=np.int32)
    done = 0
    while True:
        if periodic:
            position -= box * np.floor(position / box)
        kernel.fill_cells(position, level, box, shape, first, start, order)
        grid = (position, radii, box, largest, shape, first, start, order, buffer)
        row[0] = 0
        kernel.list_neighbours(*grid, row, none, True)
        np.cumsum(row, out=row)
        other = np.empty(int(row[-1]), dtype=np.int32)
        kernel.list_neighbours(*grid, row, other, False)
        steps = kernel.relax(
            position, velocity, radii, mass, box, row, other, buffer, LARGEST_MOVE * float(radii.min()),
            most_steps - done, tolerance, state, position.copy(), force, sums,
        )  # fmt: skip
        done += steps
        if done >= most_steps or state[3] <= tolerance or state[4] <= BALANCED:
            break
    if periodic:
        position -= box * np.floor(position / box)
    return Separated(position, float(state[3]), float(state[4]), done)


@cache
def _kernel(dimension: int, periodic: bool) -> ModuleType:
    constants = {
        "DIMENSION": dimension, "PERIODIC": periodic, "BLOCK": BLOCK, "BALANCED": BALANCED, "GROW": GROW,
        "SHRINK": SHRINK, "MIX": MIX, "UNMIX": UNMIX, "PATIENCE": PATIENCE, "LARGEST_STEP": LARGEST_STEP,
    }  # fmt: skip
    functions: list[Callable[..., Any]] = [separation, overlaps, move, relax, fill_cells, list_neighbours]
    return _jit.compile_kernel(functions, constants, parallel=True)
