"""Linear contact whose stiffness follows from a characteristic velocity and the grains' elasticity: LIGGGHTS' hooke.

The stiffness is the one at which a head-on impact at that velocity stores as much energy as Hertz's contact at the same
largest overlap; the dashpots' coefficient follows from the restitution. Friction as in
`geodem.laws.contact.hooke_stiffness`.

References: Kloss et al. (2012), Prog. Comput. Fluid Dyn. 12:140-152; Di Renzo & Di Maio (2004), Chem. Eng. Sci.
59:525-541.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, one_material

NAME = "hooke"
DIMENSIONS = (3,)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False


class HookeParameters(NamedTuple):
    """Contact of two grains of one material."""

    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]
    friction_coefficient: float  # mu [-]
    restitution: float  # e [-]
    characteristic_velocity: float  # V [m/s]


PARAMETERS = HookeParameters


def spring(young_modulus, poisson_ratio, characteristic_velocity, radius_a, radius_b, mass_a, mass_b):
    """k [N/m] in both directions: 16/15 sqrt(R*) E* (15 m* V^2/(16 sqrt(R*) E*))^(1/5)."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    root = math.sqrt(radius_a * radius_b / (radius_a + radius_b))
    mass = mass_a * mass_b / (mass_a + mass_b)
    return (
        16.0 / 15.0 * root * modulus
        * (15.0 * mass * characteristic_velocity * characteristic_velocity / (16.0 * root * modulus)) ** 0.2
    )  # fmt: skip


def force(
    young_modulus, poisson_ratio, friction_coefficient, restitution, characteristic_velocity,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, mass_a, mass_b, time_step, closing,
    shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = k u + c vn, Fs = k s + c vs with |k s| <= mu |Fn|; where k s is cut, without c vs.

    c = sqrt(4 m* k L^2/(L^2 + pi^2)), L = ln e.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the spring's shear force [N].
    """
    k = spring(young_modulus, poisson_ratio, characteristic_velocity, radius_a, radius_b, mass_a, mass_b)
    logarithm = math.log(restitution)
    damping = math.sqrt(
        4.0 * mass_a * mass_b / (mass_a + mass_b) * k
        * (logarithm * logarithm / (logarithm * logarithm + math.pi * math.pi))
    )  # fmt: skip
    normal = k * overlap + damping * closing / time_step
    x = shear_x + k * slip_x
    y = shear_y + k * slip_y
    z = shear_z + k * slip_z
    limit = friction_coefficient * abs(normal)
    squared = x * x + y * y + z * z
    slides = squared > limit * limit
    keep = limit / math.sqrt(squared) if slides else 1.0
    drag = 0.0 if slides else damping / time_step
    x *= keep
    y *= keep
    z *= keep
    return normal, x + drag * slip_x, y + drag * slip_y, z + drag * slip_z, x, y, z


def energy(
    young_modulus, poisson_ratio, characteristic_velocity, overlap, radius_a, radius_b, mass_a, mass_b,
    shear_x, shear_y, shear_z,
):  # fmt: skip
    """Elastic energy k u^2/2 + Fs^2/(2 k) [J]."""
    k = spring(young_modulus, poisson_ratio, characteristic_velocity, radius_a, radius_b, mass_a, mass_b)
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (k * overlap * overlap + squared / k)


def stiffness(young_modulus, poisson_ratio, characteristic_velocity, radius_a, radius_b, mass_a, mass_b):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    k = spring(young_modulus, poisson_ratio, characteristic_velocity, radius_a, radius_b, mass_a, mass_b)
    return k, k, 0.0, 0.0


def combine(first: HookeParameters, second: HookeParameters) -> HookeParameters:
    """Contact of two materials as one of equivalent E and nu: 1/E* and 1/G* are the sums of the halves of both.

    1/E* = sum (1 - nu^2)/E, 1/G* = sum 2 (2 - nu)(1 + nu)/E; the smaller friction, restitution and velocity.
    """
    young, poisson = one_material(
        first.young_modulus, first.poisson_ratio, second.young_modulus, second.poisson_ratio
    )
    return HookeParameters(
        young,
        poisson,
        min(first.friction_coefficient, second.friction_coefficient),
        min(first.restitution, second.restitution),
        min(first.characteristic_velocity, second.characteristic_velocity),
    )


def against_rigid(parameters: HookeParameters) -> HookeParameters:
    """Contact with a rigid wall: the sphere's own half of the contact, twice as stiff."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters: HookeParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters,
        positive=("young_modulus", "restitution", "characteristic_velocity"),
        not_negative=("friction_coefficient",),
    )
    bad = {fault.field for fault in found}
    if "poisson_ratio" not in bad and not -1.0 < parameters.poisson_ratio <= 0.5:
        found.append(Fault("poisson_ratio", "must be above -1 and at most 0.5", "Give 0.25, for instance"))
    if "restitution" not in bad and parameters.restitution > 1.0:
        found.append(Fault("restitution", "must be at most 1", "Give 1 for a bounce without loss"))
    return found
