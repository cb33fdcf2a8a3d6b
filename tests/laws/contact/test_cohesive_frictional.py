"""The contact that sticks: tension up to the adhesion, shear up to Fc + mu Fn."""

import pytest

from geodem.laws.contact.cohesive_frictional import CohesiveFrictionalParameters, force, reach
from tests.contract.two_particles import Pair, no_motion

PARAMETERS = CohesiveFrictionalParameters(1e6, 5e5, 0.3, 200.0, 100.0)
KN, KS, MU, FA, FC = PARAMETERS[:5]


def test_at_its_reach_it_pulls_with_the_adhesion():
    gap = reach(KN, FA)
    assert gap == pytest.approx(0.2e-3, rel=1e-14)
    assert force(KN, KS, MU, FC, -gap, 0, 0, 0, 0, 0, 0)[0] == pytest.approx(-FA, rel=1e-14)


@pytest.mark.parametrize(
    ("normal", "limit"),
    [(1000.0, 400.0), (0.0, 100.0), (-100.0, 70.0), (-200.0, 40.0), (-500.0, 0.0)],
)
def test_shear_slides_at_mohr_coulomb(normal, limit):
    """Fc + mu Fn, and 0 where that is negative (0.3 * 500 > 100)."""
    answer = force(KN, KS, MU, FC, normal / KN, 0.0, 3.0, 4.0, 0.0, 0.0, 0.0)
    assert answer[1:4] == pytest.approx((0.0, 0.6 * limit, 0.8 * limit), rel=1e-12, abs=1e-9)


def test_only_a_touch_makes_it_stick():
    """From afar the gap of the reach bears no force; after a touch it does; lost, it does not come back."""
    from geodem.laws.contact import cohesive_frictional

    pair = Pair(cohesive_frictional, PARAMETERS, 2)
    normals = [
        pair.step(no_motion(approach=move)).normal
        for move in (-1e-4, 1.5e-4, -1.5e-4, -0.9e-4, -0.2e-4, 0.5e-4, 2e-4)
    ]
    assert normals == pytest.approx([0.0, 50.0, -100.0, -190.0, 0.0, 0.0, 40.0], rel=1e-9, abs=1e-9)


def test_without_adhesion_it_is_the_linear_contact():
    from geodem.laws.contact import linear_frictional

    arguments = (1e-4, 1e-4, -2e-4, 3e-5, 10.0, 20.0, 30.0)
    assert reach(KN, 0.0) == 0.0
    assert force(KN, KS, MU, 0.0, *arguments) == linear_frictional.force(KN, KS, MU, *arguments)
