"""The packing of the granite: nobody floats, only what touches is bonded, contacts as stiff as the paper's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference.problems.laboratory_granite import DISCS, WIDTH, Granite, Measured, elastic, material, rows
from reference.problems.laboratory_granite_packing import (
    TOUCHING,
    Cell,
    contact_factor,
    disc,
    packed,
    prism,
    touching,
    widest,
)


@pytest.fixture(scope="module")
def cell() -> Cell:
    return packed(2, WIDTH, 12.0, 1)


def test_cage_of_three_discs_is_filled():
    # discs of radius 1 around the origin at distance 3: room for a disc of radius 2 in the middle
    angles = np.radians([90.0, 210.0, 330.0])
    around = 3.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    shift, radius = widest(around - [0.3, -0.2], np.ones(3), 0.5, 2.0)
    assert shift == pytest.approx([-0.3, 0.2], abs=1e-6)
    assert radius == pytest.approx(2.0, rel=1e-6)


def test_packing_is_rigid_with_the_fewest_contacts_and_hardly_pressed(cell):
    pairs, distance = touching(cell.positions, cell.radii, cell.sides, TOUCHING)
    contacts = np.bincount(pairs.ravel(), minlength=len(cell.radii))
    # three contacts hold a disc in its place; a cage without walls on one side may hold one with two
    assert (contacts < 3).sum() <= 0.01 * len(contacts)
    assert cell.floaters > 0
    # 2 d contacts a particle make a frictionless packing rigid
    assert cell.coordination == pytest.approx(4.0, abs=0.15)
    overlap = cell.radii[pairs].sum(axis=1) - distance
    assert 0.0 < overlap.mean() < 1e-4 * cell.radii.mean()
    assert 2.0 * cell.radii.mean() * 12.0 == pytest.approx(WIDTH)


def test_disc_is_cut_from_the_middle(cell):
    found = disc(cell, 1)
    away = np.linalg.norm(found.positions - 0.5 * found.size, axis=1)
    assert away.max() < 0.5 * found.width
    assert found.particles == pytest.approx(0.125 * math.pi * len(cell.radii), rel=0.1)


@pytest.mark.parametrize(("dimension", "factor"), [(2, 1.0), (3, 4.0 / math.pi)])
def test_contacts_of_equal_grains_are_as_stiff_as_the_papers(dimension, factor):
    # 2 Ec t in series with itself is Ec t; 4 Ec R is 2 Ec R, the law has E pi R/2
    positions = np.zeros((2, dimension))
    positions[1, 0] = 2.0
    pair = Cell(positions + 1.0, np.ones(2), np.full(dimension, 20.0), 0, 1.0)
    assert contact_factor(pair) == pytest.approx(factor)


def test_contacts_that_open_make_it_softer_across(cell):
    specimen, granite = prism(cell, 1), material(DISCS, cell)
    young, poisson = elastic(specimen, granite, 1e-3)
    # both springs of every link bear along the axis, the cement alone across it
    assert 0.5 * 62e9 < young < 1.5 * 62e9
    assert 0.2 < poisson < 0.6


def test_rows_are_means_and_say_what_misses():
    one = Measured(4.0, 75e9, 0.31, 190e6, 215e6, 45e6, 30e6, 0.5, 0.8, 0.5, 1.0)
    two = one._replace(compressive_strength=210e6, confined_strength=245e6)
    found = {row.quantity.split(" +-")[0]: row for row in rows(DISCS, [one, two])}
    assert found["uniaxial compression [MPa]"].value == pytest.approx(200.0)
    assert found["uniaxial compression [MPa]"].good
    # plane strain: nu'/(1 + nu'), E' (1 - nu^2)
    assert found["Poisson's ratio, absolute"].value == pytest.approx(0.31 / 1.31)
    assert found["Young's modulus [GPa]"].value == pytest.approx(75.0 * (1.0 - (0.31 / 1.31) ** 2))
    assert not found["Brazilian strength [MPa]"].good
    # slope 3: 30 degrees
    assert found["friction angle to 10 MPa [deg], absolute"].value == pytest.approx(30.0)
    assert isinstance(DISCS, Granite)
