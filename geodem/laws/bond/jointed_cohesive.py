"""Bond of two grains by forces alone, with Mohr-Coulomb shear strength: YADE's JCFpm.

Stiffness follows from modulus and radii as in `geodem.laws.contact.elastic_frictional`, which goes on where the bond
breaks. In the step in which it is cut the bond still bears its strength.

Reference: Scholtes & Donze (2013), A DEM model for soft and hard rocks: role of grain interlocking on strength, J.
Mech. Phys. Solids 61:352-369.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults

NAME = "jointed_cohesive"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False
REPLACES_CONTACT = True
LINGERS = True


class JointedCohesiveParameters(NamedTuple):
    """A grain's material, and that of the one it is bonded to, which is filled in where two materials meet."""

    young_modulus: float  # E [Pa]
    stiffness_ratio: float  # ks/kn [-]
    friction_coefficient: float  # mu [-]
    tensile_strength: float  # [Pa], times pi and the square of the smaller radius
    cohesion: float  # [Pa], the same
    other_young_modulus: float = math.nan  # [Pa]
    other_stiffness_ratio: float = math.nan  # [-]


PARAMETERS = JointedCohesiveParameters


def springs(young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b):
    """kn, ks [N/m]: 2 k1 k2/(k1 + k2), of kn with k = E r, of ks with k = (ks/kn) E r."""
    one_normal = young_modulus * radius_a
    other_normal = other_young_modulus * radius_b
    one_shear = stiffness_ratio * one_normal
    other_shear = other_stiffness_ratio * other_normal
    return (
        2.0 * one_normal * other_normal / (one_normal + other_normal),
        2.0 * one_shear * other_shear / (one_shear + other_shear),
    )


def bonded():
    """History of a new bond: no shear force."""
    return 0.0, 0.0, 0.0


def force(
    young_modulus, stiffness_ratio, friction_coefficient, tensile_strength, cohesion,
    other_young_modulus, other_stiffness_ratio,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, scale, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces of the intact bond after a step, and how much of its strength they take.

    Fn = kn u, dFs = ks slip. Breaks in tension at -Fn = t pi r^2, in shear at |Fs| = c pi r^2 + mu Fn, r the smaller
    radius; the shear utilisation is |Fs| over that strength.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    shear_x, shear_y, shear_z : float
        History: shear force [N].
    tension_utilisation, shear_utilisation : float
        [-]
    """
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    least = radius_a if radius_a < radius_b else radius_b
    area = math.pi * least * least
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    shear = math.sqrt(x * x + y * y + z * z)
    strength = scale * cohesion * area + friction_coefficient * normal
    # pulled so far that friction takes all cohesion away
    strength = strength if strength > 1e-300 else 1e-300
    return normal, x, y, z, x, y, z, -normal / (scale * tensile_strength * area), shear / strength


def energy(
    young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z,
):  # fmt: skip
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) [J]."""
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (normal_stiffness * overlap * overlap + squared / shear_stiffness)


def stiffness(young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    return normal_stiffness, shear_stiffness, 0.0, 0.0


def combine(first: JointedCohesiveParameters, second: JointedCohesiveParameters) -> JointedCohesiveParameters:
    """Bond of two materials: both moduli are remembered; the smaller strengths count."""
    return JointedCohesiveParameters(
        first.young_modulus,
        first.stiffness_ratio,
        min(first.friction_coefficient, second.friction_coefficient),
        min(first.tensile_strength, second.tensile_strength),
        min(first.cohesion, second.cohesion),
        second.young_modulus,
        second.stiffness_ratio,
    )


def reversed_pair(parameters: JointedCohesiveParameters) -> JointedCohesiveParameters:
    """The same bond, its second particle first."""
    return parameters._replace(
        young_modulus=parameters.other_young_modulus,
        stiffness_ratio=parameters.other_stiffness_ratio,
        other_young_modulus=parameters.young_modulus,
        other_stiffness_ratio=parameters.stiffness_ratio,
    )


def against_rigid(parameters: JointedCohesiveParameters) -> JointedCohesiveParameters:
    """Bond to a wall, which counts as a grain of the same material and size."""
    return combine(parameters, parameters)


def check(parameters: JointedCohesiveParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=(
            "young_modulus",
            "stiffness_ratio",
            "tensile_strength",
            "cohesion",
            "other_young_modulus",
            "other_stiffness_ratio",
        ),
        not_negative=("friction_coefficient",),
        may_be_infinite=("tensile_strength", "cohesion"),
    )
