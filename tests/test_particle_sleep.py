"""Parts at rest are skipped, wake when something reaches them, and change nothing where nothing rests."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.boundaries.walls import box
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.kernels import sleep
from geodem.kernels.wall_geometry import BODY_WIDTH
from geodem.particle_simulation import ParticleSimulation, Sleep
from geodem.particle_statics import find_equilibrium

HEIGHT = 1.6
WIDTH = 14.0


def bed():
    """A hexagonal bed of discs in a box."""
    builder = AssemblyBuilder(2, gravity=(0.0, -9.81))
    stiffness = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
    builder.add_material(
        "grain", density=2000.0, contact={**stiffness, "normal_viscosity": 3e-4, "shear_viscosity": 3e-4}
    )
    packing = lattice("hexagonal", 0.1, box=(WIDTH, HEIGHT))
    builder.add_particles(packing.positions, packing.radii, "grain")
    builder.add_wall(box("box", (0.0, 0.0), (WIDTH, 50.0)))
    return builder.build()


def run_to_sleep(simulation, most=40_000):
    while simulation.steps < most:
        simulation.run(500)
        if simulation.asleep.all():
            return
    pytest.fail(f"{int(simulation.asleep.sum())} of {len(simulation.asleep)} chunks asleep")


def test_a_bed_falls_asleep_where_it_would_lie_anyway_and_keeps_its_weight_on_the_floor():
    assembly = bed()
    sleeping = ParticleSimulation(assembly, local_damping=0.3, sleep=Sleep(speed=1e-4, steps=100))
    run_to_sleep(sleeping)
    awake = ParticleSimulation(assembly, local_damping=0.3)
    awake.run(sleeping.steps)
    assert np.abs(sleeping.positions - awake.positions).max() < 1e-4  # of radii of 0.1
    weight = float(assembly.mass.sum()) * 9.81
    sleeping.run(100)
    assert sleeping.wall_force("box")[1] == pytest.approx(-weight, rel=2e-3)
    assert not sleeping.velocities.any()


def test_a_blow_in_one_chunk_wakes_the_others():
    assembly = bed()
    simulation = ParticleSimulation(assembly, local_damping=0.3, sleep=Sleep(speed=1e-4, steps=100))
    run_to_sleep(simulation)
    before = simulation.positions
    simulation.asleep[0] = 0
    simulation.now[: simulation.chunk, simulation.columns.velocity] = (0.0, -1.0)
    simulation.run(200)
    assert not simulation.asleep.any()
    assert np.abs(simulation.positions - before).max() > 1e-3


def test_the_same_bits_where_nothing_sleeps():
    assembly = bed()
    plain = ParticleSimulation(assembly)
    watched = ParticleSimulation(assembly, sleep=Sleep(speed=0.0))
    for simulation in (plain, watched):
        simulation.run(300)
    assert np.array_equal(plain.positions, watched.positions)
    assert np.array_equal(plain.velocities, watched.velocities)


def wake(asleep, *, fast=None, wall=None, speed=0.0):
    """Which chunks of a row of eight sleep after a step, one of them fast, one near a wall of some speed."""
    chunks = len(asleep)
    asleep = np.array(asleep, dtype=np.uint8)
    beside = [[k for k in (c - 1, c + 1) if 0 <= k < chunks] for c in range(chunks)]
    start = np.cumsum([0, *map(len, beside)])
    sums = np.zeros((chunks, 17))
    if fast is not None:
        sums[fast, sleep.FASTEST] = 1.0
    wall_start = np.zeros(chunks + 1, dtype=np.int64)
    if wall is not None:
        wall_start[wall + 1 :] = 1
    bodies = np.zeros((1, BODY_WIDTH))
    bodies[0, sleep.BODY_VELOCITY] = speed
    nothing = np.zeros(1, dtype=np.int64)
    sleep.sleep_and_wake(
        1, np.zeros((2, chunks, 12)), 0, sums, asleep, np.zeros(chunks, np.int64), start, np.concatenate(beside),
        1e-3, 5, wall_start, nothing, nothing, bodies,
    )  # fmt: skip
    return asleep.tolist()


def test_only_the_chunks_around_a_fast_one_wake():
    assert wake([1, 1, 1, 0, 1, 1, 1, 1], fast=3) == [1, 1, 0, 0, 0, 1, 1, 1]


def test_a_wall_that_comes_near_wakes_a_chunk_if_it_moves():
    assert wake([1] * 8, wall=2, speed=0.1) == [1, 1, 0, 1, 1, 1, 1, 1]
    assert wake([1] * 8, wall=2, speed=0.0) == [1] * 8


def test_contacts_with_walls_still_count_where_one_chunk_wakes_among_sleepers():
    simulation = ParticleSimulation(bed(), local_damping=0.3, sleep=Sleep(speed=1e-4, steps=100))
    run_to_sleep(simulation)
    contacts = simulation.contact_count()
    simulation.asleep[0] = 0
    simulation.run(1)
    assert simulation.contact_count() == pytest.approx(contacts, abs=2)


def test_nothing_sleeps_after_a_search_for_equilibrium():
    simulation = ParticleSimulation(bed(), local_damping=0.3, sleep=Sleep(speed=1e-4, steps=100))
    run_to_sleep(simulation)
    find_equilibrium(simulation, most_steps=50)
    assert not simulation.asleep.any()
