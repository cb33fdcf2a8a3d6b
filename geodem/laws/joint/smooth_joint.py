"""Smooth joint: two particles on opposite sides of a joint slide along its plane, not over each other.

Stiffness, friction, cohesion, tensile strength and dilation are those of the joint, per area of its face; the pair
stands for a share of that face. The normal is that of the joint, whatever the line of centres, so the particles may
lie in one another and pass each other. Until it breaks the face is bonded; then it opens freely and slides by Coulomb.

Reference: Mas Ivars, Pierce, Darcel, Reyes-Montes, Potyondy, Young & Cundall (2011), The synthetic rock mass approach
for jointed rock mass modelling, Int. J. Rock Mech. Min. Sci. 48:219-244. There the force follows step by
step; here the normal force follows from the whole closure, which is the same and cannot drift. There a broken joint
has no cohesion; here some may be left, all of it where the joint is to be ideally plastic, as in a limit equilibrium.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults

NAME = "smooth_joint"
DIMENSIONS = (2, 3)
SCALAR = ("dilated",)
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
LASTING = False


class SmoothJointParameters(NamedTuple):
    """A joint; all but the friction and the dilation count per area of its face."""

    normal_stiffness: float  # kn [Pa/m]
    shear_stiffness: float  # ks [Pa/m]
    friction_coefficient: float  # tan(phi_j) [-]
    cohesion: float = 0.0  # c_j [Pa]: of the bonded face
    tensile_strength: float = 0.0  # T_j [Pa]
    dilation_coefficient: float = 0.0  # tan(psi_j) [-]: opening over sliding, under pressure
    residual_cohesion: float = 0.0  # c_r [Pa]: what is left of it when the face has broken, under pressure


PARAMETERS = SmoothJointParameters


def starts_bonded(parameters: SmoothJointParameters) -> bool:
    """Whether the face is bonded at first: it has some strength that it can lose."""
    return parameters.cohesion > parameters.residual_cohesion or parameters.tensile_strength > 0.0


def force(
    normal_stiffness, shear_stiffness, friction_coefficient, cohesion, tensile_strength, dilation_coefficient,
    residual_cohesion, overlap, slip_x, slip_y, slip_z, area, intact, scale, dilated, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step, and how much of the strength of a bonded face they take.

    With the closure u = overlap + what dilation has added: sigma = kn u, Fn = A sigma, dFs = ks A slip. Bonded, it
    breaks where -sigma reaches T, or |Fs|/A reaches c + sigma tan(phi). Broken, Fn is no less than 0 and |Fs| no more
    than Fn tan(phi) + c_r A where it is pressed, 0 where not; what slides beyond adds tan(psi) times its way to u.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        Along and across the joint's normal [N].
    dilated, shear_x, shear_y, shear_z : float
        History: closure by dilation [m], shear force [N].
    tension_utilisation, shear_utilisation : float
        [-]; 1 at the strength times `scale`.
    """
    sigma = normal_stiffness * (overlap + dilated)
    stiff = shear_stiffness * area
    x = shear_x + stiff * slip_x
    y = shear_y + stiff * slip_y
    z = shear_z + stiff * slip_z
    shear = math.sqrt(x * x + y * y + z * z)
    bonded_cohesion = scale * cohesion
    bonded_tension = scale * tensile_strength
    # a face without one of the two strengths breaks at once
    bonded_cohesion = bonded_cohesion if bonded_cohesion > 1e-300 else 1e-300
    bonded_tension = bonded_tension if bonded_tension > 1e-300 else 1e-300
    tension_utilisation = -sigma / bonded_tension
    shear_utilisation = (shear / area - friction_coefficient * sigma) / bonded_cohesion
    whole = intact > 0.0
    normal = area * (sigma if whole or sigma > 0.0 else 0.0)
    limit = friction_coefficient * normal + (residual_cohesion * area if normal > 0.0 else 0.0)
    slides = not whole and shear > limit
    factor = limit / shear if slides else 1.0
    grown = dilation_coefficient * (shear - limit) / stiff if slides and normal > 0.0 else 0.0
    x *= factor
    y *= factor
    z *= factor
    return (
        normal, x, y, z,
        dilated + grown, x, y, z,
        tension_utilisation, shear_utilisation,
    )  # fmt: skip


def energy(normal_stiffness, shear_stiffness, overlap, area, intact, dilated, shear_x, shear_y, shear_z):
    """Elastic energy A kn u^2/2 + Fs^2/(2 ks A) [J]; an open face that is broken stores none."""
    closure = overlap + dilated
    closure = closure if intact > 0.0 or closure > 0.0 else 0.0
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    return 0.5 * (normal_stiffness * area * closure * closure + shear / (shear_stiffness * area))


def stiffness(normal_stiffness, shear_stiffness, area):
    """Tangent stiffness kn A, ks A [N/m], twist, bend [N m/rad]."""
    return normal_stiffness * area, shear_stiffness * area, 0.0, 0.0


def check(parameters: SmoothJointParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters,
        positive=("normal_stiffness", "shear_stiffness"),
        not_negative=SmoothJointParameters._fields[2:],
        may_be_infinite=("cohesion", "tensile_strength", "residual_cohesion"),
    )
    if parameters.residual_cohesion > parameters.cohesion:
        found.append(Fault("residual_cohesion", "is above the cohesion", "Give no more than that"))
    return found
