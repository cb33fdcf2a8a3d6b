"""Periodic cells: what the list, the steps, the control and the reading must agree with from outside."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from geodem import _jit, particle_simulation
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.builders.random_packing import random_packing
from geodem.errors import InputError, InputErrors
from geodem.io.particle_frames import write_frame
from geodem.particle_recorder import history_columns, history_values
from geodem.particle_simulation import ParticleSimulation, Sleep
from geodem.particle_statics import find_equilibrium
from geodem.plotting.particles import draw_cell, draw_discs
from geodem.plotting.theme import new_figure

CONTACT = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.4}


@pytest.fixture(autouse=True)
def all_threads():
    yield
    _jit.set_threads(None)


def packed(dimension, *, count, shift=None, seed=1, vectors=None, **options):
    """A random packing, a little too dense to be without contacts, in a cell."""
    fraction = 0.84 if dimension == 2 else 0.63
    packing = random_packing(
        dimension, radius=0.01, size_ratio=1.5, count=count, solid_fraction=fraction, seed=seed
    )
    builder = AssemblyBuilder(dimension)
    builder.add_material("m", density=2500.0, contact=CONTACT)
    edges = np.diag(packing.box) if vectors is None else vectors(packing.box)
    places = packing.positions / packing.box @ edges
    builder.set_cell(edges)
    # a sheared lattice of places lies closer: it shrinks
    size = 0.9 if vectors is not None else 1.01
    if shift is not None:
        places = places + shift
    rng = np.random.default_rng(seed)
    velocity = rng.uniform(-0.01, 0.01, places.shape)
    builder.add_particles(places, packing.radii * size, "m", velocity=velocity)
    return ParticleSimulation(builder.build(), local_damping=0.1, **options)


def sheared(box):
    """Edges that lean by a third of the side before them."""
    edges = np.diag(box)
    for k in range(1, len(box)):
        edges[k, k - 1] = 0.3 * box[k - 1]
    return edges


def branches_by_brute_force(simulation, limit):
    """Pairs (particle numbers) nearer than `limit` of their radii, and their branches, over all images around."""
    edges = simulation.cell.vectors
    places, radii = simulation.positions, simulation.assembly.radii
    i, j = np.triu_indices(len(places), 1)
    share = (places[j] - places[i]) @ np.linalg.inv(edges)
    share -= np.floor(share)
    found = {}
    for image in itertools.product((-2, -1, 0, 1), repeat=len(edges)):
        branch = (share + image) @ edges
        near = np.sqrt((branch**2).sum(axis=1)) < radii[i] + radii[j] + limit
        for a, b, way in zip(i[near], j[near], branch[near], strict=True):
            assert (a, b) not in found
            found[int(a), int(b)] = way
    return found


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_are_the_nearest_images_in_a_sheared_cell(dimension):
    shift = np.random.default_rng(3).uniform(-3.0, 3.0, dimension)
    s = packed(dimension, count=500, vectors=sheared, shift=shift)
    expected = branches_by_brute_force(s, s.buffer)
    p, ids = s.pairs, s.arrays.ids
    assert len(expected) > 300
    assert p.pairs == len(expected)
    branches = s._branches(np.arange(p.pairs))
    for a, b, way in zip(ids[p.a], ids[p.b], branches, strict=True):
        assert np.allclose(way, expected[int(a), int(b)], atol=1e-12)
    assert (np.minimum(p.a, p.b) == p.listed_under()).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_where_the_cell_begins_changes_no_force(dimension):
    def forces(shift):
        s = packed(dimension, count=300, shift=shift, time_step=1e-5)
        s.set_strain_rate(-1.0)
        s.run(30)
        return s.forces, s.stress()

    size = packed(dimension, count=300).cell.vectors.max()
    here, stress = forces(None)
    there, same = forces(np.random.default_rng(7).uniform(-2.0, 2.0, dimension) * size)
    assert np.abs(here).max() > 1.0
    assert np.allclose(there, here, atol=1e-8 * np.abs(here).max())
    assert np.allclose(same, stress, rtol=1e-9, atol=1e-9 * np.abs(stress).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_cancel_while_the_cell_shears_on(dimension):
    s = packed(dimension, count=300)
    rate = np.zeros((dimension, dimension))
    rate[0, 1] = 0.8 / (4000 * s.time_step)
    s.set_strain_rate(rate)
    for _ in range(8):
        s.run(500)
        forces = s.forces[:, :dimension]
        assert np.allclose(forces.sum(axis=0), 0.0, atol=1e-10 * np.abs(forces).sum())
        assert np.abs(forces).max() > 1.0
    # far enough for other edges to be chosen
    gradient = s.deformation_gradient()
    assert gradient[0, 1] == pytest.approx(0.8, rel=1e-9)
    assert abs(s.cell.vectors[1, 0]) <= 0.55 * s.cell.vectors[0, 0]


def driven_by_stress(dimension, count):
    s = packed(dimension, count=count)
    s.set_target_stress(-2e4, largest_rate=2.0)
    return s


def same_state(first, second):
    for name in ("positions", "velocities", "spins", "forces"):
        assert np.array_equal(getattr(first, name), getattr(second, name))
    assert np.array_equal(first.cell.state, second.cell.state)


@pytest.mark.parametrize("dimension", [2, 3])
def test_same_bits_on_one_and_two_threads_and_after_resuming(dimension, tmp_path):
    found = []
    for threads in (1, 2):
        _jit.set_threads(threads)
        s = driven_by_stress(dimension, 1100)
        s.run(150)
        if threads == 2:
            s.save(tmp_path / "half.h5")
        s.run(150)
        found.append(s)
    same_state(*found)
    again = ParticleSimulation.resume(tmp_path / "half.h5")
    assert again.assembly.cell.periodic == (True,) * dimension
    again.run(150)
    same_state(found[1], again)


def test_blocks_give_what_pairs_one_by_one_give(monkeypatch):
    def after():
        s = packed(3, count=450)
        rate = np.diag([-0.5, 0.2, -0.1])
        rate[0, 1] = 0.3
        s.set_strain_rate(rate)
        s.run(100)
        return s

    blocks = after()
    monkeypatch.setattr(particle_simulation, "SERIAL_LIMIT", 1000)
    single = after()
    assert blocks.features.in_blocks()
    assert not single.features.in_blocks()
    assert np.allclose(blocks.forces, single.forces, atol=1e-9 * np.abs(single.forces).max())
    assert np.allclose(blocks.stress(), single.stress(), rtol=1e-9)
    assert np.abs(single.stress()).min() > 1.0


def regular(kind, strain):
    """A lattice strained by `strain` (d, d) from where its particles just touch."""
    dimension = 2 if kind == "hexagonal" else 3
    cells = (6, 4) if dimension == 2 else (3, 3, 3)
    packing = lattice(kind, 0.01, cells=cells)
    builder = AssemblyBuilder(dimension)
    builder.add_material("m", density=2500.0, contact=CONTACT)
    builder.set_cell(packing.box)
    builder.add_particles(packing.positions, packing.radii, "m")
    s = ParticleSimulation(builder.build(), local_damping=0.1)
    steps = 1000
    # the gradient whose steps lead to 1 + strain
    s.set_strain_rate(np.diag((1.0 + np.diag(strain)) ** (1.0 / steps) - 1.0) / s.time_step)
    s.run(steps + 1)
    return s


@pytest.mark.parametrize("kind", ["hexagonal", "fcc"])
def test_strain_moves_a_lattice_with_the_cell(kind):
    dimension = 2 if kind == "hexagonal" else 3
    strain = np.diag([-2e-3, -1e-3, -3e-3][:dimension])
    s = regular(kind, strain)
    # one step more, of which the contacts know nothing yet
    now = s.deformation_gradient()
    assert np.allclose(np.diag(now), np.exp(np.log1p(np.diag(strain)) * 1.001), rtol=1e-12)
    assert np.allclose(s.velocities, 0.0, atol=1e-9)
    assert np.allclose(s.positions, s.assembly.positions @ now.T, atol=1e-14)
    directions = s.contact_branches() @ np.linalg.inv(now).T
    lengths = np.linalg.norm(directions @ now.T, axis=1)
    assert np.allclose(np.linalg.norm(directions, axis=1), 0.02, rtol=1e-12)
    assert np.allclose(s.contacts().overlap, 0.02 - lengths, atol=1e-15)
    assert np.allclose(s.strain(), np.diag(np.log(np.diag(now))), atol=1e-12)


@pytest.mark.parametrize(("kind", "contacts"), [("hexagonal", 6), ("fcc", 12)])
def test_stress_of_a_lattice_under_uniform_strain_is_the_closed_form(kind, contacts):
    """Sum over contacts of kn (-n.e.n) d^2 n n/V; isotropic strain: sigma = z N kn d^2 e/(2 dim V), Walton 1987."""
    dimension = 2 if kind == "hexagonal" else 3
    shrink = -1e-5
    s = regular(kind, shrink * np.eye(dimension))
    number = s.assembly.particles
    expected = contacts * number * 1e6 * 0.02**2 * shrink / (2.0 * dimension * s.cell.volume)
    assert np.allclose(s.stress(), expected * np.eye(dimension), rtol=3e-3, atol=1e-9 * abs(expected))
    assert s.coordination_number() == s.coordination_number(rattlers=False) == contacts
    assert np.allclose(s.fabric_tensor(), np.eye(dimension) / dimension, atol=1e-12)
    # one step on, from the law and the branches
    assert np.allclose(s.stress(s.cell.volume), s.stress(), rtol=3e-3, atol=1e-6 * abs(expected))


def test_share_of_the_volume_and_wrapped_places():
    s = packed(2, count=300, shift=(5.0, -3.0))
    sides = np.diag(s.cell.vectors)
    assert s.solid_fraction() == pytest.approx(
        (math.pi * s.assembly.radii**2).sum() / sides.prod(), rel=1e-12
    )
    wrapped = s.wrapped_positions()
    assert ((wrapped >= 0.0) & (wrapped <= sides)).all()
    whole = (s.positions - wrapped) / sides
    assert np.allclose(whole, np.round(whole), atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_servo_reaches_its_stress_and_keeps_it(dimension):
    s = driven_by_stress(dimension, 300)
    s.run(4000)
    target = -2e4 * np.ones(dimension)
    assert np.allclose(np.diag(s.stress()), target, rtol=0.01)
    s.set_mean_stress(-4e4, largest_rate=2.0, axial=(0, -0.05))
    s.run(3000)
    assert np.trace(s.stress()) / dimension == pytest.approx(-4e4, rel=0.02)
    assert s.cell.velocity_gradient[0, 0] == -0.05


def bonded_builder(packing):
    """Strongly bonded discs in the cell of a packing, before they are bonded."""
    builder = AssemblyBuilder(2, bond_law="two_springs")
    strong = {"tensile_strength": 1e9, "cohesion": 1e9, "friction_coefficient": 0.4, "width_ratio": 1.0}
    builder.add_material("m", density=2500.0, contact=CONTACT, bond={**CONTACT, **strong})
    builder.set_cell(packing.box)
    builder.add_particles(packing.positions, packing.radii, "m")
    return builder


def test_bonds_reach_across_the_cell():
    """Hexagonal bonded discs under uniform strain: each bond carries kn d e, with or without images."""
    packing = lattice("hexagonal", 0.01, cells=(4, 3))
    builder = bonded_builder(packing)
    assert len(builder.bond_within(1.01)) == 3 * len(packing.radii)
    s = ParticleSimulation(builder.build())
    steps = 500
    s.set_strain_rate(1e-5 / (steps * s.time_step))
    s.run(steps + 1)
    expected = 6 * len(packing.radii) * 1e6 * 0.02**2 * 1e-5 / (4.0 * s.cell.volume)
    assert np.allclose(s.stress(), expected * np.eye(2), rtol=5e-3, atol=1e-9 * expected)


@pytest.fixture
def bonded_through_a_face():
    """Two discs on opposite sides of a leaning cell, bonded through the face between them; one is a cell away."""
    builder = AssemblyBuilder(2, bond_law="two_springs")
    strong = {"tensile_strength": 1e9, "cohesion": 1e9, "friction_coefficient": 0.4, "width_ratio": 1.0}
    builder.add_material("m", density=2500.0, contact=CONTACT, bond={**CONTACT, **strong})
    builder.set_cell([(0.1, 0.0), (0.03, 0.1)])
    builder.add_particles([(0.01, 0.01), (0.192, 0.01)], 0.01, "m")
    assert builder.bond_within(1.01).tolist() == [[0, 1]]
    return ParticleSimulation(builder.build(), time_step=1e-6)


def test_frames_hold_wrapped_particles_the_cell_and_contacts_through_its_faces(
    bonded_through_a_face, tmp_path
):
    pyvista = pytest.importorskip("pyvista")
    particles, contacts, *_ = write_frame(tmp_path, bonded_through_a_face)
    drawn = pyvista.read(particles)
    assert np.allclose(drawn.points[:, :2], [(0.01, 0.01), (0.092, 0.01)])
    assert np.allclose(drawn.field_data["cell edges [m]"], [(0.1, 0.0), (0.03, 0.1)])
    lines = pyvista.read(contacts)
    assert np.allclose(lines.points[:, :2], [(0.01, 0.01), (-0.008, 0.01)])
    assert lines.n_cells == 1


def test_pictures_show_the_cell_and_particles_in_it(bonded_through_a_face):
    figure = new_figure(7.7, 4.0)
    axes = figure.add_subplot()
    axes.set_xlim(0.0, 0.14)
    draw_discs(axes, bonded_through_a_face, np.ones((2, 4)))
    draw_cell(axes, bonded_through_a_face)
    assert np.allclose(axes.collections[0].get_offsets(), [(0.01, 0.01), (0.092, 0.01)])
    corners = {tuple(point) for line in axes.lines for point in np.round(line.get_xydata(), 12)}
    assert corners == {(0.0, 0.0), (0.1, 0.0), (0.03, 0.1), (0.13, 0.1)}
    assert len(axes.lines) == 4


def test_history_has_stress_and_strain(bonded_through_a_face):
    names, values = history_columns(bonded_through_a_face), history_values(bonded_through_a_face)
    assert len(names) == len(values)
    assert {"stress xy [Pa]", "strain yy [-]"} <= set(names)


def test_equilibrium_in_a_cell_that_is_held_is_the_same_solved_and_relaxed():
    packing = random_packing(2, radius=0.01, size_ratio=1.5, count=200, seed=1)

    def found(solve):
        builder = bonded_builder(packing)
        builder.bond_within(1.03)
        s = ParticleSimulation(builder.build())
        rate = 1e-4 / (100 * s.time_step)
        s.set_strain_rate([[0.0, rate], [0.0, 0.0]])
        s.run(100)
        vectors = s.cell.vectors
        end = find_equilibrium(s, tolerance=1e-8, solve=solve)
        assert end.reached
        assert (end.solves > 0) is solve
        assert np.array_equal(s.cell.vectors, vectors)
        assert s.cell.velocity_gradient[0, 1] == rate
        return s.stress()

    solved, relaxed = found(True), found(False)
    assert np.allclose(solved, relaxed, rtol=1e-5, atol=1e-6 * solved[0, 1])
    assert solved[0, 1] == pytest.approx(solved[1, 0], rel=1e-6)
    assert solved[0, 1] > 1.0


def test_slab_between_planes():
    """Periodic along x only: a row of discs on a floor, one stack of each column, carries its weight."""
    from geodem.boundaries.walls import plane

    builder = AssemblyBuilder(2, gravity=(0.0, -9.81))
    builder.add_material("m", density=2500.0, contact=CONTACT)
    builder.set_cell((0.12, 1.0), periodic=(True, False))
    x, y = np.meshgrid(0.02 * np.arange(6), 0.02 * np.arange(3) + 0.01)
    builder.add_particles(np.column_stack([x.ravel() + 1.0, y.ravel()]), 0.01, "m")
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    s = ParticleSimulation(builder.build(), local_damping=0.3)
    assert s.pairs.pairs >= 6 * 2 + 6 * 3
    # not so long that the columns roll away
    s.run(1500)
    weight = s.assembly.mass.sum() * 9.81
    assert s.wall_force("floor")[1] == pytest.approx(-weight, rel=1e-3)
    # the mean of the vertical stress in the slab: half the weight on the floor, at every height
    volume = 0.12 * 0.06
    assert s.stress(volume)[1, 1] == pytest.approx(-0.5 * weight / 0.12, rel=0.02)
    with pytest.raises(InputError, match="does not deform"):
        s.set_strain_rate(-1.0)
    s.set_strain_rate(0.0)


def small(dimension=2, **changed):
    builder = AssemblyBuilder(dimension)
    builder.add_material("m", density=2500.0, contact=CONTACT)
    builder.set_cell(changed.pop("vectors", (0.2,) * dimension), **changed)
    builder.add_particles(np.full((1, dimension), 0.05), 0.01, "m")
    return builder


@pytest.mark.parametrize(
    ("vectors", "options", "problem"),
    [
        ((1.0, 1.0, 1.0), {}, "does not hold the edges"),
        ("wide", {}, "not numbers"),
        ((1.0, math.inf), {}, "not finite"),
        ((1.0, -1.0), {}, "negative"),
        ([[0.0, 1.0], [1.0, 0.0]], {}, "left-handed"),
        ([[1.0, 1.0], [2.0, 2.0]], {}, "no volume"),
        ((1.0, 1.0), {"periodic": (True, True, True)}, "every edge"),
        ((1.0, 1.0), {"periodic": "yes"}, "every edge"),
        ((1.0, 1.0), {"periodic": (False, False)}, "no edge is periodic"),
        ((0.03, 1.0), {}, "thick"),
    ],
)
def test_cells_that_cannot_be_are_refused(vectors, options, problem):
    with pytest.raises(InputError, match=problem):
        small(vectors=vectors, **options).build()


def test_what_does_not_go_with_a_cell_is_refused():
    from geodem.boundaries.walls import plane, segments

    builder = small()
    builder.anchor([0], (0.05, 0.06), 1e3)
    builder.add_wall(plane("across", (0.0, 0.0), (0.0, 1.0)))
    builder.add_wall(segments("edge", [(0.1, 0.1), (0.15, 0.1)]))
    with pytest.raises(InputErrors, match="cuts an edge"):
        builder.build()
    with pytest.raises(InputError, match="skipped"):
        ParticleSimulation(small().build(), sleep=Sleep(1e-3))
    with pytest.raises(InputError, match="thick"):
        ParticleSimulation(small().build(), buffer=0.2)
    apart = AssemblyBuilder(2)
    apart.add_material("m", density=2500.0, contact=CONTACT)
    apart.add_particles([(0.0, 0.0)], 0.01, "m")
    with pytest.raises(InputError, match="no periodic cell"):
        ParticleSimulation(apart.build()).set_strain_rate(1.0)


def test_two_particles_in_one_another_through_a_face_are_refused():
    builder = small()
    builder.add_particles([(0.005, 0.0)], 0.01, "m")
    builder.add_particles([(0.199, 0.2)], 0.01, "m")
    with pytest.raises(InputError, match="in one another"):
        builder.build()


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda s: s.set_strain_rate((1.0, 1.0, 1.0)), "no tensor"),
        (lambda s: s.set_strain_rate(math.inf), "not finite"),
        (lambda s: s.set_target_stress([[1.0, 2.0], [3.0, 1.0]], largest_rate=1.0), "symmetric"),
        (lambda s: s.set_target_stress(-1.0, largest_rate=0.0), "no rate"),
        (lambda s: s.set_target_stress(-1.0, largest_rate=1.0, gain=-1.0), "no gain"),
        (lambda s: s.set_mean_stress(math.nan, largest_rate=1.0), "no finite stress"),
        (lambda s: s.set_mean_stress(-1.0, largest_rate=1.0, axial=(2, 1.0)), "no such axis"),
        (lambda s: s.set_mean_stress(-1.0, largest_rate=1.0, axial=(0, math.nan)), "no finite rate"),
    ],
)
def test_controls_that_cannot_be_are_refused(call, problem):
    s = ParticleSimulation(small().build(), time_step=1e-6)
    with pytest.raises(InputError, match=problem):
        call(s)


def test_a_cell_that_has_become_too_thin_ends_the_run():
    s = packed(2, count=300)
    s.cell.state[:2] *= 0.05
    with pytest.raises(InputError, match="thick"):
        s.search()


def test_the_gain_of_a_servo_follows_from_a_law_that_asks_for_masses():
    contact = {
        "young_modulus": 1e8, "poisson_ratio": 0.3, "friction_coefficient": 0.5, "restitution": 0.5,
        "characteristic_velocity": 1.0,
    }  # fmt: skip
    builder = AssemblyBuilder(3, contact_law="hooke")
    builder.add_material("grain", density=2600.0, contact=contact)
    places = 0.02 * np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3)
    builder.add_particles(places, 0.01, "grain")
    builder.set_cell([0.08, 0.08, 0.08])
    simulation = ParticleSimulation(builder.build(), orientation=False)
    simulation.set_target_stress([-1e3] * 3, largest_rate=1.0)
    assert np.isfinite(simulation.cell.state).all()
