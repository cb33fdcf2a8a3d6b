"""Run time against error of several codes: the errors, on scenes of a few spheres. Times are not looked at."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium
from reference.backends import BACKENDS, yade
from reference.benchmarks import frontier_codes_bonded as bonded
from reference.benchmarks import frontier_codes_motion as motion
from reference.benchmarks import frontier_codes_slope as slope
from reference.benchmarks.frontier_codes_runs import doubling, from_then_on, in_turn


def installed(code):
    missing = BACKENDS[code].available()
    if missing:
        pytest.skip(missing)


@pytest.mark.parametrize("code", ["yade", "liggghts"])
def test_codes_take_the_same_steps_through_a_collision(code):
    installed(code)
    shares = (0.05, 0.2)
    scenes = {name: motion.collisions(name, 40, shares, oblique=False) for name in ("geodem", code)}
    found = in_turn(scenes, 2)
    errors = {
        name: [
            motion.parting_error(one, run) for one, (run, _) in zip(scenes[name], found[name], strict=True)
        ]
        for name in scenes
    }
    # velocity Verlet and leap-frog are one scheme: their errors differ by rounding
    assert errors[code] == pytest.approx(errors["geodem"], rel=1e-6)
    # by their meeting within a step, (w dt)^2/8 at most: half of 0.05 and 0.2 squared; less on average
    assert errors["geodem"][0] < 0.5 * 0.05**2
    assert errors["geodem"][1] > 4.0 * errors["geodem"][0]
    for measured in (one for runs in found.values() for one in runs):
        assert len(measured.seconds) == 2
        assert all(second > 0.0 for second in measured.seconds)


def test_the_cantilever_rests_where_its_chain_says():
    assembly, deflection = bonded.loaded(5)
    simulation = ParticleSimulation(assembly, orientation=False)
    find_equilibrium(simulation, tolerance=1e-6)
    # the rest is of the size of its slope squared
    assert simulation.positions[-1, 1] == pytest.approx(deflection, rel=10.0 * bonded.BENT**2)
    # an Euler beam with the bending stiffness kr 2 r and the shear stiffness of its bonds, F L^3/3EI + F L/(ks 2 r)
    length = 40 * 2.0 * bonded.RADIUS
    load = np.zeros(80)
    load[-2] = 1.0
    one = float(np.linalg.solve(bonded.chain(40).stiffness, load)[-2])
    stiffness = bonded.BENDING * bonded.RADIUS**2 * bonded.SHEAR * 2.0 * bonded.RADIUS
    assert one == pytest.approx(length**3 / (3.0 * stiffness) + 40.0 / bonded.SHEAR, rel=2e-3)


def test_a_period_is_found_wherever_the_swing_begins():
    posed = bonded.swinging("geodem", 4, 0.5, 3)
    rate, _ = bonded.lowest_mode(bonded.chain(4))
    t = np.array(posed.frames) * posed.time_step
    positions = np.zeros((len(t), 5, 3))
    # a hundredth slower, about another place
    positions[:, -1, 1] = 1e-6 * np.sin(rate / 1.01 * t + 0.3) + 2e-7
    assert bonded.period_error(posed, positions, 4) == pytest.approx(0.01, rel=0.02)


def test_the_first_break_of_a_slope_in_statics_and_on_a_ramp():
    installed("yade")
    assembly = slope.slope(5)
    first = slope.first_break(assembly)
    # from a tenth of it on the elastic state tells the same, but for the turning of the bonds
    assert slope.elastic_first(assembly, 0.1 * first)[0] == pytest.approx(first, rel=5e-3)
    steps, top = 3000, 1.2 * first
    watched = yade.run_ramp(slope.rising(assembly, top, steps, "yade"), every=slope.EVERY, until=1)
    found = slope.read(watched, top, steps, 1)
    assert found.first == found.damage == pytest.approx(first, rel=0.02)
    # it ends there
    assert watched[-1, 0] < steps
    assert list(watched[:-1, 1]) == [0.0] * (len(watched) - 1)


def test_a_ramp_that_breaks_nothing_tells_no_factor():
    watched = np.array([[10.0, 0.0, 0.1], [20.0, 2.0, 0.2], [30.0, 2.0, 0.3]])
    found = slope.read(watched, 3.0, 30, 5)
    # between the tenth and the twentieth step
    assert found.first == pytest.approx(1.5)
    assert found.seconds_first == 0.2
    assert math.isnan(found.damage)


def test_errors_count_from_then_on():
    assert from_then_on(np.array([3.0, 0.1, 2.0, 0.5])).tolist() == [3.0, 2.0, 2.0, 0.5]
    assert doubling(100, 900) == [100, 200, 400, 800]


def test_what_rests_carries_its_weight():
    posed = motion.settling("geodem", 100, 0.3, 100)
    assembly = replace(posed.assembly)
    weight = 9.81 * assembly.mass.sum()
    assert motion.weight_errors(assembly, np.array([weight, 0.9 * weight])) == pytest.approx([0.0, 0.1])
    # nothing touches at the start
    pairs = ParticleSimulation(assembly, orientation=False).contact_count()
    assert pairs == 0
