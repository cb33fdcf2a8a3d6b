"""Rowe's face-centred packings: reference/problems/trubal.py, the smaller one loaded."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reference.problems import trubal
from reference.problems.trubal_rowe import CUNDALL, FRICTION, load, octagon, prism, theory, uniform_strain
from tests.verification.rows import check


@pytest.mark.parametrize("name", trubal.SAMPLES)
def test_layers_and_membrane(name):
    check(*trubal.shapes(name, trubal.SAMPLES[name]))


def test_spheres_touch_those_of_the_layers_beside_theirs():
    """Face-centred: four neighbours above and four below every sphere of a small layer, four around it inside."""
    sample = prism(CUNDALL)
    apart = np.linalg.norm(sample.places[:, None] - sample.places[None], axis=2)
    assert apart[apart > 0.0].min() == pytest.approx(2.0, abs=1e-12)
    touching = np.abs(apart - 2.0) < 1e-9
    for step in (-1, 1):
        beside = sample.layer[None, :] == sample.layer[:, None] + step
        assert ((touching & beside).sum(axis=1)[sample.layer % 2 == 1] == 4).all()
    # area by Pick's theorem, in squares of 2 r: inner spheres + half the outer ones - 1
    assert sample.area == pytest.approx(4.0 * ((37 - 16) + 16 / 2 - 1))
    assert len(sample.membrane) == 7 * 16
    assert len(octagon(7, 0)) == 49


def test_uniform_strain_starts_at_the_ratio_of_the_lattice():
    assert uniform_strain(np.zeros(1), FRICTION)[0] == pytest.approx(theory(FRICTION), rel=1e-12)
    assert theory(math.tan(math.radians(7.0))) == pytest.approx(2.56, abs=0.005)


def test_cundalls_sample_fails_at_the_published_ratio():
    """Radius 20 and a fifth of the steps of the reference; no platen is out of balance."""
    run = load(prism(CUNDALL), to=0.012, steps=4_000, points=60)
    assert run.peak == pytest.approx(trubal.PUBLISHED[FRICTION], rel=trubal.BOUND)
    assert run.peak < theory(FRICTION)
    assert run.apart < 0.01
    assert run.ratio[0] < 1.0
    assert run.ratio[-1] < run.peak
