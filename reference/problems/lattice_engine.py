"""Lattice of bonded discs strained by the particle engine, against the closed forms of `lattice`; run with it."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .rows import Row, relative

Floats = NDArray[np.float64]

SOURCE = (
    "closed form of the triangular lattice: E = 2 sqrt3 kn (kn + ks)/(3 kn + ks), nu = (kn - ks)/(3 kn + ks)"
)
HEIGHT = math.sqrt(0.75)
"""Of a layer, over the diameter."""
STIFFNESS = 1e6  # kn [N/m]
STRAIN = 1e-4
"""Small enough for the closed form, which knows no change of shape."""
STEPS = 2000
"""In which the plates come together; a search for equilibrium forgets the slip of the last one."""
TOLERANCE = 1e-7


def _sample(ratio: float, positions: Floats, speed: float) -> tuple[AssemblyBuilder, NDArray[np.int64]]:
    """Discs of diameter 1, the lowest layer on a plate, the highest driven down; and the pairs that are bonded."""
    slender = 1e-6
    builder = AssemblyBuilder(2, bond_law="parallel_bond")
    weak = {
        "normal_stiffness": 1e-9 * STIFFNESS,
        "shear_stiffness": 1e-9 * STIFFNESS,
        "friction_coefficient": 0.0,
    }
    # the section of a bond between discs is its width, twice slender times the radius; so slender, it does not bend
    bond = {
        "radius_factor": slender,
        "normal_stiffness": STIFFNESS / slender,
        "shear_stiffness": ratio * STIFFNESS / slender,
        "tensile_strength": math.inf,
        "shear_strength": math.inf,
    }
    builder.add_material("disc", density=1.0, contact=weak, bond=bond)
    builder.add_particles(positions, 0.5, "disc")
    pairs = builder.bond_within(1.01)
    height = positions[:, 1]
    builder.hold(np.flatnonzero(height < 0.1), y=0.0)
    builder.hold([0], x=0.0)
    builder.hold(np.flatnonzero(height > height.max() - 0.1), y=-speed)
    return builder, pairs


def strained(ratio: float, wide: int = 30, layers: int = 60) -> list[Row]:
    """Discs between plates that slide freely and come together, then equilibrium: E and nu of the inner third."""
    started = time.perf_counter()
    layer, place = np.divmod(np.arange(wide * layers), wide)
    positions = np.stack([place + 0.5 * (layer % 2), HEIGHT * layer], axis=1)
    young = 2.0 * math.sqrt(3.0) * STIFFNESS * (1.0 + ratio) / (3.0 + ratio)
    poisson = (1.0 - ratio) / (3.0 + ratio)
    step = ParticleSimulation(_sample(ratio, positions, 0.0)[0].build()).time_step
    shortened = STRAIN * HEIGHT * (layers - 1)
    builder, pairs = _sample(ratio, positions, shortened / (STEPS * step))
    simulation = ParticleSimulation(builder.build(), time_step=step)
    simulation.run(STEPS)
    found = find_equilibrium(simulation, tolerance=TOLERANCE)
    moved = simulation.positions - positions
    inner = (
        (layer >= layers // 3) & (layer < 2 * layers // 3) & (place >= wide // 3) & (place < 2 * wide // 3)
    )
    gradient = np.linalg.lstsq(
        np.column_stack([positions[inner], np.ones(inner.sum())]), moved[inner], rcond=None
    )[0]
    felt = float(_vertical_stress(simulation, pairs, positions)[inner].mean())
    vertical, sideways = float(gradient[1, 1]), float(gradient[0, 0])
    # on the width between the outermost centres; the height is one between centres too
    plate = float(simulation.forces[layer == layers - 1, 1].sum()) / (wide - 0.5)
    seconds = time.perf_counter() - started
    name = f"P20 {wide} x {layers} discs by the engine, ks/kn {ratio:g}"
    return [
        relative(name, "E, stress inside over strain inside", felt / vertical, young, 0.01, seconds, SOURCE),
        relative(name, "E, stress of the plates over their strain", plate / STRAIN, young, 0.01, seconds, SOURCE),
        Row(
            name, "nu, difference over 1 where it is 0", -sideways / vertical, poisson,
            (-sideways / vertical - poisson) / (poisson or 1.0), 0.01, seconds, SOURCE,
        ),
        Row(name, "unbalanced ratio", found.unbalanced_ratio, 0.0, found.unbalanced_ratio, TOLERANCE, seconds, ""),
    ]  # fmt: skip


def _vertical_stress(simulation: ParticleSimulation, pairs: NDArray[np.int64], positions: Floats) -> Floats:
    """Stress of every disc along y [Pa]: half of force times branch of all its bonds, over its hexagon."""
    contacts = simulation.contacts()
    order = {tuple(pair): k for k, pair in enumerate(contacts.pairs.tolist())}
    chosen = np.array([order[tuple(pair)] for pair in pairs.tolist()])
    first, second = pairs.T
    branch = simulation.positions[second] - simulation.positions[first]
    distance = np.linalg.norm(branch, axis=1)
    normal = branch / distance[:, None]
    was = np.linalg.norm(positions[second] - positions[first], axis=1)
    # of the bond on the first disc: pressed apart, and along t = (-ny, nx)
    press = STIFFNESS * (was - distance)
    shear = contacts.history["bond.shear_x"][chosen]
    force = -press * normal[:, 1] + shear * normal[:, 0]
    share = 0.5 * force * branch[:, 1] / HEIGHT
    stress = np.zeros(len(positions))
    np.add.at(stress, first, share)
    np.add.at(stress, second, share)
    return stress


def run() -> list[Row]:
    """Three ratios of stiffness."""
    return [row for ratio in (0.25, 0.5, 1.0) for row in strained(ratio)]
