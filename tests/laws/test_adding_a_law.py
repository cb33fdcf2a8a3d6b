"""A contact law is added by one file and one registration: Hertz's spring, held to Chung & Ooi's first test."""

from __future__ import annotations

import importlib.util
import math

import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laws import CONTACT_LAWS
from geodem.laws.protocol import check_law
from geodem.particle_simulation import ParticleSimulation

LAW = '''
"""Hertz: F = 4/3 E* sqrt(R*) u^1.5, between equal spheres. Reference: Johnson 1985, Contact Mechanics, ch. 4."""

import math
from typing import NamedTuple

NAME = "hertz_alone"
DIMENSIONS = (3,)
SCALAR = ()
TANGENTIAL = ()
AXIAL = ()
MOMENT = False
VISCOUS = False


class HertzParameters(NamedTuple):
    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]


PARAMETERS = HertzParameters


def force(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Normal force [N]; no shear."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    pressed = overlap if overlap > 0.0 else 0.0
    return 4.0 / 3.0 * modulus * math.sqrt(radius * pressed) * pressed, 0.0, 0.0, 0.0


def energy(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Elastic energy [J]: 2/5 F u."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    return 8.0 / 15.0 * modulus * math.sqrt(radius * overlap) * overlap * overlap


def stiffness(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Tangent stiffness [N/m]."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    return 2.0 * modulus * math.sqrt(radius * overlap), 0.0, 0.0, 0.0


def combine(first, second):
    """Between equal materials."""
    return first


def against_rigid(parameters):
    """A rigid wall doubles the modulus."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters):
    """Nothing to find."""
    return []
'''

RADIUS = 0.01
SPEED = 10.0

# Chung & Ooi 2011, Granular Matter 13:643, test 1 (parameters); values of Hertz's theory
GLASS = (48e9, 0.2, 2800.0, 10.70e3, 274.1e-6, 40.3e-6)
LIMESTONE = (20e9, 0.25, 2500.0, 7.108e3, 368.3e-6, 54.2e-6)


@pytest.fixture
def hertz(tmp_path):
    path = tmp_path / "hertz_alone.py"
    path.write_text(LAW)
    spec = importlib.util.spec_from_file_location("hertz_alone", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    CONTACT_LAWS[module.NAME] = module  # the one registration
    yield module
    del CONTACT_LAWS[module.NAME]


def test_the_file_offers_what_a_law_must(hertz):
    check_law(hertz, "contact")


@pytest.mark.parametrize(
    ("young", "nu", "density", "peak", "approach", "duration"), [GLASS, LIMESTONE], ids=["glass", "limestone"]
)
def test_collision_of_two_spheres(hertz, young, nu, density, peak, approach, duration):
    step = duration / 1000.0
    builder = AssemblyBuilder(3, "hertz_alone")
    builder.add_material("m", density=density, contact={"young_modulus": young, "poisson_ratio": nu})
    gap = 2.0 * SPEED * step  # they touch after one step
    builder.add_particles(
        [[0, 0, 0], [2 * RADIUS + gap, 0, 0]], RADIUS, "m", velocity=[[SPEED, 0, 0], [-SPEED, 0, 0]]
    )
    simulation = ParticleSimulation(builder.build(), time_step=step, energy=True)
    largest, deepest, begun, ended = 0.0, 0.0, None, None
    while ended is None:
        simulation.run(1)
        force = float(simulation.forces[1, 0])
        largest = max(largest, force)
        distance = float(simulation.positions[1, 0] - simulation.positions[0, 0])
        deepest = max(deepest, 2 * RADIUS - distance)
        if force > 0.0 and begun is None:
            begun = simulation.time
        if begun is not None and force == 0.0:
            ended = simulation.time
        assert simulation.steps < 3000
    assert begun is not None
    assert largest == pytest.approx(peak, rel=5e-3)
    assert deepest == pytest.approx(approach, rel=5e-3)
    assert ended - begun == pytest.approx(duration, rel=5e-3)
    assert simulation.velocities[1, 0] == pytest.approx(SPEED, rel=1e-4)
    assert math.fabs(simulation.energy().imbalance) < 1e-3
