"""Discs and spheres in motion: what is conserved, what the account says, what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numba
import numpy as np
import pytest

from geodem.assembly import Servo
from geodem.boundaries.walls import box, plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.errors import InputError
from geodem.neighbors import rebuild
from geodem.particle_simulation import ParticleSimulation

CONTACT = {"normal_stiffness": 1e5, "shear_stiffness": 5e4, "friction_coefficient": 0.5}


def cloud(dimension, side, *, law="linear_frictional", **more):
    """Particles on a loose grid that fly at random."""
    rng = np.random.default_rng(7)
    builder = AssemblyBuilder(dimension, law)
    builder.add_material("m", density=2000.0, contact={**CONTACT, **more})
    grid = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    radii = rng.uniform(0.0085, 0.0099, len(grid))
    speed = rng.uniform(-1.0, 1.0, (len(grid), dimension))
    builder.add_particles(0.02 * grid, radii, "m", velocity=speed)
    return builder.build()


def momenta(simulation):
    """Linear and angular momentum, and how large their parts are."""
    s, a = simulation, simulation.assembly
    # velocities are half a step old: place and velocity at one time
    places = s.positions - 0.5 * s.time_step * s.velocities
    carried = a.mass[:, None] * s.velocities
    if s.dimension == 2:
        moment = places[:, 0] * carried[:, 1] - places[:, 1] * carried[:, 0] + a.inertia * s.spins[:, 0]
    else:
        moment = np.cross(places, carried) + a.inertia[:, None] * s.spins
    return carried.sum(0), moment.sum(0), np.abs(carried).sum(), np.abs(moment).sum()


@pytest.mark.parametrize(("dimension", "side"), [(2, 12), (3, 8)])
def test_free_collisions_conserve_both_momenta(dimension, side):
    simulation = ParticleSimulation(cloud(dimension, side))
    simulation.run(1)
    linear, angular, size, turning = momenta(simulation)
    simulation.run(400)
    linear_now, angular_now, _, _ = momenta(simulation)
    # most have met somebody and spin since
    assert (np.abs(simulation.spins).max(axis=1) > 0.1).mean() > 0.3
    assert np.abs(linear_now - linear).max() < 1e-13 * size
    assert np.abs(angular_now - angular).max() < 1e-12 * turning


def test_same_motion_of_both_kernels():
    """The loop over blocks and the one over pairs; the energy account chooses the latter."""
    blocked = ParticleSimulation(cloud(3, 8))
    scalar = ParticleSimulation(cloud(3, 8), energy=True)
    assert blocked.features.blocked
    assert not scalar.features.blocked
    blocked.run(50)
    scalar.run(50)
    assert np.abs(blocked.positions - scalar.positions).max() < 1e-10 * 0.01
    assert np.abs(blocked.velocities - scalar.velocities).max() < 1e-10
    assert np.abs(blocked.spins - scalar.spins).max() < 1e-8


@pytest.mark.parametrize("spread", [1.0, 1.003])
def test_same_bonds_in_both_kernels(spread):
    """Spheres bonded beside contacts that come and go, bonds that break, contacts that slide afterwards."""

    def block(**more):
        packing = lattice("fcc", 0.01, cells=(4, 4, 4))
        rng = np.random.default_rng(11)
        builder = AssemblyBuilder(3, bond_law="parallel_bond")
        strength = {"tensile_strength": 2e4, "shear_strength": 4e4}
        builder.add_material(
            "rock", density=2000.0, contact=CONTACT,
            bond={"radius_factor": 1.0, "normal_stiffness": 1e8, "shear_stiffness": 5e7, **strength},
        )  # fmt: skip
        velocity = 0.3 * rng.normal(size=packing.positions.shape)
        spin = 20.0 * rng.normal(size=packing.positions.shape)
        builder.add_particles(spread * packing.positions, packing.radii, "rock", velocity=velocity, spin=spin)
        builder.bond_within(1.01)
        return ParticleSimulation(builder.build(), **more)

    blocked, scalar = block(), block(energy=True)
    # the serial kernel is the one over pairs too: force the other
    blocked.features = replace(blocked.features, blocked=True)
    assert blocked.features.in_blocks()
    assert not scalar.features.in_blocks()
    time_step = blocked.time_step
    assert time_step == scalar.time_step
    for simulation in (blocked, scalar):
        simulation.run(60)
    broken = [simulation.broken_bonds() for simulation in (blocked, scalar)]
    assert 20 < len(broken[0].bond) < 0.9 * len(blocked.assembly.bonds)
    assert broken[0].bond.tolist() == broken[1].bond.tolist()
    assert broken[0].step.tolist() == broken[1].step.tolist()
    assert broken[0].mode.tolist() == broken[1].mode.tolist()
    np.testing.assert_allclose(broken[0].place, broken[1].place, rtol=0.0, atol=1e-9)
    assert np.abs(blocked.positions - scalar.positions).max() < 1e-9 * 0.01
    assert np.abs(blocked.velocities - scalar.velocities).max() < 1e-8
    assert np.array_equal(blocked.pairs.touching, scalar.pairs.touching)
    one, other = (simulation.contacts().history for simulation in (blocked, scalar))
    for name in one:
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=1e-6 * np.abs(other[name]).max())


def test_the_account_changes_no_motion_of_discs_bonded_where_they_overlap():
    """After the break contacts are measured from the distance at bonding, until the surfaces have parted."""

    def block(energy):
        rng = np.random.default_rng(3)
        packing = lattice("hexagonal", 0.1, box=(1.3, 1.2))
        builder = AssemblyBuilder(2, bond_law="parallel_bond")
        strength = {"tensile_strength": 4e4, "shear_strength": 4e4}
        builder.add_material(
            "rock", density=2000.0, contact=CONTACT,
            bond={"radius_factor": 1.0, "normal_stiffness": 1e7, "shear_stiffness": 5e6, **strength},
        )  # fmt: skip
        velocity = 1.5 * rng.normal(size=packing.positions.shape)
        builder.add_particles(0.97 * packing.positions, packing.radii, "rock", velocity=velocity)
        builder.bond_within(1.01)
        return ParticleSimulation(builder.build(), energy=energy)

    plain, counted = block(False), block(True)
    for simulation in (plain, counted):
        simulation.run(400)
    assert len(plain.broken_bonds().bond) > 10
    assert np.abs(plain.positions - counted.positions).max() < 1e-10 * 0.1


@pytest.mark.parametrize(
    ("options", "place"),
    [
        ({"time_step": 1.0}, "time_step"),
        ({"time_step": -1e-6}, "time_step"),
        ({"time_step": math.nan}, "time_step"),
        ({"local_damping": 1.0}, "local_damping"),
        ({"local_damping": -0.1}, "local_damping"),
        ({"global_damping": math.inf}, "global_damping"),
        ({"stiffness_damping": -1.0}, "stiffness_damping"),
        ({"buffer": 0.0}, "buffer"),
    ],
)
def test_bad_input_is_refused_before_anything_is_compiled(options, place, monkeypatch):
    if options != {"time_step": 1.0}:
        # that it is above the critical one is known once there are pairs
        monkeypatch.setattr("geodem.particle_simulation.first_order", None)
    with pytest.raises(InputError, match=place):
        ParticleSimulation(cloud(2, 2), **options)


@pytest.mark.parametrize("dimension", [2, 3])
def test_planes_move_particles_alike_whether_or_not_the_kernel_knows_facets(dimension):
    found = []
    for facets in (False, True):
        builder = AssemblyBuilder(dimension, gravity=(0.0,) * (dimension - 1) + (-9.81,))
        builder.add_material(
            "grain", density=2000.0,
            contact={"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5},
        )  # fmt: skip
        builder.add_particles(
            [[0.09] * dimension, [0.15, 0.35, 0.3][:dimension]],
            0.1,
            "grain",
            velocity=[0.5] * (dimension - 1) + [-1.0],
        )
        builder.add_wall(box("box", [0.0] * dimension, [0.5] * dimension))
        simulation = ParticleSimulation(builder.build())
        assert not simulation.features.facets
        simulation.features = replace(simulation.features, facets=facets)
        simulation.run(2000)
        found.append(np.hstack([simulation.positions, simulation.velocities, simulation.spins]))
        # they have met walls
        assert np.abs(simulation.spins).max() > 0.1
    # inlined or not, the compiler may round in another order
    np.testing.assert_allclose(found[0], found[1], rtol=0.0, atol=1e-9)


def test_step_above_the_critical_one_is_refused_with_the_number():
    simulation = ParticleSimulation(cloud(2, 2))
    with pytest.raises(InputError, match=f"{simulation.critical_time_step:.6g}"):
        ParticleSimulation(cloud(2, 2), time_step=1.01 * simulation.critical_time_step)


def test_steps_backwards_are_refused():
    with pytest.raises(InputError, match="steps"):
        ParticleSimulation(cloud(2, 2)).run(-1)


def test_account_closes_as_the_square_of_the_step():
    found = []
    for share in (0.1, 0.05):
        critical = ParticleSimulation(cloud(2, 12)).critical_time_step
        simulation = ParticleSimulation(cloud(2, 12), energy=True, time_step=share * critical)
        simulation.run(round(400 / share))
        account = simulation.energy()
        assert account.friction > 0.3 * account.supplied
        found.append(abs(account.imbalance))
    assert found[0] < 1e-3
    assert found[1] < 3e-4
    assert found[0] > 3.0 * found[1]


def test_two_anchors_on_one_particle_are_refused(monkeypatch):
    builder = AssemblyBuilder(2)
    builder.add_material("m", density=2000.0, contact=CONTACT)
    builder.add_particles([[0.0, 0.0]], 0.01, "m")
    builder.anchor([0], (0.0, 1.0), 1e3)
    builder.anchor([0], (1.0, 0.0), 1e3)
    monkeypatch.setattr("geodem.particle_simulation.first_order", None)  # nothing is compiled before
    with pytest.raises(InputError, match=r"particle 0: it has more than one anchor"):
        ParticleSimulation(builder.build())


def test_a_servo_that_nothing_is_near_to_is_refused(monkeypatch):
    builder = AssemblyBuilder(2)
    builder.add_material("m", density=2000.0, contact=CONTACT)
    builder.add_particles([[0.0, 0.0]], 0.01, "m")
    builder.add_wall(plane("lid", (0.0, 1.0), (0.0, -1.0), servo=Servo((0.0, -1.0), 10.0, 0.1)))
    monkeypatch.setattr("geodem.particle_simulation.first_order", None)
    with pytest.raises(InputError, match=r"wall 'lid', servo.*no particle is within"):
        ParticleSimulation(builder.build())


def test_little_is_searched_by_one_thread(monkeypatch):
    """As the steps of so few are done: the others would wait for each other longer than the search takes."""
    used = []

    def seen(*given, **more):
        used.append(numba.get_num_threads())
        return rebuild(*given, **more)

    for side, alone in ((12, True), (24, False)):
        simulation = ParticleSimulation(cloud(2, side))
        with monkeypatch.context() as patch:
            patch.setattr("geodem.particle_simulation.rebuild", seen)
            used.clear()
            simulation.run(400)
        assert used
        assert simulation.parallel is not alone
        if alone:
            assert set(used) == {1}
