"""Equilibrium without time: a hanging chain, whose forces and lengths are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem._jit import ThreadPilot
from geodem.boundaries import walls
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium
from reference.benchmarks.statics import (
    BORNE,
    breakable,
    by_damping,
    by_search,
    random_discs,
    usual_step,
)

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
    found = find_equilibrium(simulation, tolerance=1e-8)
    # what fell off has no equilibrium, which is seen long before the steps run out
    assert not found.reached
    assert found.reason == f"{LINKS} particles fall freely, the first is 0"
    assert found.steps < 1000
    assert found.broken.tolist() == [LINKS - 1]
    broken = simulation.broken_bonds()
    assert broken.mode.tolist() == [1]
    assert broken.static.all()


def test_a_part_that_falls_onto_what_is_held_is_followed():
    """Two discs above a held one, the upper bond without strength to speak of: nothing falls away."""
    builder = AssemblyBuilder(2, "linear_frictional", "two_springs", gravity=(0.0, -9.81))
    stiff = {"normal_stiffness": STIFFNESS, "shear_stiffness": 5e7, "friction_coefficient": 0.5}
    builder.add_material(
        "m", density=2000.0, contact=stiff,
        bond={**stiff, "tensile_strength": 1e9, "cohesion": 1e9, "width_ratio": 0.5},
    )  # fmt: skip
    builder.add_particles([(0.0, 0.0), (0.0, 0.1), (0.0, 0.2005), (0.0, 0.3005)], 0.05, "m")
    builder.bond([(0, 1), (2, 3)])
    builder.hold([0], x=0.0, y=0.0, rotation=0.0)
    simulation = ParticleSimulation(builder.build())
    found = find_equilibrium(simulation, tolerance=1e-6)
    assert found.reached
    assert found.reason == ""
    # the contact carries two discs
    overlap = 0.1 - float(np.diff(simulation.positions[1:3], axis=0)[0, 1])
    assert overlap * STIFFNESS == pytest.approx(2.0 * WEIGHT, rel=1e-5)


@pytest.mark.parametrize("solve", [True, False])
def test_a_thousand_discs_rest_where_slow_damped_motion_ends(solve):
    """Bonds of the strength that the loads at rest ask for, and a tenth more: both ways break none."""
    assembly = random_discs(1000, 2.0)
    slow = by_damping(assembly, usual_step(assembly), 1e-9)
    assert slow.reached
    # half a per cent of the largest displacement is what the usual tolerance leaves; this one is converged
    largest = np.abs(slow.displacements).max()
    strong = random_discs(1000, 2.0, strength=1.1 * BORNE * breakable(assembly))
    quick = by_search(strong, 1e-7 if solve else 1e-8, solve=solve)
    assert quick.reached
    assert quick.broken == 0
    assert np.abs(quick.displacements - slow.displacements).max() < 1e-4 * largest
    assert quick.steps < slow.steps / (100 if solve else 5)


def heap():
    """Unequal discs on a loose square lattice between walls: they fall together."""
    builder = AssemblyBuilder(2, "linear_frictional", gravity=(0.0, -9.81))
    spring = {"normal_stiffness": 1e7, "shear_stiffness": 5e6, "friction_coefficient": 0.3}
    builder.add_material("m", density=2000.0, contact=spring)
    chance = np.random.default_rng(3)
    places = np.stack(np.meshgrid(np.arange(25.0), np.arange(20.0)), axis=-1).reshape(-1, 2) + 0.5
    builder.add_particles(
        places + chance.uniform(-0.05, 0.05, places.shape), chance.uniform(0.3, 0.44, 500), "m"
    )
    builder.add_wall(walls.box("box", (0.0, 0.0), (25.0, 40.0)))
    return builder.build()


def test_rest_does_not_depend_on_where_batches_of_steps_end(monkeypatch):
    monkeypatch.setattr(ThreadPilot, "learn", lambda pilot, seconds: None)

    def found(most):
        monkeypatch.setattr(ThreadPilot, "choose", lambda pilot: (1, most))
        simulation = ParticleSimulation(heap())
        answer = find_equilibrium(simulation, solve=False, most_steps=2000)
        return answer.steps, simulation.searches, simulation.positions

    steps, searches, places = found(10_000)
    assert searches > 3
    for most in (3, 70):
        again, searched, there = found(most)
        assert (again, searched) == (steps, searches)
        assert np.array_equal(there, places)
