"""The folder that a run leaves: result.json, report.html, history.csv, frames, the case and its picture."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .analysis import Analysis
from .builders.ground import downhill
from .building import portable_text, source_bytes
from .case import ImageSection
from .io.files import write_json, write_whole
from .io.vtkhdf import write_vtkhdf
from .measure.failure import Failure, describe_failure
from .plotting.report import write_report
from .plotting.views import MethodView, ReportView
from .record import MethodRecord, write_trials
from .result import assemble
from .stability.bracket import bracket
from .stability.search import Snapshot
from .units import show

Floats = NDArray[np.float64]


def write_case(analysis: Analysis, folder: Path) -> None:
    """case.toml as it is run, and the picture, mesh or terrain it names beside it."""
    spec = analysis.case.section
    content = source_bytes(spec)
    if spec.file is not None and content is not None:
        copy = folder / spec.file.name
        if not copy.exists() or copy.read_bytes() != content:
            write_whole(copy, content)
    write_whole(folder / "case.toml", portable_text(analysis.case))


def write_outputs(
    analysis: Analysis, folder: Path, neighbours: dict[str, Any], command: str = ""
) -> dict[str, Any]:
    """Write everything; returns the content of result.json.

    Parameters
    ----------
    analysis : Analysis
        Finished, or stopped on its way.
    folder : pathlib.Path
    neighbours : dict
        ``{"methods": [...], "why": "..."}``: what limit equilibrium says.
    command : str
        The command that made it, for the report.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    result = assemble(analysis)
    result["neighbours"] = neighbours.get("methods", [])
    result["neighbours_why"] = neighbours.get("why", "")
    result["command"] = command
    _attach_reference(result)
    failures = failures_of(analysis)
    for entry in result["factors"]:
        failure = failures[entry["kind"]]
        if failure is not None:
            entry["failure"] = {
                "moving_area_m2": failure.moving_area,
                "slip_surface_m": failure.slip_surface.tolist(),
                "largest_displacement_m": float(np.sqrt((failure.displacement**2).sum(axis=1)).max()),
            }
    write_trials(folder / "history.csv", analysis.records.values())
    draw_outputs(analysis, folder, result, failures)
    # last, so that a result that says "done" has everything beside it
    return write_json(folder / "result.json", result)


def draw_outputs(
    analysis: Analysis,
    folder: Path,
    result: dict[str, Any],
    failures: dict[str, Failure | None] | None = None,
) -> None:
    """Frames, figures and report of a result that is known."""
    failures = failures_of(analysis) if failures is None else failures
    write_frames(analysis, folder)
    write_report(folder / "report.html", result, make_view(analysis, failures))


def failures_of(analysis: Analysis) -> dict[str, Failure | None]:
    """Moving mass and slip surface of every method's lowest failed state; None where nothing failed."""
    return {kind: _failure(analysis, record) for kind, record in analysis.records.items()}


def write_frames(analysis: Analysis, folder: Path) -> None:
    """Frames for ParaView: the settled ground, and the last stable and first failed state of every method."""
    model, particles = analysis.model, analysis.particles
    assert model is not None
    assert particles is not None
    cells = {"material [-]": model.triangle_material}
    for kind, record in analysis.records.items():
        for name, snapshot in (("stable", record.stable), ("failed", record.failed)):
            if snapshot is None:
                continue
            stress = particle_values(analysis, snapshot)
            write_vtkhdf(
                folder / f"{kind}-{name}.vtkhdf",
                model.positions,
                model.triangles,
                point_data={
                    "displacement [m]": snapshot.state.displacement,
                    "stress xx [Pa]": stress[:, 0],
                    "stress yy [Pa]": stress[:, 1],
                    "stress xy [Pa]": stress[:, 2],
                    "plastic shear strain [-]": stress[:, 3],
                    "unbalanced force [N/m]": np.where(model.held, 0.0, snapshot.state.force),
                },
                cell_data=cells,
                field_data={
                    "factor": np.array([snapshot.factor]),
                    "materials": ", ".join(model.material_names),
                },
            )


def particle_values(analysis: Analysis, snapshot: Snapshot) -> Floats:
    """Stress [Pa] and plastic shear strain of every particle (n, 4): area-weighted over its stress points."""
    model = analysis.model
    assert model is not None
    return model.particle_mean(snapshot.state.stress)


def make_view(analysis: Analysis, failures: dict[str, Failure | None] | None = None) -> ReportView:
    """What the report and the check picture draw."""
    case, model, particles, section = analysis.case, analysis.model, analysis.particles, analysis.section
    assert model is not None
    assert particles is not None
    assert section is not None
    failures = failures or {}
    spec = case.section
    sideways = case.loads.horizontal_acceleration * downhill(model.positions, particles.boundary_edges)
    loads = [
        f"{show(s.pressure, 'stress')} from ({s.start[0]:g}, {s.start[1]:g}) to ({s.end[0]:g}, {s.end[1]:g}) m"
        for s in case.loads.surcharge
    ]
    if sideways:
        loads.append(
            f"horizontal acceleration {show(abs(sideways), 'acceleration')} out of the slope, pseudo-static"
        )
    return ReportView(
        title=case.title,
        case_text=portable_text(case),
        positions=model.positions,
        triangles=model.triangles,
        triangle_material=model.triangle_material,
        materials=model.material_names,
        material_rows=[_material_row(case.materials[name]) for name in model.material_names],
        outlines=[
            (
                region.material,
                [np.asarray(ring.coords) for ring in (region.polygon.exterior, *region.polygon.interiors)],
            )
            for region in section.regions
        ],
        supports={side: getattr(case.boundary, side) for side in ("left", "right", "bottom", "top")},
        loads=loads,
        image_path=spec.image if isinstance(spec, ImageSection) else None,
        methods=[
            _method_view(record, failures.get(kind))
            for kind, record in analysis.records.items()
            if record.fine
        ],
        spacing=particles.spacing,
        surcharges=[(s.start, s.end, s.pressure) for s in case.loads.surcharge],
        horizontal_acceleration=sideways,
    )


def _method_view(record: MethodRecord, failure: Failure | None) -> MethodView:
    now = bracket(record.fine)
    trials = [*record.coarse, *record.fine]
    deciding = next((t.criterion for t in record.fine if t.factor == now.failed), "")
    return MethodView(
        kind=record.kind,
        value=now.value,
        stable=now.stable,
        failed=now.failed,
        criterion=deciding,
        undecided=list(now.undecided),
        trials=[t.as_dict() for t in trials],
        histories=[
            (t.factor, t.verdict, np.array([h[0] for h in t.history]), np.array([h[2] for h in t.history]))
            for t in record.fine
        ],
        failure=failure,
    )


def _failure(analysis: Analysis, record: MethodRecord) -> Failure | None:
    model = analysis.model
    if record.failed is None or model is None:
        return None
    strain = particle_values(analysis, record.failed)[:, 3]
    return describe_failure(model.positions, model.triangles, record.failed.state.displacement, strain)


def _material_row(material: Any) -> dict[str, str]:
    tension = material.tensile_strength
    dilation = f"{math.degrees(material.dilation_angle):.4g} deg"
    return {
        "name": material.name,
        "law": material.law.replace("_", "-"),
        "unit weight": show(material.density * 9.81, "unit_weight"),
        "cohesion": show(material.cohesion, "stress"),
        "friction angle": f"{math.degrees(material.friction_angle):.4g} deg",
        "dilation angle": dilation if material.dilation_given else f"{dilation} (assumed)",
        "tensile strength": "full cone" if math.isinf(tension) else show(tension, "stress"),
        "Young modulus": show(material.young_modulus, "stress"),
        "Poisson ratio": f"{material.poisson_ratio:g}",
    }


def _attach_reference(result: dict[str, Any]) -> None:
    """The published value, else the limit equilibrium one, beside the strength reduction factor."""
    for entry in result["factors"]:
        if entry["kind"] != "strength-reduction" or entry["value"] is None:
            continue
        if result["reference"] is not None:
            value, how = result["reference"]["factor"], result["reference"]["source"]
        elif result["neighbours"]:
            value, how = result["neighbours"][0]["factor"], result["neighbours"][0]["method"]
        else:
            continue
        difference = 100.0 * (entry["value"] / value - 1.0)
        entry["reference"] = {"value": value, "how": how, "difference_percent": round(difference, 3)}
