"""The elastic solve: equilibrium, two ways to it, and ground that nothing holds."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.integrators import direct_solve
from geodem.integrators.direct_solve import elastic_stress, solve_elastic, stiffness
from tests.meshes import mesh, model, slope, soil


@pytest.fixture(scope="module")
def ground():
    """A 2:1 slope of about 300 particles."""
    return slope(0.9)


def test_forces_balance(ground):
    moved, _ = solve_elastic(ground, ground.weight)
    residual = ground.weight.ravel() - stiffness(ground) @ moved.ravel()
    assert np.abs(residual[~ground.held.ravel()]).max() < 1e-9 * np.abs(ground.weight).max()
    # what holds the ground carries its weight: 220 m2 of 20 kN/m3
    reaction = -residual.reshape(-1, 2)[ground.held[:, 1], 1].sum()
    assert reaction == pytest.approx(220 * 20e3, rel=1e-9)


def test_stiffness_is_symmetric_and_lets_bodies_move(ground):
    matrix = stiffness(ground)
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    x, y = ground.positions.T
    for body in (np.column_stack([np.ones_like(x), 0 * x]), np.column_stack([-y, x])):
        assert np.abs(matrix @ body.ravel()).max() < 1e-10 * abs(matrix).max() * np.abs(body).max()


def test_stiffness_gives_the_energy_of_the_stress(ground):
    """u K u/2 is the strain energy of the stress points."""
    rng = np.random.default_rng(1)
    moved = rng.normal(size=(ground.particles, 2)) * 1e-3
    xx, yy, xy = elastic_stress(ground, moved).T
    # plane strain, E 50 MPa, nu 0.3: (1 + nu)/(2 E) ((1 - nu)(xx^2 + yy^2) - 2 nu xx yy + 2 xy^2)
    density = 1.3 / (2 * 50e6) * (0.7 * (xx**2 + yy**2) - 0.6 * xx * yy + 2 * xy**2)
    stored = 0.5 * moved.ravel() @ (stiffness(ground) @ moved.ravel())
    assert (density * ground.point_area).sum() == pytest.approx(stored, rel=1e-10)


def test_conjugate_gradients_agree(ground, monkeypatch):
    direct, stress = solve_elastic(ground, ground.weight)
    monkeypatch.setattr(direct_solve, "DIRECT_LIMIT", 0)
    iterated, other = solve_elastic(ground, ground.weight)
    assert np.abs(iterated - direct).max() < 1e-8 * np.abs(direct).max()
    assert np.abs(other - stress).max() < 1e-7 * np.abs(stress).max()


def test_the_answer_is_linear_in_the_load(ground):
    once, _ = solve_elastic(ground, ground.weight)
    thrice, _ = solve_elastic(ground, 3.0 * ground.weight)
    assert thrice == pytest.approx(3.0 * once, rel=1e-9, abs=1e-12 * np.abs(once).max())


def test_prescribed_displacements_are_met(ground):
    wanted = np.zeros((ground.particles, 2))
    wanted[ground.held[:, 1], 1] = -0.01
    moved, stress = solve_elastic(ground, np.zeros_like(wanted), prescribed=wanted)
    # the base goes down as one: so does everything, without stress
    assert moved[:, 1] == pytest.approx(np.full(ground.particles, -0.01), rel=1e-9)
    assert np.abs(stress).max() < 1e-9 * 50e6 * 0.01


@pytest.mark.parametrize("limit", [20_000, 0], ids=["direct", "conjugate gradients"])
@pytest.mark.parametrize("holding", ["nothing", "one side", "one of two parts"])
def test_ground_that_floats_is_refused(limit, holding, monkeypatch):
    monkeypatch.setattr(direct_solve, "DIRECT_LIMIT", limit)
    positions, triangles = mesh([(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)], 0.4)
    held = np.zeros_like(positions, dtype=bool)
    if holding == "one side":
        held[positions[:, 0] == 0.0, 0] = True
    if holding == "one of two parts":
        held[positions[:, 1] == 0.0] = True
        triangles = np.concatenate([triangles, triangles + len(positions)])
        positions = np.concatenate([positions, np.add(positions, (10.0, 0.0))])
        held = np.concatenate([held, np.zeros_like(held)])
    floating = model(positions, triangles, soil(), held=held)
    with pytest.raises(InputError, match="not held"):
        solve_elastic(floating, floating.weight)
