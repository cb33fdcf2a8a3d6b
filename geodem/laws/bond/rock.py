"""Bond of rock: breaks by tension, or by shear with a cohesion and a friction of its own; bending hardly counts.

Reference: section and stiffness of Potyondy & Cundall (2004), A bonded-particle model for rock, Int. J. Rock Mech.
Min. Sci. 41:1329-1364, eqs 11-17, written with an effective modulus as in their section 3.1; the moment contribution
factor of Potyondy (2011), Parallel-bond refinements to match macroproperties of hard rock, Proc. 2nd Int. FLAC/DEM
Symposium; shear strength with friction as in Scholtes & Donze (2013), A DEM model for soft and hard rocks, J. Mech.
Phys. Solids 61:352-369. A bond in place of the contact: its section carries the whole force until it breaks.
With the full bending moment in the break check (beta = 1) the compressive strength of bonded discs stays near four
times the tensile one, whatever the cohesion; without it, cohesion and friction choose that ratio and the slope of the
envelope.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "rock"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear", "bending")
AXIAL = ("twisting",)
MOMENT = True
VISCOUS = False
REPLACES_CONTACT = True

# The bond's section: a disc between spheres, else a strip of one metre depth between discs. The kernel's module
# overrides this with the scene's dimension.
SPHERES = True


class RockParameters(NamedTuple):
    """The bond. The radius h of its section is that of the smaller grain, its length the sum of both radii."""

    effective_modulus: float  # Ec [Pa]
    stiffness_ratio: float  # kappa = kn/ks [-]
    tensile_strength: float  # Tb [Pa]
    shear_strength: float  # C [Pa]: of the unpressed bond
    friction_coefficient: float  # tan(phi_b) [-]: what mean pressure adds to the shear strength
    moment_contribution: float = 0.0  # beta [-]: share of the moments' stress that counts at the rim


PARAMETERS = RockParameters


def bonded():
    """History of a new bond: no shear force, no bending, no twisting moment."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def force(
    effective_modulus, stiffness_ratio, tensile_strength, shear_strength, friction_coefficient,
    moment_contribution,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b, scale,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Forces and moments of the intact bond after a step, and how much of its strength they take.

    With h = min(ra, rb), A and I of the section, J = 2 I: kn = Ec A/(ra + rb), ks = kn/kappa,
    Fn = kn u, dFs = ks slip, dMb = kn (I/A) bend, dMt = ks (J/A) twist; stresses, tension positive:
    sigma = -Fn/A, at the rim sigma + beta |Mb| h/I; tau = |Fs|/A + beta |Mt| h/J.
    Breaks where sigma at the rim reaches Tb, or tau reaches C - sigma tan(phi_b); the scale multiplies Tb and C.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    shear_x, ..., bending_z, twisting : float
        History: shear force [N], bending and twisting moment [N m].
    tension_utilisation, shear_utilisation : float
        [-]; 1 at the strength times `scale`.
    """
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    # I/A, the square of the radius of gyration; J/A is twice that
    gyration = 0.25 * height * height if SPHERES else height * height / 3.0
    per_area = effective_modulus / (radius_a + radius_b)
    kn = per_area * area
    ks = kn / stiffness_ratio
    k_bend = kn * gyration
    normal = kn * overlap
    x = shear_x + ks * slip_x
    y = shear_y + ks * slip_y
    z = shear_z + ks * slip_z
    bent_x = bending_x + k_bend * bend_x
    bent_y = bending_y + k_bend * bend_y
    bent_z = bending_z + k_bend * bend_z
    twisted = twisting + 2.0 * ks * gyration * twist
    pressure = per_area * overlap
    # one division for all stresses: h/I is 4/(A h) of a disc and 3/(A h) of a strip
    inverse = 1.0 / (area * height)
    rim = (4.0 if SPHERES else 3.0) * moment_contribution * inverse
    bending = math.sqrt(bent_x * bent_x + bent_y * bent_y + bent_z * bent_z)
    shear = math.sqrt(x * x + y * y + z * z)
    tension = rim * bending - pressure
    shearing = shear * height * inverse + 0.5 * rim * abs(twisted)
    tension_utilisation = tension / (scale * tensile_strength)
    shear_utilisation = (shearing - friction_coefficient * pressure) / (scale * shear_strength)
    return (
        normal, x, y, z,
        twisted, bent_x, bent_y, bent_z,
        x, y, z, bent_x, bent_y, bent_z, twisted,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def energy(
    effective_modulus, stiffness_ratio, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) + Mb^2 A/(2 kn I) + Mt^2 A/(2 ks J) [J]."""
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    gyration = 0.25 * height * height if SPHERES else height * height / 3.0
    kn = effective_modulus * area / (radius_a + radius_b)
    ks = kn / stiffness_ratio
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    bending = bending_x * bending_x + bending_y * bending_y + bending_z * bending_z
    return 0.5 * (
        kn * overlap * overlap
        + shear / ks
        + bending / (kn * gyration)
        + twisting * twisting / (2.0 * ks * gyration)
    )


def stiffness(effective_modulus, stiffness_ratio, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist ks J/A, bend kn I/A [N m/rad]."""
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    gyration = 0.25 * height * height if SPHERES else height * height / 3.0
    kn = effective_modulus * area / (radius_a + radius_b)
    ks = kn / stiffness_ratio
    twist = 2.0 * ks * gyration if SPHERES else 0.0
    return kn, ks, twist, kn * gyration


def combine(first: RockParameters, second: RockParameters) -> RockParameters:
    """Bond of two materials: springs in series, the smaller strength and friction, the mean kappa and beta."""
    return mixed(
        first,
        second,
        series=("effective_modulus",),
        smaller=("tensile_strength", "shear_strength", "friction_coefficient"),
        mean=("stiffness_ratio", "moment_contribution"),
    )


def against_rigid(parameters: RockParameters) -> RockParameters:
    """Bond to a rigid wall: the grain's own half of the bond, twice as stiff."""
    return parameters._replace(effective_modulus=2.0 * parameters.effective_modulus)


def check(parameters: RockParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("effective_modulus", "stiffness_ratio", "tensile_strength", "shear_strength"),
        not_negative=("friction_coefficient", "moment_contribution"),
        may_be_infinite=("tensile_strength", "shear_strength"),
    )
