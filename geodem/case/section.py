"""The section of a case: regions, a picture, a mesh or a terrain, with its refinement, to metres."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np

from geodem import units
from geodem.builders.image_pixels import TOO_LARGE
from geodem.case import mesh_section, terrain_section
from geodem.case.data import ImageSection, Point, Refinement, RegionSection, SectionOptions
from geodem.case.source_files import LENGTH_UNITS, find_file
from geodem.case.table import Findings, Table, listed

_OWN_KEYS = {
    "regions": (),
    "image": ("scale", "legend", "background", "y_axis", "origin"),
    "mesh": mesh_section.KEYS,
    "terrain": terrain_section.KEYS,
}
"""What a section can be given by, and the keys that go with each."""
KEYS = (
    "length_unit",
    *(key for kind, keys in _OWN_KEYS.items() for key in (kind, *keys)),
    "refine",
    "layers",
    "thin",
)
REGION_EXAMPLE = '{material = "soil", polygon = [[0, 0], [10, 0], [10, 5]]}'
_REFINE_EXAMPLE = '{material = "seam", spacing = "0.2 m"}'
_COLOUR = re.compile(r"#?([0-9a-fA-F]{3}|[0-9a-fA-F]{6})")

# Side lengths [m] outside which a section is more likely a wrong unit than a slope
_SMALLEST, _LARGEST = 1.0, 10_000.0


def positive(value: float) -> tuple[str, str] | None:
    """Check for `Table.quantity`: above zero."""
    return None if value > 0.0 else ("this must be above zero", "Give a positive value.")


class Coordinates:
    """Turns coordinates in the section's length unit into metres, correctly rounded."""

    def __init__(self, symbol: str) -> None:
        self.symbol = symbol

    def point(self, findings: Findings, place: str, value: object) -> Point | None:
        """[x, y] in metres, or None where it is no point (which has then been reported)."""
        if not isinstance(value, list) or len(value) != 2:
            what = f"{len(value)} entries" if isinstance(value, list) else units.describe(value)
            findings.error(
                place, f"a point has two coordinates, this is {what}", "Write [x, y].", value=value
            )
            return None
        x, y = (self._metres(findings, f"{place}[{index}]", entry) for index, entry in enumerate(value))
        return None if x is None or y is None else (x, y)

    def _metres(self, findings: Findings, place: str, entry: object) -> float | None:
        remedy = f"Write a bare number in {self.symbol} (section.length_unit)."
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            findings.error(
                place, f"a coordinate is needed here, not {units.describe(entry)}", remedy, value=entry
            )
            return None
        try:
            value = float(entry)
        except OverflowError:
            value = math.inf
        if not abs(value) < 1e12:
            findings.error(place, "this coordinate is not finite or beyond all ground", remedy, value=entry)
            return None
        return units.parse(f"{value!r} {self.symbol}", "length", place=place)


def read_section(
    top: Table, folder: Path, materials: tuple[str, ...]
) -> tuple[SectionOptions | None, Coordinates]:
    """The section and its coordinates; None where something in it is wrong (which has then been reported).

    `materials`: names of the tables of materials.
    """
    findings = top.findings
    table = top.sub("section", KEYS, example=f"[section] with regions = [{REGION_EXAMPLE}]")
    if table is None:
        if "section" not in top:
            top.missing(
                "section", f'Add [section] with regions = [{REGION_EXAMPLE}] or image = "section.png".'
            )
        return None, Coordinates("m")
    coordinates = Coordinates(read_length_unit(table))
    before = len(findings.errors)
    kinds = [kind for kind in _OWN_KEYS if kind in table]
    section: SectionOptions | None = None
    # layers of a terrain are those of the ground; the triangles of a mesh need none
    own = "terrain" in table or ("mesh" in table and table.content.get("particles_on") == "nodes")
    options = _options(table, coordinates, "terrain" in table, own)
    if len(kinds) != 1:
        problem = f"{' and '.join(kinds)} are both given"
        if not kinds:
            problem = "neither regions nor image, mesh or terrain is given"
        elif len(kinds) > 2:
            problem = f"{', '.join(kinds[:-1])} and {kinds[-1]} are given"
        findings.error(
            table.place, problem,
            f'Give exactly one: regions = [{REGION_EXAMPLE}], image = "section.png", mesh = "section.msh" or '
            'terrain = "heights.npz".',
        )  # fmt: skip
    else:
        _refuse_foreign_keys(table, kinds[0])
        if kinds == ["regions"]:
            section = _regions(table, coordinates, options)
        elif kinds == ["image"]:
            section = _image(table, coordinates, folder, options)
        elif kinds == ["mesh"]:
            section = mesh_section.read_mesh_section(table, folder, options)
        else:
            section = terrain_section.read_terrain_section(table, folder, options, materials)
    if section is None or len(findings.errors) > before:
        return None, coordinates
    _check_size(findings, section)
    if len(findings.errors) > before:
        return None, coordinates  # with a wrong unit every other length would look wrong too
    _check_refinement(findings, section)
    return section, coordinates


def _refuse_foreign_keys(table: Table, kind: str) -> None:
    """Keys of another kind of section."""
    for other, keys in _OWN_KEYS.items():
        for key in keys if other != kind else ():
            if key in table and key not in _OWN_KEYS[kind]:
                article = "an" if other == "image" else "a"
                table.error(
                    key, f"this belongs to a section from {article} {other}",
                    f"Remove {key}, or give {other} instead of {kind}.",
                )  # fmt: skip


def read_length_unit(table: Table) -> str:
    """Unit of bare coordinates."""
    if "length_unit" not in table:
        table.findings.default(table.at("length_unit"), '"m"', why="coordinates are metres")
        return "m"
    return table.choice("length_unit", LENGTH_UNITS) or "m"


def _options(table: Table, coordinates: Coordinates, layered: bool, silent: bool) -> dict[str, Any]:
    """How the section is filled.

    `layered`: the key layers holds those of the ground, not rows of triangles; `silent`: nothing is told of it.
    """
    layers = (
        None if layered else table.integer("layers", smallest=2, remedy="Write a whole number from 2 to 50.")
    )
    if layers is not None and layers > 50:
        table.error(
            "layers",
            "so many rows of triangles make no seam more accurate",
            "Write a whole number from 2 to 50.",
        )
    if "layers" not in table and not silent:
        table.findings.default(table.at("layers"), "2", why="rows of triangles across the thinnest seam")
    refine = []
    for row in table.rows("refine", ("material", "box", "spacing"), example=_REFINE_EXAMPLE):
        entry = _refinement(row, coordinates)
        if entry is not None:
            refine.append(entry)
    nodes = silent and not layered
    thin = table.choice("thin", ("refine", "refuse"), default=None if nodes else "refine")
    return {"layers": layers or 2, "thin": thin or "refine", "refine": tuple(refine)}


def _refinement(row: Table, coordinates: Coordinates) -> Refinement | None:
    spacing = row.quantity("spacing", "length", check=positive)
    if "spacing" not in row:
        row.missing("spacing", 'Write spacing = "0.2 m".')
    if ("material" in row) == ("box" in row):
        problem = "material and box are both given" if "box" in row else "neither material nor box is given"
        row.findings.error(row.place, problem, f"Give exactly one, as in {_REFINE_EXAMPLE}.")
        return None
    if "material" in row:
        material = row.text("material", remedy="Name a material.")
        return None if material is None or spacing is None else Refinement(spacing, material=material)
    corners = row.items("box", example="[[0, 0], [10, 5]]")
    if len(corners) != 2:
        row.error("box", "a box is given by two opposite corners", "Write box = [[0, 0], [10, 5]].")
        return None
    points = [coordinates.point(row.findings, f"{row.at('box')}[{i}]", c) for i, c in enumerate(corners)]
    if points[0] is None or points[1] is None or spacing is None:
        return None
    (x0, y0), (x1, y1) = points[0], points[1]
    if x0 == x1 or y0 == y1:
        row.error("box", "this box has no area", "Give two opposite corners.")
        return None
    return Refinement(spacing, box=(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)))


def _regions(table: Table, coordinates: Coordinates, options: dict[str, Any]) -> RegionSection | None:
    rows = table.rows("regions", ("material", "polygon"), example=REGION_EXAMPLE)
    if not rows and isinstance(table.content["regions"], list) and not table.content["regions"]:
        table.error("regions", "there is no region", f"Write regions = [{REGION_EXAMPLE}].")
    regions = []
    for row in rows:
        material = row.text("material", remedy="Name a material that has its own [material.NAME].")
        if "material" not in row:
            row.missing("material", f"Write {REGION_EXAMPLE}.")
        polygon = read_polygon(row, coordinates)
        if material is not None and polygon is not None:
            regions.append((material, polygon))
    return RegionSection(regions=tuple(regions), **options) if regions else None


def read_polygon(row: Table, coordinates: Coordinates) -> np.ndarray | None:
    """Corners [m] of the key `polygon`, or None where they are none, which has then been told."""
    if "polygon" not in row:
        row.missing("polygon", f"Write {REGION_EXAMPLE}.")
        return None
    corners = row.items("polygon", example="[[0, 0], [10, 0], [10, 5]]")
    if not isinstance(row.content["polygon"], list):
        return None
    points = [coordinates.point(row.findings, f"{row.at('polygon')}[{i}]", c) for i, c in enumerate(corners)]
    good = [point for point in points if point is not None]
    if len(good) < len(points):
        return None
    if len(good) > 1 and good[0] == good[-1]:
        good.pop()
    if len(set(good)) < 3:
        row.error(
            "polygon", "a polygon has at least three different corners", "Give [[x, y], [x, y], [x, y], ...]."
        )
        return None
    polygon = np.array(good, dtype=np.float64)
    x, y = (polygon - polygon[0]).T
    twice_area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    if abs(twice_area) <= 1e-12 * float(np.ptp(x) + np.ptp(y)) ** 2:
        row.error(
            "polygon",
            "the corners lie on one line, or the outline crosses itself",
            "Give the corners in order round it.",
        )
        return None
    return polygon


def _image(
    table: Table, coordinates: Coordinates, folder: Path, options: dict[str, Any]
) -> ImageSection | None:
    found = _picture(table, folder)
    scale = table.quantity("scale", "pixel_scale", check=positive)
    if "scale" not in table:
        table.missing("scale", 'Write scale = "0.25 m/px".')
    legend = read_legend(table)
    background = read_background(table, legend)
    y_axis = table.choice("y_axis", ("up", "down"), default="up")
    origin: Point | None = (0.0, 0.0)
    if "origin" in table:
        origin = coordinates.point(table.findings, table.at("origin"), table.content["origin"])
    else:
        table.findings.default(table.at("origin"), "[0, 0]", why="the picture's lower left corner")
    if found is None or scale is None or y_axis is None or origin is None or not legend:
        return None
    path, pixels = found
    return ImageSection(
        image=path,
        scale=scale,
        legend=legend,
        background=background,
        y_axis=y_axis,
        origin=origin,
        pixels=pixels,
        **options,
    )


def _picture(table: Table, folder: Path) -> tuple[Path, tuple[int, int]] | None:
    path = find_file(table, "image", folder)
    if path is None:
        return None
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            return path, picture.size
    except Image.DecompressionBombError:
        table.error("image", *TOO_LARGE)
        return None
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError) as error:
        table.error("image", "this file cannot be read as a picture", f"Save it as PNG. ({str(error)[:120]})")
        return None


def _colour(findings: Findings, place: str, value: object) -> str | None:
    match = _COLOUR.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        findings.error(
            place,
            "this is not a colour",
            'Write it like "#8c6d31" (red, green, blue in hexadecimal).',
            value=value,
        )
        return None
    digits = match.group(1).lower()
    return "#" + (digits if len(digits) == 6 else "".join(2 * digit for digit in digits))


def read_legend(table: Table) -> dict[str, str]:
    """Colours and their materials; empty where that is wrong, which has then been told."""
    example = 'legend = {"#8c6d31" = "soil", "#d62728" = "seam"}'
    content = table.content.get("legend")
    if not isinstance(content, dict) or not content:
        problem = "missing" if content is None else "a table of colours is needed here"
        table.findings.error(table.at("legend"), problem, f"Write {example}.", value=content or None)
        return {}
    inner = Table(table.findings, table.at("legend"), content, tuple(content))
    legend: dict[str, str] = {}
    for key in content:
        colour = _colour(table.findings, inner.at(key), key)
        material = inner.text(key, remedy=f"Name a material, as in {example}.")
        if colour in legend:
            inner.error(key, "this colour stands in the legend twice", "Keep one of the two.")
        elif colour is not None and material is not None:
            legend[colour] = material
    return legend


def read_background(table: Table, legend: dict[str, str]) -> tuple[str, ...]:
    """Colours that are no ground."""
    if "background" not in table:
        white = "#ffffff"
        found = () if white in legend else (white,)
        table.findings.default(
            table.at("background"), f'["{white}"]' if found else "none", why="colours that are no ground"
        )
        return found
    colours: dict[str, None] = {}
    for index, value in enumerate(table.items("background", example='["#ffffff"]')):
        place = f"{table.at('background')}[{index}]"
        colour = value if value == "transparent" else _colour(table.findings, place, value)
        if colour in legend:
            problem = f"this colour is a material in the legend ({legend[colour]})"
            table.findings.error(place, problem, "Keep it in one of the two.", value=value)
        elif colour is not None:
            colours[colour] = None
    return tuple(colours)


def _check_size(findings: Findings, section: SectionOptions) -> None:
    left, bottom, right, top = section.bounds
    size = max(right - left, top - bottom)
    if not _SMALLEST <= size <= _LARGEST:
        place = "section.scale" if isinstance(section, ImageSection) else "section.length_unit"
        if section.key == "terrain":
            place = "section.line"
        wide, high = units.show(right - left, "length"), units.show(top - bottom, "length")
        problem = f"the section is {wide} wide and {high} high"
        remedy = f"Is it the right one of {listed(LENGTH_UNITS)}?"
        if not place.endswith("length_unit"):
            remedy = (
                "Check it against the drawing." if place == "section.scale" else "Check it against the map."
            )
        findings.implausible(place, problem, remedy)


def _check_refinement(findings: Findings, section: SectionOptions) -> None:
    left, bottom, right, top = section.bounds
    for index, entry in enumerate(section.refine):
        place = f"section.refine[{index}]"
        if entry.spacing > max(right - left, top - bottom):
            shown = units.show(entry.spacing, "length")
            findings.implausible(
                f"{place}.spacing", f"{shown} is more than the whole section", "Give a smaller spacing."
            )
        if entry.box and (
            entry.box[0] >= right or entry.box[2] <= left or entry.box[1] >= top or entry.box[3] <= bottom
        ):
            findings.error(
                f"{place}.box", f"this box lies outside the section ({bounds_text(section)})", "Move it."
            )


def bounds_text(section: SectionOptions) -> str:
    """Where a section lies, for a message."""
    left, bottom, right, top = section.bounds
    return f"x from {left:g} to {right:g} m, y from {bottom:g} to {top:g} m"
