"""Linear contact with friction that sticks: once touched it holds tension up to an adhesion force.

Two grains that touched stay in contact over a gap of at most adhesion/kn (`reach`), where the spring pulls with
the adhesion force; beyond it the contact is lost with what it stored, and only a new touch makes a new one. So
the force has one value for each overlap while the contact lives, and the pair gives back no more than was put in.

References: the linear contact of Cundall & Strack (1979), Geotechnique 29:47-65, with the pull-off force and the
Mohr-Coulomb limit of shear of sticky grains: Luding (2008), Cohesive, frictional powders, Granular Matter
10:235-246, with unloading as stiff as loading.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "cohesive_frictional"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = True


class CohesiveFrictionalParameters(NamedTuple):
    """Stiffness of the contact of two equal grains of one material."""

    normal_stiffness: float  # kn [N/m]
    shear_stiffness: float  # ks [N/m]
    friction_coefficient: float  # mu [-]
    adhesion: float  # Fa [N]: largest tension
    adhesion_shear: float = 0.0  # Fc [N]: shear force held without any normal force
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = CohesiveFrictionalParameters


def force(
    normal_stiffness, shear_stiffness, friction_coefficient, adhesion_shear,
    overlap, slip_x, slip_y, slip_z, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = kn u, Fs = Fs + ks slip with |Fs| <= max(Fc + mu Fn, 0).

    Called while overlap > 0 and, once touched, while overlap > -reach.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart where positive, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the shear force [N].
    """
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    limit = adhesion_shear + friction_coefficient * normal
    limit = limit if limit > 0.0 else 0.0
    squared = x * x + y * y + z * z
    keep = limit / math.sqrt(squared) if squared > limit * limit else 1.0
    x *= keep
    y *= keep
    z *= keep
    return normal, x, y, z, x, y, z


def reach(normal_stiffness, adhesion):
    """Gap up to which a contact that has touched lives on [m]: Fa/kn."""
    return adhesion / normal_stiffness


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
    first: CohesiveFrictionalParameters, second: CohesiveFrictionalParameters
) -> CohesiveFrictionalParameters:
    """Contact of two materials: springs in series, the smaller friction and adhesion, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("friction_coefficient", "adhesion", "adhesion_shear"),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: CohesiveFrictionalParameters) -> CohesiveFrictionalParameters:
    """Contact with a rigid wall: the grain's own half of the spring, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: CohesiveFrictionalParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=(
            "friction_coefficient",
            "adhesion",
            "adhesion_shear",
            "normal_viscosity",
            "shear_viscosity",
        ),
    )
