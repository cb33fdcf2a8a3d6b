"""One row of what is read of an opening, after an increment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .ground import Standing
from .measure import convergence, lining_forces, mean_pressure, settlement, yielded
from .plan import DepthStress
from .supports import Built

if TYPE_CHECKING:
    from .digging import Digging

Floats = NDArray[np.float64]


def read_row(digging: Digging, stands: Standing, number: int, wall: NDArray[np.int64]) -> dict[str, Any]:
    """Convergence, yielded ground and forces in supports around the opening `number` with its wall (k, 2), SI."""
    now, positions, plan = digging.progress, digging.ground.model.positions, digging.plan
    opening = plan.openings[number]
    area = float(digging.ground.openings[number].polygon.area)
    zone = yielded(stands.model, now.stress[stands.point], area, opening.centre)
    # far below a surface there is none that could settle
    surface = isinstance(plan.initial, DepthStress)
    return {
        **convergence(positions, now.displacement, wall)._asdict(),
        "yielded_area": zone.area,
        "plastic_radius_ratio": zone.radius_ratio,
        "reach": zone.reach,
        "settlement": settlement(digging.ground, now.displacement) if surface else 0.0,
        **_supports(digging, opening.name, wall),
    }


def _supports(digging: Digging, opening: str, wall: NDArray[np.int64]) -> dict[str, float]:
    """Of the linings on the wall and of all bolts."""
    positions = digging.ground.model.positions
    linings = {entry.name: entry for entry in digging.plan.linings}
    pressure = thrust = moment = bolt = 0.0
    for built, support in zip(digging.built, digging.progress.support, strict=True):
        if built.kind == "lining" and linings[built.name].opening == opening:
            found = lining_forces(built, support, linings[built.name].thickness)
            thrust = max(thrust, float(found.thrust.max()))
            moment = max(moment, float(np.abs(found.moment).max(initial=0.0)))
            pressure += mean_pressure(positions, -_pull(built, support, positions), wall)
        elif built.kind == "bolts":
            bolt = max(bolt, float(np.abs(support[built.reading["bar"], 0]).max()))
    return {
        "lining_pressure": pressure,
        "largest_thrust": thrust,
        "largest_moment": moment,
        "largest_bolt_force": bolt,
    }


def _pull(built: Built, support: Floats, positions: Floats) -> Floats:
    """Forces (n, 2) [N/m] of the particles on a support's links."""
    force = np.zeros_like(positions)
    for row, state in zip(built.rows, support, strict=True):
        force[list(row.particles)] += state[0] * row.vectors
    return force
