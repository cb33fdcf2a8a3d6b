"""From a tunnel run to what its pictures need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .case.data import ImageSection
from .case.tunnel import TunnelCase
from .plotting.tunnel_views import BoltView, FailureView, LiningView, TunnelView
from .plotting.views import ReportView
from .record import MethodRecord
from .tunnelling.digging import Digging
from .tunnelling.ground import Standing, standing
from .tunnelling.measure import lining_forces, yielded
from .tunnelling.plan import UniformStress
from .tunnelling.progress import Progress
from .units import show

NEAR = 2.2
"""Half of the window around the openings, over their half size."""
FARTHEST = 4.5
"""Yielded ground and bolts beyond that many half sizes do not widen the window."""


def make_view(
    case: TunnelCase,
    digging: Digging,
    reaction: Progress | None = None,
    records: Mapping[str, MethodRecord] | None = None,
) -> TunnelView:
    """What the report and the check draw."""
    now = digging.progress
    stands = standing(digging.ground, digging.dug)
    stress = now.stress[stands.point]
    opening = digging.plan.openings[digging.dug[0] if digging.dug else 0]
    zone = yielded(stands.model, stress, 1.0, opening.centre)
    return TunnelView(
        ground=_ground_view(case, digging),
        positions=stands.model.positions,
        triangles=stands.model.triangles,
        displacement=now.displacement[stands.particle],
        strain=stands.model.particle_mean(stress)[:, 3],
        yielded=stands.model.particle_mean(zone.points.astype(np.float64)[:, None])[:, 0],
        openings=[
            (o.name, np.asarray(cut.polygon.exterior.coords))
            for o, cut in zip(digging.plan.openings, digging.ground.openings, strict=True)
        ],
        stress=_initial(case),
        rows=now.rows,
        reaction=[] if reaction is None else reaction.rows,
        linings=_linings(digging),
        bolts=_bolts(digging),
        failures=_failures(stands, records or {}),
        collapse=None if now.collapse is None else vars(now.collapse),
        window=_window(digging, stands, zone.points),
    )


def _initial(case: TunnelCase) -> dict[str, float]:
    if isinstance(case.initial, UniformStress):
        return {
            "horizontal": case.initial.horizontal, "vertical": case.initial.vertical, "shear": case.initial.shear,
        }  # fmt: skip
    return {"k0": case.initial.k0}


def _ground_view(case: TunnelCase, digging: Digging) -> ReportView:
    ground = digging.ground
    model = ground.model
    names = tuple(dict.fromkeys(ground.material_of))
    number = np.array([names.index(name) for name in ground.material_of], dtype=np.int64)
    loads = [
        f"{show(s.pressure, 'stress')} from ({s.start[0]:g}, {s.start[1]:g}) to ({s.end[0]:g}, {s.end[1]:g}) m"
        for s in case.surcharge
    ]
    return ReportView(
        title=case.title,
        case_text="",
        positions=model.positions,
        triangles=model.triangles,
        triangle_material=number[model.triangle_material],
        materials=names,
        supports=dict(case.boundary),
        loads=loads,
        image_path=case.section.image if isinstance(case.section, ImageSection) else None,
        spacing=ground.particles.spacing,
        surcharges=[(s.start, s.end, s.pressure) for s in case.surcharge],
    )


def _linings(digging: Digging) -> list[LiningView]:
    known = {entry.name: entry for entry in digging.plan.linings}
    positions = digging.ground.model.positions
    found = []
    for built, support in zip(digging.built, digging.progress.support, strict=True):
        if built.kind == "lining":
            thickness = known[built.name].thickness
            forces = lining_forces(built, support, thickness)
            found.append(
                LiningView(
                    built.name,
                    positions[built.chain],
                    thickness,
                    forces.thrust,
                    forces.thrust_at,
                    forces.moment,
                    forces.moment_at,
                )
            )
    return found


def _bolts(digging: Digging) -> list[BoltView]:
    known = {entry.name: entry for entry in digging.plan.bolts}
    found = []
    for built, support in zip(digging.built, digging.progress.support, strict=True):
        if built.kind == "bolts":
            bolts = known[built.name]
            force = support[built.reading["bar"], 0] * bolts.spacing
            found.append(
                BoltView(built.name, np.array(bolts.bars), built.at["bar"], force, bolts.yield_force)
            )
    return found


def _failures(stands: Standing, records: Mapping[str, MethodRecord]) -> list[FailureView]:
    count = len(stands.particle)
    return [
        FailureView(
            kind,
            record.failed.factor,
            stands.model.particle_mean(record.failed.state.stress)[:, 3],
            record.failed.state.displacement[:count],
        )
        for kind, record in records.items()
        if record.failed is not None
    ]


def _window(digging: Digging, stands: Standing, points: Any) -> tuple[float, float, float, float]:
    """The openings, the yielded ground and the supports with some room, within the section."""
    outline = np.concatenate([np.asarray(o.polygon.exterior.coords) for o in digging.ground.openings])
    low, high = outline.min(axis=0), outline.max(axis=0)
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    reach = np.full(2, NEAR * float(half.max()))
    at = [stands.model.positions[stands.model.point_particle[points]]]
    at += [np.array(bolts.bars).reshape(-1, 2) for bolts in digging.plan.bolts]
    for some in at:
        # what yields far away, a weak surface for one, does not make the openings small
        some = some[np.abs(some - centre).max(axis=1) < FARTHEST * float(half.max())]
        if len(some):
            reach = np.maximum(reach, 1.15 * np.abs(some - centre).max(axis=0))
    positions = digging.ground.model.positions
    left, bottom = np.maximum(centre - reach, positions.min(axis=0))
    right, top = np.minimum(centre + reach, positions.max(axis=0))
    return float(left), float(bottom), float(right), float(top)
