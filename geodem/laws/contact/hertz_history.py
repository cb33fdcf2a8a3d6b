"""Hertz's contact with Mindlin's shear stiffness on the whole slip, and friction: LIGGGHTS' hertz with history.

The shear force is the present stiffness times the whole slip that is remembered. So it follows the normal force up and
down, and a cycle of pressing, shearing, releasing and going back may give more than was put in; geodem's own
`hertz_mindlin` does not. It is here to be compared with.

References: Di Renzo & Di Maio (2004), Chem. Eng. Sci. 59:525-541; Tsuji, Tanaka & Ishida (1992), Powder Technology
71:239-250 (dashpots); Kloss et al. (2012), Prog. Comput. Fluid Dyn. 12:140-152.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, one_material

NAME = "hertz_history"
DIMENSIONS = (3,)
SCALAR = ("stiffness_before",)
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False


class HertzHistoryParameters(NamedTuple):
    """Contact of two spheres of one material."""

    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]
    friction_coefficient: float  # mu [-]
    restitution: float  # e [-]


PARAMETERS = HertzHistoryParameters


def tangents(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """2 E* sqrt(R* u) and 8 G* sqrt(R* u) [N/m]; 1/G* = 4 (2 - nu)(1 + nu)/E."""
    pressed = overlap if overlap > 0.0 else 0.0
    root = math.sqrt(radius_a * radius_b / (radius_a + radius_b) * pressed)
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    shear_modulus = 0.25 * young_modulus / ((2.0 - poisson_ratio) * (1.0 + poisson_ratio))
    return 2.0 * modulus * root, 8.0 * shear_modulus * root


def force(
    young_modulus, poisson_ratio, friction_coefficient, restitution,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, mass_a, mass_b, time_step, closing,
    stiffness_before, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = 4/3 E* sqrt(R* u) u + cn vn, Fs = kt s + ct vs with |kt s| <= mu |Fn|.

    kt = 8 G* sqrt(R* u), c = 2 sqrt(5/6) b sqrt(S m*) with S = 2 E* sqrt(R* u) or kt, b = -L/sqrt(L^2 + pi^2),
    L = ln e; where kt s is cut, without ct vs.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    stiffness_before, shear_x, shear_y, shear_z : float
        History: kt [N/m] and the spring's shear force kt s [N].
    """
    normal_tangent, shear_tangent = tangents(young_modulus, poisson_ratio, overlap, radius_a, radius_b)
    mass = mass_a * mass_b / (mass_a + mass_b)
    logarithm = math.log(restitution)
    share = 2.0 * math.sqrt(5.0 / 6.0) * -logarithm / math.sqrt(logarithm * logarithm + math.pi * math.pi)
    normal = (
        2.0 / 3.0 * normal_tangent * overlap
        + share * math.sqrt(normal_tangent * mass) * closing / time_step
    )  # fmt: skip
    grown = shear_tangent / stiffness_before if stiffness_before > 0.0 else 1.0
    x = grown * shear_x + shear_tangent * slip_x
    y = grown * shear_y + shear_tangent * slip_y
    z = grown * shear_z + shear_tangent * slip_z
    limit = friction_coefficient * abs(normal)
    squared = x * x + y * y + z * z
    slides = squared > limit * limit
    keep = limit / math.sqrt(squared) if slides else 1.0
    drag = 0.0 if slides else share * math.sqrt(shear_tangent * mass) / time_step
    x *= keep
    y *= keep
    z *= keep
    return normal, x + drag * slip_x, y + drag * slip_y, z + drag * slip_z, shear_tangent, x, y, z


def energy(
    young_modulus, poisson_ratio, overlap, radius_a, radius_b, stiffness_before, shear_x, shear_y, shear_z
):
    """Energy 8/15 E* sqrt(R* u) u^2 + Fs^2/(2 kt) [J]: of the springs as they are, which no path need have given."""
    normal_tangent = tangents(young_modulus, poisson_ratio, overlap, radius_a, radius_b)[0]
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    sheared = 0.5 * squared / stiffness_before if stiffness_before > 0.0 else 0.0
    return 4.0 / 15.0 * normal_tangent * overlap * overlap + sheared


def stiffness(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]: nothing before the two touch."""
    normal_tangent, shear_tangent = tangents(young_modulus, poisson_ratio, overlap, radius_a, radius_b)
    return normal_tangent, shear_tangent, 0.0, 0.0


def combine(first: HertzHistoryParameters, second: HertzHistoryParameters) -> HertzHistoryParameters:
    """Contact of two materials as one of equivalent E and nu: 1/E* and 1/G* are the sums of the halves of both.

    1/E* = sum (1 - nu^2)/E, 1/G* = sum 2 (2 - nu)(1 + nu)/E; the smaller friction and restitution.
    """
    young, poisson = one_material(
        first.young_modulus, first.poisson_ratio, second.young_modulus, second.poisson_ratio
    )
    return HertzHistoryParameters(
        young,
        poisson,
        min(first.friction_coefficient, second.friction_coefficient),
        min(first.restitution, second.restitution),
    )


def against_rigid(parameters: HertzHistoryParameters) -> HertzHistoryParameters:
    """Contact with a rigid wall: the sphere's own half of the contact, twice as stiff."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters: HertzHistoryParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters, positive=("young_modulus", "restitution"), not_negative=("friction_coefficient",)
    )
    bad = {fault.field for fault in found}
    if "poisson_ratio" not in bad and not -1.0 < parameters.poisson_ratio <= 0.5:
        found.append(Fault("poisson_ratio", "must be above -1 and at most 0.5", "Give 0.25, for instance"))
    if "restitution" not in bad and parameters.restitution > 1.0:
        found.append(Fault("restitution", "must be at most 1", "Give 1 for a bounce without loss"))
    return found
