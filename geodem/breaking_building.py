"""From a case of breaking ground to its site and its stages."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .assembly import Wall
from .boundaries.walls import segments
from .breaking.criteria import Criteria
from .breaking.scene import BondedScene, start, wall_words
from .breaking.search import SearchPlan
from .breaking.shapes import inside_circle, inside_cylinder, inside_polygon
from .breaking.site import Site
from .breaking.stages import (
    ChangeStrength,
    Excavate,
    FindFactor,
    Gravity,
    MoveWall,
    RemoveWalls,
    Run,
    Settle,
    Stage,
    Where,
)
from .breaking.supports import wall_place
from .builders.body import Body
from .case.breaking import BreakingCase, PointOptions, StageOptions
from .errors import InputError, InputErrors
from .ground_building import GroundBody
from .scene_building import make_filling, scene_of
from .units import show

Floats = NDArray[np.float64]
NEAR = 1.5
"""A measured point is a particle that is at most this many mean diameters away."""


@dataclass(frozen=True, eq=False)
class Works:
    """What a case becomes.

    Attributes
    ----------
    made : GroundBody
    scene : BondedScene
    site : Site
    stages : tuple of Stage
    """

    made: GroundBody
    scene: BondedScene
    site: Site
    stages: tuple[Stage, ...]


def build_works(case: BreakingCase) -> Works:
    """Body, particles, scene, site and stages of a case; nothing has moved yet.

    Raises
    ------
    InputError, InputErrors
        As of `geodem.scene_building.make_filling` and `scene_of`; measured points in the air, excavations that miss the
        ground, openings that are not in their wall.
    """
    made, filling = make_filling(case.scene, title=case.title, allow_implausible=case.allow_implausible)
    body = made.body
    refuse_misplaced(case, body, filling.positions, 2.0 * float(filling.radii.mean()))
    openings = _openings(case, filling.positions, filling.radii)
    boundary = {side: "free" if side in openings else kind for side, kind in case.scene.boundary.items()}
    walls = [wall for pieces in openings.values() for wall in pieces]
    walls += [_line(wall.name, np.array(wall.points), wall.friction) for wall in case.walls]
    scene = scene_of(replace(case.scene, boundary=boundary), body, filling, walls=walls)
    if len(scene.assembly.bonds):
        touching = {side: wall_place(side, filling.positions, filling.radii)[1] for side in openings}
        words = wall_words(filling, touching, case.scene.boundary)
        scene = replace(scene, warnings=(*scene.warnings, *words))
    simulation, _ = start(scene, local_damping=case.damping, energy=True, applied=True)
    if case.time_step_factor != BreakingCase.time_step_factor:
        step = case.time_step_factor * simulation.critical_time_step
        simulation, _ = start(scene, local_damping=case.damping, energy=True, applied=True, time_step=step)
    points = {point.name: int(scene.ids[_nearest(point, filling.positions)]) for point in case.points}
    site = Site.of(simulation, points)
    return Works(made, scene, site, tuple(_stage(case, one, scene, openings) for one in case.stages))


def refuse_misplaced(case: BreakingCase, body: Body, positions: Floats, diameter: float) -> None:
    """Raise InputErrors for what a case puts where there is no ground.

    Parameters
    ----------
    case : BreakingCase
    body : Body
    positions : (n, d) [m]
        Of the particles.
    diameter : float [m]
        Their mean one.
    """
    errors: list[InputError] = []
    low, high = np.asarray(body.bounds)
    box = " to ".join(f"({', '.join(f'{x:g}' for x in corner)})" for corner in (low, high))
    for number, point in enumerate(case.points):
        away = float(np.linalg.norm(positions[_nearest(point, positions)] - np.array(point.at)))
        if away > NEAR * diameter:
            errors.append(
                InputError(
                    f"point[{number}].at", f"{point.name!r} is in the air: the nearest particle is "
                    f"{show(float(f'{away:.3g}'), 'length')} away",
                    f"Put it into the ground, which lies within {box} m.", value=list(point.at),
                )
            )  # fmt: skip
    for number, stage in enumerate(case.stages):
        place = _excavated(stage)
        if stage.kind == "excavate" and place is not None and not place(positions).any():
            key = "polygon" if "polygon" in stage.values else "centre"
            errors.append(
                InputError(
                    f"stage[{number}].{key}", "the excavation lies outside the ground: no particle is in it",
                    f"The ground lies within {box} m.",
                )
            )  # fmt: skip
    if errors:
        raise InputErrors(errors)


def _nearest(point: PointOptions, positions: Floats) -> int:
    apart = positions - np.array(point.at)
    return int(np.argmin((apart**2).sum(axis=1)))


class _Place:
    """Which positions (n, d) an excavation takes."""

    def __init__(self, stage: StageOptions) -> None:
        self.values = stage.values

    def __call__(self, positions: Floats) -> NDArray[np.bool_]:
        values = self.values
        if "polygon" in values:
            return inside_polygon(positions, np.array(values["polygon"]))
        centre = np.array(values["centre"])
        if positions.shape[1] == 2:
            return inside_circle(positions, centre, values["radius"])
        # a round hole in space runs along y
        low, high = positions.min(axis=0)[1], positions.max(axis=0)[1]
        ends = [
            np.array([centre[0], y, centre[2]]) for y in (low - values["radius"], high + values["radius"])
        ]
        return inside_cylinder(positions, ends[0], ends[1], values["radius"])


def _excavated(stage: StageOptions) -> _Place | None:
    return _Place(stage) if "polygon" in stage.values or "centre" in stage.values else None


def _where(stage: StageOptions, scene: BondedScene) -> Where:
    place = _excavated(stage)
    names = stage.values.get("material", ())
    wanted = np.zeros(scene.assembly.particles, dtype=bool)
    for name in names:
        wanted[scene.material_ids(name)] = True

    def chosen(site: Site) -> NDArray[np.bool_]:
        mask = np.ones(len(site.number), dtype=bool) if place is None else place(site.simulation.positions)
        return mask & wanted[site.number] if names else mask

    return chosen


def _openings(case: BreakingCase, positions: Floats, radii: Floats) -> dict[str, list[Wall]]:
    """Sides of which a stage takes a part away: their pieces, the parts that go named after their stages."""
    found: dict[str, list[Wall]] = {}
    cuts: dict[str, list[tuple[float, float, str]]] = {}
    reach = float((positions.max(axis=0) - positions.min(axis=0)).max())
    for number, stage in enumerate(case.stages):
        if stage.kind != "remove-wall" or "from" not in stage.values:
            continue
        side = str(stage.values["wall"])
        along = 1 if side in ("left", "right") else 0
        ends = sorted((float(stage.values["from"][along]), float(stage.values["to"][along])))
        low, high = positions.min(axis=0)[along], positions.max(axis=0)[along]
        if ends[1] <= low or ends[0] >= high or ends[0] == ends[1]:
            raise InputError(
                f"stage[{number}].from", f"the opening is not in the wall {side!r}",
                f"It reaches from {low:.4g} to {high:.4g} m along {'xy'[along]}.",
            )  # fmt: skip
        cuts.setdefault(side, []).append((ends[0], ends[1], opening_name(side, number)))
    for side, parts in cuts.items():
        axis = 0 if side in ("left", "right") else 1
        level, _ = wall_place(side, positions, radii)
        along = 1 - axis
        smooth = 0.0 if case.scene.boundary[side] == "wall" else None
        # planes have no ends: what stays reaches far beyond the ground
        edge = float(positions[:, along].min()) - reach
        pieces, at = [], 0
        for first, last, name in sorted(parts):
            if first < edge:
                raise InputError(f"stage, {name}", "two openings of a wall overlap", "Give each its own part")
            pieces += (
                [_piece(f"{side}, piece {at}", edge, first, level, axis, smooth)] if first > edge else []
            )
            pieces.append(_piece(name, first, last, level, axis, smooth))
            edge, at = last, at + 1
        pieces.append(_piece(f"{side}, piece {at}", edge, edge + 3.0 * reach, level, axis, smooth))
        found[side] = pieces
    return found


def opening_name(side: str, number: int) -> str:
    """Of the piece of a wall that stage `number` takes away."""
    return f"{side}, opening {number}"


def _piece(name: str, first: float, last: float, level: float, axis: int, friction: float | None) -> Wall:
    ends = [[level, first], [level, last]] if axis == 0 else [[first, level], [last, level]]
    return _line(name, np.array(ends), friction)


def _line(name: str, points: Floats, friction: float | None) -> Wall:
    contact = {} if friction is None else {"friction_coefficient": friction}
    return segments(name, points, contact=contact)


def criteria_of(stage: StageOptions) -> Criteria:
    """Rules of rest and failure as a stage says them."""
    usual, values = Criteria(), stage.values
    patience = float(values.get("patience", 1.0))
    return replace(
        usual,
        rest=float(values.get("rest", usual.rest)),
        failed_diameters=float(values.get("failed_diameters", usual.failed_diameters)),
        moving_share=float(values.get("moving_share", usual.moving_share)),
        steps_per_length=patience * usual.steps_per_length,
    )


def _stage(
    case: BreakingCase, one: StageOptions, scene: BondedScene, openings: dict[str, list[Wall]]
) -> Stage:
    values, criteria = one.values, criteria_of(one)
    number = case.stages.index(one)
    if one.kind == "settle":
        return Settle(one.name, float(values["factor"]), case.scene.initial_stress is None, criteria)
    if one.kind == "gravity":
        return Gravity(one.name, values["factor"], criteria)
    if one.kind == "strength":
        names = scene.assembly.material_names
        numbers = tuple(names.index(name) for name in values.get("material", ()) if name in names)
        return ChangeStrength(one.name, numbers, values["factor"], criteria)
    if one.kind == "excavate":
        return Excavate(one.name, _where(one, scene), values["shares"], values["come_to_rest"], criteria)
    if one.kind == "move-wall":
        return MoveWall(
            one.name, values["wall"], values["velocity"], values["time"], values.get("frames_every")
        )
    if one.kind == "remove-wall":
        side = values["wall"]
        if "from" in values:
            return RemoveWalls(one.name, (opening_name(side, number),))
        pieces = openings.get(side)
        return RemoveWalls(one.name, (side,) if pieces is None else tuple(wall.name for wall in pieces))
    if one.kind == "run":
        return Run(one.name, values["time"], values["until_rest"], values.get("frames_every"), criteria)
    plan = SearchPlan(
        one.kind, values["start"], values["step"], values["tolerance"], values["highest"], criteria,
        values["goes_on"],
    )  # fmt: skip
    return FindFactor(one.name, plan)
