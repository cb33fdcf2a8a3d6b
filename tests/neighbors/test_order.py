"""The order of rows along a Hilbert curve, and the displacement that asks for a new search."""

import math

import numpy as np
import pytest

from geodem.neighbors import max_displacement, spatial_order


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_curve_steps_from_cell_to_neighbouring_cell(dimension):
    """What a Hilbert curve is: through every cell once, each step to a cell with a common face."""
    side = 8
    cells = np.stack(np.meshgrid(*[np.arange(side)] * dimension), axis=-1).reshape(-1, dimension)
    cells = np.random.default_rng(0).permutation(cells)
    # the curve covers 16 cells along each axis, with these in the middle: three of its faces are cut off
    order = spatial_order(cells.astype(float), np.full(len(cells), 0.5), 7.0 / (side - 1))
    assert np.array_equal(np.sort(order), np.arange(len(cells)))
    steps = np.abs(np.diff(cells[order], axis=0)).sum(axis=1)
    assert np.mean(steps == 1) > 0.9


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cell_keeps_the_order_of_its_particles(dimension):
    rng = np.random.default_rng(1)
    positions = rng.uniform(0.0, 1.0, (500, dimension))
    crowded = np.repeat(positions, 3, axis=0)
    order = spatial_order(crowded, np.ones(1500), 1e-9).reshape(-1, 3)
    assert np.all(np.diff(order, axis=1) == 1)
    once = spatial_order(positions, np.ones(500), 0.1)
    again = spatial_order(positions[once], np.ones(500), 0.1)
    assert np.array_equal(again, np.arange(500))


@pytest.mark.parametrize("lost", [1e300, -1e300, np.nan, np.inf])
@pytest.mark.parametrize("dimension", [2, 3])
def test_lost_particles_do_not_spoil_the_order_of_the_others(dimension, lost):
    rng = np.random.default_rng(2)
    positions = rng.uniform(0.0, 30.0, (2000, dimension))
    positions[7] = lost
    order = spatial_order(positions, np.ones(2000))
    assert np.array_equal(np.sort(order), np.arange(2000))
    steps = np.linalg.norm(np.diff(positions[order[order != 7]], axis=0), axis=1)
    # in random order a step would be about half the box
    assert np.mean(steps) < 4.0


def test_no_particles_no_order():
    assert len(spatial_order(np.empty((0, 3)), np.empty(0))) == 0
    assert max_displacement(np.empty((0, 12)), np.empty((0, 3))) == 0.0


@pytest.mark.parametrize(("dimension", "width"), [(2, 8), (3, 12)])
@pytest.mark.parametrize("mover", [0, 2047, 2048, 9999])
def test_the_farthest_particle_counts(dimension, width, mover):
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(10000, width))
    reference = rows[:, :dimension].copy()
    assert max_displacement(rows, reference) == 0.0
    rows[:, 0] += 0.25
    rows[mover, 0] += 2.75
    rows[mover, 1] -= 4.0
    assert math.isclose(max_displacement(rows, reference), 5.0)
    rows[5000, 1] = np.nan
    assert math.isnan(max_displacement(rows, reference))
