"""The first pair list, with the bonds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .images import Lattice
from .pair_list import PairList
from .search import rebuild

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def bond_pairs(
    rows: Floats,
    ids: NDArray[np.int64] | NDArray[np.int32],
    bonds: NDArray[np.int64] | NDArray[np.int32],
    histories: Floats,
    *,
    offset: int,
    chunk: int,
    buffer: float,
    dimension: int,
    history_width: int,
    multilevel: bool = True,
    cell: Lattice | None = None,
) -> PairList:
    """Make the first list: all near pairs, and every bond however long it is.

    Parameters
    ----------
    rows, ids, chunk, buffer, dimension, history_width, multilevel, cell
        As of `rebuild`.
    bonds : (b, 2)
        Particle ids of every bond; bond k gets the number k + 1.
    histories : (b, Hb)
        What each bond remembers at first.
    offset : int
        First column of the bonds' own history in that of the pairs.

    Raises
    ------
    InputError
        Where a bond joins a particle to itself, or two bonds join the same particles.
    """
    first = _bond_list(rows, ids, bonds, histories, offset=offset, chunk=chunk, history_width=history_width)
    return rebuild(
        rows, ids, first,
        chunk=chunk, buffer=buffer, dimension=dimension, history_width=history_width, multilevel=multilevel,
        cell=cell,
    )  # fmt: skip


def _bond_list(
    rows: Floats,
    ids: NDArray[np.int64] | NDArray[np.int32],
    bonds: NDArray[np.int64] | NDArray[np.int32],
    histories: Floats,
    *,
    offset: int,
    chunk: int,
    history_width: int,
) -> PairList:
    """A list of nothing but the bonds."""
    row_of = np.empty(len(rows), dtype=np.int64)
    row_of[ids] = np.arange(len(rows))
    ordered = np.sort(np.asarray(bonds, dtype=np.int64).reshape(-1, 2), axis=1)
    _check_bonds(ordered)
    a = row_of[ordered[:, 0]]
    b = row_of[ordered[:, 1]]
    under = np.minimum(a, b)
    bond = np.lexsort((np.maximum(a, b), under))
    under = under[bond]
    row = np.concatenate([[0], np.cumsum(np.bincount(under, minlength=len(rows)))])
    pairs = PairList.allocate(row, chunk=chunk, history_width=history_width)
    pairs.a[:] = a[bond]
    pairs.b[:] = b[bond]
    pairs.bond[:] = bond + 1
    pairs.touching[:] = 0
    pairs.far = len(a)
    pairs.history[:] = 0.0
    pairs.history[:, offset : offset + histories.shape[1]] = histories[bond]
    return pairs


def _check_bonds(ordered: Integers) -> None:
    itself = np.flatnonzero(ordered[:, 0] == ordered[:, 1])
    if len(itself):
        raise InputError(
            f"bonds[{itself[0]}]", "a bond joins a particle to itself", "Name two particles",
            value=ordered[itself[0]].tolist(),
        )  # fmt: skip
    unique, count = np.unique(ordered, axis=0, return_counts=True)
    if len(unique) < len(ordered):
        pair = unique[np.argmax(count > 1)]
        number = int(np.flatnonzero((ordered == pair).all(axis=1))[1])
        raise InputError(
            f"bonds[{number}]", "a second bond joins the same two particles", "Leave one of them out",
            value=pair.tolist(),
        )  # fmt: skip
