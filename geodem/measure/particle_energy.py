"""Energy account of discs or spheres in motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class ParticleEnergy(NamedTuple):
    """Where the work went [J] (2D: J per m).

    Kinetic energy is m v(n-1/2).v(n+1/2)/2, elastic energy that of the positions at n; of a linear system a leap-frog
    keeps their sum exactly.
    """

    kinetic: float
    elastic: float  # contacts, bonds and anchors
    friction: float  # lost in contacts: slip, and springs let go when they part
    damping: float  # local and mass-proportional damping
    viscous: float  # dashpots of contacts and bonds
    broken: float  # released by bonds that broke
    gravity: float  # work of gravity
    applied: float  # work of applied forces
    driven: float  # work of held freedoms that move
    walls: float  # work of walls that move
    cell: float  # work of the periodic cell that deforms
    initial: float  # kinetic energy and that of anchors at the start

    @property
    def supplied(self) -> float:
        """Everything put in since the start."""
        return self.initial + self.gravity + self.applied + self.driven + self.walls + self.cell

    @property
    def found(self) -> float:
        """Everything that is there or was lost."""
        return self.kinetic + self.elastic + self.friction + self.damping + self.viscous + self.broken

    @property
    def imbalance(self) -> float:
        """What is found less what was supplied, over the largest of all terms [-]."""
        largest = max(abs(term) for term in self)
        return (self.found - self.supplied) / largest if largest > 0.0 else 0.0


class HalfStep(NamedTuple):
    """Work of the last forces on the second half of their step [J]: steps count it, the energies are those before."""

    damping: float
    driven: float


def half_step_ahead(
    force: Floats,
    given: Floats,
    inertia: Floats,
    held: NDArray[np.bool_],
    before: Floats,
    after: Floats,
    *,
    time_step: float,
    local_damping: float,
    global_damping: float,
) -> HalfStep:
    """What damping took and held freedoms gave on the way of half a step, from forces at its beginning.

    Parameters
    ----------
    force, given : (n, d + s) [N, N m]
        Resultants of the last step, and what weight and applied forces have in them.
    inertia : (n, d + s) [kg, kg m2]
    held : (n, d + s) bool
    before, after : (n, d + s) [m/s, rad/s]
        Velocities half a step before and after the forces.
    """
    way = 0.5 * time_step * after
    drag = local_damping * np.abs(force) * np.sign(before) + 0.5 * global_damping * inertia * (before + after)
    return HalfStep(
        damping=float((drag * way)[~held].sum()), driven=-float(((force - given) * way)[held].sum())
    )
