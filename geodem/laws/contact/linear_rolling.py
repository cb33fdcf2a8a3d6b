"""Linear contact with friction that resists rolling and twisting as well: two more springs, each with its slider.

Spring and slider along and across the normal: Cundall & Strack (1979), Geotechnique 29:47-65. Rolling: the
elastic-plastic spring-slider without dashpot of Ai, Chen, Rotter & Ooi (2011), Assessment of rolling resistance models
in discrete element simulations, Powder Technology 206:269-282 (their type C), with the stiffness ks R*^2 after Iwashita
& Oda (1998), Journal of Engineering Mechanics 124:285-292. Twisting in the same form.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "linear_rolling"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear", "rolling")
AXIAL = ("twisting",)
MOMENT = True
VISCOUS = True


class LinearRollingParameters(NamedTuple):
    """Stiffness of the contact of two equal grains of one material. Nothing twists between discs."""

    normal_stiffness: float  # kn [N/m]
    shear_stiffness: float  # ks [N/m]
    friction_coefficient: float  # mu [-]
    rolling_friction: float  # mu_r [-]
    twisting_friction: float = 0.0  # mu_t [-]
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = LinearRollingParameters


def force(
    normal_stiffness, shear_stiffness, friction_coefficient, rolling_friction, twisting_friction,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b,
    shear_x, shear_y, shear_z, rolling_x, rolling_y, rolling_z, twisting,
):  # fmt: skip
    """Forces and moments after a step, 1/R* = 1/ra + 1/rb.

    Fn = kn u, Fs = Fs + ks slip, Mr = Mr + ks R*^2 bend, Mt = Mt + ks R*^2 twist, with |Fs| <= mu Fn,
    |Mr| <= mu_r R* Fn, |Mt| <= mu_t R* Fn.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    shear_x, ..., rolling_z, twisting : float
        History: shear force [N], rolling and twisting moment [N m].
    """
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
    radius = radius_a * radius_b / (radius_a + radius_b)
    spring = shear_stiffness * radius * radius
    rolled_x = rolling_x + spring * bend_x
    rolled_y = rolling_y + spring * bend_y
    rolled_z = rolling_z + spring * bend_z
    most = rolling_friction * radius * normal
    size = rolled_x * rolled_x + rolled_y * rolled_y + rolled_z * rolled_z
    left = most / math.sqrt(size) if size > most * most else 1.0
    rolled_x *= left
    rolled_y *= left
    rolled_z *= left
    twisted = twisting + spring * twist
    largest = twisting_friction * radius * normal
    twisted = largest if twisted > largest else twisted
    twisted = -largest if twisted < -largest else twisted
    return (
        normal, x, y, z,
        twisted, rolled_x, rolled_y, rolled_z,
        x, y, z, rolled_x, rolled_y, rolled_z, twisted,
    )  # fmt: skip


def viscous(
    normal_stiffness, shear_stiffness, normal_viscosity, shear_viscosity,
    approach, slip_x, slip_y, slip_z, time_step,
):  # fmt: skip
    """Viscous force eta k v [N]: normal, shear x, y, z. The moments have none."""
    normal = normal_viscosity * normal_stiffness / time_step
    shear = shear_viscosity * shear_stiffness / time_step
    return normal * approach, shear * slip_x, shear * slip_y, shear * slip_z


def energy(
    normal_stiffness, shear_stiffness, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, rolling_x, rolling_y, rolling_z, twisting,
):  # fmt: skip
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) + (Mr^2 + Mt^2)/(2 ks R*^2) [J]."""
    radius = radius_a * radius_b / (radius_a + radius_b)
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    moment = rolling_x * rolling_x + rolling_y * rolling_y + rolling_z * rolling_z + twisting * twisting
    return 0.5 * (
        normal_stiffness * overlap * overlap + (shear + moment / (radius * radius)) / shear_stiffness
    )


def stiffness(normal_stiffness, shear_stiffness, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist, bend, both ks R*^2 [N m/rad]."""
    radius = radius_a * radius_b / (radius_a + radius_b)
    spring = shear_stiffness * radius * radius
    return normal_stiffness, shear_stiffness, spring, spring


def combine(first: LinearRollingParameters, second: LinearRollingParameters) -> LinearRollingParameters:
    """Contact of two materials: springs in series, the smaller friction of each kind, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("friction_coefficient", "rolling_friction", "twisting_friction"),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: LinearRollingParameters) -> LinearRollingParameters:
    """Contact with a rigid wall: the grain's own half of the springs, twice as stiff; R* is the radius."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: LinearRollingParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=(
            "friction_coefficient",
            "rolling_friction",
            "twisting_friction",
            "normal_viscosity",
            "shear_viscosity",
        ),
    )
