"""Joints, sets of joints and faults of a case."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from geodem.case.bonded import exact
from geodem.case.places import Places
from geodem.case.scene import FacePlace, FaultOptions, JointOptions, JointSetOptions, Place
from geodem.case.section import positive
from geodem.case.table import Table, quoted
from geodem.laws.joint import smooth_joint

PARAMETERS = {
    "normal_stiffness": "joint_stiffness",
    "shear_stiffness": "joint_stiffness",
    "cohesion": "stress",
    "tensile_strength": "stress",
    "residual_cohesion": "stress",
}
ANGLES = {"friction_angle": "friction_coefficient", "dilation_angle": "dilation_coefficient"}
PROPERTIES = (*PARAMETERS, *ANGLES)
PLACE = ("points", "centre", "radius", "angle", "dip", "dip_direction")
JOINT_EXAMPLE = 'points = [[0, 2], [10, 5]], friction_angle = "30 deg", normal_stiffness = "10 GPa/m"'
SET_EXAMPLE = 'angle = "35 deg", spacing = "2 m", friction_angle = "30 deg", normal_stiffness = "10 GPa/m"'
FAULT_EXAMPLE = 'material = "gouge", thickness = "1 m", points = [[0, 2], [10, 5]]'
_OF_SET = (
    "name", "angle", "dip", "dip_direction", "spacing", "trace", "gap", "persistence", "origin", "seed",
    "angle_scatter", "spacing_scatter", "trace_scatter",
)  # fmt: skip


def read_joints(top: Table, places: Places) -> tuple[JointOptions, ...]:
    """The tables [[joint]]."""
    found = []
    for number, row in enumerate(
        top.rows("joint", ("name", *PLACE, *PROPERTIES), example=f"{{{JOINT_EXAMPLE}}}")
    ):
        name = row.text("name", remedy='Write name = "fault".') or f"joint {number + 1}"
        where = read_place(row, places, JOINT_EXAMPLE)
        parameters = _parameters(row, JOINT_EXAMPLE)
        if where is not None and parameters is not None:
            found.append(JointOptions(name, where, parameters))
    return tuple(found)


def read_joint_sets(top: Table, places: Places) -> tuple[JointSetOptions, ...]:
    """The tables [[joint_set]]."""
    found = []
    for number, row in enumerate(
        top.rows("joint_set", (*_OF_SET, *PROPERTIES), example=f"{{{SET_EXAMPLE}}}")
    ):
        before = len(row.findings.errors)
        name = row.text("name", remedy='Write name = "bedding".') or f"joint set {number + 1}"
        parameters = _parameters(row, SET_EXAMPLE)
        flat = places.dimension == 2
        angle, dip, towards = _direction(row, flat, SET_EXAMPLE)
        spacing = row.quantity("spacing", "length", check=positive)
        if "spacing" not in row:
            row.missing("spacing", f"Write {SET_EXAMPLE}.")
        trace, gap = _trace(row)
        seed = row.integer("seed", smallest=0, remedy="Write a whole number such as 1.")
        scatters = {
            "angle_scatter": row.quantity("angle_scatter", "angle", check=_not_negative),
            "spacing_scatter": row.quantity("spacing_scatter", "dimensionless", check=_half),
            "trace_scatter": row.quantity("trace_scatter", "dimensionless", check=_below_one),
        }
        origin = places.point(row, "origin")
        if seed is None and "seed" not in row:
            row.findings.default(row.at("seed"), "1")
        if parameters is None or spacing is None or len(row.findings.errors) > before:
            continue
        found.append(
            JointSetOptions(
                name, spacing, parameters, trace=trace, gap=gap, origin=origin, seed=1 if seed is None else seed,
                angle=angle, dip=dip, dip_direction=towards,
                **{key: value or 0.0 for key, value in scatters.items()},
            )
        )  # fmt: skip
    return tuple(found)


def read_faults(top: Table, places: Places) -> tuple[FaultOptions, ...]:
    """The tables [[fault]]."""
    found = []
    for row in top.rows("fault", ("material", "thickness", *PLACE), example=f"{{{FAULT_EXAMPLE}}}"):
        for key in ("material", "thickness"):
            if key not in row:
                row.missing(key, f"Write {FAULT_EXAMPLE}.")
        material = row.text("material", remedy="Name a material.")
        thickness = row.quantity("thickness", "length", check=positive)
        where = read_place(row, places, FAULT_EXAMPLE)
        if material is not None and thickness is not None and where is not None:
            found.append(FaultOptions(material, thickness, where))
    return tuple(found)


def read_place(row: Table, places: Places, example: str) -> FacePlace | None:
    """Where a joint runs: points, or a centre with its direction; None where that is wrong, which has been told."""
    before = len(row.findings.errors)
    if ("points" in row) == ("centre" in row):
        problem = "points and centre are both given" if "points" in row else "nothing says where it runs"
        row.findings.error(row.place, problem, f"Write {example}, or centre with angle (2D) or dip (3D).")
        return None
    if "points" in row:
        for key in PLACE[1:]:
            if key in row:
                row.error(key, "points say it already", f"Remove {key}.")
        if places.dimension == 3:
            row.error("points", "a line makes no face in 3D", "Give centre, dip, dip_direction and radius.")
        points = places.points(row, "points")
        if any(a == b for a, b in itertools.pairwise(points)):
            row.error("points", "two that follow each other are the same", "Leave one out.")
        return FacePlace(points=points) if len(row.findings.errors) == before else None
    centre = places.point(row, "centre")
    radius = row.quantity("radius", "length", check=positive)
    if "radius" not in row:
        row.findings.default(row.at("radius"), "none", why="it runs through the whole ground")
    angle, dip, towards = _direction(
        row, places.dimension == 2 or (centre is not None and len(centre) == 2), example
    )
    if centre is None or len(row.findings.errors) > before:
        return None
    size = math.inf if radius is None else radius
    return FacePlace(centre=centre, radius=size, angle=angle, dip=dip, dip_direction=towards)


def _direction(row: Table, flat: bool, example: str) -> tuple[float | None, float | None, float | None]:
    """Angle in 2D, dip and dip direction in 3D [rad]."""
    angle = row.quantity("angle", "angle")
    dip, towards = row.quantity("dip", "angle", check=_dip), row.quantity("dip_direction", "angle")
    if flat:
        for key in ("dip", "dip_direction"):
            if key in row:
                row.error(
                    key, "this is the ground's section, 2D", 'Write angle = "35 deg", above the x axis.'
                )
        if "angle" not in row:
            row.missing("angle", f"Write {example}.")
    elif "angle" in row and "dip" not in row:
        return angle, None, None
    else:
        for key in ("dip", "dip_direction"):
            if key not in row:
                row.missing(
                    key, 'Write dip = "40 deg" and dip_direction = "120 deg", clockwise from north (y).'
                )
    return (angle, None, None) if flat else (None, dip, towards)


def _trace(row: Table) -> tuple[float, float]:
    """Length of traces and of the bridges between them [m]."""
    trace, gap = (
        row.quantity("trace", "length", check=positive),
        row.quantity("gap", "length", check=_not_negative),
    )
    share = row.quantity("persistence", "dimensionless", check=_persistence)
    if "trace" not in row:
        for key in ("gap", "persistence", "trace_scatter"):
            if key in row and not (key == "persistence" and share == 1.0):
                row.error(key, "it goes with the length of the traces", 'Write trace = "5 m" as well.')
        row.findings.default(row.at("trace"), "none", why="joints run through the whole ground")
        return math.inf, 0.0
    if "gap" in row and "persistence" in row:
        row.error(
            "persistence",
            "gap and persistence are both given",
            "Keep one: persistence = trace/(trace + gap).",
        )
    if trace is None:
        return math.inf, 0.0
    if share is not None:
        return trace, trace * (1.0 / share - 1.0)
    if "gap" not in row and "persistence" not in row:
        row.missing("gap", 'Write gap = "1 m", or persistence = 0.8.')
    return trace, gap or 0.0


def _parameters(row: Table, example: str) -> dict[str, float] | None:
    before = len(row.findings.errors)
    found: dict[str, float] = {}
    for key, dimension in PARAMETERS.items():
        value = row.quantity(key, dimension, check=_not_negative)
        if value is not None:
            found[key] = value
    for key in ANGLES:
        value = row.quantity(key, "angle", check=_friction)
        if value is not None:
            found[key] = value
    for key in ("normal_stiffness", "friction_angle"):
        if key not in row:
            row.missing(key, f"Write {example}.")
    if "shear_stiffness" not in row and "normal_stiffness" in found:
        found["shear_stiffness"] = found["normal_stiffness"]
        row.findings.default(row.at("shear_stiffness"), "the normal one")
    if len(row.findings.errors) > before:
        return None
    for fault in smooth_joint.check(smooth_joint.PARAMETERS(**law_parameters(found))):
        row.findings.error(row.at(fault.field), fault.problem, f"{fault.remedy}.")
    return (
        {key: found[key] for key in PROPERTIES if key in found}
        if len(row.findings.errors) == before
        else None
    )


def law_parameters(given: Mapping[str, float]) -> dict[str, float]:
    """Parameters of the law `smooth_joint` from those of a case: angles become their tangents."""
    return {ANGLES.get(key, key): math.tan(value) if key in ANGLES else value for key, value in given.items()}


def joint_lines(one: JointOptions) -> list[str]:
    """The table of a joint."""
    return [
        "[[joint]]",
        f"name = {quoted(one.name)}",
        *place_lines(one.place),
        *_parameter_lines(one.parameters),
    ]


def set_lines(one: JointSetOptions) -> list[str]:
    """The table of a set."""
    lines = [
        "[[joint_set]]",
        f"name = {quoted(one.name)}",
        *_direction_lines(one.angle, one.dip, one.dip_direction),
    ]
    lines.append(f"spacing = {exact(one.spacing, 'length')}")
    if not math.isinf(one.trace):
        lines += [f"trace = {exact(one.trace, 'length')}", f"gap = {exact(one.gap, 'length')}"]
    if one.origin is not None:
        lines.append(f"origin = {point_text(one.origin)}")
    lines.append(f"seed = {one.seed}")
    if one.angle_scatter:
        lines.append(f"angle_scatter = {exact(one.angle_scatter, 'angle')}")
    lines += [
        f"{key} = {getattr(one, key)!r}" for key in ("spacing_scatter", "trace_scatter") if getattr(one, key)
    ]
    return lines + _parameter_lines(one.parameters)


def fault_lines(one: FaultOptions) -> list[str]:
    """The table of a fault."""
    return [
        "[[fault]]", f"material = {quoted(one.material)}", f"thickness = {exact(one.thickness, 'length')}",
        *place_lines(one.place),
    ]  # fmt: skip


def place_lines(place: FacePlace) -> list[str]:
    """Keys of a place."""
    if place.points:
        return [f"points = [{', '.join(map(point_text, place.points))}]"]
    assert place.centre is not None
    lines = [f"centre = {point_text(place.centre)}"]
    lines += _direction_lines(place.angle, place.dip, place.dip_direction)
    return lines if math.isinf(place.radius) else [*lines, f"radius = {exact(place.radius, 'length')}"]


def _direction_lines(angle: float | None, dip: float | None, towards: float | None) -> list[str]:
    given = {"angle": angle, "dip": dip, "dip_direction": towards}
    return [f"{key} = {exact(value, 'angle')}" for key, value in given.items() if value is not None]


def _parameter_lines(parameters: Mapping[str, float]) -> list[str]:
    dimensions = PARAMETERS | dict.fromkeys(ANGLES, "angle")
    return [f"{key} = {exact(value, dimensions[key])}" for key, value in parameters.items()]


def point_text(point: Place) -> str:
    """A point in metres."""
    return f"[{', '.join(repr(x) for x in point)}]"


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Give 0 or more.")


def _half(value: float) -> tuple[str, str] | None:
    return (
        None
        if 0.0 <= value <= 0.5
        else ("joints would swap places", "Give 0 to 0.5, a share of the spacing.")
    )


def _below_one(value: float) -> tuple[str, str] | None:
    return None if 0.0 <= value <= 0.95 else ("this is out of range", "Give 0 to 0.95, a share of the trace.")


def _dip(value: float) -> tuple[str, str] | None:
    return None if 0.0 <= value <= 0.5 * math.pi else ("this is no dip", 'Give "0 deg" to "90 deg".')


def _friction(value: float) -> tuple[str, str] | None:
    return (
        None if 0.0 <= value < 0.5 * math.pi else ("this is no friction angle", 'Give "0 deg" to "89 deg".')
    )


def _persistence(value: float) -> tuple[str, str] | None:
    return None if 0.0 < value <= 1.0 else ("persistence lies between 0 and 1", "Write 0.8.")
