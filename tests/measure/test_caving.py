"""Surfaces that sank, on discs whose places are known."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.measure.caving import drawn, subsidence

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
