"""Mean stress in circles and spheres, against lines whose share inside is plain and bodies in a known state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.measure.region_stress import share_inside, stress_in_box, stress_in_region
from geodem.measure.stress import stress_of_contacts


def test_the_share_of_a_line_is_its_chord():
    starts = np.array([[-2.0, 0.0], [0.0, 0.0], [-2.0, 0.6], [-2.0, 1.5], [0.1, 0.1], [3.0, 0.0]])
    branches = np.array([[4.0, 0.0], [4.0, 0.0], [4.0, 0.0], [4.0, 0.0], [0.2, 0.1], [1.0, 0.0]])
    # chords of a circle of radius 1: the diameter, a radius, 2 sqrt(1 - 0.36), none, all of it, none
    expected = [2.0 / 4.0, 1.0 / 4.0, 1.6 / 4.0, 0.0, 1.0, 0.0]
    assert np.allclose(share_inside(starts, branches, np.zeros(2), 1.0), expected, atol=1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_grid_of_rods_has_the_stress_of_its_forces_wherever_the_region_lies(dimension):
    # rods along x with a force of 1 each in a spacing of 1: stress 1 along x, up to the grain of the grid
    side = np.arange(-20.0, 21.0)
    grid = np.stack(np.meshgrid(*[side] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    along = np.eye(dimension)[0]
    branches = np.tile(along, (len(grid), 1))
    rng = np.random.default_rng(1)
    found = [
        stress_in_region(branches, grid, branches, rng.uniform(-1.0, 1.0, dimension), 12.0) for _ in range(20)
    ]
    assert np.allclose(np.mean(found, axis=0), np.outer(along, along), atol=2e-3)


def test_shares_of_regions_that_hold_everything_are_the_whole():
    rng = np.random.default_rng(2)
    starts, branches, forces = rng.normal(size=(3, 50, 3))
    volume = 4.0 / 3.0 * math.pi * 100.0**3
    assert np.allclose(
        stress_in_region(forces, starts, branches, np.zeros(3), 100.0),
        stress_of_contacts(forces, branches, volume),
    )


def test_what_does_not_belong_together_is_refused():
    with pytest.raises(InputError, match="do not belong"):
        stress_in_region(np.zeros((2, 2)), np.zeros((3, 2)), np.zeros((2, 2)), np.zeros(2), 1.0)
    with pytest.raises(InputError, match="no radius"):
        stress_in_region(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2)), np.zeros(2), -1.0)


def test_boxes_share_out_the_stress_of_all():
    """Boxes that fill a body have its stress between them, whatever lines cross their faces."""
    rng = np.random.default_rng(4)
    starts = rng.uniform(0.0, 4.0, (200, 3))
    branches = rng.uniform(0.0, 4.0, (200, 3)) - starts
    branches[:20, 0] = 0.0
    forces = rng.standard_normal((200, 3))
    whole = stress_of_contacts(forces, branches, 64.0)
    edges = np.linspace(0.0, 4.0, 3)
    corners = np.stack(np.meshgrid(edges[:-1], edges[:-1], edges[:-1]), axis=-1).reshape(-1, 3)
    parts = [stress_in_box(forces, starts, branches, low, low + 2.0) for low in corners]
    assert np.mean(parts, axis=0) == pytest.approx(whole, rel=1e-12, abs=1e-12)


def test_corners_that_bound_no_box_are_refused():
    with pytest.raises(InputError, match="corners"):
        stress_in_box(np.ones((1, 2)), np.zeros((1, 2)), np.ones((1, 2)), (1.0, 0.0), (0.0, 1.0))
