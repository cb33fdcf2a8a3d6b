"""Bond of two grains that carries forces and, by the whole rotation since it was made, moments: YADE's CohFrict.

Stiffness follows from modulus and radii as in `geodem.laws.contact.elastic_frictional`, which goes on where the bond
breaks. Moments follow from the relative rotation as one vector, so they do not depend on the way to it; they do not
break the bond.

References: Bourrier, Kneib, Chareyre & Fourcaud (2013), Ecological Engineering 61:646-657; Smilauer et al. (2021), Yade
documentation, 3rd ed. (Law2_ScGeom6D_CohFrictPhys_CohesionMoment with fragile bonds, as in its version 2023.02a).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, harmonic_mean

NAME = "cohesive_moments"
DIMENSIONS = (3,)
SCALAR = ("turn_w", "turn_x", "turn_y", "turn_z", "twisted", "bent")
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = True
VISCOUS = False
REPLACES_CONTACT = True


class CohesiveMomentsParameters(NamedTuple):
    """A grain's material, and that of the one it is bonded to, which is filled in where two materials meet."""

    young_modulus: float  # E [Pa]
    stiffness_ratio: float  # ks/kn [-]
    friction_coefficient: float  # mu [-]
    normal_cohesion: float  # [Pa], times the square of the smaller radius
    shear_cohesion: float  # [Pa], the same
    bending_factor: float = 0.0  # alpha_kr [-]: kr = alpha r1 r2 ks
    twisting_factor: float = 0.0  # alpha_ktw [-]
    other_young_modulus: float = math.nan  # [Pa]
    other_stiffness_ratio: float = math.nan  # [-]


PARAMETERS = CohesiveMomentsParameters


def springs(young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b):
    """kn, ks [N/m]: 2 k1 k2/(k1 + k2), of kn with k = E r, of ks with k = (ks/kn) E r."""
    one_normal = young_modulus * radius_a
    other_normal = other_young_modulus * radius_b
    one_shear = stiffness_ratio * one_normal
    other_shear = other_stiffness_ratio * other_normal
    return (
        2.0 * one_normal * other_normal / (one_normal + other_normal),
        2.0 * one_shear * other_shear / (one_shear + other_shear),
    )


def bonded():
    """History of a new bond: no rotation (all zero: not even the rotation of the step in which it is made)."""
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def turned(w, x, y, z, ax, ay, az, bx, by, bz):
    """Relative rotation q of b against a after a step: rot(b) q rot(a)^-1, with rotation vectors of the step."""
    size_a = math.sqrt(ax * ax + ay * ay + az * az)
    size_b = math.sqrt(bx * bx + by * by + bz * bz)
    # sin(half)/size, whose limit is 1/2
    share_a = math.sin(0.5 * size_a) / size_a if size_a > 1e-9 else 0.5
    share_b = math.sin(0.5 * size_b) / size_b if size_b > 1e-9 else 0.5
    aw = math.cos(0.5 * size_a)
    bw = math.cos(0.5 * size_b)
    ax *= -share_a
    ay *= -share_a
    az *= -share_a
    bx *= share_b
    by *= share_b
    bz *= share_b
    pw = bw * w - bx * x - by * y - bz * z
    px = bw * x + bx * w + by * z - bz * y
    py = bw * y - bx * z + by * w + bz * x
    pz = bw * z + bx * y - by * x + bz * w
    qw = pw * aw - px * ax - py * ay - pz * az
    qx = pw * ax + px * aw + py * az - pz * ay
    qy = pw * ay - px * az + py * aw + pz * ax
    qz = pw * az + px * ay - py * ax + pz * aw
    return qw, qx, qy, qz


def force(
    young_modulus, stiffness_ratio, friction_coefficient, normal_cohesion, shear_cohesion,
    bending_factor, twisting_factor, other_young_modulus, other_stiffness_ratio,
    overlap, slip_x, slip_y, slip_z, radius_a, radius_b, scale, normal_x, normal_y, normal_z,
    rotation_a_x, rotation_a_y, rotation_a_z, rotation_b_x, rotation_b_y, rotation_b_z,
    turn_w, turn_x, turn_y, turn_z, twisted, bent, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces and moments of the intact bond after a step, and how much of its strength they take.

    Fn = kn u, dFs = ks slip; with the relative rotation theta as a vector Mt = kt theta.n, Mb = kr (theta - theta.n n).
    Breaks in tension at -Fn = cn r^2, in shear at |Fs| = cs r^2 + mu Fn, r the smaller radius.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    turn_w, ..., bent, shear_x, shear_y, shear_z : float
        History: relative rotation as a quaternion, its angles about and across the normal [rad], shear force [N].
    tension_utilisation, shear_utilisation : float
        [-]
    """
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    least = radius_a if radius_a < radius_b else radius_b
    normal = normal_stiffness * overlap
    x = shear_x + shear_stiffness * slip_x
    y = shear_y + shear_stiffness * slip_y
    z = shear_z + shear_stiffness * slip_z
    fresh = turn_w == 0.0 and turn_x == 0.0 and turn_y == 0.0 and turn_z == 0.0
    qw, qx, qy, qz = turned(
        turn_w, turn_x, turn_y, turn_z,
        rotation_a_x, rotation_a_y, rotation_a_z, rotation_b_x, rotation_b_y, rotation_b_z,
    )  # fmt: skip
    qw = 1.0 if fresh else qw
    size = math.sqrt(qx * qx + qy * qy + qz * qz)
    # the shorter way round
    sign = -1.0 if qw < 0.0 else 1.0
    angle = 2.0 * math.atan2(size, sign * qw)
    share = sign * angle / size if size > 0.0 else 0.0
    tx = share * qx
    ty = share * qy
    tz = share * qz
    about = tx * normal_x + ty * normal_y + tz * normal_z
    bx = tx - about * normal_x
    by = ty - about * normal_y
    bz = tz - about * normal_z
    bend_stiffness = bending_factor * radius_a * radius_b * shear_stiffness
    twist_stiffness = twisting_factor * radius_a * radius_b * shear_stiffness
    across = math.sqrt(bx * bx + by * by + bz * bz)
    shear = math.sqrt(x * x + y * y + z * z)
    area = least * least
    tension_utilisation = -normal / (scale * normal_cohesion * area)
    shear_utilisation = (shear - friction_coefficient * normal) / (scale * shear_cohesion * area)
    return (
        normal, x, y, z,
        twist_stiffness * about, bend_stiffness * bx, bend_stiffness * by, bend_stiffness * bz,
        qw, qx, qy, qz, about, across, x, y, z,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def energy(
    young_modulus, stiffness_ratio, bending_factor, twisting_factor, other_young_modulus, other_stiffness_ratio,
    overlap, radius_a, radius_b, twisted, bent, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Elastic energy kn u^2/2 + Fs^2/(2 ks) + kr bent^2/2 + kt twisted^2/2 [J]."""
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    turning = radius_a * radius_b * shear_stiffness
    squared = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (
        normal_stiffness * overlap * overlap
        + squared / shear_stiffness
        + turning * (bending_factor * bent * bent + twisting_factor * twisted * twisted)
    )


def stiffness(
    young_modulus, stiffness_ratio, bending_factor, twisting_factor, other_young_modulus, other_stiffness_ratio,
    radius_a, radius_b,
):  # fmt: skip
    """Tangent stiffness kn, ks [N/m], twist, bend [N m/rad]."""
    normal_stiffness, shear_stiffness = springs(
        young_modulus, stiffness_ratio, other_young_modulus, other_stiffness_ratio, radius_a, radius_b
    )
    turning = radius_a * radius_b * shear_stiffness
    return normal_stiffness, shear_stiffness, twisting_factor * turning, bending_factor * turning


def combine(first: CohesiveMomentsParameters, second: CohesiveMomentsParameters) -> CohesiveMomentsParameters:
    """Bond of two materials: both moduli are remembered; smaller strengths, factors in series."""
    return CohesiveMomentsParameters(
        first.young_modulus,
        first.stiffness_ratio,
        min(first.friction_coefficient, second.friction_coefficient),
        min(first.normal_cohesion, second.normal_cohesion),
        min(first.shear_cohesion, second.shear_cohesion),
        harmonic_mean(first.bending_factor, second.bending_factor),
        harmonic_mean(first.twisting_factor, second.twisting_factor),
        second.young_modulus,
        second.stiffness_ratio,
    )


def reversed_pair(parameters: CohesiveMomentsParameters) -> CohesiveMomentsParameters:
    """The same bond, its second particle first."""
    return parameters._replace(
        young_modulus=parameters.other_young_modulus,
        stiffness_ratio=parameters.other_stiffness_ratio,
        other_young_modulus=parameters.young_modulus,
        other_stiffness_ratio=parameters.stiffness_ratio,
    )


def against_rigid(parameters: CohesiveMomentsParameters) -> CohesiveMomentsParameters:
    """Bond to a wall, which counts as a grain of the same material and size."""
    return combine(parameters, parameters)


def check(parameters: CohesiveMomentsParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=(
            "young_modulus",
            "stiffness_ratio",
            "normal_cohesion",
            "shear_cohesion",
            "other_young_modulus",
            "other_stiffness_ratio",
        ),
        not_negative=("friction_coefficient", "bending_factor", "twisting_factor"),
        may_be_infinite=("normal_cohesion", "shear_cohesion"),
    )
