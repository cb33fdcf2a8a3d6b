"""How fast a tool is for its ground: whether it presses chips off or hits them."""

from __future__ import annotations

import math
from dataclasses import dataclass

FEWEST_PASSAGES = 20.0
"""Passages of a compression wave through the depth, while the force rises to a peak, above which the ground is pressed
rather than hit."""

CALM = 0.3
"""Local damping above which it is told that mean forces grow with it: at 0.8 they are twice those at 0.3."""


@dataclass(frozen=True)
class Pace:
    """A tool's speed beside what the ground can follow.

    Ground that a face meets at a speed v answers with the stress rho c v at once; every passage of a compression wave
    through the depth adds about as much, so that a peak of stress s takes s/(rho c v) passages.

    Attributes
    ----------
    speed : float
        Of the tool [m/s].
    wave : float
        Of compression [m/s].
    density : float
        Of the ground, pores and all [kg/m3].
    """

    speed: float
    wave: float
    density: float

    @property
    def stress(self) -> float:
        """rho c v, that of ground which the tool meets at its speed [Pa]."""
        return self.density * self.wave * self.speed

    def passages(self, peak: float) -> float:
        """Of a wave through the depth until the stress rises to a peak [Pa]; nan without one."""
        return peak / self.stress if peak > 0.0 else math.nan

    def doubts(self, peak: float, damping: float) -> list[str]:
        """Words where a mean force depends on the speed or on the damping; `peak` [Pa] of force over depth."""
        found = []
        count = self.passages(peak)
        if count < FEWEST_PASSAGES:
            slow = float(f"{self.speed * count / FEWEST_PASSAGES:.1g}")
            found.append(
                f"The force rises to a peak within {count:.2g} passages of a compression wave through the depth: chips "
                "are hit off, and mean force and specific energy depend on the speed; peaks do so less. At "
                f"{slow:g} m/s it would be {FEWEST_PASSAGES:g} passages."
            )
        if damping > CALM:
            found.append(
                f"local_damping is {damping:g}: it resists what flies off and what flows, and mean forces grow with "
                f"it. Try {CALM:g} and less."
            )
        return found
