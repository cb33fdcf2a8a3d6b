"""Stress-carrying particles: strain and force of the model against what must hold for any mesh."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.ground import pressure_load
from geodem.integrators.direct_solve import elastic_stress, solve_elastic, strain_operators
from geodem.kernels import stress_particles
from geodem.model import triangle_areas
from tests.meshes import SLOPE, mesh, model, soil

BOX = ((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0))
LAYER = ((0.0, 0.75), (3.0, 0.75))


@pytest.fixture(scope="module")
def plain():
    """One material."""
    return model(*mesh(BOX, 0.25), soil())


@pytest.fixture(scope="module")
def layered():
    """Two materials of one stiffness, and a particle of the top that is split into sectors."""
    positions, triangles = mesh(BOX, 0.25, lines=[LAYER])
    material = (positions[triangles].mean(axis=1)[:, 1] > 0.75).astype(np.int32)
    edge = int(np.argmin(np.hypot(positions[:, 0] - 1.5, positions[:, 1] - 2.0)))
    boundary = np.isin(positions[:, 0], [0.0, 3.0]) | np.isin(positions[:, 1], [0.0, 2.0])
    held = np.repeat(boundary[:, None], 2, axis=1)
    return model(
        positions, triangles, [soil(), soil(c=1e3, phi=35.0)], material=material, held=held, split=[(edge, 4)]
    )


@pytest.fixture(params=["plain", "layered"])
def any_model(request):
    """Every kind of model."""
    return request.getfixturevalue(request.param)


def rows_of(sparse):
    return np.repeat(np.arange(len(sparse.start) - 1), np.diff(sparse.start))


def internal_force(any_model, stress):
    """Force (n, 2) of stresses (s, 3) by the compiled kernel's own text: a gather per particle."""
    count = any_model.particles
    force, sums = np.zeros((count, 2)), np.zeros((1 + count // 128, 4))
    four = np.column_stack([stress, np.zeros(len(stress))])
    stress_particles.move(
        four, *any_model.particle_gradient, np.zeros((count, 2)), np.zeros((count, 2)), 0.0,
        np.zeros((count, 2)), np.zeros((count, 2)), force, sums,
    )  # fmt: skip
    return force


def test_areas(any_model):
    assert any_model.point_area.sum() == pytest.approx(6.0, rel=1e-13)
    assert any_model.particle_area.sum() == pytest.approx(6.0, rel=1e-13)
    assert (any_model.point_area > 0.0).all()
    by_particle = np.bincount(any_model.point_particle, any_model.point_area)
    assert by_particle == pytest.approx(any_model.particle_area, rel=1e-13)


def test_the_layers_have_their_own_area(layered):
    by_material = np.bincount(layered.point_material, layered.point_area)
    assert by_material == pytest.approx([3.0 * 0.75, 3.0 * 1.25], rel=1e-12)
    on_the_line = np.flatnonzero(np.abs(layered.positions[:, 1] - 0.75) < 1e-12)
    for particle in on_the_line:
        assert set(layered.point_material[layered.point_particle == particle]) == {0, 1}


def test_a_split_particle_has_a_stress_in_every_sector(layered):
    edge = np.argmin(np.hypot(layered.positions[:, 0] - 1.5, layered.positions[:, 1] - 2.0))
    fan = (layered.triangles == edge).any(axis=1).sum()
    assert (layered.point_particle == edge).sum() == min(4, fan)


def test_weight(any_model):
    """20 kN/m3 times 6 m2, downwards."""
    assert any_model.weight.sum(axis=0) == pytest.approx([0.0, -120e3], rel=1e-9)


def test_a_stiff_shift_strains_nothing(any_model):
    """The gradients of every stress point add up to zero."""
    total = np.zeros((any_model.stress_points, 2))
    np.add.at(total, rows_of(any_model.point_gradient), any_model.point_gradient.vector)
    assert np.abs(total).max() < 1e-14


def test_every_linear_field_has_its_strain(any_model):
    gradient = np.array([[1.3e-3, 0.7e-3], [-0.4e-3, 2.1e-3]])
    moved = (any_model.positions @ gradient.T).ravel()
    xx, yy, shear = (operator @ moved / any_model.point_area for operator in strain_operators(any_model))
    assert xx == pytest.approx(np.full_like(xx, gradient[0, 0]), rel=1e-11)
    assert yy == pytest.approx(np.full_like(yy, gradient[1, 1]), rel=1e-11)
    assert shear == pytest.approx(np.full_like(shear, gradient[0, 1] + gradient[1, 0]), rel=1e-11)


def test_patch(layered):
    """The outline is moved linearly and everything inside is solved: strain and stress are uniform."""
    gradient = np.array([[1.3e-3, 0.7e-3], [-0.4e-3, 2.1e-3]])
    expected = layered.positions @ gradient.T
    moved, stress = solve_elastic(layered, np.zeros_like(expected), prescribed=expected)
    assert np.abs(moved - expected).max() < 1e-10 * np.abs(expected).max()
    # E 50 MPa, nu 0.3: lambda = 28.846 MPa, G = 19.231 MPa
    lame, shear = 50e6 * 0.3 / (1.3 * 0.4), 50e6 / 2.6
    volume = lame * np.trace(gradient)
    uniform = [
        volume + 2 * shear * gradient[0, 0],
        volume + 2 * shear * gradient[1, 1],
        shear * (gradient[0, 1] + gradient[1, 0]),
    ]
    assert np.abs(stress - uniform).max() < 1e-10 * np.abs(uniform).max()


def test_a_pressed_bar(plain):
    """Rollers left and below, 1 MPa on the right: uniform stress, the end moves by (1 - nu^2) p L/E."""
    positions = plain.positions
    held = np.zeros_like(positions, dtype=bool)
    held[positions[:, 0] == 0.0, 0] = True
    held[positions[:, 1] == 0.0, 1] = True
    right = np.flatnonzero(positions[:, 0] == 3.0)
    right = right[np.argsort(positions[right, 1])]
    load = pressure_load(positions, np.column_stack([right[:-1], right[1:]]), 1e6)
    bar = model(positions, plain.triangles, soil(), held=held, load=load)
    moved, stress = solve_elastic(bar, load)
    assert stress == pytest.approx(np.tile([-1e6, 0.0, 0.0], (len(stress), 1)), rel=0, abs=1e-3)
    assert moved[right, 0] == pytest.approx(np.full(len(right), -(1 - 0.3**2) * 1e6 * 3.0 / 50e6), rel=1e-9)


def test_action_is_reaction(any_model):
    stress = np.random.default_rng(1).normal(size=(any_model.stress_points, 3)) * 1e5
    force = internal_force(any_model, stress)
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * size
    x, y = any_model.positions.T
    assert abs((x * force[:, 1] - y * force[:, 0]).sum()) < 1e-12 * size


def test_force_is_the_transpose_of_strain(any_model):
    """Virtual work: force on a velocity is minus the stress on its strain."""
    rng = np.random.default_rng(2)
    stress = rng.normal(size=(any_model.stress_points, 3)) * 1e5
    velocity = rng.normal(size=(any_model.particles, 2))
    xx, yy, shear = (operator @ velocity.ravel() for operator in strain_operators(any_model))
    inner = (stress[:, 0] * xx + stress[:, 1] * yy + stress[:, 2] * shear).sum()
    outer = (internal_force(any_model, stress) * velocity).sum()
    assert outer == pytest.approx(-inner, rel=1e-11)


def test_both_gathers_hold_the_same_numbers(any_model):
    points, particles = any_model.point_gradient, any_model.particle_gradient
    by_point = sorted(zip(rows_of(points), points.column, *points.vector.T, strict=True))
    by_particle = sorted(zip(particles.column, rows_of(particles), *particles.vector.T, strict=True))
    assert by_point == by_particle


def test_triangles_have_their_area():
    positions, triangles = mesh(SLOPE, 1.0)
    # trapezium: base 32 m, top 12 m, 10 m high
    assert triangle_areas(positions, triangles).sum() == pytest.approx(220.0, rel=1e-12)
    assert triangle_areas(positions, triangles).min() > 0.0


def test_particle_mean(layered):
    mean = layered.particle_mean(np.column_stack([np.ones(layered.stress_points), layered.point_area]))
    assert mean[:, 0] == pytest.approx(np.ones(layered.particles), rel=1e-14)
    particle = int(layered.point_particle[np.argmax(np.bincount(layered.point_particle))])
    own = layered.point_area[layered.point_particle == particle]
    assert mean[particle, 1] == pytest.approx((own**2).sum() / own.sum(), rel=1e-12)


def test_elastic_stress_of_a_rotation_is_zero(any_model):
    """A small rotation is no strain."""
    spin = 1e-4 * np.column_stack([-any_model.positions[:, 1], any_model.positions[:, 0]])
    assert np.abs(elastic_stress(any_model, spin)).max() < 1e-10 * 50e6 * 1e-4
