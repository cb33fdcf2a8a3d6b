"""Evans and Nishimatsu beside numbers worked by hand."""

import math

import pytest

from reference.problems.cutting_formulae import evans, nishimatsu

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
