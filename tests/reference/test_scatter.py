"""Chaotic scenes by their statistics: the tests on known distributions, and two hundred spheres in all codes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from geodem.boundaries.walls import plane
from reference.backends import BACKENDS
from reference.comparisons import column, grains, settling
from reference.comparisons.scatter import (
    LEVEL,
    apart,
    kolmogorov_smirnov,
    means_of,
    rows_of_means,
    told_apart,
)
from reference.posed import Posed, Trajectory, sorted_pairs

ABOUT = {
    "scene": "scene", "code": "yade", "version": "1", "law": "law", "steps": 1, "particles": 1, "seconds": 0.0,
}  # fmt: skip


def test_the_bound_is_students():
    """By hand: means 2 and 5, variances 1 and 1, t(0.995, 4) = 4.6041 in any table."""
    found = means_of([1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
    assert found.means == (2.0, 5.0)
    assert found.scatters == pytest.approx((1.0, 1.0))
    assert found.difference == pytest.approx(3.0 / 5.0)
    assert found.bound == pytest.approx(4.6041 * math.sqrt(2.0 / 3.0) / 5.0, rel=1e-4)
    assert found.over_scatter == pytest.approx(3.0)


def test_means_of_one_distribution_are_alike_as_often_as_the_level_says():
    rng = np.random.default_rng(1)
    drawn = rng.normal(10.0, 1.0, (4000, 2, 3))
    alike = np.mean([means_of(*pair).alike for pair in drawn])
    assert alike == pytest.approx(LEVEL, abs=4.0 * math.sqrt(LEVEL * (1.0 - LEVEL) / 4000))


def test_means_that_are_ten_scatters_apart_are_seen():
    rng = np.random.default_rng(2)
    seen = [not means_of(rng.normal(10.0, 1.0, 3), rng.normal(20.0, 1.0, 3)).alike for _ in range(200)]
    assert np.mean(seen) > 0.95


def test_one_seed_has_no_scatter():
    with pytest.raises(ValueError, match="two seeds"):
        means_of([1.0], [1.0, 2.0])


def test_rows_miss_where_the_means_are_apart():
    ours = [{"height": value, "width": value} for value in (1.0, 1.01, 0.99)]
    theirs = [{"height": value, "width": value + 1.0} for value in (1.005, 0.995, 1.0)]
    good, bad = rows_of_means(ABOUT, ours, theirs)
    assert good.good
    assert good.scene == "scene: height"
    assert not bad.good
    assert bad.difference == pytest.approx(0.5)


def test_what_is_changed_must_be_seen_in_one_number():
    ours = [{"height": value} for value in (1.0, 1.01, 0.99)]
    assert not told_apart(ABOUT, "nothing", ours, ours).good
    assert told_apart(ABOUT, "all", ours, [{"height": 2.0 + one["height"]} for one in ours]).good


def test_distance_between_distributions():
    """Exponential distributions of the rates 1 and 2 differ most where exp(-f) = 1/2, by 1/4."""
    rng = np.random.default_rng(3)
    one, other = rng.exponential(1.0, (3, 20000)), rng.exponential(0.5, (3, 20000))
    assert kolmogorov_smirnov(one[0], other[0]) == pytest.approx(0.25, abs=0.02)
    between, within = apart(list(one), list(other), kolmogorov_smirnov)
    assert between > 5.0 * within
    between, within = apart(list(one[:2]), [one[2], rng.exponential(1.0, 20000)], kolmogorov_smirnov)
    assert between < 2.0 * within


def test_tail_of_exponential_forces():
    """Of exp(-b f) it is b, whatever the mean."""
    forces = stats.expon(scale=1.0 / 1.5).ppf((np.arange(100_000) + 0.5) / 100_000)
    assert grains.tail(forces) == pytest.approx(1.5, rel=1e-3)


def test_forces_are_measured_by_the_mean_of_their_layer():
    height = np.arange(100.0)
    assert grains.over_mean_of_layers(np.full(100, 3.0), height) == pytest.approx(1.0)
    # a force that grows with depth has the mean 1 in every fifth
    scaled = grains.over_mean_of_layers(100.0 - height, height)
    assert scaled.reshape(5, 20).mean(axis=1) == pytest.approx(1.0)


def test_three_spheres_on_a_floor():
    """A triangle of touching spheres on a floor: two contacts each, none without a force; kn u is the force."""
    b = grains.builder_of("yade")
    d = grains.DIAMETER
    places = (
        np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.5, 0.5 * math.sqrt(3.0), 0.5], [5.0, 0.0, 2.0]]) * d
    )
    b.add_particles(places, 0.5 * d, "grain")
    b.add_wall(plane("floor", (0, 0, 1e-6 * d), (0, 0, 1)))
    posed = Posed("three", b.build(), grains.TIME_STEP, 1, "yade")
    pairs = np.array([[0, 1], [0, 2], [1, 2], [0, 3]])
    along = places[pairs[:, 1]] - places[pairs[:, 0]]
    along /= np.sqrt((along**2).sum(axis=1))[:, None]
    force = np.array([2.0, 2.0, 2.0, 0.0])
    zero = np.zeros((1, 4, 3))
    run = Trajectory(
        "yade", "1", "law", np.array([1]), places[None], zero, zero, zero, zero,
        pair_forces=sorted_pairs(np.zeros(4, dtype=int), pairs, -force[:, None] * along, np.zeros((4, 3)), along),
    )  # fmt: skip
    rest = grains.at_rest(posed, run)
    assert rest.numbers["coordination number"] == 6 / 4
    # the fourth is left out, the floor counts
    assert rest.numbers["coordination number without rattlers"] == 3.0
    assert rest.numbers["fabric along gravity"] == 0.0
    assert rest.overlap == pytest.approx(2.0 / grains.NORMAL / d)
    assert rest.kinetic == 0.0


@pytest.mark.parametrize("code", ["yade", "liggghts"])
def test_two_hundred_spheres_settle_alike(code):
    """Before chaos sets in: half way down, all codes have the same height of the centre of mass."""
    missing = BACKENDS[code].available()
    if missing:
        pytest.skip(missing)
    posed = settling.settling(code, 1, count=200, side=5.0, duration=2.0)
    fallen = [grains.run(one, posed).positions[-1, :, 2].mean() for one in ("geodem", code)]
    start = posed.assembly.positions[:, 2].mean()
    assert fallen[0] < start - 1.0 * grains.DIAMETER
    assert fallen[0] == pytest.approx(fallen[1], rel=1e-3)


def test_a_column_stands_on_its_floor_behind_its_gate():
    """Positions handed over lie in the slot, and those of the floor are held."""
    shape = column.Shape(count=150, width=4.8, slot=5.0, far=14.0, settling=2.0, duration=2.0)
    posed = column.column("yade", 1, shape)
    a = posed.assembly
    held = a.held.all(axis=1)
    assert (~held).sum() == 150
    moving = a.positions[~held] / grains.DIAMETER
    assert moving[:, 0].max() < 4.8
    assert moving[:, 1].min() > 0.0
    assert moving[:, 1].max() < 5.0
    assert (moving[:, 2] > -0.1).all()
    assert {wall.name for wall in a.walls} == {"under the floor", "back", "end", "left", "right", "lid"}
