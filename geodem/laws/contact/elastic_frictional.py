"""Linear contact with Coulomb friction whose stiffness follows from the grains' modulus and radii.

Two grains are two springs in a row, each as stiff as E times its radius, so a packing keeps its modulus whatever the
sizes of its grains. It is the contact of Cundall & Strack (1979), Geotechnique 29:47-65, as YADE gives it its
stiffness: Smilauer et al. (2021), Yade documentation, 3rd ed., "Simulation of discrete particles".
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults

NAME = "elastic_frictional"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False


class ElasticFrictionalParameters(NamedTuple):
    """A grain's material, and that of the one it touches, which is filled in where two materials meet."""

    young_modulus: float  # E [Pa]
    stiffness_ratio: float  # ks/kn [-]: what YADE calls poisson
    friction_coefficient: float  # mu [-]
    other_young_modulus: float = math.nan  # [Pa]
    other_stiffness_ratio: float = math.nan  # [-]


PARAMETERS = ElasticFrictionalParameters


def springs(young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b):
    """kn, ks [N/m]: 2 k1 k2/(k1 + k2), of kn with k = E r, of ks with k = (ks/kn) E r.

    A wall, whose radius is beyond all measure, counts as a grain of the same size.
    """
    other = radius_b if radius_b < 1e12 * radius_a else radius_a
    one_normal = young_modulus * radius_a
    other_normal = other_young_modulus * other
    one_shear = stiffness_ratio * one_normal
    other_shear = other_stiffness_ratio * other_normal
    return (
        2.0 * one_normal * other_normal / (one_normal + other_normal),
        2.0 * one_shear * other_shear / (one_shear + other_shear),
    )


def force(
    young_modulus, stiffness_ratio, friction_coefficient, other_young_modulus, other_stiffness_ratio,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = kn u, Fs = Fs + ks slip with |Fs| <= mu Fn.

    kn = 2 k1 k2/(k1 + k2) with k = E r, ks the same with k = (ks/kn) E r. A wall (a radius beyond all measure) counts
    as a grain of the same size.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the shear force [N].
    """
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    limit = friction_coefficient * normal
    squared = x * x + y * y + z * z
    keep = limit / math.sqrt(squared) if squared > limit * limit else 1.0
    x *= keep
    y *= keep
    z *= keep
    return normal, x, y, z, x, y, z


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


def combine(
    first: ElasticFrictionalParameters, second: ElasticFrictionalParameters
) -> ElasticFrictionalParameters:
    """Contact of two materials: both are remembered, the smaller friction counts."""
    return first._replace(
        friction_coefficient=min(first.friction_coefficient, second.friction_coefficient),
        other_young_modulus=second.young_modulus,
        other_stiffness_ratio=second.stiffness_ratio,
    )


def reversed_pair(parameters: ElasticFrictionalParameters) -> ElasticFrictionalParameters:
    """The same contact, its second particle first."""
    return parameters._replace(
        young_modulus=parameters.other_young_modulus,
        stiffness_ratio=parameters.other_stiffness_ratio,
        other_young_modulus=parameters.young_modulus,
        other_stiffness_ratio=parameters.stiffness_ratio,
    )


def against_rigid(parameters: ElasticFrictionalParameters) -> ElasticFrictionalParameters:
    """Contact with a wall, which counts as a grain of the same material and size."""
    return combine(parameters, parameters)


def check(parameters: ElasticFrictionalParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("young_modulus", "stiffness_ratio", "other_young_modulus", "other_stiffness_ratio"),
        not_negative=("friction_coefficient",),
    )
