"""Surfaces that sank, on discs whose places are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.measure.caving import Subsidence, drawn, subsidence, swelling

R = 0.5
GRID = np.stack(np.meshgrid(np.arange(20.0), np.arange(5.0), indexing="ij"), axis=-1).reshape(-1, 2) + R


def test_trough_of_known_shape() -> None:
    now = GRID.copy()
    now[:, 1] -= np.where(np.abs(GRID[:, 0] - 10.0) < 2.0, 1.5, 0.0)
    found = subsidence(GRID, np.full(100, R), now, np.full(100, R), columns=19)
    assert found.greatest == pytest.approx(1.5)
    assert found.centre == pytest.approx(10.0, abs=0.51)
    assert found.area == pytest.approx(4.0 * 1.5, rel=0.05)
    assert found.depth[[0, 1, -2, -1]] == pytest.approx(0.0)


def test_what_was_taken_away_sinks_the_surface_by_its_height() -> None:
    stays = ~((GRID[:, 0] < 4.0) & (GRID[:, 1] > 3.0))
    found = subsidence(GRID, np.full(100, R), GRID[stays], np.full(int(stays.sum()), R), columns=19)
    assert found.depth[:3] == pytest.approx(2.0)
    assert found.depth[5:] == pytest.approx(0.0)


def test_an_empty_column_is_no_number() -> None:
    stays = GRID[:, 0] > 6.0
    found = subsidence(GRID, np.full(100, R), GRID[stays], np.full(int(stays.sum()), R), columns=10)
    assert np.isnan(found.depth[0])
    assert found.greatest == pytest.approx(0.0)


def test_drawn_mass_and_too_few_columns() -> None:
    assert drawn(GRID, np.full(100, 2.0), 1.0) == pytest.approx(40.0)
    with pytest.raises(InputError, match="width"):
        subsidence(GRID, np.full(100, R), GRID, np.full(100, R), columns=1)


def test_angle_of_draw_on_either_side() -> None:
    """Gone 5 m outside an edge that is 10 m deep, straight in between: 5 % are left 4.75 m outside."""
    place = np.arange(30.0)
    depth = 2.0 * np.clip((place - 5.0) / 5.0, 0.0, 1.0)
    found = Subsidence(place, depth)
    assert found.angle_of_draw(10.0, 10.0) == pytest.approx(math.atan(4.75 / 10.0), abs=1e-12)
    mirrored = Subsidence(-place[::-1], depth[::-1])
    assert mirrored.angle_of_draw(-10.0, 10.0) == pytest.approx(math.atan(4.75 / 10.0), abs=1e-12)
    # where the surface over the opening stays up, the angle is below nothing
    assert found.angle_of_draw(3.0, 10.0) == pytest.approx(-math.atan(2.25 / 10.0), abs=1e-12)


def test_angles_that_cannot_be() -> None:
    flat = Subsidence(np.arange(5.0), np.zeros(5))
    with pytest.raises(InputError, match="nothing sank"):
        flat.angle_of_draw(2.0, 10.0)
    with pytest.raises(InputError, match="wider"):
        Subsidence(np.arange(5.0), np.array([1.0, 2.0, 3.0, 3.0, 3.0])).angle_of_draw(2.0, 10.0)
    with pytest.raises(InputError, match="depth"):
        flat.angle_of_draw(2.0, 0.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_rock_that_is_spread_out_swells(dimension: int) -> None:
    axes = np.meshgrid(*(np.arange(12.0),) * dimension, indexing="ij")
    dense = np.stack(axes, axis=-1).reshape(-1, dimension) + R
    radii = np.full(len(dense), R)
    loose = dense * 1.25
    found = swelling(
        dense, radii, np.array([[0.0] * dimension, [12.0] * dimension]),
        loose, radii, np.array([[0.0] * dimension, [15.0] * dimension]),
    )  # fmt: skip
    assert found == pytest.approx(1.25**dimension)
    box = np.array([[20.0] * dimension, [30.0] * dimension])
    with pytest.raises(InputError, match="no particle"):
        swelling(dense, radii, box, loose, radii, box)
