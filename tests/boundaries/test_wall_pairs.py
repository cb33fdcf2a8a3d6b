"""The search finds what a comparison of all with all finds, and carries over what pairs remember."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.boundaries import walls
from geodem.boundaries.wall_pairs import find_wall_pairs
from geodem.boundaries.wall_table import wall_table
from geodem.kernels import wall_geometry
from tests.boundaries.wall_scene import particle_rows


def hills(count, rng):
    """A surface of 2 count^2 triangles over the unit square, heights at random."""
    x = np.linspace(0.0, 1.0, count + 1)
    corners = np.stack([*np.meshgrid(x, x), rng.uniform(0.0, 0.1, (count + 1, count + 1))], axis=-1)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def scene(dimension, rng, particles=300):
    if dimension == 3:
        facets = np.concatenate([hills(12, rng), [[(-1, -1, 2), (3, -1, 2), (-1, 3, 0.5)]]])
        bodies = [
            walls.triangles("hills", facets, spin=(0.3, 0.2, 0.9), velocity=(0.1, 0.2, 0.3)),
            walls.box("box", (0, 0, 0), (1, 1, 1)),
        ]
    else:
        points = np.stack([np.linspace(0, 1, 200), rng.uniform(0, 0.1, 200)], axis=1)
        bodies = [walls.segments("hills", points, spin=0.9), walls.box("box", (0, 0), (1, 1))]
    rows = particle_rows(
        dimension, rng.uniform(-0.3, 1.3, (particles, dimension)), rng.uniform(0.01, 0.1, particles)
    )
    table = wall_table(bodies, dimension)
    for _ in range(20):
        table.advance(0.01)
    return rows, table


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_are_those_of_all_with_all(dimension, monkeypatch):
    rows, table = scene(dimension, np.random.default_rng(dimension))
    monkeypatch.setattr(wall_geometry, "SPACE", dimension == 3)
    radius = 3 if dimension == 3 else 2
    expected = []
    for i, row in enumerate(rows):
        x, y, z = row[0], row[1], row[2] if dimension == 3 else 0.0
        for q in range(len(table.kind)):
            closest = wall_geometry.closest_on_wall(
                x, y, z, 0.0, table.shape, table.kind, table.bodies, q, table.body[q]
            )
            if closest[3] - row[radius] < 0.05:
                expected.append((i, q))
    pairs = find_wall_pairs(rows, table, buffer=0.05, chunk=32, history_width=2)
    found = list(zip(pairs.particle.tolist(), pairs.primitive.tolist(), strict=True))
    assert len(found) > 500
    assert found == expected
    assert pairs.start.tolist() == [
        int(np.searchsorted(pairs.particle, c)) for c in [*range(0, 300, 32), 300]
    ]
    assert (
        pairs.particle[pairs.row[:-1][np.diff(pairs.row) > 0]] == np.flatnonzero(np.diff(pairs.row))
    ).all()


def test_history_follows_particles_to_their_new_rows():
    rng = np.random.default_rng(5)
    rows, table = scene(3, rng)
    old = find_wall_pairs(rows, table, buffer=0.05, chunk=32, history_width=2)
    old.touching[:] = rng.integers(0, 2, len(old.touching))
    old.history[:] = rng.normal(size=old.history.shape)
    old.normal[:] = rng.normal(size=old.normal.shape)
    remembered = {
        (i, q): (t, *h, *n)
        for i, q, t, h, n in zip(
            old.particle, old.primitive, old.touching, old.history, old.normal, strict=True
        )
    }
    order = rng.permutation(len(rows))
    moved = rows[order]
    moved[:, :3] += rng.uniform(-0.03, 0.03, (len(rows), 3))
    new = find_wall_pairs(moved, table, buffer=0.05, chunk=16, history_width=2, old=old, old_row_of_new=order)
    kept = 0
    for i, q, t, h, n in zip(new.particle, new.primitive, new.touching, new.history, new.normal, strict=True):
        before = remembered.get((order[i], q))
        kept += before is not None
        assert (t, *h, *n) == (before or (0.0,) * 6)
    assert 0.5 * len(remembered) < kept < len(remembered)


def test_nothing_near_and_nothing_there():
    rows = particle_rows(3, [[0.0, 0.0, 5.0]], 0.1)
    table = wall_table([walls.plane("floor", (0, 0, 0), (0, 0, 1))], 3)
    for pairs in (
        find_wall_pairs(rows, table, buffer=0.1, chunk=8, history_width=3),
        find_wall_pairs(rows, wall_table([], 3), buffer=0.1, chunk=8, history_width=3),
        find_wall_pairs(rows[:0], table, buffer=0.1, chunk=8, history_width=3),
    ):
        assert len(pairs.particle) == 0
        assert pairs.history.shape == (0, 3)
        assert (pairs.start == 0).all()
