"""The guard of particle motion: each rule with the particle, the step and the cause; what is kept."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.errors import InputError, UnstableError
from geodem.particle_simulation import ParticleSimulation

SPRING = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
RADIUS = 0.1


def discs(places, *, gravity=(0.0, -10.0), floor=True, velocity=0.0, **options):
    build = AssemblyBuilder(2, gravity=gravity)
    build.add_material("grain", density=2000.0, contact=SPRING)
    build.add_particles(places, RADIUS, "grain", velocity=velocity)
    if floor:
        build.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    return ParticleSimulation(build.build(), **{"local_damping": 0.5} | options)


def resting():
    return discs([(0.0, 0.1), (0.0, 0.3), (0.5, 0.1)])


def test_a_number_that_is_none_is_told_with_its_particle_and_step():
    s = resting()
    s.run(100)
    s.rows[:, list(s.arrays.ids).index(2), s.columns.velocity.start] = math.nan
    with pytest.raises(UnstableError, match=r"particle 2 .*no finite place or velocity") as found:
        s.run(20_000)
    assert found.value.particle == 2
    assert 100 < found.value.step <= 100 + s.guard.every + 1000
    assert found.value.last_good == 0


def test_the_last_good_state_goes_on_with_the_same_bits(tmp_path):
    s, other = resting(), resting()
    s.guard.every = 1000
    s.run(9000)
    other.run(9000)
    s.rows[:, 0, s.columns.velocity.start] = math.nan
    with pytest.raises(UnstableError, match="state at step 8,001 is kept"):
        s.run(5000)
    s.last_good().save(tmp_path / "good.h5")
    again = ParticleSimulation.resume(tmp_path / "good.h5")
    # the first step is a batch of its own
    assert again.steps == 8001
    again.run(999)
    assert np.array_equal(again.now, other.now)


def test_nothing_is_kept_before_the_first_step():
    with pytest.raises(InputError, match="nothing has moved"):
        resting().last_good()


def test_a_step_too_long_for_the_radius_is_refused():
    s = discs([(0.0, 0.2)], velocity=(0.0, -1e4))
    with pytest.raises(UnstableError, match=r"in one step, more than 0\.4 of its radius"):
        s.run(10)


@pytest.mark.parametrize("floor", ["plane", "grain"])
def test_what_a_contact_cannot_stop_is_told_before_it_has_passed(floor):
    build = AssemblyBuilder(2)
    build.add_material("grain", density=2000.0, contact=SPRING)
    (heavy,) = build.add_particles([(0.0, 0.25)], RADIUS, "grain", density=1e9, velocity=(0.0, -5.0))
    build.add_particles([(5.0, 0.25)], RADIUS, "grain")
    if floor == "plane":
        build.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    else:
        build.hold(build.add_particles([(0.0, 0.0)], RADIUS, "grain"), x=0.0, y=0.0, rotation=0.0)
    s = ParticleSimulation(build.build())
    with pytest.raises(UnstableError, match="about to pass through") as found:
        s.run(100_000)
    assert found.value.particle == heavy
    # told at the latest a step after it was that deep
    assert s.positions[heavy, 1] > -0.5 * RADIUS


def test_what_leaves_the_box_is_told():
    s = discs([(0.0, 0.1), (0.0, 0.3), (0.5, 0.1)], velocity=(0.0, -0.5))
    # 1000 times an extent of at least 100 radii
    assert s.guard.low == pytest.approx([-0.1 - 1e4, -1e4])
    s.guard.low[1] = 0.15
    with pytest.raises(UnstableError, match=r"has left the box from .* 0.15\) to"):
        s.run(100_000)


@pytest.mark.parametrize("energy", [True, False])
def test_energy_out_of_nothing_is_told(energy):
    s = discs([(0.0, 0.1), (0.0, 0.3), (0.5, 0.1)], energy=energy)
    s.guard.every = 1000
    s.run(20_000)
    # grains at rest that are suddenly warm: slow enough for every other rule
    s.rows[:, :, s.columns.velocity.start] += 2.0
    s.run(2)
    with pytest.raises(UnstableError, match=r"energy"):
        s.guard.look(s)


def test_motion_that_rounding_makes_is_no_explosion():
    """Far from the origin places are rounded to 1e-11 m: springs that hold nothing shake with what that is worth."""
    hexagon = [
        (2.0 * RADIUS * np.cos(angle), 2.0 * RADIUS * np.sin(angle)) for angle in np.arange(6) * np.pi / 3.0
    ]
    places = np.array([(0.0, 0.0), *hexagon]) * (1.0 - 1e-9) + [1e5 + 1.0 / 3.0, 1e5 + 1.0 / 7.0]
    s = discs(places, gravity=(0.0, 0.0), floor=False, local_damping=0.0)
    s.guard.every = 1000
    for _ in range(20):
        s.run(1000)
        s.rows[:, :, s.columns.velocity] = 0.0
    s.guard.kinetic = 0.0
    s.run(4000)
    assert s.kinetic_energy() > 0.0


def test_grains_that_begin_in_each_other_may_fly_apart():
    """What their contacts store is not known before the first step."""
    s = discs([(0.0, 0.3), (0.15, 0.3), (2.0, 0.1)], gravity=(0.0, -1e-9))
    s.run(20)
    s.guard.look(s)
    assert s.kinetic_energy() > 100.0


def test_kinetic_energy_of_a_long_fall_and_of_a_released_spring_is_explained():
    s = discs([(0.0, 2.0), (1.0, 0.1), (2.0, 0.1)])
    s.run(12_000)
    assert s.kinetic_energy() > 0.0
    spring = discs([(0.0, 0.12), (0.15, 0.12), (2.0, 0.1)])
    spring.guard.every = 100
    spring.run(1000)
    assert spring.kinetic_energy() > 0.0
