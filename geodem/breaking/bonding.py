"""Which pairs of the ground's particles are bonded, and how strongly."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..builders.assembly_builder import AssemblyBuilder
from ..builders.body_filling import BodyFilling
from ..builders.close_pairs import close_pairs
from ..errors import InputError
from ..laboratory.material import BondedMaterial
from .materials import Interface, SceneMaterial, pair_range, pair_scatter

Integers = NDArray[np.int64]


class BondCount(NamedTuple):
    """Pairs between two materials.

    Attributes
    ----------
    bonds : int
    contacts : int
        Pairs that touch, or nearly (within a thousandth of the sum of their radii), bonded ones included.
    """

    bonds: int
    contacts: int


def bond_ground(
    build: AssemblyBuilder,
    filling: BodyFilling,
    ids: Integers,
    materials: Mapping[str, SceneMaterial],
    interfaces: Sequence[Interface],
    *,
    across: float,
    seed: int,
) -> tuple[dict[tuple[str, str], BondCount], Integers]:
    """Bond the particles of a filling pair of materials by pair of materials.

    Returns
    -------
    counts : dict of (str, str) to BondCount
        Of pairs of materials that meet.
    loose : (l,) int64
        Numbers in the assembly of particles of bonded materials without a bond.
    """
    if not (np.isfinite(across) and across >= 0.0):
        raise InputError("across", "this is not a number from 0", "Give 1, or 0: not bonded", value=across)
    names = filling.materials
    special = {one.pair: one for one in interfaces}
    widest = max((m.bonding_range for m in materials.values() if isinstance(m, BondedMaterial)), default=1.0)
    pairs, distance = close_pairs(filling.positions, filling.radii, lambda a, b: max(widest, 1.001) * (a + b))
    ratio = distance / filling.radii[pairs].sum(axis=1)
    kind = np.sort(filling.material[pairs], axis=1)
    apart = filling.group[pairs[:, 0]] != filling.group[pairs[:, 1]]
    degree = np.zeros(filling.particles, dtype=np.int64)
    counts: dict[tuple[str, str], BondCount] = {}
    for number, (i, j) in enumerate(itertools.combinations_with_replacement(range(len(names)), 2)):
        mine = (kind[:, 0] == i) & (kind[:, 1] == j)
        if not mine.any():
            continue
        one, other = materials[names[i]], materials[names[j]]
        key = min(names[i], names[j]), max(names[i], names[j])
        limit = pair_range(one, other)
        interface = special.get(key)
        if interface is not None and not interface.bonded:
            limit = 0.0
        chosen = mine & (ratio <= limit * (1.0 + 1e-12))
        if across == 0.0:
            chosen &= ~apart
        near = int((mine & (ratio <= 1.001)).sum())
        counts[key] = BondCount(int(chosen.sum()), near)
        if not chosen.any():
            continue
        assert isinstance(one, BondedMaterial)
        assert isinstance(other, BondedMaterial)
        scale = _scale(pair_scatter(one, other), int(chosen.sum()), seed + 1000 * number)
        if interface is not None:
            scale = scale * interface.strength
        scale = np.where(apart[chosen] & (across > 0.0), across * scale, scale)
        build.bond(ids[pairs[chosen]], scale=scale)
        degree += np.bincount(pairs[chosen].ravel(), minlength=filling.particles)
    able = np.array([isinstance(materials[name], BondedMaterial) for name in names])
    return counts, ids[(degree == 0) & able[filling.material]]


def _scale(material: BondedMaterial, count: int, seed: int) -> NDArray[np.float64]:
    """Factors (count,) on the strength."""
    found = material.scatter(seed)
    return np.ones(count) if isinstance(found, float) else found.factors(count)
