"""Pressure on the sides: resultants of bodies whose projected areas are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.kernels import outermost
from geodem.laboratory.confinement import RAYS, Confinement
from geodem.laboratory.specimen import make_specimen


def sides_of(positions, radii, **keep):
    along = positions[:, -1]
    sides = Confinement(
        float(keep.get("low", along.min())),
        float(keep.get("high", along.max())),
        float(radii.min()),
        positions.shape[1],
    )
    return sides, sides.loads(positions, radii, keep.get("joined", np.ones(len(radii), dtype=bool)))


def test_rectangle_bears_the_pressure_times_its_height():
    # a square lattice has no gaps between its outermost discs: 10 columns, 21 rows, the ends at the first and last
    grid = np.array([(x, y) for x in range(10) for y in range(21)], dtype=float)
    sides, load = sides_of(grid, np.full(210, 0.5))
    left, right = grid[:, 0] == 0.0, grid[:, 0] == 9.0
    # all but the last part of a ray's spacing
    height = math.floor(20.0 / sides.spacing) * sides.spacing
    assert load[left, 0].sum() == pytest.approx(height, rel=1e-12)
    assert load[right, 0].sum() == pytest.approx(-height, rel=1e-12)
    # a disc inside the column stands for its diameter
    assert load[left & (grid[:, 1] == 7.0), 0] == pytest.approx(1.0, rel=1e-12)
    assert not load[~(left | right)].any()
    assert not load[:, 1:].any()


def test_sphere_bears_the_pressure_on_its_circle():
    radius = 0.5
    # one small sphere far aside sets how fine the rays are
    centres, radii = np.array([[0.0, 0.0, 0.0], [20.0, 20.0, 0.0]]), np.array([radius, 0.1])
    _, load = sides_of(centres, radii, low=-1.0, high=1.0)
    # pressed from both sides: nothing is left
    assert load[0] == pytest.approx(np.zeros(6), abs=1e-15)
    met = outermost.outermost(
        centres[:, 0].copy(), centres[:, 1:], radii, np.array([-1.0, -1.0]), 0.1 / RAYS[3], (40, 40)
    )
    circle = (met[0] == 0).sum() * (0.1 / RAYS[3]) ** 2
    assert circle == pytest.approx(math.pi * radius**2, rel=0.02)
    assert (met[0] == met[1]).all()


@pytest.mark.parametrize(("dimension", "shape"), [(2, "prism"), (3, "prism"), (3, "cylinder")])
def test_specimen_is_pushed_nowhere_and_not_turned(dimension, shape):
    found = make_specimen(dimension, width=0.03, across=10, shape=shape)
    _, load = sides_of(found.positions, found.radii)
    size = np.abs(load[:, : dimension - 1]).sum(axis=0)
    # as much as the surface that is seen from each side: its width between the hidden halves of the outermost grains
    across = (0.06 - found.diameter) * (0.03 + 0.3 * found.diameter if dimension == 3 else 1.0)
    assert size == pytest.approx(np.full(dimension - 1, 2.0 * across), rel=0.08)
    assert load[:, : dimension - 1].sum(axis=0) == pytest.approx(
        np.zeros(dimension - 1), abs=1e-12 * size.max()
    )
    if dimension == 3:
        x, y = found.positions[:, 0], found.positions[:, 1]
        arm = 0.015 * size.sum()
        by_forces = float((x * load[:, 1] - y * load[:, 0]).sum())
        assert float(load[:, 5].sum()) + by_forces == pytest.approx(0.0, abs=1e-12 * arm)
        # without the torques it would turn
        assert abs(by_forces) > 1e-6 * arm


def test_cylinder_is_pressed_inwards_from_all_around():
    found = make_specimen(3, width=0.03, across=12, shape="cylinder")
    _, load = sides_of(found.positions, found.radii)
    away = found.positions[:, :2] - 0.015
    outwards = away / np.linalg.norm(away, axis=1, keepdims=True)
    radial = (load[:, :2] * outwards).sum(axis=1)
    across = load[:, 1] * outwards[:, 0] - load[:, 0] * outwards[:, 1]
    # pi D h over the two sides seen along an axis, 2 D h, whatever D is; grains are pressed a little aside, too
    wall = 0.5 * math.pi * np.abs(load[:, :2]).sum(axis=0).mean()
    assert -radial.sum() == pytest.approx(wall, rel=0.05)
    assert abs(across.sum()) < 0.01 * wall
    # few rays find a way deep inside
    deep = np.linalg.norm(away, axis=1) < 0.015 - 3.0 * found.diameter
    assert np.abs(load[deep, :2]).sum() < 0.01 * np.abs(load[:, :2]).sum()


def test_what_has_come_off_is_not_pressed_and_hides_nothing():
    grid = np.array([(x, y) for x in range(6) for y in range(11)], dtype=float)
    off = np.vstack([grid, [(-3.0, 5.0), (9.0, 2.0)]])
    joined = np.arange(len(off)) < len(grid)
    _, alone = sides_of(grid, np.full(len(grid), 0.5))
    _, load = sides_of(off, np.full(len(off), 0.5), low=0.0, high=10.0, joined=joined)
    assert not load[~joined].any()
    assert np.array_equal(load[joined], alone)


@pytest.mark.parametrize("dimension", [2, 3])
def test_plain_loops_see_what_the_compiled_ones_see(dimension):
    rng = np.random.default_rng(5)
    centres = rng.random((60, dimension))
    radii = 0.05 + 0.05 * rng.random(60)
    low = np.zeros(dimension - 1)
    cells = (25,) * (dimension - 1)
    compiled = outermost.outermost(centres[:, 0].copy(), centres[:, 1:], radii, low, 0.04, cells)
    front = np.full((2, *cells), math.inf)
    plain = np.full((2, *cells), -1)
    meet = outermost.meet_lines if dimension == 2 else outermost.meet_grid
    meet(centres[:, 0], centres[:, 1:], radii, low, 0.04, front, plain)
    assert (plain == compiled).all()
    # by brute force: the surface that is nearest along every ray
    middles = np.stack(np.meshgrid(*[(np.arange(25) + 0.5) * 0.04] * (dimension - 1), indexing="ij"), -1)
    reach = radii**2 - ((middles[..., None, :] - centres[:, 1:]) ** 2).sum(axis=-1)
    surface = np.where(reach > 0.0, centres[:, 0] - np.sqrt(np.maximum(reach, 0.0)), math.inf)
    nearest = np.where(np.isfinite(surface.min(axis=-1)), surface.argmin(axis=-1), -1)
    assert (plain[0] == nearest).all()
