"""What a factor does to the ground: the methods that a search can drive.

A gravity factor is a load factor, and so is that of a load. It equals the factor of safety only where friction is
zero or both are one.
"""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ..simulation import Simulation

Floats = NDArray[np.float64]


class Method(Protocol):
    """How a trial factor is applied, and how the ground moves from one factor to the next."""

    kind: ClassVar[str]
    meaning: ClassVar[str]
    limits: ClassVar[tuple[float, float]]

    def apply(self, simulation: Simulation, factor: float) -> None:
        """Set strength or loads to `factor`."""

    def stress_at(self, simulation: Simulation, stress: Floats, at: float, factor: float) -> Floats:
        """Starting stress (s, 3) [Pa] at `factor`, continued from an equilibrium at the factor `at`."""

    def settlement(self, simulation: Simulation, factor: float) -> float:
        """Displacement that failure is measured by at this factor [m]."""


class StrengthReduction:
    """c/F and tan(phi)/F, psi at most phi_F, tension cut by F.

    Reference: Zienkiewicz, Humpheson & Lewis 1975 (Geotechnique 25:671).
    """

    kind: ClassVar[str] = "strength-reduction"
    meaning: ClassVar[str] = "factor of safety: strength over the strength at which the ground fails"
    limits: ClassVar[tuple[float, float]] = (0.02, 200.0)

    def apply(self, simulation: Simulation, factor: float) -> None:
        """Divide the strength by `factor`."""
        simulation.set_strength(factor)

    def stress_at(self, simulation: Simulation, stress: Floats, at: float, factor: float) -> Floats:
        """Loads are the same at every factor: the stress is continued as it is."""
        return stress

    def settlement(self, simulation: Simulation, factor: float) -> float:
        """Mean elastic displacement under gravity [m]."""
        return simulation.elastic.mean_displacement


class GravityIncrease:
    """Gravity times the factor, strength kept. A load factor. Li, Tang, Zhu & Liang 2009 (Comput. Geotech. 36:1246)."""

    kind: ClassVar[str] = "gravity-increase"
    meaning: ClassVar[str] = (
        "load factor: gravity at which the ground fails over gravity; not a factor of safety"
    )
    limits: ClassVar[tuple[float, float]] = (0.02, 1000.0)

    def __init__(self, simulation: Simulation) -> None:
        # the elastic answer to gravity alone; surcharges do not grow
        loaded = simulation.model.load.any()
        self._unit = (
            simulation.solve(simulation.model.weight, simulation.matrix) if loaded else simulation.elastic
        )

    def apply(self, simulation: Simulation, factor: float) -> None:
        """Multiply gravity by `factor`."""
        simulation.set_gravity(factor)

    def stress_at(self, simulation: Simulation, stress: Floats, at: float, factor: float) -> Floats:
        """The elastic answer to the added gravity is solved, not relaxed; the yield condition then corrects it.

        Where supports hold the ground it is relaxed: they bear part of it.
        """
        if simulation.model.links is not None:
            return stress
        return stress + (factor - at) * self._unit.stress

    def settlement(self, simulation: Simulation, factor: float) -> float:
        """Mean elastic displacement under the increased gravity [m]."""
        return simulation.elastic.mean_displacement + (factor - 1.0) * self._unit.mean_displacement


class LoadIncrease:
    """Loads times the factor, gravity and strength kept: the bearing capacity over the load. A load factor."""

    kind: ClassVar[str] = "load-increase"
    meaning: ClassVar[str] = (
        "load factor: load at which the ground fails over the load given; not a factor of safety"
    )
    limits: ClassVar[tuple[float, float]] = (0.02, 1000.0)

    def __init__(self, simulation: Simulation) -> None:
        weightless = not simulation.model.weight.any()
        self._unit = (
            simulation.elastic if weightless else simulation.solve(simulation.model.load, simulation.matrix)
        )

    def apply(self, simulation: Simulation, factor: float) -> None:
        """Multiply the loads by `factor`."""
        simulation.set_load(factor)

    def stress_at(self, simulation: Simulation, stress: Floats, at: float, factor: float) -> Floats:
        """The elastic answer to the added load is solved, not relaxed; the yield condition then corrects it.

        Where supports hold the ground it is relaxed: they bear part of it.
        """
        if simulation.model.links is not None:
            return stress
        return stress + (factor - at) * self._unit.stress

    def settlement(self, simulation: Simulation, factor: float) -> float:
        """Mean elastic displacement under gravity and the increased loads [m]."""
        return simulation.elastic.mean_displacement + (factor - 1.0) * self._unit.mean_displacement


def make_method(kind: str, simulation: Simulation) -> Method:
    """The method of that name for one simulation."""
    if kind == GravityIncrease.kind:
        return GravityIncrease(simulation)
    if kind == LoadIncrease.kind:
        return LoadIncrease(simulation)
    return StrengthReduction()
