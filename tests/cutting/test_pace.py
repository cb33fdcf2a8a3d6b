"""How fast a tool is: the stress of an impact and what is said of it."""

import math

import pytest

from geodem.cutting.pace import Pace


def test_the_stress_of_an_impact_is_that_of_a_bar():
    # rho c v (Kolsky 1963, Stress Waves in Solids): steel hit at 1 m/s bears 40 MPa
    assert Pace(speed=1.0, wave=5100.0, density=7850.0).stress == pytest.approx(40e6, rel=0.01)


def test_a_peak_takes_as_many_passages_as_it_is_times_the_stress_of_the_impact():
    pace = Pace(speed=0.5, wave=1000.0, density=2000.0)
    assert pace.passages(10e6) == pytest.approx(10.0)
    assert math.isnan(pace.passages(math.nan))


def test_a_tool_that_hits_and_a_damping_that_resists_are_told():
    pace = Pace(speed=0.5, wave=1000.0, density=2000.0)
    hit, damped = pace.doubts(10e6, 0.5)
    # 20 passages at half the speed
    assert "10 passages" in hit
    assert "0.2 m/s" in hit
    assert "local_damping" in damped
    assert pace.doubts(30e6, 0.3) == []
    # ground without bonds has no peaks that are hit off
    assert pace.doubts(math.nan, 0.3) == []
