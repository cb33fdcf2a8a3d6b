"""Small forms of `reference run laboratory-dice2d`: closed forms by hand, tests that a wrong material fails."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.laboratory.specimen import make_specimen
from reference.problems import laboratory_dice2d_strength as strength
from reference.problems import laboratory_dice2d_tension as tension
from reference.problems.laboratory_dice2d_specimens import irregular, material, triangular


def test_sheet_in_tension():
    # without shear springs both bonds of a disc bear Ft at 60 degrees: 2 sin 60
    assert tension.sheet(0.0) == pytest.approx(math.sqrt(3.0))
    # ks = kn: no strain across, so that Fn : Fs = sin 60 : cos 60 and sigma D = 2 Ft/sin 60
    assert tension.sheet(1.0) == pytest.approx(4.0 / math.sqrt(3.0))
    # tan 80 = 5.671, Fs/Fn = 0.2 (5 sqrt3/4)/(11/4) = 0.1575
    assert tension.cut_off(2.0, 80.0) == pytest.approx(2.0 / 5.829, rel=1e-3)
    assert tension.cut_off(10.0, 80.0) == 1.0
    assert tension.inside(0.5).good


def test_straight_sections():
    # rows of 10 and 9: 18 bonds cross, each sin 60 of Ft along, over a width of 10 D
    mean, least = tension.sections(triangular(10, 10))
    assert mean == pytest.approx(18.0 * math.sin(math.radians(60.0)) / 10.0)
    assert least == pytest.approx(mean)


def test_regular_specimen_breaks_where_the_elastic_solve_says():
    specimen = triangular(10, 10).specimen("triangular")
    whole = tension.torn(specimen, material())
    assert whole.failed
    assert whole.alpha == pytest.approx(whole.first_break, rel=0.01)
    # Zhao 2015, section 3.3.1: about 1.5
    assert whole.alpha == pytest.approx(1.5, rel=0.1)
    assert (whole.shear, whole.tension > 0) == (0, True)
    cut = tension.torn(specimen, material(cohesion=2.0))
    assert cut.alpha / whole.alpha == pytest.approx(tension.cut_off(2.0, 80.0), rel=0.01)
    assert (cut.tension, cut.shear > 0) == (0, True)


def test_irregular_specimen_bears_less_than_its_bonds_together():
    sample = irregular(240.0, 400.0, tension.DENSE, 1)
    found = tension.torn(sample.specimen("random"), material(tension.DENSE))
    assert found.failed
    assert 0.9 * found.first_break < found.alpha < tension.sections(sample)[1]


def test_splitting_and_compression():
    disc = make_specimen(2, width=240.0, across=12.0, shape="disc", seed=1)
    prism = make_specimen(2, width=240.0, height=400.0, across=12.0, seed=1)
    made_of = material(tension.DENSE)
    halved = strength.tested(strength.split, [disc], made_of)
    pressed = strength.tested(strength.compress, [prism], made_of)
    pulled = strength.tested(strength.pull, [prism], made_of)
    assert 0.0 < halved.mean < pressed.mean
    assert pressed.mean > 2.0 * pulled.mean
    # bonds that are weak in shear
    weak = strength.tested(strength.compress, [prism], material(tension.DENSE, cohesion=0.25, angle=40.0))
    assert weak.mean < 0.5 * pressed.mean
    assert weak.tension < 0.5 < pressed.tension


def test_what_lies_below_its_limit_is_told():
    assert strength.at_least("a", "b", 1.0, 1.0, 0.0, "").good
    assert not strength.at_least("a", "b", 0.9, 1.0, 0.0, "").good
    assert not strength.at_least("a", "b", float("nan"), 1.0, 0.0, "").good
    assert np.isnan(strength.at_least("a", "b", float("nan"), 1.0, 0.0, "").error)
