"""The table [source] of a case of ground: what the body is made from, and with which settings."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from geodem import units
from geodem.case import drawn_source
from geodem.case.ground import GroundSource
from geodem.case.section import positive, read_background, read_legend
from geodem.case.source_files import LENGTH_UNITS, existing, find_file, read_lengths, read_names
from geodem.case.table import Table, listed
from geodem.case.terrain_section import read_base, read_degrees, read_holes, read_place, read_strata

_BY_BRIGHTNESS = ("materials", "thresholds", "smoothing", "lighting", "smallest", "grains", "apart")
SOURCES = {
    "image": ("scale", "legend", "background", "origin"),
    "photograph": ("scale", *_BY_BRIGHTNESS, "origin"),
    "slices": ("voxel", "legend", "background", *_BY_BRIGHTNESS, "origin"),
    "grid": ("scalars", "thresholds", "materials"),
    "mesh": ("length_unit", "names", "material_array"),
    "solids": ("length_unit",),
    "geometry": ("length_unit", "names", "size"),
    "terrain": ("base", "layers", "degrees", "holes", "cut_out"),
    "regions": ("length_unit",),
    "box": ("origin", "layers"),
}
"""What a body can be made from, and the keys that go with each."""

DRAWN = ("regions", "box")
"""Those that need no file."""

KEYS = tuple(dict.fromkeys(key for kind, keys in SOURCES.items() for key in (kind, *keys)))
EXAMPLE = 'image = "section.png" with scale and legend'
NOTHING = "none"
"""The material of a class that is no ground."""
_MATERIALS = 'materials = ["grain", "none"]'
_LARGEST_BRIGHTNESS = 1.0
_LARGEST_NUMBER = 1e300


def read_source(top: Table, folder: Path, materials: tuple[str, ...]) -> GroundSource | None:
    """The source of a case; None where something is wrong, which has then been told.

    `materials`: those that the case defines; one alone needs no layers of a terrain.
    """
    findings = top.findings
    table = top.sub("source", KEYS, example=f"[source] with {EXAMPLE}")
    if table is None:
        if "source" not in top:
            top.missing("source", f"Add [source] with {EXAMPLE}, or with one of {listed(SOURCES)}.")
        return None
    before = len(findings.errors)
    kinds = [kind for kind in SOURCES if kind in table]
    if len(kinds) != 1:
        problem = f"{' and '.join(kinds)} are given" if kinds else "nothing says what the ground is made from"
        findings.error(table.place, problem, f"Give exactly one of {listed(SOURCES)}.")
        return None
    kind = kinds[0]
    _refuse_foreign(table, kind)
    if kind == "solids":
        files = _solids(table, folder)
    elif kind in DRAWN:
        files = {}
    else:
        path = find_file(table, kind, folder, folders=kind == "slices")
        files = {} if path is None else {kind: path}
    options = _READERS[kind](table, materials)
    if (not files and kind not in DRAWN) or len(findings.errors) > before:
        return None
    return GroundSource(kind, files, {key: value for key, value in options.items() if value is not None})


def _refuse_foreign(table: Table, kind: str) -> None:
    """Keys of another source."""
    for key in table.content:
        owners = [other for other, keys in SOURCES.items() if key in keys]
        if owners and kind not in owners:
            own = ", ".join(SOURCES[kind])
            table.error(
                key,
                f"this belongs to {' or '.join(owners)}",
                f"Remove it; {kind} goes with {own}.",
            )


def _solids(table: Table, folder: Path) -> dict[str, Path]:
    example = 'solids = {rock = "rock.stl", ore = "ore.stl"}'
    content = table.content["solids"]
    if not isinstance(content, dict) or not content:
        table.error("solids", "a file for each material is needed here", f"Write {example}.")
        return {}
    inner = Table(table.findings, table.at("solids"), content, tuple(content))
    found = {}
    for name in content:
        text = inner.text(name, remedy=f"Name a file, as in {example}.")
        path = None if text is None else existing(inner, name, text, folder)
        if path is not None:
            found[name] = path
    return found


def _image(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    legend = read_legend(table)
    return {
        "scale": _scale(table),
        "legend": legend or None,
        "background": read_background(table, legend),
        "origin": read_lengths(table, "origin", 2),
    }


def _scale(table: Table) -> float | None:
    if "scale" not in table:
        table.missing("scale", 'Write scale = "2 mm/px", the side of a pixel.')
    return table.quantity("scale", "pixel_scale", check=positive)


def _photograph(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    return {"scale": _scale(table), **_brightness(table), "origin": read_lengths(table, "origin", 2)}


def _slices(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    options: dict[str, Any] = {"origin": read_lengths(table, "origin", 3)}
    if "voxel" not in table:
        table.missing("voxel", 'Write voxel = "0.1 mm", or ["0.1 mm", "0.1 mm", "0.5 mm"] along x, y and z.')
    elif isinstance(table.content["voxel"], list):
        options["voxel"] = read_lengths(table, "voxel", 3, above_zero=True)
    else:
        side = table.quantity("voxel", "length", check=positive)
        options["voxel"] = None if side is None else (side,) * 3
    if "legend" not in table:
        return options | _brightness(table)
    for key in _BY_BRIGHTNESS:
        if key in table:
            table.error(
                key, "the legend tells the materials by colour", f"Remove {key}, or remove the legend."
            )
    legend = read_legend(table)
    return options | {"legend": legend or None, "background": read_background(table, legend)}


def _brightness(table: Table) -> dict[str, Any]:
    names = _materials(table)
    cuts = _numbers(table, "thresholds")
    for cut in cuts or ():
        if not 0.0 < cut < _LARGEST_BRIGHTNESS:
            table.error("thresholds", "brightness lies between 0, black, and 1, white", "Write [0.4].")
            break
    _check_parts(table, cuts, names)
    grains = table.text("grains", remedy="Name one of materials.")
    if grains is not None and names and grains not in names:
        table.error(
            "grains", "this is none of the materials", f"Name one of {listed(n for n in names if n)}."
        )
    if "thresholds" not in table:
        table.findings.default(
            table.at("thresholds"), "what parts the brightness best", why="Otsu; the report says where"
        )
    return {
        "materials": names or None,
        "thresholds": cuts,
        "smoothing": table.quantity("smoothing", "dimensionless", check=_not_negative) or 0.0,
        "lighting": table.quantity("lighting", "dimensionless", check=positive),
        "smallest": table.integer("smallest", smallest=0, remedy="Write a number of pixels such as 50.") or 0,
        "grains": grains,
        "apart": table.quantity("apart", "dimensionless", check=positive),
    }


def _grid(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    names, cuts = _materials(table), _numbers(table, "thresholds")
    if "thresholds" not in table:
        table.missing("thresholds", "Write thresholds = [0.5], in the unit of the values.")
    _check_parts(table, cuts, names)
    return {
        "scalars": table.text("scalars", remedy='Write scalars = "density".'),
        "thresholds": cuts,
        "materials": names or None,
    }


def _mesh(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    return {
        "length_unit": table.choice("length_unit", LENGTH_UNITS) if "length_unit" in table else None,
        "names": read_names(table) or None,
        "material_array": table.text("material_array", remedy='Write material_array = "MaterialIDs".'),
        "size": table.quantity("size", "length", check=positive),
    }


def _terrain(table: Table, materials: tuple[str, ...]) -> dict[str, Any]:
    cut = None
    if "cut_out" in table:
        remedy = "Write cut_out = [[0, 0], [500, 400]]: two opposite corners in the coordinates of the file."
        corners = table.items("cut_out", example="[[0, 0], [500, 400]]")
        places = [read_place(table, f"cut_out[{k}]", value, remedy) for k, value in enumerate(corners)]
        if len(corners) != 2:
            table.error("cut_out", "a part is cut out by two opposite corners", remedy)
        elif places[0] is not None and places[1] is not None:
            (a, b), (c, d) = places[0], places[1]
            cut = ((min(a, c), min(b, d)), (max(a, c), max(b, d)))
    return {
        "base": read_base(table),
        "layers": read_strata(table, materials) or None,
        "degrees": read_degrees(table),
        "holes": read_holes(table),
        "cut_out": cut,
    }


_READERS: dict[str, Callable[[Table, tuple[str, ...]], dict[str, Any]]] = {
    "image": _image,
    "photograph": _photograph,
    "slices": _slices,
    "grid": _grid,
    "mesh": _mesh,
    "solids": _mesh,
    "geometry": _mesh,
    "terrain": _terrain,
    "regions": drawn_source.read_regions,
    "box": drawn_source.read_box,
}


def _materials(table: Table) -> tuple[str | None, ...]:
    if "materials" not in table:
        table.missing("materials", f'Write {_MATERIALS}, from dark to bright; "{NOTHING}" is no ground.')
        return ()
    entries = table.items("materials", example='["grain", "none"]')
    if any(not isinstance(name, str) or not name.strip() for name in entries) or len(entries) < 2:
        table.error("materials", "two or more names are needed here", f"Write {_MATERIALS}.")
        return ()
    if all(name == NOTHING for name in entries):
        table.error("materials", "there is no ground among these", f"Write {_MATERIALS}.")
    return tuple(None if name == NOTHING else name for name in entries)


def _numbers(table: Table, key: str) -> tuple[float, ...] | None:
    if key not in table:
        return None
    entries = table.items(key, example="[0.4, 0.7]")
    if not entries or any(
        isinstance(n, bool) or not isinstance(n, int | float) or not abs(n) < _LARGEST_NUMBER for n in entries
    ):
        table.error(key, "numbers are needed here", f"Write {key} = [0.4, 0.7].")
        return None
    numbers = tuple(map(float, entries))
    if any(not b > a for a, b in itertools.pairwise(numbers)):
        table.error(key, "these do not grow", "Give them in ascending order.")
    return numbers


def _check_parts(table: Table, cuts: tuple[float, ...] | None, names: tuple[str | None, ...]) -> None:
    if cuts is not None and names and len(names) != len(cuts) + 1:
        problem = f"{len(cuts)} thresholds part {len(cuts) + 1} materials, these are {len(names)}"
        table.error("materials", problem, f'Name one for each part, "{NOTHING}" for what is no ground.')


def _not_negative(value: float) -> tuple[str, str] | None:
    return (
        None if value >= 0.0 else (f"{units.show(value, 'dimensionless')} is below zero", "Give 0 or more.")
    )
