"""What changes while a plan is carried out, and its way into a checkpoint and back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Collapse:
    """Where an opening could not be brought to rest.

    Attributes
    ----------
    stage : str
    opening : str
    stable, failed : float
        Relaxed share at the last rest and at the first state without [-].
    pressure_stable, pressure_failed : float [Pa]
        Mean pressure on the wall there.
    criterion : str
    """

    stage: str
    opening: str
    stable: float
    failed: float
    pressure_stable: float
    pressure_failed: float
    criterion: str


@dataclass
class Progress:
    """All that changes while a plan is carried out: what a checkpoint holds.

    Arrays are those of the whole ground; `shares` and `pressures` are per opening.
    """

    stress: Floats  # (s, 4)
    displacement: Floats  # (n, 2)
    nodes: Floats  # (b, 2), displacements of the nodes of bolts
    support: list[Floats]  # (k, 3) of every support built
    kept: dict[int, Floats] = field(default_factory=dict)
    shares: dict[int, float] = field(default_factory=dict)
    pressures: dict[int, float] = field(default_factory=dict)
    installed: list[str] = field(default_factory=list)
    stage: int = 0
    increment: int = 0
    rows: list[dict[str, Any]] = field(default_factory=list)
    collapse: Collapse | None = None
    steps: int = 0

    @property
    def taken(self) -> list[int]:
        """Steps of every increment so far."""
        rows = [row for row in self.rows if row["opening"] == self.rows[0]["opening"]]
        return [int(row["steps"]) for row in rows if row["steps"] > 0]

    def to_tree(self) -> dict[str, Any]:
        """As a checkpoint tree."""
        return {
            "stress": self.stress,
            "displacement": self.displacement,
            "nodes": self.nodes,
            "support": {str(k): array for k, array in enumerate(self.support)},
            "kept": {str(k): array for k, array in self.kept.items()},
            "shares": {str(k): value for k, value in self.shares.items()},
            "pressures": {str(k): value for k, value in self.pressures.items()},
            "installed": list(self.installed),
            "stage": self.stage,
            "increment": self.increment,
            "rows": self.rows,
            "collapse": None if self.collapse is None else dict(vars(self.collapse)),
            "steps": self.steps,
        }

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> Progress:
        """From a checkpoint tree."""
        support = tree["support"]
        return cls(
            stress=tree["stress"],
            displacement=tree["displacement"],
            nodes=tree["nodes"].reshape(-1, 2),
            support=[support[str(k)].reshape(-1, 3) for k in range(len(support))],
            kept={int(k): array for k, array in tree["kept"].items()},
            shares={int(k): value for k, value in tree["shares"].items()},
            pressures={int(k): value for k, value in tree["pressures"].items()},
            installed=list(tree["installed"]),
            stage=int(tree["stage"]),
            increment=int(tree["increment"]),
            rows=[dict(row) for row in tree["rows"]],
            collapse=None if tree["collapse"] is None else Collapse(**tree["collapse"]),
            steps=int(tree["steps"]),
        )
