"""Distributions of sizes against the moments of their closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, stats

from geodem.builders.sizes import equal, graded, lognormal, normal, uniform
from geodem.errors import InputError

COUNT = 2000


def drawn(sizes):
    return sizes.draw(COUNT, np.random.default_rng(3))


def test_equal_and_uniform_sizes_have_their_moments():
    assert set(drawn(equal(0.3))) == {0.3}
    radii = drawn(uniform(0.2, 0.6))
    # mean, variance and mean cube of the uniform distribution
    assert radii.mean() == pytest.approx(0.4, rel=1e-4)
    assert radii.var() == pytest.approx(0.4**2 / 12.0, rel=1e-3)
    assert (radii**3).mean() == pytest.approx((0.6**4 - 0.2**4) / (4.0 * 0.4), rel=1e-3)
    assert uniform(0.2, 0.6).mean_volume(2) == pytest.approx(
        math.pi * (0.6**3 - 0.2**3) / (3.0 * 0.4), rel=1e-6
    )


def test_normal_sizes_have_the_moments_of_the_truncated_distribution():
    radii = drawn(normal(1.0, 0.3, smallest=0.6, largest=1.5))
    closed = stats.truncnorm(-0.4 / 0.3, 0.5 / 0.3, loc=1.0, scale=0.3)
    assert radii.mean() == pytest.approx(closed.mean(), rel=1e-4)
    assert radii.var() == pytest.approx(closed.var(), rel=1e-3)
    assert radii.min() >= 0.6
    assert radii.max() <= 1.5
    # the upper tail alone, where 1 - share loses its digits
    far = drawn(normal(1.0, 0.1, smallest=1.3, largest=2.0))
    assert far.mean() == pytest.approx(stats.truncnorm(3.0, 10.0, loc=1.0, scale=0.1).mean(), rel=1e-4)


def test_lognormal_sizes_have_the_moments_of_the_truncated_distribution():
    median, spread, low, high = 0.01, 0.4, 0.004, 0.03
    radii = drawn(lognormal(median, spread, smallest=low, largest=high))
    density = stats.lognorm(spread, scale=median).pdf
    mass = integrate.quad(density, low, high)[0]
    for power in (1, 2, 3):
        moment = integrate.quad(lambda r, k=power: r**k * density(r), low, high)[0] / mass
        assert (radii**power).mean() == pytest.approx(moment, rel=2e-3)
    assert np.median(radii) != pytest.approx(radii.mean(), rel=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
def test_grading_curve_is_met_by_area_or_volume(dimension):
    curve = [(0.1, 0.0), (0.2, 0.3), (0.2, 0.5), (0.4, 1.0)]
    radii = drawn(graded(curve, dimension))
    share = radii**dimension / (radii**dimension).sum()
    passing = {0.15: 0.15, 0.1999: 0.3, 0.2001: 0.5, 0.3: 0.75}
    for radius, expected in passing.items():
        assert share[radii <= radius].sum() == pytest.approx(expected, abs=0.004)


def test_order_is_random_and_of_the_seed():
    sizes = uniform(1.0, 2.0)
    one, again, other = (sizes.draw(500, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert (one == again).all()
    assert (one != other).any()
    assert abs(np.corrcoef(np.arange(500), one)[0, 1]) < 0.15


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: equal(0.0), "not a positive number"),
        (lambda: equal("wide"), "not a positive number"),
        (lambda: uniform(2.0, 1.0), "above the largest"),
        (lambda: normal(1.0, -0.1, smallest=0.5, largest=2.0), "not a positive number"),
        (lambda: normal(1.0, 0.1, smallest=3.0, largest=4.0), "next to none"),
        (lambda: lognormal(1.0, math.nan, smallest=0.5, largest=2.0), "not a positive number"),
        (lambda: graded([(1.0, 0.0)], 2), "two pairs"),
        (lambda: graded([(1.0, 0.0), (0.5, 1.0)], 2), "do not grow"),
        (lambda: graded([(1.0, 0.1), (2.0, 1.0)], 3), "from 0 to 1"),
        (lambda: graded([(1.0, 0.0), (2.0, 1.0)], 4), "2 or 3"),
    ],
)
def test_wrong_input_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
