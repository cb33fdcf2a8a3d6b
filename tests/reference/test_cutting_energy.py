"""Scaling and picture of `reference run cutting-energy`; its cuts take minutes."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from reference.problems.cutting_energy import Ground
from reference.problems.cutting_picture import Line, draw


def test_depth_over_the_length_of_toughness():
    """K = 4 MPa sqrt(pi 0.5 mm), K/15 MPa squared is 0.1117 mm: 4 mm are 35.8 of them."""
    group = [SimpleNamespace(course=SimpleNamespace(placed=SimpleNamespace(diameter=1e-3)))]
    assert Ground("rock", 15e6, 4e6, {4.0: group}).lengths(4.0) == pytest.approx(4.0 / 0.11170, rel=1e-4)
    assert math.isnan(Ground("clay", 0.0, 0.0, {4.0: group}).lengths(4.0))


def test_picture(tmp_path):
    depth = np.array([1.0, 2.0, 4.0])
    scaled = [Line(name, depth, 1e6 * depth**-0.5, 10.0 * depth, depth**-0.5) for name in "abc"]
    clay = Line("clay", depth, np.full(3, 1e6), np.full(3, np.nan), np.ones(3))
    with Image.open(draw([clay, *scaled], tmp_path)) as picture:
        assert picture.width > 2 * picture.height
        assert np.asarray(picture.convert("L")).std() > 5.0
