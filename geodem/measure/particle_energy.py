"""Energy account of discs or spheres in motion."""

from __future__ import annotations

from typing import NamedTuple


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
    initial: float  # kinetic energy and that of anchors at the start

    @property
    def supplied(self) -> float:
        """Everything put in since the start."""
        return self.initial + self.gravity + self.applied + self.driven + self.walls

    @property
    def found(self) -> float:
        """Everything that is there or was lost."""
        return self.kinetic + self.elastic + self.friction + self.damping + self.viscous + self.broken

    @property
    def imbalance(self) -> float:
        """What is found less what was supplied, over the largest of all terms [-]."""
        largest = max(abs(term) for term in self)
        return (self.found - self.supplied) / largest if largest > 0.0 else 0.0
