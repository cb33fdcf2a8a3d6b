"""Parallel bond: an elastic cement between two grains that carries forces and moments until it breaks.

Reference: Potyondy & Cundall (2004), A bonded-particle model for rock, Int. J. Rock Mech. Min. Sci. 41:1329-1364,
eqs 11-17. The cement acts beside the grains' own contact. The moment contribution factor of the stress
(1 in the paper) is that of Potyondy (2011), friction of the shear strength that of the same model in later use.
The normal force follows from the whole change of distance, the other three are added up step by step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "parallel_bond"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear", "bending")
AXIAL = ("twisting",)
MOMENT = True
VISCOUS = False
REPLACES_CONTACT = False

# The cement's section: a disc between spheres, else a strip of one metre depth between discs. The kernel's
# module overrides this with the scene's dimension.
SPHERES = True


class ParallelBondParameters(NamedTuple):
    """The cement. Its radius is radius_factor times that of the smaller grain."""

    radius_factor: float  # [-]
    normal_stiffness: float  # kn [Pa/m]: per area of the cement
    shear_stiffness: float  # ks [Pa/m]
    tensile_strength: float  # [Pa]
    shear_strength: float  # [Pa]: of the unpressed cement
    friction_coefficient: float = 0.0  # tan(phi) [-]: what mean pressure adds to the shear strength
    moment_contribution: float = 1.0  # beta [-]: share of the moments' stress that counts at the rim


PARAMETERS = ParallelBondParameters


def bonded():
    """History of a new bond: no shear force, no bending, no twisting moment."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def force(
    radius_factor, normal_stiffness, shear_stiffness, tensile_strength, shear_strength,
    friction_coefficient, moment_contribution,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b, scale,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Forces and moments of the intact bond after a step, and how much of its strength they take.

    With the cement's radius R, section A, moment of inertia I and polar moment J (eqs 11-17):
    Fn = kn A u, dFs = ks A slip, dMt = ks J twist, dMb = kn I bend; largest stresses at the rim
    sigma = -Fn/A + beta |Mb| R/I, tau = |Fs|/A + beta |Mt| R/J.
    Breaks at sigma = tensile strength or tau = shear strength + tan(phi) Fn/A.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    shear_x, ..., bending_z, twisting : float
        History: shear force [N], bending and twisting moment [N m].
    tension_utilisation, shear_utilisation : float
        [-], proportional to the forces; 1 at the strength times `scale`.
    """
    radius = radius_factor * (radius_a if radius_a < radius_b else radius_b)
    area = math.pi * radius * radius if SPHERES else 2.0 * radius
    inertia = 0.25 * area * radius * radius if SPHERES else area * radius * radius / 3.0
    # between discs there is no twist, and any value will do
    polar = 2.0 * inertia
    normal = normal_stiffness * area * overlap
    x = shear_x + shear_stiffness * area * slip_x
    y = shear_y + shear_stiffness * area * slip_y
    z = shear_z + shear_stiffness * area * slip_z
    bent_x = bending_x + normal_stiffness * inertia * bend_x
    bent_y = bending_y + normal_stiffness * inertia * bend_y
    bent_z = bending_z + normal_stiffness * inertia * bend_z
    twisted = twisting + shear_stiffness * polar * twist
    pressure = normal / area
    bending = math.sqrt(bent_x * bent_x + bent_y * bent_y + bent_z * bent_z)
    shear = math.sqrt(x * x + y * y + z * z)
    tension = moment_contribution * bending * radius / inertia - pressure
    shearing = shear / area + moment_contribution * abs(twisted) * radius / polar
    tension_utilisation = tension / (scale * tensile_strength)
    shear_utilisation = (shearing - friction_coefficient * pressure) / (scale * shear_strength)
    return (
        normal, x, y, z,
        twisted, bent_x, bent_y, bent_z,
        x, y, z, bent_x, bent_y, bent_z, twisted,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def energy(
    radius_factor, normal_stiffness, shear_stiffness, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Elastic energy kn A u^2/2 + Fs^2/(2 ks A) + Mb^2/(2 kn I) + Mt^2/(2 ks J) [J]."""
    radius = radius_factor * (radius_a if radius_a < radius_b else radius_b)
    area = math.pi * radius * radius if SPHERES else 2.0 * radius
    inertia = 0.25 * area * radius * radius if SPHERES else area * radius * radius / 3.0
    polar = 2.0 * inertia
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    bending = bending_x * bending_x + bending_y * bending_y + bending_z * bending_z
    return 0.5 * (
        normal_stiffness * area * overlap * overlap
        + shear / (shear_stiffness * area)
        + bending / (normal_stiffness * inertia)
        + twisting * twisting / (shear_stiffness * polar)
    )


def stiffness(radius_factor, normal_stiffness, shear_stiffness, radius_a, radius_b):
    """Tangent stiffness kn A, ks A [N/m], twist ks J, bend kn I [N m/rad]."""
    radius = radius_factor * (radius_a if radius_a < radius_b else radius_b)
    area = math.pi * radius * radius if SPHERES else 2.0 * radius
    inertia = 0.25 * area * radius * radius if SPHERES else area * radius * radius / 3.0
    twist = 2.0 * shear_stiffness * inertia if SPHERES else 0.0
    return normal_stiffness * area, shear_stiffness * area, twist, normal_stiffness * inertia


def combine(first: ParallelBondParameters, second: ParallelBondParameters) -> ParallelBondParameters:
    """Bond of two materials: springs in series, the smaller radius factor and strength, the mean beta."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("radius_factor", "tensile_strength", "shear_strength", "friction_coefficient"),
        mean=("moment_contribution",),
    )


def against_rigid(parameters: ParallelBondParameters) -> ParallelBondParameters:
    """Bond to a rigid wall: the grain's own half of the cement, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: ParallelBondParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=(
            "radius_factor",
            "normal_stiffness",
            "shear_stiffness",
            "tensile_strength",
            "shear_strength",
        ),
        not_negative=("friction_coefficient", "moment_contribution"),
        may_be_infinite=("tensile_strength", "shear_strength"),
    )
