"""A section below a line across a terrain, with layers that follow the surface."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from geodem import units
from geodem.case.data import Point, SectionOptions
from geodem.case.source_files import find_file, read_named_material, read_or_tell
from geodem.case.table import Table

if TYPE_CHECKING:
    from geodem.builders.section import Section
    from geodem.builders.terrain import Terrain

KEYS = ("line", "base", "degrees", "holes", "step")
HOLES = ("refuse", "fill")
LAYERS = '[{material = "soil", depth = "3 m"}, {material = "rock"}]'
LINE = "[[0, 0], [120, 40]]"


@dataclass(frozen=True, eq=False)
class TerrainSection(SectionOptions):
    """A section from heights on a grid; x is the distance along the line, y the elevation.

    Attributes
    ----------
    path : pathlib.Path
        Absolute.
    section : Section
        What follows from the rest [m].
    line : tuple of (float, float)
        In the coordinates of the file, metres or degrees.
    base : float [m]
    strata : tuple of (str, float)
        Material of each layer and the depth [m] below the surface that it reaches to, infinite of the last.
    degrees : bool or None
        Whether x and y of the file are longitude and latitude; None: what the file says.
    holes : str
        ``refuse`` or ``fill``.
    step : float or None [m]
        Distance between the points of the surface; None: that of the heights.
    """

    path: Path
    section: Section
    line: tuple[Point, ...]
    base: float
    strata: tuple[tuple[str, float], ...]
    degrees: bool | None = None
    holes: str = "refuse"
    step: float | None = None

    key: ClassVar[str] = "terrain"

    @property
    def file(self) -> Path:
        """The terrain."""
        return self.path

    def beside(self) -> TerrainSection:
        """The same with its file named without a folder."""
        return replace(self, path=Path(self.path.name))

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials from the surface down."""
        return tuple(dict.fromkeys(material for material, _ in self.strata))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top [m]."""
        return self.section.bounds


def read_terrain_section(
    table: Table, folder: Path, options: dict[str, Any], materials: tuple[str, ...]
) -> TerrainSection | None:
    """The section of a table that names a terrain; None where something is wrong, which has then been told.

    `materials`: those that the case defines; one alone needs no layers.
    """
    findings = table.findings
    before = len(findings.errors)
    path = find_file(table, "terrain", folder)
    line = _line(table)
    base = read_base(table)
    strata = read_strata(table, materials)
    degrees, holes = read_degrees(table), read_holes(table)
    step = table.quantity("step", "length")
    if len(findings.errors) > before:
        return None
    assert path is not None
    assert base is not None
    place, name = table.at("terrain"), table.content["terrain"]
    keys = {"line": "line", "base": "base", "layers": "layers", "degrees": "degrees", "step": "step"}
    terrain = read_or_tell(findings, place, lambda: load_terrain(path, degrees, holes), value=name, keys=keys)
    if terrain is None:
        return None
    section = read_or_tell(
        findings, place, lambda: _cut(terrain, line, base, strata, step), value=name, keys=keys
    )
    if section is None:
        return None
    findings.notices += [f"{place}: {remark}" for remark in terrain.remarks]
    return TerrainSection(
        path=path, section=section, line=line, base=base, strata=strata, degrees=degrees, holes=holes, step=step,
        **options,
    )  # fmt: skip


def load_terrain(path: Path, degrees: bool | None, holes: str) -> Terrain:
    """The terrain of a file; raises as `geodem.builders.terrain_files.read_terrain`."""
    from geodem.builders.terrain_files import read_terrain

    return read_terrain(path, degrees=degrees, holes="fill" if holes == "fill" else "refuse")


def _cut(
    terrain: Terrain, line: tuple[Point, ...], base: float, strata: tuple[tuple[str, float], ...], step: float | None
) -> Section:  # fmt: skip
    from geodem.builders.terrain import Layer

    layers = [Layer(material, bottom) for material, bottom in strata]
    return terrain.section_along(terrain.metres(line), base=base, layers=layers, step=step)


def _line(table: Table) -> tuple[Point, ...]:
    remedy = f"Write line = {LINE}, x and y in the coordinates of the file."
    if "line" not in table:
        table.missing("line", remedy)
        return ()
    points = []
    for index, value in enumerate(table.items("line", example=LINE)):
        point = read_place(table, f"line[{index}]", value, remedy)
        if point is not None:
            points.append(point)
    if isinstance(table.content["line"], list) and len(table.content["line"]) < 2:
        table.error("line", "a line has two ends", remedy)
    return tuple(points)


def read_place(table: Table, key: str, value: object, remedy: str) -> Point | None:
    """x and y in the coordinates of a file, or None where it is no place (which has then been told)."""
    numbers = value if isinstance(value, list) else []
    good = [
        float(entry)
        for entry in numbers
        if isinstance(entry, int | float) and not isinstance(entry, bool) and abs(entry) < 1e12
    ]
    if len(numbers) == 2 and len(good) == 2:
        return good[0], good[1]
    what = f"{len(numbers)} entries" if isinstance(value, list) else units.describe(value)
    problem = "these are not two numbers" if len(numbers) == 2 else f"two numbers are needed, this is {what}"
    table.findings.error(f"{table.place}.{key}", problem, remedy, value=value)
    return None


def read_base(table: Table) -> float | None:
    """Elevation of the lower side."""
    if "base" not in table:
        table.missing("base", 'Write base = "120 m", the elevation down to which there is ground.')
    return table.quantity("base", "length")


def read_degrees(table: Table) -> bool | None:
    """Whether coordinates of the file are degrees; None where the case leaves that to the file."""
    value = table.content.get("degrees")
    if value is not None and not isinstance(value, bool):
        table.error(
            "degrees", f"a switch is needed here, not {units.describe(value)}", "Write degrees = true."
        )
        return None
    return value


def read_holes(table: Table) -> str:
    """What becomes of heights that are missing."""
    return (table.choice("holes", HOLES) if "holes" in table else "refuse") or "refuse"


def read_strata(table: Table, materials: tuple[str, ...]) -> tuple[tuple[str, float], ...]:
    """Materials and depths of the layers; the one material of a case where none is given."""
    if "layers" not in table:
        if len(materials) == 1:
            return ((materials[0], math.inf),)
        table.missing("layers", f"Write layers = {LAYERS}, from the surface down.")
        return ()
    rows = table.rows("layers", ("material", "depth"), example='{material = "soil", depth = "3 m"}')
    if isinstance(table.content["layers"], list) and not table.content["layers"]:
        table.error("layers", "there is no layer", f"Write layers = {LAYERS}.")
    strata: list[tuple[str, float]] = []
    for index, row in enumerate(rows):
        material = read_named_material(row, "material", LAYERS)
        depth = row.quantity("depth", "length")
        last = index == len(rows) - 1
        if last and "depth" in row:
            row.error(
                "depth", "the last layer reaches down to the base", "Remove this depth, or add a layer."
            )
        elif not last and "depth" not in row:
            row.missing("depth", 'Write depth = "3 m": how far below the surface it reaches.')
        above = strata[-1][1] if strata else 0.0
        if not last and depth is not None and depth <= above:
            problem = "this is no deeper than the layer above" if strata else "this must be above zero"
            row.error("depth", problem, "Depths count from the surface and grow downwards.")
        if material is not None:
            strata.append((material, math.inf if last or depth is None else depth))
    return tuple(strata)
