"""A case of cutting, from its text and back; every error of the file at once."""

from __future__ import annotations

import math
from pathlib import Path

from geodem import units
from geodem.case.bonded import exact
from geodem.case.cutting import CuttingCase
from geodem.case.head import read_head
from geodem.case.scene_reading import SCENE_KEYS, read_scene, scene_head, scene_lines
from geodem.case.section import positive
from geodem.case.table import Table, quoted
from geodem.cutting.plan import DAMPING, ENTRY, FRAMES, HEIGHT, RAMP, CuttingPlan
from geodem.cutting.tool import Tool
from geodem.errors import InputError, InputErrors

KEYS = (
    "workflow", "title", "allow_implausible", "seed", "tool", "frames", "local_damping", *SCENE_KEYS,
)  # fmt: skip
TOOL_KEYS = (
    "rake", "clearance", "wear_flat", "tip_radius", "friction_angle", "height", "depth", "speed", "distance",
    "start", "ramp", "entry",
)  # fmt: skip
TOOL = 'rake = "15 deg", friction_angle = "20 deg", depth = "5 mm", speed = "3 m/s" and distance = "30 mm"'
CLEARANCE = math.radians(10.0)
STEEP = math.radians(75.0)
"""Rake beyond which a tool looks mistaken."""
MOST_FRAMES = 10_000
FAST = 50.0
"""Speed beyond which a tool looks mistaken [m/s]."""


def parse_cutting(text: str, folder: Path) -> CuttingCase:
    """Read a case of cutting from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What relative paths in it are relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another kind.
    InputErrors
        All that is wrong in it, in its order.
    """
    head = read_head(text, folder, "cutting", KEYS, example="Sandstone cut by a pick")
    top = head.top
    seed = head.seed()
    scene = read_scene(top, folder, seed=seed)
    if scene is not None and scene.source.dimension == 3:
        head.findings.error(
            "source", "a cut is a section, 2D", 'Write a box of two sides: box = ["60 mm", "30 mm"].'
        )
    plan = _plan(top)
    common = head.close()
    # every None below has been reported
    assert scene is not None
    assert plan is not None
    return CuttingCase(**common, scene=scene, plan=plan, seed=seed)


def _plan(top: Table) -> CuttingPlan | None:
    findings = top.findings
    before = len(findings.errors)
    frames = top.integer("frames", smallest=1, remedy="Write a whole number such as 20.")
    if frames is not None and frames > MOST_FRAMES:
        top.error("frames", f"so many are no use ({MOST_FRAMES:,} at most)", "Write a number such as 20.")
    if "frames" not in top:
        findings.default("frames", str(FRAMES))
    damping = top.quantity("local_damping", "dimensionless", check=_damping)
    if "local_damping" not in top:
        findings.default("local_damping", f"{DAMPING:g}")
    table = top.sub("tool", TOOL_KEYS, example=f"[tool] with {TOOL}")
    if table is None:
        if "tool" not in top:
            top.missing("tool", f"Add [tool] with {TOOL}.")
        return None
    for key in ("rake", "friction_angle", "depth", "speed", "distance"):
        if key not in table:
            table.missing(key, f"Write {TOOL}.")
    rake = table.quantity("rake", "angle")
    friction = table.quantity("friction_angle", "angle")
    clearance = table.quantity("clearance", "angle")
    if "clearance" not in table:
        clearance = CLEARANCE
        findings.default(table.at("clearance"), "10 deg")
    flat = table.quantity("wear_flat", "length", check=_not_negative)
    radius = table.quantity("tip_radius", "length", check=_not_negative)
    for key, value in (("wear_flat", flat), ("tip_radius", radius)):
        if key not in table:
            findings.default(table.at(key), "0 m", why="none" if key == "wear_flat" else "a sharp tip")
        elif value is None:
            return None
    depth = table.quantity("depth", "length", check=positive)
    speed = table.quantity("speed", "velocity", check=_forwards)
    distance = table.quantity("distance", "length", check=_forwards)
    start = table.quantity("start", "length")
    if "start" not in table:
        findings.default(table.at("start"), "where the tool just touches the ground")
    height = table.quantity("height", "length", check=positive)
    ramp = table.quantity("ramp", "length", check=_not_negative)
    entry = table.quantity("entry", "length", check=_not_negative)
    if "ramp" not in table:
        findings.default(table.at("ramp"), f"{RAMP:g} mean diameters of the particles")
    _plausible(table, rake, speed)
    if len(findings.errors) > before:
        return None
    # every None below has been reported
    assert rake is not None
    assert friction is not None
    assert clearance is not None
    assert depth is not None
    assert speed is not None
    assert distance is not None
    if "height" not in table:
        height = HEIGHT * depth
        findings.default(table.at("height"), units.show(height, "length"), why=f"{HEIGHT:g} times the depth")
    if "entry" not in table:
        entry = ENTRY * depth
        findings.default(
            table.at("entry"), units.show(entry, "length"), why=f"means are taken after {ENTRY:g} depths"
        )
    plan = CuttingPlan(
        Tool(rake, clearance, height or 0.0, friction, flat or 0.0, radius or 0.0), depth, speed, distance,
        start=start, ramp=ramp, entry=entry, damping=DAMPING if damping is None else damping,
        frames=frames or FRAMES,
    )  # fmt: skip
    try:
        plan.check()
    except InputErrors as errors:
        for error in errors.errors:
            findings.errors.append(at_key(error))
        return None
    except InputError as error:
        findings.errors.append(at_key(error))
        return None
    return plan


def at_key(error: InputError) -> InputError:
    """The same error at its key of the case: "tool, rake" is tool.rake; lengths and speeds with their units."""
    place, value = error.place.replace("tool, ", "tool."), error.value
    key = place.removeprefix("tool.")
    if key in TOOL_KEYS and isinstance(value, float):
        value = units.show(value, "velocity" if key == "speed" else "length")
    return InputError(place, error.problem, error.remedy, value=value)


def _plausible(table: Table, rake: float | None, speed: float | None) -> None:
    if rake is not None and abs(rake) > STEEP and abs(rake) < 0.5 * math.pi:
        table.findings.implausible(
            table.at("rake"),
            "no tool is as slanted as this",
            'Write rake = "15 deg".',
            value=units.show(rake, "angle"),
        )
    if speed is not None and speed > FAST:
        table.findings.implausible(
            table.at("speed"), "rock is not cut as fast as this", 'Write speed = "3 m/s".',
            value=units.show(speed, "velocity"),
        )  # fmt: skip


def _forwards(value: float) -> tuple[str, str] | None:
    if value > 0.0:
        return None
    if value < 0.0:
        return "the tool would move away from the ground", "It moves along +x: give more than 0."
    return "the tool would not move", "Give more than 0."


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Give 0 or more.")


def _damping(value: float) -> tuple[str, str] | None:
    return None if 0.0 <= value < 1.0 else ("this is no local damping", "Give 0 to below 1.")


def cutting_text(case: CuttingCase) -> str:
    """The case as it is run, as TOML."""
    plan, tool = case.plan, case.plan.tool
    lines = ['workflow = "cutting"', f"title = {quoted(case.title)}", f"seed = {case.seed}"]
    if case.allow_implausible:
        lines.append(f"allow_implausible = [{', '.join(map(quoted, case.allow_implausible))}]")
    lines += [f"frames = {plan.frames}", f"local_damping = {plan.damping!r}", *scene_head(case.scene)]
    lengths = {
        "wear_flat": tool.wear_flat, "tip_radius": tool.tip_radius, "height": tool.height, "depth": plan.depth,
        "distance": plan.distance, "start": plan.start, "ramp": plan.ramp, "entry": plan.entry,
    }  # fmt: skip
    angles = {"rake": tool.rake, "clearance": tool.clearance, "friction_angle": tool.friction_angle}
    lines += ["", "[tool]", *(f"{key} = {exact(value, 'angle')}" for key, value in angles.items())]
    lines += [f"{key} = {exact(value, 'length')}" for key, value in lengths.items() if value is not None]
    lines += [f"speed = {exact(plan.speed, 'velocity')}", *scene_lines(case.scene)]
    return "\n".join(lines) + "\n"
