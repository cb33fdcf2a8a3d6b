"""The simulation: equilibrium, bits, energy, and what it does with numbers that are none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geodem.simulation import SERIAL_LIMIT, Simulation, UnstableError
from geodem.state import FIELDS
from tests.meshes import slope

ROOT = Path(__file__).parents[1]

BITS = """
import hashlib, sys
sys.path.insert(0, sys.argv[2])
from tests.meshes import slope
from geodem import _jit
from geodem.simulation import Simulation
assert _jit.set_threads(int(sys.argv[1])) == int(sys.argv[1])
simulation = Simulation(slope(0.55))
simulation.set_strength(1.5)
simulation.run(200)
state = simulation.state
digest = hashlib.sha256(b"".join(array.tobytes() for array in state.arrays().values()))
digest.update(repr(sorted(state.numbers().items())).encode())
print(simulation.model.particles, digest.hexdigest())
"""


@pytest.fixture(scope="module")
def ground():
    """A 2:1 slope of about 300 particles; F = 1.4."""
    return slope(0.9)


def same_bits(one, other):
    return all(
        a.tobytes() == b.tobytes()
        for a, b in zip(one.arrays().values(), other.arrays().values(), strict=True)
    )


def test_the_slope_takes_the_serial_kernel(ground):
    assert 200 < ground.particles < SERIAL_LIMIT


def test_one_and_two_threads_compiled_and_from_the_cache_give_the_same_bits(tmp_path):
    """The first process compiles into an empty folder, the second finds the kernel there."""
    answers = []
    for threads in ("1", "2"):
        environment = {**os.environ, "NUMBA_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
        environment["GEODEM_CACHE"] = str(tmp_path)
        done = subprocess.run(
            [sys.executable, "-c", BITS, threads, str(ROOT)],
            env=environment,
            check=True,
            capture_output=True,
            text=True,
        )
        answers.append(done.stdout.split())
    assert int(answers[0][0]) > SERIAL_LIMIT
    assert answers[0] == answers[1]


def test_a_stored_state_goes_on_with_the_same_bits(ground):
    """A run, and a run from a copy of its half-way state in a simulation of its own."""
    one, other = Simulation(ground), Simulation(ground)
    for simulation in (one, other):
        simulation.set_strength(1.5)
    one.run(100)
    other.state = one.state.copy()
    one.run(100)
    assert not same_bits(one.state, other.state), "the copy is its own"
    other.run(100)
    assert same_bits(one.state, other.state)
    assert one.state.numbers() == other.state.numbers()


def test_batches_do_not_matter(ground):
    one, other = Simulation(ground), Simulation(ground)
    one.run(120)
    for _ in range(3):
        other.run(40)
    assert same_bits(one.state, other.state)


def test_the_energy_account_changes_nothing(ground):
    """The account adds up what happens; what happens is the same to the last bits but one."""
    with_, without = Simulation(ground, energy=True), Simulation(ground, energy=False)
    for simulation in (with_, without):
        simulation.set_strength(1.3)
        simulation.run(400)
    scale = np.abs(with_.state.displacement).max()
    assert np.abs(with_.state.displacement - without.state.displacement).max() < 1e-9 * scale
    assert with_.state.dissipation.sum() > 0.0
    assert not without.state.dissipation.any()


def test_relaxation_finds_the_solved_state(ground):
    """Elastic ground from a stress-free start, against the sparse solve."""
    simulation = Simulation(ground, plastic=False)
    simulation.begin(np.zeros_like(simulation.elastic.stress))
    measures = simulation.relax(1e-9)
    assert measures.unbalanced_ratio < 1e-9
    solved = simulation.elastic
    assert (
        np.abs(simulation.state.displacement - solved.displacement).max()
        < 1e-6 * np.abs(solved.displacement).max()
    )
    assert np.abs(simulation.state.stress[:, :3] - solved.stress).max() < 1e-6 * np.abs(solved.stress).max()


def test_the_solved_state_is_at_rest(ground):
    simulation = Simulation(ground, plastic=False)
    measures = simulation.run(20)
    assert measures.unbalanced_ratio < 1e-10
    assert np.abs(simulation.state.displacement).max() < 1e-9 * np.abs(simulation.elastic.displacement).max()


def test_strong_ground_stays_and_weak_ground_goes(ground):
    """Griffiths & Lane 1999: F = 1.4. Stress is borne everywhere in between."""
    simulation = Simulation(ground)
    simulation.set_strength(1.2)
    assert simulation.relax(1e-6, max_steps=5000).unbalanced_ratio < 1e-6
    resting = simulation.mean_size(simulation.state.displacement)
    simulation.set_strength(1.6)
    simulation.begin()
    assert simulation.relax(1e-6, max_steps=2000).unbalanced_ratio > 1e-3
    assert simulation.mean_size(simulation.state.displacement) > 10.0 * resting


def test_loads_are_carried_by_the_supports(ground):
    simulation = Simulation(ground, plastic=False)
    simulation.run(1)
    # 220 m2 of 20 kN/m3; what the supports carry is what is unbalanced in the held particles
    assert simulation.state.force[ground.held[:, 1], 1].sum() == pytest.approx(-220 * 20e3, rel=1e-9)


def test_factors_of_gravity_and_load_are_independent():
    load = np.zeros((slope(2.0).particles, 2))
    load[5] = [3.0, -7.0]
    ground = slope(2.0)
    simulation = Simulation(_with_load(ground, load))
    simulation.set_gravity(2.0)
    simulation.set_load(5.0)
    assert simulation.external == pytest.approx(2.0 * ground.weight + 5.0 * load)
    simulation.set_gravity(1.0)
    assert simulation.external == pytest.approx(ground.weight + 5.0 * load)


def _with_load(ground, load):
    from dataclasses import replace

    return replace(ground, load=load)


@pytest.mark.parametrize(
    ("label", "material"),
    [
        ("associated", {}),
        ("no dilation", {"psi": 0.0}),
        ("no tension", {"tension": 0.0}),
        ("sand", {"c": 100.0, "phi": 35.0, "psi": 35.0}),
    ],
)
def test_energy_closes_in_a_run_to_failure(label, material):
    """Work of gravity = elastic + plastic + damping + kinetic, while the slope comes down."""
    simulation = Simulation(slope(0.9, **material))
    simulation.set_strength(2.0)
    simulation.run(3000)
    account = simulation.energy()
    moved = simulation.mean_size(simulation.state.displacement)
    assert moved > 20.0 * simulation.elastic.mean_displacement, "the slope is meant to come down"
    assert account.plastic > 0.01 * account.external_work
    assert abs(account.closure) < 1e-3


def test_numbers_that_are_none_stop_the_run(ground):
    simulation = Simulation(ground)
    simulation.state.velocity[17, 0] = np.nan
    with pytest.raises(UnstableError, match="not finite"):
        simulation.run(10)


def test_overflow_stops_the_run(ground):
    simulation = Simulation(ground, plastic=False)
    simulation.inverse_mass *= 1.5
    with pytest.raises(UnstableError, match="not finite"):
        simulation.run(50_000)


def test_every_array_of_the_state_is_in_the_table(ground):
    state = Simulation(ground).state
    assert set(state.arrays()) == {field.name for field in FIELDS}
    arrays = {name for name, value in vars(state).items() if isinstance(value, np.ndarray)}
    assert arrays == {field.name for field in FIELDS}
    rows = {
        "(particles, 2)": (ground.particles, 2),
        "(stress points,)": (ground.stress_points,),
        "(links, 3)": (0, 3),
    }
    for field in FIELDS:
        expected = rows.get(field.shape, (ground.stress_points, 4))
        assert getattr(state, field.name).shape == expected
