"""A slope of two materials with a failed state made by hand: what lies above a plane slides down on it and turns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from geodem.building import make_model, make_particles, make_section
from geodem.case import parse_case
from geodem.model import Model
from geodem.state import State

DENSITIES = (1900.0, 2100.0)
CASE = """
workflow = "slope"
title = "Two materials"
particles = 400
methods = ["strength-reduction"]
tolerance = 0.05
seed = 1
[section]
length_unit = "m"
regions = [
  {material = "upper", polygon = [[0,0],[24,0],[24,4],[16,4],[8,12],[0,12]]},
  {material = "lower", polygon = [[0,0],[24,0],[24,4],[16,4],[13,7],[0,7]]},
]
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
[material.upper]
law = "mohr_coulomb"
density = "1900 kg/m3"
cohesion = "2 kPa"
friction_angle = "20 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
[material.lower]
law = "mohr_coulomb"
density = "2100 kg/m3"
cohesion = "4 kPa"
friction_angle = "20 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
"""

SLIDE = 0.02
"""Way that the mass has slid [m]."""


def failed_slope() -> tuple[Model, State]:
    """The model and the state: ground above the line from (3, 12) to the toe (16, 4) has slid along it."""
    case = parse_case(CASE, Path("."))
    model = make_model(case, make_particles(case, make_section(case), particles=400))
    state = State.at_rest(model)
    along = np.array([13.0, -8.0]) / math.hypot(13.0, 8.0)
    normal = np.array([-along[1], along[0]])
    above = (model.positions - (3.0, 12.0)) @ normal > 0.0
    state.displacement[above] = SLIDE * along
    state.stress[:, 3] = 1e-3
    return model, state


def turning(model: Model) -> np.ndarray:
    """A velocity field (n, 2) [m/s] that slides, turns and shears."""
    x, y = model.positions.T
    return np.stack([1.0 + 0.3 * (y - 8.0), -0.6 - 0.2 * (x - 10.0) + 0.05 * (y - 8.0) ** 2], axis=1)
