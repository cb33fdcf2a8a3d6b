"""What is drawn through an opening, in its closed form and in a handful of grains."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference.problems.caving_draw import EDGES, LEVELS, drawn, spreading, zone


def test_the_zone_holds_what_was_drawn():
    """Area and greatest width of x^2 = 6 B y ln(H/y), by sums over it."""
    area, b = 900.0, 2.24
    height, width = zone(area, b)
    y = (np.arange(200_000) + 0.5) / 200_000 * height
    wide = 2.0 * np.sqrt(6.0 * b * y * np.log(height / y))
    assert wide.mean() * height == pytest.approx(area, rel=1e-4)
    assert wide.max() == pytest.approx(width, rel=1e-6)
    assert y[wide.argmax()] == pytest.approx(height / math.e, rel=1e-2)


def test_a_gauss_curve_gives_its_own_spreading():
    middles = 0.5 * (EDGES[1:] + EDGES[:-1])
    speed = np.array([0.3 / math.sqrt(y) * np.exp(-(middles**2) / (4.0 * 1.7 * y)) for y in LEVELS])
    assert spreading(speed) == pytest.approx(1.7, rel=1e-6)


def test_what_leaves_a_box_of_grains_is_what_it_loses():
    found = drawn(1, wide=12.0, high=17.0)
    before, left, taken = found.masses
    assert left + taken == pytest.approx(before, rel=1e-12)
    # what is below the floor, and not yet taken away, is drawn too
    share = (found.radii**2)[found.gone].sum() / (found.radii**2).sum()
    assert taken / before <= share
    assert 0.25 <= share < 0.6
    # it comes from above the opening, in the middle
    assert abs(found.start[found.gone, 0].mean()) < 2.0
