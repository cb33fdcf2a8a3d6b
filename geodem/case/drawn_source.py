"""Sources of ground that need no file: polygons, and boxes of layers."""

from __future__ import annotations

import math
from typing import Any

from geodem.case.section import REGION_EXAMPLE, Coordinates, positive, read_length_unit, read_polygon
from geodem.case.source_files import read_lengths, read_named_material
from geodem.case.table import Table, listed

_LAYERS = '{material = "clay", thickness = "2 m"}, {material = "rock"}'


def read_regions(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    """Polygons [m], a later one over the earlier ones, and the unit that bare coordinates have."""
    coordinates = Coordinates(read_length_unit(table))
    found = []
    rows = table.rows("regions", ("material", "polygon"), example=REGION_EXAMPLE)
    if not rows and table.content["regions"] == []:
        table.error("regions", "there is no region", f"Write regions = [{REGION_EXAMPLE}].")
    for row in rows:
        material = row.text("material", remedy="Name a material that has its own [material.NAME].")
        if "material" not in row:
            row.missing("material", f"Write {REGION_EXAMPLE}.")
        polygon = read_polygon(row, coordinates)
        if material is not None and polygon is not None:
            found.append((material, tuple(map(tuple, polygon.tolist()))))
    # all that follows is in metres
    return {"regions": tuple(found), "length_unit": "m", "unit": coordinates.symbol}


def read_box(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    """Sides, lower corner and layers of a box [m]."""
    entries = table.items("box", example='["20 m", "10 m"]')
    if isinstance(table.content["box"], list) and len(entries) not in (2, 3):
        table.error("box", "a box has two sides in 2D and three in 3D", 'Write box = ["20 m", "10 m"].')
        return {}
    count = len(entries)
    return {
        "box": read_lengths(table, "box", count, above_zero=True) if count else None,
        "origin": read_lengths(table, "origin", count) if count else None,
        "layers": _box_layers(table, materials) or None,
    }


def _box_layers(table: Table, materials: tuple[str, ...]) -> tuple[tuple[str, float], ...]:
    """Material and thickness from the top; the last one reaches to the bottom."""
    if "layers" not in table:
        if len(materials) == 1:
            return ((materials[0], math.inf),)
        if materials:
            table.missing("layers", f"The case has {listed(materials)}. Write layers = [{_LAYERS}].")
        return ()
    found = []
    rows = table.rows("layers", ("material", "thickness"), example=_LAYERS)
    for number, row in enumerate(rows):
        name = read_named_material(row, "material", f"layers = [{_LAYERS}]")
        thick = row.quantity("thickness", "length", check=positive)
        last = number == len(rows) - 1
        if last and "thickness" in row:
            row.error("thickness", "the last layer reaches to the bottom", "Remove its thickness.")
        if not last and "thickness" not in row:
            row.missing("thickness", f"Write layers = [{_LAYERS}].")
        if name is not None and (last or thick is not None):
            found.append((name, math.inf if last or thick is None else thick))
    if not rows:
        table.error("layers", "there is no layer", f"Write layers = [{_LAYERS}].")
    return tuple(found)
