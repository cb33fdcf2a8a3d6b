"""The incremental contact: the same as the linear one from touch on, and never tensile."""

import numpy as np
import pytest

from geodem.laws.contact import linear_frictional, linear_incremental

KN, KS, MU = 1e6, 5e5, 0.3


def test_pressed_from_touch_it_is_the_linear_contact():
    rng = np.random.default_rng(1)
    overlap, history = 0.0, [0.0, 0.0, 0.0, 0.0]
    shear = [0.0, 0.0, 0.0]
    for approach in np.abs(rng.normal(size=50)) * 1e-5 * np.where(np.arange(50) < 25, 1.0, -0.5):
        overlap += approach
        slip = rng.normal(size=3) * 1e-4
        *forces, normal, x, y, z = linear_incremental.force(KN, KS, MU, approach, *slip, *history)
        history = [normal, x, y, z]
        expected = linear_frictional.force(KN, KS, MU, overlap, *slip, *shear)
        shear = expected[4:]
        assert forces == pytest.approx(expected[:4], rel=1e-9, abs=1e-9)
        assert forces == [normal, x, y, z]


def test_a_force_lost_at_zero_is_not_owed():
    """Drawn back by more than was pressed in, the force is 0 and not tensile; pressed again it starts at once."""
    history = (0.0, 0.0, 0.0, 0.0)
    normals = []
    for approach in (2e-4, -5e-4, 1e-4):
        history = linear_incremental.force(KN, KS, MU, approach, 0.0, 0.0, 0.0, *history)[4:]
        normals.append(history[0])
    assert normals == pytest.approx([200.0, 0.0, 100.0], rel=1e-12)


def test_without_normal_force_there_is_no_shear_force():
    answer = linear_incremental.force(KN, KS, MU, -1e-3, 1e-4, 0.0, 0.0, 200.0, 50.0, 0.0, 0.0)
    assert answer == (0.0,) * 8
