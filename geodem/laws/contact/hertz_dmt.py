"""Adhesive contact of elastic spheres: Hertz-Mindlin and the constant pull of surfaces that attract each other.

References: Derjaguin, Muller & Toporov (1975), Effect of contact deformations on the adhesion of particles, Journal of
Colloid and Interface Science 53:314-326, in the form of Maugis (1992), ibid. 150:243-269: Hertz's contact under the
load Fn + 2 pi w R*. All else is the Hertz-Mindlin contact: Johnson (1985), Contact Mechanics, Cambridge University
Press, eqs 4.23 and 7.42; shear force in steps as in Thornton, Cummins & Cleary (2013), Powder Technology 233:30-46;
dashpot of Tsuji, Tanaka & Ishida (1992), Powder Technology 71:239-250, with the relation of Antypov & Elliott (2011),
Europhysics Letters 94:50004.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, one_material

NAME = "hertz_dmt"
DIMENSIONS = (3,)
SCALAR = ("last_overlap",)
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = True


class HertzDmtParameters(NamedTuple):
    """The two spheres that touch, as if both were of one material."""

    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]
    friction_coefficient: float  # mu [-]
    work_of_adhesion: float  # w [J/m2]: twice the surface energy of one material
    restitution: float = 1.0  # e [-]: speed after over speed before a collision head-on without adhesion


PARAMETERS = HertzDmtParameters


def force(
    young_modulus, poisson_ratio, friction_coefficient, work_of_adhesion,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, last_overlap, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step, with the contact's radius a = sqrt(R* u), 1/R* = 1/ra + 1/rb.

    Fn = 4/3 E* a u - 2 pi w R*, E* = E/(2 (1 - nu^2)); Fs = c Fs + 8 G* b slip, G* = E/(4 (2 - nu)(1 + nu)).
    While a shrinks c = a over the last a, b = a; else c = 1, b = their mean; |Fs| <= mu (Fn + 2 pi w R*).

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart where positive, shear is the force on a.
    last_overlap, shear_x, shear_y, shear_z : float
        History: the overlap [m] and the shear force [N].
    """
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    curvature = radius_a * radius_b / (radius_a + radius_b)
    radius = math.sqrt(curvature * pressed)
    elastic = 4.0 / 3.0 * normal_modulus * radius * pressed
    normal = elastic - 2.0 * math.pi * work_of_adhesion * curvature
    # what is added in a step sees the contact grow from the last radius; while it shrinks all is scaled to the new one
    last = last_overlap if last_overlap > 0.0 else 0.0
    grows = pressed >= last
    larger = pressed if grows else last
    ratio = math.sqrt((last if grows else pressed) / larger) if larger > 0.0 else 1.0
    shrunk = 1.0 if grows else ratio
    spring = 8.0 * shear_modulus * radius * (0.5 + 0.5 * ratio if grows else 1.0)
    x = shrunk * shear_x + spring * slip_x
    y = shrunk * shear_y + spring * slip_y
    z = shrunk * shear_z + spring * slip_z
    limit = friction_coefficient * elastic
    squared = x * x + y * y + z * z
    keep = limit / math.sqrt(squared) if squared > limit * limit else 1.0
    x *= keep
    y *= keep
    z *= keep
    return normal, x, y, z, pressed, x, y, z


def viscous(
    young_modulus, poisson_ratio, restitution,
    overlap, approach, radius_a, radius_b, mass_a, mass_b, time_step,
):  # fmt: skip
    """Viscous force sqrt(10/3) zeta sqrt(kn m*) v along the normal [N], none across: normal, shear x, y, z.

    kn = 2 E* a, 1/m* = 1/ma + 1/mb, zeta = -ln e/sqrt(pi^2 + (ln e)^2). A collision head-on without adhesion then keeps
    exactly e of its speed.
    """
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    pressed = overlap if overlap > 0.0 else 0.0
    radius = math.sqrt(radius_a * radius_b / (radius_a + radius_b) * pressed)
    mass = mass_a * (mass_b / (mass_a + mass_b))
    log = math.log(restitution)
    zeta = -log / math.sqrt(math.pi * math.pi + log * log)
    normal = math.sqrt(10.0 / 3.0) * zeta * math.sqrt(2.0 * modulus * radius * mass) / time_step
    return normal * approach, 0.0, 0.0, 0.0


def energy(
    young_modulus, poisson_ratio, work_of_adhesion, overlap, radius_a, radius_b, shear_x, shear_y, shear_z
):
    """Energy 8/15 E* a u^2 - 2 pi w R* u + Fs^2/(16 G* a) [J]: elastic, and what adhesion has given."""
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    curvature = radius_a * radius_b / (radius_a + radius_b)
    radius = math.sqrt(curvature * pressed)
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    sheared = squared / (16.0 * shear_modulus * radius) if radius > 0.0 else 0.0
    pulled = 2.0 * math.pi * work_of_adhesion * curvature * pressed
    return 8.0 / 15.0 * normal_modulus * radius * pressed * pressed - pulled + sheared


def stiffness(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Tangent stiffness kn = 2 E* a, ks = 8 G* a [N/m], twist, bend [N m/rad]: nothing before the two touch."""
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    radius = math.sqrt(radius_a * radius_b / (radius_a + radius_b) * pressed)
    return 2.0 * normal_modulus * radius, 8.0 * shear_modulus * radius, 0.0, 0.0


def combine(first: HertzDmtParameters, second: HertzDmtParameters) -> HertzDmtParameters:
    """Contact of two materials, as one material of the same E* and G*; the smaller friction, the mean restitution.

    The work of adhesion is the geometric mean (Berthelot's rule).

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, 1/G* = 2 (2 - nu1)(1 + nu1)/E1 + 2 (2 - nu2)(1 + nu2)/E2.
    """
    young, poisson = one_material(
        first.young_modulus, first.poisson_ratio, second.young_modulus, second.poisson_ratio
    )
    return HertzDmtParameters(
        young,
        poisson,
        min(first.friction_coefficient, second.friction_coefficient),
        math.sqrt(first.work_of_adhesion * second.work_of_adhesion),
        0.5 * first.restitution + 0.5 * second.restitution,
    )


def against_rigid(parameters: HertzDmtParameters) -> HertzDmtParameters:
    """Contact with a rigid wall: the sphere's own half of the contact, E* and G* twice as large, its own adhesion."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters: HertzDmtParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters,
        positive=("young_modulus", "restitution"),
        not_negative=("friction_coefficient", "work_of_adhesion"),
    )
    known = {fault.field for fault in found}
    if "poisson_ratio" not in known and not -1.0 < parameters.poisson_ratio <= 0.5:
        found.append(Fault("poisson_ratio", "must be above -1 and at most 0.5", "Give 0.25, for instance"))
    if "restitution" not in known and parameters.restitution > 1.0:
        found.append(Fault("restitution", "must be at most 1", "Give 1 for a collision that costs nothing"))
    return found
