"""What result.json says of a run-out, and its frames."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .case.runout import RunoutCase
from .io.checkpoint import checksum
from .io.vtkhdf import write_vtkhdf
from .measure.deposit import Deposit
from .model import Model
from .record import MethodRecord
from .result import bracket_warnings, dilation_warnings, factor_entry
from .runout.flow import Flow
from .runout.handing import HandOver

Floats = NDArray[np.float64]

FRAME_LOOKS = 4
"""Looks between frames."""
LONG_SHIFT = 0.5
"""Way of the packing to the centre of gravity, in mean diameters, that is worth a word."""


def assemble(
    case: RunoutCase, model: Model, record: MethodRecord, hand: HandOver, flow: Flow
) -> dict[str, Any]:
    """Everything that result.json holds, but what the run itself knows."""
    factor = factor_entry(record)
    source, last = hand.source, flow.looks[-1]
    found = flow.deposit()
    return {
        "kind_of_result": "failure: quasi-static search; flow: true motion of discs, times are real",
        "particles": model.particles,
        "discs": int(hand.moving.sum()),
        "held_discs": int((~hand.moving).sum()),
        "dimension": 2,
        "factors": [factor],
        "moved": {
            "what": case.runout.mass,
            "start": case.runout.start,
            "area_m2": source.area,
            "mass_kg_m": source.mass,
            "height_m": source.height,
            "at_factor": None if record.failed is None else record.failed.factor,
        },
        "hand_over": {
            "conserved": [
                {"name": entry.name, "unit": entry.unit, "before": entry.before, "after": entry.after,
                 "error": entry.error}
                for entry in hand.conserved
            ],
            "energy_jump": hand.error("energy"),
            "displacement_taken": hand.source.taken,
            "settlement_m": hand.settlement,
            "shift_m": hand.shift.tolist(),
            "unbalanced_ratio": hand.unbalanced_ratio,
            "mean_diameter_m": hand.diameter,
            "normal_stiffness_N_m2": hand.stiffness,
        },
        "deposit": deposit_entry(found),
        "flow": {
            "at_rest": flow.at_rest,
            "time_s": last.time,
            "fall_time_s": flow.fall_time,
            "largest_speed_m_s": max(look.fastest for look in flow.looks),
            "largest_kinetic_J_m": max(look.kinetic for look in flow.looks),
            "dissipated_J_m": last.dissipated,
        },
        "steps": flow.simulation.steps,
        "notices": [text.removesuffix(".") for text in _notices(case, hand)],
        "warnings": [text.removesuffix(".") for text in _warnings(case, hand, flow, factor)],
        "digest": checksum({"positions": flow.simulation.positions, "looks": np.array(flow.looks)}),
    }  # fmt: skip


def deposit_entry(found: Deposit) -> dict[str, Any]:
    """A deposit, with units in the names."""
    return {
        "front_m": found.front,
        "run_out_m": found.run_out,
        "height_m": found.height,
        "fall_height_m": found.fall_height,
        "reach_m": found.reach,
        "angle_of_reach_deg": math.degrees(found.angle_of_reach),
        "centre_m": found.centre.tolist(),
        "travel_angle_deg": math.degrees(found.travel_angle),
        "left_behind": found.left_behind,
        "loose": found.loose,
        "crest_m": found.crest.tolist(),
        "profile_m": found.profile.tolist(),
    }


def _notices(case: RunoutCase, hand: HandOver) -> list[str]:
    unit = hand.source.mass / hand.source.area * hand.source.gravity * hand.source.height
    return [
        *case.notices,
        f"discs touch with a normal stiffness of {hand.stiffness:.3g} N/m per metre, "
        f"{hand.stiffness / unit:.0f} rho g H, and flow with rolling resistance",
        *(
            [f"{100.0 * hand.source.taken:.3g} % of the displacement of the failed trial is taken along"]
            if hand.source.taken < 1.0
            else []
        ),
        "pore water is not modelled: what flows is dry, or its residual friction angle is one of total stress",
    ]


def _warnings(case: RunoutCase, hand: HandOver, flow: Flow, factor: dict[str, Any]) -> list[str]:
    found = [*case.questions, *dilation_warnings(case.slope), *bracket_warnings([factor])]
    if factor["value"] is not None and factor["value"] > 1.0:
        found.append(
            f"the slope stands at its own strength (factor of safety {factor['value']:.3g}): what flows is the mass "
            "that would fail if its strength were divided by that factor"
        )
    if case.slope.loads.surcharge or case.slope.loads.horizontal_acceleration:
        found.append("loads beside the weight act until the failure and not on the flow")
    if not flow.at_rest:
        found.append(f"the mass had not come to rest after {flow.looks[-1].time:.3g} s")
    end = flow.surface[-1, 0] if flow.downhill > 0.0 else flow.surface[0, 0]
    if flow.downhill * (end - flow.looks[-1].front) < 2.0 * hand.diameter:
        found.append("the front reached the end of the level ground: make runout.beyond longer")
    shift = float(np.hypot(*hand.shift))
    if shift > LONG_SHIFT * hand.diameter:
        found.append(
            f"the discs were moved by {shift:.3g} m, {shift / hand.diameter:.1f} mean diameters, to the centre of "
            "gravity: take more discs"
        )
    return found


def write_frames(folder: Path, flow: Flow, places: Floats) -> None:
    """Discs at every few looks, for ParaView."""
    a = flow.simulation.assembly
    for number, where in enumerate(places):
        write_vtkhdf(
            folder / f"discs-{number:06d}.vtkhdf",
            where,
            point_data={
                "radius [m]": a.radii, "material [-]": a.material, "moving [-]": flow.moving.astype(np.int32),
                "displacement [m]": np.hypot(*(where - flow.start).T),
            },
            field_data={"materials": ", ".join(a.material_names)},
            time=flow.looks[min(number * FRAME_LOOKS, len(flow.looks) - 1)].time,
        )  # fmt: skip
