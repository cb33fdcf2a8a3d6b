"""The list of pairs that are near enough to touch before the next search, with what each pair remembers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass
class PairList:
    """Pairs of particles, each listed once: row i lists every near row j > i, in ascending order of j.

    Attributes
    ----------
    chunk : int
        Particles per chunk: chunk c owns rows [c chunk, min(n, (c + 1) chunk)).
    start : (chunks + 1,) int64
        First pair of every chunk.
    row : (n + 1,) int64
        First pair of every row.
    a, b : (p,) uint32
        Rows of the two particles; a is the one with the lower particle id.
    bond : (p,) int32
        1 + number of the intact bond; 0: none.
    touching : (p,) uint8
        1 while the pair touched in the last step.
    history : (p, H) float64
        What the laws remember of the pair.
    image : (p, d) int32
        In a periodic cell the image of b that is meant: how often each edge of the cell is to be added. No rows else.
    far : int
        Pairs listed though they are not near, because they are bonded or touch. The next search asks first for
        such pairs where there were some, and only then.
    """

    chunk: int
    start: NDArray[np.int64]
    row: NDArray[np.int64]
    a: NDArray[np.uint32]
    b: NDArray[np.uint32]
    bond: NDArray[np.int32]
    touching: NDArray[np.uint8]
    history: NDArray[np.float64]
    far: int = 0
    image: NDArray[np.int32] = field(default_factory=lambda: np.empty((0, 1), dtype=np.int32))

    @classmethod
    def empty(cls, particles: int, *, chunk: int, history_width: int) -> PairList:
        """A list without pairs for `particles` particles."""
        return cls.allocate(np.zeros(particles + 1, dtype=np.int64), chunk=chunk, history_width=history_width)

    @classmethod
    def allocate(cls, row: NDArray[np.int64], *, chunk: int, history_width: int) -> PairList:
        """A list with room for the pairs that `row` (n + 1,) counts; its pairs are yet to be written."""
        particles = len(row) - 1
        pairs = int(row[-1])
        edges = np.minimum(np.arange(chunks_of(particles, chunk) + 1) * chunk, particles)
        return cls(
            chunk=chunk,
            start=row[edges],
            row=row,
            a=np.empty(pairs, dtype=np.uint32),
            b=np.empty(pairs, dtype=np.uint32),
            bond=np.empty(pairs, dtype=np.int32),
            touching=np.empty(pairs, dtype=np.uint8),
            history=np.empty((pairs, history_width), dtype=np.float64),
        )

    @property
    def particles(self) -> int:
        """Number of particles, n."""
        return len(self.row) - 1

    @property
    def pairs(self) -> int:
        """Number of listed pairs, p."""
        return len(self.a)

    @property
    def nbytes(self) -> int:
        """Memory of the list [bytes]."""
        arrays: list[NDArray[Any]] = [
            self.start, self.row, self.a, self.b, self.bond, self.touching, self.history, self.image,
        ]  # fmt: skip
        return sum(array.nbytes for array in arrays)

    def listed_under(self) -> NDArray[np.int64]:
        """Row under which each pair is listed, (p,)."""
        return np.repeat(np.arange(self.particles), np.diff(self.row))

    def lookup(self, first: int, second: int) -> int:
        """Index of the pair of two rows, -1 where they are not a pair."""
        under, other = min(first, second), max(first, second)
        listed = slice(self.row[under], self.row[under + 1])
        found = np.flatnonzero((self.a[listed] == other) | (self.b[listed] == other))
        return int(self.row[under] + found[0]) if len(found) else -1


def chunks_of(particles: int, chunk: int) -> int:
    """Number of chunks that own `particles` rows."""
    return (particles + chunk - 1) // chunk
