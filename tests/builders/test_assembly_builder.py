"""Assemblies: masses, tables and freedoms as given, and every bad input refused with its place and a remedy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.boundaries import walls
from geodem.builders import memory
from geodem.builders.assembly_builder import AssemblyBuilder, LognormalScatter
from geodem.builders.close_pairs import close_pairs
from geodem.errors import InputError, InputErrors

CONTACT = {"normal_stiffness": 1e8, "shear_stiffness": 4e7, "friction_coefficient": 0.5}
SPRINGS = {
    "normal_stiffness": 1e8, "shear_stiffness": 4e7, "tensile_strength": 1e5, "cohesion": 2e5,
    "friction_coefficient": 0.5, "width_ratio": 0.5,
}  # fmt: skip
ROW = [(0.0, 0.0), (2.0, 0.0), (4.0, 0.0)]


def builder(bond_law="two_springs", bond=SPRINGS, **more):
    """Discs of one material, rock."""
    made = AssemblyBuilder(2, bond_law=bond_law, **more)
    made.add_material("rock", density=2500.0, contact=CONTACT, bond=bond)
    return made


def row(**more):
    """Three discs that touch."""
    made = builder(**more)
    made.add_particles(ROW, 1.0, "rock")
    return made


def spheres(positions, radii=1.0):
    made = AssemblyBuilder(3)
    made.add_material("sand", density=2650.0, contact=CONTACT)
    made.add_particles(positions, radii, "sand")
    return made


# ---------------------------------------------------------------------------------------------- what is built


def test_mass_and_inertia_of_discs_and_spheres():
    discs = builder()
    discs.add_particles(ROW, [0.5, 1.0, 1.0], "rock", density=[2000.0, 2500.0, 2500.0])
    assembly = discs.build()
    # per metre of length: m = rho pi r^2, I = m r^2 / 2
    assert assembly.mass[0] == pytest.approx(2000.0 * math.pi * 0.25)
    assert assembly.inertia[0] == pytest.approx(2000.0 * math.pi * 0.25 * 0.125)
    ball = spheres([(0, 0, 0)], 0.5).build()
    # m = 4/3 rho pi r^3, I = 2/5 m r^2
    assert ball.mass[0] == pytest.approx(2650.0 * math.pi / 6.0)
    assert ball.inertia[0] == pytest.approx(2650.0 * math.pi / 6.0 * 0.1)


def test_particles_are_numbered_as_they_come():
    made = builder()
    assert made.add_particles(ROW, 1.0, "rock") == range(3)
    made.add_material("clay", density=1900.0, contact=CONTACT)
    assert made.add_particles([(6.0, 0.0)], 1.0, "clay", velocity=(1.0, -2.0), spin=0.3) == range(3, 4)
    assembly = made.build()
    assert assembly.material.tolist() == [0, 0, 0, 1]
    assert assembly.material_names == ("rock", "clay")
    assert assembly.velocities[3].tolist() == [1.0, -2.0]
    assert assembly.spins.tolist() == [[0.0], [0.0], [0.0], [0.3]]


def test_contact_table_holds_springs_in_series_and_what_pairs_override():
    made = row()
    made.add_material("clay", density=1900.0, contact=CONTACT | {"normal_stiffness": 3e8})
    made.add_material("steel", density=7850.0, contact=CONTACT | {"friction_coefficient": 0.1})
    made.set_contact("steel", "rock", friction_coefficient=0.9)
    assembly = made.build()
    # kn, ks, mu of two equal halves in series: 2 k1 k2 / (k1 + k2)
    assert assembly.pair_parameters(0, 1)[:3] == pytest.approx([1.5e8, 4e7, 0.5])
    assert assembly.pair_parameters(0, 2)[2] == 0.9
    assert assembly.pair_parameters(1, 2)[2] == 0.1
    for i in range(3):
        for j in range(3):
            assert np.array_equal(assembly.pair_parameters(i, j), assembly.pair_parameters(j, i))


def test_bond_table_is_nan_where_nothing_can_be_bonded():
    made = row()
    made.add_material("water", density=1000.0, contact=CONTACT)
    made.bond([(0, 1)])
    table = made.build().bond_table
    assert np.isfinite(table[0]).all()
    assert np.isnan(table[1:]).all()


def test_set_bond_weakens_an_interface():
    made = row()
    made.add_material("mortar", density=2000.0, contact=CONTACT, bond=SPRINGS)
    made.add_particles([(6.0, 0.0)], 1.0, "mortar")
    made.bond_within()
    made.set_bond("mortar", "rock", tensile_strength=7.0)
    assembly = made.build()
    column = 2
    assert assembly.bond_table[:, column].tolist() == [1e5, 7.0, 7.0, 1e5]


def test_wall_contact_is_the_rigid_half_with_its_overrides():
    made = row(gravity=(0.0, -9.81))
    made.add_material("clay", density=1900.0, contact=CONTACT)
    made.add_wall(walls.plane("floor", (0, -1), (0, 1), contact={"friction_coefficient": 0.2}))
    made.set_contact("clay", "floor", friction_coefficient=0.0)
    (floor,) = made.build().walls
    # against a rigid body only the grain's own half of the spring gives way
    assert floor.contact["rock"].normal_stiffness == 2e8
    assert floor.contact["rock"].friction_coefficient == 0.2
    assert floor.contact["clay"].friction_coefficient == 0.0


def test_bond_within_finds_every_pair_in_reach():
    rng = np.random.default_rng(1)
    positions = np.stack(np.meshgrid(np.arange(12) * 2.2, np.arange(9) * 2.2), axis=-1).reshape(-1, 2)
    positions += rng.uniform(-0.05, 0.05, positions.shape)
    radii = rng.uniform(0.5, 1.1, len(positions))
    made = builder()
    made.add_particles(positions, radii, "rock")
    found = made.bond_within(1.25)
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    near = np.triu(distance <= 1.25 * (radii[:, None] + radii[None]), 1)
    assert len(found) > 40
    assert found.tolist() == np.argwhere(near).tolist()
    assert made.build().bonds.tolist() == found.tolist()


def test_bond_within_leaves_earlier_bonds_and_other_materials_alone():
    made = row()
    made.add_material("clay", density=1900.0, contact=CONTACT, bond=SPRINGS)
    made.add_particles([(0.0, 2.0), (2.0, 2.0)], 1.0, "clay")
    made.bond([(1, 0)], scale=0.5)
    assert made.bond_within(1.01, between=("rock", "clay")).tolist() == [[0, 3], [1, 4]]
    assert made.bond_within(1.01, scale=2.0).tolist() == [[1, 2], [3, 4]]
    assert made.build().bond_scale.tolist() == [0.5, 1.0, 1.0, 2.0, 2.0]


def test_pairs_of_very_unlike_sizes_are_found():
    rng = np.random.default_rng(2)
    positions, radii = rng.random((300, 3)), np.geomspace(1e-3, 0.3, 300)
    pairs, distance = close_pairs(positions, radii, lambda a, b: a + b)
    all_distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    assert pairs.tolist() == np.argwhere(np.triu(all_distances <= radii[:, None] + radii[None], 1)).tolist()
    assert distance == pytest.approx(all_distances[pairs[:, 0], pairs[:, 1]])


def test_lognormal_scatter_has_its_mean_and_variation_and_repeats():
    factors = LognormalScatter(0.3, seed=4).factors(200_000)
    # standard error of the mean 0.3 / sqrt(200000) = 7e-4
    assert factors.mean() == pytest.approx(1.0, abs=3e-3)
    assert factors.std() == pytest.approx(0.3, abs=4e-3)
    assert np.array_equal(factors, LognormalScatter(0.3, seed=4).factors(200_000))
    assert not np.array_equal(factors, LognormalScatter(0.3, seed=5).factors(200_000))


def test_held_driven_and_loaded_freedoms():
    made = row()
    made.hold([0], x=0.0, rotation=0.0)
    made.hold(range(1, 3), y=[-0.1, -0.2])
    made.apply(np.array([False, False, True]), force=(3.0, 4.0))
    made.apply([2, 2], force=(1.0, 0.0), torque=5.0)
    assembly = made.build()
    assert assembly.held.tolist() == [[True, False, True], [False, True, False], [False, True, False]]
    assert assembly.velocities[:, 1].tolist() == [0.0, -0.1, -0.2]
    # loads add up, also those of one call
    assert assembly.applied[2].tolist() == [5.0, 4.0, 10.0]


def test_anchor_is_free_of_force_where_it_is_made():
    made = row()
    made.anchor([0, 2], (0.0, 3.0), 1e6)
    made.anchor([1], [(2.0, 0.0)], 5.0, length=0.0)
    anchors = made.build().anchors
    assert anchors.particle.tolist() == [0, 2, 1]
    assert anchors.length == pytest.approx([3.0, 5.0, 0.0])
    assert anchors.stiffness.tolist() == [1e6, 1e6, 5.0]


def test_built_assembly_does_not_change_with_the_builder():
    made = row()
    assembly = made.build()
    made.hold([0], x=1.0)
    assert not assembly.held.any()
    assert not assembly.velocities.any()


# -------------------------------------------------------------------------------------------- what is refused

REFUSED = {
    # what is done: (call, what the place names, value or what is wrong, remedy)
    "dimension": (lambda: AssemblyBuilder(4), "dimension", "= 4", "2 or 3"),
    "unknown law": (lambda: AssemblyBuilder(2, "liner_frictional"), "contact law", "liner", "'linear_frictional'"),
    "law of another dimension": (
        lambda: AssemblyBuilder(3, bond_law="two_springs"), "bond law", "not made for 3D", "parallel_bond"),
    "gravity": (lambda: AssemblyBuilder(2, gravity=(0, math.nan)), "gravity", "not 2 finite", "-9.81"),
    "gravity without direction": (lambda: AssemblyBuilder(2, gravity=-9.81), "gravity", "= -9.81", "(0.0, -9.81)"),
    "density": (
        lambda: AssemblyBuilder(2).add_material("clay", density=-1.0, contact=CONTACT),
        "material 'clay', density", "= -1.0", "kg/m3"),
    "stiffness": (
        lambda: AssemblyBuilder(2).add_material("clay", density=1.0, contact=CONTACT | {"normal_stiffness": -5.0}),
        "'clay', contact.normal_stiffness", "= -5.0", "positive"),
    "parameter lacks": (
        lambda: AssemblyBuilder(2).add_material("clay", density=1.0, contact={"normal_stiffness": 1e8}),
        "'clay', contact.shear_stiffness", "needs it", "SI units"),
    "parameter too many": (
        lambda: AssemblyBuilder(2).add_material("clay", density=1.0, contact=CONTACT | {"fricton": 0.5}),
        "'clay', contact.fricton", "no parameter", '"friction_coefficient"'),
    "no number": (
        lambda: AssemblyBuilder(2).add_material(
            "clay", density=1.0, contact=CONTACT | {"normal_stiffness": "1 MN/m"}),
        "normal_stiffness", "1 MN/m", "number"),
    "bond without bond law": (
        lambda: AssemblyBuilder(2).add_material("clay", density=1.0, contact=CONTACT, bond=SPRINGS),
        "'clay', bond", "no bond law", "bond_law"),
    "material twice": (
        lambda: builder().add_material("rock", density=1.0, contact=CONTACT), "'rock'", "already", "another name"),
    "unknown material": (lambda: builder().add_particles(ROW, 1.0, "rok"), "material", "= 'rok'", "'rock'"),
    "radius": (lambda: row().add_particles(ROW, [1, -2, 0], "rock"), "radius of particle 4", "= -2.0", "positive"),
    "position": (
        lambda: builder().add_particles([(0, 0), (math.nan, 1)], 1.0, "rock"), "position of particle 1", "nan", "m"),
    "positions of spheres": (
        lambda: builder().add_particles([(0, 0, 0)], 1.0, "rock"), "positions", "(1, 3)", "2 coordinates"),
    "velocity": (
        lambda: builder().add_particles(ROW, 1.0, "rock", velocity=(0, math.inf)),
        "velocity of particle 0", "inf", "m/s"),
    "own density": (
        lambda: builder().add_particles(ROW, 1.0, "rock", density=0.0), "density of particle 0", "2 more", "kg/m3"),
    "number of radii": (lambda: builder().add_particles(ROW, [1, 2], "rock"), "radii", "(2,)", "3 of them"),
    "bond to nowhere": (lambda: row().bond([(0, 7)]), "bonds", "= 7", "add_particles"),
    "bond to itself": (lambda: row().bond([(0, 1), (2, 2)]), "bond 1", "particle 2", "two different"),
    "bond twice": (lambda: row().bond([(0, 1), (1, 0)]), "bond 1", "0 and 1", "once"),
    "bond without parameters": (lambda: row(bond=None).bond([(0, 1)]), "'rock', bond", "two_springs", "bond={"),
    "bonds without law": (lambda: row(bond_law=None, bond=None).bond_within(), "bonds", "no bond law", "bond_law"),
    "bond factor": (lambda: row().bond_within(5.0), "factor", "= 5.0", "1.05"),
    "scale": (lambda: row().bond([(0, 1), (1, 2)], scale=[1, 0]), "scale of bond 1", "= 0.0", "positive"),
    "scatter": (lambda: row().bond_within(scale=LognormalScatter(-0.1, 1)), "variation", "= -0.1", "0.2"),
    "hold nobody": (lambda: row().hold([3], x=0), "hold", "= 3", "add_particles"),
    "hold z of discs": (lambda: row().hold([0], z=0.0), "hold, z", "no freedom z", "Leave it out"),
    "hold not finite": (lambda: row().hold([0, 1], x=[0, math.nan]), "hold, x: velocity of entry 1", "nan", "m/s"),
    "force": (lambda: row().apply([0], force=5.0), "apply, force", "direction", "2 numbers"),
    "force not finite": (lambda: row().apply([0], force=(math.inf, 0)), "apply", "inf", "N"),
    "anchor": (lambda: row().anchor([0], (0, 3), 0.0), "stiffness of spring 0", "= 0.0", "N/m"),
    "anchor length": (lambda: row().anchor([0], (0, 3), 1.0, -1.0), "length of spring 0", "= -1.0", "another"),
    "mask": (lambda: row().hold(np.array([True]), x=0), "hold", "mask of 1", "one per particle"),
    "no particle": (lambda: builder().build(), "particles", "no particle", "add_particles"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_refused_with_place_value_and_remedy(case):
    call, place, problem, remedy = REFUSED[case]
    with pytest.raises(InputError) as error:
        call()
    places = [one.place for one in getattr(error.value, "errors", [error.value])]
    assert any(place in one for one in places)
    assert problem in str(error.value)
    assert remedy in str(error.value)


def test_bond_farther_than_makes_sense():
    made = builder()
    made.add_particles([(0, 0), (9, 0)], 1.0, "rock")
    with pytest.raises(InputError, match=r"bond 0: particles 0 and 1 are 4.5 times .*at most 2 times"):
        made.bond([(1, 0)])


def test_several_errors_come_at_once():
    made = builder()
    with pytest.raises(InputErrors) as error:
        made.add_particles([(0, math.nan), (2, 0)], [1.0, -1.0], "rock")
    assert [one.place for one in error.value.errors] == ["position of particle 0", "radius of particle 1"]


def test_particles_in_one_another_are_counted_and_the_worst_is_shown():
    # overlaps of 0.5, 0.6 and 1.5 of the smaller radius: one is allowed
    made = spheres([(0, 0, 0), (1.5, 0, 0), (5, 0, 0), (6.4, 0, 0), (0, 9, 0), (0, 9.5, 0)])
    with pytest.raises(InputError) as error:
        made.build()
    message = str(error.value)
    assert "2 pairs of particles" in message
    assert "4 and 5 at (0, 9.25, 0) m with 1.5" in message
    assert "apart" in message


def test_bonded_particles_may_lie_in_one_another_where_the_bond_replaces_the_contact():
    made = builder()
    made.add_particles([(0, 0), (1.2, 0)], 1.0, "rock")
    made.bond([(0, 1)])
    assert made.build().bonds.tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("changed", "wrong"),
    [
        # the contact would hold kn u^2 / 2 of the larger kn after the break
        ({"normal_stiffness": 0.9e8}, "normal stiffness 9e+07 N/m is below the contact's 1e+08"),
        # the shear force handed over would hold F^2 / (2 ks) of the smaller ks
        ({"shear_stiffness": 5e7}, "shear stiffness 4e+07 N/m is below the bond's 5e+07"),
    ],
)
def test_bond_whose_break_creates_energy_is_refused(changed, wrong):
    made = row(bond=SPRINGS | changed)
    made.bond_within()
    with pytest.raises(InputError) as error:
        made.build()
    assert "bond of 'rock' and 'rock'" in error.value.place
    assert wrong in str(error.value)
    assert "create energy" in str(error.value)
    assert "same stiffness" in str(error.value)


@pytest.mark.parametrize(
    "changed", [{}, {"normal_stiffness": 4e8, "shear_stiffness": 8e7}, {"shear_stiffness": 3e7}]
)
def test_bond_whose_break_loses_energy_is_taken(changed):
    made = row(bond=SPRINGS | changed)
    made.bond_within()
    assert len(made.build().bonds) == 2


def test_memory_is_compared_before_anything_is_made(monkeypatch):
    monkeypatch.setattr(memory, "available_bytes", lambda: 1_000_000)
    with pytest.raises(InputError) as error:
        builder().add_particles(np.zeros((5000, 2)), 1.0, "rock")
    message = str(error.value)
    # 5000 discs of 700 B need 3.5 MB of 1 MB
    assert "5000 discs need about 0.0035 GB, and 0.001 GB are free" in message
    assert "1428 discs" in message


def test_memory_of_this_machine_is_known():
    free = memory.available_bytes()
    assert free is not None
    assert 1e7 < free < 1e14


def test_particles_behind_a_plane():
    made = row()
    made.add_wall(walls.plane("floor", (0, 0), (0, 1)))
    with pytest.raises(
        InputError, match=r"wall 'floor': 3 particles are behind .* particle 0 at .*Move the plane"
    ):
        made.build()


def test_wall_of_another_dimension_and_second_of_one_name():
    made = row()
    made.add_wall(walls.plane("floor", (0, 0, 0), (0, 0, 1)))
    with pytest.raises(InputError, match="wall 'floor'"):
        made.build()
    with pytest.raises(InputError, match=r"wall 'floor'.*already.*another name"):
        made.add_wall(walls.plane("floor", (0, -1), (0, 1)))


@pytest.mark.parametrize(
    ("first", "second", "parameters", "message"),
    [
        ("rock", "flor", {"friction_coefficient": 0.1}, r"no material or wall 'flor'.*'floor'"),
        ("floor", "floor", {"friction_coefficient": 0.1}, "walls do not touch"),
        ("rock", "rock", {"friction": 0.1}, r'friction.*"friction_coefficient"'),
        ("rock", "floor", {"friction_coefficient": -0.1}, r"'rock' and wall 'floor'.*-0.1.*not be negative"),
    ],
)
def test_overrides_of_unknown_pairs_or_parameters(first, second, parameters, message):
    made = row()
    made.add_wall(walls.plane("floor", (0, -1), (0, 1)))
    made.set_contact(first, second, **parameters)
    with pytest.raises(InputError, match=message):
        made.build()


def test_wall_override_for_an_unknown_material():
    made = row()
    made.add_wall(walls.plane("floor", (0, -1), (0, 1), contact={"rok": {"friction_coefficient": 0.1}}))
    with pytest.raises(InputError, match=r"wall 'floor', contact = 'rok'.*'rock'"):
        made.build()
