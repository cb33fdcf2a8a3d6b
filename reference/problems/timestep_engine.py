"""Regular packings shaken by the particle engine just below and just above their critical step; run with `timestep`.

The spheres are joined by bonds so slender that they resist no bending: springs kn and ks, as in the table, and no more.
The packings are finite and free, so that their own critical step lies above that of the infinite ones, by a per cent at
most with the sizes taken here.
"""

from __future__ import annotations

import math
import time

import numpy as np

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation, UnstableError

from .regular_packings import CELLS, packing
from .rows import Row, at_most

SOURCE = (
    "full spectrum of lattice waves: sqrt(m/(z ks)) of discs, sqrt(1.2 m/(z ks)) of spheres, else kn alone"
)

SIDE = {"square": 14, "hexagonal": 9, "SC": 12, "BCC": 9, "FCC": 8, "HCP": 8}
"""Cells along every side."""
NOISE = 1e-6
"""Velocities and surface speeds at the start, over diameter/sqrt(m/kn)."""
BOUNDED = 20.0
"""Over the noise; at 0.98 of its critical step a mode swings to 5 times its speed."""
EXPLODED = 1e4
"""Over the noise."""


def shaken(kind: str, ratio: float, side: int | None = None) -> tuple[Assembly, float]:
    """Packing of diameter 1 with kn = 1e6 N/m and noise, and sqrt(m/kn) [s]."""
    dimension = len(CELLS[kind][0])
    found = packing(kind, side or SIDE[kind], periodic=False)
    stiffness, slender = 1e6, 1e-5
    section = slender if dimension == 2 else 0.25 * math.pi * slender**2
    builder = AssemblyBuilder(dimension, bond_law="parallel_bond")
    weak = dict.fromkeys(("normal_stiffness", "shear_stiffness"), 1e-6 * stiffness)
    bond = {
        "radius_factor": slender,
        "normal_stiffness": stiffness / section,
        # no stiffness at all is refused
        "shear_stiffness": max(ratio, 1e-9) * stiffness / section,
        "tensile_strength": math.inf,
        "shear_strength": math.inf,
    }
    builder.add_material("m", density=1000.0, contact={**weak, "friction_coefficient": 0.0}, bond=bond)
    mass = 1000.0 * (math.pi / 4.0 if dimension == 2 else math.pi / 6.0)
    unit = math.sqrt(mass / stiffness)
    rng = np.random.default_rng(27)
    count = len(found.positions)
    velocity = rng.uniform(-1.0, 1.0, (count, dimension)) * NOISE / unit
    spin = rng.uniform(-1.0, 1.0, (count, 1 if dimension == 2 else 3)) * 2.0 * NOISE / unit
    builder.add_particles(found.positions, 0.5, "m", velocity=velocity, spin=spin)
    builder.bond(found.pairs)
    return builder.build(), unit


def largest_speed(assembly: Assembly, step: float, steps: int, unit: float, limit: float) -> float:
    """Largest velocity or surface speed over the noise, of those after every 20 steps; inf where numbers end."""
    simulation = ParticleSimulation(assembly)
    # a step above the critical one is refused where it is asked for; here it is the point
    simulation.time_step = step
    largest = 0.0
    for _ in range(steps // 20):
        try:
            simulation.run(20)
        except UnstableError:
            return math.inf
        speed = max(float(np.abs(simulation.velocities).max()), 0.5 * float(np.abs(simulation.spins).max()))
        largest = max(largest, speed * unit / NOISE)
        if not largest < limit:
            break
    return largest


def by_engine(
    kind: str, ratio: float, expected: float, *, steps: int = 10_000, side: int | None = None
) -> list[Row]:
    """Bounded at 0.98 of the infinite packing's critical step, exploding at 1.02; what the engine measures and refuses.

    `expected` is that step over sqrt(m/kn).
    """
    started = time.perf_counter()
    assembly, unit = shaken(kind, ratio, side)
    name = f"P27 {kind} by the engine, ks/kn {ratio:g}"
    measured = ParticleSimulation(assembly).critical_time_step / unit
    try:
        ParticleSimulation(assembly, time_step=1.02 * expected * unit)
        refused = 0.0
    except InputError:
        refused = 1.0
    stays = largest_speed(assembly, 0.98 * expected * unit, steps, unit, 1e3 * EXPLODED)
    grows = largest_speed(assembly, 1.02 * expected * unit, steps, unit, EXPLODED)
    seconds = time.perf_counter() - started
    off = measured / expected - 1.0
    return [
        Row(name, "critical step measured [sqrt(m/kn)]", measured, expected, off, 0.01, seconds, SOURCE),
        Row(name, "1.02 of it is refused", refused, 1.0, 1.0 - refused, 0.0, seconds, SOURCE),
        at_most(name, f"0.98: largest over noise in {steps} steps, at most", stays, BOUNDED, seconds, SOURCE),
        at_most(name, "1.02: noise over largest, at most", 1.0 / grows, 1.0 / EXPLODED, seconds, SOURCE),
    ]
