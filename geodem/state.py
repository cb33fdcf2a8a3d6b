"""State: the arrays that change while the ground deforms, with one table of their names, units and shapes."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .model import Model

Floats = NDArray[np.float64]


class Field(NamedTuple):
    """One line of the field table."""

    name: str
    unit: str
    shape: str
    meaning: str


FIELDS = (
    Field("displacement", "m", "(particles, 2)", "displacement from the elastic state under gravity"),
    Field("velocity", "m/step", "(particles, 2)", "displacement per relaxation step, half a step ahead"),
    Field(
        "force",
        "N/m",
        "(particles, 2)",
        "unbalanced force of the last step, reactions of held freedoms included",
    ),
    Field(
        "stress",
        "Pa, -",
        "(stress points, 4)",
        "in-plane stress xx, yy, xy (tension positive); plastic shear strain",
    ),
    Field("dissipation", "J/m3", "(stress points,)", "plastic work per volume"),
    Field(
        "support",
        "N/m or N, m or -, J/m",
        "(links, 3)",
        "force or moment of every link of a support, its plastic stretch, its plastic work",
    ),
)
"""Every array of the state: writers, checkpoints and documentation read this table."""


@dataclass
class State:
    """What changes. Arrays as in `FIELDS`; numbers besides."""

    displacement: Floats
    velocity: Floats
    force: Floats
    stress: Floats
    dissipation: Floats
    support: Floats
    start_work: float = 0.0  # external forces times the displacement at the start [J/m]
    start_elastic: float = 0.0  # elastic energy at the start [J/m]
    start_links: float = 0.0  # plastic work of the links at the start [J/m]
    damping: float = 0.0  # [1/step]
    damping_work: float = 0.0  # [J/m]
    steps: int = 0

    @classmethod
    def at_rest(cls, model: Model) -> State:
        """A stress-free state at rest."""
        n, s = model.particles, model.stress_points
        links = 0 if model.links is None else model.links.number
        return cls(
            np.zeros((n, 2)),
            np.zeros((n, 2)),
            np.zeros((n, 2)),
            np.zeros((s, 4)),
            np.zeros(s),
            np.zeros((links, 3)),
        )

    def copy(self) -> State:
        """An independent copy."""
        copies: dict[str, Any] = {name: array.copy() for name, array in self.arrays().items()}
        return replace(self, **copies)

    def arrays(self) -> dict[str, Floats]:
        """The arrays by name, in the order of `FIELDS`."""
        return {field.name: getattr(self, field.name) for field in FIELDS}

    def numbers(self) -> dict[str, float | int]:
        """The numbers by name."""
        return {
            field.name: getattr(self, field.name) for field in fields(self) if field.type in ("float", "int")
        }
