"""Bolts, linings, sides, gravity and initial stress of a case."""

from __future__ import annotations

import math

from geodem import units
from geodem.breaking.supports import SIDES, SUPPORTS
from geodem.case.bonded import exact
from geodem.case.places import Places
from geodem.case.scene import BoltOptions, LiningOptions, StressOptions
from geodem.case.scene_joints import point_text
from geodem.case.section import positive
from geodem.case.table import Table, quoted
from geodem.case.tunnel_supports import BOLT_DIAMETER, LINING_THICKNESS, judge_size

ALL_SIDES = SIDES[3]
DEFAULTS = {"bottom": "fixed", "top": "free"}
"""Of sides; the others are rollers."""
BOLT_KEYS = (
    "name", "from", "to", "step", "count", "diameter", "young_modulus", "yield_strength", "axial_stiffness",
    "yield_force", "elongation", "pretension", "density_per_length", "grout_stiffness", "grout_strength", "plate",
    "out_of_plane",
)  # fmt: skip
MOST_BOLTS = 10_000
"""Of a row."""
BOLT_EXAMPLE = 'from = [0, 5], to = [0, 1], diameter = "25 mm", grout_stiffness = "100 MPa"'
LINING_KEYS = ("name", "points", "closed", "centre", "radius", "thickness", "young_modulus", "density")
LINING_EXAMPLE = 'centre = [0, 0], radius = "2.8 m", thickness = "0.2 m", young_modulus = "20 GPa"'
COMPONENTS = ("x", "y", "z", "xy", "xz", "yz")
STRESS_KEYS = ("k0", "unit_weight", "surface", *COMPONENTS)
_STRESS = '[initial_stress] with k0 = 0.6, or x = "10 MPa" and y = "5 MPa"'
STEEL = 7850.0
"""[kg/m3]"""
STRONGEST = 5000.0
"""Gravity that is plausible [m/s2]."""
STEEL_MODULUS = 200e9
"""[Pa]"""


def read_sides(top: Table, dimension: int | None) -> dict[str, str]:
    """Support by side; what is left out is told. Front and back are there in 3D alone."""
    sides = ALL_SIDES if dimension is None else SIDES[dimension]
    example = '[boundary] with bottom = "fixed", left = "roller", right = "roller"'
    table = top.sub("boundary", sides, example=example)
    if table is None:
        table = Table(top.findings, "boundary", {}, sides)
    found: dict[str, str] = {}
    for name in sides:
        usual = DEFAULTS.get(name, "roller")
        if name in table:
            found[name] = table.choice(name, SUPPORTS) or usual
        else:
            found[name] = usual
            if dimension is not None or name not in ("front", "back"):
                top.findings.default(table.at(name), quoted(usual))
    return found


def read_gravity(top: Table, places: Places) -> tuple[float, ...] | float:
    """A vector, or the value of gravity downwards [m/s2]."""
    usual = units.GRAVITY
    table = top.sub("loads", ("gravity",), example='[loads] with gravity = "9.81 m/s2"')
    if table is None or "gravity" not in table:
        top.findings.default("loads.gravity", units.show(usual, "acceleration"), why="downwards")
        return usual
    value = table.content["gravity"]
    if not isinstance(value, list):
        found = table.quantity("gravity", "acceleration", check=_not_negative)
        _judge_gravity(table, found or 0.0)
        return usual if found is None else found
    sizes = (2, 3) if places.dimension is None else (places.dimension,)
    if len(value) not in sizes:
        table.error("gravity", "it has another number of components", 'Write ["0 m/s2", "-9.81 m/s2"].')
        return usual
    keys = tuple(map(str, range(len(value))))
    inner = Table(table.findings, table.at("gravity"), dict(zip(keys, value, strict=True)), keys)
    vector = tuple(inner.quantity(key, "acceleration") or 0.0 for key in keys)
    _judge_gravity(table, math.hypot(*vector))
    return vector


def _judge_gravity(table: Table, value: float) -> None:
    if value > STRONGEST:
        remedy = f"A centrifuge reaches {units.show(STRONGEST, 'acceleration')}: check the unit."
        table.findings.implausible(table.at("gravity"), "no ground is as heavy as this", remedy)


def read_bolts(top: Table, places: Places) -> tuple[BoltOptions, ...]:
    """The tables [[bolt]]."""
    found = []
    for number, row in enumerate(top.rows("bolt", BOLT_KEYS, example=f"{{{BOLT_EXAMPLE}}}")):
        before = len(row.findings.errors)
        name = row.text("name", remedy='Write name = "roof bolts".') or f"bolt {number + 1}"
        for key in ("from", "to", "grout_stiffness"):
            if key not in row:
                row.missing(key, f"Write {BOLT_EXAMPLE}.")
        head, end, step = (places.point(row, key) for key in ("from", "to", "step"))
        count = row.integer("count", smallest=1, remedy="Write a whole number such as 5.") or 1
        if count > MOST_BOLTS:
            row.error(
                "count", f"no row has so many bolts ({MOST_BOLTS:,} at most)", "Write how many there are."
            )
        if count > 1 and "step" not in row:
            row.missing("step", "Write step = [1.5, 0], the way from one bolt to the next.")
        if head is not None and head == end:
            row.error("to", "it ends where it begins", "Give two ends.")
        steel = _steel(row)
        grout = row.quantity("grout_stiffness", "stress", check=positive)
        strength = row.quantity("grout_strength", "line_load", check=positive)
        if "grout_strength" not in row:
            row.findings.default(row.at("grout_strength"), "unlimited", why="the grout does not slip")
        apart = row.quantity("out_of_plane", "length", check=positive)
        if "out_of_plane" not in row and places.dimension == 2:
            row.findings.default(row.at("out_of_plane"), "1 m", why="one bolt a metre out of the plane")
        plate = row.content.get("plate", False)
        if not isinstance(plate, bool):
            row.error("plate", "true or false is needed here", "Write plate = true.")
        if head is None or end is None or grout is None or len(row.findings.errors) > before:
            continue
        found.append(
            BoltOptions(
                name, head, end, grout_stiffness=grout, step=step, count=count, out_of_plane=apart or 1.0,
                grout_strength=strength or math.inf, plate=bool(plate), **steel,
            )
        )  # fmt: skip
    return tuple(found)


def _steel(row: Table) -> dict[str, float]:
    """EA, yield force and mass of a bar, given by themselves or by its diameter and steel."""
    diameter = row.quantity("diameter", "length", check=positive)
    judge_size(row, "diameter", diameter, BOLT_DIAMETER, "no bolt is as thick or thin as this")
    area = None if diameter is None else 0.25 * math.pi * diameter**2
    modulus = row.quantity("young_modulus", "stress", check=positive)
    stress = row.quantity("yield_strength", "stress", check=positive)
    stiffness = row.quantity("axial_stiffness", "force", check=positive)
    force = row.quantity("yield_force", "force", check=positive)
    heavy = row.quantity("density_per_length", "unit_mass", check=positive)
    if ("diameter" in row) == ("axial_stiffness" in row):
        problem = "both are given" if "diameter" in row else "nothing says how stiff it is"
        row.findings.error(row.place, problem, 'Give diameter = "25 mm", or axial_stiffness = "98 MN".')
    if area is not None:
        if "young_modulus" not in row:
            row.findings.default(row.at("young_modulus"), "200 GPa", why="steel")
        stiffness = area * (modulus or STEEL_MODULUS)
        heavy = area * STEEL if heavy is None else heavy
        force = area * stress if stress is not None else force
    elif "yield_strength" in row:
        row.error("yield_strength", "it goes with the diameter", 'Give yield_force = "200 kN".')
    if "yield_strength" not in row and "yield_force" not in row:
        row.findings.default(row.at("yield_force"), "unlimited", why="it does not yield")
    elongation = row.quantity("elongation", "dimensionless", check=positive)
    return {
        "axial_stiffness": stiffness or 0.0,
        "yield_force": math.inf if force is None else force,
        "pretension": row.quantity("pretension", "force", check=_not_negative) or 0.0,
        "elongation": math.inf if elongation is None else elongation,
        "density_per_length": 4.0 if heavy is None else heavy,
    }


def read_linings(top: Table, places: Places) -> tuple[LiningOptions, ...]:
    """The tables [[lining]]."""
    found = []
    for number, row in enumerate(top.rows("lining", LINING_KEYS, example=f"{{{LINING_EXAMPLE}}}")):
        before = len(row.findings.errors)
        name = row.text("name", remedy='Write name = "shotcrete".') or f"lining {number + 1}"
        if places.dimension == 3:
            row.findings.error(row.place, "linings are there in 2D alone", "Remove it.")
        for key in ("thickness", "young_modulus"):
            if key not in row:
                row.missing(key, f"Write {LINING_EXAMPLE}.")
        thickness = row.quantity("thickness", "length", check=positive)
        judge_size(row, "thickness", thickness, LINING_THICKNESS, "no lining is as thick or thin as this")
        modulus = row.quantity("young_modulus", "stress", check=positive)
        density = row.quantity("density", "density", check=positive)
        if "density" not in row:
            row.findings.default(row.at("density"), "2500 kg/m3", why="concrete")
        points = places.points(row, "points")
        centre, radius = places.point(row, "centre"), row.quantity("radius", "length", check=positive)
        if ("points" in row) == ("centre" in row) or ("centre" in row) != ("radius" in row):
            row.findings.error(row.place, "its line is not clear", f"Give points, or as in {LINING_EXAMPLE}.")
        closed = row.content.get("closed", "centre" in row)
        if not isinstance(closed, bool):
            row.error("closed", "true or false is needed here", "Write closed = true.")
        if thickness is None or modulus is None or len(row.findings.errors) > before:
            continue
        found.append(
            LiningOptions(name, thickness, modulus, density or 2500.0, points, bool(closed), centre, radius)
        )
    return tuple(found)


def read_stress(top: Table, dimension: int | None) -> StressOptions | None:
    """The table [initial_stress]."""
    table = top.sub("initial_stress", STRESS_KEYS, example=_STRESS)
    if table is None:
        return None
    components = {key: value for key in COMPONENTS if (value := table.quantity(key, "stress")) is not None}
    flat = [key for key in components if "z" in key and dimension == 2]
    for key in flat:
        table.error(key, "the ground is 2D", f"Remove {key}.")
    if ("k0" in table) == any(key in table for key in COMPONENTS):
        both = "k0 and components are both given" if "k0" in table else "nothing says what the stress is"
        table.findings.error("initial_stress", both, f"Write {_STRESS}; pressure is positive.")
        return None
    if "k0" not in table:
        for key in ("unit_weight", "surface"):
            if key in table:
                table.error(key, "this goes with k0", f"Remove {key}.")
        for key in ("x", "y", "z")[: dimension or 2]:
            if key not in table:
                table.missing(key, f"Write {_STRESS}.")
        return StressOptions(components=components)
    given = table.content["k0"]
    entries = given if isinstance(given, list) else [given]
    keys = tuple(map(str, range(len(entries))))
    inner = Table(table.findings, table.at("k0"), dict(zip(keys, entries, strict=True)), keys)
    values = [inner.quantity(key, "dimensionless", check=_not_negative) for key in keys]
    if len(values) not in (1, (dimension or 3) - 1):
        table.error("k0", "one number is needed, or two in 3D: along x and along y", "Write k0 = 0.6.")
    for key, why in (("unit_weight", "that of the ground"), ("surface", "the top of the ground")):
        if key not in table:
            table.findings.default(table.at(key), why)
    return StressOptions(
        tuple(value for value in values if value is not None),
        table.quantity("unit_weight", "unit_weight", check=positive),
        table.quantity("surface", "length"),
    )


def bolt_lines(one: BoltOptions) -> list[str]:
    """The table of bolts."""
    lines = [
        "[[bolt]]", f"name = {quoted(one.name)}", f"from = {point_text(one.head)}", f"to = {point_text(one.end)}",
        f"count = {one.count}", f"axial_stiffness = {exact(one.axial_stiffness, 'force')}",
        f"pretension = {exact(one.pretension, 'force')}",
        f"density_per_length = {exact(one.density_per_length, 'unit_mass')}",
        f"grout_stiffness = {exact(one.grout_stiffness, 'stress')}", f"plate = {str(one.plate).lower()}",
        f"out_of_plane = {exact(one.out_of_plane, 'length')}",
    ]  # fmt: skip
    if one.step is not None:
        lines.append(f"step = {point_text(one.step)}")
    limits = {"yield_force": "force", "grout_strength": "line_load", "elongation": "dimensionless"}
    for key, dimension in limits.items():
        value = getattr(one, key)
        if not math.isinf(value):
            lines.append(
                f"{key} = {repr(value) if dimension == 'dimensionless' else exact(value, dimension)}"
            )
    return lines


def lining_lines(one: LiningOptions) -> list[str]:
    """The table of a lining."""
    lines = ["[[lining]]", f"name = {quoted(one.name)}"]
    if one.centre is not None and one.radius is not None:
        lines += [f"centre = {point_text(one.centre)}", f"radius = {exact(one.radius, 'length')}"]
    else:
        lines.append(f"points = [{', '.join(map(point_text, one.points))}]")
    return [
        *lines, f"closed = {str(one.closed).lower()}", f"thickness = {exact(one.thickness, 'length')}",
        f"young_modulus = {exact(one.young_modulus, 'stress')}", f"density = {exact(one.density, 'density')}",
    ]  # fmt: skip


def stress_lines(one: StressOptions) -> list[str]:
    """The table of the initial stress."""
    lines = ["[initial_stress]"]
    lines += [f"{key} = {exact(value, 'stress')}" for key, value in one.components.items()]
    if one.k0:
        lines.append(f"k0 = {one.k0[0]!r}" if len(one.k0) == 1 else f"k0 = {list(one.k0)!r}")
    if one.unit_weight is not None:
        lines.append(f"unit_weight = {exact(one.unit_weight, 'unit_weight')}")
    if one.surface is not None:
        lines.append(f"surface = {exact(one.surface, 'length')}")
    return lines


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Give 0 or more.")
