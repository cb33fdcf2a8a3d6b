"""Hertz's contact of elastic spheres: a normal force, stiffer the deeper, without friction.

Reference: Johnson (1985), Contact Mechanics, Cambridge University Press, ch. 4, eqs 4.23 and 4.24 (Hertz 1882).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, harmonic_mean

NAME = "hertz"
DIMENSIONS = (3,)
SCALAR: tuple[str, ...] = ()
TANGENTIAL: tuple[str, ...] = ()
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False


class HertzParameters(NamedTuple):
    """Elastic constants of the two spheres that touch, as if both were of one material."""

    young_modulus: float  # E [Pa]
    poisson_ratio: float  # nu [-]


PARAMETERS = HertzParameters


def force(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Force at an overlap u: Fn = 4/3 E* sqrt(R*) u^1.5, E* = E/(2 (1 - nu^2)), 1/R* = 1/ra + 1/rb.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, there is no shear.
    """
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    pressed = overlap if overlap > 0.0 else 0.0
    return 4.0 / 3.0 * modulus * math.sqrt(radius * pressed) * pressed, 0.0, 0.0, 0.0


def energy(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Elastic energy 8/15 E* sqrt(R*) u^2.5 [J]."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    pressed = overlap if overlap > 0.0 else 0.0
    return 8.0 / 15.0 * modulus * math.sqrt(radius * pressed) * pressed * pressed


def stiffness(young_modulus, poisson_ratio, overlap, radius_a, radius_b):
    """Tangent stiffness kn = 2 E* sqrt(R* u), ks [N/m], twist, bend [N m/rad]: nothing before the two touch."""
    modulus = 0.5 * young_modulus / (1.0 - poisson_ratio * poisson_ratio)
    radius = radius_a * radius_b / (radius_a + radius_b)
    pressed = overlap if overlap > 0.0 else 0.0
    return 2.0 * modulus * math.sqrt(radius * pressed), 0.0, 0.0, 0.0


def combine(first: HertzParameters, second: HertzParameters) -> HertzParameters:
    """Contact of two materials: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, told as one material of the mean nu."""
    ratio = 0.5 * first.poisson_ratio + 0.5 * second.poisson_ratio
    # E/(1 - nu^2) over the share that the mean takes away again: exactly E for two equal materials
    share_first = (1.0 - ratio * ratio) / (1.0 - first.poisson_ratio * first.poisson_ratio)
    share_second = (1.0 - ratio * ratio) / (1.0 - second.poisson_ratio * second.poisson_ratio)
    return HertzParameters(
        harmonic_mean(first.young_modulus * share_first, second.young_modulus * share_second), ratio
    )


def against_rigid(parameters: HertzParameters) -> HertzParameters:
    """Contact with a rigid wall, E* = E/(1 - nu^2): the sphere's own half of the contact, twice as stiff."""
    return parameters._replace(young_modulus=2.0 * parameters.young_modulus)


def check(parameters: HertzParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(parameters, positive=("young_modulus",))
    if not any(fault.field == "poisson_ratio" for fault in found) and not (
        -1.0 < parameters.poisson_ratio <= 0.5
    ):
        found.append(Fault("poisson_ratio", "must be above -1 and at most 0.5", "Give 0.25, for instance"))
    return found
