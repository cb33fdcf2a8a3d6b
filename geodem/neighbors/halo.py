"""The halo of every chunk: particles of other chunks that its pairs touch.

A pair across two chunks is computed once, by the chunk that lists it; what it does to the other chunk's particle is
added up in a place of that particle in the halo, and handed over when all chunks are done.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from .pair_list import PairList

prange = range

GROUPS = 16
"""Parts that are searched at the same time; each has one number for every particle."""


@dataclass(frozen=True)
class Halo:
    """Where pairs add up their forces, and who takes them over.

    Attributes
    ----------
    local_a, local_b : (p,) uint32
        Place of a pair's two particles in its chunk: first the chunk's own, in the order of their rows, then its halo.
    start : (chunks + 1,) int64
        First place of every chunk in the halo of all, h places.
    into : (chunks + 1,) int64
        First entry of every chunk that takes over, in `source` and `target`.
    source : (h,) int64
        Place in the halo of all.
    target : (h,) uint32
        Place of the particle in the chunk that owns it. A chunk takes over in the order of the chunks it takes from.
    lowest : (chunks,) int64
        The first chunk from which a chunk takes over, or itself. None comes after it: pairs are listed under the
        lower row.
    across : int
        Pairs across chunks.
    """

    local_a: NDArray[np.uint32]
    local_b: NDArray[np.uint32]
    start: NDArray[np.int64]
    into: NDArray[np.int64]
    source: NDArray[np.int64]
    target: NDArray[np.uint32]
    lowest: NDArray[np.int64]
    across: int

    @property
    def nbytes(self) -> int:
        """Memory [bytes]."""
        arrays = (self.local_a, self.local_b, self.start, self.into, self.source, self.target, self.lowest)
        return sum(array.nbytes for array in arrays)


def find_halo(pairs: PairList) -> Halo:
    """The halo of every chunk of a pair list."""
    chunks = len(pairs.start) - 1
    local_a = np.empty(pairs.pairs, dtype=np.uint32)
    local_b = np.empty(pairs.pairs, dtype=np.uint32)
    found = np.empty(pairs.pairs, dtype=np.uint32)
    count = np.zeros(chunks, dtype=np.int64)
    across = np.zeros(chunks, dtype=np.int64)
    kernel = _kernel()
    kernel.number_halo(
        pairs.particles, pairs.chunk, pairs.start, pairs.a, pairs.b, local_a, local_b, found, count, across
    )
    start = np.zeros(chunks + 1, dtype=np.int64)
    np.cumsum(count, out=start[1:])
    into = np.zeros(chunks + 2, dtype=np.int64)
    source = np.empty(int(start[-1]), dtype=np.int64)
    target = np.empty(int(start[-1]), dtype=np.uint32)
    lowest = np.arange(chunks)
    kernel.list_takers(pairs.chunk, pairs.start, found, start, into, source, target, lowest)
    return Halo(local_a, local_b, start, into[:-1], source, target, lowest, int(across.sum()))


@cache
def _kernel() -> ModuleType:
    return _jit.compile_kernel([number_halo, list_takers], {"GROUPS": GROUPS}, parallel=True)


def number_halo(particles, chunk, pair_start, pair_a, pair_b, local_a, local_b, found, count, across):
    """Number the other chunks' particles in the order in which a chunk's pairs meet them.

    Overwritten: local_a, local_b (p,); found (p,) uint32: rows of the halo, from where the chunk's pairs begin; count,
    across (chunks,): particles in the halo and pairs across.
    """
    chunks = len(pair_start) - 1
    for group in prange(GROUPS):
        first = group * chunks // GROUPS
        last = (group + 1) * chunks // GROUPS
        if first == last:
            continue
        # listed under the lower row: other chunks' particles come after the first chunk's
        begin = first * chunk
        number = np.zeros(particles - begin, np.int32)
        meets = np.full(particles - begin, -1, np.int32)
        for part in range(first, last):
            base = np.int64(part * chunk)
            size = min(chunk, particles - base)
            place = pair_start[part]
            halo = 0
            crossing = 0
            # without a sign, so that no index can count from the end
            for p in range(np.uint64(pair_start[part]), np.uint64(pair_start[part + 1])):
                a = np.int64(pair_a[p])
                b = np.int64(pair_b[p])
                other = max(a, b)
                there = other - base
                if there >= size:
                    crossing += 1
                    k = np.uint64(other - begin)
                    if meets[k] != part:
                        meets[k] = part
                        number[k] = halo
                        found[np.uint64(place + halo)] = other
                        halo += 1
                    there = size + number[k]
                own = min(a, b) - base
                local_a[p] = own if a < b else there
                local_b[p] = there if a < b else own
            count[part] = halo
            across[part] = crossing


def list_takers(chunk, pair_start, found, start, into, source, target, lowest):
    """Who takes over what is added up in the halo: into (chunks + 2,) zeros, source, target (h,), overwritten.

    lowest (chunks,): lowered.
    """
    chunks = len(pair_start) - 1
    for part in range(chunks):
        for k in range(start[part + 1] - start[part]):
            into[found[pair_start[part] + k] // chunk + 2] += 1
    for part in range(chunks):
        into[part + 2] += into[part + 1]
    for part in range(chunks):
        for k in range(start[part + 1] - start[part]):
            row = found[pair_start[part] + k]
            owner = row // chunk
            lowest[owner] = min(lowest[owner], part)
            place = into[owner + 1]
            source[place] = start[part] + k
            target[place] = row - owner * chunk
            into[owner + 1] = place + 1
