"""The tables [[stage]] of a case of breaking ground: one list of keys for each kind, read and written alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from geodem.breaking.criteria import Criteria
from geodem.breaking.search import SearchPlan
from geodem.case.bonded import exact
from geodem.case.breaking import StageOptions
from geodem.case.places import Places
from geodem.case.section import positive
from geodem.case.table import Table, quoted

REST = ("rest", "patience")
SEARCH = (
    "start", "step", "tolerance", "highest", "failed_diameters", "moving_share", "goes_on", *REST,
)  # fmt: skip
STAGES: Mapping[str, tuple[str, ...]] = {
    "settle": ("factor", *REST),
    "gravity": ("factor", *REST),
    "strength": ("material", "factor", *REST),
    "excavate": ("polygon", "centre", "radius", "material", "shares", "come_to_rest", *REST),
    "move-wall": ("wall", "velocity", "time", "frames_every"),
    "remove-wall": ("wall", "from", "to"),
    "run": ("time", "until_rest", "frames_every", "rest"),
    "gravity-increase": SEARCH,
    "strength-reduction": SEARCH,
}
"""Kinds of stages and their keys, beside kind and name."""

MOST = 10_000
"""Frames of a stage, and steps in which forces go to nothing."""
EXAMPLE = '{kind = "settle"}'
_NEEDED = {
    "gravity": ("factor",),
    "strength": ("factor",),
    "move-wall": ("wall", "velocity", "time"),
    "remove-wall": ("wall",),
    "run": ("time",),
}
_ALL_KEYS = ("kind", "name", *dict.fromkeys(key for keys in STAGES.values() for key in keys))
_AFTER_SETTLING = ("gravity", "strength", "excavate", "gravity-increase", "strength-reduction")
_USUAL_PLAN, _USUAL = SearchPlan("gravity-increase"), Criteria()


class _Key(NamedTuple):
    """How a key is read, written, and what it is where it is left out (None: nothing)."""

    read: Callable[[Table, str, Places], Any]
    write: Callable[[Any], str]
    usual: Any = None
    example: str = ""


def read_stages(top: Table, places: Places, *, stressed: bool) -> tuple[StageOptions, ...]:
    """The stages in their order.

    Parameters
    ----------
    top : Table
    places : Places
    stressed : bool
        Whether the ground has an initial stress, so that it need not settle.
    """
    rows = top.rows("stage", _ALL_KEYS, example=EXAMPLE)
    if "stage" not in top:
        top.missing("stage", 'Add [[stage]] with kind = "settle", then what is to happen.')
    elif not rows and not top.findings.errors:
        top.error("stage", "there is no stage", 'Add [[stage]] with kind = "settle".')
    found = [stage for row in rows if (stage := _read(row, places)) is not None]
    if len(found) == len(rows):
        _refuse_order(top, found, rows, stressed)
    return tuple(found)


def stage_lines(stage: StageOptions) -> list[str]:
    """Lines of TOML of one stage."""
    lines = ["[[stage]]", f"kind = {quoted(stage.kind)}", f"name = {quoted(stage.name)}"]
    return lines + [
        f"{key} = {_KEYS[key].write(stage.values[key])}" for key in STAGES[stage.kind] if key in stage.values
    ]


def _read(row: Table, places: Places) -> StageOptions | None:
    findings = row.findings
    before = len(findings.errors)
    kind = row.choice("kind", tuple(STAGES))
    if "kind" not in row:
        row.missing("kind", f"Write one of {', '.join(STAGES)}.")
    if kind is None:
        return None
    name = row.text("name", remedy='Write name = "drift".') or kind
    keys = STAGES[kind]
    for key in row.content:
        if key in _ALL_KEYS and key not in (*keys, "kind", "name"):
            row.error(key, f"a stage of kind {quoted(kind)} has no such key", f"It has {', '.join(keys)}.")
    for key in _NEEDED.get(kind, ()):
        if key not in row:
            row.missing(key, f"Write {key} = {_KEYS[key].example}.")
    values: dict[str, Any] = {}
    for key in keys:
        spec = _KEYS[key]
        usual = 1.0 if (kind, key) == ("settle", "factor") else spec.usual
        value = spec.read(row, key, places) if key in row else usual
        if value is not None:
            values[key] = value
    if values.get("time", 0.0) > MOST * values.get("frames_every", math.inf):
        problem = f"this makes {values['time'] / values['frames_every']:.3g} frames ({MOST:,} at most)"
        row.error("frames_every", problem, "Write a longer time.")
    if kind == "excavate":
        _excavation(row)
    if kind == "remove-wall" and ("from" in row) != ("to" in row):
        row.error("from" if "from" in row else "to", "a part has two ends", "Give from and to.")
    return None if len(findings.errors) > before else StageOptions(kind, name, values)


def _excavation(row: Table) -> None:
    places = [key for key in ("polygon", "centre", "material") if key in row]
    if not places:
        row.missing(
            "polygon",
            'Write polygon = [[0, 0], [10, 0], [10, 5]], or centre and radius, or material = "ore".',
        )
    if "polygon" in row and "centre" in row:
        row.error("centre", "a polygon and a circle are given", "Keep one of the two.")
    if ("centre" in row) != ("radius" in row):
        given, other = ("centre", "radius") if "centre" in row else ("radius", "centre")
        row.error(given, f"{other} is missing", "Give centre and radius.")


def _refuse_order(top: Table, stages: list[StageOptions], rows: list[Table], stressed: bool) -> None:
    """Stages that need ground at rest come after it has settled, and it settles once, first."""
    settled = stressed
    for number, (stage, row) in enumerate(zip(stages, rows, strict=True)):
        if stage.kind == "settle":
            if number > 0:
                row.error(
                    "kind", "the ground has been under its weight since the first stage",
                    'Put "settle" first, or let it come to rest with kind = "run" and until_rest = true.',
                )  # fmt: skip
            settled = True
        elif stage.kind in _AFTER_SETTLING and not settled:
            row.error(
                "kind", "this comes before the ground has settled under its weight",
                'Put a stage with kind = "settle" first, or give [initial_stress].',
            )  # fmt: skip
            settled = True
    if stages and all(stage.kind == "settle" for stage in stages):
        top.findings.questions.append("stage: the ground settles, and nothing else happens.")


def _number(usual: float | None, *, low: float = 0.0, high: float = math.inf, example: str = "2") -> _Key:
    def check(value: float) -> tuple[str, str] | None:
        if low < value <= high:
            return None
        above = f"above {low:g}" + ("" if math.isinf(high) else f" and at most {high:g}")
        return f"this must be {above}", f"Write {example}, for instance."

    return _Key(
        lambda row, key, places: row.quantity(key, "dimensionless", check=check), repr, usual, example
    )


def _quantity(dimension: str, example: str) -> _Key:
    return _Key(
        lambda row, key, places: row.quantity(key, dimension, check=positive),
        lambda value: exact(value, dimension), None, example,
    )  # fmt: skip


def _read_whole(row: Table, key: str, places: Places) -> int | None:
    value = row.integer(key, smallest=1, remedy="Write a whole number such as 10.")
    if value is not None and value > MOST:
        row.error(key, f"so many steps are no use ({MOST:,} at most)", "Write a whole number such as 10.")
        return None
    return value


def _read_flag(row: Table, key: str, places: Places) -> bool | None:
    value = row.content[key]
    if isinstance(value, bool):
        return value
    row.error(key, "true or false is needed here", f"Write {key} = true.")
    return None


def _read_names(row: Table, key: str, places: Places) -> tuple[str, ...] | None:
    value = row.content[key]
    names = value if isinstance(value, list) else [value]
    if names and all(isinstance(name, str) and name for name in names):
        return tuple(names)
    row.error(key, "a name or a list of names is needed here", f'Write {key} = "rock".')
    return None


def _read_velocity(row: Table, key: str, places: Places) -> tuple[float, ...] | None:
    value = row.content[key]
    size = places.dimension or 2
    if not isinstance(value, list) or len(value) != size:
        row.error(key, f"a velocity with {size} components is needed here", 'Write ["0 m/s", "-0.1 m/s"].')
        return None
    keys = tuple(map(str, range(size)))
    inner = Table(row.findings, row.at(key), dict(zip(keys, value, strict=True)), keys)
    parts = [inner.quantity(part, "velocity") for part in keys]
    return None if any(part is None for part in parts) else tuple(part for part in parts if part is not None)


def _flag_text(value: bool) -> str:
    return str(value).lower()


def point_text(point: tuple[float, ...]) -> str:
    """A point with its units."""
    return f"[{', '.join(exact(part, 'length') for part in point)}]"


def _names_text(names: tuple[str, ...]) -> str:
    return quoted(names[0]) if len(names) == 1 else f"[{', '.join(map(quoted, names))}]"


_POINT = _Key(lambda row, key, places: places.point(row, key), point_text, None, "[10, 0]")
_FLAG = (_read_flag, _flag_text)
_KEYS: Mapping[str, _Key] = {
    "rest": _number(_USUAL.rest, high=0.1, example="1e-4"),
    "patience": _number(1.0, high=1e4, example="2"),
    "factor": _number(None, example="2"),
    "start": _number(_USUAL_PLAN.start, example="1"),
    "step": _number(_USUAL_PLAN.step, high=10.0, example="0.5"),
    "tolerance": _number(_USUAL_PLAN.tolerance, low=1e-6, high=1.0, example="0.05"),
    "highest": _number(_USUAL_PLAN.highest, high=1000.0, example="20"),
    "failed_diameters": _number(_USUAL.failed_diameters, example="2"),
    "moving_share": _number(_USUAL.moving_share, high=1.0, example="0.005"),
    "goes_on": _Key(
        lambda row, key, places: row.choice(key, ("start", "stable", "failed")), quoted, _USUAL_PLAN.goes_on, '"stable"'
    ),
    "material": _Key(_read_names, _names_text, None, '"rock"'),
    "wall": _Key(lambda row, key, places: row.text(key, remedy='Write wall = "bottom".'), quoted, None, '"bottom"'),
    "polygon": _Key(
        lambda row, key, places: places.points(row, key, fewest=3) or None,
        lambda value: f"[{', '.join(map(point_text, value))}]", None, "[[0, 0], [10, 0], [10, 5]]",
    ),
    "centre": _POINT,
    "from": _POINT,
    "to": _POINT,
    "radius": _quantity("length", '"2.5 m"'),
    "time": _quantity("time", '"5 s"'),
    "frames_every": _quantity("time", '"0.5 s"'),
    "velocity": _Key(
        _read_velocity, lambda value: f"[{', '.join(exact(part, 'velocity') for part in value)}]", None,
        '["0 m/s", "-0.1 m/s"]',
    ),
    "shares": _Key(_read_whole, repr, 10, "10"),
    "come_to_rest": _Key(*_FLAG, True, "true"),
    "until_rest": _Key(*_FLAG, False, "true"),
}  # fmt: skip
