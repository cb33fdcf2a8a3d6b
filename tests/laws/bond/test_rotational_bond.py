"""The rotational bond against LAMMPS: answers of its bpm/rotational (2025.7.22, smooth no) to one displacement.

Two spheres at a distance of 1 with kr = ks = 1 and all strengths 1e-3 were moved by (along, across), and LAMMPS said
whether the bond broke.
"""

import math

import numpy as np
import pytest

from geodem.laws.bond import rotational_bond
from geodem.laws.bond.rotational_bond import RotationalBondParameters, check
from tests.contract.two_particles import Motion, Pair

ONE = RotationalBondParameters(1.0, 1.0, 0.2, 0.2, 1e-3, 1e-3, 1e-3, 1e-3)


@pytest.mark.parametrize(
    ("along", "across", "breaks"),
    [
        (0.0, 0.9e-3, False),
        (0.0, 1.1e-3, True),
        (-0.5e-3, 1.1e-3, False),
        (-0.5e-3, 1.4e-3, False),
        (-0.5e-3, 1.6e-3, True),
        (0.5e-3, 0.4e-3, False),
        (0.5e-3, 0.6e-3, True),
    ],
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_it_breaks_where_lammps_does(dimension, along, across, breaks):
    pair = Pair(rotational_bond, ONE, dimension, radii=(0.5, 0.5))
    pair.step(Motion(-along, np.array([across, 0.0, 0.0]), 0.0, np.zeros(3)))
    assert pair.broken == breaks


def test_springs_are_those_given():
    """Whatever the radii."""
    pair = Pair(rotational_bond, ONE, 3, radii=(0.1, 30.0))
    assert pair.stiffness() == (1.0, 1.0, 0.2, 0.2)


def test_a_spring_that_is_not_there_stores_nothing():
    pair = Pair(rotational_bond, ONE._replace(twisting_stiffness=0.0, bending_stiffness=0.0), 3)
    answer = pair.step(Motion(2e-4, np.zeros(3), 1.0, np.ones(3)))
    assert answer.twist_moment == 0.0
    assert not answer.bend_moment.any()
    assert pair.energy() == pytest.approx(0.5 * 2e-4**2)


def test_ranges():
    assert check(ONE._replace(tensile_strength=math.inf, bending_strength=math.inf)) == []
    wrong = ONE._replace(normal_stiffness=0.0, bending_stiffness=-1.0, twisting_strength=0.0)
    assert [fault.field for fault in check(wrong)] == [
        "normal_stiffness", "bending_stiffness", "twisting_strength",
    ]  # fmt: skip
