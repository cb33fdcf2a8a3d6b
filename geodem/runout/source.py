"""The part of a failed section that is handed over: who moves, and what it carries.

A particle owns a third of every triangle around it: the quadrilateral between it, the middles of two sides and the
centroid. The mass of such a share stands at its own centre of gravity and moves as the triangle does there, so that the
sums here are those of the ground and not of points on its surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..builders.ground import STANDARD_GRAVITY
from ..errors import InputError
from ..laws import GROUND_LAWS
from ..measure.slip_surface import moving_mass, triangle_areas
from ..model import Model
from ..state import State

Floats = NDArray[np.float64]

WHAT = ("failing", "section")
"""What may be handed over: the mass that failed, or all that the supports do not hold."""

INVERTED = 1e-3
"""Share of the section that may lie in triangles that the displacement turned inside out."""

HALVINGS = 10
"""Of the displacement at most. A search is one of small strains: how far a failing mass has gone in it says little."""


@dataclass(frozen=True, eq=False)
class Source:
    """Ground that is handed over, as stress-carrying particles hold it.

    Attributes
    ----------
    positions : (n, 2) [m]
        Of all particles of the model, displaced.
    triangles : (m, 3)
    triangle_material : (m,)
    materials : tuple of str
    moving : (n,) bool
        Who is handed over.
    velocity : (n, 2) [m/s]
        Of all particles; that of who stays does not count.
    material_mass : (k,) [kg/m]
        Of what moves, by material.
    area : float [m2]
    mass : float [kg/m]
    centre : (2,) [m]
        Centre of gravity.
    momentum : (2,) [kg/s]
        Linear, per metre of length.
    angular_momentum : float [kg m/s]
        About the centre of gravity, per metre of length.
    kinetic, elastic : float [J/m]
    potential : float [J/m]
        Above the lowest moving particle, at the gravity that acts.
    datum : float [m]
    gravity : float [m/s2]
    slip_surface : (j, 2) [m]
        Before the displacement; empty where nothing parts.
    taken : float
        Share of the displacement of the state that is taken along [-]: less than one where it would turn triangles of
        the model inside out.
    """

    positions: Floats
    triangles: NDArray[np.int32]
    triangle_material: NDArray[np.int32]
    materials: tuple[str, ...]
    moving: NDArray[np.bool_]
    velocity: Floats
    material_mass: Floats
    area: float
    mass: float
    centre: Floats
    momentum: Floats
    angular_momentum: float
    kinetic: float
    elastic: float
    potential: float
    datum: float
    gravity: float
    slip_surface: Floats
    taken: float = 1.0

    @property
    def energy(self) -> float:
        """Potential, kinetic and elastic energy together [J/m]."""
        return self.potential + self.kinetic + self.elastic

    @property
    def height(self) -> float:
        """Height of what moves [m]."""
        return float(np.ptp(self.positions[self.moving, 1]))

    @property
    def downhill(self) -> float:
        """1 where the moving mass faces higher x, -1 where it faces lower x."""
        place = self.positions[self.moving]
        top = place[:, 0][place[:, 1] > place[:, 1].max() - 0.2 * self.height]
        foot = place[:, 0][place[:, 1] < place[:, 1].min() + 0.2 * self.height]
        return 1.0 if float(foot.mean()) >= float(top.mean()) else -1.0


def failed_source(
    model: Model,
    state: State,
    densities: Sequence[float],
    *,
    gravity: float = STANDARD_GRAVITY,
    what: str = "failing",
    velocity: Floats | None = None,
) -> Source:
    """What a failed state hands over.

    Parameters
    ----------
    model : Model
        Its loads are not taken along.
    state : State
        Of a failed trial.
    densities : (k,) float
        Of the model's materials [kg/m3].
    gravity : float
        [m/s2]
    what : str
        ``"failing"``: the largest connected mass that moves, as `moving_mass` tells it. ``"section"``: every particle
        that is not held.
    velocity : (n, 2) float, optional
        [m/s]; at rest where it is left out. Those of a search are no velocities: its inertia is scaled.

    Raises
    ------
    InputError
        Nothing moves.
    """
    if what not in WHAT:
        raise InputError("what", "there is no such choice", f"Give one of {', '.join(WHAT)}.", value=what)
    strain = model.particle_mean(state.stress[:, 3:4])[:, 0]
    found = moving_mass(model.positions, model.triangles, state.displacement, strain)
    moving = np.asarray(found.moving if what == "failing" else ~model.held.any(axis=1), dtype=np.bool_)
    if not moving.any():
        raise InputError(
            "runout", "nothing moves in this state", "Hand over a failed trial of a strength reduction."
        )
    positions, share = _displaced(model, state.displacement)
    owner, heavy, where = _shares(model, densities)
    own = moving[owner]
    mass, place = heavy[own], where(positions)[own]
    field = np.zeros_like(positions) if velocity is None else np.asarray(velocity, dtype=np.float64)
    speed = where(field)[own]
    total = float(mass.sum())
    centre = (mass[:, None] * place).sum(axis=0) / total
    arm = place - centre
    datum = float(positions[moving, 1].min())
    kinds = np.repeat(model.triangle_material, 3)
    return Source(
        positions=positions,
        triangles=model.triangles,
        triangle_material=model.triangle_material,
        materials=model.material_names,
        moving=moving,
        velocity=field,
        material_mass=np.bincount(kinds, np.where(own, heavy, 0.0), len(model.material_names)).astype(float),
        area=float(model.particle_area[moving].sum()),
        mass=total,
        centre=centre,
        momentum=(mass[:, None] * speed).sum(axis=0),
        angular_momentum=float((mass * (arm[:, 0] * speed[:, 1] - arm[:, 1] * speed[:, 0])).sum()),
        kinetic=0.5 * float((mass * (speed**2).sum(axis=1)).sum()),
        elastic=_elastic(model, state.stress, moving[model.point_particle]),
        potential=total * gravity * float(centre[1] - datum),
        datum=datum,
        gravity=gravity,
        slip_surface=found.slip_surface,
        taken=share,
    )


def released_velocity(
    model: Model, state: State, densities: Sequence[float], moving: NDArray[np.bool_], released: float
) -> Floats:
    """Velocities (n, 2) [m/s] that point as the particles of a failing trial move and hold a given kinetic energy.

    A search damps what true inertia would keep: of the work of gravity, what is neither elastic nor plastic.

    Parameters
    ----------
    model : Model
    state : State
    densities : (k,) float
        [kg/m3]
    moving : (n,) bool
    released : float
        Kinetic energy [J/m].
    """
    owner, heavy, where = _shares(model, densities)
    own = moving[owner]
    square = float((heavy[own] * (where(state.velocity)[own] ** 2).sum(axis=1)).sum())
    if not (square > 0.0 and released > 0.0):
        return np.zeros_like(state.velocity)
    return np.asarray(state.velocity * np.sqrt(2.0 * released / square), dtype=np.float64)


def _shares(
    model: Model, densities: Sequence[float]
) -> tuple[NDArray[np.int32], Floats, Callable[[Floats], Floats]]:
    """Owner (3 m,) and mass (3 m,) [kg/m] of every share, and what takes values (n, 2) to their centres (3 m, 2)."""
    area = np.repeat(triangle_areas(model.positions, model.triangles) / 3.0, 3)
    heavy = area * np.asarray(densities, dtype=np.float64)[np.repeat(model.triangle_material, 3)]

    def where(values: Floats) -> Floats:
        corner = values[model.triangles]
        # the quadrilateral's centre of gravity in the corners: 11/18, 7/36, 7/36
        return np.asarray(
            (corner * 5.0 / 12.0 + corner.sum(axis=1, keepdims=True) * 7.0 / 36.0).reshape(-1, 2)
        )

    return model.triangles.ravel(), heavy, where


def _elastic(model: Model, stress: Floats, own: NDArray[np.bool_]) -> float:
    """Elastic energy [J/m] of the chosen stress points."""
    law = GROUND_LAWS[model.law]
    moduli = np.array([law.elastic_moduli(p) for p in model.parameters])[model.point_material]
    density = law.elastic_energy(moduli[:, 0], moduli[:, 1], stress[:, 0], stress[:, 1], stress[:, 2])
    return float((density * model.point_area)[own].sum())


def _displaced(model: Model, displacement: Floats) -> tuple[Floats, float]:
    """Places (n, 2) [m], and the share of the displacement in them: halved until hardly a triangle is inside out."""
    share = 1.0
    for _ in range(HALVINGS):
        positions = model.positions + share * displacement
        a, b, c = (positions[model.triangles[:, k]] for k in range(3))
        signed = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        if float(np.abs(signed[signed <= 0.0]).sum()) <= INVERTED * float(np.abs(signed).sum()):
            return positions, share
        share *= 0.5
    return model.positions.copy(), 0.0
