"""Mean stress, fabric, coordination and share of the volume, against sums by hand."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.measure.fabric import coordination_number, fabric_tensor, solid_fraction
from geodem.measure.stress import stress_of_contacts


def test_a_pressed_column_has_the_stress_of_its_force_over_its_area():
    # three blocks of height 2 on an area of 0.5, pressed with 10: two contacts between them and one at each end
    forces = [(0.0, -10.0), (0.0, -10.0), (0.0, 10.0), (0.0, -10.0)]
    branches = [(0.0, 2.0), (0.0, 2.0), (0.0, -1.0), (0.0, 1.0)]
    stress = stress_of_contacts(forces, branches, 3 * 2.0 * 0.5)
    assert np.allclose(stress, [[0.0, 0.0], [0.0, -20.0]])


def test_what_is_no_set_of_contacts_or_no_volume_is_refused():
    with pytest.raises(InputError, match="do not belong"):
        stress_of_contacts(np.zeros((2, 3)), np.zeros((3, 3)), 1.0)
    with pytest.raises(InputError, match="no volume"):
        stress_of_contacts(np.zeros((2, 3)), np.zeros((2, 3)), 0.0)


def test_coordination_with_and_without_rattlers():
    # a triangle with a fourth particle that hangs on it, and a fifth alone: (2*4 - 1)/(5 - 1 - 1)
    pairs = np.array([[0, 1], [1, 2], [0, 2], [2, 3]])
    assert coordination_number(pairs, 5) == pytest.approx(8.0 / 5.0)
    assert coordination_number(pairs, 5, rattlers=False) == pytest.approx(7.0 / 3.0)
    assert coordination_number(np.empty((0, 2), dtype=np.int64), 5, rattlers=False) == 0.0


def test_fabric_and_share_of_the_volume():
    assert np.allclose(
        fabric_tensor(np.array([(1.0, 0.0), (1.0, 0.0), (0.0, 1.0)])), np.diag([2.0, 1.0]) / 3.0
    )
    assert solid_fraction(np.array([1.0, 2.0]), 2, 100.0) == pytest.approx(5.0 * np.pi / 100.0)
    assert solid_fraction(np.array([1.0, 2.0]), 3, 100.0) == pytest.approx(12.0 * np.pi / 100.0)
