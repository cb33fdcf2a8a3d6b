"""A round hole in an infinite elastic plate under two pressures: stresses (Kirsch 1898) and what it adds to motion.

G. Kirsch (1898), Z. VDI 42:797-807; N. I. Muskhelishvili (1953), Some basic problems of the mathematical theory of
elasticity, section 56a. Pressure is positive.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RADIUS = 1.0
"""Of the hole [m]."""


def plane_moduli(strain: Floats, stress: Floats) -> tuple[float, float]:
    """E [Pa] and nu of a plate from a state: E exx = sxx - nu syy, E eyy = syy - nu sxx."""
    matrix = np.array([[strain[0, 0], stress[1, 1]], [strain[1, 1], stress[0, 0]]])
    modulus, ratio = np.linalg.solve(matrix, np.array([stress[0, 0], stress[1, 1]]))
    return float(modulus), float(ratio)


def kirsch_motion(places: Floats, pressure: tuple[float, float], moduli: tuple[float, float]) -> Floats:
    """What a hole of `RADIUS` adds to displacements (n, 2) [m] of an infinite plate under pressures along x and y."""
    shear = moduli[0] / (2.0 * (1.0 + moduli[1]))
    kappa = (3.0 - moduli[1]) / (1.0 + moduli[1])
    mean, half = -0.5 * (pressure[0] + pressure[1]), -0.5 * (pressure[0] - pressure[1])
    r, angle = np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0])
    near, nearer = RADIUS**2 / r, RADIUS**4 / r**3
    out = (mean * near + half * ((kappa + 1.0) * near - nearer) * np.cos(2.0 * angle)) / (2.0 * shear)
    turn = -half * ((kappa - 1.0) * near + nearer) * np.sin(2.0 * angle) / (2.0 * shear)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([out * cos - turn * sin, out * sin + turn * cos], axis=1)


def kirsch_stress(places: Floats, pressure: tuple[float, float]) -> tuple[Floats, Floats, Floats]:
    """Radial, hoop and shear stress, each (n,) [Pa]."""
    near, angle = (RADIUS / np.hypot(*places.T)) ** 2, 2.0 * np.arctan2(places[:, 1], places[:, 0])
    mean, half = 0.5 * (pressure[0] + pressure[1]), 0.5 * (pressure[0] - pressure[1])
    radial = mean * (1.0 - near) + half * (1.0 - 4.0 * near + 3.0 * near**2) * np.cos(angle)
    hoop = mean * (1.0 + near) - half * (1.0 + 3.0 * near**2) * np.cos(angle)
    shear = -half * (1.0 + 2.0 * near - 3.0 * near**2) * np.sin(angle)
    return np.asarray(radial), np.asarray(hoop), np.asarray(shear)


def kirsch_hoop(places: Floats, pressure: tuple[float, float]) -> Floats:
    """Hoop stress (n,) [Pa]."""
    return kirsch_stress(places, pressure)[1]


def kirsch_deviator(places: Floats, pressure: tuple[float, float]) -> Floats:
    """Larger less smaller principal stress (n,) [Pa]."""
    radial, hoop, shear = kirsch_stress(places, pressure)
    return np.asarray(np.sqrt((hoop - radial) ** 2 + 4.0 * shear**2))
