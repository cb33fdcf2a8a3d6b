"""Hertz-Mindlin contact that resists rolling and twisting as well: two more springs, each with its slider.

References: Johnson (1985), Contact Mechanics, Cambridge University Press, eqs 4.23 and 7.42; shear force in steps as in
Thornton, Cummins & Cleary (2013), Powder Technology 233:30-46; dashpot of Tsuji, Tanaka & Ishida (1992), Powder
Technology 71:239-250, with the relation of Antypov & Elliott (2011), Europhysics Letters 94:50004. Rolling: the
elastic-plastic spring-slider without dashpot of Ai, Chen, Rotter & Ooi (2011), Powder Technology 206:269-282 (their
type C), with the stiffness ks R*^2 after Iwashita & Oda (1998), Journal of Engineering Mechanics 124:285-292. Both
moments are scaled with the contact's radius while it is unloaded, as the shear force is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, one_material

NAME = "hertz_mindlin_rolling"
DIMENSIONS = (3,)
SCALAR = ("last_overlap",)
TANGENTIAL = ("shear", "rolling")
AXIAL = ("twisting",)
MOMENT = True
VISCOUS = True


class HertzMindlinRollingParameters(NamedTuple):
    """The two spheres that touch, as if both were of one material."""

    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]
    friction_coefficient: float  # mu [-]
    rolling_friction: float  # mu_r [-]
    twisting_friction: float = 0.0  # mu_t [-]
    restitution: float = 1.0  # e [-]: speed after over speed before a collision head-on


PARAMETERS = HertzMindlinRollingParameters


def force(
    young_modulus, poisson_ratio, friction_coefficient, rolling_friction, twisting_friction,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b,
    last_overlap, shear_x, shear_y, shear_z, rolling_x, rolling_y, rolling_z, twisting,
):  # fmt: skip
    """Forces and moments after a step, with the contact's radius a = sqrt(R* u), 1/R* = 1/ra + 1/rb.

    Fn = 4/3 E* a u, E* = E/(2 (1 - nu^2)); with ks = 8 G* b, G* = E/(4 (2 - nu)(1 + nu)): Fs = c Fs + ks slip,
    Mr = c Mr + ks R*^2 bend, Mt = c Mt + ks R*^2 twist. While a shrinks c = a over the last a, b = a; else c = 1
    and b is their mean; |Fs| <= mu Fn, |Mr| <= mu_r R* Fn, |Mt| <= mu_t R* Fn.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    last_overlap, shear_x, ..., rolling_z, twisting : float
        History: the overlap [m], the shear force [N], rolling and twisting moment [N m].
    """
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    curvature = radius_a * radius_b / (radius_a + radius_b)
    radius = math.sqrt(curvature * pressed)
    normal = 4.0 / 3.0 * normal_modulus * radius * pressed
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
    limit = friction_coefficient * normal
    squared = x * x + y * y + z * z
    keep = limit / math.sqrt(squared) if squared > limit * limit else 1.0
    x *= keep
    y *= keep
    z *= keep
    stiff = spring * curvature * curvature
    rolled_x = shrunk * rolling_x + stiff * bend_x
    rolled_y = shrunk * rolling_y + stiff * bend_y
    rolled_z = shrunk * rolling_z + stiff * bend_z
    most = rolling_friction * curvature * normal
    size = rolled_x * rolled_x + rolled_y * rolled_y + rolled_z * rolled_z
    left = most / math.sqrt(size) if size > most * most else 1.0
    rolled_x *= left
    rolled_y *= left
    rolled_z *= left
    twisted = shrunk * twisting + stiff * twist
    largest = twisting_friction * curvature * normal
    twisted = largest if twisted > largest else twisted
    twisted = -largest if twisted < -largest else twisted
    return (
        normal, x, y, z,
        twisted, rolled_x, rolled_y, rolled_z,
        pressed, x, y, z, rolled_x, rolled_y, rolled_z, twisted,
    )  # fmt: skip


def viscous(
    young_modulus, poisson_ratio, restitution,
    overlap, approach, radius_a, radius_b, mass_a, mass_b, time_step,
):  # fmt: skip
    """Viscous force sqrt(10/3) zeta sqrt(kn m*) v along the normal [N], none across: normal, shear x, y, z.

    kn = 2 E* a, 1/m* = 1/ma + 1/mb, zeta = -ln e/sqrt(pi^2 + (ln e)^2). A collision head-on that ends where the
    overlap is zero then keeps exactly e of its speed.
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
    young_modulus, poisson_ratio, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, rolling_x, rolling_y, rolling_z, twisting,
):  # fmt: skip
    """Elastic energy 8/15 E* a u^2 + (Fs^2 + (Mr^2 + Mt^2)/R*^2)/(16 G* a) [J]."""
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    curvature = radius_a * radius_b / (radius_a + radius_b)
    radius = math.sqrt(curvature * pressed)
    moment = rolling_x * rolling_x + rolling_y * rolling_y + rolling_z * rolling_z + twisting * twisting
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z + moment / (curvature * curvature)
    sheared = squared / (16.0 * shear_modulus * radius) if radius > 0.0 else 0.0
    return 8.0 / 15.0 * normal_modulus * radius * pressed * pressed + sheared


def stiffness(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Tangent stiffness kn = 2 E* a, ks = 8 G* a [N/m], twist, bend, both ks R*^2 [N m/rad]."""
    normal_modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    pressed = overlap if overlap > 0.0 else 0.0
    curvature = radius_a * radius_b / (radius_a + radius_b)
    radius = math.sqrt(curvature * pressed)
    spring = 8.0 * shear_modulus * radius
    return (
        2.0 * normal_modulus * radius,
        spring,
        spring * curvature * curvature,
        spring * curvature * curvature,
    )


def combine(
    first: HertzMindlinRollingParameters, second: HertzMindlinRollingParameters
) -> HertzMindlinRollingParameters:
    """Contact of two materials, as one of the same E* and G*; the smaller friction of each kind, the mean restitution.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, 1/G* = 2 (2 - nu1)(1 + nu1)/E1 + 2 (2 - nu2)(1 + nu2)/E2.
    """
    young, poisson = one_material(
        first.young_modulus, first.poisson_ratio, second.young_modulus, second.poisson_ratio
    )
    return HertzMindlinRollingParameters(
        young,
        poisson,
        min(first.friction_coefficient, second.friction_coefficient),
        min(first.rolling_friction, second.rolling_friction),
        min(first.twisting_friction, second.twisting_friction),
        0.5 * first.restitution + 0.5 * second.restitution,
    )


def against_rigid(parameters: HertzMindlinRollingParameters) -> HertzMindlinRollingParameters:
    """Contact with a rigid wall: the sphere's own half of the contact, E* and G* twice as large; R* is the radius."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters: HertzMindlinRollingParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters,
        positive=("young_modulus", "restitution"),
        not_negative=("friction_coefficient", "rolling_friction", "twisting_friction"),
    )
    known = {fault.field for fault in found}
    if "poisson_ratio" not in known and not -1.0 < parameters.poisson_ratio <= 0.5:
        found.append(Fault("poisson_ratio", "must be above -1 and at most 0.5", "Give 0.25, for instance"))
    if "restitution" not in known and parameters.restitution > 1.0:
        found.append(Fault("restitution", "must be at most 1", "Give 1 for a collision that costs nothing"))
    return found
