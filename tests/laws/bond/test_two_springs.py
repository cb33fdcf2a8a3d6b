"""The bond of DICE2D against its book, summed up step by step as it is written there."""

import numpy as np
import pytest

from geodem.laws.bond import two_springs
from tests.contract.two_particles import RADIUS_A, RADIUS_B, Motion, Pair, elastic_parameters


def test_the_books_increments_sum_up_to_the_same_forces():
    """Zhao 2015, eqs 1.18-1.19, 1.22-1.25: increments of the springs, the moment and the shear force."""
    parameters = elastic_parameters(two_springs)
    kn, ks = parameters.normal_stiffness, parameters.shear_stiffness
    db = parameters.width_ratio * 2.0 * min(RADIUS_A, RADIUS_B)
    pair = Pair(two_springs, parameters, 2)
    rng = np.random.default_rng(1)
    upper = lower = moment = shear = 0.0
    for _ in range(200):
        approach, slip, turn = rng.normal(size=3) * (1e-6, 1e-6, 1e-4)
        upper += 0.5 * kn * approach + 0.25 * turn * db * kn
        lower += 0.5 * kn * approach - 0.25 * turn * db * kn
        moment += 0.25 * turn * db**2 * kn
        shear += ks * slip
        answer = pair.step(Motion(approach, np.array([slip, 0, 0]), 0.0, np.array([turn, 0, 0])))
    assert answer.normal == pytest.approx(upper + lower, rel=1e-10)
    assert answer.shear[0] == pytest.approx(shear, rel=1e-10)
    assert answer.bend_moment[0] == pytest.approx(moment, rel=1e-10)
    # the moment is that of the two springs about the middle between them
    assert answer.bend_moment[0] == pytest.approx((upper - lower) * db / 2.0, rel=1e-10)
    # the energy of the springs, each half as stiff: F^2/(2 kn/2), and of the shear spring
    springs = (upper**2 + lower**2) / kn + shear**2 / (2.0 * ks)
    assert pair.energy() == pytest.approx(springs, rel=1e-10)


def test_without_width_there_is_no_moment():
    parameters = elastic_parameters(two_springs)._replace(width_ratio=0.0)
    pair = Pair(two_springs, parameters, 2)
    answer = pair.step(Motion(0.0, np.zeros(3), 0.0, np.array([0.1, 0.0, 0.0])))
    assert answer.bend_moment[0] == 0.0
    assert pair.stiffness()[3] == 0.0
