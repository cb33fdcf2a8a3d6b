"""Random sequential addition: no overlap, the literature's saturation, even spread, seeds and threads."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from geodem.builders.random_addition import scatter_particles
from geodem.builders.sizes import equal, graded, uniform
from geodem.errors import InputError


def smallest_gap(packing):
    """Of all pairs, one by one, through the faces of a periodic box [m]."""
    step = packing.positions[:, None, :] - packing.positions[None, :, :]
    if packing.periodic:
        step -= packing.box * np.round(step / packing.box)
    gap = np.linalg.norm(step, axis=-1) - packing.radii[:, None] - packing.radii[None, :]
    return gap[np.triu_indices(len(gap), 1)].min()


@pytest.mark.parametrize(
    ("dimension", "sizes", "fraction", "periodic"),
    [
        (2, equal(0.5), 0.5, True),
        (2, uniform(0.1, 1.0), 0.55, False),
        (3, equal(0.5), 0.34, False),
        (3, graded([(0.3, 0.0), (0.6, 0.5), (2.0, 1.0)], 3), 0.38, True),
    ],
)  # fmt: skip
def test_no_two_overlap_and_all_lie_inside(dimension, sizes, fraction, periodic):
    packing = scatter_particles(
        dimension, sizes, count=1200, solid_fraction=fraction, periodic=periodic, seed=2
    )
    assert smallest_gap(packing) >= 0.0
    assert packing.solid_fraction == pytest.approx(fraction, rel=1e-12)
    assert packing.largest_overlap == 0.0
    edge = 0.0 if periodic else packing.radii[:, None]
    assert (packing.positions - edge >= 0.0).all()
    assert (packing.positions + edge <= packing.box).all()
    # pairs nearly touch: more than neighbours in a grid
    assert smallest_gap(packing) < 0.01 * packing.radii.mean()


# Zhang & Torquato (2013), Phys. Rev. E 88:053312. Numbers of particles in saturated boxes scatter by about a quarter of
# a root of their number, the structure factor at the origin being near 0.06: 0.12 % in 2D and 0.17 % in 3D
@pytest.mark.parametrize(
    ("dimension", "count", "asked", "saturated"),
    [(2, 40_000, 0.551, 0.5470735), (3, 20_000, 0.388, 0.3841307)],
)
def test_equal_particles_fill_the_box_as_far_as_the_literature_says(dimension, count, asked, saturated):
    with pytest.raises(InputError, match="grow_radii") as caught:
        scatter_particles(dimension, equal(0.5), count=count, solid_fraction=asked, seed=4)
    reached = float(re.search(r"solid fraction of ([\d.]+)", str(caught.value)).group(1))
    assert reached == pytest.approx(saturated, rel=4e-3)
    with pytest.raises(InputError, match=f"{saturated:.3f}"):
        scatter_particles(dimension, equal(0.5), count=count, solid_fraction=0.8, seed=4)


def test_places_are_spread_evenly():
    packing = scatter_particles(2, equal(0.5), count=20_000, solid_fraction=0.3, seed=5)
    counts, *_ = np.histogram2d(
        *packing.positions.T, bins=10, range=[(0, packing.box[0]), (0, packing.box[1])]
    )
    # hard discs keep the numbers in cells closer to their mean than independent points, whose variance it is
    assert counts.var() < counts.mean()
    assert abs(counts[:5].sum() - 10_000) < 3.0 * np.sqrt(20_000) / 2.0


def test_the_third_of_box_count_and_fraction_follows():
    sizes = uniform(0.05, 0.15)
    by_box = scatter_particles(2, sizes, box=(10.0, 5.0), solid_fraction=0.4, periodic=False, seed=1)
    assert by_box.solid_fraction == pytest.approx(0.4, rel=2e-3)
    fixed = scatter_particles(2, sizes, box=(10.0, 5.0), count=300, seed=1)
    assert fixed.particles == 300
    assert fixed.solid_fraction == pytest.approx(np.pi * (fixed.radii**2).sum() / 50.0)
    assert fixed.box.tolist() == [10.0, 5.0]


SCRIPT = """
import hashlib
from geodem.builders.random_addition import scatter_particles
from geodem.builders.sizes import equal
packing = scatter_particles(3, equal(0.5), count=1500, solid_fraction=0.372, seed=7)
print(hashlib.sha256(packing.positions.tobytes()).hexdigest())
"""


def test_a_seed_gives_the_same_bits_on_any_number_of_threads():
    # so dense that voxels are needed, which are looked at by all threads
    packing = scatter_particles(3, equal(0.5), count=1500, solid_fraction=0.372, seed=7)
    here = hashlib.sha256(packing.positions.tobytes()).hexdigest()
    for threads in (1, 3):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True,
            env={**os.environ, "NUMBA_NUM_THREADS": str(threads)},
        )  # fmt: skip
        assert done.stdout.strip() == here
    other = scatter_particles(3, equal(0.5), count=1500, solid_fraction=0.372, seed=8)
    assert (other.positions != packing.positions).any()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"count": 10}, "two of box, count and solid_fraction"),
        ({"count": 10, "solid_fraction": 0.2, "box": (1.0, 1.0)}, "two of box, count and solid_fraction"),
        ({"count": 0, "solid_fraction": 0.2}, "whole number from 1"),
        ({"count": 10, "solid_fraction": 1.2}, "no share of a box"),
        ({"count": 10, "solid_fraction": 0.2, "seed": -1}, "whole number from 0"),
        ({"count": 10, "box": (0.5, 9.0)}, "narrower than a particle"),
        ({"count": 10, "box": (5.0, 9.0, 1.0)}, "2 positive numbers"),
        ({"box": (1.0, 1.0), "solid_fraction": 0.1}, "too small for one"),
        ({"count": 10, "solid_fraction": 0.2, "sizes": graded([(1.0, 0.0), (2.0, 1.0)], 3)}, "for 3D"),
    ],
)
def test_wrong_input_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        scatter_particles(2, given.pop("sizes", equal(0.5)), **{"seed": 1, **given})
