"""One and two spheres against closed forms: reference/problems/fewbody.py."""

from __future__ import annotations

import math

import pytest

from reference.problems import fewbody, fewbody_laws, fewbody_motion
from tests.verification.rows import check


def test_hertz_gives_the_published_figures():
    """Chung & Ooi's test 2, to the digits that are printed."""
    for impact in fewbody.ON_PLANE.values():
        mass = impact.density * 4.0 / 3.0 * math.pi * 0.1**3
        modulus = 0.5 * impact.young / (1.0 - impact.poisson**2)
        assert fewbody.hertz(mass, 0.1, modulus, 0.2) == pytest.approx(impact[3:], rel=1e-3)


def test_two_spheres_meet():
    check(*fewbody.two_spheres("glass"))


@pytest.mark.parametrize("rigid", [False, True])
def test_sphere_meets_a_plane(rigid):
    check(*fewbody.on_plane("aluminium alloy", rigid=rigid))


@pytest.mark.parametrize(("asked", "finer"), [(0.05, 4), (0.2, 4), (0.4, 1), (0.8, 1)])
def test_restitution_is_the_one_asked_for(asked, finer):
    check(fewbody.restitution(asked, finer=finer))


@pytest.mark.parametrize("case", fewbody.OBLIQUE)
def test_oblique_impact_that_slides_all_through(case):
    angle, kept, spin = case
    # the table is that of the closed forms
    impulse = 0.092 * 1.98
    assert kept == pytest.approx(1.0 - impulse / math.tan(math.radians(angle)), abs=6e-5)
    assert spin == pytest.approx(2.5 * impulse * 3.9 * math.cos(math.radians(angle)) / 2.5e-3, abs=0.06)
    check(*fewbody.oblique(angle, kept, spin), *fewbody_laws.oblique(angle, kept, spin))


@pytest.mark.parametrize(("asked", "finer"), [(0.1, 4), (0.4, 1), (0.9, 1)])
def test_restitution_of_a_hertz_mindlin_contact(asked, finer):
    check(fewbody_laws.restitution(asked, finer=finer))


def test_rolling_resistance():
    check(fewbody_laws.spin_down("linear_rolling"), fewbody_laws.roll_down("linear_rolling"))


def test_pull_off():
    check(fewbody_laws.pull_off(10e-6, 25e-6))


def test_sliding_becomes_rolling():
    check(*fewbody_motion.slide_to_roll())


def test_spinning_ball_falls_on_a_plane():
    check(*fewbody_motion.spinning_impact())


def test_bounces():
    check(*fewbody_motion.bounces(count=2))


@pytest.mark.parametrize("counter", [True, False])
def test_two_spinning_balls_meet(counter):
    check(*fewbody_motion.spinning_pair(counter=counter))
