"""What DICE2D's twelve examples have in common: size of a disc, its time step, its gravity.

Source: Zhao (2015), High Performance Computing and the Discrete Element Model, section 1.5, tables 1.2 to 1.12. The
drawings and some lengths are not in the text. Its "mean particle size" is taken as the radius: only then do
the 80,000 steps of the pendulum last 17.9 s and turn it by more than 180 degrees (11.7 s), as the text says.
Strengths, stiffnesses and masses are those of discs, per metre of depth.
"""

from __future__ import annotations

import math

RADIUS = 10.0  # [m]
GRAVITY = 10.0  # [m/s2]
WIDTH_RATIO = 0.8
"""WRT of the bonds; the text gives it for shear only, elsewhere nothing bends or it is not said."""


def disc_mass(density: float, radius: float = RADIUS) -> float:
    """Mass of a disc [kg/m]."""
    return math.pi * radius**2 * density


def book_step(factor: float, mass: float, normal: float, shear: float) -> float:
    """Time step factor * 2 sqrt(m/max(kn, ks)) [s], eq. 1.48."""
    return factor * 2.0 * math.sqrt(mass / max(normal, shear))


def friction(degrees: float) -> float:
    """Coefficient of friction of an angle."""
    return math.tan(math.radians(degrees))
