"""A simulation as a tree of arrays and plain data, and back to the same bits: to keep a state and go on from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..io.checkpoint import Tree
from ..io.particle_checkpoint import assembly_from, assembly_tree
from ..particle_simulation import ParticleSimulation
from ..particle_state import state_tree

PLACE = "a kept state"


def keep(simulation: ParticleSimulation) -> Tree:
    """Assembly and state, as copies that no further step changes."""
    kept: Tree = _copied({"assembly": assembly_tree(simulation.assembly), "state": state_tree(simulation)})
    return kept


def bring_back(tree: Mapping[str, Any]) -> ParticleSimulation:
    """The simulation of a tree; the tree can be used again.

    Raises
    ------
    InputError
        Its parts do not belong together.
    """
    own = _copied(tree)
    return ParticleSimulation.of_state(assembly_from(own["assembly"], PLACE), own["state"], PLACE)


def _copied(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, Mapping):
        return {name: _copied(part) for name, part in value.items()}
    return value
