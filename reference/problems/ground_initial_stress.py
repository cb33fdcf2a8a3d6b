"""Initial stress of bonded ground: a far-field tensor, and weight with K0, in 2D and 3D."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation.initial_stress import (
    InitialStress,
    WantedStress,
    bulk_unit_weight,
    far_field,
    ground_stress,
    set_initial_stress,
)

from .rows import Row, at_most

Floats = NDArray[np.float64]

BOXES = {2: (40.0, 30.0), 3: (12.0, 12.0, 10.0)}
"""In diameters, about."""
TENSORS = {
    2: np.array([[-2.0, 0.5], [0.5, -1.0]]),
    3: np.array([[-2.0, 0.5, 0.1], [0.5, -1.0, 0.0], [0.1, 0.0, -1.5]]),
}
"""[MPa]"""
K0 = 1.5


def ground(dimension: int, box: tuple[float, ...], *, weight: bool) -> ParticleSimulation:
    """A box of bonded particles, held around but for the top where it has weight."""
    packing = random_packing(dimension, radius=0.5, size_ratio=1.66, box=box, periodic=False, seed=1)
    positions = packing.positions
    gravity = (0.0,) * (dimension - 1) + (-9.81 if weight else 0.0,)
    build = AssemblyBuilder(dimension, "effective_modulus", "rock", gravity=gravity)
    contact = {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
    bond = {
        "effective_modulus": 1e9, "stiffness_ratio": 2.0, "tensile_strength": 2e7, "shear_strength": 2e7,
        "friction_coefficient": 0.5,
    }  # fmt: skip
    build.add_material("rock", density=2600.0, contact=contact, bond=bond)
    build.add_particles(positions, packing.radii, "rock")
    build.bond_within(1.08)
    low, high = positions.min(axis=0) + 1.0, positions.max(axis=0) - 1.0
    sides = slice(0, dimension - 1 if weight else dimension)
    outer = (positions < low).any(axis=1) | (positions[:, sides] > high[sides]).any(axis=1)
    still = {"x": 0.0, "y": 0.0, "rotation": 0.0, **({"z": 0.0} if dimension == 3 else {})}
    build.hold(np.flatnonzero(outer), **still)
    return ParticleSimulation(build.build())


def rows_of(name: str, simulation: ParticleSimulation, wanted: WantedStress, source: str) -> list[Row]:
    """Rows of one state: deviation, breaks, utilisation."""
    begun = time.perf_counter()
    found: InitialStress = set_initial_stress(simulation, wanted)
    seconds = time.perf_counter() - begun
    broken = int((~simulation.intact()).sum())
    return [
        at_most(name, "farthest component off, over the largest wanted", found.error, 0.01, seconds, source),
        Row(name, "bonds broken", broken, 0.0, broken, 0.0, 0.0, "none may"),
        at_most(name, "largest utilisation of a bond", found.most_utilised, 1.0, 0.0, "none may break"),
    ]


def initial_stress(dimension: int) -> list[Row]:
    """Far field and K0 ground of one dimension."""
    box = BOXES[dimension]
    far = rows_of(
        f"far field {dimension}D",
        ground(dimension, box, weight=False),
        far_field(1e6 * TENSORS[dimension]),
        "given",
    )
    heavy = ground(dimension, box, weight=True)
    top = float((heavy.positions[:, -1] + heavy.assembly.radii).max())
    wanted = ground_stress(dimension, unit_weight=bulk_unit_weight(heavy), k0=K0, top=top)
    return [*far, *rows_of(f"K0 ground {dimension}D", heavy, wanted, "gamma z, K0 gamma z")]


def run() -> list[Row]:
    """In 2D and 3D."""
    return [*initial_stress(2), *initial_stress(3)]
