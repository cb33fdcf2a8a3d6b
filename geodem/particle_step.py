"""The critical time step of a particle simulation, from its links and dashpots as they are now."""

from __future__ import annotations

import math
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .integrators.critical_step import critical_step, largest_frequency, largest_frequency_of_products
from .integrators.link_stiffness import law_damping, law_stiffness
from .integrators.network import RIGID, Links, Springs, build_network, stiffness_matrix
from .kernels.link_products import link_product
from .particle_network import current_links, current_springs

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

MATRIX_LIMIT = 20_000
"""Up to this many particles the largest frequency is that of a matrix; beyond, no matrix is made."""

LARGE = 1e15
"""Radius and mass of a wall over those of a particle."""


def critical_time_step(s: ParticleSimulation, *, local_damping: float) -> float:
    """The longest stable step [s], measured on the links as they are now; inf without any stiffness.

    Every listed pair counts as touching, and every free particle may meet one more wall or equal particle.
    """
    found = current_links(s)
    mass = s.assembly.mass[s.arrays.ids]
    inertia = s.assembly.inertia[s.arrays.ids]
    held = s.assembly.held[s.arrays.ids]
    frequency = math.sqrt(max(_alone(s, mass, inertia, held), 0.0))
    # viscosity in the form eta k v: damping ratio eta omega/2
    viscosity = _viscosity(s)
    rate = 0.0
    if len(found.first) or s.assembly.anchors is not None:
        inertias = np.column_stack([mass] * s.dimension + [inertia] * s.assembly.rotations)
        frequency = max(frequency, _largest(s, found, current_springs(s), inertias, held))
        dashpots = _dashpots(s, found)
        if dashpots.kn.any() or dashpots.ks.any():
            # no mode is damped at a higher rate than the fastest of the dashpots alone
            rate = _largest(s, dashpots, None, inertias, held) ** 2
    ratio = 0.5 * viscosity * frequency + (0.5 * rate / frequency if rate > 0.0 else 0.0)
    return critical_step(frequency, viscous=ratio, local=local_damping)


def _largest(
    s: ParticleSimulation, found: Links, springs: Springs | None, inertias: Floats, held: NDArray[np.bool_]
) -> float:
    """Largest frequency [rad/s] of links and springs; of dashpots, the root of the largest rate."""
    if len(inertias) <= MATRIX_LIMIT:
        positions = np.ascontiguousarray(s.now[:, s.columns.position])
        matrix = stiffness_matrix(build_network(positions, found, springs))
        return largest_frequency(matrix, inertias, held)
    return largest_frequency_of_products(lambda moved: link_product(found, springs, moved), inertias, held)


def _dashpots(s: ParticleSimulation, found: Links) -> Links:
    """Links with the dashpots of contacts [N s/m] that come from a restitution or a damping, in place of springs.

    Viscosities, which are proportional to the springs, are `_viscosity`'s.
    """
    contact, bond = s.features.laws()
    nothing = np.zeros(len(found.first))
    if not _damps(contact, s):
        return found._replace(kn=nothing, ks=nothing)
    inner = found.second != RIGID
    a, b = found.first, np.where(inner, found.second, found.first)
    columns, materials, walls = s.columns, len(s.assembly.material_names), len(s.walls.bodies)
    material = s.now[:, columns.material].astype(np.int64)
    radius, mass = s.now[:, columns.radius], s.now[:, columns.mass]
    body = np.zeros(len(a), dtype=np.int64)
    body[~inner] = s.walls.body[s.wall_pairs.primitive]
    damping = np.zeros((len(a), 4))
    acts = np.ones(len(a), dtype=bool)
    acts[: len(s.pairs.a)] = (s.pairs.bond == 0) if bond is not None and bond.REPLACES_CONTACT else True
    if s.layout.place is not None:
        acts[: len(s.pairs.a)] &= s.pairs.history[:, s.layout.place] == 0.0
    distance = found.arms.sum(axis=1)
    for own, table, row, large in (
        (inner, s.table, material[a] * materials + material[b], 1.0),
        (~inner, s.wall_parameters, material[a] * walls + body, LARGE),
    ):
        which = np.flatnonzero(own & acts)
        if len(which):
            first, second = a[which], b[which]
            damping[which] = law_damping(
                contact, s.dimension, table[row[which]],
                radius_a=radius[first], radius_b=large * radius[second], distance=distance[which],
                overlap=radius[first] + np.where(inner[which], radius[second], 0.0) - distance[which],
                mass_a=mass[first], mass_b=large * mass[second],
            )  # fmt: skip
    return found._replace(
        kn=damping[:, 0], ks=damping[:, 1] if s.features.shear else nothing, k_twist=nothing, k_bend=nothing
    )


def _alone(s: ParticleSimulation, mass: Floats, inertia: Floats, held: NDArray[np.bool_]) -> float:
    """Largest squared frequency of one contact of a particle that touches nothing yet: with a rigid wall."""
    free = ~held.all(axis=1)
    if not free.any():
        return 0.0
    radius = s.now[:, s.columns.radius]
    contact, _ = s.features.laws()
    # two equal particles: the reduced mass is half
    rows = [(row, 2.0) for row in s.table] + [
        (row, 1.0) for row in (s.wall_parameters if s.assembly.walls else [])
    ]
    largest = 0.0
    lightest = np.flatnonzero(free)[np.argmin(mass[free])]
    for row, factor in rows:
        r = np.array([radius[lightest]])
        m = np.array([mass[lightest]])
        k = law_stiffness(
            contact, s.dimension, row[None], radius_a=r, radius_b=r, distance=2 * r, overlap=0.0 * r,
            mass_a=m, mass_b=m if factor == 2.0 else 1e15 * m,
        )[0]  # fmt: skip
        largest = max(largest, factor * k[0] / mass[lightest])
        if s.features.shear:
            turning = 0.0 if held[lightest, s.dimension :].all() else r[0] ** 2 / inertia[lightest]
            largest = max(largest, factor * k[1] * (1.0 / mass[lightest] + turning))
    return largest


def _viscosity(s: ParticleSimulation) -> float:
    contact, bond = s.features.laws()
    largest = 0.0
    tables = [(contact, s.table)] + ([(contact, s.wall_parameters)] if s.assembly.walls else [])
    if bond is not None:
        tables.append((bond, s.bond_table))
    for law, table in tables:
        for k, name in enumerate(law.PARAMETERS._fields):
            if name.endswith("_viscosity"):
                largest = max(largest, float(table[:, k].max()))
    return largest


def _damps(contact: ModuleType, s: ParticleSimulation) -> bool:
    """Some contact has a restitution below one, or a damping."""
    tables = [s.table, *([s.wall_parameters] if s.assembly.walls else [])]
    for k, name in enumerate(contact.PARAMETERS._fields):
        values = np.concatenate([table[:, k] for table in tables])
        if (name == "restitution" and (values < 1.0).any()) or (name.endswith("_damping") and values.any()):
            return True
    return False
