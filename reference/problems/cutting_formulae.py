"""Published formulae for the force of a cutting tool, per metre of its width."""

from __future__ import annotations

import math

import numpy as np


def evans(tension: float, depth: float, half_angle: float) -> float:
    """Cutting force of a symmetric wedge of half-angle theta, 2 sigma_t d sin(theta)/(1 - sin(theta)) [N/m].

    Evans & Pomeroy 1966, The Strength, Fracture and Workability of Coal; friction at the tool adds its angle to theta.
    """
    return 2.0 * tension * depth * math.sin(half_angle) / (1.0 - math.sin(half_angle))


def nishimatsu(
    strength: float, friction: float, depth: float, rake: float, tool_friction: float, n: float = 0.0
) -> float:
    """Cutting force along a shear plane, R cos(psi - alpha) [N/m].

    R = 2 S d cos(phi)/((n + 1)(1 - sin(phi - alpha + psi))), S = UCS (1 - sin(phi))/(2 cos(phi)): Nishimatsu 1972, The
    mechanics of rock cutting, Int. J. Rock Mech. Min. Sci. 9:261-270; with n = 0 it is Merchant's.
    """
    shear = strength * (1.0 - math.sin(friction)) / (2.0 * math.cos(friction))
    resultant = (
        2.0
        * shear
        * depth
        * math.cos(friction)
        / (1.0 - math.sin(friction - rake + tool_friction))
        / (n + 1.0)
    )
    return resultant * math.cos(tool_friction - rake)


def passive_wedge(
    weight: float, friction: float, depth: float, rake: float, tool_friction: float, heap: float = 0.0
) -> float:
    """Cutting force of loose ground on a blade, the least of Coulomb's trial wedges with level ground [N/m].

    P = W sin(beta + phi)/cos(beta + phi + delta - alpha) on the face, P cos(delta - alpha) along the path; W is that of
    the wedge, unit weight [N/m3], and of a heap [N/m] that stands on it.
    """
    beta = np.radians(np.linspace(2.0, 88.0, 8601))
    load = 0.5 * weight * depth**2 * (1.0 / np.tan(beta) + math.tan(rake)) + heap
    turn = beta + friction + tool_friction - rake
    sliding = turn < 0.5 * math.pi
    thrust = load[sliding] * np.sin(beta + friction)[sliding] / np.cos(turn[sliding])
    return float(thrust.min()) * math.cos(tool_friction - rake)
