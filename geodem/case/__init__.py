"""The case file: TOML text with units in, validated SI numbers out; the only place that knows defaults."""

from geodem.case.data import (
    METHODS,
    Boundary,
    Case,
    GroundMaterial,
    ImageSection,
    Loads,
    Reference,
    Refinement,
    RegionSection,
    Surcharge,
)
from geodem.case.reading import load_case, parse_case

__all__ = [
    "METHODS",
    "Boundary",
    "Case",
    "GroundMaterial",
    "ImageSection",
    "Loads",
    "Reference",
    "Refinement",
    "RegionSection",
    "Surcharge",
    "load_case",
    "parse_case",
]
