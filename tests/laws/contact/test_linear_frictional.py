"""Linear frictional contact against Coulomb's law and the path of a block on a spring."""

import numpy as np
import pytest

from geodem.laws.contact.linear_frictional import LinearFrictionalParameters, energy, force

PARAMETERS = LinearFrictionalParameters(1e6, 5e5, 0.3)
KN, KS, MU = PARAMETERS[:3]


def test_it_sticks_slides_and_sticks_on_the_way_back():
    """Pressed by 1 mm (1000 N), 300 N hold: slip grows at 0.6 mm; turned round it needs 1.2 mm to slide back."""
    shear = np.zeros(3)
    for slip, expected in ((0.5e-3, 250.0), (0.5e-3, 300.0), (-0.6e-3, 0.0), (-0.7e-3, -300.0)):
        normal, *_, x, y, z = force(KN, KS, MU, 1e-3, 0.0, slip, 0.0, *shear)
        shear = np.array([x, y, z])
        assert normal == pytest.approx(1000.0, rel=1e-14)
        assert shear == pytest.approx([0.0, expected, 0.0], rel=1e-12, abs=1e-9)


def test_sliding_keeps_the_direction_and_the_size():
    rng = np.random.default_rng(1)
    for _ in range(20):
        old, slip = rng.normal(size=3) * 100.0, rng.normal(size=3) * 1e-2
        shear = np.array(force(KN, KS, MU, 1e-3, *slip, *old)[1:4])
        trial = old + KS * slip
        assert np.linalg.norm(shear) == pytest.approx(MU * KN * 1e-3, rel=1e-12)
        assert np.cross(shear, trial) == pytest.approx(np.zeros(3), abs=1e-8 * np.linalg.norm(trial))
        assert shear @ trial > 0.0


def test_less_pressure_lets_slide():
    assert force(KN, KS, MU, 5e-4, 0.0, 0.0, 0.0, 300.0, 0.0, 0.0)[1] == pytest.approx(150.0, rel=1e-14)


def test_without_friction_there_is_no_shear():
    assert force(KN, KS, 0.0, 1e-3, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0)[1:4] == (0.0, 0.0, 0.0)


def test_energy_of_two_springs():
    """1000 N on 1 MN/m: 0.5 J; 300 N on 0.5 MN/m: 0.09 J."""
    assert energy(KN, KS, 1e-3, 0.0, 180.0, -240.0) == pytest.approx(0.59, rel=1e-14)
