"""Cracks: bonds that broke, how, when, where and between which materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..io.checkpoint import Tree
from ..particle_reading import ParticleReading

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TENSION, SHEAR = 1, 2
MODES = {TENSION: "tension", SHEAR: "shear"}


@dataclass(frozen=True, eq=False)
class Cracks:
    """Every break, in the order of steps and then of the bonds' numbers.

    Attributes
    ----------
    bond : (k,) int64
        Number of the bond in the scene.
    mode : (k,) int64
        1 tension, 2 shear.
    step : (k,) int64
    time : (k,) [s]
    place : (k, d) [m]
    materials : (k, 2) int64
        Of the two particles, the lower number first.
    """

    bond: Integers
    mode: Integers
    step: Integers
    time: Floats
    place: Floats
    materials: Integers

    @property
    def count(self) -> int:
        """Number of cracks."""
        return len(self.mode)

    def where(self, mask: NDArray[np.bool_] | Integers) -> Cracks:
        """Those of a mask (k,), or of numbers in their order."""
        return Cracks(**{part.name: getattr(self, part.name)[mask] for part in fields(Cracks)})

    def by_mode(self) -> dict[str, int]:
        """Their number by mode."""
        return {name: int((self.mode == mode).sum()) for mode, name in MODES.items()}

    @classmethod
    def joined(cls, parts: Sequence[Cracks]) -> Cracks:
        """All of several."""
        whole = {
            part.name: np.concatenate([getattr(each, part.name) for each in parts]) for part in fields(Cracks)
        }
        return cls(**whole).where(np.lexsort((whole["bond"], whole["step"])))

    def tree(self) -> Tree:
        """As a checkpoint tree."""
        return {part.name: getattr(self, part.name).copy() for part in fields(Cracks)}

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> Cracks:
        """Of a checkpoint tree."""
        return cls(**{part.name: tree[part.name] for part in fields(Cracks)})


def cracks_of(simulation: ParticleReading, number: Integers) -> Cracks:
    """Of a simulation; `number` (b,) of its bonds in the scene."""
    found = simulation.broken_bonds()
    pairs = simulation.assembly.bonds[found.bond]
    materials = np.sort(simulation.assembly.material[pairs], axis=1).astype(np.int64)
    return Cracks(
        number[found.bond], found.mode, found.step, found.time, found.place, materials.reshape(-1, 2)
    )
