"""The pair list against every particle compared with every other."""

import numpy as np
import pytest

from geodem import _jit
from geodem.errors import InputError
from geodem.neighbors import PairList, bond_pairs, rebuild, spatial_order
from tests.neighbors.scenes import (
    RADIUS,
    assert_well_formed,
    make_rows,
    memory,
    near_pairs,
    random_rows,
    write_memory,
)

FIELDS = ("start", "row", "a", "b", "bond", "touching", "history")


def search(rows, ids, old=None, *maps, dimension, chunk=64, buffer=0.2, history_width=2, **options):
    pairs = rebuild(
        rows, ids, old, *maps,
        chunk=chunk, buffer=buffer, dimension=dimension, history_width=history_width, **options,
    )  # fmt: skip
    assert_well_formed(pairs, ids)
    return pairs


def same_bits(first, second):
    return all(np.array_equal(getattr(first, name), getattr(second, name)) for name in FIELDS)


@pytest.fixture(autouse=True)
def all_threads():
    yield
    _jit.set_threads(None)


@pytest.mark.parametrize("multilevel", [True, False])
@pytest.mark.parametrize("ratio", [1.0, 2.5, 10.0, 50.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_finds_all_near_pairs_and_no_other(dimension, ratio, multilevel):
    rng = np.random.default_rng(int(ratio))
    rows = random_rows(rng, 701, dimension, ratio=ratio)
    ids = rng.permutation(len(rows))
    pairs = search(rows, ids, dimension=dimension, multilevel=multilevel)
    expected = near_pairs(rows, ids, dimension, 0.2)
    assert len(expected) > 500
    assert set(memory(pairs, ids)) == expected
    assert not pairs.bond.any()
    assert not pairs.touching.any()
    assert not pairs.history.any()


@pytest.mark.parametrize("dimension", [2, 3])
def test_one_grid_and_several_give_the_same_list(dimension):
    rng = np.random.default_rng(4)
    rows = random_rows(rng, 900, dimension, ratio=40.0)
    ids = np.arange(len(rows))
    assert same_bits(
        search(rows, ids, dimension=dimension, multilevel=True),
        search(rows, ids, dimension=dimension, multilevel=False),
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_any_number_of_threads_gives_the_same_bits(dimension):
    rng = np.random.default_rng(5)
    rows = random_rows(rng, 5000, dimension, ratio=6.0)
    ids = rng.permutation(len(rows))
    lists = []
    for threads in (1, 2):
        _jit.set_threads(threads)
        first = search(rows, ids, dimension=dimension)
        write_memory(first, ids, np.random.default_rng(6))
        order = spatial_order(rows[:, :dimension], rows[:, RADIUS[dimension]])
        second = search(rows[order], ids[order], first, order, np.argsort(order), dimension=dimension)
        lists.append((first, order, second))
    assert same_bits(lists[0][0], lists[1][0])
    assert np.array_equal(lists[0][1], lists[1][1])
    assert same_bits(lists[0][2], lists[1][2])


@pytest.mark.parametrize("chunk", [1, 7, 64, 300, 1000])
@pytest.mark.parametrize("dimension", [2, 3])
def test_chunks_need_not_divide_the_particles(dimension, chunk):
    rng = np.random.default_rng(chunk)
    rows = random_rows(rng, 300, dimension)
    ids = rng.permutation(len(rows))
    pairs = search(rows, ids, dimension=dimension, chunk=chunk)
    assert set(memory(pairs, ids)) == near_pairs(rows, ids, dimension, 0.2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_memory_survives_moves_and_repeated_sorting(dimension):
    """Against a dictionary of ids: near pairs, intact bonds and touching pairs keep what they knew; no other."""
    rng = np.random.default_rng(dimension)
    rows = random_rows(rng, 600, dimension, ratio=4.0)
    ids = rng.permutation(len(rows))
    pairs = search(rows, ids, dimension=dimension)
    known = memory(pairs, ids)
    kept_far = 0
    for turn in range(6):
        write_memory(pairs, ids, rng)
        known = memory(pairs, ids)
        rows = rows.copy()
        rows[:, :dimension] += rng.normal(scale=0.5, size=(len(rows), dimension))
        if turn % 3 == 2:
            maps = ()
        else:
            order = spatial_order(rows[:, :dimension], rows[:, RADIUS[dimension]], 1.0 + turn)
            rows, ids = rows[order], ids[order]
            maps = (order, np.argsort(order))
        # the chunk may change as well
        pairs = search(rows, ids, pairs, *maps, dimension=dimension, chunk=(64, 50, 50)[turn % 3])

        near = near_pairs(rows, ids, dimension, 0.2)
        held = {pair for pair, (bond, touching, _) in known.items() if bond > 0 or touching == 1}
        kept_far += len(held - near)
        fresh = (0, 0, (0.0, 0.0))
        assert memory(pairs, ids) == {pair: known.get(pair, fresh) for pair in near | held}
    assert kept_far > 500


def test_a_pair_let_go_and_found_again_knows_nothing():
    positions = np.array([[0.0, 0.0], [2.1, 0.0]])
    ids = np.array([1, 0])
    pairs = search(make_rows(positions, np.ones(2)), ids, dimension=2)
    assert (pairs.a.tolist(), pairs.b.tolist()) == ([1], [0])
    pairs.history[:] = 3.0
    away = search(make_rows(positions * 2.0, np.ones(2)), ids, pairs, dimension=2)
    assert away.pairs == 0
    back = search(make_rows(positions, np.ones(2)), ids, away, dimension=2)
    assert back.history.tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("dimension", [2, 3])
def test_exact_ties_are_seen_alike_from_both_sides(dimension):
    """A lattice whose neighbours are as far as the buffer reaches, to the last bit or nearly."""
    axis = 0.1 + 2.2 * np.arange(8)
    positions = np.stack(np.meshgrid(*[axis] * dimension), axis=-1).reshape(-1, dimension)
    ids = np.arange(len(positions))
    for shift in (0.0, 1e3 / 3.0):
        search(make_rows(positions + shift, np.ones(len(positions))), ids, dimension=dimension, chunk=5)


@pytest.mark.parametrize("distance", [1e4, 1e9, 1e15, 1e300])
@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_that_fly_away_cost_nothing(dimension, distance):
    rng = np.random.default_rng(8)
    rows = random_rows(rng, 500, dimension)
    rows[17, :dimension] = distance
    rows[18, :dimension] = -distance
    rows[19, 0] = distance
    ids = np.arange(len(rows))
    first = search(rows, ids, dimension=dimension)
    assert set(memory(first, ids)) == near_pairs(rows, ids, dimension, 0.2)
    # an intact bond keeps its pair however far
    bonded = bond_pairs(
        rows, ids, np.array([[18, 3], [17, 18]]), np.array([[5.0], [6.0]]),
        offset=1, chunk=64, buffer=0.2, dimension=dimension, history_width=2,
    )  # fmt: skip
    assert_well_formed(bonded, ids)
    again = search(rows, ids, bonded, dimension=dimension)
    assert memory(again, ids)[3, 18] == (1, 0, (0.0, 5.0))
    assert memory(again, ids)[17, 18] == (2, 0, (0.0, 6.0))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("centre", [-1e6, 3e7])
def test_places_far_from_the_origin(dimension, centre):
    rng = np.random.default_rng(9)
    rows = random_rows(rng, 500, dimension, ratio=5.0, centre=centre)
    ids = np.arange(len(rows))
    pairs = search(rows, ids, dimension=dimension)
    assert set(memory(pairs, ids)) == near_pairs(rows, ids, dimension, 0.2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_thin_line_of_particles(dimension):
    """Along the diagonal of a box whose cells are far more than the particles."""
    step = 2.1 / np.sqrt(dimension)
    positions = np.repeat(step * np.arange(1500.0)[:, None], dimension, axis=1)
    ids = np.arange(len(positions))
    pairs = search(make_rows(positions, np.ones(len(positions))), ids, dimension=dimension)
    assert set(memory(pairs, ids)) == {(i, i + 1) for i in range(1499)}


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_crowd_in_one_place(dimension):
    """More pairs than there was room for at first."""
    rng = np.random.default_rng(10)
    rows = random_rows(rng, 400, dimension, room=0.05)
    ids = np.arange(len(rows))
    pairs = search(rows, ids, dimension=dimension)
    expected = near_pairs(rows, ids, dimension, 0.2)
    assert len(expected) > 100 * len(rows)
    assert set(memory(pairs, ids)) == expected


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dimension", [2, 3])
def test_large_particles_among_many_small_ones(dimension, threads):
    """A large one meets more cells and particles than the work space holds at first."""
    _jit.set_threads(threads)
    rng = np.random.default_rng(14)
    rows = random_rows(rng, 3000, dimension, ratio=30.0)
    rows[::500, RADIUS[dimension]] = 30.0
    ids = np.arange(len(rows))
    expected = near_pairs(rows, ids, dimension, 0.2)
    pairs = None
    for _ in range(3):
        pairs = search(rows, ids, pairs, dimension=dimension)
        assert set(memory(pairs, ids)) == expected


def test_one_permutation_is_not_enough():
    rows = make_rows(np.zeros((2, 2)), np.ones(2))
    ids = np.arange(2)
    pairs = search(rows, ids, dimension=2)
    with pytest.raises(InputError, match="new_row_of_old"):
        search(rows, ids, pairs, ids, dimension=2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_lost_particle_is_near_to_nothing(dimension):
    rng = np.random.default_rng(11)
    rows = random_rows(rng, 100, dimension)
    rows[40, :dimension] = np.nan
    ids = np.arange(len(rows))
    pairs = search(rows, ids, dimension=dimension)
    assert set(memory(pairs, ids)) == near_pairs(rows, ids, dimension, 0.2)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("particles", [0, 1])
def test_scenes_without_a_pair(dimension, particles):
    rows = make_rows(np.zeros((particles, dimension)), np.ones(particles))
    ids = np.arange(particles)
    pairs = search(rows, ids, dimension=dimension)
    again = search(rows, ids, pairs, ids, ids, dimension=dimension)
    assert pairs.pairs == again.pairs == 0
    assert again.history.shape == (0, 2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_bonds_long_and_short(dimension):
    rng = np.random.default_rng(12)
    rows = random_rows(rng, 300, dimension)
    ids = rng.permutation(len(rows))
    chosen = np.unique(np.sort(rng.integers(0, len(rows), (200, 2)), axis=1), axis=0)
    chosen = rng.permutation(chosen[chosen[:, 0] != chosen[:, 1]])
    near = near_pairs(rows, ids, dimension, 0.2)
    chosen = np.concatenate([chosen, [pair for pair in list(near)[:50] if list(pair) not in chosen.tolist()]])
    histories = rng.normal(size=(len(chosen), 2))
    # either particle may be named first
    named = np.where(rng.integers(0, 2, (len(chosen), 1)) == 1, chosen, chosen[:, ::-1])
    pairs = bond_pairs(
        rows, ids, named, histories,
        offset=1, chunk=64, buffer=0.2, dimension=dimension, history_width=4,
    )  # fmt: skip
    assert_well_formed(pairs, ids)
    expected = dict.fromkeys(near, (0, 0, (0.0, 0.0, 0.0, 0.0)))
    for number, (bond, own) in enumerate(zip(chosen.tolist(), histories.tolist(), strict=True)):
        expected[tuple(bond)] = (number + 1, 0, (0.0, *own, 0.0))
    assert memory(pairs, ids) == expected


def test_no_bonds_at_all():
    rng = np.random.default_rng(13)
    rows = random_rows(rng, 50, 2)
    ids = np.arange(50)
    pairs = bond_pairs(
        rows, ids, np.empty((0, 2), dtype=np.int64), np.empty((0, 1)),
        offset=0, chunk=64, buffer=0.2, dimension=2, history_width=1,
    )  # fmt: skip
    assert set(memory(pairs, ids)) == near_pairs(rows, ids, 2, 0.2)


@pytest.mark.parametrize(
    ("bonds", "place"), [([[0, 1], [2, 2]], "bonds[1]"), ([[0, 1], [1, 2], [1, 0]], "bonds[2]")]
)
def test_bonds_that_cannot_be(bonds, place):
    rows = make_rows(np.arange(6.0).reshape(3, 2), np.ones(3))
    with pytest.raises(InputError) as caught:
        bond_pairs(
            rows, np.arange(3), np.array(bonds), np.zeros((len(bonds), 1)),
            offset=0, chunk=64, buffer=0.2, dimension=2, history_width=1,
        )  # fmt: skip
    assert caught.value.place == place


def test_lookup_and_memory_of_a_list():
    positions = np.array([[0.0, 0.0], [2.1, 0.0], [4.2, 0.0], [50.0, 0.0]])
    pairs = search(make_rows(positions, np.ones(4)), np.arange(4), dimension=2, chunk=2)
    # (0, 1) inside a chunk, (1, 2) across chunks, both under the lower row
    assert pairs.pairs == 2
    assert pairs.lookup(0, 1) == pairs.lookup(1, 0) == 0
    assert pairs.lookup(1, 2) == pairs.lookup(2, 1) == 1
    assert pairs.lookup(0, 2) == pairs.lookup(3, 0) == -1
    assert pairs.nbytes == 2 * (4 + 4 + 4 + 1 + 16) + 8 * (5 + 3)
    assert PairList.empty(4, chunk=2, history_width=2).nbytes == 8 * (5 + 3)
