"""The halos of the chunks: every pair adds up in the right places, and everything is handed over once."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.neighbors import PairList, find_halo


def pair_list(particles, chunk, pairs):
    """A list of given pairs of rows, in random orientation, each under its lower row."""
    pairs = np.array(sorted(sorted(pair) for pair in pairs), dtype=np.int64).reshape(-1, 2)
    row = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=particles))])
    found = PairList.allocate(row, chunk=chunk, history_width=1)
    turned = np.random.default_rng(5).random(len(pairs)) < 0.5
    found.a[:] = np.where(turned, pairs[:, 1], pairs[:, 0])
    found.b[:] = np.where(turned, pairs[:, 0], pairs[:, 1])
    return found


def handed_over(pairs, halo, on_a, on_b):
    """What every row receives if a pair gives `on_a` to a and `on_b` to b, chunk by chunk as the kernels do it."""
    own = np.zeros(pairs.particles)
    outside = np.zeros(len(halo.source))
    chunks = len(pairs.start) - 1
    for chunk in range(chunks):
        base = chunk * pairs.chunk
        size = min(pairs.chunk, pairs.particles - base)
        load = np.zeros(size + halo.start[chunk + 1] - halo.start[chunk])
        for p in range(pairs.start[chunk], pairs.start[chunk + 1]):
            load[halo.local_a[p]] += on_a[p]
            load[halo.local_b[p]] += on_b[p]
        own[base : base + size] += load[:size]
        outside[halo.start[chunk] : halo.start[chunk + 1]] = load[size:]
    for chunk in range(chunks):
        for k in range(halo.into[chunk], halo.into[chunk + 1]):
            own[chunk * pairs.chunk + halo.target[k]] += outside[halo.source[k]]
    return own


@pytest.mark.parametrize(("particles", "chunk"), [(1, 4), (7, 16), (64, 16), (100, 16), (1000, 8)])
def test_every_pair_reaches_both_particles(particles, chunk):
    rng = np.random.default_rng(particles)
    first, second = rng.integers(0, particles, (2, 4 * particles))
    pairs = pair_list(
        particles, chunk, {(min(i, j), max(i, j)) for i, j in zip(first, second, strict=True) if i != j}
    )
    halo = find_halo(pairs)
    on_a, on_b = rng.integers(1, 100, (2, pairs.pairs)).astype(float)
    expected = np.bincount(pairs.a, on_a, particles) + np.bincount(pairs.b, on_b, particles)
    assert handed_over(pairs, halo, on_a, on_b).tolist() == expected.tolist()
    assert halo.across == (pairs.a // chunk != pairs.b // chunk).sum()


def test_what_a_chunk_takes_over_comes_from_chunks_before_it():
    pairs = pair_list(12, 4, [(0, 1), (0, 5), (2, 5), (3, 9), (6, 7), (6, 11)])
    halo = find_halo(pairs)
    # chunk 0 touches rows 5 (twice) and 9 of others, chunk 1 touches row 11
    assert halo.start.tolist() == [0, 2, 3, 3]
    assert halo.into.tolist() == [0, 0, 1, 3]
    assert halo.target.tolist() == [1, 1, 3]
    assert halo.lowest.tolist() == [0, 0, 0]
    assert halo.across == 4


def test_no_pairs():
    halo = find_halo(PairList.empty(10, chunk=4, history_width=1))
    assert halo.across == 0
    assert halo.lowest.tolist() == [0, 1, 2]
    assert len(halo.source) == 0
    assert find_halo(PairList.empty(0, chunk=4, history_width=1)).across == 0
