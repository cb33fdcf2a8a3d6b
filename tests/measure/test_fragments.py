"""Connected pieces of graphs drawn by hand: every expected value is counted on paper."""

import math

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.measure.fragments import find_fragments

#   0 - 1 - 2     3 - 4     5     6 - 7 (broken)
PLACES = np.array([[0, 0], [1, 0], [2, 0], [5, 0], [5, 1], [8, 0], [10, 0], [11, 0]], dtype=float)
RADII = np.full(8, 0.5)
MASS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 0.5, 0.25, 0.75])
BONDS = np.array([[0, 1], [1, 2], [3, 4], [6, 7]])
INTACT = np.array([True, True, True, False])


def pieces(**more):
    return find_fragments(PLACES, RADII, MASS, BONDS, INTACT, **more)


def test_pieces_are_what_unbroken_bonds_join_heaviest_first():
    found = pieces()
    assert found.count == 5
    # masses 4, 3, 0.75, 0.5, 0.25
    np.testing.assert_array_equal(found.piece_of, [1, 1, 1, 0, 0, 3, 4, 2])
    np.testing.assert_array_equal(found.particles, [2, 3, 1, 1, 1])
    np.testing.assert_allclose(found.mass, [4.0, 3.0, 0.75, 0.5, 0.25])
    np.testing.assert_array_equal(found.single, [False, False, True, True, True])


def test_an_unbroken_bond_makes_one_piece_of_two():
    found = find_fragments(PLACES, RADII, MASS, BONDS)
    assert found.count == 4
    assert found.piece_of[6] == found.piece_of[7]


def test_boxes_reach_to_the_surfaces_of_grains_and_centres_are_of_mass():
    found = pieces()
    np.testing.assert_allclose(found.low[1], [-0.5, -0.5])
    np.testing.assert_allclose(found.high[1], [2.5, 0.5])
    np.testing.assert_allclose(found.extent[0], [1.0, 2.0])
    np.testing.assert_allclose(found.centre[0], [5.0, 0.5])


def test_size_is_that_of_the_disc_of_the_same_area():
    # n discs of radius r have the area of one of radius r sqrt(n)
    np.testing.assert_allclose(pieces().size, [math.sqrt(2), math.sqrt(3), 1, 1, 1])
    # with pores the pieces are larger, single grains are not
    np.testing.assert_allclose(
        pieces(solid_fraction=0.8).size, [math.sqrt(2 / 0.8), math.sqrt(3 / 0.8), 1, 1, 1]
    )


def test_size_is_that_of_the_sphere_of_the_same_volume():
    places = np.zeros((8, 3))
    places[:, 0] = np.arange(8)
    chain = np.stack([np.arange(7), np.arange(1, 8)], axis=1)
    found = find_fragments(places, np.full(8, 0.5), np.ones(8), chain)
    assert found.count == 1
    # eight spheres of diameter 1 have the volume of one of diameter 2
    assert found.size[0] == pytest.approx(2.0)
    assert found.piece_of.tolist() == [0] * 8


def test_of_equal_masses_that_with_the_lowest_number_comes_first():
    found = find_fragments(PLACES[:4], RADII[:4], np.ones(4), [[3, 1]])
    np.testing.assert_array_equal(found.piece_of, [1, 0, 2, 0])


def test_passing_curve_is_a_sieve_curve_by_mass():
    found = pieces()
    # total 8.5: single grains of size 1 weigh 1.5, the pair of size 1.414 weighs 4, the three of 1.732 weigh 3
    np.testing.assert_allclose(
        found.passing([0.5, 1.0, 1.42, 2.0]), [0.0, 1.5 / 8.5, 5.5 / 8.5, 1.0], rtol=1e-14
    )
    np.testing.assert_allclose(found.passing([1.42], ~found.single), [4.0 / 7.0])
    assert found.size_passing(0.5) == pytest.approx(math.sqrt(2))
    assert found.size_passing(0.1) == pytest.approx(1.0)
    assert found.size_passing(1.0) == pytest.approx(math.sqrt(3))


def test_no_piece_has_a_curve_of_nothing():
    found = pieces()
    nothing = np.zeros(found.count, dtype=bool)
    np.testing.assert_array_equal(found.passing([1.0], nothing), [0.0])
    assert math.isnan(found.size_passing(0.5, nothing))


def test_particles_left_out_join_nothing():
    among = np.ones(8, dtype=bool)
    among[1] = False
    found = pieces(among=among)
    assert found.piece_of[1] == -1
    assert found.piece_of[0] != found.piece_of[2]
    assert found.count == 6
    assert found.mass.sum() == pytest.approx(MASS.sum() - MASS[1])


def test_a_long_ring_is_one_piece_and_two_when_cut_twice():
    n = 100_000
    angle = np.linspace(0.0, 2.0 * math.pi, n, endpoint=False)
    places = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    bonds = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
    assert find_fragments(places, np.full(n, 1e-5), np.ones(n), bonds).count == 1
    intact = np.ones(n, dtype=bool)
    intact[[100, 30_100]] = False
    found = find_fragments(places, np.full(n, 1e-5), np.ones(n), bonds, intact)
    np.testing.assert_array_equal(found.particles, [70_000, 30_000])


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"bonds": [[0, 8]]}, "bonds"),
        ({"intact": [True]}, "intact"),
        ({"among": np.ones(3, bool)}, "among"),
        ({"solid_fraction": 0.0}, "solid_fraction"),
        ({"mass": np.ones(3)}, "fragments"),
        ({"positions": np.zeros(8)}, "positions"),
    ],
)
def test_what_does_not_fit_is_refused(change, place):
    given = {"positions": PLACES, "radii": RADII, "mass": MASS, "bonds": BONDS, "intact": INTACT} | change
    with pytest.raises(InputError) as raised:
        find_fragments(**given)
    assert place in raised.value.place


def test_a_share_that_is_none_is_refused():
    with pytest.raises(InputError, match="share"):
        pieces().size_passing(0.0)
