"""Shape of a deposit, on heaps whose shape is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.measure.deposit import main_body, measure_deposit, upper_side

R = 0.5


def row(start: float, count: int, height: float = R) -> np.ndarray:
    return np.stack([start + 2.0 * R * np.arange(count), np.full(count, height)], axis=1)


def test_block_that_slid_ten_metres() -> None:
    start = np.concatenate([row(0.0, 6, R), row(0.0, 6, 3.0 * R)]) + np.array([0.0, 5.0])
    now = start + np.array([10.0, -5.0])
    n = len(now)
    surface = np.array([[-5.0, 5.0], [6.0, 5.0], [6.1, 0.0], [40.0, 0.0]])
    found = measure_deposit(now, np.full(n, R), np.ones(n), start, surface=surface, downhill=1.0)
    assert found.front == pytest.approx(15.5)
    assert found.run_out == pytest.approx(10.0)
    assert found.fall_height == pytest.approx(5.0 + 4.0 * R)
    # the crest is the first of the highest discs
    assert found.reach == pytest.approx(15.5)
    assert found.angle_of_reach == pytest.approx(math.atan2(7.0, 15.5))
    assert found.travel_angle == pytest.approx(math.atan2(5.0, 10.0))
    assert found.height == pytest.approx(4.0 * R)
    assert found.loose == 0.0
    assert found.left_behind == 0.0


def test_the_same_to_the_left() -> None:
    start = row(0.0, 5) * (-1.0, 1.0)
    now = start + np.array([-3.0, 0.0])
    surface = np.array([[-40.0, 0.0], [5.0, 0.0]])
    found = measure_deposit(now, np.full(5, R), np.ones(5), start, surface=surface, downhill=-1.0)
    assert found.front == pytest.approx(-7.5)
    assert found.run_out == pytest.approx(3.0)


def test_what_flew_ahead_does_not_count() -> None:
    heap, lost = row(0.0, 20), np.array([[60.0, R]])
    places = np.concatenate([heap, lost])
    radii, mass = np.full(21, R), np.ones(21)
    assert main_body(places, radii).sum() == 20
    surface = np.array([[-5.0, 0.0], [99.0, 0.0]])
    found = measure_deposit(places, radii, mass, places - np.array([1.0, 0.0]), surface=surface, downhill=1.0)
    assert found.front == pytest.approx(19.5)
    assert found.loose == pytest.approx(1.0 / 21.0)


def test_upper_side_is_that_of_the_highest() -> None:
    places = np.concatenate([row(0.75, 12), row(0.75, 12, 3.0 * R)])
    line = upper_side(places, np.full(24, R))
    assert line[:, 1] == pytest.approx(np.full(len(line), 4.0 * R))
    assert (np.diff(line[:, 0]) > 0.0).all()
