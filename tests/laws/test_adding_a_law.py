"""A contact law is added by one file and one registration: a spring whose force goes with the overlap squared."""

from __future__ import annotations

import importlib.util
import math

import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laws import CONTACT_LAWS
from geodem.laws.protocol import check_law
from geodem.particle_simulation import ParticleSimulation

LAW = '''
"""A blunt tip: F = k u^2, as of a rigid cone on an elastic half-space. Reference: Sneddon 1965."""

from typing import NamedTuple

NAME = "cone"
DIMENSIONS = (3,)
SCALAR = ()
TANGENTIAL = ()
AXIAL = ()
MOMENT = False
VISCOUS = False


class ConeParameters(NamedTuple):
    rigidity: float  # k [N/m2]


PARAMETERS = ConeParameters


def force(rigidity, overlap):
    """Normal force [N]; no shear."""
    return rigidity * overlap * overlap, 0.0, 0.0, 0.0


def energy(rigidity, overlap):
    """Elastic energy [J]."""
    return rigidity * overlap * overlap * overlap / 3.0


def stiffness(rigidity, overlap):
    """Tangent stiffness [N/m]."""
    return 2.0 * rigidity * overlap, 0.0, 0.0, 0.0


def combine(first, second):
    """Between equal materials."""
    return first


def against_rigid(parameters):
    """A wall like any other."""
    return parameters


def check(parameters):
    """Nothing to find."""
    return []
'''

RADIUS, SPEED, RIGIDITY = 0.01, 2.0, 1e12
MASS = 2500.0 * 4.0 / 3.0 * math.pi * RADIUS**3


@pytest.fixture
def cone(tmp_path):
    path = tmp_path / "cone.py"
    path.write_text(LAW)
    spec = importlib.util.spec_from_file_location("cone", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    CONTACT_LAWS[module.NAME] = module  # the one registration
    yield module
    del CONTACT_LAWS[module.NAME]


def test_the_file_offers_what_a_law_must(cone):
    check_law(cone, "contact")


def test_collision_of_two_spheres(cone):
    """m*/2 w^2 = k u^3/3 gives the depth u; from there duration = 2 u/w times the integral of 1/sqrt(1 - x^3)."""
    meeting, reduced = 2.0 * SPEED, 0.5 * MASS
    depth = (1.5 * reduced * meeting**2 / RIGIDITY) ** (1.0 / 3.0)
    duration = 2.0 * depth / meeting * math.sqrt(math.pi) * math.gamma(4.0 / 3.0) / math.gamma(5.0 / 6.0)
    step = duration / 1000.0
    builder = AssemblyBuilder(3, "cone")
    builder.add_material("m", density=2500.0, contact={"rigidity": RIGIDITY})
    gap = meeting * step  # they touch after one step
    builder.add_particles(
        [[0, 0, 0], [2 * RADIUS + gap, 0, 0]], RADIUS, "m", velocity=[[SPEED, 0, 0], [-SPEED, 0, 0]]
    )
    simulation = ParticleSimulation(builder.build(), time_step=step, energy=True)
    forces = []
    for _ in range(1020):
        simulation.run(1)
        forces.append(float(simulation.forces[1, 0]))
    assert max(forces) == pytest.approx(RIGIDITY * depth**2, rel=1e-3)
    assert sum(force > 0.0 for force in forces) * step == pytest.approx(duration, rel=2e-3)
    assert simulation.velocities[1, 0] == pytest.approx(SPEED, rel=1e-4)
    assert math.fabs(simulation.energy().imbalance) < 1e-3
