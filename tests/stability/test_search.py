"""Searches on a small slope: the methods, and a stop in the middle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geodem.builders.ground import pressure_load
from geodem.simulation import Simulation
from geodem.stability.criteria import Criteria
from geodem.stability.methods import GravityIncrease, LoadIncrease, StrengthReduction, make_method
from geodem.stability.search import Search
from tests.meshes import mesh, model, slope, soil


@pytest.fixture(scope="module")
def ground():
    """A 2:1 slope of about 240 particles."""
    return slope(1.1)


def search(ground, kind, *, tolerance=0.01, start=1.0, step=0.3):
    simulation = Simulation(ground, energy=False)
    return Search(
        simulation, make_method(kind, simulation), Criteria(), tolerance=tolerance, start=start, step=step
    )


def test_strength_reduction(ground):
    """Griffiths & Lane 1999 example 1: 1.38 by charts. This coarse, 5 % is good."""
    found = search(ground, "strength-reduction").run()
    assert found.width <= 0.01
    assert found.value == pytest.approx(1.38, rel=0.05)


def test_clay_has_one_factor():
    """phi = 0: strength reduction and gravity increase are the same question."""
    clay = slope(1.1, c=50e3, phi=0.0)
    factors = [
        search(clay, kind, start=1.5).run().value for kind in ("strength-reduction", "gravity-increase")
    ]
    assert factors[1] == pytest.approx(factors[0], rel=0.011)


def test_a_start_from_above_finds_the_same(ground):
    low = search(ground, "strength-reduction", start=0.8).run()
    high = search(ground, "strength-reduction", start=3.0).run()
    assert max(low.stable, high.stable) < min(low.failed, high.failed)


def test_a_search_stopped_in_the_middle_ends_with_the_same_bits(ground):
    whole = search(ground, "strength-reduction", tolerance=0.02)
    whole.run()

    class Stop(Exception):
        pass

    looks = 0

    def stop(search):
        nonlocal looks
        looks += 1
        if looks == 17 and search.current is not None:
            raise Stop

    half = search(ground, "strength-reduction", tolerance=0.02)
    with pytest.raises(Stop):
        half.run(stop)
    rest = search(ground, "strength-reduction", tolerance=0.02)
    rest.trials, rest.stable, rest.failed = half.trials, half.stable, half.failed
    rest.continue_trial(half.current, half.history, half.simulation.state.copy())
    rest.run()

    def figures(search):
        return [(t.factor, t.verdict, t.steps, t.unbalanced, t.displacement) for t in search.trials]

    assert figures(rest) == figures(whole)
    assert rest.failed.state.stress.tobytes() == whole.failed.state.stress.tobytes()


def test_kept_states_are_those_of_the_bracket(ground):
    done = search(ground, "strength-reduction", tolerance=0.05)
    found = done.run()
    assert (done.stable.factor, done.failed.factor) == (found.stable, found.failed)
    assert done.failed.state.displacement is not done.simulation.state.displacement
    assert np.abs(done.failed.state.displacement).max() > np.abs(done.stable.state.displacement).max()


def pressed(strength=10e3, unit_weight=0.0):
    """A block 3 m wide and high on a smooth base, pressed from above by 1 kPa; phi = 0."""
    positions, triangles = mesh([(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)], 0.3)
    held = np.zeros_like(positions, dtype=bool)
    held[positions[:, 1] == 0.0, 1] = True
    held[(positions[:, 0] == 0.0), 0] = True
    top = np.flatnonzero(positions[:, 1] == 3.0)
    top = top[np.argsort(-positions[top, 0])]
    load = pressure_load(positions, np.column_stack([top[:-1], top[1:]]), 1e3)
    return model(
        positions, triangles, soil(c=strength, phi=0.0), held=held, load=load, unit_weight=unit_weight
    )


def test_load_increase_crushes_a_block():
    """Plane strain, phi = 0: a free block between smooth plates bears 2 c = 20 kPa, whatever the mesh."""
    found = search(pressed(), "load-increase", start=15.0, step=0.1).run()
    assert found.stable <= 20.0 * 1.002
    assert found.failed >= 20.0 * 0.998
    assert found.width <= 0.01


def test_methods_set_what_they_say(ground):
    loaded = replace(ground, load=np.full((ground.particles, 2), 100.0))
    simulation = Simulation(loaded)
    unit = Simulation(ground).elastic.stress
    gravity, load = GravityIncrease(simulation), LoadIncrease(simulation)
    stress = simulation.elastic.stress
    twice = gravity.stress_at(simulation, stress, 1.0, 2.0)
    assert twice == pytest.approx(stress + unit, rel=1e-9, abs=1e-6 * np.abs(unit).max())
    both = load.stress_at(simulation, twice, 1.0, 2.0)
    assert both == pytest.approx(2.0 * stress, rel=1e-9, abs=1e-6 * np.abs(unit).max())
    gravity.apply(simulation, 2.0)
    load.apply(simulation, 2.0)
    assert simulation.external == pytest.approx(2.0 * (loaded.weight + loaded.load))


@pytest.mark.parametrize("kind", [StrengthReduction, GravityIncrease, LoadIncrease])
def test_methods_by_name(kind):
    assert isinstance(make_method(kind.kind, Simulation(pressed(unit_weight=1.0))), kind)
