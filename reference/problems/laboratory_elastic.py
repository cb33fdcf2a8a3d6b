"""Poisson's ratio and modulus of specimens between smooth plates, beams: `python -m reference run laboratory-elastic`.

DICE2D's uniaxial compression (Zhao 2015, section 2.5.1) and, in 3D, the face-centred packing along a cube axis. One
sparse solve a specimen; two of them are also compressed by the engine as the text does it. Draws
docs/pictures/laboratory_poisson.png. The beams of section 2.5.2 are in `laboratory_dice2d_beam` and run with it.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.close_pairs import close_pairs
from geodem.builders.packings import lattice
from geodem.integrators.elastic_network import solve_network
from geodem.integrators.network import Network, build_network, link_forces, pair_links
from geodem.particle_simulation import ParticleSimulation

from . import laboratory_dice2d_beam
from .dice2d_tables import book_step, disc_mass, friction
from .laboratory_dice2d_specimens import (
    DENSITY,
    HEIGHT,
    RADIUS,
    STIFFNESS,
    Bonded,
    Floats,
    irregular,
    square,
    triangular,
)
from .rows import Row, at_most, relative

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"

RATIOS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
"""ks/kn."""
FACTORS = (1.02, 1.05, 1.2, 1.5)
"""Thresholds of bonding of the irregular specimens, over the sum of the radii."""
SEEDS = (1, 2, 3, 4, 5)
SIZE = (600.0, 1200.0)  # of the irregular specimens [m]: 30 x 60 discs
LIMIT = 1.0 / 3.0
"""Of Poisson's ratio of the triangular packing, at ks = 0."""

TEXT = "Zhao 2015, section 2.5.1"
DISCS = (
    "closed form of the triangular lattice: E = 2 sqrt3 kn (kn + ks)/(3 kn + ks), nu = (kn - ks)/(3 kn + ks)"
)
SPHERES = (
    "closed form of the FCC lattice: E = 2 sqrt2 kn (kn + 3 ks)/(a (3 kn + ks)), nu = (kn - ks)/(3 kn + ks)"
)


class Pressed(NamedTuple):
    """A specimen shortened by one thousandth of its height between smooth plates.

    `moved` (n, d) [m] are the displacements; `work` (n, d) [N m] what every particle's bonds bear along the axes times
    their branches, over its volume the normal stresses, tensile where positive; `inner` (n,) the particles in the
    middle half of all axes.
    """

    moved: Floats
    work: Floats
    inner: NDArray[np.bool_]


def pressed(
    positions: Floats,
    box: Floats,
    network: Network,
    ends: tuple[NDArray[np.bool_], NDArray[np.bool_]],
) -> Pressed:
    """Compress along the last axis by its ends, which are free to slip; the middle of the low one is held across."""
    low, high = ends
    off = np.where(low, ((positions - 0.5 * box)[:, :-1] ** 2).sum(axis=1), np.inf)
    supports = int(np.argmin(off))
    d = positions.shape[1]
    held = np.zeros((len(positions), network.freedoms), dtype=bool)
    held[low | high, d - 1] = True
    held[supports, : d - 1] = True
    # in 3D nothing but friction would keep the whole from turning about the axis
    held[supports, network.freedoms - 1] |= d == 3
    prescribed = np.zeros(held.shape)
    prescribed[high, d - 1] = -1e-3 * box[-1]
    moved = solve_network(network, np.zeros(held.shape), held=held, prescribed=prescribed)
    forces = link_forces(network, moved)
    links = network.links
    slip = forces.slip if d == 3 else forces.slip * network.tangents[:, 0]
    force = forces.extension[:, None] * links.normal + slip
    share = 0.5 * force * links.normal * links.arms.sum(axis=1)[:, None]
    work = np.zeros((len(positions), d))
    for side in (links.first, links.second):
        np.add.at(work, side, share)
    inner = np.all(np.abs(positions - 0.5 * box) < 0.25 * box, axis=1)
    return Pressed(moved[:, :d], work, inner)


def pressed_discs(sample: Bonded, ratio: float, width_ratio: float = 0.1) -> Pressed:
    """A specimen of discs with ks/kn and WRT between its low and its high end."""
    return pressed(sample.positions, sample.box, sample.network(ratio, width_ratio), sample.ends())


def by_points(sample: Bonded, moved: Floats, share: float = 0.25) -> tuple[float, float]:
    """Axial strain and that across between two discs each (eq. 2.2), at `share` and 1 - `share` of the sides."""

    def gauge(axis: int) -> float:
        ends = []
        for at in (share, 1.0 - share):
            point = 0.5 * sample.box
            point[axis] = at * sample.box[axis]
            ends.append(int(np.argmin(((sample.positions - point) ** 2).sum(axis=1))))
        first, second = ends
        apart = sample.positions[second, axis] - sample.positions[first, axis]
        return float((moved[second, axis] - moved[first, axis]) / apart)

    return gauge(1), gauge(0)


def gradient(positions: Floats, found: Pressed) -> Floats:
    """Displacement gradient (d, d) by least squares over the inner particles; column i is that of u_i."""
    where = np.column_stack([positions[found.inner], np.ones(found.inner.sum())])
    return np.asarray(np.linalg.lstsq(where, found.moved[found.inner], rcond=None)[0][:-1])


def regular_discs(wide: int = 30, high: int = 60) -> list[Row]:
    """Square: no strain across. Triangular: E and nu on the closed forms, strains by points inside."""
    rows = []
    box = square(10, 10)
    column = triangular(wide, high)
    for ratio in RATIOS:
        started = time.perf_counter()
        axial, across = by_points(box, pressed_discs(box, ratio).moved)
        seconds = time.perf_counter() - started
        rows.append(
            Row(f"square, 100 discs, ks/kn {ratio:g}", "nu by points", -across / axial, 0.0, -across / axial,
                1e-9, seconds, TEXT)
        )  # fmt: skip
        started = time.perf_counter()
        found = pressed_discs(column, ratio)
        axial, across = by_points(column, found.moved)
        # every disc has the area of its hexagon
        stress = float(found.work[found.inner, 1].mean()) / (2.0 * RADIUS * HEIGHT)
        seconds = time.perf_counter() - started
        name = f"triangular, {wide} x {high} discs, ks/kn {ratio:g}"
        young = 2.0 * math.sqrt(3.0) * STIFFNESS * (1.0 + ratio) / (3.0 + ratio)
        poisson = (1.0 - ratio) / (3.0 + ratio)
        nu = -across / axial
        rows += [
            Row(name, "nu by points, difference over it, over 1 where it is 0", nu, poisson,
                (nu - poisson) / (poisson or 1.0), 0.01, seconds, DISCS),
            relative(name, "E, stress inside over strain by points [Pa]", stress / axial, young, 0.01, seconds, DISCS),
        ]  # fmt: skip
    return rows


def width_of_bonds() -> list[Row]:
    """WRT does not touch Poisson's ratio, says the text: where all discs move alike, none turns."""
    rows = []
    for label, sample, bound in (
        ("triangular, 30 x 60 discs", triangular(30, 60), 1e-3),
        ("irregular, bonded within 1.2, seed 1", irregular(*SIZE, 1.2, 1), 0.02),
    ):
        started = time.perf_counter()
        values = []
        for width_ratio in (0.0, 0.5, 1.0):
            across, axial = np.diag(gradient(sample.positions, pressed_discs(sample, 0.2, width_ratio)))
            values.append(-across / axial)
        seconds = time.perf_counter() - started
        for width_ratio, value in zip((0.5, 1.0), values[1:], strict=True):
            rows.append(
                Row(label, f"nu at WRT {width_ratio:g}, difference to that at 0", value, values[0],
                    value - values[0], bound, seconds, TEXT)
            )  # fmt: skip
    return rows


def face_centred(cells: tuple[int, int, int] = (8, 8, 16), ratios: tuple[float, ...] = RATIOS) -> list[Row]:
    """Spheres between plates across a cube axis: E and nu from strains and stresses inside.

    The outermost layers bear less along the sides, since they have fewer bonds, so that a stress across is left inside
    that falls as one over the width: with 8 cells the ratio of the strains alone is 4 % too high.
    """
    side = math.sqrt(2.0)
    found = lattice("fcc", 0.5, box=[side * n + 1.0 + 1e-9 for n in cells])
    positions = found.positions
    pairs, _ = close_pairs(positions, found.radii, lambda a, b: 1.01 * (a + b), None)
    ends = positions[:, 2] < 0.6, positions[:, 2] > positions[:, 2].max() - 0.1
    rows = []
    for ratio in ratios:
        started = time.perf_counter()
        network = build_network(positions, pair_links(positions, found.radii, pairs, 1.0, ratio))
        answer = pressed(positions, found.box, network, ends)
        strain = np.diag(gradient(positions, answer))
        # a unit cell has four spheres
        stress = answer.work[answer.inner].mean(axis=0) / (side**3 / 4.0)
        young, nu = hooke(strain, stress)
        seconds = time.perf_counter() - started
        name = f"FCC, {' x '.join(str(n) for n in cells)} cells, ks/kn {ratio:g}"
        poisson = (1.0 - ratio) / (3.0 + ratio)
        expected = 2.0 * math.sqrt(2.0) * (1.0 + 3.0 * ratio) / (3.0 + ratio)
        rows += [
            relative(name, "E inside, times a/kn", young, expected, 0.01, seconds, SPHERES),
            Row(name, "nu inside, difference over it, over 1 where it is 0", nu, poisson,
                (nu - poisson) / (poisson or 1.0), 0.01, seconds, SPHERES),
        ]  # fmt: skip
    return rows


def hooke(strain: Floats, stress: Floats) -> tuple[float, float]:
    """E and nu of a cubic material along its axes, from the strains (3,) and stresses (3,): two equations."""
    across_strain, across = strain[:2].mean(), stress[:2].mean()
    # E ez = sz - 2 nu sx and E ex = (1 - nu) sx - nu sz
    matrix = np.array([[strain[2], 2.0 * across], [across_strain, across + stress[2]]])
    young, nu = np.linalg.solve(matrix, np.array([stress[2], across]))
    return float(young), float(nu)


class Curve(NamedTuple):
    """Poisson's ratio (seeds, ratios) of the irregular specimens of one threshold, and their coordination numbers."""

    factor: float
    coordination: float
    values: Floats


def curve(
    factor: float, seeds: tuple[int, ...] = SEEDS, ratios: tuple[float, ...] = RATIOS
) -> tuple[Curve, float]:
    """Strains by least squares over the inner discs, and the seconds that it took."""
    started = time.perf_counter()
    values, bonds = [], []
    for seed in seeds:
        sample = irregular(*SIZE, factor, seed)
        bonds.append(sample.coordination)
        line = []
        for ratio in ratios:
            strain = gradient(sample.positions, pressed_discs(sample, ratio))
            line.append(-strain[0, 0] / strain[1, 1])
        values.append(line)
    return Curve(factor, float(np.mean(bonds)), np.array(values)), time.perf_counter() - started


def irregular_discs(
    seeds: tuple[int, ...] = SEEDS, ratios: tuple[float, ...] = RATIOS
) -> tuple[list[Row], list[Curve]]:
    """Curves of four coordination numbers, and what the text says of them."""
    rows, curves = [], []
    regular = np.array([(1.0 - ratio) / (3.0 + ratio) for ratio in ratios])
    for factor in FACTORS:
        found, seconds = curve(factor, seeds, ratios)
        curves.append(found)
        name = f"irregular, {found.coordination:.2f} bonds a disc"
        mean, spread = found.values.mean(axis=0), found.values.std(axis=0, ddof=1)
        apart = np.abs(found.values.mean(axis=0) - regular).max()
        if factor == FACTORS[0]:
            loosest = (mean[0], apart)
        rows.append(
            Row(name, f"nu at ks = 0 over 1/3, deviation of seeds {spread[0] / LIMIT:.2f}: above 1",
                mean[0] / LIMIT, 1.0, min(mean[0] / LIMIT - 1.0, 0.0), 0.0, seconds, TEXT)
        )  # fmt: skip
        rise = max(float(np.diff(mean).max()), 0.0)
        rows.append(
            Row(name, "largest rise of nu where ks/kn rises: none", rise, 0.0, rise, 0.0, seconds, TEXT)
        )  # fmt: skip
        if factor == FACTORS[-1]:
            rows += [
                at_most(name, "farthest from the triangular packing's nu", apart, 0.05, seconds,
                        "the text: many bonds make it like the triangular packing; bound ours"),
                at_most(name, "the same over that of the fewest bonds", apart / loosest[1], 0.2, seconds,
                        "the text: many bonds make it like the triangular packing; bound ours"),
            ]  # fmt: skip
    return rows, curves


def by_the_engine(sample: Bonded, ratio: float, steps: int = 800) -> Floats:
    """Displacements (n, 2) [m] in the second half of the steps of table 2.6; the upper wall comes down at 1 mm/s.

    Local damping of 0.8 lets the sides lag behind: by the same length all the time, which the difference is rid of.
    """
    shear = max(ratio, 1e-9) * STIFFNESS
    builder = AssemblyBuilder(2, bond_law="two_springs")
    contact = {
        "normal_stiffness": STIFFNESS,
        "shear_stiffness": shear,
        "friction_coefficient": friction(80.0),
    }
    bond = {**contact, "tensile_strength": 5e9, "cohesion": 5e9, "width_ratio": 0.1}
    builder.add_material("disc", density=DENSITY, contact=contact, bond=bond)
    builder.add_particles(sample.positions, sample.radii, "disc")
    builder.bond(sample.pairs)
    smooth = {**contact, "friction_coefficient": 0.0}
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0), contact=smooth))
    top = (0.0, float(sample.box[1]))
    builder.add_wall(plane("plate", top, (0.0, -1.0), velocity=(0.0, -1e-3), contact=smooth))
    step = book_step(0.1, disc_mass(DENSITY), STIFFNESS, shear)
    simulation = ParticleSimulation(builder.build(), time_step=step, local_damping=0.8)
    simulation.run(steps // 2)
    half = simulation.positions
    simulation.run(steps - steps // 2)
    return simulation.positions - half


def engine() -> list[Row]:
    """The text's own runs; that of 95 discs beside its static state."""
    rows = []
    for label, sample in (
        ("square, 100 discs", square(10, 10)),
        ("triangular, 95 discs", triangular(10, 10)),
    ):
        started = time.perf_counter()
        axial, across = by_points(sample, by_the_engine(sample, 0.0))
        seconds = time.perf_counter() - started
        still = by_points(sample, pressed_discs(sample, 0.0).moved)
        nu, expected = -across / axial, -still[1] / still[0]
        rows.append(
            Row(f"{label}, by the engine, table 2.6", "nu by points, difference to that at rest", nu, expected,
                nu - expected, 1e-9 if expected == 0.0 else 0.01, seconds, "solved as a network")
        )  # fmt: skip
    return rows


def draw(curves: list[Curve]) -> bytes:
    """Poisson's ratio against ks/kn (figure 2.13 of the text)."""
    from geodem.plotting.theme import INK, OTHER_CIRCLES, SOFT, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(6.0, 4.0)
        axes = figure.subplots()
        at = np.linspace(0.0, 1.0, 101)
        axes.plot(at, (1.0 - at) / (3.0 + at), "-", color=INK, linewidth=1.2, label="triangular, closed form")
        axes.plot(at, 0.0 * at, "-", color=SOFT, linewidth=1.0, label="square")
        for found, colour in zip(curves, OTHER_CIRCLES, strict=False):
            axes.errorbar(
                RATIOS, found.values.mean(axis=0), found.values.std(axis=0, ddof=1), fmt="o--", color=colour,
                markersize=3.5, linewidth=0.9, capsize=2.0, label=f"irregular, {found.coordination:.2f} bonds a disc",
            )  # fmt: skip
        axes.set_xlabel("ks/kn")
        axes.set_ylabel("Poisson's ratio")
        axes.legend(loc="upper right")
        quiet_axes(axes)
        return png(figure)


def run() -> list[Row]:
    """All of them."""
    rows, curves = irregular_discs()
    (PICTURES / "laboratory_poisson.png").write_bytes(draw(curves))
    return [
        *regular_discs(),
        *width_of_bonds(),
        *engine(),
        *rows,
        *face_centred(),
        *laboratory_dice2d_beam.run(),
    ]
