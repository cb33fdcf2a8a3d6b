"""The material file: bonds and contacts of a material with their units, and how they were found; TOML."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from geodem._version import __version__
from geodem.calibration.estimate import Estimate
from geodem.calibration.targets import RockTargets
from geodem.case.bonded import exact, material_keys, material_lines, number, read_material
from geodem.case.document import parse_document, read_text
from geodem.case.section import positive
from geodem.case.table import Findings, Table, quoted
from geodem.errors import InputErrors
from geodem.io.files import write_whole
from geodem.laboratory.material import BondedMaterial

FORMAT = 1

PROPERTIES = {
    "young_modulus": "stress",
    "poisson_ratio": "dimensionless",
    "uniaxial_compressive_strength": "stress",
    "tensile_strength": "stress",
    "friction_angle": "angle",
}
"""What a calibration aims at and comes to, density aside."""

_OF_FILE = ("format", "name", "calibration")
_OF_CALIBRATION = (
    "dimension", "packing", "width", "across", "size_ratio", "seed", "tests", "version", "remarks",
    "targets", "achieved",
)  # fmt: skip


@dataclass(frozen=True)
class Calibrated:
    """How a material was found.

    Attributes
    ----------
    targets : RockTargets
    achieved : dict of str to Estimate
        Names of `PROPERTIES`, SI: means over specimens with their 95 % intervals.
    dimension : int
    packing : str
    width : float
        Of the specimens [m].
    across, size_ratio : float
        Particles across them, largest over smallest radius [-].
    seed, tests : int
        Of the specimens, and how many were tested.
    version : str
        Of geodem.
    remarks : tuple of str
        What cannot be had, and what else is to be known.
    """

    targets: RockTargets
    achieved: Mapping[str, Estimate]
    dimension: int
    packing: str
    width: float
    across: float
    size_ratio: float
    seed: int
    tests: int
    version: str = __version__
    remarks: tuple[str, ...] = field(default=())


def load_material(path: Path | str) -> tuple[BondedMaterial, Calibrated | None]:
    """Read a material file.

    Returns
    -------
    BondedMaterial, Calibrated or None
        None where the file does not say how the material was found.

    Raises
    ------
    InputError
        The file cannot be found or read, or is no TOML.
    InputErrors
        All that is wrong in it, in its order.
    """
    text, _ = read_text(path, what="material")
    return parse_material(text)


def parse_material(text: str) -> tuple[BondedMaterial, Calibrated | None]:
    """Read a material from the text of its file; raises as `load_material` does."""
    document = parse_document(text, what="material")
    findings = Findings(document)
    table = Table(findings, "", document, (*_OF_FILE, *material_keys(document)))
    _check_format(table)
    name = table.text("name", remedy='Write name = "Granite".') or "rock"
    material = read_material(table, name=name)
    calibrated = _read_calibrated(table)
    if findings.errors:
        raise InputErrors(findings.in_order())
    assert material is not None  # or an error would have been found
    return material, calibrated


def write_material(path: Path | str, material: BondedMaterial, calibrated: Calibrated | None = None) -> None:
    """Write a material file, whole or not at all; reading it gives the same numbers to the last bit.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_whole(path, material_text(material, calibrated))


def material_text(material: BondedMaterial, calibrated: Calibrated | None = None) -> str:
    """The text of a material file."""
    lines = [
        f"# A material for geodem {__version__}: bonds and contacts of its grains. In a laboratory case:",
        "#   [material]",
        '#   file = "this-file.toml"',
        "",
        f"format = {FORMAT}",
        f"name = {quoted(material.name)}",
        *material_lines(material),
    ]
    if calibrated is not None:
        lines += ["", *_calibrated_lines(calibrated)]
    return "\n".join(lines) + "\n"


def _check_format(table: Table) -> None:
    found = table.integer("format", smallest=1, remedy=f"Write format = {FORMAT}.")
    if "format" not in table:
        table.missing("format", f"Write format = {FORMAT}.")
    elif found is not None and found != FORMAT:
        table.error("format", "another geodem wrote this file", f"This one reads format = {FORMAT}.")


def _read_calibrated(top: Table) -> Calibrated | None:
    table = top.sub("calibration", _OF_CALIBRATION, example="[calibration], as geodem calibrate writes it")
    if table is None:
        return None
    before = len(table.findings.errors)
    whole = {
        key: table.integer(key, smallest=smallest, remedy=f"Write a whole number, {smallest} at least.")
        for key, smallest in (("dimension", 2), ("seed", 0), ("tests", 1))
    }
    lengths = {
        key: table.quantity(key, dimension, check=positive)
        for key, dimension in (
            ("width", "length"),
            ("across", "dimensionless"),
            ("size_ratio", "dimensionless"),
        )
    }
    texts = {key: table.text(key, remedy="Write text.") for key in ("packing", "version")}
    for key in (*whole, *lengths, *texts, "targets", "achieved"):
        if key not in table:
            table.missing(key, "Write what geodem calibrate wrote, or take [calibration] out.")
    remarks = tuple(str(remark) for remark in table.items("remarks", example='["..."]'))
    targets = _read_targets(table)
    achieved = _read_achieved(table)
    if len(table.findings.errors) > before:
        return None
    given: dict[str, Any] = {**whole, **lengths, **texts}
    return Calibrated(targets, achieved, remarks=remarks, **given)


def _read_targets(table: Table) -> RockTargets:
    known = {"density": "density", **PROPERTIES, "friction_confinement": "stress"}
    inner = table.sub("targets", tuple(known), example="[calibration.targets]")
    found = {}
    if inner is not None:
        found = {name: inner.quantity(name, dimension) for name, dimension in known.items()}
    return RockTargets(**{name: value for name, value in found.items() if value is not None})


def _read_achieved(table: Table) -> dict[str, Estimate]:
    inner = table.sub("achieved", tuple(PROPERTIES), example="[calibration.achieved]")
    found: dict[str, Estimate] = {}
    for name, dimension in PROPERTIES.items() if inner is not None else ():
        assert inner is not None
        row = inner.sub(
            name, ("value", "low", "high"), example=f"{name} = {{value = ..., low = ..., high = ...}}"
        )
        if row is None:
            continue
        values = [row.quantity(key, dimension) for key in ("value", "low", "high")]
        for key in ("value", "low", "high"):
            if key not in row:
                row.missing(key, "Write the value and both ends of its interval.")
        if None not in values:
            found[name] = Estimate(*(value for value in values if value is not None))
    return found


def _calibrated_lines(found: Calibrated) -> list[str]:
    lines = [
        "[calibration]  # how it was found; a run does not need it",
        f"dimension = {found.dimension}",
        f"packing = {quoted(found.packing)}",
        f"width = {exact(found.width, 'length')}",
        f"across = {found.across!r}",
        f"size_ratio = {found.size_ratio!r}",
        f"seed = {found.seed}",
        f"tests = {found.tests}",
        f"version = {quoted(found.version)}",
    ]
    if found.remarks:
        lines.append("remarks = [\n" + "".join(f"  {quoted(remark)},\n" for remark in found.remarks) + "]")
    lines += ["", "[calibration.targets]"]
    for name, dimension in {"density": "density", **PROPERTIES, "friction_confinement": "stress"}.items():
        value = getattr(found.targets, name)
        if math.isfinite(value):
            lines.append(f"{name} = {number(value, dimension)}")
    lines += ["", "[calibration.achieved]  # means over specimens, with the ends of their 95 % intervals"]
    for name, dimension in PROPERTIES.items():
        if name in found.achieved:
            parts = [
                f"{key} = {number(getattr(found.achieved[name], key), dimension)}"
                for key in ("value", "low", "high")
            ]
            lines.append(f"{name} = {{{', '.join(parts)}}}")
    return lines
