"""Friction of discs for a friction angle of the ground: what was measured in shear, read backwards."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..errors import InputError

SHEAR_STIFFNESS = 0.5
"""Shear over normal stiffness of a contact [-]."""


class DiscFriction(NamedTuple):
    """Friction of contacts of the law `linear_rolling` [-]."""

    sliding: float
    rolling: float


ROLLING = 1.0

MEASURED = ((0.05, 12.36), (0.1, 16.06), (0.15, 20.02), (0.2, 23.10), (0.3, 28.95), (0.4, 32.37))
"""(sliding friction of contacts [-], residual friction angle of the discs [deg]), rolling friction `ROLLING`.

Dense packings of 900 discs, radii equally frequent between r and 2 r, in a periodic cell; biaxial compression at
constant stress across, stiffness of contacts 1,000 times that stress, inertial number 0.002: the mean of 20 to 40 % of
strain along the axis, mean of three packings, whose angles are at most 2.2 deg apart. At first they bear up to 8 deg
more. `python -m reference run runout` measures fresh packings.
"""


def disc_friction(friction_angle: float) -> DiscFriction:
    """Friction of contacts with which discs have this residual friction angle [rad].

    Raises
    ------
    InputError
        An angle out of the range that was measured.
    """
    sliding, angle = np.array(MEASURED).T
    asked = math.degrees(friction_angle)
    if not angle[0] <= asked <= angle[-1]:
        raise InputError(
            "residual friction angle",
            f"discs reach {angle[0]:.1f} to {angle[-1]:.1f} deg",
            "Give an angle between these.",
            value=f"{asked:.4g} deg",
        )
    return DiscFriction(float(np.interp(asked, angle, sliding)), ROLLING)


def friction_tangent(discs: DiscFriction) -> float:
    """Tangent of the residual friction angle [-] that discs of this friction have, by `MEASURED`.

    `disc_friction` the other way round; at the ends of what was measured it is that of the end.
    """
    sliding, angle = np.array(MEASURED).T
    return math.tan(math.radians(float(np.interp(discs.sliding, sliding, angle))))
