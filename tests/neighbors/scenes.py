"""Random scenes, and what a search must find in them by comparing every particle with every other."""

from __future__ import annotations

import numpy as np

WIDTH = {2: 8, 3: 12}
RADIUS = {2: 2, 3: 3}


def random_rows(rng, particles, dimension, *, ratio=1.0, room=1.0, centre=0.0):
    """Rows with radii in [1, ratio] and about one diameter of the mean size, times `room`, for each particle."""
    radii = np.exp(rng.uniform(0.0, np.log(ratio) + 1e-12, particles))
    side = room * (np.sum((2.0 * radii) ** dimension)) ** (1.0 / dimension)
    return make_rows(centre + rng.uniform(0.0, side, (particles, dimension)), radii)


def make_rows(positions, radii):
    """Rows of the state with the columns that a search reads."""
    dimension = positions.shape[1]
    rows = np.full((len(positions), WIDTH[dimension]), np.nan)
    rows[:, :dimension] = positions
    rows[:, RADIUS[dimension]] = radii
    return rows


def near_pairs(rows, ids, dimension, buffer):
    """All pairs of ids with d < ra + rb + buffer, the lower id first."""
    positions = rows[:, :dimension]
    radii = rows[:, RADIUS[dimension]]
    first, second = np.triu_indices(len(rows), 1)
    with np.errstate(over="ignore"):
        distance = np.sqrt(np.sum((positions[first] - positions[second]) ** 2, axis=1))
    near = distance < radii[first] + radii[second] + buffer
    low = np.minimum(ids[first], ids[second])[near]
    high = np.maximum(ids[first], ids[second])[near]
    return set(zip(low.tolist(), high.tolist(), strict=True))


def memory(pairs, ids):
    """What the list says of every pair of ids."""
    known = {}
    for index in range(pairs.pairs):
        key = (int(ids[pairs.a[index]]), int(ids[pairs.b[index]]))
        value = (int(pairs.bond[index]), int(pairs.touching[index]), tuple(pairs.history[index].tolist()))
        assert known.setdefault(key, value) == value
    return known


def assert_well_formed(pairs, ids):
    """Every rule of `PairList` about order and sides."""
    particles = len(ids)
    assert pairs.row[0] == 0
    assert pairs.row[-1] == pairs.pairs == len(pairs.b) == len(pairs.bond) == len(pairs.touching)
    assert len(pairs.row) == particles + 1
    edges = [*range(0, particles, pairs.chunk), particles]
    assert pairs.start.tolist() == pairs.row[edges].tolist()
    under = pairs.listed_under()
    a = pairs.a.astype(np.int64)
    b = pairs.b.astype(np.int64)
    assert np.all((a == under) | (b == under))
    other = a + b - under
    assert np.all(other != under)
    assert np.all(other > under)
    assert np.all(ids[a] < ids[b])
    # ascending under every row, so that no pair is listed twice there
    assert np.all((np.diff(under) > 0) | (np.diff(other) > 0))


def write_memory(pairs, ids, rng, *, touching=None):
    """Put different values into every pair."""
    a = ids[pairs.a].astype(np.int64)
    b = ids[pairs.b].astype(np.int64)
    key = a * (int(ids.max()) + 1) + b
    unique, index = np.unique(key, return_inverse=True)
    pairs.bond[:] = (rng.permutation(len(unique)) * rng.integers(0, 2, len(unique)))[index]
    flags = rng.integers(0, 2, len(unique)) if touching is None else np.full(len(unique), touching)
    pairs.touching[:] = flags[index]
    pairs.history[:] = rng.normal(size=(len(unique), pairs.history.shape[1]))[index]
