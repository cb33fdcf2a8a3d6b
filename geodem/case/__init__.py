"""The case file: TOML text with units in, validated SI numbers out; the only place that knows defaults."""

from geodem.case.any_kind import load_any, load_kind, parse_any
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
    SectionOptions,
    Surcharge,
)
from geodem.case.ground import GroundCase, GroundGrains, GroundSource, ParticleOptions
from geodem.case.ground_reading import load_ground, parse_ground
from geodem.case.laboratory import CalibrationCase, LaboratoryCase
from geodem.case.laboratory_reading import (
    load_calibration,
    load_laboratory,
    parse_calibration,
    parse_laboratory,
)
from geodem.case.material_file import Calibrated, load_material, write_material
from geodem.case.mesh_section import MeshSection
from geodem.case.reading import load_case, parse_case
from geodem.case.terrain_section import TerrainSection

__all__ = [
    "METHODS",
    "Boundary",
    "Calibrated",
    "CalibrationCase",
    "Case",
    "GroundCase",
    "GroundGrains",
    "GroundMaterial",
    "GroundSource",
    "ImageSection",
    "LaboratoryCase",
    "Loads",
    "MeshSection",
    "ParticleOptions",
    "Reference",
    "Refinement",
    "RegionSection",
    "SectionOptions",
    "Surcharge",
    "TerrainSection",
    "load_any",
    "load_calibration",
    "load_case",
    "load_ground",
    "load_kind",
    "load_laboratory",
    "load_material",
    "parse_any",
    "parse_calibration",
    "parse_case",
    "parse_ground",
    "parse_laboratory",
    "write_material",
]
