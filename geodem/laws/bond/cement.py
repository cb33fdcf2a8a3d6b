"""Cement between two grains beside their contact, its stiffness from a modulus: it carries moments until it breaks.

Reference: Potyondy & Cundall (2004), A bonded-particle model for rock, Int. J. Rock Mech. Min. Sci. 41:1329-1364,
eqs 11-17, stiffness as in section 3.1: the cement is an elastic beam between the centres, so grains of any size give
the same stiffness of the whole. The moment contribution factor of the stress (1 in the paper) is that of Potyondy
(2011), Parallel-bond refinements to match macroproperties of hard rock, Proc. 2nd Int. FLAC/DEM Symposium; friction of
the shear strength that of the same model in later use.
The normal force follows from the whole change of distance, the other three are added up step by step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "cement"
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


class CementParameters(NamedTuple):
    """The cement. Its radius is radius_factor times that of the smaller grain, its length the sum of both radii."""

    radius_factor: float  # lambda [-]
    effective_modulus: float  # Ec [Pa]
    stiffness_ratio: float  # kappa = kn/ks [-]
    tensile_strength: float  # [Pa]
    shear_strength: float  # [Pa]: of the unpressed cement
    friction_coefficient: float = 0.0  # tan(phi) [-]: what mean pressure adds to the shear strength
    moment_contribution: float = 1.0  # beta [-]: share of the moments' stress that counts at the rim


PARAMETERS = CementParameters


def bonded():
    """History of a new bond: no shear force, no bending, no twisting moment."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def force(
    radius_factor, effective_modulus, stiffness_ratio, tensile_strength, shear_strength,
    friction_coefficient, moment_contribution,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b, scale,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Forces and moments of the intact cement after a step, and how much of its strength they take.

    With the cement's radius R, section A, moment of inertia I and polar moment J (eqs 11-17), and per area
    kn = Ec/(ra + rb), ks = kn/kappa: Fn = kn A u, dFs = ks A slip, dMt = ks J twist, dMb = kn I bend; largest
    stresses at the rim sigma = -Fn/A + beta |Mb| R/I, tau = |Fs|/A + beta |Mt| R/J.
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
    # I/A, the square of the radius of gyration; J/A is twice that, and between discs there is no twist
    gyration = 0.25 * radius * radius if SPHERES else radius * radius / 3.0
    per_area = effective_modulus / (radius_a + radius_b)
    k_normal = per_area * area
    k_shear = k_normal / stiffness_ratio
    k_bend = k_normal * gyration
    normal = k_normal * overlap
    x = shear_x + k_shear * slip_x
    y = shear_y + k_shear * slip_y
    z = shear_z + k_shear * slip_z
    bent_x = bending_x + k_bend * bend_x
    bent_y = bending_y + k_bend * bend_y
    bent_z = bending_z + k_bend * bend_z
    twisted = twisting + 2.0 * k_shear * gyration * twist
    pressure = per_area * overlap
    # one division for all stresses: R/I is 4/(A R) of a disc and 3/(A R) of a strip
    inverse = 1.0 / (area * radius)
    rim = (4.0 if SPHERES else 3.0) * moment_contribution * inverse
    bending = math.sqrt(bent_x * bent_x + bent_y * bent_y + bent_z * bent_z)
    shear = math.sqrt(x * x + y * y + z * z)
    tension = rim * bending - pressure
    shearing = shear * radius * inverse + 0.5 * rim * abs(twisted)
    tension_utilisation = tension / (scale * tensile_strength)
    shear_utilisation = (shearing - friction_coefficient * pressure) / (scale * shear_strength)
    return (
        normal, x, y, z,
        twisted, bent_x, bent_y, bent_z,
        x, y, z, bent_x, bent_y, bent_z, twisted,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def energy(
    radius_factor, effective_modulus, stiffness_ratio, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Elastic energy kn A u^2/2 + Fs^2/(2 ks A) + Mb^2/(2 kn I) + Mt^2/(2 ks J) [J]."""
    radius = radius_factor * (radius_a if radius_a < radius_b else radius_b)
    area = math.pi * radius * radius if SPHERES else 2.0 * radius
    gyration = 0.25 * radius * radius if SPHERES else radius * radius / 3.0
    k_normal = effective_modulus * area / (radius_a + radius_b)
    k_shear = k_normal / stiffness_ratio
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    bending = bending_x * bending_x + bending_y * bending_y + bending_z * bending_z
    return 0.5 * (
        k_normal * overlap * overlap
        + shear / k_shear
        + bending / (k_normal * gyration)
        + twisting * twisting / (2.0 * k_shear * gyration)
    )


def stiffness(radius_factor, effective_modulus, stiffness_ratio, radius_a, radius_b):
    """Tangent stiffness kn A, ks A [N/m], twist ks J, bend kn I [N m/rad]."""
    radius = radius_factor * (radius_a if radius_a < radius_b else radius_b)
    area = math.pi * radius * radius if SPHERES else 2.0 * radius
    gyration = 0.25 * radius * radius if SPHERES else radius * radius / 3.0
    k_normal = effective_modulus * area / (radius_a + radius_b)
    k_shear = k_normal / stiffness_ratio
    twist = 2.0 * k_shear * gyration if SPHERES else 0.0
    return k_normal, k_shear, twist, k_normal * gyration


def combine(first: CementParameters, second: CementParameters) -> CementParameters:
    """Bond of two materials: springs in series, the smaller radius factor and strength, the mean kappa and beta."""
    return mixed(
        first,
        second,
        series=("effective_modulus",),
        smaller=("radius_factor", "tensile_strength", "shear_strength", "friction_coefficient"),
        mean=("stiffness_ratio", "moment_contribution"),
    )


def against_rigid(parameters: CementParameters) -> CementParameters:
    """Bond to a rigid wall: the grain's own half of the cement, twice as stiff."""
    return parameters._replace(effective_modulus=2.0 * parameters.effective_modulus)


def check(parameters: CementParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=(
            "radius_factor",
            "effective_modulus",
            "stiffness_ratio",
            "tensile_strength",
            "shear_strength",
        ),
        not_negative=("friction_coefficient", "moment_contribution"),
        may_be_infinite=("tensile_strength", "shear_strength"),
    )
