"""Direct shear: equal and opposite halves, the normal stress, strength and residual strength over it, dilation."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.direct_shear import _top, box_halves, dilation_angle, shear
from geodem.laboratory.driven import Driven
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.record import TestRecord
from geodem.laboratory.specimen import Specimen, make_specimen

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=10e6, shear_strength=40e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip
PACE = 120.0


@cache
def block() -> Specimen:
    return make_specimen(2, width=0.05, height=0.05, across=21, seed=1)


@cache
def sheared(normal_stress: float) -> TestRecord:
    return shear(block(), ROCK, normal_stress=normal_stress, pace=PACE)


def test_the_halves_are_pushed_alike_and_the_bottom_bears_the_normal_stress():
    specimen = block()
    motion = box_halves(specimen)
    load = np.zeros(motion.shape)
    ids, share = _top(specimen)
    load[ids, 1] = -5e6 * specimen.area * share
    driven = Driven(specimen, ROCK, motion, load=load)
    driven.begin(0.0)
    force = driven.simulation.forces
    upper, lower = driven.motion[:, 0] > 0.0, driven.motion[:, 0] < 0.0
    assert force[upper, 0].sum() == pytest.approx(-force[lower, 0].sum(), rel=1e-3)
    assert driven.force() == pytest.approx(-force[upper, 0].sum(), rel=1e-3)
    bottom = driven.driven[:, 1]
    assert -force[bottom, 1].sum() == pytest.approx(5e6 * specimen.area, rel=1e-3)


def test_strength_rises_with_the_normal_stress_and_falls_to_a_residual_one():
    low, high = sheared(5e6), sheared(10e6)
    for record in (low, high):
        assert record.failed
        assert record.numbers["residual_stress"] < 0.9 * record.strength
        # what is broken rubs with a coefficient of 0.5, and more by what stands in its way
        assert record.numbers["residual_stress"] > 0.4 * record.numbers["normal_stress"]
    slope = (high.strength - low.strength) / 5e6
    assert 0.5 < slope < 2.5


def test_it_dilates_less_the_more_it_is_pressed():
    low, high = sheared(5e6), sheared(10e6)
    way = 1.5 * low.numbers["peak_displacement"]
    assert low.curves["dilation"][-1] > 0.0
    assert low.numbers["dilation_angle"] > 0.0

    def risen(record: TestRecord) -> float:
        return float(np.interp(way, record.curves["displacement"], record.curves["dilation"]))

    assert risen(high) < risen(low)


def test_cracks_lie_between_the_halves():
    record = sheared(5e6)
    away = np.abs(record.cracks.place[:, 1] - 0.025)
    # spread evenly over the block the median would be half of its half height
    assert np.median(away) < 0.35 * 0.025


def test_the_dilation_angle_is_a_slope():
    way = np.linspace(0.0, 3.0, 31)
    risen = np.where(way < 1.0, 0.0, 0.3 * (way - 1.0))
    assert dilation_angle(way, risen, 10) == pytest.approx(math.atan(0.3), rel=1e-12)
    assert math.isnan(dilation_angle(way[:11], risen[:11], 10))


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="no pressure"):
        shear(block(), ROCK, normal_stress=-1.0)
    with pytest.raises(InputError, match="is a prism"):
        shear(
            make_specimen(2, width=0.05, across=10, packing="square", shape="disc"), ROCK, normal_stress=0.0
        )
    flat = make_specimen(2, width=0.05, height=0.02, across=10, packing="square")
    with pytest.raises(InputError, match="halves of the box meet"):
        shear(flat, ROCK, normal_stress=0.0)
