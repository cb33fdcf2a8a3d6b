"""The C loop that geodem's speed is measured against does the work it is said to do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geodem.errors import InputError
from reference import limits, ours, scenes
from reference.backends import BACKENDS

pytestmark = pytest.mark.skipif(limits.available() is not None, reason=str(limits.available()))


def test_two_spheres_part_as_fast_as_they_met():
    steps = 500.25
    scene = scenes.head_on((4e-3, 6e-3), 0.3, steps_in_contact=steps)
    loop = limits.loop_of(scene, margin=1.0)
    loop.step(530, 1)
    np.testing.assert_allclose(
        loop.rows[loop.current, :, 4:7], -scene.velocities, rtol=(np.pi / steps) ** 2, atol=1e-16
    )


@pytest.mark.parametrize("chunk", [7, 64, 1000])
def test_a_packing_with_friction_moves_as_in_liggghts(chunk):
    """The same law in another code, from the same state: 20 steps to rounding, whatever the chunks."""
    missing = BACKENDS["liggghts"].available()
    if missing:
        pytest.skip(missing)
    scene = replace(scenes.spheres_in_a_box(200), box=None)
    loop = limits.loop_of(scene, chunk=chunk, margin=0.2)
    loop.step(20, 2)
    moved = loop.rows[loop.current, :, :3] - scene.positions
    theirs = BACKENDS["liggghts"].run(scene, 20).positions[-1] - scene.positions
    np.testing.assert_allclose(moved, theirs, rtol=0.0, atol=1e-8 * np.abs(theirs).max())
    # the shear springs are at work: without them the same 20 steps end elsewhere
    smooth = limits.loop_of(replace(scene, friction=0.0), chunk=chunk, margin=0.2)
    smooth.step(20, 1)
    assert (
        np.abs(smooth.rows[smooth.current, :, :3] - scene.positions - theirs).max()
        > 1e-3 * np.abs(theirs).max()
    )


@pytest.mark.parametrize("make", [scenes.touching_spheres, scenes.bonded_discs])
def test_threads_change_no_bit(make):
    one, two = (limits.loop_of(make(1000), damping=0.3, chunk=100) for _ in range(2))
    one.step(50, 1)
    two.step(50, 2)
    np.testing.assert_array_equal(one.rows[one.current], two.rows[two.current])


def test_all_listed_spheres_touch_all_the_time():
    loop = limits.loop_of(scenes.touching_spheres(5000))
    loop.step(200, 1)
    assert loop.touching.all()
    assert loop.pairs() / loop.particles == pytest.approx(5.7, rel=0.1)


def _two_discs(tension: float) -> scenes.Scene:
    radius = scenes.RADIUS
    scene = scenes.bonded_discs(2)
    assert scene.bonds is not None
    velocities = np.array([[-0.01, 0.0, 0.0], [0.01, 0.0, 0.0]])
    return replace(
        scene,
        positions=np.array([[0.0, 0.0, 0.0], [2.0 * radius, 0.0, 0.0]]),
        velocities=velocities,
        time_step=scene.time_step / 20.0,
        bonds=replace(scene.bonds, pairs=np.array([[0, 1]]), tension=tension),
    )


def test_a_bond_breaks_at_its_strength_and_not_before():
    # two masses on a spring: the pull grows to v sqrt(kn m/2) with v = 0.02 m/s, m/2 the reduced mass
    scene = _two_discs(np.inf)
    largest = 0.02 * np.sqrt(scene.normal * scene.mass[0] / 2.0)
    for tension, intact in ((1.01 * largest, True), (0.99 * largest, False)):
        loop = limits.loop_of(_two_discs(tension), margin=0.1)
        loop.step(2000, 1)
        assert bool(loop.bond[0]) is intact


def test_local_damping_takes_its_share():
    # a lone sphere that falls: the weight is less by the damping
    scene = scenes.head_on((4e-3, 6e-3), 0.0)
    scene = replace(scene, positions=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), gravity=(0.0, 0.0, -9.81))
    loop = limits.loop_of(scene, damping=0.4)
    loop.step(101, 1)
    # the first step starts at rest, where damping has no direction
    falls = -9.81 * scene.time_step * (1.0 + 100.0 * 0.6)
    np.testing.assert_allclose(loop.rows[loop.current, :, 6], falls, rtol=1e-12)


@pytest.mark.parametrize("make", [scenes.touching_spheres, scenes.bonded_discs])
def test_c_does_the_work_of_geodem_on_its_arrays(make):
    scene = replace(make(2000), gravity=(0.0, 0.0, 0.0))
    simulation = ours.simulation_of(scene, damping=0.1)
    # geodem's first step takes half a step's push; no contact remembers anything after it
    simulation.run(1)
    loop = limits.loop_of_engine(scene, simulation, damping=0.1)
    begun = loop.rows[0].copy()
    loop.step(20, 2)
    simulation.run(20)
    d = scene.dimension
    moved = np.abs(simulation.now[:, :d] - begun[:, :d]).max()
    np.testing.assert_allclose(
        loop.rows[loop.current, :, :d], simulation.now[:, :d], rtol=0.0, atol=1e-9 * moved
    )
    assert (
        loop.touching[loop.once()].sum()
        == ((simulation.pairs.touching > 0) | (simulation.pairs.bond > 0)).sum()
    )


def test_pairs_across_chunks_stand_in_both():
    pairs = np.array([[0, 1], [0, 2], [1, 5], [2, 3], [4, 5]])
    start, a, b, own = limits.chunked(pairs, 6, 2)
    assert start.tolist() == [0, 3, 5, 7]
    assert list(zip(a.tolist(), b.tolist(), strict=True)) == [
        (0, 1),
        (0, 2),
        (1, 5),
        (0, 2),
        (2, 3),
        (4, 5),
        (1, 5),
    ]
    assert own.tolist() == [0, 1, 2, 1, 3, 4, 2]


def test_arrays_of_the_wrong_kind_are_refused():
    loop = limits.loop_of(scenes.touching_spheres(100))
    loop.a = loop.a.astype(np.int64)
    with pytest.raises(InputError, match="uint32"):
        loop.step(1, 1)


def test_the_triad_moves_what_it_counts():
    values = limits.triad(1, megabytes=64, repeats=3)
    assert all(1e9 < value < 1e12 for value in values)


def test_the_library_leaves_the_arithmetic_of_the_process_alone():
    """Half the smallest normal number is denormal; a process that flushes denormals makes it zero."""
    limits.library()
    half = np.array([np.finfo(np.float64).tiny]) * 0.5
    assert half[0] > 0.0
