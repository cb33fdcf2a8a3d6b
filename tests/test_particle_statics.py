"""Equilibrium without time: a hanging chain, whose forces and lengths are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

LINKS = 9
WEIGHT = 2000.0 * math.pi * 0.05**2 * 9.81
STIFFNESS = 1e8


def chain(strength):
    """Ten discs one above the other; the highest is held, the strength is that of every bond [N]."""
    builder = AssemblyBuilder(2, "linear_frictional", "two_springs", gravity=(0.0, -9.81))
    stiff = {"normal_stiffness": STIFFNESS, "shear_stiffness": 5e7, "friction_coefficient": 0.5}
    bond = {**stiff, "tensile_strength": strength, "cohesion": strength, "width_ratio": 0.5}
    builder.add_material("m", density=2000.0, contact=stiff, bond=bond)
    builder.add_particles([(0.0, 0.1 * k) for k in range(LINKS + 1)], 0.05, "m")
    builder.bond_within(1.01)
    builder.hold([LINKS], x=0.0, y=0.0, rotation=0.0)
    return builder.build()


def test_chain_hangs_as_long_as_its_weight_makes_it():
    assembly = chain(1e9)
    simulation = ParticleSimulation(assembly)
    found = find_equilibrium(simulation, tolerance=1e-8)
    assert found.reached
    assert not len(found.broken)
    # the k-th bond from below carries k discs
    sinking = -(simulation.positions - assembly.positions)[:, 1] * STIFFNESS / WEIGHT
    expected = [sum(range(k + 1, LINKS + 1)) for k in range(LINKS + 1)]
    assert sinking == pytest.approx(np.array(expected, dtype=float), rel=1e-6, abs=1e-6)


def test_chain_breaks_at_its_top_and_nowhere_else():
    simulation = ParticleSimulation(chain(8.5 * WEIGHT))
    found = find_equilibrium(simulation, tolerance=1e-8, most_steps=300)
    # what fell off has no equilibrium
    assert not found.reached
    assert found.broken.tolist() == [LINKS - 1]
    broken = simulation.broken_bonds()
    assert broken.mode.tolist() == [1]
    assert broken.static.all()
