"""Specimens: as large, as dense and as fine as they were asked to be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geodem.errors import InputError
from geodem.laboratory.specimen import SIZE_RATIO, SOLID_FRACTION, make_specimen


@pytest.mark.parametrize("dimension", [2, 3])
def test_random_prism_is_what_was_asked_for(dimension):
    found = make_specimen(dimension, width=0.05, across=10, seed=3)
    assert found.size.tolist() == [0.05] * (dimension - 1) + [0.1]
    assert found.across == pytest.approx(10.0, rel=0.01)
    assert found.radii.max() / found.radii.min() == pytest.approx(SIZE_RATIO, rel=0.03)
    volume = math.pi * found.radii**2 if dimension == 2 else 4.0 / 3.0 * math.pi * found.radii**3
    share = volume.sum() / np.prod(found.size)
    assert share == pytest.approx(SOLID_FRACTION[dimension], rel=0.01)
    assert found.area == pytest.approx(0.05 ** (dimension - 1))
    # nothing bursts where a bond breaks
    pairs = cKDTree(found.positions).query_pairs(2.0 * found.radii.max(), output_type="ndarray")
    apart = np.linalg.norm(found.positions[pairs[:, 0]] - found.positions[pairs[:, 1]], axis=1)
    assert (apart >= (1.0 - 1e-12) * found.radii[pairs].sum(axis=1)).all()


def test_same_arguments_give_the_same_bits_and_another_seed_another_specimen():
    first, second = (make_specimen(2, across=12, seed=4) for _ in range(2))
    other = make_specimen(2, across=12, seed=5)
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.radii, second.radii)
    assert first.seed == 4
    assert not np.array_equal(first.positions, other.positions)


@pytest.mark.parametrize(
    ("dimension", "packing", "neighbours"), [(2, "square", 4), (2, "triangular", 6), (3, "fcc", 12)]
)
def test_lattice_lies_in_the_middle_and_has_its_neighbours(dimension, packing, neighbours):
    found = make_specimen(dimension, width=1.0, across=10, packing=packing)
    assert found.seed is None
    assert found.positions.min(axis=0) + found.positions.max(axis=0) == pytest.approx(found.size)
    tree = cKDTree(found.positions)
    around = [len(near) - 1 for near in tree.query_ball_point(found.positions, 1.001 * found.diameter)]
    assert max(around) == neighbours


def test_cylinder_is_round_and_a_disc_stands_on_its_rim():
    cylinder = make_specimen(3, width=1.0, across=10, shape="cylinder")
    away = np.linalg.norm(cylinder.positions[:, :2] - 0.5, axis=1)
    assert away.max() < 0.5
    assert cylinder.area == pytest.approx(0.25 * math.pi)
    assert cylinder.height == 2.0
    disc = make_specimen(3, width=1.0, across=10, shape="disc")
    assert disc.size.tolist() == [1.0, 0.5, 1.0]
    assert np.linalg.norm(disc.positions[:, [0, 2]] - 0.5, axis=1).max() < 0.5
    flat = make_specimen(2, width=1.0, across=10, shape="disc")
    assert flat.size.tolist() == [1.0, 1.0]
    # as much as the square without its corners
    square = make_specimen(2, width=1.0, height=1.0, across=10)
    assert flat.particles == pytest.approx(0.25 * math.pi * square.particles, rel=0.1)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"dimension": 4}, "dimension"),
        ({"dimension": 2, "packing": "fcc"}, "packing"),
        ({"dimension": 2, "shape": "cylinder"}, "shape"),
        ({"dimension": 2, "width": -1.0}, "width"),
        ({"dimension": 2, "height": math.nan}, "height"),
        ({"dimension": 3, "across": 5.0}, "too coarse"),
        ({"dimension": 3, "across": math.nan}, "across"),
        ({"dimension": 2, "seed": -1}, "seed"),
    ],
)
def test_what_cannot_be_is_refused_by_name(arguments, word):
    with pytest.raises(InputError, match=word):
        make_specimen(**arguments)
