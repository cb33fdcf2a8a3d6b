"""What result.json says of a tunnel."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .case.tunnel import TunnelCase
from .io.checkpoint import checksum
from .record import MethodRecord
from .stability.bracket import bracket
from .stability.methods import GravityIncrease, LoadIncrease, StrengthReduction
from .tunnelling.digging import Digging
from .tunnelling.measure import lining_forces
from .tunnelling.progress import Progress

UNITS = {
    "relaxed": "relaxed", "pressure": "pressure_Pa", "mean": "mean_convergence_m", "largest": "largest_displacement_m",
    "crown": "crown_m", "invert": "invert_m", "horizontal": "horizontal_m", "vertical": "vertical_m",
    "yielded_area": "yielded_area_m2", "plastic_radius_ratio": "plastic_radius_ratio", "reach": "yielded_reach_m",
    "settlement": "settlement_m", "lining_pressure": "lining_pressure_Pa", "largest_thrust": "largest_thrust_N_per_m",
    "largest_moment": "largest_moment_Nm_per_m", "largest_bolt_force": "largest_bolt_force_N_per_m",
    "steps": "steps", "unbalanced": "unbalanced_ratio", "criterion": "criterion", "stage": "stage",
    "opening": "excavation",
}  # fmt: skip
"""Names of what is read at every increment, in result.json."""

DILATION_GAP = math.radians(15.0)
MEANINGS = {kind.kind: kind.meaning for kind in (StrengthReduction, LoadIncrease, GravityIncrease)}


def assemble(
    case: TunnelCase,
    digging: Digging,
    reaction: Progress | None,
    records: Mapping[str, MethodRecord],
) -> dict[str, Any]:
    """Everything but what every run tells."""
    now = digging.progress
    model = digging.ground.model
    rows = [_row(row) for row in now.rows]
    curve = now.rows if reaction is None else reaction.rows
    factors = [_factor(record) for record in records.values() if record.fine]
    return {
        "workflow": case.workflow,
        "title": case.title,
        "kind_of_result": "static: quasi-static relaxation, times have no physical meaning",
        "particles": model.particles,
        "stress_points": model.stress_points,
        "spacing_m": digging.ground.particles.spacing,
        "wall_spacing_m": digging.wall_spacing(digging.dug) if digging.dug else None,
        "dimension": 2,
        "excavations": _openings(digging),
        "stages": rows,
        "ground_reaction": [_row(row) for row in curve],
        "ground_reaction_supported": reaction is None and _supported(digging),
        "linings": _linings(digging),
        "bolts": _bolts(digging),
        "collapse": _collapse(now),
        "reaction_collapse": None if reaction is None else _collapse(reaction),
        "factors": factors,
        "steps": now.steps
        + (0 if reaction is None else reaction.steps)
        + sum(t.steps for record in records.values() for t in record.fine),
        "seed": case.seed,
        "tolerance": case.tolerance,
        "notices": [text.removesuffix(".") for text in (*case.notices, *digging.ground.particles.messages)],
        "warnings": [
            text.removesuffix(".")
            for text in (
                *case.questions,
                *_warnings(case, digging, factors),
                *_lining_warnings(digging, records),
            )
        ],
        "digest": digest(digging, reaction, records),
    }


def _supported(digging: Digging) -> bool:
    return any(built.kind != "far" for built in digging.built)


def _row(row: Mapping[str, Any]) -> dict[str, Any]:
    return {UNITS[key]: value for key, value in row.items()}


def _openings(digging: Digging) -> dict[str, Any]:
    """The last row of every opening."""
    return {row["opening"]: _row(row) for row in digging.progress.rows}


def _collapse(progress: Progress) -> dict[str, Any] | None:
    if progress.collapse is None:
        return None
    found = vars(progress.collapse)
    return {
        "stage": found["stage"], "excavation": found["opening"], "relaxed_stable": found["stable"],
        "relaxed_failed": found["failed"], "pressure_stable_Pa": found["pressure_stable"],
        "pressure_failed_Pa": found["pressure_failed"], "criterion": found["criterion"],
        "meaning": "the opening does not stand with less than this of the forces of the excavated ground",
    }  # fmt: skip


def _linings(digging: Digging) -> list[dict[str, Any]]:
    known = {entry.name: entry for entry in digging.plan.linings}
    found = []
    for built, support in zip(digging.built, digging.progress.support, strict=True):
        if built.kind != "lining":
            continue
        lining = known[built.name]
        forces = lining_forces(built, support, lining.thickness)
        found.append(
            {
                "name": lining.name,
                "excavation": lining.opening,
                "largest_thrust_N_per_m": float(forces.thrust.max()),
                "smallest_thrust_N_per_m": float(forces.thrust.min()),
                "largest_moment_Nm_per_m": float(np.abs(forces.moment).max(initial=0.0)),
                "largest_compression_Pa": forces.largest_compression,
                "largest_tension_Pa": max(forces.largest_tension, 0.0),
                "compressive_utilisation": _share(forces.largest_compression, lining.compressive_strength),
                "tensile_utilisation": _share(max(forces.largest_tension, 0.0), lining.tensile_strength),
            }
        )
    return found


def _share(value: float, strength: float) -> float | None:
    return None if math.isinf(strength) else value / strength


def _bolts(digging: Digging) -> list[dict[str, Any]]:
    known = {entry.name: entry for entry in digging.plan.bolts}
    found = []
    for built, support in zip(digging.built, digging.progress.support, strict=True):
        if built.kind != "bolts":
            continue
        bolts = known[built.name]
        force = support[built.reading["bar"], 0] * bolts.spacing
        found.append(
            {
                "name": bolts.name,
                "bolts": len(bolts.bars),
                "largest_force_N": float(force.max()),
                "yield_force_N": bolts.yield_force,
                "utilisation": float(np.abs(force).max() / bolts.yield_force),
                "yielded_pieces": int((support[built.reading["bar"], 1] != 0.0).sum()),
                "slipping_grout_pieces": int((support[built.reading["grout"], 1] != 0.0).sum()),
                "pieces": len(force),
            }
        )
    return found


def _factor(record: MethodRecord) -> dict[str, Any]:
    now = bracket(record.fine)
    decided = {t.factor: t.criterion for t in record.fine}
    return {
        "kind": record.kind,
        "meaning": MEANINGS[record.kind],
        "value": now.value,
        "stable": now.stable,
        "failed": now.failed,
        "undecided": list(now.undecided),
        "criterion": "; ".join(
            f"{word} at {factor:.5g}: {decided[factor]}"
            for word, factor in (("stable", now.stable), ("failed", now.failed))
            if factor is not None
        ),
        "trials": [t.as_dict() for t in record.fine],
        "finished": record.done,
    }


def _warnings(case: TunnelCase, digging: Digging, factors: Sequence[Mapping[str, Any]]) -> list[str]:
    found = [
        f"material.{m.name}: dilation angle {math.degrees(m.dilation_angle):.3g} deg is far below the friction angle "
        f"{math.degrees(m.friction_angle):.3g} deg: yielded zone and displacement depend on the mesh"
        for m in case.materials.values()
        if m.friction_angle - m.dilation_angle > DILATION_GAP
    ]
    now = digging.progress
    if now.collapse is not None:
        c = now.collapse
        found.append(
            f"{c.opening} does not stand: no rest beyond {100.0 * c.stable:.4g} % of relaxation in stage {c.stage!r}"
        )
    if digging.initial.settled:
        found.append(f"{100.0 * digging.initial.settled:.2g} % of the ground yielded before anything was dug")
    undecided = sum("neither at rest" in row["criterion"] for row in now.rows)
    if undecided:
        found.append(f"{undecided} increments ended neither at rest nor growing: finer increments may help")
    for row in _linings(digging):
        for kind in ("compressive", "tensile"):
            used = row[f"{kind}_utilisation"]
            if used is not None and used > 1.0:
                found.append(
                    f"lining {row['name']}: {used:.3g} times its {kind} strength; it was taken as elastic"
                )
    for row in _bolts(digging):
        if row["yielded_pieces"] or row["slipping_grout_pieces"]:
            found.append(
                f"{row['name']}: {row['yielded_pieces']} of {row['pieces']} pieces yielded, "
                f"{row['slipping_grout_pieces']} slipped in their grout"
            )
    for entry in factors:
        if not entry["finished"]:
            found.append(f"{entry['kind']}: the search was stopped before its bracket was closed; resume it")
        elif entry["failed"] is None:
            found.append(f"{entry['kind']}: nothing failed up to a factor of {entry['stable']:g}")
        elif entry["stable"] is None:
            found.append(
                f"{entry['kind']}: no stable state was found down to a factor of {entry['failed']:g}"
            )
        if entry["undecided"]:
            listed = ", ".join(f"{factor:.4g}" for factor in entry["undecided"])
            found.append(f"{entry['kind']}: undecided at {listed}; the bracket includes them")
    return found


def _lining_warnings(digging: Digging, records: Mapping[str, MethodRecord]) -> list[str]:
    """What a lining, elastic at any thrust, bears at the last stable factor: the factor counts on it."""
    found = []
    known = {entry.name: entry for entry in digging.plan.linings}
    for kind, record in records.items():
        if record.stable is None:
            continue
        place = 0
        for built in digging.built:
            support = record.stable.state.support[place : place + len(built.rows)]
            place += len(built.rows)
            if built.kind != "lining":
                continue
            lining = known[built.name]
            stress = lining_forces(built, support, lining.thickness).largest_compression
            used = _share(stress, lining.compressive_strength)
            times = "" if used is None else f", {used:.3g} times its strength"
            found.append(
                f"{kind}: the lining {built.name} stays elastic; at the last stable factor, "
                f"{record.stable.factor:.4g}, it bears a compression of {stress / 1e6:.3g} MPa{times}"
            )
    return found


def digest(digging: Digging, reaction: Progress | None, records: Mapping[str, MethodRecord]) -> str:
    """Hash of the bits of the answer."""
    now = digging.progress
    held: dict[str, Any] = {
        "mesh": digging.ground.model.positions,
        "stress": now.stress,
        "displacement": now.displacement,
        "support": {str(k): array for k, array in enumerate(now.support)},
        "rows": [[row["relaxed"], row["pressure"], row["mean"], row["steps"]] for row in now.rows],
        "trials": [
            [t.factor, t.verdict, t.steps, t.unbalanced, t.displacement]
            for record in records.values()
            for t in record.fine
        ],
    }
    if reaction is not None:
        held["reaction"] = reaction.displacement
    return checksum(held)
