"""What result.json says of ground that went through its stages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._jit import compile_seconds
from .breaking.cracks import Cracks
from .breaking.search import Search
from .breaking.site import Site
from .breaking.stages import Stage
from .breaking_building import Works
from .case.breaking import BreakingCase
from .io.checkpoint import checksum
from .measure.fragments import find_fragments

FIRST_SHARE = 0.1
"""Share of the cracks of a failure that count as its first ones."""


@dataclass(frozen=True, eq=False)
class StageEnd:
    """A finished stage.

    Attributes
    ----------
    stage : Stage
    site : Site
        At its end, what later stages go on from.
    facts : dict
        What the stage tells, and "seconds".
    search : Search or None
        Of a stage that looks for a factor.
    """

    stage: Stage
    site: Site
    facts: dict[str, Any]
    search: Search | None = None


def assemble(case: BreakingCase, works: Works, ends: Sequence[StageEnd]) -> dict[str, Any]:
    """The content of result.json, but for what the run itself knows."""
    scene, site = works.scene, ends[-1].site
    s = site.simulation
    names = scene.assembly.material_names
    cracks = site.cracks()
    found = {
        "kind_of_result": "breaking ground: bonded particles in true, damped motion through stages",
        "particles": scene.assembly.particles,
        "particles_left": s.assembly.particles,
        "dimension": s.dimension,
        "bonds": len(scene.assembly.bonds),
        "bond_law": scene.assembly.bond_law,
        "contact_law": scene.assembly.contact_law,
        "bounds_m": scene.box.tolist(),
        "diameter_m": 2.0 * float(scene.filling.radii.mean()),
        "damping": case.damping,
        "time_step_s": s.time_step,
        "critical_time_step_s": s.critical_time_step,
        "steps": s.steps + sum(trial.steps for end in ends if end.search for trial in end.search.trials),
        "simulated_time_s": s.time,
        "factors": [_factor(end, works, names) for end in ends if end.search is not None],
        "stages": _stages(ends),
        "points": _points(case, site),
        "cracks": {**cracks.by_mode(), "by_materials": by_materials(cracks, works, names)},
        "fragments": _fragments(site),
        "walls": [
            {"name": name, "force_N": [_number(part) for part in force]}
            for name, force in site.wall_forces().items()
        ],
        "energy": _energy(site),
        "materials": _materials(works),
        "seed": case.seed,
        "compile_time_s": round(compile_seconds(), 3),
        "notices": list(case.notices),
        "warnings": [*case.questions, *works.scene.warnings, *_warnings(ends)],
        "digest": checksum({"positions": s.positions, "broken": cracks.bond}),
    }
    return found


def by_materials(cracks: Cracks, works: Works, names: Sequence[str]) -> list[dict[str, Any]]:
    """Cracks by the two materials that they part, with the share of their bonds that is broken."""
    a = works.scene.assembly
    all_pairs = np.sort(a.material[a.bonds], axis=1).reshape(-1, 2)
    rows = []
    for first, second in np.unique(all_pairs, axis=0):
        bonds = int((all_pairs == (first, second)).all(axis=1).sum())
        own = cracks.where((cracks.materials == (first, second)).all(axis=1))
        rows.append(
            {
                "materials": [names[first], names[second]], "bonds": bonds, **own.by_mode(),
                "share_broken": own.count / bonds,
            }
        )  # fmt: skip
    return rows


def first_cracks(search: Search, names: Sequence[str]) -> dict[str, Any]:
    """Where the lowest failed trial began to break: the first tenth of its new cracks, by materials and place."""
    if search.failed is None:
        return {}
    site = Site.from_tree(search.failed)
    start = min((row[2] for row in search.rows if row[1] == site.place[1]), default=0.0)
    cracks = site.cracks()
    new = cracks.where(cracks.step >= start)
    if not new.count:
        return {"new_cracks": 0}
    early = new.where(np.arange(new.count) < max(1, math.ceil(FIRST_SHARE * new.count)))
    pairs, counts = np.unique(early.materials, axis=0, return_counts=True)
    most = pairs[int(np.argmax(counts))]
    return {
        "new_cracks": new.count,
        **new.by_mode(),
        "first_in": [names[int(k)] for k in most],
        "first_share": float(counts.max() / early.count),
        "first_centre_m": early.place.mean(axis=0).tolist(),
        "centre_m": new.place.mean(axis=0).tolist(),
    }


def _factor(end: StageEnd, works: Works, names: Sequence[str]) -> dict[str, Any]:
    search = end.search
    assert search is not None
    found, method = search.bracket, search.plan.method
    deciding = [t for t in search.trials if t.factor in (found.stable, found.failed)]
    return {
        "kind": method.kind,
        "meaning": method.meaning,
        "stage": end.stage.name,
        "value": found.value,
        "stable": found.stable,
        "failed": found.failed,
        "undecided": list(found.undecided),
        "criterion": next((t.criterion for t in deciding if t.verdict == "failed"), ""),
        "cracks_when_stable": []
        if search.stable is None
        else by_materials(Site.from_tree(search.stable).cracks(), works, names),
        "failure": first_cracks(search, names),
        "trials": [{**trial.as_dict(), "seconds": round(trial.seconds, 3)} for trial in search.trials],
    }


def _stages(ends: Sequence[StageEnd]) -> list[dict[str, Any]]:
    rows = []
    steps, time, before = 0, 0.0, {"tension": 0, "shear": 0}
    for end in ends:
        s = end.site.simulation
        now = end.site.cracks().by_mode()
        rows.append(
            {
                "name": end.stage.name, "kind": end.stage.kind, "steps": s.steps - steps,
                "time_s": s.time - time, **end.facts,
                "new_cracks": {mode: now[mode] - before[mode] for mode in now},
            }
        )  # fmt: skip
        steps, time, before = s.steps, s.time, now
    return rows


def _points(case: BreakingCase, site: Site) -> list[dict[str, Any]]:
    where, ways = site.positions_of_all(), site.at_points()
    return [
        {
            "name": point.name,
            "at_m": site.origin[site.points[point.name]].tolist(),
            "displacement_m": [_number(part) for part in ways[point.name]],
            "since_settled_m": [_number(part) for part in (where - site.settled)[site.points[point.name]]],
        }
        for point in case.points
    ]


def _fragments(site: Site) -> dict[str, Any]:
    s = site.simulation
    a = s.assembly
    found = find_fragments(s.positions, a.radii, a.mass, a.bonds, s.intact())
    larger = ~found.single
    return {
        "pieces": int(larger.sum()),
        "single_particles": int(found.single.sum()),
        "largest_share_of_mass": float(found.mass[0] / a.mass.sum()),
        "median_size_m": _number(found.size_passing(0.5)),
    }


def _energy(site: Site) -> dict[str, float]:
    found = site.simulation.energy()
    return {**found._asdict(), "removed": site.energy_removed, "imbalance": found.imbalance}


def _materials(works: Works) -> list[dict[str, Any]]:
    return [
        {"name": share.name, "particles": share.particles, "source_size": share.source}
        for share in works.scene.filling.shares
    ]


def _warnings(ends: Sequence[StageEnd]) -> list[str]:
    words = []
    for end in ends:
        if end.facts.get("at_rest") is False and end.stage.kind not in ("run",):
            words.append(
                f"stage {end.stage.name!r}: the ground did not come to rest within the step limit; "
                "patience = 2 gives it twice as long."
            )
        if end.search is None:
            continue
        found = end.search.bracket
        if found.value is None:
            side = "failed" if found.failed is None else "stood"
            words.append(
                f"stage {end.stage.name!r}: no trial {side}, so the factor is known from one side only."
            )
        if found.undecided:
            listed = ", ".join(f"{factor:g}" for factor in found.undecided)
            words.append(
                f"stage {end.stage.name!r}: undecided at {listed}, neither stable nor failed; patience = 2 decides it "
                "more often than not."
            )
    return words


def _number(value: float) -> float | None:
    """A number as JSON holds it: nothing where there is none."""
    return float(value) if math.isfinite(value) else None
