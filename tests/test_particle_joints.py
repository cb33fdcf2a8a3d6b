"""Particles across a smooth joint: they slide along its plane for many diameters, whatever the packing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.joint_loads import press_joints
from geodem.builders.joints import disc, plane, segment
from geodem.builders.random_packing import random_packing
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation

FRICTION = 0.5
SIZES = {2: (12.0, 8.0), 3: (5.0, 5.0, 5.0)}


def rock(dimension, size, seed=1):
    """A builder with bonded particles of a diameter near 1 in a box."""
    packing = random_packing(dimension, radius=0.6, size_ratio=1.5, box=size, periodic=False, seed=seed)
    build = AssemblyBuilder(dimension, "effective_modulus", "rock")
    contact = {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
    bond = {
        "effective_modulus": 1e9, "stiffness_ratio": 2.0, "tensile_strength": 1e9, "shear_strength": 1e9,
        "friction_coefficient": 0.5,
    }  # fmt: skip
    build.add_material("rock", density=2500.0, contact=contact, bond=bond)
    build.add_particles(packing.positions, packing.radii, "rock")
    build.bond_within(1.1)
    return build, packing.positions


def sheared(dimension, *, cohesion=0.0, speed=0.5):
    """A box cut in the middle; its upper half is pressed down and drawn along the plane."""
    size = SIZES[dimension]
    build, positions = rock(dimension, size)
    build.add_joint_material(
        "joint", normal_stiffness=2e9, shear_stiffness=1e9, friction_coefficient=FRICTION, cohesion=cohesion,
        tensile_strength=cohesion, residual_cohesion=cohesion,
    )  # fmt: skip
    up = np.eye(dimension)[-1]
    box = np.array([np.zeros(dimension), size])
    cut = build.cut([plane(0.5 * np.array(size), up, box, "joint")], bounds=box, within=1.1)
    upper = np.flatnonzero(positions[:, -1] > 0.5 * size[-1] + 2.0)
    lower = np.flatnonzero(positions[:, -1] < 0.5 * size[-1] - 2.0)
    still = {"x": 0.0, "y": 0.0, "rotation": 0.0, **({"z": 0.0} if dimension == 3 else {})}
    build.hold(lower, **still)
    build.hold(upper, rotation=0.0, x=speed, **({"y": 0.0} if dimension == 3 else {}))
    pressure = 1e6 * math.prod(size[:-1])
    build.apply(upper, force=-pressure / len(upper) * up)
    return build, cut, upper, pressure


@pytest.mark.parametrize("dimension", [2, 3])
def test_rough_packing_slides_as_on_a_plane(dimension):
    """Friction is mu N from the first slip on, and the upper half does not climb over the particles below."""
    build, _, upper, pressure = sheared(dimension)
    # local damping drags what moves steadily
    s = ParticleSimulation(build.build(), local_damping=0.2)
    steps = round(0.2 / s.time_step / 0.5)
    s.run(steps)
    height = s.positions[upper, -1].mean()
    drawn, heights = [], []
    for _ in range(12):
        s.run(steps // 2)
        drawn.append(-float(s.forces[upper, 0].sum()))
        heights.append(float(s.positions[upper, -1].mean()))
    way = s.positions[upper, 0].mean() - s.assembly.positions[upper, 0].mean()
    assert way > 1.2
    assert np.mean(drawn) / pressure == pytest.approx(FRICTION, rel=0.03)
    # a triangular packing of this size would climb by more than a tenth of a diameter
    assert np.abs(np.array(heights) - height).max() < 1e-2


def test_areas_add_up_to_the_face():
    _, cut, _, _ = sheared(2)
    assert cut.areas.sum() == pytest.approx(SIZES[2][0], rel=1e-9)
    assert cut.normals == pytest.approx(
        np.tile([0.0, 1.0], (len(cut.pairs), 1)) * np.sign(cut.normals[:, 1:])
    )
    _, cut, _, _ = sheared(3)
    assert cut.areas.sum() == pytest.approx(25.0, rel=0.01)


def test_joint_that_ends_in_the_rock_cuts_only_there():
    build, positions = rock(2, SIZES[2])
    build.add_joint_material("joint", normal_stiffness=2e8, shear_stiffness=1e8, friction_coefficient=0.5)
    bonds = len(build.bond_within(1.1)) + 0
    cut = build.cut([segment((3.0, 4.0), (8.0, 4.0), "joint")], within=1.1)
    assert bonds == 0
    assert (np.abs(cut.places[:, 0] - 5.5) <= 2.5).all()
    assert cut.places[:, 1] == pytest.approx(4.0)
    one, other = positions[cut.pairs[:, 0], 1], positions[cut.pairs[:, 1], 1]
    assert ((one < 4.0) != (other < 4.0)).all()
    kept = build.build().bonds
    assert not (set(map(tuple, kept.tolist())) & set(map(tuple, cut.pairs.tolist())))


def test_cohesion_is_that_of_the_face_and_its_break_is_recorded():
    """An ideally plastic joint slides at c + sigma tan(phi) over its whole length, whatever the packing."""
    # five times as fast, the middle swings and the mean is that of its swings
    build, _, upper, pressure = sheared(2, cohesion=3e5, speed=0.1)
    s = ParticleSimulation(build.build(), local_damping=0.2)
    steps = round(0.01 / s.time_step / 0.1)
    s.run(4 * steps)
    drawn = []
    for _ in range(10):
        s.run(steps)
        drawn.append(-float(s.forces[upper, 0].sum()))
    # with much more than the pressure the face would open behind, where what draws it lifts it
    assert np.mean(drawn) == pytest.approx(3e5 * SIZES[2][0] + FRICTION * pressure, rel=0.03)
    found = s.broken_bonds()
    joined = {tuple(pair) for pair in s.assembly.joints.pairs.tolist()}
    assert {tuple(pair) for pair in s.assembly.bonds[found.bond].tolist()} <= joined
    assert len(found.bond) > 0.9 * (s.assembly.joints.area > 0.0).sum()
    assert (found.mode == 2).mean() > 0.8


def test_same_bits_after_a_resume(tmp_path):
    build, *_ = sheared(2)
    assembly = build.build()
    whole = ParticleSimulation(assembly, local_damping=0.7)
    whole.run(3000)
    part = ParticleSimulation(assembly, local_damping=0.7)
    part.run(1500)
    part.save(tmp_path / "half.h5")
    again = ParticleSimulation.resume(tmp_path / "half.h5")
    again.run(1500)
    assert np.array_equal(again.positions, whole.positions)
    assert np.array_equal(again.forces, whole.forces)


def test_energy_account_closes():
    build, *_ = sheared(2, cohesion=1e6, speed=0.5)
    s = ParticleSimulation(build.build(), local_damping=0.3, energy=True)
    s.run(4000)
    account = s.energy()
    spent = account.kinetic + account.elastic + account.friction + account.damping + account.broken
    given = account.applied + account.driven + account.gravity + account.initial
    assert account.friction > 0.0
    assert spent == pytest.approx(given, rel=1e-3)


def test_water_presses_the_faces_apart():
    build, cut, *_ = sheared(2)
    force = press_joints(build, cut, lambda places: 1e4 * places[:, 0])
    assert force == pytest.approx((1e4 * cut.places[:, 0] * cut.areas)[:, None] * cut.normals)
    applied = build.build().applied
    assert np.abs(applied[:, 0]).max() == 0.0
    # of all pressures 1e4 x, over a face of 12 m
    assert np.abs(force[:, 1]).sum() == pytest.approx(0.5 * 1e4 * 12.0**2, rel=0.02)


def test_what_cannot_be_cut_is_refused():
    build, _ = rock(2, SIZES[2])
    face = segment((0.0, 4.0), (12.0, 4.0), "nothing")
    with pytest.raises(InputError, match="material of joints"):
        build.cut([face])
    with pytest.raises(InputError, match="2D"):
        build.cut([disc((1.0, 1.0, 1.0), (0.0, 0.0, 1.0), 1.0, "joint")])
    build.add_joint_material("nothing", normal_stiffness=1e8, shear_stiffness=1e8, friction_coefficient=0.5)
    with pytest.raises(InputError, match="within"):
        build.cut([face], within=0.5)
    build.cut([face])
    with pytest.raises(InputError, match="already"):
        build.cut([face])
