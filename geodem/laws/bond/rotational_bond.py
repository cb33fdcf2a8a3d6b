"""Bond of four springs, along, across, twisting and bending, that breaks where their shares of strength add up to one.

Reference: Wang & Mora (2009), The ESyS_Particle: a new 3-D discrete element model with single particle rotation, in
Advances in Geocomputing, Lecture Notes in Earth Sciences 119:183-228. The criterion, with pressure counted against
the other three, is that of LAMMPS (bond_style bpm/rotational, documentation). They find the shear force and the
moments from the whole rotation since bonding, here they are added up step by step; both are the same for small
rotations. The normal force follows from the whole change of distance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "rotational_bond"
DIMENSIONS = (2, 3)
SCALAR: tuple[str, ...] = ()
TANGENTIAL = ("shear", "bending")
AXIAL = ("twisting",)
MOMENT = True
VISCOUS = True
REPLACES_CONTACT = True


class RotationalBondParameters(NamedTuple):
    """Bond of two equal grains of one material, whatever their size. Nothing twists between discs."""

    normal_stiffness: float  # kr [N/m]
    shear_stiffness: float  # ks [N/m]
    twisting_stiffness: float  # kt [N m/rad]
    bending_stiffness: float  # kb [N m/rad]
    tensile_strength: float  # frc [N]
    shear_strength: float  # fsc [N]
    twisting_strength: float  # Mtc [N m]
    bending_strength: float  # Mbc [N m]
    normal_viscosity: float = 0.0  # eta_n [s]
    shear_viscosity: float = 0.0  # eta_s [s]


PARAMETERS = RotationalBondParameters


def bonded():
    """History of a new bond: no shear force, no bending, no twisting moment."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def force(
    normal_stiffness, shear_stiffness, twisting_stiffness, bending_stiffness,
    tensile_strength, shear_strength, twisting_strength, bending_strength,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, scale,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Forces and moments of the intact bond after a step, and how much of its strength they take.

    Fn = kr u, dFs = ks slip, dMt = kt twist, dMb = kb bend. With T = -Fn/frc + |Mb|/Mbc (drawn and bent) and
    S = |Fs|/fsc + |Mt|/Mtc (sheared and twisted) it breaks where T + S = 1, in the mode of the larger. The
    utilisations T + min(T, S) and S + min(T, S) say that: the larger of the two is T + S.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    shear_x, ..., bending_z, twisting : float
        History: shear force [N], bending and twisting moment [N m].
    tension_utilisation, shear_utilisation : float
        [-], proportional to the forces; 1 at the strength times `scale`.
    """
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    bent_x = bending_x + bending_stiffness * bend_x
    bent_y = bending_y + bending_stiffness * bend_y
    bent_z = bending_z + bending_stiffness * bend_z
    twisted = twisting + twisting_stiffness * twist
    bending = math.sqrt(bent_x * bent_x + bent_y * bent_y + bent_z * bent_z)
    shear = math.sqrt(x * x + y * y + z * z)
    drawn = (bending / bending_strength - normal / tensile_strength) / scale
    sheared = (shear / shear_strength + abs(twisted) / twisting_strength) / scale
    smaller = drawn if drawn < sheared else sheared
    return (
        normal, x, y, z,
        twisted, bent_x, bent_y, bent_z,
        x, y, z, bent_x, bent_y, bent_z, twisted,
        drawn + smaller, sheared + smaller,
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
    normal_stiffness, shear_stiffness, twisting_stiffness, bending_stiffness, overlap,
    shear_x, shear_y, shear_z, bending_x, bending_y, bending_z, twisting,
):  # fmt: skip
    """Elastic energy kr u^2/2 + Fs^2/(2 ks) + Mt^2/(2 kt) + Mb^2/(2 kb) [J]; a spring that is not there has none."""
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    bending = bending_x * bending_x + bending_y * bending_y + bending_z * bending_z
    return 0.5 * (
        normal_stiffness * overlap * overlap
        + shear / shear_stiffness
        + (bending / bending_stiffness if bending_stiffness > 0.0 else 0.0)
        + (twisting * twisting / twisting_stiffness if twisting_stiffness > 0.0 else 0.0)
    )


def stiffness(normal_stiffness, shear_stiffness, twisting_stiffness, bending_stiffness):
    """Tangent stiffness kr, ks [N/m], twist kt, bend kb [N m/rad]."""
    return normal_stiffness, shear_stiffness, twisting_stiffness, bending_stiffness


def combine(first: RotationalBondParameters, second: RotationalBondParameters) -> RotationalBondParameters:
    """Bond of two materials: springs in series, the smaller strength, the mean viscosity."""
    return mixed(
        first,
        second,
        series=("normal_stiffness", "shear_stiffness", "twisting_stiffness", "bending_stiffness"),
        smaller=("tensile_strength", "shear_strength", "twisting_strength", "bending_strength"),
        mean=("normal_viscosity", "shear_viscosity"),
    )


def against_rigid(parameters: RotationalBondParameters) -> RotationalBondParameters:
    """Bond to a rigid wall: the grain's own half of the springs, twice as stiff."""
    return parameters._replace(
        normal_stiffness=2.0 * parameters.normal_stiffness,
        shear_stiffness=2.0 * parameters.shear_stiffness,
        twisting_stiffness=2.0 * parameters.twisting_stiffness,
        bending_stiffness=2.0 * parameters.bending_stiffness,
    )


def check(parameters: RotationalBondParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    strengths = ("tensile_strength", "shear_strength", "twisting_strength", "bending_strength")
    return faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness", *strengths),
        not_negative=("twisting_stiffness", "bending_stiffness", "normal_viscosity", "shear_viscosity"),
        may_be_infinite=strengths,
    )
