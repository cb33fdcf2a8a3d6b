"""A case of run-out: a slope as in a case of kind slope, and in [runout] how its failed mass flows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from geodem import units
from geodem.case.data import Case, GroundMaterial, SectionOptions
from geodem.case.head import read_head
from geodem.case.reading import KEYS as SLOPE_KEYS
from geodem.case.reading import read_slope
from geodem.case.section import positive
from geodem.case.table import Table, join, quoted
from geodem.case.writing import as_run_text
from geodem.errors import InputError
from geodem.runout.friction import MEASURED, disc_friction
from geodem.runout.placing import FEWEST
from geodem.runout.source import WHAT

KEYS = (*(key for key in SLOPE_KEYS if key not in ("methods", "reference")), "runout")
RUNOUT_KEYS = ("mass", "start", "discs", "beyond", "restitution", "residual_friction_angle")
STARTS = ("rest", "failing")
METHODS = ("strength-reduction",)
DEFAULT_DISCS = 2000
DEFAULT_RESTITUTION = 0.5
BEYOND = 4.0
"""Level ground beyond the section over the height of what moves, where the case does not say."""
_MANY = 200_000
_EXAMPLE = '[runout] with residual_friction_angle = "25 deg"'


@dataclass(frozen=True)
class RunoutOptions:
    """How a failed mass flows.

    Attributes
    ----------
    mass : str
        ``failing``: the mass that slides. ``section``: all that the supports do not hold.
    start : str
        ``rest``, or ``failing``: with the energy that the search took out as damping, moving as it fails.
    discs : int
        Of what moves, about.
    beyond : float or None
        Level ground beyond the section [m]; None for `BEYOND` times the height of what moves.
    restitution : float
        Of two discs that meet head-on [-].
    residual_friction : mapping of str to float
        Of every material that the section uses [rad].
    """

    mass: str
    start: str
    discs: int
    beyond: float | None
    restitution: float
    residual_friction: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class RunoutCase:
    """A slope and how its failed mass flows.

    Attributes
    ----------
    slope : Case
        Its workflow is "runout".
    runout : RunoutOptions
    """

    slope: Case
    runout: RunoutOptions
    workflow: str = "runout"

    @property
    def title(self) -> str:
        """What the user calls it."""
        return self.slope.title

    @property
    def notices(self) -> tuple[str, ...]:
        """Defaults that were taken, in words."""
        return self.slope.notices

    @property
    def questions(self) -> tuple[str, ...]:
        """Doubts that do not stop a run."""
        return self.slope.questions

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""
        own = self.runout
        slope = as_run_text(replace(self.slope, reference=None)).splitlines()
        angles = ", ".join(
            f"{join('', name)} = {quoted(units.exact(angle, 'angle'))}"
            for name, angle in own.residual_friction.items()
        )
        lines = [
            *(line for line in slope if not line.startswith("methods = ")),
            "",
            "[runout]",
            f"mass = {quoted(own.mass)}",
            f"start = {quoted(own.start)}",
            f"discs = {own.discs}",
            *([] if own.beyond is None else [f"beyond = {quoted(units.exact(own.beyond, 'length'))}"]),
            f"restitution = {own.restitution!r}",
            f"residual_friction_angle = {{{angles}}}",
        ]
        return "\n".join(lines) + "\n"

    def beside(self) -> tuple[RunoutCase, dict[str, Path]]:
        """The same with its file beside it, as it stands in the folder of the results, and where that comes from."""
        section = self.slope.section
        if section.file is None:
            return self, {}
        moved = section.beside()
        assert moved.file is not None
        return replace(self, slope=replace(self.slope, section=moved)), {str(moved.file): section.file}


def parse_runout(text: str, folder: Path) -> RunoutCase:
    """Read a case of run-out from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What relative paths in it are relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another workflow.
    InputErrors
        All that is wrong in it, in its order.
    """
    head = read_head(text, folder, "runout", KEYS, example="Run-out of a slope")
    read = read_slope(head, folder, METHODS)
    options = _options(head.top, read["section"], read["materials"])
    slope = Case(**head.close(), **read, workflow="runout")
    # every None below has been reported
    assert options is not None
    return RunoutCase(slope, options)


def _options(
    top: Table, section: SectionOptions | None, materials: Mapping[str, GroundMaterial]
) -> RunoutOptions | None:
    findings = top.findings
    empty: Mapping[str, object] = {}
    table = (
        top.sub("runout", RUNOUT_KEYS, example=_EXAMPLE)
        if "runout" in top
        else Table(findings, "runout", empty, RUNOUT_KEYS)
    )
    if table is None:
        return None
    mass = table.choice("mass", WHAT, default="failing")
    start = table.choice("start", STARTS, default="rest")
    discs = table.integer("discs", smallest=FEWEST, remedy="Write a whole number such as 2000.")
    if discs is None:
        if "discs" not in table:
            findings.default(table.at("discs"), str(DEFAULT_DISCS))
        discs = DEFAULT_DISCS
    elif discs > _MANY:
        findings.implausible(table.at("discs"), "so many discs take hours", "Write 2000.", value=discs)
    beyond = table.quantity("beyond", "length", check=positive)
    findings.asked.add(table.at("beyond"))
    if "beyond" not in table:
        findings.default(table.at("beyond"), f"{BEYOND:g} times the height of what moves")
    used = () if section is None else section.materials
    restitution = table.quantity("restitution", "dimensionless", check=_restitution)
    if "restitution" not in table:
        findings.default(table.at("restitution"), f"{DEFAULT_RESTITUTION:g}")
    friction = _angles(table, used, materials)
    return RunoutOptions(
        mass or "failing", start or "rest", discs, beyond,
        DEFAULT_RESTITUTION if restitution is None else restitution, friction,
    )  # fmt: skip


def _angles(table: Table, used: tuple[str, ...], materials: Mapping[str, GroundMaterial]) -> dict[str, float]:
    """Residual friction angle of every material that the section uses [rad]."""
    findings, key = table.findings, "residual_friction_angle"
    content = table.content.get(key)
    given: dict[str, float] = {}
    if isinstance(content, dict):
        inner = table.sub(key, used or tuple(content), example=f'{key} = {{soil = "25 deg"}}')
        assert inner is not None
        for name in content:
            angle = inner.quantity(name, "angle", check=_reachable)
            if angle is not None:
                given[name] = angle
    elif key in table:
        angle = table.quantity(key, "angle", check=_reachable)
        given = {} if angle is None else dict.fromkeys(used, angle)
        if angle is None:
            return {}
    found = {}
    for name in used:
        if name in given:
            found[name] = given[name]
        elif name in materials and not (isinstance(content, dict) and name in content):
            own = materials[name].friction_angle
            shown = units.show(own, "angle")
            findings.default(
                join(table.at(key), name), shown, why="the friction angle; cohesion is lost in the flow"
            )
            wrong = _reachable(own)
            if wrong is not None:
                findings.error(
                    join(table.at(key), name), f"missing, and {shown} cannot be taken: {wrong[0]}", wrong[1]
                )
            found[name] = own
    return found


def _reachable(angle: float) -> tuple[str, str] | None:
    try:
        disc_friction(angle)
    except InputError:
        low, high = MEASURED[0][1], MEASURED[-1][1]
        return (
            f"discs with rolling resistance flow with {low:g} to {high:g} deg",
            'Residual angles of soils are 15 to 32 deg: write "25 deg", say.',
        )
    return None


def _restitution(value: float) -> tuple[str, str] | None:
    if 0.0 < value <= 1.0 and math.isfinite(value):
        return None
    return "the coefficient of restitution lies above 0 and is at most 1", "Write 0.5."
