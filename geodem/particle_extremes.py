"""How deep contacts are pressed, how far away is far, how much energy there is: what `particle_guard` compares with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .integrators.link_stiffness import law_stiffness
from .kernels import motion
from .laws.protocol import argument_names, in_dimension

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]
Depths = tuple[NDArray[np.int64], NDArray[np.int64], Floats]

FAR = 1000.0
"""The box that nothing is to leave reaches so many times the largest extent of the scene beyond it on every side."""

LEAST_EXTENT = 100.0
"""Of the scene, over the largest radius: a single particle has room too."""

RIGID = 1e15
"""Radius and mass of a wall over those of a particle."""


def far_box(s: ParticleSimulation) -> tuple[Floats, Floats]:
    """Corners (d,) [m] of a box far around all particles and bounded walls as they were at the start."""
    d, a = s.dimension, s.assembly
    points = [a.positions - a.radii[:, None], a.positions + a.radii[:, None]]
    for wall in a.walls:
        points += [np.reshape(part, (-1, d)) for part in (wall.segments, wall.triangles) if np.size(part)]
    cloud = np.concatenate(points)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    reach = FAR * max(float((high - low).max()), LEAST_EXTENT * float(a.radii.max()))
    return low - reach, high + reach


def slowest_contact(s: ParticleSimulation) -> float:
    """sqrt(m/k) of the heaviest particle and the softest contact [s]: times a speed, how deep that presses it.

    Contacts are those of two particles as small as the smallest, pressed by half their radius.
    """
    contact, _ = s.features.laws()
    radius = np.array([float(s.assembly.radii.min())])
    mass = np.array([float(s.assembly.mass.min())])
    softest = math.inf
    for table, other in ((s.table, 1.0), (s.wall_parameters if s.assembly.walls else s.table[:0], RIGID)):
        for row in table:
            stiffness = law_stiffness(
                contact, s.dimension, row[None], radius_a=radius, radius_b=other * radius, distance=radius,
                overlap=0.5 * radius, mass_a=mass, mass_b=other * mass,
            )  # fmt: skip
            softest = min(softest, float(stiffness[0, 0]))
    return math.sqrt(float(s.assembly.mass.max()) / softest) if softest > 0.0 else math.inf


def overlaps_of_strangers(s: ParticleSimulation) -> Depths:
    """Rows of pairs that touch and are neither bonded nor across a joint, and their overlap over the smaller radius."""
    p = s.pairs
    chosen = (p.touching > 0) & (p.bond == 0)
    if s.layout.place is not None:
        chosen &= p.history[:, s.layout.place] == 0.0
    which = np.flatnonzero(chosen)
    a, b = p.a[which].astype(np.int64), p.b[which].astype(np.int64)
    apart = s._branches(which)
    radii = s.now[:, s.columns.radius]
    overlap = radii[a] + radii[b] - np.sqrt((apart**2).sum(axis=1))
    return a, b, overlap / np.minimum(radii[a], radii[b])


def overlaps_with_walls(s: ParticleSimulation) -> Depths:
    """Rows of particles that touch a wall, the wall's number, and the overlap over the radius."""
    w = s.wall_pairs
    which = np.flatnonzero(w.touching > 0)
    rows = w.particle[which].astype(np.int64)
    depth = 1.0 - w.geometry[which, 3] / s.now[rows, s.columns.radius]
    return rows, s.walls.body[w.primitive[which]].astype(np.int64), depth


def stored_energy(s: ParticleSimulation) -> float:
    """Elastic energy [J] of contacts, bonds and anchors.

    That of contacts with walls is not known one by one: it is taken to be what all contact forces together would
    store in the softest contact, which is more.
    """
    p, columns = s.pairs, s.columns
    which = np.flatnonzero((p.touching > 0) | (p.bond > 0))
    a, b = s.now[p.a[which]], s.now[p.b[which]]
    apart = s._branches(which)
    distance = np.sqrt((apart**2).sum(axis=1))
    history = p.history[which]
    overlap = a[:, columns.radius] + b[:, columns.radius] - distance
    contact, bond = s.features.laws()
    known = {
        "overlap": overlap, "radius_a": a[:, columns.radius], "radius_b": b[:, columns.radius],
        "distance": distance, "mass_a": a[:, columns.mass], "mass_b": b[:, columns.mass],
        "scale": s.bond_scale[np.maximum(p.bond[which].astype(np.int64) - 1, 0)],
    }  # fmt: skip
    row = (a[:, columns.material] * len(s.assembly.material_names) + b[:, columns.material]).astype(int)
    bonded = p.bond[which] > 0
    pressed = (p.touching[which] > 0) & ((overlap > 0.0) | hasattr(contact, "reach"))
    total = 0.0
    if bond is not None and s.layout.offset is not None:
        first = len(s.layout.contact)
        own = {**known, "overlap": overlap + history[:, s.layout.offset]}
        own |= {name: history[:, first + k] for k, name in enumerate(s.layout.bond)}
        total += _sum_of_energies(bond, s.dimension, s.bond_table[row], own, bonded)
        if bond.REPLACES_CONTACT:
            pressed &= ~bonded
    own = known | {name: history[:, k] for k, name in enumerate(s.layout.contact)}
    total += _sum_of_energies(contact, s.dimension, s.table[row], own, pressed)
    if s.assembly.anchors is not None:
        anchors = s.assembly.anchors
        length = np.sqrt(((s.positions[anchors.particle] - anchors.point) ** 2).sum(axis=1))
        total += 0.5 * float((anchors.stiffness * (length - anchors.length) ** 2).sum())
    if s.assembly.walls:
        total += (
            0.5
            * (float(s.sums[:, motion.THRUST].sum()) * slowest_contact(s)) ** 2
            / float(s.assembly.mass.max())
        )
    return total


def _sum_of_energies(
    law: ModuleType, dimension: int, parameters: Floats, known: Mapping[str, Floats], which: NDArray[np.bool_]
) -> float:
    columns = {**dict(zip(law.PARAMETERS._fields, parameters.T, strict=True)), **known}
    nothing = np.zeros(len(which))
    wanted = [columns.get(name, nothing)[which].tolist() for name in argument_names(law.energy)]
    function = in_dimension(law.energy, dimension)
    return math.fsum(function(*values) for values in zip(*wanted, strict=True))


def rounding(before: ParticleSimulation, s: ParticleSimulation) -> float:
    """Kinetic energy that rounded places can have made since `before` [J].

    A place is rounded by its size times 2^-53 in every step, which springs turn into speeds of that over a step; from
    step to step these energies add up.
    """
    size = float(np.abs(s.positions).max())
    jump = size * float(np.finfo(float).eps) / s.time_step
    return float(s.assembly.mass.sum()) * (s.steps - before.steps) * jump**2


def supplied(before: ParticleSimulation, s: ParticleSimulation) -> float:
    """Sizes of the work of loads, walls and the cell since `before` [J]; more than they add up to."""
    d, a = s.dimension, s.assembly
    ways = s.positions - before.positions
    work = float(np.abs(a.mass[:, None] * a.gravity * ways).sum())
    if s.features.applied:
        turned = s.orientations - before.orientations if s.features.orientation and d == 2 else None
        for each in (before, s):
            applied = np.empty_like(each.arrays.applied)
            applied[each.arrays.ids] = each.arrays.applied
            work += float(np.abs(applied[:, :d] * ways).sum())
            if turned is not None:
                work += float(np.abs(applied[:, d:] * turned).sum())
            else:
                spin = np.abs(each.spins) * (s.time - before.time)
                work += float(np.abs(applied[:, d:] * spin).sum())
    if a.walls:
        work += float(np.abs(s.walls.work() - before.walls.work()).sum())
    if s.cell is not None and before.cell is not None:
        work += abs(s.cell.work - before.cell.work)
    return work
