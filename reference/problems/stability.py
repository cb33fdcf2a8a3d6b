"""What geodem is put through and must survive: `python -m reference run stability`.

Every line is an attempt, or many of a kind, that either stays within a bound stated before it was run or must stop with
a message that names the particle, the step and the cause.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from . import (
    stability_abuse,
    stability_contrasts,
    stability_ground,
    stability_rest,
    stability_stops,
    stability_timestep,
)
from .stability_trial import Trial

PARTS: Sequence[Callable[[], list[Trial]]] = (
    stability_timestep.rows,
    stability_timestep.joints,
    *stability_contrasts.PARTS,
    *stability_abuse.PARTS,
    *stability_stops.PARTS,
    *stability_rest.PARTS,
    *stability_ground.PARTS,
)


def run() -> list[Trial]:
    """All of it."""
    return [row for part in PARTS for row in part()]
