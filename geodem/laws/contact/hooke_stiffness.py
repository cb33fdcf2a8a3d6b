"""Linear contact with dashpots and Coulomb friction on their sum: LIGGGHTS' and LAMMPS' hooke, by given stiffness.

The dashpots' coefficients are given over the effective mass of the two, so light and heavy grains bounce alike.
Friction is cut by the normal force with its dashpot; where the contact slides the dashpot in shear rests. The normal
force may pull for a moment before the two part.

References: Silbert et al. (2001), Granular flow down an inclined plane, Phys. Rev. E 64:051302; Kloss et al. (2012),
Prog. Comput. Fluid Dyn. 12:140-152.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "hooke_stiffness"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
VISCOUS = False


class HookeStiffnessParameters(NamedTuple):
    """Contact of two grains of one material."""

    normal_stiffness: float  # kn [N/m]
    shear_stiffness: float  # kt [N/m]
    friction_coefficient: float  # mu [-]
    normal_damping: float = 0.0  # gamma_n [1/s], times the effective mass
    shear_damping: float = 0.0  # gamma_t [1/s], the same


PARAMETERS = HookeStiffnessParameters


def force(
    normal_stiffness, shear_stiffness, friction_coefficient, normal_damping, shear_damping,
    overlap, slip_x, slip_y, slip_z, mass_a, mass_b, time_step, closing, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step: Fn = kn u + cn vn, Fs = kt s + ct vs with |kt s| <= mu |Fn|, c = gamma times the mass.

    Where kt s is cut, Fs = mu |Fn| along it, and s is what such a spring would have.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]; normal pushes the two apart, shear is the force on a.
    shear_x, shear_y, shear_z : float
        History: the spring's shear force [N].
    """
    mass = mass_a * mass_b / (mass_a + mass_b)
    normal = normal_stiffness * overlap + normal_damping * mass * closing / time_step
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    limit = friction_coefficient * abs(normal)
    squared = x * x + y * y + z * z
    slides = squared > limit * limit
    keep = limit / math.sqrt(squared) if slides else 1.0
    drag = 0.0 if slides else shear_damping * mass / time_step
    x *= keep
    y *= keep
    z *= keep
    return normal, x + drag * slip_x, y + drag * slip_y, z + drag * slip_z, x, y, z


def energy(normal_stiffness, shear_stiffness, overlap, shear_x, shear_y, shear_z):
    """Elastic energy kn u^2/2 + Fs^2/(2 kt) [J]."""
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (normal_stiffness * overlap * overlap + squared / shear_stiffness)


def stiffness(normal_stiffness, shear_stiffness):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    return normal_stiffness, shear_stiffness, 0.0, 0.0


def combine(first: HookeStiffnessParameters, second: HookeStiffnessParameters) -> HookeStiffnessParameters:
    """Contact of two materials: springs in series, the smaller friction, the mean damping."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("friction_coefficient",),
        mean=("normal_damping", "shear_damping"),
    )


def against_rigid(parameters: HookeStiffnessParameters) -> HookeStiffnessParameters:
    """Contact with a rigid wall: the grain's own half of the spring, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: HookeStiffnessParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=("friction_coefficient", "normal_damping", "shear_damping"),
    )
