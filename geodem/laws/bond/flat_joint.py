"""Flat joint: grains joined at flat faces that break piece by piece and rub, and resist rotation, when broken.

Reference: Potyondy (2012), A flat-jointed bonded-particle material for hard rock, 46th US Rock Mechanics / Geomechanics
Symposium, ARMA 12-501. The face is cut into elements of equal area, 4 between discs, 6 between spheres; each is whole
or broken. What is of this file:

- An element acts at one point. The points lie so that the section bends and twists as the undivided one: in 2D at
  +-h sqrt(1/15) and +-h sqrt(3/5), 3 % outside the middles of the quarters of the strip; in 3D on a hexagon at
  h/sqrt(2), since then I = A h^2/4 and J = A h^2/2. With a hexagon the bending moment that breaks the first element
  depends on the direction by 15 %; with a square, 41 %.
- An element breaks within the step, at the strength; its shear force falls to what friction bears. Where an
  equilibrium is sought nothing breaks on the way (`breaking` is infinite), the utilisations are those of the weakest
  elements that are left, and in equilibrium the most overstressed ones break.
- The joint ends, and the contact law goes on, once all elements are broken and none is pressed, or once the faces have
  left each other: slid by h, or tilted by 1 rad. Until then its utilisation stays below 1. It counts as broken in
  tension where at least half of its elements were.
- In 3D the elements lie along a vector across the normal that turns with the two grains. The first step chooses it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults, mixed

NAME = "flat_joint"
DIMENSIONS = (2, 3)
SCALAR = ("damage", "slid_1", "tilt_1", "shear_11", "shear_12", "shear_13", "shear_14")
TANGENTIAL = ("along",)
AXIAL = (
    "slid_2", "tilt_2", "shear_15", "shear_16",
    "shear_21", "shear_22", "shear_23", "shear_24", "shear_25", "shear_26",
)  # fmt: skip
MOMENT = True
VISCOUS = False
REPLACES_CONTACT = True

# The face: a disc between spheres, else a strip of one metre depth between discs. The kernel's module overrides this
# with the scene's dimension.
SPHERES = True

# Places of the elements over h, in 2D and in 3D.
INNER_PLACE = math.sqrt(1.0 / 15.0)
OUTER_PLACE = math.sqrt(3.0 / 5.0)
CORNER_PLACE = math.sqrt(0.5)
HALF_CORNER_PLACE = 0.5 * CORNER_PLACE
ASIDE_PLACE = math.sqrt(0.375)
# Utilisation of a joint that ends: above all others, and finite.
JOINT_ENDED = 1e30


class FlatJointParameters(NamedTuple):
    """The joint. The radius h of its face is that of the smaller grain, its length the sum of both radii."""

    effective_modulus: float  # Ec [Pa]
    stiffness_ratio: float  # kappa = kn/ks [-]
    tensile_strength: float  # Tb [Pa]
    shear_strength: float  # C [Pa]: of an unpressed element
    friction_coefficient: float  # tan(phi_b) [-]: what pressure adds to the shear strength
    residual_friction_coefficient: float  # mu [-]: of broken elements


PARAMETERS = FlatJointParameters


def bonded():
    """History of a new joint: all elements whole, no shear forces, nothing slid or tilted, no direction yet."""
    return (
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip


def element(
    bit, damage, gap, shear_1, shear_2, slip_1, slip_2,
    k_normal, k_shear, per_tension, per_shear, friction, residual, breaking,
):  # fmt: skip
    """One element after a step, whole or broken: damage has its bit where it was torn, 64 times its bit where cut.

    gap [m]: pressed where positive; shear_1, shear_2: force before the step; k_normal, k_shear [N/m]; per_tension,
    per_shear [1/N]: one over the strength as a force, 0 where infinite; friction of a whole and of a broken element.

    Returns
    -------
    normal, shear_1, shear_2 : float
        [N]
    broke : int
        What this step adds to the damage.
    tension, shearing : float
        Utilisations, 0 where it is broken.
    """
    whole = (damage & (65 * bit)) == 0
    normal = k_normal * gap
    one = shear_1 + k_shear * slip_1
    other = shear_2 + k_shear * slip_2
    size = math.sqrt(one * one + other * other)
    tension = -normal * per_tension
    shearing = (size - friction * normal) * per_shear
    breaks = whole and (tension >= breaking or shearing >= breaking)
    holds = whole and not breaks
    normal = normal if holds or normal > 0.0 else 0.0
    limit = residual * normal
    keep = 1.0 if holds or size <= limit else limit / size
    return (
        normal, keep * one, keep * other,
        (bit if tension >= shearing else 64 * bit) if breaks else 0,
        tension if holds else 0.0,
        shearing if holds else 0.0,
    )  # fmt: skip


def bits(mask):
    """How many of the six lowest bits are set."""
    return (
        (mask & 1) + (mask >> 1 & 1) + (mask >> 2 & 1) + (mask >> 3 & 1) + (mask >> 4 & 1) + (mask >> 5 & 1)
    )


def larger(first, second):
    """The larger of two."""
    return first if first > second else second


def force(
    effective_modulus, stiffness_ratio, tensile_strength, shear_strength, friction_coefficient,
    residual_friction_coefficient,
    overlap, slip_x, slip_y, slip_z, twist, bend_x, bend_y, bend_z, radius_a, radius_b, scale,
    normal_x, normal_y, normal_z, breaking,
    damage, slid_1, tilt_1, shear_11, shear_12, shear_13, shear_14,
    along_x, along_y, along_z,
    slid_2, tilt_2, shear_15, shear_16, shear_21, shear_22, shear_23, shear_24, shear_25, shear_26,
):  # fmt: skip
    """Forces and moments of the joint after a step, and how much of their strength its whole elements take.

    With h = min(ra, rb), A of the face and m = 4 or 6 elements: kn = Ec A/(ra + rb), ks = kn/kappa. The element at d,
    the lever across the normal, is pressed by g = u + tilt . d and slips by slip + twist d; its forces are
    N = (kn/m) g, dS = (ks/m) dslip. Whole: breaks where -N/(A/m) reaches Tb, or |S|/(A/m) reaches
    C + tan(phi_b) N/(A/m); the scale multiplies Tb and C. Broken: N >= 0, |S| <= mu N.
    Fn = sum N, Fs = sum S, Mb = sum d N, Mt = sum d . S.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        [N]
    twist_moment, bend_moment_x, bend_moment_y, bend_moment_z : float
        [N m]
    damage, ..., shear_26 : float
        History: which elements broke, six bits for tension and then six for shear of a whole number; in the
        directions 1 and 2 across the normal how far b slid [m] and tilted [rad] against a since it was joined and the
        shear forces of the elements [N]; the direction 1.
    tension_utilisation, shear_utilisation : float
        [-]; below `breaking`, or `JOINT_ENDED`.
    """
    height = radius_a if radius_a < radius_b else radius_b
    area = (math.pi * height * height if SPHERES else 2.0 * height) * (1.0 / 6.0 if SPHERES else 0.25)
    k_normal = effective_modulus * area / (radius_a + radius_b)
    k_shear = k_normal / stiffness_ratio
    # between discs there are no fifth and sixth elements
    k_normal_56 = k_normal if SPHERES else 0.0
    k_shear_56 = k_shear if SPHERES else 0.0
    per_tension = 1.0 / (scale * tensile_strength * area)
    per_shear = 1.0 / (scale * shear_strength * area)

    # directions 1 and 2 across the normal; between discs what has a component has it in x
    size = along_x * along_x + along_y * along_y + along_z * along_z
    steep = abs(normal_z) < 0.8
    first_x = along_x if size > 0.0 else (normal_y if steep else 0.0)
    first_y = along_y if size > 0.0 else (-normal_x if steep else normal_z)
    first_z = along_z if size > 0.0 else (0.0 if steep else -normal_y)
    out = first_x * normal_x + first_y * normal_y + first_z * normal_z
    first_x -= out * normal_x
    first_y -= out * normal_y
    first_z -= out * normal_z
    inverse = 1.0 / math.sqrt(first_x * first_x + first_y * first_y + first_z * first_z) if SPHERES else 0.0
    first_x = first_x * inverse if SPHERES else 1.0
    first_y = first_y * inverse if SPHERES else 0.0
    first_z = first_z * inverse if SPHERES else 0.0
    # between discs there is no direction to remember
    along_x = first_x if SPHERES else 0.0
    second_x = normal_y * first_z - normal_z * first_y if SPHERES else 0.0
    second_y = normal_z * first_x - normal_x * first_z if SPHERES else 0.0
    second_z = normal_x * first_y - normal_y * first_x if SPHERES else 0.0

    slip_1 = slip_x * first_x + slip_y * first_y + slip_z * first_z
    slip_2 = slip_x * second_x + slip_y * second_y + slip_z * second_z
    slid_1 += slip_1
    slid_2 += slip_2
    tilt_1 += bend_x * first_x + bend_y * first_y + bend_z * first_z
    tilt_2 += bend_x * second_x + bend_y * second_y + bend_z * second_z

    # levers; of the elements 1 and 4, 2 and 3 they are mirrored, so that the sums below do not depend on which is a
    lever_1 = height * (HALF_CORNER_PLACE if SPHERES else OUTER_PLACE)
    lever_2 = height * (-HALF_CORNER_PLACE if SPHERES else INNER_PLACE)
    lever_3 = height * (-HALF_CORNER_PLACE if SPHERES else -INNER_PLACE)
    lever_4 = height * (HALF_CORNER_PLACE if SPHERES else -OUTER_PLACE)
    lever_5 = height * CORNER_PLACE if SPHERES else 0.0
    aside = height * ASIDE_PLACE if SPHERES else 0.0
    lift = aside * tilt_2
    turned_1 = twist * lever_1
    turned_5 = twist * lever_5
    turned_2 = twist * aside

    was = math.floor(damage)
    normal_1, shear_11, shear_21, broke_1, tension_1, shearing_1 = element(
        1, was, overlap + lever_1 * tilt_1 + lift, shear_11, shear_21,
        slip_1 + turned_1, slip_2 + turned_2, k_normal, k_shear, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip
    normal_2, shear_12, shear_22, broke_2, tension_2, shearing_2 = element(
        2, was, overlap + lever_2 * tilt_1 + lift, shear_12, shear_22,
        slip_1 - turned_1, slip_2 + turned_2, k_normal, k_shear, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip
    normal_3, shear_13, shear_23, broke_3, tension_3, shearing_3 = element(
        4, was, overlap + lever_3 * tilt_1 - lift, shear_13, shear_23,
        slip_1 - turned_1, slip_2 - turned_2, k_normal, k_shear, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip
    normal_4, shear_14, shear_24, broke_4, tension_4, shearing_4 = element(
        8, was, overlap + lever_4 * tilt_1 - lift, shear_14, shear_24,
        slip_1 + turned_1, slip_2 - turned_2, k_normal, k_shear, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip
    normal_5, shear_15, shear_25, broke_5, tension_5, shearing_5 = element(
        16, was, overlap + lever_5 * tilt_1, shear_15, shear_25,
        slip_1 + turned_5, slip_2, k_normal_56, k_shear_56, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip
    normal_6, shear_16, shear_26, broke_6, tension_6, shearing_6 = element(
        32, was, overlap - lever_5 * tilt_1, shear_16, shear_26,
        slip_1 - turned_5, slip_2, k_normal_56, k_shear_56, per_tension, per_shear,
        friction_coefficient, residual_friction_coefficient, breaking,
    )  # fmt: skip

    now = was | broke_1 | broke_2 | broke_3 | broke_4 | broke_5 | broke_6
    normal = ((normal_1 + normal_4) + (normal_2 + normal_3)) + (normal_5 + normal_6)
    sum_1 = ((shear_11 + shear_14) + (shear_12 + shear_13)) + (shear_15 + shear_16)
    sum_2 = ((shear_21 + shear_24) + (shear_22 + shear_23)) + (shear_25 + shear_26)
    bent_1 = (lever_1 * normal_1 + lever_4 * normal_4) + (lever_2 * normal_2 + lever_3 * normal_3)
    bent_1 += lever_5 * (normal_5 - normal_6)
    bent_2 = aside * ((normal_1 - normal_4) + (normal_2 - normal_3))
    twisted = lever_1 * ((shear_11 + shear_14) - (shear_12 + shear_13)) + lever_5 * (shear_15 - shear_16)
    twisted += aside * ((shear_21 - shear_24) + (shear_22 - shear_23))
    twisted = twisted if SPHERES else 0.0

    tension = larger(
        larger(larger(tension_1, tension_4), larger(tension_2, tension_3)), larger(tension_5, tension_6)
    )
    shearing = larger(
        larger(larger(shearing_1, shearing_4), larger(shearing_2, shearing_3)), larger(shearing_5, shearing_6)
    )
    torn = now & 63
    cut = now >> 6
    away = slid_1 * slid_1 + slid_2 * slid_2 > height * height or tilt_1 * tilt_1 + tilt_2 * tilt_2 > 1.0
    ended = (torn | cut) == (63 if SPHERES else 15) and (away or not normal > 0.0)
    in_tension = bits(torn) >= bits(cut)
    tension = (JOINT_ENDED if in_tension else 0.0) if ended else larger(tension, 0.0)
    shearing = (0.0 if in_tension else JOINT_ENDED) if ended else larger(shearing, 0.0)
    return (
        normal,
        sum_1 * first_x + sum_2 * second_x,
        sum_1 * first_y + sum_2 * second_y,
        sum_1 * first_z + sum_2 * second_z,
        twisted,
        bent_1 * first_x + bent_2 * second_x,
        bent_1 * first_y + bent_2 * second_y,
        bent_1 * first_z + bent_2 * second_z,
        1.0 * now, slid_1, tilt_1, shear_11, shear_12, shear_13, shear_14,
        along_x, first_y, first_z,
        slid_2, tilt_2, shear_15, shear_16, shear_21, shear_22, shear_23, shear_24, shear_25, shear_26,
        tension, shearing,
    )  # fmt: skip


def held(bit, damage, gap):
    """Square of the gap of an element that carries its force, 0 where it is open."""
    return gap * gap if gap > 0.0 or (math.floor(damage) & (65 * bit)) == 0 else 0.0


def energy(
    effective_modulus, stiffness_ratio, overlap, radius_a, radius_b,
    damage, tilt_1, shear_11, shear_12, shear_13, shear_14,
    tilt_2, shear_15, shear_16, shear_21, shear_22, shear_23, shear_24, shear_25, shear_26,
):  # fmt: skip
    """Elastic energy, over the elements that are whole or pressed: (kn/m) g^2/2 + |S|^2 m/(2 ks) [J]."""
    height = radius_a if radius_a < radius_b else radius_b
    area = (math.pi * height * height if SPHERES else 2.0 * height) * (1.0 / 6.0 if SPHERES else 0.25)
    k_normal = effective_modulus * area / (radius_a + radius_b)
    one = height * (HALF_CORNER_PLACE if SPHERES else OUTER_PLACE) * tilt_1
    two = height * (-HALF_CORNER_PLACE if SPHERES else INNER_PLACE) * tilt_1
    three = height * (-HALF_CORNER_PLACE if SPHERES else -INNER_PLACE) * tilt_1
    four = height * (HALF_CORNER_PLACE if SPHERES else -OUTER_PLACE) * tilt_1
    lift = height * ASIDE_PLACE * tilt_2 if SPHERES else 0.0
    pressed = (held(1, damage, overlap + one + lift) + held(8, damage, overlap + four - lift)) + (
        held(2, damage, overlap + two + lift) + held(4, damage, overlap + three - lift)
    )
    corner = height * CORNER_PLACE * tilt_1
    pair = held(16, damage, overlap + corner) + held(32, damage, overlap - corner)
    pressed += pair if SPHERES else 0.0
    first = (shear_11 * shear_11 + shear_14 * shear_14) + (shear_12 * shear_12 + shear_13 * shear_13)
    first += shear_15 * shear_15 + shear_16 * shear_16
    second = (shear_21 * shear_21 + shear_24 * shear_24) + (shear_22 * shear_22 + shear_23 * shear_23)
    second += shear_25 * shear_25 + shear_26 * shear_26
    return 0.5 * (k_normal * pressed + (first + second) * stiffness_ratio / k_normal)


def stiffness(effective_modulus, stiffness_ratio, radius_a, radius_b):
    """Stiffness kn, ks [N/m], twist ks J/A, bend kn I/A [N m/rad] of the whole joint; broken, it is softer."""
    height = radius_a if radius_a < radius_b else radius_b
    area = math.pi * height * height if SPHERES else 2.0 * height
    gyration = 0.25 * height * height if SPHERES else height * height / 3.0
    kn = effective_modulus * area / (radius_a + radius_b)
    ks = kn / stiffness_ratio
    twist = 2.0 * ks * gyration if SPHERES else 0.0
    return kn, ks, twist, kn * gyration


def combine(first: FlatJointParameters, second: FlatJointParameters) -> FlatJointParameters:
    """Joint of two materials: springs in series, the smaller strength and friction, the mean kappa."""
    return mixed(
        first,
        second,
        series=("effective_modulus",),
        smaller=(
            "tensile_strength",
            "shear_strength",
            "friction_coefficient",
            "residual_friction_coefficient",
        ),
        mean=("stiffness_ratio",),
    )


def against_rigid(parameters: FlatJointParameters) -> FlatJointParameters:
    """Joint with a rigid wall: the grain's own half, twice as stiff."""
    return parameters._replace(effective_modulus=2.0 * parameters.effective_modulus)


def check(parameters: FlatJointParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    return faults(
        parameters,
        positive=("effective_modulus", "stiffness_ratio", "tensile_strength", "shear_strength"),
        not_negative=("friction_coefficient", "residual_friction_coefficient"),
        may_be_infinite=("tensile_strength", "shear_strength"),
    )
