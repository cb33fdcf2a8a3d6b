"""Small forms of `reference run laboratory-elastic`: what it measures, and that a wrong specimen is told."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference.problems import laboratory_dice2d_beam as beam
from reference.problems import laboratory_elastic as elastic
from reference.problems.laboratory_dice2d_specimens import (
    RADIUS,
    Bonded,
    bonded,
    irregular,
    square,
    triangular,
)


def test_specimens_have_the_discs_of_the_text():
    # Zhao 2015, tables 2.6, 2.7 and 3.7; the text counts 779 where 40 rows of 20 and 19 are 780
    assert len(square(10, 10).radii) == 100
    assert len(triangular(10, 10).radii) == 95
    assert len(triangular(41, 5).radii) == 203
    large = triangular(20, 40)
    assert len(large.radii) == 780
    np.testing.assert_allclose(large.box, (400.0, 695.5), rtol=1e-5)


def test_discs_that_hang_on_one_bond_are_left_out():
    positions = np.array([(0.0, 0.0), (2.0, 0.0), (1.0, math.sqrt(3.0)), (4.0, 0.0), (6.0, 0.0)]) * RADIUS
    found = bonded(positions, np.full(5, RADIUS), np.array([1.0, 1.0]), 1.01)
    assert len(found.radii) == 3
    assert found.coordination == 2.0


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0])
def test_nu_of_discs_is_that_of_the_lattice(ratio):
    sample = triangular(20, 40)
    axial, across = elastic.by_points(sample, elastic.pressed_discs(sample, ratio).moved)
    assert -across / axial == pytest.approx((1.0 - ratio) / (3.0 + ratio), abs=0.005)
    box = square(6, 6)
    axial, across = elastic.by_points(box, elastic.pressed_discs(box, ratio).moved)
    assert abs(across) < 1e-12 * abs(axial)


def test_spheres_on_a_cube_axis():
    rows = elastic.face_centred((5, 5, 10), (0.2, 1.0))
    assert all(row.good for row in rows)
    # a cubic material with E 2, nu 0.3, pressed by 1 along z and pulled by 0.1 across
    strain = np.array([0.1 * 0.7 + 0.3, 0.1 * 0.7 + 0.3, -1.0 - 2 * 0.3 * 0.1]) / 2.0
    assert elastic.hooke(strain, np.array([0.1, 0.1, -1.0])) == pytest.approx((2.0, 0.3))


def test_many_bonds_make_an_irregular_specimen_like_the_triangular_one():
    lattice = 0.9 / 3.1  # (kn - ks)/(3 kn + ks) at ks/kn 0.1
    values = []
    for factor in (1.02, 1.5):
        sample = irregular(400.0, 800.0, factor, 1)
        across, axial = np.diag(elastic.gradient(sample.positions, elastic.pressed_discs(sample, 0.1)))
        values.append(-across / axial)
    # Zhao 2015, section 2.5.1: few bonds a disc go beyond 1/3, many bonds do as the triangular packing does
    assert values[0] > lattice + 0.1
    assert values[0] > 1.0 / 3.0
    assert values[1] == pytest.approx(lattice, abs=0.02)


def test_the_engine_presses_as_the_network_says():
    assert all(row.good for row in elastic.engine())


def test_a_beam_bends_as_its_strip_does():
    for ratio, width in ((0.0, 0.5), (0.2, 0.0), (0.2, 1.0)):
        assert all(row.good for row in beam.stiffnesses(beam.BOOK, ratio, width)), (ratio, width)
    # without shear springs discs do not turn, and the width of the bonds does nothing
    assert beam.stiffness(5, 0.0, 1.0) == beam.stiffness(5, 0.0, 0.0)
    # rows alone: n (n^2 - 1) h^3
    assert beam.height(5, 0.0, 0.0) == pytest.approx(120.0 ** (1.0 / 3.0) * math.sqrt(3.0) * RADIUS)


def test_a_beam_with_a_row_less_is_told():
    sample = triangular(41, 5)
    left, right, load, row = beam.ends_and_middle(sample)
    assert len(row) == 41
    top = sample.positions[:, 1] > sample.box[1] - 1.5 * RADIUS
    weaker = sample.pairs[~top[sample.pairs].all(axis=1)]
    held = np.zeros((203, 3), dtype=bool)
    held[left, :2] = held[right, 1] = True
    force = np.zeros(held.shape)
    force[load, 1] = -beam.LOAD
    cut = Bonded(sample.positions, sample.radii, weaker, sample.box)
    moved = beam.solve_network(cut.network(0.2, 0.2), force, held=held)
    assert beam.measured(cut, moved).largest > 1.5 * sum(beam.deflections(beam.BOOK, 800.0, 0.2, 0.2))
