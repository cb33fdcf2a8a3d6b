"""Lattices against their closed forms; random packings: dense, without overlap, the same on any number of threads."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geodem.builders.packings import lattice
from geodem.builders.random_packing import random_packing
from geodem.errors import InputError

# solid fraction and coordination number, e.g. Conway & Sloane, Sphere Packings, Lattices and Groups, ch. 1
LATTICES = {
    "square": (math.pi / 4, 4),
    "hexagonal": (math.pi / math.sqrt(12), 6),
    "simple_cubic": (math.pi / 6, 6),
    "bcc": (math.pi * math.sqrt(3) / 8, 8),
    "fcc": (math.pi / math.sqrt(18), 12),
    "hcp": (math.pi / math.sqrt(18), 12),
}


def neighbours(packing, reach):
    """Numbers of particles within `reach` of each one, through the faces of a periodic box."""
    tree = cKDTree(packing.positions % packing.box, boxsize=packing.box)
    return np.array([len(near) - 1 for near in tree.query_ball_point(tree.data, reach)])


def largest_overlap(packing):
    """Over the smaller radius, from all pairs within the largest diameter."""
    box = packing.box if packing.periodic else None
    tree = cKDTree(packing.positions, boxsize=box)
    pairs = tree.query_pairs(2.0 * packing.radii.max(), output_type="ndarray")
    step = packing.positions[pairs[:, 1]] - packing.positions[pairs[:, 0]]
    if packing.periodic:
        step -= packing.box * np.round(step / packing.box)
    radii = packing.radii[pairs]
    return float(np.max((radii.sum(axis=1) - np.linalg.norm(step, axis=1)) / radii.min(axis=1), initial=0.0))


@pytest.mark.parametrize("kind", LATTICES)
def test_lattice_has_the_fraction_and_coordination_of_its_closed_form(kind):
    fraction, coordination = LATTICES[kind]
    dimension = 2 if kind in ("square", "hexagonal") else 3
    packing = lattice(kind, 0.35, cells=(4,) * dimension)
    assert packing.solid_fraction == pytest.approx(fraction, rel=1e-12)
    assert set(neighbours(packing, 0.7 * (1.0 + 1e-9))) == {coordination}
    assert set(neighbours(packing, 0.7 * (1.0 - 1e-9))) == {0}


@pytest.mark.parametrize("kind", LATTICES)
def test_box_is_filled_up_to_its_walls_and_no_further(kind):
    dimension = 2 if kind in ("square", "hexagonal") else 3
    packing = lattice(kind, 0.5, box=(6.0, 7.3, 8.1)[:dimension])
    assert (packing.positions >= 0.5 - 1e-8).all()
    assert (packing.positions <= packing.box - 0.5 + 1e-8).all()
    # less than one layer is missing at the far walls
    assert (packing.positions.max(axis=0) > packing.box - 0.5 - 1.2).all()
    assert not packing.periodic


def test_square_lattice_has_a_row_for_every_diameter():
    # a whole number of diameters: rounding must not cost a row
    assert lattice("square", 0.05, box=(1.0, 0.7)).particles == 70
    assert lattice("square", 0.05, box=(0.9999, 0.7)).particles == 63


def test_gap_sets_the_distance_of_surfaces():
    apart = lattice("fcc", 1.0, cells=(3, 3, 3), gap=0.1)
    assert cKDTree(apart.positions, boxsize=apart.box).query(apart.positions, k=2)[0][:, 1] == pytest.approx(
        2.1
    )
    pressed = lattice("hexagonal", 1.0, cells=(3, 3), gap=-0.1)
    assert pressed.largest_overlap == pytest.approx(0.1)
    assert largest_overlap(pressed) == pytest.approx(0.1)


def test_random_spheres_are_dense_without_overlap():
    packing = random_packing(3, radius=0.5, count=2000, seed=3)
    assert packing.particles == 2000
    assert packing.solid_fraction == pytest.approx(0.62, rel=1e-9)
    assert packing.solid_fraction == pytest.approx(2000 * 4 / 3 * math.pi * 0.5**3 / np.prod(packing.box))
    assert packing.largest_overlap <= 1e-12
    assert largest_overlap(packing) <= 1e-12
    # random close packings have about six contacts; here nearly so
    assert 4.0 < neighbours(packing, 1.02).mean() < 8.0


def test_random_discs_of_two_to_three_fill_a_box_without_overlap():
    packing = random_packing(2, radius=1.0, size_ratio=1.5, box=(70.0, 50.0), seed=3)
    assert packing.solid_fraction == pytest.approx(0.83, abs=1e-3)
    assert packing.radii.max() <= 1.0
    assert packing.radii.min() >= 1.0 / 1.5
    assert largest_overlap(packing) <= 1e-12


def test_jammed_packing_says_how_much_overlap_is_left():
    packing = random_packing(3, radius=0.5, count=800, solid_fraction=0.66, seed=3)
    assert packing.largest_overlap > 0.01
    assert largest_overlap(packing) == pytest.approx(packing.largest_overlap, rel=1e-6)


def test_closed_box_holds_all_particles():
    packing = random_packing(2, radius=0.5, size_ratio=1.4, box=(20.0, 30.0), periodic=False, seed=3)
    depth = 1.0 - np.minimum(packing.positions, packing.box - packing.positions).min(axis=1) / packing.radii
    assert depth.max() <= packing.largest_overlap + 1e-12
    assert packing.largest_overlap < 0.02
    assert packing.solid_fraction == pytest.approx(0.83, abs=0.005)


def test_wide_spread_of_sizes_is_packed_too():
    packing = random_packing(2, radius=1.0, size_ratio=12.0, box=(25.0, 25.0), seed=1)
    assert largest_overlap(packing) <= 1e-12
    assert packing.radii.max() / packing.radii.min() > 10.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_grading_is_met_by_area_or_volume(dimension):
    curve = [(0.1, 0.0), (0.2, 0.5), (0.4, 1.0)]
    packing = random_packing(dimension, grading=curve, count=4000, seed=1, most_steps=0)
    share = packing.radii**dimension / (packing.radii**dimension).sum()
    for radius, passing in ((0.15, 0.25), (0.2, 0.5), (0.3, 0.75)):
        assert share[packing.radii <= radius].sum() == pytest.approx(passing, abs=0.01)


def test_grading_of_two_sizes():
    packing = random_packing(
        2, grading=[(1, 0), (1, 0.5), (2, 0.5), (2, 1)], count=1000, seed=1, most_steps=0
    )
    # equal areas: four small discs for every large one
    assert np.unique(packing.radii, return_counts=True)[1].tolist() == [800, 200]


def test_tiles_repeat_the_packing_and_fit_each_other():
    one = random_packing(3, radius=0.5, count=300, seed=5)
    many = one.tile(2, 1, 3)
    assert many.particles == 1800
    assert many.box == pytest.approx(one.box * [2, 1, 3])
    assert many.solid_fraction == one.solid_fraction
    assert largest_overlap(many) <= 1e-9
    assert neighbours(many, 1.02).mean() == pytest.approx(neighbours(one, 1.02).mean())


def test_seed_decides():
    first, second = (random_packing(2, radius=1.0, size_ratio=1.3, count=200, seed=s) for s in (1, 2))
    assert not np.array_equal(first.positions, second.positions)


def test_bits_do_not_depend_on_the_number_of_threads():
    # more particles than one block
    code = (
        "import hashlib; from geodem.builders.random_packing import random_packing;"
        "p = random_packing(3, radius=1.0, size_ratio=1.5, count=1500, seed=1);"
        "print(hashlib.sha256(p.positions.tobytes()).hexdigest())"
    )
    mine = random_packing(3, radius=1.0, size_ratio=1.5, count=1500, seed=1)
    found = {hashlib.sha256(mine.positions.tobytes()).hexdigest()}
    for threads in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"NUMBA_NUM_THREADS": threads}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        found.add(run.stdout.strip())
    assert len(found) == 1


@pytest.mark.parametrize(
    ("arguments", "place", "remedy"),
    [
        ({"radius": -1.0, "count": 10}, "radius", "Give m"),
        ({"radius": 1.0}, "random packing", "one of the two"),
        ({"radius": 1.0, "count": 10, "box": (9, 9, 9)}, "random packing", "one of the two"),
        ({"count": 10}, "random packing", "one of the two"),
        ({"radius": 1.0, "count": 0}, "count", "10000"),
        ({"radius": 1.0, "count": 500, "size_ratio": 0.5}, "size_ratio", "1.5"),
        ({"radius": 1.0, "count": 500, "solid_fraction": 0.8}, "solid_fraction", "0.64"),
        ({"radius": 1.0, "count": 10}, "box", "at least 4."),
        ({"radius": 1.0, "box": (9, 9)}, "box", "sides"),
        ({"radius": 1.0, "count": 500, "seed": -1}, "seed", "Give 1"),
        ({"grading": [(1, 0), (2, 0.9)], "count": 500}, "grading", "for instance"),
        ({"grading": [(2, 0), (1, 1)], "count": 500}, "grading", "for instance"),
        ({"grading": [(0, 0), (1, 1)], "count": 500}, "grading", "Mend"),
    ],
)
def test_bad_requests_say_where_and_what_to_do(arguments, place, remedy):
    with pytest.raises(InputError) as error:
        random_packing(3, **({"seed": 1} | arguments))
    assert place in error.value.place
    assert remedy in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "place", "remedy"),
    [
        (("hexagnal", 1.0), "lattice", "'hexagonal'"),
        (("fcc", math.nan), "radius", "metres"),
        (("fcc", 1.0), "lattice", "one of the two"),
    ],
)
def test_bad_lattices_say_where_and_what_to_do(arguments, place, remedy):
    with pytest.raises(InputError) as error:
        lattice(*arguments)
    assert place in error.value.place
    assert remedy in str(error.value)


def test_box_without_room_and_closed_packing_without_tiles():
    with pytest.raises(InputError, match=r"box.*no particle fits.*at least 2 m"):
        lattice("square", 1.0, box=(5.0, 1.9))
    with pytest.raises(InputError, match=r"not periodic.*periodic=True"):
        lattice("square", 1.0, box=(5.0, 5.0)).tile(2, 2)
    with pytest.raises(InputError, match=r"tile.*Give 2"):
        lattice("square", 1.0, cells=(2, 2)).tile(2)
