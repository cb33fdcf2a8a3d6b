"""Linear contact with Coulomb friction: a spring along the normal, a spring across it, and a slider.

Reference: Cundall & Strack (1979), A discrete numerical model for granular assemblies, Geotechnique 29:47-65.
The normal force follows from the whole overlap, so nothing drifts. Viscosity in the form of Zhao (2015), High
Performance Computing and the Discrete Element Model, eqs 1.31-1.32.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "linear_frictional"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = True


class LinearFrictionalParameters(NamedTuple):
    """Stiffness of the contact of two equal grains of one material."""

    normal_stiffness: float  # kn [N/m]
    shear_stiffness: float  # ks [N/m]
    friction_coefficient: float  # mu [-]
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = LinearFrictionalParameters


def force(
    normal_stiffness, shear_stiffness, friction_coefficient,
    overlap, slip_x, slip_y, slip_z, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = kn u, Fs = Fs + ks slip with |Fs| <= mu Fn.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the shear force [N].
    """
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    limit = friction_coefficient * normal
    squared = x * x + y * y + z * z
    # a branch where pairs are computed one by one: most contacts hold, and a root and a quotient take long
    if squared > limit * limit:
        keep = limit / math.sqrt(squared)
        x *= keep
        y *= keep
        z *= keep
    return normal, x, y, z, x, y, z


def viscous(
    normal_stiffness, shear_stiffness, normal_viscosity, shear_viscosity,
    approach, slip_x, slip_y, slip_z, time_step,
):  # fmt: skip
    """Viscous force eta k v [N]: normal, shear x, y, z."""
    normal = normal_viscosity * normal_stiffness / time_step
    shear = shear_viscosity * shear_stiffness / time_step
    return normal * approach, shear * slip_x, shear * slip_y, shear * slip_z


def energy(normal_stiffness, shear_stiffness, overlap, shear_x, shear_y, shear_z):
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) [J]."""
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (normal_stiffness * overlap * overlap + squared / shear_stiffness)


def stiffness(normal_stiffness, shear_stiffness):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    return normal_stiffness, shear_stiffness, 0.0, 0.0


def combine(
    first: LinearFrictionalParameters, second: LinearFrictionalParameters
) -> LinearFrictionalParameters:
    """Contact of two materials: springs in series, the smaller friction, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("friction_coefficient",),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: LinearFrictionalParameters) -> LinearFrictionalParameters:
    """Contact with a rigid wall: the grain's own half of the spring, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: LinearFrictionalParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=("friction_coefficient", "normal_viscosity", "shear_viscosity"),
    )
