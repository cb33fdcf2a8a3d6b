"""Packings that all codes are timed on: dense, at rest, the same every time."""

from __future__ import annotations

import numpy as np
import pytest

from reference import scene_packings, scenes


@pytest.mark.parametrize("n", [500, 8000])
def test_random_spheres_are_dense_at_rest_and_in_their_box(n):
    scene = scenes.spheres_in_a_box(n)
    assert scene.particles == n
    assert scene.box is not None
    fraction = 4.0 / 3.0 * np.pi * (scene.radii**3).sum() / np.prod(scene.box[1] - scene.box[0])
    assert 0.58 < fraction < 0.66
    pairs = scene.pairs()
    assert 2.7 * n < len(pairs) < 3.4 * n
    # centres inside; no sphere deep in another
    assert np.all(scene.positions > scene.box[0])
    assert np.all(scene.positions < scene.box[1])
    apart = np.linalg.norm(scene.positions[pairs[:, 0]] - scene.positions[pairs[:, 1]], axis=1)
    overlap = scene.radii[pairs].sum(1) - apart
    assert overlap.max() < 0.15 * scene.radii.min()
    # at rest but for gravity: what is left of the forces is small against the forces themselves
    left = (scene.velocities_at_start() - scene.velocities) * 2.0 / scene.time_step * scene.mass[:, None]
    left -= scene.mass[:, None] * np.array(scene.gravity)
    # the top layer has lost what was cut off to reach n
    inside = scene.positions[:, 2] < 0.9 * scene.box[1, 2]
    assert np.median(np.linalg.norm(left[inside], axis=1)) < 0.1 * scene.normal * np.median(overlap)


def test_a_seed_gives_one_packing():
    first, second = (scene_packings.random_spheres(300, seed=4).positions for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert np.abs(first - scene_packings.random_spheres(300, seed=5).positions).max() > 0.1


def test_the_lattice_has_the_gaps_it_is_said_to_have():
    # 6 pairs a site inside; a pair is there where both sites are filled: 6 * 0.95 a sphere
    positions = scene_packings.vacant_lattice(20_000)
    pairs = scene_packings.touching_pairs(positions, np.ones(len(positions)), 1e-6)
    count = np.bincount(pairs.ravel(), minlength=len(positions))
    middle = positions[:, :] - positions.mean(0)
    inside = np.abs(middle).max(1) < 0.8 * np.abs(middle).max()
    assert count[inside].mean() / 2.0 == pytest.approx(5.7, rel=0.01)


def test_hexagonal_discs_have_three_bonds_each_inside():
    scene = scenes.bonded_discs(2500)
    assert scene.bonds is not None
    assert len(scene.bonds.pairs) / scene.particles == pytest.approx(3.0, rel=0.05)
    assert not scene.positions[:, 2].any()
