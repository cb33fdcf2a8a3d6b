"""The Hertz-Mindlin contact with rolling resistance: made of two laws that are tested for themselves."""

import numpy as np
import pytest

from geodem.laws.contact import hertz_mindlin, hertz_mindlin_rolling
from geodem.laws.contact.hertz_mindlin_rolling import HertzMindlinRollingParameters, check, combine
from tests.contract.two_particles import Pair, no_motion

GIVEN = HertzMindlinRollingParameters(75e9, 0.5, 0.3, 0.1, 0.05)
RADII = (0.02, 0.02)
"""R* = 10 mm; at u = 0.1 mm Fn = 20/3 kN and ks = 200/3 N/um, so that ks R*^2 = 20/3 kN m/rad."""


def pressed():
    pair = Pair(hertz_mindlin_rolling, GIVEN, 3, radii=RADII)
    pair.step(no_motion(approach=1e-4))
    return pair


def test_springs_by_hand():
    pair = pressed()
    assert pair.stiffness() == pytest.approx((1e8, 2e8 / 3.0, 2e4 / 3.0, 2e4 / 3.0), rel=1e-12)
    answer = pair.step(no_motion(twist=3e-4, bend=np.array([0.0, 3e-4, 4e-4])))
    assert answer.twist_moment == pytest.approx(2.0, rel=1e-12)
    assert answer.bend_moment == pytest.approx([0.0, 2.0, 8.0 / 3.0], rel=1e-12)


def test_limits():
    """mu_r R* Fn = 20/3 N m and mu_t R* Fn = 10/3 N m."""
    answer = pressed().step(no_motion(twist=-1.0, bend=np.array([0.6, 0.0, 0.8])))
    assert answer.twist_moment == pytest.approx(-10.0 / 3.0, rel=1e-12)
    assert answer.bend_moment == pytest.approx([4.0, 0.0, 16.0 / 3.0], rel=1e-12)


def test_moments_shrink_with_the_contact():
    """Below their limits: unloaded to 0.81 of the overlap the contact's radius is 0.9 of what it was."""
    pair = pressed()
    charged = pair.step(no_motion(twist=1e-4, bend=np.array([2e-4, 0.0, 0.0])))
    left = pair.step(no_motion(approach=-0.19e-4))
    assert left.twist_moment == pytest.approx(0.9 * charged.twist_moment, rel=1e-12)
    assert left.bend_moment[0] == pytest.approx(0.9 * charged.bend_moment[0], rel=1e-12)


def test_without_rotation_it_is_the_hertz_mindlin_contact():
    rng = np.random.default_rng(9)
    plain = hertz_mindlin.HertzMindlinParameters(75e9, 0.2, 0.3, 0.6)
    rolling = HertzMindlinRollingParameters(75e9, 0.2, 0.3, 0.1, 0.1, 0.6)
    one, other = Pair(hertz_mindlin, plain, 3), Pair(hertz_mindlin_rolling, rolling, 3)
    for _ in range(50):
        motion = no_motion(approach=rng.normal() * 1e-5, slip=rng.normal(size=3) * 1e-6)
        assert np.array_equal(one.step(motion).vector(), other.step(motion).vector())
        assert one.energy() == other.energy()
        if one.alive:
            assert np.array_equal(one.viscous(motion), other.viscous(motion))


def test_two_materials():
    both = combine(GIVEN, GIVEN._replace(rolling_friction=0.02, twisting_friction=0.3))
    assert both == GIVEN._replace(rolling_friction=0.02)
    assert [fault.field for fault in check(GIVEN._replace(rolling_friction=-1.0))] == ["rolling_friction"]
