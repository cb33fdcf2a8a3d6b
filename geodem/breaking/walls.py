"""Walls of a simulation taken away, everything else kept to the bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..boundaries.wall_pairs import WallPairs
from ..io.checkpoint import Tree
from ..particle_simulation import ParticleSimulation
from .snapshot import bring_back, keep

_OF_PAIRS = ("particle", "primitive", "touching", "history", "normal", "geometry", "feature")


def without_walls(simulation: ParticleSimulation, names: Sequence[str]) -> ParticleSimulation:
    """A simulation without some of its walls.

    Raises
    ------
    InputError
        There is no wall of that name.
    """
    s = simulation
    for name in names:
        s.walls.index(name)
    stay = np.array([wall.name not in names for wall in s.assembly.walls])
    tree = keep(s)
    walls = [tree["assembly"]["walls"][str(k)] for k in np.flatnonzero(stay)]
    tree["assembly"]["walls"] = {str(k): wall for k, wall in enumerate(walls)}
    state = tree["state"]
    state["bodies"] = state["bodies"][stay]
    arrays = state["arrays"]
    arrays["wall_parameters"] = wall_rows(arrays["wall_parameters"], stay)
    # one column at least, as of a scene without walls
    columns = np.flatnonzero(stay) if stay.any() else [0]
    arrays["wall_sums"] = np.ascontiguousarray(arrays["wall_sums"][:, columns])
    state["wall_pairs"] = _pairs(s, stay)
    state["plain"]["features"]["walls"] = bool(stay.any())
    return bring_back(tree)


def wall_rows(table: np.ndarray, stay: np.ndarray) -> np.ndarray:
    """Parameters of contacts, row material * walls + wall, of the walls that stay (w,) bool."""
    width = table.shape[1]
    if not stay.any():
        return np.zeros((1, width))
    return np.ascontiguousarray(table.reshape(-1, len(stay), width)[:, stay].reshape(-1, width))


def _pairs(s: ParticleSimulation, stay: np.ndarray) -> Tree:
    """Pairs of the walls that stay, their primitives numbered anew."""
    old = s.wall_pairs
    primitives = stay[s.walls.body]
    kept = primitives[old.primitive]
    row = np.concatenate([[0], np.cumsum(np.bincount(old.particle[kept], minlength=len(old.row) - 1))])
    new = WallPairs.allocate(row.astype(np.int64), chunk=old.chunk, history_width=old.history.shape[1])
    found: Tree = {name: getattr(old, name)[kept] for name in _OF_PAIRS}
    numbered = np.cumsum(primitives) - 1
    found["primitive"] = numbered[found["primitive"]].astype(old.primitive.dtype)
    return {**found, "row": new.row, "start": new.start}
