"""Evans and Nishimatsu beside numbers worked by hand, Coulomb beside his closed form."""

import math

import pytest

from reference.problems.cutting_formulae import evans, nishimatsu, passive_wedge

WIDTH = 0.01


@pytest.mark.parametrize(
    ("angle", "force"), [(20, 312), (30, 600), (35, 807), (40, 1080), (50, 1965), (55, 2718)]
)
def test_evans(angle, force):
    assert WIDTH * evans(6e6, 5e-3, math.radians(angle)) == pytest.approx(force, rel=2e-3)


@pytest.mark.parametrize(("rake", "force"), [(15, 3570), (0, 6650), (-15, 17400)])
def test_nishimatsu_with_n_0_is_merchant(rake, force):
    found = WIDTH * nishimatsu(60e6, math.radians(35), 5e-3, math.radians(rake), math.radians(20))
    assert found == pytest.approx(force, rel=3e-3)


def test_nishimatsu_divides_by_n_and_1():
    one = nishimatsu(60e6, 0.6, 5e-3, 0.2, 0.3)
    assert nishimatsu(60e6, 0.6, 5e-3, 0.2, 0.3, n=1.0) == pytest.approx(0.5 * one)


@pytest.mark.parametrize(("friction", "wall"), [(30, 0), (30, 10), (30, 20), (40, 15)])
def test_trial_wedges_find_coulombs_passive_pressure(friction, wall):
    # of a vertical wall: Kp = cos2(phi)/(cos(delta) (1 - sqrt(sin(phi + delta) sin(phi)/cos(delta)))2)
    phi, delta = math.radians(friction), math.radians(wall)
    root = math.sqrt(math.sin(phi + delta) * math.sin(phi) / math.cos(delta))
    pressure = math.cos(phi) ** 2 / (math.cos(delta) * (1.0 - root) ** 2)
    found = passive_wedge(16e3, phi, 0.5, 0.0, delta)
    assert found == pytest.approx(0.5 * 16e3 * 0.25 * pressure * math.cos(delta), rel=1e-4)


def test_a_heap_adds_to_the_wedge():
    plain, heaped = (passive_wedge(15.7e3, 0.6, 0.1, 0.26, 0.35, heap=heap) for heap in (0.0, 100.0))
    assert heaped > plain
