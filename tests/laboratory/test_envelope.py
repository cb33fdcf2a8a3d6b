"""Envelopes through strengths that follow a known law."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.envelope import fit_envelope

SIDES = np.array([0.0, 5e6, 10e6, 20e6, 40e6])


def mohr_coulomb(friction, cohesion, sides):
    """Jaeger, Cook & Zimmerman (2007), eq. 4.22."""
    slope = (1.0 + math.sin(friction)) / (1.0 - math.sin(friction))
    return 2.0 * cohesion * math.sqrt(slope) + slope * sides


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, 60.0])
def test_straight_envelope_gives_its_friction_and_cohesion_back(degrees):
    friction = math.radians(degrees)
    found = fit_envelope(SIDES, mohr_coulomb(friction, 12e6, SIDES))
    assert found.friction_angle == pytest.approx(friction, abs=1e-7)
    assert found.cohesion == pytest.approx(12e6, rel=1e-9)
    assert found.intercept == pytest.approx(mohr_coulomb(friction, 12e6, 0.0), rel=1e-9)
    assert found.misfit == pytest.approx(0.0, abs=1e-9)


def test_curve_of_hoek_and_brown_gives_its_constant_back():
    # Lac du Bonnet granite: m_i about 30, 200 MPa
    strength = SIDES + np.sqrt(30.0 * 200e6 * SIDES + 200e6**2)
    found = fit_envelope(SIDES, strength)
    # the curve begins at UCS, the straight line above it: m_i refers to the line
    assert found.intercept > 200e6
    assert 0.0 < found.misfit < 0.05
    narrow = np.array([0.0, 1e3])
    exact = fit_envelope(narrow, narrow + np.sqrt(30.0 * 200e6 * narrow + 200e6**2))
    assert exact.m_i == pytest.approx(30.0, rel=1e-3)


def test_two_points_are_enough_and_more_at_one_confinement_count():
    two = fit_envelope([0.0, 10e6], [100e6, 150e6])
    assert two.friction_angle == pytest.approx(math.asin(4.0 / 6.0))
    three = fit_envelope([0.0, 0.0, 10e6], [90e6, 110e6, 150e6])
    assert three.friction_angle == pytest.approx(two.friction_angle)


def test_one_confinement_gives_no_friction():
    with pytest.raises(InputError, match="one confinement"):
        fit_envelope([5e6, 5e6], [100e6, 110e6])


def test_strength_that_hardly_rises_has_no_friction_angle():
    with pytest.raises(InputError, match="rises by less than the confinement"):
        fit_envelope([0.0, 10e6], [100e6, 105e6])
