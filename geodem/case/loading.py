"""What holds and what loads the ground of a case: supports, pseudo-static acceleration, surcharges."""

from __future__ import annotations

from geodem import units
from geodem.case.data import SUPPORTS, Boundary, Loads, Point, SectionOptions, Surcharge
from geodem.case.section import Coordinates, bounds_text
from geodem.case.table import Table

_SIDES = ("left", "right", "bottom", "top")


def read_boundary(top: Table) -> Boundary:
    """The supports; whether they hold the ground is judged here."""
    example = '[boundary] with bottom = "fixed", left = "roller", right = "roller"'
    if "boundary" not in top:
        top.missing("boundary", f"Nothing holds the ground. Add {example}.")
        return Boundary()
    table = top.sub("boundary", _SIDES, example=example)
    if table is None:
        return Boundary()
    before = len(top.findings.errors)
    sides = {side: table.choice(side, SUPPORTS, default="free") or "free" for side in _SIDES}
    boundary = Boundary(**sides)
    if len(top.findings.errors) > before:
        return boundary
    if boundary.bottom == "free":
        top.findings.error(
            "boundary.bottom", "nothing carries the weight: the bottom is free", 'Write bottom = "fixed".'
        )
    sideways = (
        boundary.left != "free" or boundary.right != "free" or "fixed" in (boundary.bottom, boundary.top)
    )
    if not sideways:
        problem = "nothing holds the ground sideways: left and right are free and no side is fixed"
        top.findings.error(
            "boundary", problem, 'Write bottom = "fixed", or left = "roller" and right = "roller".'
        )
    if boundary.top != "free":
        problem = "the ground's surface is held"
        top.findings.implausible(
            "boundary.top", problem, "The surface of a slope is free: remove it.", value=boundary.top
        )
    return boundary


def read_loads(top: Table, coordinates: Coordinates, section: SectionOptions | None) -> Loads:
    """The loads; `section` (where it could be read) tells whether they lie on it."""
    table = top.sub("loads", ("horizontal_acceleration", "surcharge"), example="[loads]")
    findings = top.findings
    if table is None:
        findings.default("loads", "none", why="the ground bears its own weight")
        return Loads()
    if "horizontal_acceleration" not in table:
        findings.default("loads.horizontal_acceleration", '"0 g"')
    acceleration = table.quantity("horizontal_acceleration", "acceleration") or 0.0
    if abs(acceleration) > units.GRAVITY:
        problem = "this is more than the weight itself"
        value = table.content["horizontal_acceleration"]
        findings.implausible(
            "loads.horizontal_acceleration", problem, 'Earthquakes: "0.05 g" to "0.4 g".', value=value
        )
    elif acceleration < 0.0:
        findings.questions.append(
            "loads.horizontal_acceleration is negative: it presses into the slope and holds it."
        )
    return Loads(horizontal_acceleration=acceleration, surcharge=read_surcharges(table, coordinates, section))


def read_surcharges(
    table: Table, coordinates: Coordinates, section: SectionOptions | None
) -> tuple[Surcharge, ...]:
    """The key surcharge of a table of loads."""
    surcharges = []
    example = '{from = [0, 10], to = [5, 10], pressure = "20 kPa"}'
    for row in table.rows("surcharge", ("from", "to", "pressure"), example=example):
        surcharge = _surcharge(row, coordinates, section, example)
        if surcharge is not None:
            surcharges.append(surcharge)
    return tuple(surcharges)


def _surcharge(
    row: Table, coordinates: Coordinates, section: SectionOptions | None, example: str
) -> Surcharge | None:
    ends: list[Point] = []
    for key in ("from", "to"):
        if key not in row:
            row.missing(key, f"Write {example}.")
            continue
        point = coordinates.point(row.findings, row.at(key), row.content[key])
        if point is None:
            continue
        ends.append(point)
        if section is not None:
            left, bottom, right, top = section.bounds
            slack = 1e-9 * (right - left + top - bottom)
            if not (left - slack <= point[0] <= right + slack and bottom - slack <= point[1] <= top + slack):
                row.error(
                    key,
                    f"this point lies outside the section ({bounds_text(section)})",
                    "Move it onto the surface.",
                )
    pressure = row.quantity("pressure", "stress")
    if "pressure" not in row:
        row.missing("pressure", f"Write {example}.")
    if pressure is not None and pressure < 0.0:
        remedy = "A surcharge presses onto the ground: give it without the sign."
        row.findings.implausible(
            row.at("pressure"), "this pulls at the ground", remedy, value=row.content["pressure"]
        )
    elif pressure is not None and pressure > 1e8:
        remedy = f'Did you mean "{units.show(pressure / 1e3, "stress")}"?'
        row.findings.implausible(
            row.at("pressure"), "no foundation presses so hard", remedy, value=row.content["pressure"]
        )
    if len(ends) < 2 or pressure is None:
        return None
    if ends[0] == ends[1]:
        row.findings.error(
            row.place, "from and to are the same point", "Give the two ends of the loaded stretch."
        )
        return None
    return Surcharge(ends[0], ends[1], pressure)
