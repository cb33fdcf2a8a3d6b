"""Deposition: heaps at rest, their weight on the floor, contacts near isostatic, resumed runs, samples in files."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geodem.boundaries.walls import plane
from geodem.builders.sizes import equal, uniform
from geodem.errors import InputError
from geodem.preparation import Grains, PreparedSample, deposit
from geodem.preparation.deposition import solid_fraction_between
from geodem.preparation.sample import mechanical_coordination

GRAINS = Grains(2600.0, {"normal_stiffness": 2e6, "shear_stiffness": 1e6, "friction_coefficient": 0.5})
SIZES = uniform(0.015, 0.03)
HEAP = {"width": (0.45,), "count": 110, "local_damping": 0.3, "seed": 1}


@pytest.fixture(scope="module")
def heap():
    return deposit(2, GRAINS, SIZES, wall_friction=0.0, tolerance=1e-4, **HEAP)


@pytest.fixture(scope="module")
def smooth():
    return deposit(2, GRAINS, SIZES, friction=0.0, tolerance=1e-4, **HEAP)


def test_heap_is_at_rest_and_its_weight_on_the_floor(heap):
    assert heap.reached
    assert heap.unbalanced_ratio < 1e-4
    weight = 9.81 * 2600.0 * math.pi * (heap.radii**2).sum()
    assert heap.wall_forces["floor"][1] == pytest.approx(-weight, rel=2e-4)
    # smooth sides carry nothing downwards, and each what the other does
    assert heap.wall_forces["left"][1] == 0.0
    assert heap.wall_forces["left"][0] == pytest.approx(-heap.wall_forces["right"][0], abs=1e-3 * weight)
    assert np.abs(heap.simulation.velocities).max() < 0.01
    assert (heap.positions[:, 1] > 0.9 * heap.radii).all()
    assert (heap.positions[:, 0] > 0.9 * heap.radii).all()
    assert (heap.positions[:, 0] < 0.45 - 0.9 * heap.radii).all()
    assert heap.largest_overlap < 0.05
    # mean vertical stress: half of what stands on the floor, somewhat less as the surface is not even
    mean = heap.stress[1, 1]
    assert mean == pytest.approx(-0.5 * weight / 0.45, rel=0.1)


def test_contacts_are_near_isostatic(heap, smooth):
    """2 d contacts a particle without friction, between d + 1 and 2 d with it: e.g. O'Hern et al. (2003), Phys. Rev. E
    68:011306, and Silbert et al. (2002), Phys. Rev. E 65:031304."""
    # the upper surface has fewer, the pressure some more
    assert smooth.mechanical_coordination == pytest.approx(4.0, abs=0.15)
    assert 3.0 < heap.mechanical_coordination < smooth.mechanical_coordination - 0.2
    assert smooth.porosity < heap.porosity
    assert smooth.grains.friction == 0.0


def test_contacts_and_porosity_are_those_of_the_positions(heap):
    """Counted here pair by pair, and the layer point by point."""
    step = heap.positions[:, None] - heap.positions[None]
    gap = np.linalg.norm(step, axis=-1) - heap.radii[:, None] - heap.radii[None]
    pairs = np.argwhere(np.triu(gap < 0.0, 1))
    assert (pairs == heap.pairs).all()
    on_walls = (heap.positions[:, 1] < heap.radii).sum()
    on_walls += (heap.positions[:, 0] < heap.radii).sum() + (heap.positions[:, 0] > 0.45 - heap.radii).sum()
    assert heap.coordination == pytest.approx((2 * len(pairs) + on_walls) / 110)
    depth = -gap[tuple(pairs.T)] / heap.radii[pairs].min(axis=1)
    assert heap.largest_overlap == pytest.approx(depth.max(), rel=1e-9)
    low, high = heap.container
    grid = np.stack(
        np.meshgrid(*[np.linspace(a, b, 401)[:-1] + (b - a) / 800 for a, b in zip(low, high, strict=True)]),
        -1,
    )
    points = grid.reshape(-1, 2)
    inside = np.zeros(len(points), dtype=bool)
    for centre, radius in zip(heap.positions, heap.radii, strict=True):
        inside |= ((points - centre) ** 2).sum(axis=1) < radius**2
    assert heap.porosity == pytest.approx(1.0 - inside.mean(), abs=2e-3)


def test_layers_cut_particles_exactly():
    """Caps of a sphere pi h^2 (3 - h)/3 and segments of a disc arccos(1 - h) - (1 - h) sqrt(2 h - h^2), of radius 1."""
    for height in (0.3, 1.0, 1.6):
        corners = np.array([[0.0, 0.0, -1.0], [2.0, 3.0, -1.0 + height]])
        cap = math.pi * height**2 * (3.0 - height) / 3.0
        found = solid_fraction_between(np.zeros((1, 3)), np.ones(1), corners)
        assert found == pytest.approx(cap / (6.0 * height), rel=1e-12)
        segment = math.acos(1.0 - height) - (1.0 - height) * math.sqrt(2.0 * height - height**2)
        found = solid_fraction_between(np.zeros((1, 2)), np.ones(1), corners[:, 1:])
        assert found == pytest.approx(segment / (3.0 * height), rel=1e-12)


def test_rattlers_are_left_out_again_and_again():
    # a triangle of discs with a tail of two: the tail goes, disc by disc
    pairs = np.array([[0, 1], [1, 2], [0, 2], [2, 3], [3, 4]])
    nothing = np.empty(0, dtype=np.int64)
    assert mechanical_coordination(pairs, nothing, 6, 2) == 2.0
    assert mechanical_coordination(pairs, nothing, 6, 3) == 0.0
    # a wall under the three: 3 contacts each
    assert mechanical_coordination(pairs, np.array([0, 1, 2]), 6, 3) == 3.0


def test_run_that_was_cut_goes_on_to_the_same_bits(tmp_path, heap):
    path = tmp_path / "heap.h5"
    settings = {
        "wall_friction": 0.0,
        "tolerance": 1e-4,
        "checkpoint": path,
        "checkpoint_seconds": 5.0,
        **HEAP,
    }
    first = deposit(2, GRAINS, SIZES, most_steps=3000, **settings)
    assert not first.reached
    assert "not at rest after 3,000 steps" in first.reason
    assert "NOT reached" in first.summary()
    told = []
    whole = deposit(2, GRAINS, SIZES, progress=lambda steps, ratio: told.append(steps), **settings)
    assert told[0] == 3200
    assert whole.steps == heap.steps
    assert (whole.positions == heap.positions).all()
    with pytest.raises(InputError, match="another preparation"):
        deposit(2, GRAINS, SIZES, **(settings | {"seed": 2}))
    with pytest.raises(InputError, match="another preparation"):
        deposit(2, GRAINS, SIZES, **(settings | {"wall_friction": 0.4}))


def test_sample_comes_back_from_its_file(tmp_path, heap):
    path = tmp_path / "heap.npz"
    heap.save(path)
    found = PreparedSample.load(path)
    assert found.simulation is None
    assert found.summary() == heap.summary()
    assert found.grains == heap.grains
    for name in ("positions", "radii", "container", "pairs"):
        assert (getattr(found, name) == getattr(heap, name)).all()
    assert found.history.keys() == heap.history.keys()
    assert (found.wall_forces["floor"] == heap.wall_forces["floor"]).all()
    assert found.assembly().particles == 110
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(InputError, match="damaged or cut off"):
        PreparedSample.load(path)
    np.savez(tmp_path / "other.npz", positions=np.zeros(3))
    with pytest.raises(InputError, match="damaged"):
        PreparedSample.load(tmp_path / "other.npz")
    with pytest.raises(InputError, match="there is no sample"):
        PreparedSample.load(tmp_path / "none.npz")


def test_own_walls_catch_the_rain():
    funnel = [
        plane("left", (0.25, -0.3), (1.0, 1.0)),
        plane("right", (0.25, -0.3), (-1.0, 1.0)),
    ]
    sample = deposit(2, GRAINS, SIZES, walls=funnel, **(HEAP | {"count": 40, "tolerance": 1e-3}))
    assert sample.reached
    assert math.isnan(sample.porosity)
    weight = 9.81 * 2600.0 * math.pi * (sample.radii**2).sum()
    assert -sum(force[1] for force in sample.wall_forces.values()) == pytest.approx(weight, rel=5e-3)


SCRIPT = """
import hashlib
from geodem.builders.sizes import uniform
from geodem.preparation import Grains, deposit
contact = {"normal_stiffness": 2e6, "shear_stiffness": 1e6, "friction_coefficient": 0.5}
sample = deposit(2, Grains(2600.0, contact), uniform(0.015, 0.03), width=(1.5,), count=450, local_damping=0.3, seed=1,
                 most_steps=4000)
print(hashlib.sha256(sample.positions.tobytes()).hexdigest(), len(sample.pairs))
"""


def test_a_seed_gives_the_same_bits_on_any_number_of_threads(tmp_path):
    told = []
    for threads in (1, 2):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False,
            env={**os.environ, "NUMBA_NUM_THREADS": str(threads)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        told.append(done.stdout.split())
    assert told[0] == told[1]
    assert int(told[0][1]) > 300


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"width": (0.6, 0.6)}, "1 of them"),
        ({"width": (0.03,)}, "narrower than a particle"),
        ({"count": 0}, "whole number from 1"),
        ({"gravity": 0.0}, "nothing falls"),
        ({"tolerance": 0.0}, "no balance is that good"),
        ({"most_steps": 0}, "no number of steps"),
        ({"friction": -0.1}, "no friction coefficient"),
        ({"rain_fraction": 1.5}, "no share of a box"),
        ({"local_damping": 1.0}, "local_damping"),
        ({"sizes": equal(0.02), "rain_fraction": 0.7}, "0.547"),
    ],
)  # fmt: skip
def test_wrong_input_is_refused(given, words):
    given = HEAP | given
    with pytest.raises(InputError, match=words):
        deposit(2, GRAINS, given.pop("sizes", SIZES), **given)


def test_rain_that_nothing_catches_is_told():
    gap = [plane("left", (0.0, 0.0), (1.0, 0.0))]
    sample = deposit(2, GRAINS, SIZES, walls=gap, **(HEAP | {"count": 5}))
    assert not sample.reached
    assert "fell past the walls" in sample.reason


def test_friction_of_a_law_without_it_is_refused():
    spheres = Grains(2600.0, {"young_modulus": 1e8, "poisson_ratio": 0.3}, contact_law="hertz")
    assert spheres.with_friction(0.0) is spheres
    with pytest.raises(InputError, match="has no friction_coefficient"):
        spheres.with_friction(0.3)
    with pytest.raises(InputError, match="no such law"):
        Grains(2600.0, {}, contact_law="hertzz").with_friction(0.3)
