"""Bond of two normal springs side by side and one shear spring, 2D (DICE2D's bond).

Reference: Zhao (2015), High Performance Computing and the Discrete Element Model, ch. 1, eqs 1.17-1.35. The
springs stand a width db = width_ratio * (smaller diameter) apart and carry half of kn each; each one is
Mohr-Coulomb with a tension cut-off, so pressure raises the strength in shear. The book adds the normal force up
step by step; here it follows from the whole change of distance, which is the same and cannot drift.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "two_springs"
DIMENSIONS = (2,)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear", "rotation")
AXIAL: tuple[str, ...] = ()
MOMENT = True
VISCOUS = True
REPLACES_CONTACT = True


class TwoSpringsParameters(NamedTuple):
    """Stiffness of the bond of two equal grains of one material, per metre of depth where forces are."""

    normal_stiffness: float  # kn [N/m], of both springs together
    shear_stiffness: float  # ks [N/m]
    tensile_strength: float  # Ft [N], of both springs together
    cohesion: float  # Fc [N], of both springs together
    friction_coefficient: float  # tan(phi) [-]
    width_ratio: float  # WRT [-]: distance of the springs over the smaller diameter
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = TwoSpringsParameters


def bonded():
    """History of a new bond: no shear force, no rotation."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def force(
    normal_stiffness, shear_stiffness, tensile_strength, cohesion, friction_coefficient, width_ratio,
    overlap, slip_x, slip_y, slip_z, bend_x, bend_y, bend_z, radius_a, radius_b, scale,
    shear_x, shear_y, shear_z, rotation_x, rotation_y, rotation_z,
):  # fmt: skip
    """Forces of the intact bond after a step, and how much of its strength they take.

    Spring forces (pressure positive) kn u/2 +- kn db theta/4, moment kn db^2 theta/4. Tension: -F >= Ft/2;
    shear: |Fs|/2 >= F tan(phi) + Fc/2, both for the less pressed spring. Utilisations are proportional to
    the forces, so a bond under a proportional load breaks at 1/utilisation of it.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    shear_x, ..., rotation_z : float
        History: shear force [N], relative rotation theta [rad].
    tension_utilisation, shear_utilisation : float
        [-], 1 at the strength times `scale`.
    """
    width = 2.0 * width_ratio * (radius_a if radius_a < radius_b else radius_b)
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    turned_x = rotation_x + bend_x
    turned_y = rotation_y + bend_y
    turned_z = rotation_z + bend_z
    lever = 0.25 * normal_stiffness * width
    turned = math.sqrt(turned_x * turned_x + turned_y * turned_y + turned_z * turned_z)
    least = 0.5 * normal - lever * turned
    shear = math.sqrt(x * x + y * y + z * z)
    tension_utilisation = -2.0 * least / (scale * tensile_strength)
    shear_utilisation = (shear - 2.0 * friction_coefficient * least) / (scale * cohesion)
    moment = lever * width
    return (
        normal, x, y, z,
        0.0, moment * turned_x, moment * turned_y, moment * turned_z,
        x, y, z, turned_x, turned_y, turned_z,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def viscous(
    normal_stiffness, shear_stiffness, normal_viscosity, shear_viscosity,
    approach, slip_x, slip_y, slip_z, time_step,
):  # fmt: skip
    """Viscous force eta k v [N]: normal, shear x, y, z. The moment has none."""
    normal = normal_viscosity * normal_stiffness / time_step
    shear = shear_viscosity * shear_stiffness / time_step
    return normal * approach, shear * slip_x, shear * slip_y, shear * slip_z


def energy(
    normal_stiffness, shear_stiffness, width_ratio, overlap, radius_a, radius_b,
    shear_x, shear_y, shear_z, rotation_x, rotation_y, rotation_z,
):  # fmt: skip
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) + kn db^2 theta^2/8 [J]."""
    width = 2.0 * width_ratio * (radius_a if radius_a < radius_b else radius_b)
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    turned = rotation_x * rotation_x + rotation_y * rotation_y + rotation_z * rotation_z
    bending = 0.25 * normal_stiffness * width * width * turned
    return 0.5 * (normal_stiffness * overlap * overlap + shear / shear_stiffness + bending)


def stiffness(normal_stiffness, shear_stiffness, width_ratio, radius_a, radius_b):
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    width = 2.0 * width_ratio * (radius_a if radius_a < radius_b else radius_b)
    return normal_stiffness, shear_stiffness, 0.0, 0.25 * normal_stiffness * width * width


def combine(first: TwoSpringsParameters, second: TwoSpringsParameters) -> TwoSpringsParameters:
    """Bond of two materials: springs in series, the smaller strength and width, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness"),
        smaller=("tensile_strength", "cohesion", "friction_coefficient", "width_ratio"),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: TwoSpringsParameters) -> TwoSpringsParameters:
    """Bond to a rigid wall: the grain's own half of the springs, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness, shear_stiffness=2.0 * parameters.shear_stiffness
    )


def check(parameters: TwoSpringsParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness", "tensile_strength", "cohesion"),
        not_negative=("friction_coefficient", "width_ratio", "normal_viscosity", "shear_viscosity"),
        may_be_infinite=("tensile_strength", "cohesion"),
    )
