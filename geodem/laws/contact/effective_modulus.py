"""Contact whose springs follow from a modulus: the same stiffness of the whole at any size of grains.

Reference: Potyondy & Cundall (2004), A bonded-particle model for rock, Int. J. Rock Mech. Min. Sci. 41:1329-1364,
section 3.1: the contact is an elastic beam between the centres; here with the section of the smaller grain, so that a
contact is as stiff as the bond of the same modulus that it replaces. Coulomb friction as Cundall & Strack (1979),
Geotechnique 29:47-65.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "effective_modulus"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False

# The section: a disc between spheres, else a strip of one metre depth between discs; set by the kernel's module.
SPHERES = True
# Radius over that of the grain from which the other is a wall, as laws are told it: the beam ends at the surface.
WALL_RADIUS = 1e12


class EffectiveModulusParameters(NamedTuple):
    """The contact of two grains of one material."""

    effective_modulus: float  # Ec [Pa]
    stiffness_ratio: float  # kappa = kn/ks [-]
    friction_coefficient: float  # mu [-]


PARAMETERS = EffectiveModulusParameters


def force(
    effective_modulus, stiffness_ratio, friction_coefficient,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: kn = Ec A/L, Fn = kn u, Fs = Fs + (kn/kappa) slip with |Fs| <= mu Fn.

    A is the section of the smaller grain, L = ra + rb the length of the beam, to a wall L = ra.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the shear force [N].
    """
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    kn = effective_modulus * area / (radius_a + (radius_b if radius_b < WALL_RADIUS * radius_a else 0.0))
    ks = kn / stiffness_ratio
    normal = kn * overlap
    x = shear_x + ks * slip_x
    y = shear_y + ks * slip_y
    z = shear_z + ks * slip_z
    limit = friction_coefficient * normal
    squared = x * x + y * y + z * z
    if squared > limit * limit:
        keep = limit / math.sqrt(squared)
        x *= keep
        y *= keep
        z *= keep
    return normal, x, y, z, x, y, z


def energy(effective_modulus, stiffness_ratio, overlap, radius_a, radius_b, shear_x, shear_y, shear_z):
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) [J]."""
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    kn = effective_modulus * area / (radius_a + (radius_b if radius_b < WALL_RADIUS * radius_a else 0.0))
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (kn * overlap * overlap + squared * stiffness_ratio / kn)


def stiffness(effective_modulus, stiffness_ratio, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    kn = effective_modulus * area / (radius_a + (radius_b if radius_b < WALL_RADIUS * radius_a else 0.0))
    return kn, kn / stiffness_ratio, 0.0, 0.0


def combine(
    first: EffectiveModulusParameters, second: EffectiveModulusParameters
) -> EffectiveModulusParameters:
    """Contact of two materials: springs in series, the smaller friction, the mean kappa."""
    return mixed(
        first,
        second,
        series=("effective_modulus",),
        smaller=("friction_coefficient",),
        mean=("stiffness_ratio",),
    )


def against_rigid(parameters: EffectiveModulusParameters) -> EffectiveModulusParameters:
    """Contact with a rigid wall: the same modulus; the beam from the centre to the surface is shorter."""
    return parameters


def check(parameters: EffectiveModulusParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("effective_modulus", "stiffness_ratio"),
        not_negative=("friction_coefficient",),
    )
