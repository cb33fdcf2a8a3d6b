"""The Hertz-Mindlin contact against numbers worked out by hand, Mindlin's ratio of stiffness, and its restitution."""

import math

import numpy as np
import pytest

from geodem.laws.contact import hertz_mindlin
from geodem.laws.contact.hertz_mindlin import HertzMindlinParameters, check, combine, stiffness, viscous
from tests.contract.two_particles import Pair, no_motion, work

STICKY = HertzMindlinParameters(75e9, 0.5, 1e9)
RADII = (0.02, 0.02)
STEEL = HertzMindlinParameters(210e9, 0.3, 0.2, 0.9)
RUBBER = HertzMindlinParameters(1e8, 0.49, 0.8, 0.5)


def slip(x):
    return no_motion(slip=np.array([x, 0.0, 0.0]))


def test_stiffness_by_hand():
    """E* = 50 GPa, G* = 75/9 GPa, contact radius 1 mm at u = 0.1 mm: kn = 2 E* a, ks = 8 G* a."""
    found = stiffness(75e9, 0.5, 1e-4, *RADII)
    assert found == pytest.approx((1e8, 8.0 * 75e9 / 9.0 * 1e-3, 0.0, 0.0), rel=1e-14)


@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.5])
def test_mindlins_ratio(ratio):
    """ks/kn = 2 (1 - nu)/(2 - nu), Mindlin 1949."""
    kn, ks, *_ = stiffness(75e9, ratio, 1e-4, *RADII)
    assert ks / kn == pytest.approx(2.0 * (1.0 - ratio) / (2.0 - ratio), rel=1e-14)


def test_the_shear_force_shrinks_with_the_contact_and_does_not_grow_with_it():
    """Thornton, Cummins & Cleary 2013: unloaded to a quarter of the overlap the contact's radius is halved."""
    pair = Pair(hertz_mindlin, STICKY, 3, radii=RADII)
    pair.step(no_motion(approach=1e-4))
    charged = pair.step(slip(1e-6)).shear[0]
    assert charged == pytest.approx(8.0 * 75e9 / 9.0 * 1e-3 * 1e-6, rel=1e-12)
    assert pair.step(no_motion(approach=-0.75e-4)).shear[0] == pytest.approx(0.5 * charged, rel=1e-12)
    assert pair.step(no_motion(approach=0.75e-4)).shear[0] == pytest.approx(0.5 * charged, rel=1e-12)


def test_shear_that_grows_with_the_load_is_of_second_order():
    """Slip in proportion to the overlap: Fs is the integral of 8 G* sqrt(R* u) ds, 2/3 of it at the last radius."""
    errors = []
    for steps in (20, 40):
        pair = Pair(hertz_mindlin, STICKY, 3, radii=RADII)
        pair.step(no_motion(approach=0.25e-4))
        for _ in range(steps):
            force = pair.step(
                no_motion(approach=0.75e-4 / steps, slip=np.array([0.75e-6 / steps, 0.0, 0.0]))
            ).shear[0]
        exact = 8.0 * 75e9 / 9.0 * 1e-3 * 1e-6 * 2.0 / 3.0 * (1.0 - 0.25**1.5)
        errors.append(abs(force / exact - 1.0))
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_sheared_under_load_and_back_without_it_gives_no_energy():
    """Charged at the stiffness ks, given back at ks/2: half of the shear energy is lost, and not won."""
    pair = Pair(hertz_mindlin, STICKY, 3, radii=RADII)
    before, spent = pair.step(no_motion(approach=1e-4)), []
    for motion in (slip(1e-6), no_motion(approach=-0.75e-4), slip(-1e-6)):
        after = pair.step(motion)
        spent.append(work(before, after, motion) if motion.slip.any() else 0.0)
        before = after
    assert after.shear == pytest.approx(np.zeros(3), abs=1e-12)
    assert spent[0] + spent[2] == pytest.approx(0.5 * spent[0], rel=1e-12)


def test_friction():
    pair = Pair(hertz_mindlin, STICKY._replace(friction_coefficient=0.3), 3, radii=RADII)
    normal = pair.step(no_motion(approach=1e-4)).normal
    assert normal == pytest.approx(20e3 / 3.0, rel=1e-14)
    answer = pair.step(no_motion(slip=np.array([0.0, 3e-3, 4e-3])))
    assert answer.shear == pytest.approx([0.0, 0.6 * 0.3 * normal, 0.8 * 0.3 * normal], rel=1e-12)


@pytest.mark.parametrize("asked", [0.05, 0.3, 0.7, 1.0])
def test_a_collision_keeps_e_of_its_speed(asked):
    """Any speed, masses and radii; Runge-Kutta of the fourth order, from touch to touch."""
    given = HertzMindlinParameters(5e8, 0.25, 0.0, asked)
    masses, radii = (3.0, 0.7), (0.05, 0.02)
    mass = masses[0] * masses[1] / sum(masses)

    def rate(overlap, speed):
        pressed = max(overlap, 0.0)
        kn = stiffness(*given[:2], pressed, *radii)[0]
        damp = viscous(*given[:2], asked, pressed, speed, *radii, *masses, 1.0)[0]
        return speed, -(2.0 / 3.0 * kn * pressed + damp) / mass

    step, overlap, speed = 2e-6, 1e-12, 0.8
    while overlap > 0.0:
        a = rate(overlap, speed)
        b = rate(overlap + 0.5 * step * a[0], speed + 0.5 * step * a[1])
        c = rate(overlap + 0.5 * step * b[0], speed + 0.5 * step * b[1])
        d = rate(overlap + step * c[0], speed + step * c[1])
        overlap += step / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0])
        speed += step / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1])
    assert -speed / 0.8 == pytest.approx(asked, rel=2e-3)


def test_two_materials_have_their_own_moduli_of_contact():
    """1/E* and 1/G* are the sums of those of the two (Johnson 1985, eqs 4.20b and 7.42)."""
    both = combine(STEEL, RUBBER)
    kn, ks, *_ = stiffness(*both[:2], 1e-4, *RADII)
    normal = 0.91 / 210e9 + (1.0 - 0.49**2) / 1e8
    shear = 2.0 * 1.7 * 1.3 / 210e9 + 2.0 * 1.51 * 1.49 / 1e8
    assert kn == pytest.approx(2e-3 / normal, rel=1e-12)
    assert ks == pytest.approx(8e-3 / shear, rel=1e-12)
    assert combine(RUBBER, STEEL) == pytest.approx(both, rel=1e-14)
    assert both[2:] == (0.2, 0.7)
    assert check(both) == []


@pytest.mark.parametrize(
    ("field", "value"),
    [("restitution", 0.0), ("restitution", 1.1), ("restitution", math.nan), ("poisson_ratio", 0.6)],
)
def test_what_is_out_of_range_is_named(field, value):
    assert [fault.field for fault in check(STEEL._replace(**{field: value}))] == [field]
