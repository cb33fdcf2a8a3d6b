"""Grains that the problems of granular flow share: hard enough, dissipative, of about 1 mm."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder

Floats = NDArray[np.float64]

DIAMETER = 1e-3  # mean [m]
GRAVITY = 9.81  # [m/s2]
DENSITY = 2500.0  # [kg/m3]
FRICTION = 0.5  # of grains and walls [-]
RESTITUTION = 0.5  # of two grains that meet head-on [-]
UNIT_TIME = math.sqrt(DIAMETER / GRAVITY)  # [s]


def mean_mass(dimension: int) -> float:
    """Mass of a grain of the mean diameter [kg] (2D: kg/m)."""
    radius = 0.5 * DIAMETER
    return DENSITY * (math.pi * radius**2 if dimension == 2 else 4.0 / 3.0 * math.pi * radius**3)


def grain_builder(dimension: int, stiffness: float, friction: float = FRICTION) -> AssemblyBuilder:
    """A builder with the material "grain"; `stiffness` is kn d/(m g), the depth in grains at an overlap of one.

    The dashpots are those of a linear impact: damping ratio zeta = -ln(e)/sqrt(pi^2 + ln(e)^2).
    """
    mass = mean_mass(dimension)
    normal = stiffness * mass * GRAVITY / DIAMETER
    loss = -math.log(RESTITUTION)
    ratio = loss / math.hypot(math.pi, loss)
    viscosity = 2.0 * ratio * math.sqrt(0.5 * mass / normal)
    builder = AssemblyBuilder(dimension, gravity=(0.0,) * (dimension - 1) + (-GRAVITY,))
    contact = {
        "normal_stiffness": normal,
        "shear_stiffness": 2.0 / 7.0 * normal,
        "friction_coefficient": friction,
        "normal_viscosity": viscosity,
        "shear_viscosity": viscosity,
    }
    builder.add_material("grain", density=DENSITY, contact=contact)
    return builder


def exponent(x: Floats, y: Floats) -> float:
    """Slope of the straight line through log y over log x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
