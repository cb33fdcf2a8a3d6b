"""Linear contact with Coulomb friction, both forces summed up step by step (DICE2D's contact).

Reference: Zhao (2015), High Performance Computing and the Discrete Element Model, ch. 1, eqs 1.20-1.44. The normal
force adds up kn times the approach and is never tensile. Pressed from touch on it equals kn times the overlap;
after it was lost at zero it starts anew, at any overlap.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "linear_incremental"
DIMENSIONS = (2, 3)
SCALAR = ("normal",)
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = True


class LinearIncrementalParameters(NamedTuple):
    """Stiffness of the contact of two equal grains of one material."""

    normal_stiffness: float  # kn [N/m]
    shear_stiffness: float  # ks [N/m]
    friction_coefficient: float  # mu [-]
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = LinearIncrementalParameters


def force(
    normal_stiffness, shear_stiffness, friction_coefficient,
    approach, slip_x, slip_y, slip_z, normal, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = Fn + kn approach >= 0, Fs = Fs + ks slip with |Fs| <= mu Fn.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    normal, shear_x, shear_y, shear_z : float
        History: the normal and the shear force [N].
    """
    pressed = normal + normal_stiffness * approach
    pressed = pressed if pressed > 0.0 else 0.0
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    limit = friction_coefficient * pressed
    squared = x * x + y * y + z * z
    keep = limit / math.sqrt(squared) if squared > limit * limit else 1.0
    x *= keep
    y *= keep
    z *= keep
    return pressed, x, y, z, pressed, x, y, z


def viscous(
    normal_stiffness, shear_stiffness, normal_viscosity, shear_viscosity,
    approach, slip_x, slip_y, slip_z, time_step,
):  # fmt: skip
    """Viscous force eta k v [N]: normal, shear x, y, z."""
    normal = normal_viscosity * normal_stiffness / time_step
    shear = shear_viscosity * shear_stiffness / time_step
    return normal * approach, shear * slip_x, shear * slip_y, shear * slip_z


def energy(normal_stiffness, shear_stiffness, normal, shear_x, shear_y, shear_z):
    """Elastic energy Fn^2/(2 kn) + Fs^2/(2 ks) [J]."""
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (normal * normal / normal_stiffness + squared / shear_stiffness)


def stiffness(normal_stiffness, shear_stiffness):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    return normal_stiffness, shear_stiffness, 0.0, 0.0


def combine(
    first: LinearIncrementalParameters, second: LinearIncrementalParameters
) -> LinearIncrementalParameters:
    """Contact of two materials: springs in series, the smaller friction, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("friction_coefficient",),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: LinearIncrementalParameters) -> LinearIncrementalParameters:
    """Contact with a rigid wall: the grain's own half of the spring, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: LinearIncrementalParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=("friction_coefficient", "normal_viscosity", "shear_viscosity"),
    )
