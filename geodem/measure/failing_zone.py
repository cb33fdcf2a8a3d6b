"""Where a failed state does its plastic work: the zone that deserves the particles of a finer model."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model import Model
from ..state import State

WORK_SHARE = 0.9
"""The zone holds this share of the plastic shear strain (times area) of the failing trial."""

PARTICLE_SHARE = 0.6
"""Share of the particles that the zone is to get."""

FINEST = 0.3
"""Least spacing in the zone over the spacing elsewhere."""

WORTHWHILE = 0.85
"""Above this ratio of spacings a refinement changes nothing."""


class FailingZone(NamedTuple):
    """Part of a section and the spacing it should have over the spacing elsewhere [-]."""

    geometry: Any
    ratio: float


def failing_zone(model: Model, states: list[State]) -> FailingZone | None:
    """The zone that failed states of a model shear in, widened by one particle; None where nothing is gained.

    Parameters
    ----------
    model : Model
    states : list of State
        One failed state per method.

    Returns
    -------
    FailingZone or None
    """
    import shapely

    corner = model.positions[model.triangles]
    edge = corner - np.roll(corner, 1, axis=1)
    area = 0.5 * np.abs(edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    chosen = np.zeros(len(area), dtype=bool)
    for state in states:
        strain = model.particle_mean(state.stress[:, 3:4])[:, 0]
        chosen |= _densest(strain[model.triangles].mean(axis=1), area)
    if not chosen.any():
        return None
    width = float(np.sqrt(area[chosen].mean()))
    zone = shapely.union_all(shapely.polygons(corner[chosen])).buffer(width).simplify(0.3 * width)
    outline = shapely.union_all(shapely.polygons(corner))
    share = zone.intersection(outline).area / outline.area
    if share >= 1.0:
        return None
    ratio = float(np.sqrt(share * (1.0 - PARTICLE_SHARE) / (PARTICLE_SHARE * (1.0 - share))))
    return FailingZone(zone, max(ratio, FINEST)) if ratio < WORTHWHILE else None


def _densest(strain: NDArray[np.float64], area: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Triangles of highest strain that together hold the share of strain times area."""
    order = np.argsort(-strain, kind="stable")
    work = np.cumsum((strain * area)[order])
    chosen = np.zeros(len(area), dtype=bool)
    if work[-1] > 0.0:
        chosen[order[: int(np.searchsorted(work, WORK_SHARE * work[-1])) + 1]] = True
    return chosen
