"""How the specimens of a case are made."""

from __future__ import annotations

import math

from geodem import units
from geodem.case.laboratory import SpecimenOptions
from geodem.case.section import positive
from geodem.case.table import Table

SPECIMEN_KEYS = ("dimension", "packing", "shape", "width", "height", "across", "size_ratio")
CALIBRATION_KEYS = ("dimension", "shape", "width", "across", "size_ratio")
"""Of the specimens of a calibration, which are twice as high as wide and of the random packing of the map."""
PACKINGS = {2: ("random", "triangular", "square"), 3: ("random", "fcc")}
SHAPES = {2: ("prism",), 3: ("prism", "cylinder")}
ACROSS = {2: 40.0, 3: 16.0}
ACROSS_CALIBRATION = {2: 30.0, 3: 10.0}
"""Particles across where a case does not say: in 3D what still runs in minutes."""

COARSEST, COARSE = 10.0, 30.0
_MANY = 2_000_000  # particles of one specimen: above, a test takes days


def read_specimen(
    top: Table, usual: dict[int, float], keys: tuple[str, ...] = SPECIMEN_KEYS
) -> SpecimenOptions | None:
    """The specimens of a case, with `usual` particles across where it does not say; None where something is wrong."""
    findings = top.findings
    before = len(findings.errors)
    table = top.sub("specimen", keys, example='[specimen] with dimension = 2, width = "50 mm", across = 40')
    if table is None:
        if "specimen" in top:
            return None
        table = Table(findings, "specimen", {}, keys)
    dimension = table.integer("dimension", smallest=2, remedy="Write 2 for discs or 3 for spheres.")
    if "dimension" not in table:
        dimension = 2
        findings.default("specimen.dimension", "2", why="discs of one metre depth")
    elif dimension is not None and dimension > 3:
        table.error("dimension", "particles are discs (2) or spheres (3)", "Write 2 or 3.")
        dimension = None
    if dimension is None:
        return None
    packing: str | None = "random"
    if "packing" in keys:
        packing = table.choice("packing", PACKINGS[dimension], default="random")
    shape = table.choice("shape", SHAPES[dimension], default="prism")
    width = _length(table, "width", SpecimenOptions.width, "50 mm")
    height = table.quantity("height", "length", check=positive)
    if "height" in keys and "height" not in table:
        findings.default("specimen.height", "twice the width")
    elif height is not None and width is not None and not 1.0 <= height / width <= 5.0:
        problem = f"the height is {height / width:.3g} times the width"
        remedy = f"Usual are two to three times: {units.show(2.0 * width, 'length')}."
        findings.implausible("specimen.height", problem, remedy, value=table.content["height"])
    across = _across(table, usual[dimension])
    ratio = table.quantity("size_ratio", "dimensionless", check=_size_ratio)
    if "size_ratio" not in table:
        ratio = SpecimenOptions.size_ratio
        if packing == "random":
            findings.default("specimen.size_ratio", str(ratio))
    if len(findings.errors) > before:
        return None
    assert packing is not None
    assert shape is not None
    assert width is not None
    assert across is not None
    assert ratio is not None
    slender = 2.0 if height is None else height / width
    # discs of a dense packing, 1.05 a square of their mean diameter; spheres 1.2 a cube
    count = (1.05, 1.2)[dimension - 2] * slender * across**dimension
    if count > _MANY:
        problem = f"{count:.2g} particles a specimen: a test takes days"
        fewer = across * (_MANY / count) ** (1.0 / dimension)
        remedy = f"Write across = {math.floor(fewer)}, or fewer."
        findings.implausible("specimen.across", problem, remedy, value=across)
    return SpecimenOptions(dimension, packing, shape, width, height, across, ratio)


def _length(table: Table, key: str, usual: float, shown: str) -> float | None:
    if key not in table:
        table.findings.default(table.at(key), f'"{shown}"')
        return usual
    return table.quantity(key, "length", check=positive)


def _across(table: Table, usual: float) -> float | None:
    if "across" not in table:
        table.findings.default("specimen.across", f"{usual:g}")
        across: float | None = usual
    else:
        across = table.quantity("across", "dimensionless", check=_coarse)
    if across is not None and across < COARSE:
        table.findings.notices.append(
            f"specimen.across = {across:g}: below {COARSE:g} particles across, strength and friction still depend "
            "on how many there are."
        )
    return across


def _coarse(value: float) -> tuple[str, str] | None:
    if value >= COARSEST:
        return None
    problem = f"the specimen is too coarse: {value:g} particles across are no continuum"
    return problem, f"Write {COARSEST:g} at least, better {COARSE:g} or more."


def _size_ratio(value: float) -> tuple[str, str] | None:
    if 1.0 <= value <= 10.0:
        return None
    problem = "largest over smallest radius lies between 1 and 10"
    return problem, "Write 1.66, or 1 for equal particles, which order themselves in 2D."
