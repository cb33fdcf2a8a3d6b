"""A case of breaking ground from its text."""

from __future__ import annotations

from pathlib import Path

from geodem.case.breaking import BreakingCase, PointOptions, StageOptions, WallOptions
from geodem.case.breaking_stages import read_stages
from geodem.case.head import read_head
from geodem.case.places import Places
from geodem.case.scene import SceneCase
from geodem.case.scene_reading import SCENE_KEYS, read_scene
from geodem.case.table import Table, listed

KEYS = (
    "workflow", "title", "allow_implausible", "seed", *SCENE_KEYS, "motion", "point", "wall", "stage",
)  # fmt: skip
MOTION_KEYS = ("damping", "time_step_factor")
_POINT = '{name = "crest", at = [10, 20]}'
_WALL = '{name = "floor", points = [[0, 0], [10, 0]]}'


def parse_breaking(text: str, folder: Path) -> BreakingCase:
    """Read a case; relative paths in it are relative to `folder`.

    Raises
    ------
    InputErrors
        Everything that is wrong in it, in the order of the file.
    """
    head = read_head(text, folder, "breaking", KEYS, example="Cavern under a frame")
    top = head.top
    seed = head.seed()
    scene = read_scene(top, folder, seed=seed)
    source = None if scene is None else scene.source
    unit = "m" if source is None else source.options.get("unit", "m")
    places = Places(unit, None if source is None else source.dimension)
    damping, factor = _motion(top)
    points = _points(top, places)
    walls = _walls(top, places, scene)
    stressed = "initial_stress" in top
    stages = read_stages(top, places, stressed=stressed)
    if scene is not None:
        _refuse_unknown(top, scene, walls, stages)
    common = head.close()
    assert scene is not None  # or close has raised
    return BreakingCase(
        **common, scene=scene, stages=stages, points=points, walls=walls, damping=damping,
        time_step_factor=factor, seed=seed,
    )  # fmt: skip


def _motion(top: Table) -> tuple[float, float]:
    usual = BreakingCase.damping, BreakingCase.time_step_factor
    table = top.sub("motion", MOTION_KEYS, example="[motion] with damping = 0.7")
    if table is None:
        table = Table(top.findings, "motion", {}, MOTION_KEYS)
    found = []
    for key, default, low in zip(MOTION_KEYS, usual, (0.0, 1e-6), strict=True):

        def check(value: float, low: float = low, default: float = default) -> tuple[str, str] | None:
            if low <= value < 1.0:
                return None
            return "this lies between 0 and 1", f"Write {default:g}."

        value = table.quantity(key, "dimensionless", check=check)
        if key not in table:
            top.findings.default(table.at(key), f"{default:g}")
        found.append(default if value is None else value)
    return found[0], found[1]


def _points(top: Table, places: Places) -> tuple[PointOptions, ...]:
    found: list[PointOptions] = []
    for number, row in enumerate(top.rows("point", ("name", "at"), example=_POINT)):
        name = row.text("name", remedy='Write name = "crest".') or f"point {number + 1}"
        if "at" not in row:
            row.missing("at", "Write at = [10, 20].")
        if name in [point.name for point in found]:
            row.error("name", "another point has this name", "Give it one of its own.")
        at = places.point(row, "at")
        if at is not None:
            found.append(PointOptions(name, at))
    return tuple(found)


def _walls(top: Table, places: Places, scene: SceneCase | None) -> tuple[WallOptions, ...]:
    found: list[WallOptions] = []
    rows = top.rows("wall", ("name", "points", "friction"), example=_WALL)
    if rows and places.dimension == 3:
        top.error("wall", "walls of lines belong to a section", "Leave them out in 3D.")
        return ()
    for row in rows:
        name = row.text("name", remedy='Write name = "floor".')
        if "name" not in row:
            row.missing("name", 'Write name = "floor".')
        if "points" not in row:
            row.missing("points", "Write points = [[0, 0], [10, 0]].")
        points = places.points(row, "points")
        friction = row.quantity("friction", "dimensionless", check=_not_negative)
        taken = [wall.name for wall in found]
        if scene is not None:
            taken += [*scene.materials, *scene.boundary]
        if name in taken:
            row.error("name", "a side, a material or another wall has this name", "Give it one of its own.")
        elif name is not None and points:
            found.append(WallOptions(name, points, friction))
    return tuple(found)


def _refuse_unknown(
    top: Table, scene: SceneCase, walls: tuple[WallOptions, ...], stages: tuple[StageOptions, ...]
) -> None:
    """Walls and materials that stages name and that are not there."""
    there = [side for side, kind in scene.boundary.items() if kind in ("wall", "rough")]
    there += [wall.name for wall in walls]
    for number, stage in enumerate(stages):
        place = f"stage[{number}]"
        name = stage.values.get("wall")
        if name is not None and name not in there:
            remedy = f"Known: {listed(there)}. Name a [[wall]], or a side that is a wall in [boundary]."
            top.findings.error(f"{place}.wall", "there is no such wall", remedy, value=name)
        elif stage.kind == "remove-wall":
            parted = "from" in stage.values
            if not parted:
                there.remove(str(name))
            elif name not in scene.boundary:
                top.findings.error(
                    f"{place}.from", "a part can be taken out of a side only",
                    "Make [[wall]] of several pieces, and take one of them away.",
                )  # fmt: skip
        for material in stage.values.get("material", ()):
            if material not in scene.materials:
                top.findings.error(
                    f"{place}.material", "there is no such material", f"Known: {listed(scene.materials)}.",
                    value=material,
                )  # fmt: skip


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Write 0 for a smooth wall.")
