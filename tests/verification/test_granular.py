"""What the problems of granular flow are made of: reference/problems/granular.py; the flows run there."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference.problems import granular_column as column
from reference.problems import granular_hopper as hopper
from reference.problems import granular_silo as silo
from reference.problems.granular_grains import exponent


def test_formulae_give_the_worked_figures():
    """A silo of 0.2 m, mu = K = 0.5; a hole of 20 mm for grains of 2 mm; both at 1500 kg/m3."""
    assert silo.saturation(1500.0, 0.2, 0.5, 0.5) == pytest.approx(2943.0, rel=1e-12)
    assert hopper.beverloo(0.02, 1500.0, 0.002) == pytest.approx(0.1027, abs=5e-5)


def test_hole_has_the_area_of_its_circle():
    opening = 0.006
    corners = hopper.annulus(opening)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert len(np.unique(np.sign(across[:, 2]))) == 1
    whole = 0.5 * hopper.CORNERS * math.sin(2.0 * math.pi / hopper.CORNERS) * (1.5 * hopper.WIDTH) ** 2
    left_open = whole - 0.5 * np.abs(across[:, 2]).sum()
    assert left_open == pytest.approx(math.pi * opening**2 / 4.0, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_column_is_upright_and_its_floor_level(dimension):
    wide = column.half_width(dimension, 2.0, 300)
    places, radii = column.packing(dimension, wide, 2.0 * wide, seed=1)
    # loose grains may stick into walls a little, which is gone once they have settled
    assert (places[:, -1] > 0.9 * radii).all()
    aside = np.abs(places[:, 0]) if dimension == 2 else np.hypot(*places[:, :2].T)
    # a prism of 16 sides has its corners outside the circle
    assert (aside + 0.9 * radii < wide / math.cos(math.pi / column.SIDES)).all()
    floor, held = column.floor(dimension, 2.0 * wide, np.random.default_rng(1))
    np.testing.assert_allclose(floor[:, -1] + held, 0.0, atol=1e-18)


def test_exponent_of_a_power_law():
    x = np.array([4.0, 7.0, 12.0])
    assert exponent(x, 3.0 * x ** (2.0 / 3.0)) == pytest.approx(2.0 / 3.0, rel=1e-12)
