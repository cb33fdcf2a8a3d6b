"""The stress in the ground before anything is dug."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..integrators.direct_solve import solve_elastic, stiffness
from ..simulation import ElasticState, Simulation
from .ground import TunnelGround, internal_forces, strength
from .plan import DepthStress, UniformStress

Floats = NDArray[np.float64]

BEYOND_YIELD = 0.02
"""Share of the ground that may lie outside its strength before it is settled: corners of slopes, not whole layers."""

PLACE = "initial_stress"


class InitialState(NamedTuple):
    """Stress of the whole ground, at rest, and the loads that go with it.

    Attributes
    ----------
    stress : (s, 3) [Pa], tension positive
    load : (n, 2) [N/m]
        Surcharges, and the tractions of a uniform stress on sides that are free or far.
    settled : float
        Share of the ground that yielded on the way to rest [-].
    """

    stress: Floats
    load: Floats
    settled: float = 0.0


def initial_state(ground: TunnelGround, initial: UniformStress | DepthStress) -> InitialState:
    """Stress at rest before anything is dug.

    Raises
    ------
    InputError
        The stress is beyond what the ground's strength can bear.
    """
    if isinstance(initial, UniformStress):
        return _uniform(ground, initial)
    return _with_depth(ground, initial)


def _uniform(ground: TunnelGround, initial: UniformStress) -> InitialState:
    model = ground.model
    stress = np.tile([-initial.horizontal, -initial.vertical, -initial.shear], (model.stress_points, 1))
    _require_strength(ground, stress, initial)
    # constant stress asks nothing of a particle inside, and its traction of one on a side
    load = np.where(model.held, 0.0, internal_forces(model, stress)) + model.load
    return InitialState(stress, load)


def _with_depth(ground: TunnelGround, initial: DepthStress) -> InitialState:
    model = ground.model
    matrix = stiffness(model)
    external = model.weight + model.load
    _, stress = solve_elastic(model, external, matrix=matrix)
    stress[:, 0] = initial.k0 * stress[:, 1]
    _require_strength(ground, stress, initial)
    missing = np.where(model.held, 0.0, external - internal_forces(model, stress))
    if np.abs(missing).max() > 1e-9 * np.abs(external).max():
        stress = stress + solve_elastic(model, missing, matrix=matrix)[1]
    radius, allowed = strength(model, stress)
    share = _share(ground, radius > allowed * (1.0 + 1e-9))
    if share == 0.0:
        return InitialState(stress, model.load)
    simulation = Simulation(model, energy=False, elastic=ElasticState(np.zeros_like(external), stress, 1.0))
    simulation.relax(1e-6)
    return InitialState(simulation.state.stress[:, :3].copy(), model.load, share)


def _require_strength(ground: TunnelGround, stress: Floats, initial: UniformStress | DepthStress) -> None:
    """Refuse a stress that the ground cannot bear: it would flow before anything is dug."""
    radius, allowed = strength(ground.model, stress)
    beyond = radius > allowed * (1.0 + 1e-6)
    share = _share(ground, beyond)
    if share <= BEYOND_YIELD:
        return
    worst = int(np.argmax(np.where(beyond, radius - allowed, -np.inf)))
    material = ground.material_of[ground.model.point_material[worst]]
    x, y = ground.model.positions[ground.model.point_particle[worst]]
    problem = (
        f"this stress is beyond the strength of {100.0 * share:.3g} % of the ground before anything is dug: at "
        f"({x:.4g}, {y:.4g}) m in {material!r} half the difference of the principal stresses is {radius[worst]:.4g} "
        f"Pa, and the strength allows {max(allowed[worst], 0.0):.4g} Pa"
    )
    if isinstance(initial, DepthStress):
        raise InputError(
            f"{PLACE}.k0", problem,
            "Give a k0 between (1 - sin phi)/(1 + sin phi) and its inverse, nearer to 1 in clay, or more cohesion.",
            value=initial.k0,
        )  # fmt: skip
    raise InputError(
        PLACE, problem, "Bring horizontal and vertical nearer to each other, or check the strength."
    )


def _share(ground: TunnelGround, chosen: NDArray[np.bool_]) -> float:
    area = ground.model.point_area
    return float(area[chosen].sum() / area.sum())


def loaded(ground: TunnelGround, state: InitialState) -> TunnelGround:
    """The ground with the loads of its initial state."""
    return replace(ground, model=replace(ground.model, load=state.load))
