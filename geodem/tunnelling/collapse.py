"""The factor at which a tunnel collapses once it is dug: by strength reduction, by its loads or by gravity.

Without supports every trial starts from the elastic answer to the whole excavation, so that a tunnel that does not
stand has a factor too. With supports the ground starts as the stages left it. Strength reduction takes the ground's
strength alone: supports keep theirs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..integrators.direct_solve import solve_elastic
from ..simulation import ElasticState, Simulation
from ..stability.criteria import Criteria
from ..stability.methods import make_method
from ..stability.search import Search
from .digging import Digging

FIRST_STEP = 0.3


def make_search(digging: Digging, kind: str, *, tolerance: float, start: float = 1.0) -> Search:
    """A search for the factor of a tunnel whose stages are done.

    Parameters
    ----------
    digging : Digging
        Run to its end, or to its collapse where it has no supports.
    kind : str
        One of `geodem.tunnelling.plan.METHODS`.
    tolerance : float
        Width of [stable, failed] over its middle.
    start : float
        First factor.
    """
    supported = any(built.kind != "far" for built in digging.built)
    simulation = _as_left(digging) if supported else _elastic(digging)
    return Search(
        simulation,
        make_method(kind, simulation),
        Criteria(),
        tolerance=tolerance,
        start=start,
        step=FIRST_STEP,
    )


def _as_left(digging: Digging) -> Simulation:
    scene = digging.scene()
    now, stands = digging.progress, scene.standing
    old = scene.simulation.elastic
    scene.simulation.elastic = replace(old, stress=now.stress[stands.point, :3])
    scene.simulation.set_kept(digging.external(stands))
    return scene.simulation


def _elastic(digging: Digging) -> Simulation:
    """The elastic answer of the ground to all excavations at once, internal pressures kept."""
    scene = digging.scene()
    stands = scene.standing
    simulation, model = scene.simulation, scene.standing.model
    external = digging.external(stands, shares=dict.fromkeys(digging.dug, 0.0))
    moved, change = solve_elastic(model, external - simulation.kept, matrix=simulation.matrix)
    stress = digging.initial.stress[stands.point] + change
    support = None
    if model.links is not None:
        from ..integrators.direct_solve import link_operator

        support = np.zeros((model.links.number, 3))
        support[:, 0] = model.links.table[:, 0] * (link_operator(model) @ moved.ravel())
    simulation.elastic = ElasticState(
        np.zeros_like(moved), stress, simulation.mean_size(moved) or 1e-9, support
    )
    simulation.set_kept(external)
    return simulation
