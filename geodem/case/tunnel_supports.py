"""Openings, linings and bolts of a tunnel case."""

from __future__ import annotations

import math

import shapely

from geodem import units
from geodem.case.section import Coordinates, positive
from geodem.case.table import Table, listed, nearest
from geodem.case.tunnel import BoltPattern, Excavation
from geodem.tunnelling.plan import Lining

EXCAVATION_EXAMPLE = '{name = "tunnel", circle = {centre = [0, 0], diameter = "10 m"}}'
LINING_EXAMPLE = '[[lining]] with name = "shell", thickness = "20 cm", young_modulus = "15 GPa"'
BOLT_EXAMPLE = '[[bolt]] with name = "bolts", angles = ["30 deg", "90 deg"], length = "3 m"'
STEEL = 200e9
LINING_THICKNESS = 1e-3, 5.0
BOLT_DIAMETER = 1e-3, 0.5
"""What is plausible [m]."""
_SHAPES = {"circle": ("centre", "diameter"), "horseshoe": ("floor", "width", "height")}
LINING_KEYS = (
    "name", "excavation", "thickness", "young_modulus", "poisson_ratio", "compressive_strength", "tensile_strength",
)  # fmt: skip
BOLT_KEYS = (
    "name", "excavation", "angles", "length", "bars", "kind", "diameter", "young_modulus", "yield_force", "spacing",
    "grout_stiffness", "grout_strength",
)  # fmt: skip


def read_excavations(top: Table, coordinates: Coordinates) -> tuple[Excavation, ...]:
    """Everything that may be dug out."""
    rows = _rows(top, "excavation", ("name", "circle", "horseshoe", "polygon"), EXCAVATION_EXAMPLE)
    if "excavation" not in top:
        top.missing("excavation", f"Add [[excavation]] as in {EXCAVATION_EXAMPLE}.")
    found: list[Excavation] = []
    for row in rows:
        name = _name(row, [entry.name for entry in found])
        kinds = [key for key in ("circle", "horseshoe", "polygon") if key in row]
        if len(kinds) != 1:
            problem = (
                "circle, horseshoe or polygon is needed" if not kinds else f"{' and '.join(kinds)} are given"
            )
            row.findings.error(row.place, problem, f"Give exactly one, as in {EXCAVATION_EXAMPLE}.")
            continue
        shape = _polygon(row, coordinates) if kinds == ["polygon"] else _round(row, kinds[0], coordinates)
        if name is not None and shape is not None:
            found.append(Excavation(name, kinds[0], *shape))
    return tuple(found)


def _rows(top: Table, key: str, known: tuple[str, ...], example: str) -> list[Table]:
    """Tables of a list; a single table stands for a list of one."""
    if isinstance(top.content.get(key), dict):
        return [Table(top.findings, top.at(key), top.content[key], known)]
    return top.rows(key, known, example=example)


def _name(row: Table, taken: list[str], default: str | None = None) -> str | None:
    if "name" not in row and default is not None:
        row.findings.default(row.at("name"), f'"{default}"')
        name: str | None = default
    else:
        name = row.text("name", remedy='Write name = "tunnel".')
        if "name" not in row:
            row.missing("name", 'Write name = "tunnel".')
    if name is not None and name in taken:
        row.findings.error(row.at("name"), "this name is given twice", "Give each its own.", value=name)
        return None
    return name


def _round(
    row: Table, kind: str, coordinates: Coordinates
) -> tuple[tuple[float, float], tuple[float, ...], tuple[()]] | None:
    keys = _SHAPES[kind]
    table = row.sub(kind, keys, example=EXCAVATION_EXAMPLE)
    if table is None:
        return None
    for key in keys:
        if key not in table:
            table.missing(key, f"{kind} has {listed(keys)}.")
    at = (
        coordinates.point(table.findings, table.at(keys[0]), table.content[keys[0]])
        if keys[0] in table
        else None
    )
    sizes = [table.quantity(key, "length", check=positive) for key in keys[1:]]
    good = tuple(size for size in sizes if size is not None)
    if at is None or len(good) < len(sizes):
        return None
    if kind == "horseshoe" and good[1] < 0.5 * good[0]:
        table.error(
            "height", "the roof is half a circle: it alone is half of the width", "Give a larger height."
        )
        return None
    return at, good, ()


def _polygon(
    row: Table, coordinates: Coordinates
) -> tuple[tuple[float, float], tuple[()], tuple[tuple[float, float], ...]] | None:
    entries = row.items("polygon", example="[[0, 0], [10, 0], [10, 5]]")
    points = [coordinates.point(row.findings, f"{row.at('polygon')}[{k}]", c) for k, c in enumerate(entries)]
    good = tuple(point for point in points if point is not None)
    if len(good) < len(points):
        return None
    if len(set(good)) < 3 or not shapely.Polygon(good).is_valid or shapely.Polygon(good).area <= 0.0:
        row.error(
            "polygon",
            "this outline encloses no area, or crosses itself",
            "Give the corners in order round it.",
        )
        return None
    return (0.0, 0.0), (), good


def read_linings(top: Table, excavations: tuple[str, ...]) -> tuple[Lining, ...]:
    """Everything that is put on walls."""
    found: list[Lining] = []
    for row in _rows(top, "lining", LINING_KEYS, LINING_EXAMPLE):
        before = len(row.findings.errors)
        name = _name(row, [entry.name for entry in found], "lining")
        excavation = _excavation(row, excavations)
        for key in ("thickness", "young_modulus"):
            if key not in row:
                row.missing(key, f"Write {LINING_EXAMPLE}.")
        thickness = row.quantity("thickness", "length", check=positive)
        modulus = row.quantity("young_modulus", "stress", check=positive)
        ratio = row.quantity("poisson_ratio", "dimensionless", check=_poisson)
        if "poisson_ratio" not in row:
            row.findings.default(row.at("poisson_ratio"), "0.2")
        judge_size(row, "thickness", thickness, LINING_THICKNESS, "no lining is as thick or thin as this")
        strengths = [row.quantity(key, "stress", check=positive) for key in LINING_KEYS[-2:]]
        if modulus is not None and not 1e8 <= modulus <= 3e11:
            row.findings.implausible(
                row.at("young_modulus"), "concrete has 5 to 40 GPa, steel 210 GPa", "Check the unit.",
                value=row.content["young_modulus"],
            )  # fmt: skip
        if len(row.findings.errors) > before or None in (name, excavation, thickness, modulus):
            continue
        assert name is not None
        assert excavation is not None
        assert thickness is not None
        assert modulus is not None
        limits = [math.inf if value is None else value for value in strengths]
        found.append(Lining(name, excavation, thickness, modulus, 0.2 if ratio is None else ratio, *limits))
    return tuple(found)


def judge_size(
    row: Table, key: str, value: float | None, plausible: tuple[float, float], problem: str
) -> None:
    """Refuse a size [m] outside what is plausible, until it is allowed."""
    low, high = plausible
    if value is not None and not low <= value <= high:
        usual = f"Usual are {units.show(low, 'length')} to {units.show(high, 'length')}: check the unit."
        row.findings.implausible(row.at(key), problem, usual, value=row.content[key])


def _poisson(value: float) -> tuple[str, str] | None:
    return None if 0.0 <= value < 0.5 else ("a Poisson ratio lies between 0 and 0.5", "Write 0.2.")


def _excavation(row: Table, excavations: tuple[str, ...], *, needed: bool = True) -> str | None:
    if "excavation" not in row:
        if len(excavations) == 1:
            return excavations[0]
        if needed and excavations:
            row.missing("excavation", f"Name one of {listed(excavations)}.")
        return None
    name = row.text("excavation", remedy="Name an excavation.")
    if name is not None and name not in excavations:
        row.error(
            "excavation",
            "there is no such excavation",
            f"{nearest(name, excavations)}Known: {listed(excavations)}.",
        )
        return None
    return name


def read_bolts(top: Table, coordinates: Coordinates, excavations: tuple[str, ...]) -> tuple[BoltPattern, ...]:
    """All patterns of bolts."""
    found: list[BoltPattern] = []
    for row in _rows(top, "bolt", BOLT_KEYS, BOLT_EXAMPLE):
        before = len(row.findings.errors)
        name = _name(row, [entry.name for entry in found], "bolts")
        radial = "angles" in row
        if radial == ("bars" in row):
            row.findings.error(
                row.place, "angles or bars are needed", f"Give exactly one, as in {BOLT_EXAMPLE}."
            )
            continue
        excavation = _excavation(row, excavations) if radial else None
        angles = tuple(_angles(row)) if radial else ()
        bars = () if radial else _bars(row, coordinates)
        wanted = [("diameter", "length"), ("yield_force", "force"), ("spacing", "length")]
        wanted += [("length", "length")] if radial else []
        values = {key: row.quantity(key, dimension, check=positive) for key, dimension in wanted}
        judge_size(row, "diameter", values["diameter"], BOLT_DIAMETER, "no bolt is as thick or thin as this")
        for key in values:
            if key not in row:
                row.missing(
                    key, 'A bolt has length, diameter = "25 mm", yield_force = "150 kN", spacing = "1.5 m".'
                )
        modulus = row.quantity("young_modulus", "stress", check=positive)
        if "young_modulus" not in row:
            row.findings.default(row.at("young_modulus"), '"200 GPa"', why="steel")
        kind = row.choice("kind", ("grouted", "anchored"), default="grouted")
        stiffness = row.quantity("grout_stiffness", "stress", check=positive)
        strength = row.quantity("grout_strength", "line_load", check=positive)
        if kind == "grouted":
            if "grout_stiffness" not in row:
                row.findings.default(
                    row.at("grout_stiffness"), '"1 GPa"', why="shear force per length and slip"
                )
            if "grout_strength" not in row:
                row.findings.default(row.at("grout_strength"), "none", why="the grout does not slip")
        else:
            for key in ("grout_stiffness", "grout_strength"):
                if key in row:
                    row.error(
                        key, "an anchored bolt has no grout", f'Remove {key}, or write kind = "grouted".'
                    )
        if len(row.findings.errors) > before or name is None or kind is None:
            continue
        numbers = {key: value for key, value in values.items() if value is not None}
        found.append(
            BoltPattern(
                name, excavation, angles, numbers.get("length", 0.0), bars, numbers["diameter"], modulus or STEEL,
                numbers["yield_force"], numbers["spacing"], kind == "anchored", stiffness or 1e9,
                math.inf if strength is None else strength,
            )
        )  # fmt: skip
    return tuple(found)


def _angles(row: Table) -> list[float]:
    found = []
    for index, value in enumerate(row.items("angles", example='["30 deg", "90 deg"]')):
        inner = Table(row.findings, row.place, {f"angles[{index}]": value}, (f"angles[{index}]",))
        angle = inner.quantity(f"angles[{index}]", "angle")
        if angle is not None:
            found.append(angle)
    if not row.items("angles", example="[]"):
        row.error("angles", "there is no bolt", f"Write {BOLT_EXAMPLE}.")
    return found


def _bars(
    row: Table, coordinates: Coordinates
) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    found = []
    for index, value in enumerate(row.items("bars", example="[[[0, 5], [0, 8]]]")):
        place = f"{row.at('bars')}[{index}]"
        if not isinstance(value, list) or len(value) != 2:
            row.findings.error(
                place, f"a bar has two ends, this is {units.describe(value)}", "Write [[0, 5], [0, 8]]."
            )
            continue
        head, tip = (coordinates.point(row.findings, f"{place}[{k}]", end) for k, end in enumerate(value))
        if head is not None and tip is not None:
            if head == tip:
                row.findings.error(place, "head and end are the same point", "Give two points.", value=value)
            else:
                found.append((head, tip))
    return tuple(found)
