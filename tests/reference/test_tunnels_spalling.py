"""The closed forms that a tunnel in hard rock is held against."""

from __future__ import annotations

import numpy as np
import pytest

from reference.problems.tunnels_spalling_kirsch import (
    kirsch_deviator,
    kirsch_hoop,
    kirsch_motion,
    plane_moduli,
)
from reference.problems.tunnels_spalling_onset import Laboratory, expected_load

PRESSURE = (10e6, 5e6)
MODULI = (50e9, 0.25)


def ring(r: float) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
    return r * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def test_hoop_stress_at_the_wall_is_three_times_one_pressure_less_the_other():
    found = kirsch_hoop(np.array([[1.0, 0.0], [0.0, 1.0], [1e4, 0.0]]), PRESSURE)
    assert found == pytest.approx([3 * 5e6 - 10e6, 3 * 10e6 - 5e6, 5e6], rel=1e-6)


def test_the_added_motion_carries_the_stress_that_the_hole_takes_away():
    """On the wall the strain of the motion has the hoop stress of Kirsch less the far field, and no pressure is left.

    The hoop strain of the wall, (u_r + du_t/dangle)/r, is hoop/E less nu/E times the radial stress; both with the far
    field taken away (Timoshenko & Goodier 1970, section 35).
    """
    step = 1e-6
    places = ring(1.0)
    angle = np.arctan2(places[:, 1], places[:, 0])
    out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=1)

    def turned(by: float) -> np.ndarray:
        moved = np.stack([np.cos(angle + by), np.sin(angle + by)], axis=1)
        return kirsch_motion(moved, PRESSURE, MODULI)

    def stretched(by: float) -> np.ndarray:
        return kirsch_motion((1.0 + by) * places, PRESSURE, MODULI)

    motion = kirsch_motion(places, PRESSURE, MODULI)
    hoop = ((turned(step) - turned(-step)) / (2 * step) * along).sum(axis=1)
    radial = ((stretched(step) - stretched(-step)) / (2 * step) * out).sum(axis=1)
    modulus, ratio = MODULI
    mean, half = 0.5 * sum(PRESSURE), 0.5 * (PRESSURE[0] - PRESSURE[1])
    far_hoop = -(mean - half * np.cos(2 * angle))
    far_radial = -(mean + half * np.cos(2 * angle))
    added_hoop = -kirsch_hoop(places, PRESSURE) - far_hoop
    assert hoop == pytest.approx(
        (added_hoop + ratio * far_radial) / modulus, abs=1e-8 * abs(hoop).max() + 1e-12
    )
    assert radial == pytest.approx(
        (-far_radial - ratio * added_hoop) / modulus, abs=1e-8 * abs(radial).max() + 1e-12
    )
    # excavated ground moves in everywhere under these pressures
    assert ((motion * out).sum(axis=1) < 0.0).all()


def test_moduli_of_a_state():
    modulus, ratio = 40e9, 0.2
    stress = np.diag([-3e6, -1e6])
    strain = np.diag([(-3e6 + 0.2 * 1e6) / modulus, (-1e6 + 0.2 * 3e6) / modulus])
    assert plane_moduli(strain, stress) == pytest.approx((modulus, ratio))


def test_principal_stresses_at_the_wall_and_under_even_pressure():
    wall, away = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([[2.0, 0.0], [0.0, 3.0]])
    assert kirsch_deviator(wall, PRESSURE) == pytest.approx(kirsch_hoop(wall, PRESSURE))
    # Lame: p (1 + 1/r^2) around, p (1 - 1/r^2) outwards
    assert kirsch_deviator(away, (10e6, 10e6)) == pytest.approx([2.0 * 10e6 / 4.0, 2.0 * 10e6 / 9.0])


def test_expected_cracks_under_even_pressure():
    """Where every second grain cracks at 60 MPa, those within r^2 = 2 p L/60 MPa of the middle do: Lame."""
    found = Laboratory(140e6, 60e6, np.full(500, 60e6), 1000, 0.0)
    count, grains = 300.0, 800.0
    area = count / (0.5 * grains)
    load = (1.0 + area / np.pi) * 60e6 / (2.0 * 10e6)
    assert expected_load(found, count, (10e6, 10e6), grains) == pytest.approx(load, rel=2e-3)
