"""The linear contact with rolling resistance: its stiffness and limits by hand, and a ball on a slope."""

import math

import numpy as np
import pytest

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laws.contact import linear_rolling
from geodem.laws.contact.linear_rolling import LinearRollingParameters
from geodem.particle_simulation import ParticleSimulation
from tests.contract.two_particles import Pair, no_motion

GIVEN = LinearRollingParameters(1e7, 4e6, 0.5, 0.1, 0.05)
RADII = (0.03, 0.06)
"""R* = 20 mm."""


def pressed(dimension=3):
    pair = Pair(linear_rolling, GIVEN, dimension, radii=RADII)
    pair.step(no_motion(approach=1e-5))
    return pair


def test_springs_by_hand():
    """Fn = 100 N; ks R*^2 = 1,600 N m/rad."""
    pair = pressed()
    assert pair.stiffness() == pytest.approx((1e7, 4e6, 1600.0, 1600.0), rel=1e-14)
    answer = pair.step(no_motion(twist=3e-5, bend=np.array([0.0, 6e-5, 8e-5])))
    assert answer.twist_moment == pytest.approx(0.048, rel=1e-12)
    assert answer.bend_moment == pytest.approx([0.0, 0.096, 0.128], rel=1e-12)
    elastic = 0.5 * (1e7 * 1e-10 + (0.16**2 + 0.048**2) / 1600.0)
    assert pair.energy() == pytest.approx(elastic, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_limits(sign):
    """mu_r R* Fn = 0.2 N m and mu_t R* Fn = 0.1 N m."""
    answer = pressed().step(no_motion(twist=sign, bend=sign * np.array([0.6, 0.0, 0.8])))
    assert answer.twist_moment == pytest.approx(sign * 0.1, rel=1e-12)
    assert answer.bend_moment == pytest.approx(sign * np.array([0.12, 0.0, 0.16]), rel=1e-12)


def test_rolling_back_is_elastic_at_first():
    """From its limit the moment falls by 1,600 N m a radian."""
    pair = pressed(2)
    pair.step(no_motion(bend=np.array([0.3, 0.0, 0.0])))
    back = pair.step(no_motion(bend=np.array([-1e-4, 0.0, 0.0])))
    assert back.bend_moment[0] == pytest.approx(0.2 - 0.16, rel=1e-12)


@pytest.mark.parametrize(("slope", "rolls"), [(0.09, False), (0.14, True)])
def test_a_disc_on_a_slope(slope, rolls):
    """It stands up to tan(beta) = mu_r; steeper it rolls with a = g (sin - mu_r cos)/(1 + 1/2), for discs."""
    radius, mass = 0.03, math.pi * 0.03**2 * 2000.0
    angle = math.atan(slope)
    down = np.array([math.sin(angle), -math.cos(angle)])
    builder = AssemblyBuilder(2, "linear_rolling", gravity=9.81 * down)
    normal = mass * 9.81 / (1e-4 * radius)
    contact = LinearRollingParameters(normal, normal, 0.5, 0.1, 0.0, 1e-4, 1e-4)
    builder.add_material("disc", density=2000.0, contact=contact._asdict())
    sunk = 0.5e-4 * math.cos(angle)
    builder.add_particles([[0.0, radius * (1.0 - sunk)]], radius, "disc")
    builder.add_wall(plane("slope", (0.0, 0.0), (0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), local_damping=0.0)
    steps = int(0.5 / simulation.time_step)
    simulation.run(steps)
    speed = float(simulation.velocities[0, 0])
    if rolls:
        expected = 9.81 * (math.sin(angle) - 0.1 * math.cos(angle)) / 1.5 * simulation.time
        assert speed == pytest.approx(expected, rel=0.02)
        assert simulation.spins[0, 0] == pytest.approx(-speed / radius, rel=1e-2)
    else:
        assert abs(speed) < 1e-4
