"""Kinds of cases: what each is called, and where its functions are. A new kind is its own files and one entry here.

Functions are named as "module:function" within geodem and are imported when they are first called, so that a case of
one kind does not load what the others need.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.console import Console

Answer = list[tuple[str, str]]
"""Lines that a run ends with: what is printed in bold, and what comes after it."""


class AnyCase(Protocol):
    """What cases of all kinds have in common."""

    @property
    def workflow(self) -> str:
        """The name of its kind."""

    @property
    def title(self) -> str:
        """What the user calls it."""

    @property
    def notices(self) -> tuple[str, ...]:
        """Defaults that were taken, in words."""

    @property
    def questions(self) -> tuple[str, ...]:
        """Doubts that do not stop a run."""

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""


@dataclass(frozen=True)
class Kind:
    """One kind of case.

    Attributes
    ----------
    name : str
        As `workflow` in a case file, and of the folder in geodem/templates that `geodem new` copies.
    command : str
        What runs it.
    reader, runner, resumer, redrawer, checker, answerer : str
        Where the functions `parse`, `run`, `resume`, `redraw`, `check` and `answer` are.
    marks : tuple of str
        Top-level keys that tell this kind where a case names none.
    table : mapping of str to str
        What a sweep tabulates unless it says otherwise: name with unit, place in result.json.
    picture : str
        Pattern of the figure that shows best what came of a run; the first one of these stands in a sweep's report.
    processes : bool
        Its parts run in processes of their own, which compile side by side.
    """

    name: str
    command: str
    reader: str
    runner: str
    resumer: str
    redrawer: str
    checker: str
    answerer: str
    marks: tuple[str, ...] = ()
    table: Mapping[str, str] = field(default_factory=dict)
    picture: str = "*.png"
    processes: bool = False

    def parse(self, text: str, folder: Path) -> AnyCase:
        """The case from its text; paths in it are relative to `folder`. Raises InputError, InputErrors."""
        case: AnyCase = _load(self.reader)(text, folder)
        return case

    def run(
        self,
        case: AnyCase,
        out: Path,
        *,
        threads: int | None = None,
        quickly: bool = False,
        overwrite: bool = False,
        watch: Callable[[Any], None] | None = None,
        stop_asked: Callable[[], bool] | None = None,
        command: str = "",
    ) -> dict[str, Any]:
        """Run into a folder, or go on there; the content of result.json. Raises InputError, StoppedError."""
        result: dict[str, Any] = _load(self.runner)(
            case, out, threads=threads, quickly=quickly, overwrite=overwrite, watch=watch,
            stop_asked=stop_asked, command=command,
        )  # fmt: skip
        return result

    def resume(
        self,
        folder: Path,
        case: AnyCase,
        *,
        threads: int | None = None,
        watch: Callable[[Any], None] | None = None,
        stop_asked: Callable[[], bool] | None = None,
        command: str = "",
    ) -> dict[str, Any]:
        """Go on with the run that a folder holds, `case` as its case.toml says it. Raises InputError, StoppedError."""
        result: dict[str, Any] = _load(self.resumer)(
            folder, case, threads=threads, watch=watch, stop_asked=stop_asked, command=command
        )
        return result

    def redraw(self, folder: Path, case: AnyCase) -> Path:
        """Make report and pictures again from what a folder holds; the report's path. Raises InputError."""
        path: Path = _load(self.redrawer)(folder, case)
        return path

    def check(self, case: AnyCase, picture: Path, console: Console) -> dict[str, Any]:
        """Build without running, print what it is and will cost, draw it into the file `picture`.

        What is returned has "expected_s": seconds of a run, or seconds by part of a run. Raises InputError.
        """
        found: dict[str, Any] = _load(self.checker)(case, picture, console)
        return found

    def answer(self, result: Mapping[str, Any]) -> Answer:
        """What a result says, in the words of its report."""
        lines: Answer = _load(self.answerer)(result)
        return lines


_ALL = (
    Kind(
        "slope",
        "geodem run",
        reader="case.reading:parse_case",
        runner="slope_run:run_slope",
        resumer="slope_run:resume_slope",
        redrawer="slope_run:redraw_slope",
        checker="slope_check:check_slope",
        answerer="plotting.wording:answer",
        table={
            "factor of safety [-]": "factors[kind=strength-reduction].value",
            "gravity factor [-]": "factors[kind=gravity-increase].value",
        },
        picture="*-failure.png",
    ),
    Kind(
        "laboratory",
        "geodem lab",
        reader="case.laboratory_reading:parse_laboratory",
        runner="laboratory_run:run_laboratory",
        resumer="laboratory_run:resume_laboratory",
        redrawer="laboratory_run:redraw_laboratory",
        checker="laboratory_check:check_tests",
        answerer="plotting.laboratory_wording:laboratory_answer",
        table={
            "compressive strength [Pa]": "properties.uniaxial_compressive_strength_Pa.mean",
            "tensile strength [Pa]": "properties.tensile_strength_Pa.mean",
            "Young's modulus [Pa]": "properties.young_modulus_Pa.mean",
            "Poisson's ratio [-]": "properties.poisson_ratio.mean",
            "friction angle [rad]": "properties.friction_angle_rad.mean",
        },
        processes=True,
    ),
    Kind(
        "calibration",
        "geodem calibrate",
        reader="case.laboratory_reading:parse_calibration",
        runner="calibration_run:run_calibration",
        resumer="calibration_run:resume_calibration",
        redrawer="calibration_run:redraw_calibration",
        checker="laboratory_check:check_tests",
        answerer="plotting.laboratory_wording:calibration_answer",
        table={
            "compressive strength [Pa]": "properties.uniaxial_compressive_strength.achieved",
            "tensile strength [Pa]": "properties.tensile_strength.achieved",
            "Young's modulus [Pa]": "properties.young_modulus.achieved",
        },
        processes=True,
    ),
    Kind(
        "ground",
        "geodem run",
        reader="case.ground_reading:parse_ground",
        runner="ground_run:run_ground",
        resumer="ground_run:resume_ground",
        redrawer="ground_run:redraw_ground",
        checker="ground_check:check_ground",
        answerer="plotting.ground_wording:answer",
        marks=("source",),
        table={"particles [-]": "particles", "neighbours of a particle [-]": "contacts.coordination"},
    ),
    Kind(
        "breaking",
        "geodem run",
        reader="case.breaking_reading:parse_breaking",
        runner="breaking_run:run_breaking",
        resumer="breaking_run:resume_breaking",
        redrawer="breaking_run:redraw_breaking",
        checker="breaking_check:check_breaking",
        answerer="plotting.breaking_wording:answer",
        table={
            "gravity factor [-]": "factors[kind=gravity-increase].value",
            "strength factor [-]": "factors[kind=strength-reduction].value",
            "cracks in tension [-]": "cracks.tension",
            "cracks in shear [-]": "cracks.shear",
        },
    ),
    Kind(
        "sweep",
        "geodem sweep",
        reader="case.sweep_reading:parse_sweep",
        runner="sweep_run:run_sweep",
        resumer="sweep_run:resume_sweep",
        redrawer="sweep_run:redraw_sweep",
        checker="sweep_check:check_sweep",
        answerer="plotting.sweep_report:answer",
        marks=("vary",),
    ),
    Kind(
        "tunnel",
        "geodem run",
        reader="case.tunnel_reading:parse_tunnel",
        runner="tunnel_run:run_tunnel",
        resumer="tunnel_run:resume_tunnel",
        redrawer="tunnel_run:redraw_tunnel",
        checker="tunnel_check:check_tunnel",
        answerer="plotting.tunnel_wording:answer",
        marks=("excavation",),
        table={
            "mean convergence [m]": "stages[-1].mean_convergence_m",
            "plastic radius over radius [-]": "stages[-1].plastic_radius_ratio",
            "largest thrust [N/m]": "stages[-1].largest_thrust_N_per_m",
            "factor of safety [-]": "factors[kind=strength-reduction].value",
        },
    ),
    Kind(
        "cutting",
        "geodem run",
        reader="case.cutting_reading:parse_cutting",
        runner="cutting_run:run_cutting",
        resumer="cutting_run:resume_cutting",
        redrawer="cutting_run:redraw_cutting",
        checker="cutting_check:check_cutting",
        answerer="plotting.cutting_wording:answer",
        table={
            "cutting force [N/m]": "forces.cutting_N_per_m.mean",
            "cutting force, mean of peaks [N/m]": "forces.cutting_N_per_m.mean_of_peaks",
            "normal force [N/m]": "forces.normal_N_per_m.mean",
            "specific energy [Pa]": "specific_energy_Pa",
            "chips [-]": "chips.chips",
        },
    ),
    Kind(
        "runout",
        "geodem run",
        reader="case.runout:parse_runout",
        runner="runout_run:run_runout",
        resumer="runout_run:resume_runout",
        redrawer="runout_run:redraw_runout",
        checker="runout_check:check_runout",
        answerer="plotting.runout_wording:answer",
        table={
            "run-out [m]": "deposit.run_out_m",
            "angle of reach [deg]": "deposit.angle_of_reach_deg",
            "moved mass [kg/m]": "moved.mass_kg_m",
        },
    ),
)

KINDS: Mapping[str, Kind] = {kind.name: kind for kind in _ALL}
"""Every kind by its name; the first is that of a case which does not say what it is."""


def kind_of(document: Mapping[str, Any]) -> Kind:
    """The kind that a case file names; where it names none that there is, the one that it looks like."""
    named = document.get("workflow")
    if isinstance(named, str) and named in KINDS:
        return KINDS[named]
    return next((kind for kind in _ALL if any(mark in document for mark in kind.marks)), _ALL[0])


def kind_of_result(result: Mapping[str, Any] | None) -> Kind:
    """The kind of a run by its result.json; a run that has none yet is one of the first kind."""
    return KINDS.get(str((result or {}).get("workflow")), _ALL[0])


def _load(place: str) -> Callable[..., Any]:
    module, _, name = place.partition(":")
    found: Callable[..., Any] = getattr(import_module(f"geodem.{module}"), name)
    return found
