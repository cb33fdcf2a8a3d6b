"""A specimen with one joint through it, compressed under pressure: Jaeger's plane of weakness.

With beta between the joint's normal and the axis, the stresses on the joint are
sigma_n = sigma3 + (sigma1 - sigma3) cos(beta)^2 and tau = (sigma1 - sigma3) sin(beta) cos(beta). Coulomb's
tau = c + sigma_n tan(phi) gives

    sigma1 = sigma3 + 2 (c + sigma3 tan(phi)) / ((1 - tan(phi)/tan(beta)) sin(2 beta)),    beta > phi.

Where that is more than the strength of the rock, or there is no such angle, the rock breaks as if there were no joint.
Source: Jaeger 1960, Shear failure of anisotropic rocks, Geol. Mag. 97:65.

The side of a specimen is a row of particles, so a joint ends half a particle within: under pressure alone, without
cohesion, a specimen 20 particles wide slides some 10 % too early at 60 degrees. Specimens here have cohesion, and all
of it stays, as the formula has it.

Strength is the largest axial stress, of a joint as of rock. While the joint slides the halves shift and bear on less
than the whole joint: at 40 degrees the stress stands at 1.02 of the formula from 1.1 to 1.4 times the strain of
sliding, and has fallen by 10 % at twice that strain, in rock three times as strong too.

Where the joint slides at nearly the strength of the rock, here from 36 to 39 degrees, both fail together. These angles
are left out. Near them rock breaks along the joint long before the joint slides, so the specimen is to be driven
slowly: at a third of the pace 40 degrees came out 17 % too strong.
"""

from __future__ import annotations

import math
import time
from functools import cache

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.joints import plane
from geodem.laboratory.axial import compress
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import Specimen, make_specimen

from .rows import Row, relative

ANGLES = (0.0, 15.0, 30.0, 40.0, 45.0, 52.5, 60.0, 70.0, 90.0)
FRICTION = math.radians(30.0)
COHESION = 10e6
CONFINEMENT = 5e6
STIFFNESS = 5e12
"""Of the joint: closes a hundredth of a particle [Pa/m]."""
STEPS = 340.0
"""To the strain of sliding, per particle of height."""
SOURCE = "Jaeger 1960, Geol. Mag. 97:65"

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=20e6, shear_strength=60e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip


def sliding_strength(angle: float) -> float:
    """sigma1 [Pa] at which the joint slides; infinite where it cannot. `angle` in degrees."""
    beta = math.radians(angle)
    if not FRICTION < beta < 0.5 * math.pi * (1.0 - 1e-9):
        return math.inf
    strength = 2.0 * (COHESION + CONFINEMENT * math.tan(FRICTION))
    return CONFINEMENT + strength / ((1.0 - math.tan(FRICTION) / math.tan(beta)) * math.sin(2.0 * beta))


@cache
def specimen(across: float, slenderness: float = 2.0, dimension: int = 2) -> Specimen:
    """Discs or spheres, random."""
    return make_specimen(dimension, width=0.05, height=0.05 * slenderness, across=across, seed=1)


def cut_specimen(build: AssemblyBuilder, body: Specimen, angle: float) -> None:
    """Cut the joint through the middle of a specimen."""
    beta = math.radians(angle)
    build.add_joint_material(
        "joint", normal_stiffness=STIFFNESS, shear_stiffness=0.5 * STIFFNESS,
        friction_coefficient=math.tan(FRICTION), cohesion=COHESION, residual_cohesion=COHESION,
    )  # fmt: skip
    box = np.array([np.zeros(body.dimension), body.size])
    across = (0.0,) * (body.dimension - 2)
    build.cut([plane(0.5 * body.size, (math.sin(beta), *across, math.cos(beta)), box, "joint")], bounds=box)


@cache
def intact(across: float) -> float:
    """Strength of the rock without a joint [Pa]."""
    return compress(specimen(across), ROCK, confinement=CONFINEMENT, expected_strain=3.5e-3).strength


def jaeger(angle: float, across: float, rock: float, dimension: int = 2) -> Row:
    """The row of one angle [deg]; `rock` is the strength without a joint [Pa]."""
    begun = time.perf_counter()
    expected = sliding_strength(angle)
    if expected < rock:
        # both ends of the joint lie on the sides
        body = specimen(across, max(2.0, math.tan(math.radians(angle)) + 0.5), dimension)
        rig = Rig(body, ROCK, confinement=CONFINEMENT, prepare=lambda build: cut_specimen(build, body, angle))
        rig.solve()
        strain = expected / rig.modulus
        rate = strain / (STEPS * body.height / body.diameter)
        rig.begin(rate, share=0.05)
        found = []
        while rig.axial_strain() < 2.0 * strain:
            rig.advance(round(0.02 * strain / rate))
            found.append(rig.axial_stress())
        strength = max(found)
    else:
        body = specimen(across, dimension=dimension)
        strength = compress(
            body, ROCK, confinement=CONFINEMENT, expected_strain=3.5e-3, share=0.05,
            prepare=lambda build: cut_specimen(build, body, angle),
        ).strength  # fmt: skip
    return relative(
        f"jaeger {dimension}D", f"sigma1 at {angle:g} deg [MPa], {across:g} across", 1e-6 * strength,
        1e-6 * min(expected, rock), 0.05, time.perf_counter() - begun, SOURCE if expected < rock else "without a joint",
    )  # fmt: skip
