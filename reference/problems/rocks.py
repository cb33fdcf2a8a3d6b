"""Rocks to calibrate to: properties with their sources (rocks.toml)."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from geodem import units
from geodem.calibration.targets import RockTargets

FILE = Path(__file__).with_suffix(".toml")

DIMENSIONS = {
    "density": "density",
    "young_modulus": "stress",
    "poisson_ratio": "dimensionless",
    "uniaxial_compressive_strength": "stress",
    "tensile_strength": "stress",
    "brazilian_strength": "stress",
    "friction_angle": "angle",
    "friction_confinement": "stress",
    "hoek_brown_mi": "dimensionless",
}


def read_rocks() -> dict[str, dict[str, Any]]:
    """Every rock with its name, its `source` texts, and its properties in SI units."""
    rocks = tomllib.loads(FILE.read_text(encoding="utf-8"))
    for name, rock in rocks.items():
        for key in DIMENSIONS.keys() & rock.keys():
            rock[key] = units.parse(rock[key], DIMENSIONS[key], place=f"{name}.{key}")
    return rocks


def targets_of(rock: dict[str, Any]) -> RockTargets:
    """The properties that a calibration aims at."""
    return RockTargets(**{key: rock[key] for key in RockTargets.__dataclass_fields__ if key in rock})
