"""Parts at rest are skipped, wake when something reaches them, and change nothing where nothing rests."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.boundaries.walls import box
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation, Sleep

HEIGHT = 1.6
WIDTH = 14.0
SPEED = 1.0


def bed(*, ball_at: float | None = None):
    """A hexagonal bed of discs in a box and, at a height above its middle, a disc that is driven downwards."""
    builder = AssemblyBuilder(2, gravity=(0.0, -9.81))
    stiffness = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
    builder.add_material(
        "grain", density=2000.0, contact={**stiffness, "normal_viscosity": 3e-4, "shear_viscosity": 3e-4}
    )
    packing = lattice("hexagonal", 0.1, box=(WIDTH, HEIGHT))
    builder.add_particles(packing.positions, packing.radii, "grain")
    if ball_at is not None:
        ball = builder.add_particles([[0.5 * WIDTH, ball_at]], 0.3, "grain")
        builder.hold(ball, x=0.0, y=-SPEED, rotation=0.0)
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


def test_a_disc_that_is_driven_into_a_sleeping_bed_wakes_it():
    simulation = ParticleSimulation(
        bed(ball_at=HEIGHT + 25.0), local_damping=0.3, sleep=Sleep(speed=2e-3, steps=50)
    )
    above = HEIGHT + 1.0
    while simulation.positions[-1, 1] > above:
        simulation.run(100)
    # all but the chunk of the driven disc, and those around it
    assert simulation.asleep.mean() > 0.5
    before = simulation.positions[:-1]
    seconds = 1.6 / SPEED
    simulation.run(int(seconds / simulation.time_step))
    pushed = np.linalg.norm(simulation.positions[:-1] - before, axis=1)
    assert pushed.max() > 0.1
    # nothing is left inside the disc
    gap = np.linalg.norm(simulation.positions[:-1] - simulation.positions[-1], axis=1) - 0.4
    assert gap.min() > -0.05


def test_the_same_bits_where_nothing_sleeps():
    assembly = bed()
    plain = ParticleSimulation(assembly)
    watched = ParticleSimulation(assembly, sleep=Sleep(speed=0.0))
    for simulation in (plain, watched):
        simulation.run(300)
    assert np.array_equal(plain.positions, watched.positions)
    assert np.array_equal(plain.velocities, watched.velocities)
