"""A case of breaking ground, back to TOML."""

from __future__ import annotations

from geodem.case.breaking import BreakingCase
from geodem.case.breaking_stages import point_text, stage_lines
from geodem.case.scene_reading import scene_head, scene_lines
from geodem.case.table import quoted


def breaking_text(case: BreakingCase) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [f"workflow = {quoted(case.workflow)}", f"title = {quoted(case.title)}", f"seed = {case.seed}"]
    if case.allow_implausible:
        lines.append(f"allow_implausible = [{', '.join(map(quoted, case.allow_implausible))}]")
    lines += [*scene_head(case.scene), *scene_lines(case.scene)]
    lines += ["", "[motion]", f"damping = {case.damping!r}", f"time_step_factor = {case.time_step_factor!r}"]
    for point in case.points:
        lines += ["", "[[point]]", f"name = {quoted(point.name)}", f"at = {point_text(point.at)}"]
    for wall in case.walls:
        lines += ["", "[[wall]]", f"name = {quoted(wall.name)}"]
        lines.append(f"points = [{', '.join(map(point_text, wall.points))}]")
        if wall.friction is not None:
            lines.append(f"friction = {wall.friction!r}")
    for stage in case.stages:
        lines += ["", *stage_lines(stage)]
    return "\n".join(lines) + "\n"
