"""What a cut came to, as result.json and history.csv tell it: SI, the unit at the end of a name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from .cutting.course import COLUMNS, Course
from .cutting.outcome import Force, Outcome, chip_facts
from .cutting_building import Cut, pace_of, speed_warning

HISTORY = {
    "step": "step [-]", "time": "time [s]", "way": "way of the tool [m]", "speed": "speed [m/s]",
    "cutting": "cutting force [N/m]", "normal": "normal force [N/m]",
    "pressed": "pressing on the face [N/m]", "slid": "pressing on the face where it is slid on [N/m]",
    "cutting_slid": "cutting force where the face is slid on [N/m]",
    "normal_slid": "normal force where the face is slid on [N/m]",
    "tension_cracks": "tension cracks [-]", "shear_cracks": "shear cracks [-]", "imbalance": "imbalance of energy [-]",
}  # fmt: skip
FORCES = {"cutting_": "cutting force on the", "normal_": "normal force on the"}


def history_names() -> list[str]:
    """Headers of history.csv, in the order of `COLUMNS`."""
    found = []
    for name in COLUMNS:
        prefix = next((each for each in FORCES if name.startswith(each)), None)
        if name in HISTORY:
            found.append(HISTORY[name])
        elif prefix is not None:
            found.append(f"{FORCES[prefix]} {name[len(prefix) :]} [N/m]")
        else:
            found.append(f"{'work of the tool' if name == 'tool' else f'energy, {name}'} [J/m]")
    return found


def force_entry(force: Force) -> dict[str, float]:
    """A force over the way after entry."""
    return {
        "mean": force.mean, "standard_deviation": force.deviation, "peak": force.peak, "mean_of_peaks": force.peaks,
    }  # fmt: skip


def assemble(cut: Cut, course: Course, found: Outcome) -> dict[str, Any]:
    """Content of result.json but for what every run adds."""
    pace = pace_of(cut, course.simulation)
    # ground without bonds yields: no peaks are hit off it
    peak = found.peak_stress if len(course.assembly.bonds) else math.nan
    case, plan, tool, placed = cut.case, cut.plan, cut.plan.tool, cut.placed
    way = course.columns()["way"]
    low, high = cut.scene.box
    angle = found.face_angle
    return {
        "workflow": "cutting",
        "title": case.title,
        "dimension": 2,
        "particles": int(course.assembly.particles),
        "bonds": len(course.assembly.bonds),
        "mean_diameter_m": placed.diameter,
        "bounds_m": [low.tolist(), high.tolist()],
        "seed": case.seed,
        "steps": int(course.simulation.steps),
        "time_step_s": float(course.simulation.time_step),
        "tool": {
            "rake_rad": tool.rake, "clearance_rad": tool.clearance, "wear_flat_m": tool.wear_flat,
            "tip_radius_m": tool.tip_radius, "friction_angle_rad": tool.friction_angle, "height_m": tool.height,
            "depth_m": plan.depth, "depth_over_diameter": plan.depth / placed.diameter,
            "speed_m_per_s": plan.speed, "start_m": placed.place.tolist(), "first_touch_m": placed.contact,
            "way_m": float(way[-1]), "ramp_m": placed.ramp,
        },
        "forces": {
            "after_m": found.first,
            "cutting_N_per_m": force_entry(found.cutting),
            "normal_N_per_m": force_entry(found.normal),
            "parts_N_per_m": {
                name: {"cutting": values[0], "normal": values[1]} for name, values in found.parts.items()
            },
            "normal_over_cutting_on_face": math.tan(angle) if math.isfinite(angle) else None,
            "face_angle_rad": _told(angle),
            "expected_face_angle_rad": tool.friction_angle - tool.rake,
            "sliding_share_of_face": _told(found.sliding_share),
            "sliding_face_angle_rad": _told(found.sliding_angle),
        },
        "speed": {
            "wave_stress_Pa": pace.stress, "peak_stress_Pa": _told(found.peak_stress),
            "passages_of_a_wave_to_a_peak": _told(pace.passages(peak)),
        },
        "work_per_way_N_per_m": found.work,
        "specific_energy_Pa": found.specific_energy,
        "chips": chip_facts(found),
        "cracks": dict(found.cracks),
        "energy": {f"{name}_J_per_m": value for name, value in found.energy.items()} | {"imbalance": found.imbalance},
        "notices": list(case.notices),
        "questions": list(case.questions),
        "warnings": [*cut.warnings, *speed_warning(pace), *pace.doubts(peak, plan.damping), *_doubts(found)],
    }  # fmt: skip


def _told(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _doubts(found: Outcome) -> list[str]:
    doubts = []
    if not abs(found.imbalance) <= 0.01:
        doubts.append(
            f"The energy account is off by {100.0 * found.imbalance:.2g} %: a slower tool closes it better."
        )
    if not math.isfinite(found.cutting.mean):
        doubts.append("The tool has not gone beyond its entry: there are no means.")
    return doubts


def history_row(row: Sequence[float]) -> list[float]:
    """A row of history.csv of one of a course; whole numbers as such."""
    return [int(value) if name in WHOLE else value for name, value in zip(COLUMNS, row, strict=True)]


WHOLE = ("step", "tension_cracks", "shear_cracks")
