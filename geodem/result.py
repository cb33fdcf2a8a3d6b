"""The content of result.json from what an analysis knows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._jit import threads_allowed
from .analysis import Analysis
from .case import Case
from .io.checkpoint import checksum
from .provenance import versions
from .record import MethodRecord
from .stability.bracket import bracket
from .stability.methods import GravityIncrease, StrengthReduction
from .stability.search import Snapshot

DILATION_GAP = math.radians(15.0)
"""Dilation this far below friction makes the factor depend on mesh and damping."""


def assemble(analysis: Analysis) -> dict[str, Any]:
    """Everything that result.json holds, but what other methods say.

    Parameters
    ----------
    analysis : Analysis
        Finished, or stopped on its way.
    """
    case, model, particles = analysis.case, analysis.model, analysis.particles
    assert model is not None
    assert particles is not None
    records = list(analysis.records.values())
    factors = [factor_entry(record) for record in records]
    energy_of = next((record.failed for record in records if record.failed is not None), None)
    first = analysis.seconds_to_first_step
    return {
        "workflow": case.workflow,
        "title": case.title,
        "status": "done" if analysis.done() else "stopped",
        "kind_of_result": "static: quasi-static relaxation, times have no physical meaning",
        "particles": model.particles,
        "stress_points": model.stress_points,
        "spacing_m": particles.spacing,
        "dimension": 2,
        "factors": factors,
        "steps": sum(t.steps for r in records for t in (*r.coarse, *r.fine, *r.zero_dilation)),
        "wall_time_s": round(analysis.wall_seconds(), 3),
        "compile_time_s": round(analysis.compiled_seconds(), 3),
        "seconds_to_first_step": None if first is None else round(first, 3),
        "threads": threads_allowed(),
        "seed": case.seed,
        "tolerance": case.tolerance,
        "energy": {} if energy_of is None else energy_entry(energy_of),
        "cracks": {"tension": 0, "shear": 0},
        "reference": None
        if case.reference is None
        else {"factor": case.reference.factor, "source": case.reference.source},
        "versions": versions(),
        "spacing_where_it_failed": analysis.focus,
        "notices": _listed(*case.notices, *particles.messages, *_focus_notice(analysis.focus)),
        "warnings": _listed(*case.questions, *dilation_warnings(case), *bracket_warnings(factors)),
        "digest": _digest(particles.positions, records),
    }


def factor_entry(record: MethodRecord) -> dict[str, Any]:
    """One entry of result.json's factors."""
    now = bracket(record.fine)
    method = StrengthReduction if record.kind == StrengthReduction.kind else GravityIncrease
    decided = {t.factor: t.criterion for t in record.fine}
    criterion = "; ".join(
        f"{word} at {factor:.5g}: {decided[factor]}"
        for word, factor in (("stable", now.stable), ("failed", now.failed))
        if factor is not None
    )
    entry: dict[str, Any] = {
        "kind": record.kind,
        "meaning": method.meaning,
        "value": now.value,
        "stable": now.stable,
        "failed": now.failed,
        "undecided": list(now.undecided),
        "criterion": criterion,
        "trials": [t.as_dict() for t in (*record.coarse, *record.fine)],
        "finished": record.done,
    }
    if record.zero_dilation:
        flat = bracket(record.zero_dilation)
        entry["zero_dilation"] = {
            "value": flat.value,
            "stable": flat.stable,
            "failed": flat.failed,
            "undecided": list(flat.undecided),
            "particles": record.zero_dilation[0].particles,
            "meaning": "the same with a dilation angle of zero; depends on the mesh",
        }
    return entry


def bracket_warnings(factors: list[dict[str, Any]]) -> list[str]:
    """What a reader must know of brackets that are open or hold undecided trials."""
    warnings = []
    for entry in factors:
        kind, stable, failed = entry["kind"], entry["stable"], entry["failed"]
        if not entry["finished"]:
            warnings.append(f"{kind}: the search was stopped before its bracket was closed; resume it")
        elif stable is None and failed is None:
            warnings.append(f"{kind}: no trial was decided")
        elif failed is None:
            warnings.append(f"{kind}: nothing failed up to a factor of {stable:g}")
        elif stable is None:
            warnings.append(f"{kind}: no stable state was found down to a factor of {failed:g}")
        if entry["undecided"]:
            text = ", ".join(f"{factor:.4g}" for factor in entry["undecided"])
            warnings.append(
                f"{kind}: undecided at {text} (neither at rest nor failing); the bracket includes them"
            )
    return warnings


def dilation_warnings(case: Case) -> list[str]:
    """Materials whose dilation is so far below their friction that the factor depends on the mesh."""
    return [
        f"material.{m.name}: dilation angle {math.degrees(m.dilation_angle):.3g} deg is far below the friction angle "
        f"{math.degrees(m.friction_angle):.3g} deg: the factor is mesh-dependent"
        for m in case.materials.values()
        if m.friction_angle - m.dilation_angle > DILATION_GAP
    ]


def energy_entry(snapshot: Snapshot) -> dict[str, float]:
    """The energy account of a failed trial, from its start [J per m of length]."""
    account = snapshot.energy
    return {
        "factor": snapshot.factor,
        "external_work_J_per_m": account.external_work,
        "elastic_J_per_m": account.elastic,
        "plastic_J_per_m": account.plastic,
        "damping_J_per_m": account.damping,
        "kinetic_J_per_m": account.kinetic,
        "closure": account.closure,
    }


def _listed(*texts: str) -> list[str]:
    """Sentences from many places, as entries of a list: without their full stops."""
    return [text.removesuffix(".") for text in texts]


def _focus_notice(focus: float) -> list[str]:
    if focus >= 1.0:
        return []
    return [
        f"particles are {1.0 / focus:.2g} times as fine where the coarse model failed as elsewhere; a given "
        "spacing instead of a number of particles keeps them uniform"
    ]


def _digest(positions: NDArray[np.float64], records: list[MethodRecord]) -> str:
    """Hash of the bits of the answer: mesh, every trial, last stable and first failed states."""
    decided = [
        [t.factor, t.verdict, t.steps, t.unbalanced, t.displacement]
        for record in records
        for t in (*record.coarse, *record.fine, *record.zero_dilation)
    ]
    states: Mapping[str, Any] = {
        f"{record.kind}-{name}": snapshot.state.arrays()
        for record in records
        for name, snapshot in (("stable", record.stable), ("failed", record.failed))
        if snapshot is not None
    }
    return checksum({"mesh": positions, "trials": decided, "states": states})
