"""The same bits on 1, 2 and 4 threads: bonds that break, walls, friction, searches and sorts of rows."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import hashlib, sys
import numpy as np
from geodem.boundaries.walls import box
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation

dimension = int(sys.argv[1])
law, kind, cells = ("two_springs", "hexagonal", (40, 15)) if dimension == 2 else ("parallel_bond", "fcc", (5, 5, 6))
builder = AssemblyBuilder(dimension, bond_law=law, gravity=(0.0,) * (dimension - 1) + (-9.81,))
contact = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
bond = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "tensile_strength": 3e3, "cohesion": 3e3,
        "friction_coefficient": 0.5, "width_ratio": 0.8}
if dimension == 3:
    bond = {"radius_factor": 1.0, "normal_stiffness": 1e7, "shear_stiffness": 5e6, "tensile_strength": 1e4,
            "shear_strength": 1e4}
builder.add_material("rock", density=2000.0, contact=contact, bond=bond)
packing = lattice(kind, 0.1, cells=cells)
places = packing.positions - packing.positions.min(axis=0) + 0.2
rng = np.random.default_rng(3)
builder.add_particles(places, packing.radii, "rock", velocity=rng.normal(size=places.shape) * 3.0)
builder.bond_within(1.01)
builder.add_wall(box("box", np.zeros(dimension), places.max(axis=0) + 0.2))
simulation = ParticleSimulation(builder.build(), local_damping=0.1, buffer=0.01)
for _ in range(4):
    simulation.run(60)
    simulation.search(sort=True)
p, digest = simulation.pairs, hashlib.sha256()
for array in (simulation.positions, simulation.velocities, simulation.spins, p.history, p.bond):
    digest.update(np.ascontiguousarray(array).tobytes())
broken = len(simulation.broken_bonds().bond)
print(digest.hexdigest(), simulation.halo.across, broken, simulation.searches)
"""


HERTZ = """
import hashlib
import numpy as np
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation

builder = AssemblyBuilder(3, "hertz_mindlin")
contact = {"young_modulus": 1e7, "poisson_ratio": 0.25, "friction_coefficient": 0.5, "restitution": 0.7}
builder.add_material("grain", density=2000.0, contact=contact)
places = lattice("fcc", 0.01, cells=(6, 6, 6), gap=-1e-5).positions
velocity = 1e-3 * np.random.default_rng(1).normal(size=places.shape)
builder.add_particles(places, 0.01, "grain", velocity=velocity)
simulation = ParticleSimulation(builder.build(), orientation=False)
simulation.run(400)
print(hashlib.sha256(np.ascontiguousarray(simulation.positions).tobytes()).hexdigest())
"""


def outcome(dimension: int, threads: int, cache: Path, script: str = SCRIPT) -> list[str]:
    environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads), "GEODEM_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", script, str(dimension)],
        env=environment, cwd=Path(__file__).parent.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("dimension", [2, 3])
def test_same_bits_on_any_number_of_threads(dimension, tmp_path):
    # the first process compiles, the others find the kernel in the cache
    one, two, four = (outcome(dimension, threads, tmp_path) for threads in (1, 2, 4))
    assert one == two == four
    _, across, broken, searches = one
    # the scene has what could go wrong
    assert int(across) > 100
    assert int(broken) > 10
    assert int(searches) > 5


def test_same_bits_in_the_process_that_compiles(tmp_path):
    """numba optimises a parallel loop by itself, and once more in its caller: the sums of this law came out apart."""
    assert outcome(3, 1, tmp_path, HERTZ) == outcome(3, 1, tmp_path, HERTZ)
