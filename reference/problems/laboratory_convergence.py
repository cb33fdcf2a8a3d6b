"""What the laboratory's strengths are worth: `python -m reference run laboratory-convergence`.

Two rocks in 2D: a sandstone (bonds of neighbours, no moments) and a granite (bonds from farther, a third of the
moments). Compression at five rates and at half the time step; compression, tension and confined compression with 10
to 60 particles across; one specimen made over and over with other rounding. Draws
docs/pictures/laboratory_convergence.png.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from geodem.laboratory.envelope import fit_envelope
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.pace import PACE
from geodem.laboratory.rig import STEP

from .laboratory_points import Answer, Floats, Mean, Point, measure_all
from .rows import Row, at_most

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PICTURE = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "laboratory_convergence.png"

COARSE = 20.0
"""Particles across where rates and steps are compared: many specimens say more than fine ones."""
SEEDS = tuple(range(1, 17))
ROUNDINGS = tuple(range(9))
"""The density is higher by so many times 1e-12."""


class Rock(NamedTuple):
    """A material, the strains near its peaks that set the rates, the pressure [Pa] of its confined test, how many seeds
    are tested with so many particles across, and the paces, in steps to the peak per particle of height."""

    material: BondedMaterial
    strains: Mapping[str, float]
    pressure: float
    seeds: Mapping[float, int]
    paces: tuple[float, ...]


ROCKS = {
    "sandstone": Rock(
        BondedMaterial.rock(
            density=2500.0, effective_modulus=30e9, stiffness_ratio=2.5, tensile_strength=8e6, shear_strength=36e6,
            friction_angle=math.radians(31.0),
        ),
        {"compression": 2.8e-3, "tension": 1.9e-4, "confined": 6.1e-3},
        11.5e6,
        {10.0: 32, 15.0: 24, 20.0: 16, 30.0: 8, 40.0: 4, 60.0: 2},
        (40.0, 85.0, 170.0, PACE, 2.0 * PACE),
    ),
    "granite": Rock(
        BondedMaterial.rock(
            density=2600.0, effective_modulus=30e9, stiffness_ratio=4.0, tensile_strength=8e6, shear_strength=32e6,
            friction_angle=math.radians(45.0), moment_contribution=0.3, bonding_range=1.3,
        ),
        {"compression": 5.1e-3, "tension": 1.85e-4, "confined": 1.8e-2},
        20e6,
        {10.0: 24, 15.0: 16, 20.0: 16, 30.0: 6, 40.0: 3, 60.0: 2},
        (40.0, 85.0, 170.0, PACE, 2.0 * PACE, 4.0 * PACE),
    ),
}  # fmt: skip


def point(
    rock: str,
    kind: str,
    across: float,
    seed: int,
    *,
    pace: float = PACE,
    time_share: float = STEP,
    grain: float = 1.0,
) -> Point:
    """A test on a rock; confined under the rock's pressure."""
    r = ROCKS[rock]
    pressure = r.pressure if kind == "confined" else 0.0
    return Point(rock, r.material, kind, across, seed, r.strains[kind], pressure, pace, time_share, grain=grain)


def rates(rock: str) -> list[Point]:
    """Compression of the same specimens at all paces, and at half the time step.

    Half the step at twice the steps moves the grips at the same speed: what differs is the step alone.
    """
    paced = [(pace, STEP) for pace in ROCKS[rock].paces]
    return [
        point(rock, "compression", COARSE, seed, pace=pace, time_share=share)
        for pace, share in [*paced, (2.0 * PACE, 0.5 * STEP)]
        for seed in SEEDS
    ]


def resolutions(rock: str) -> list[Point]:
    """Compression, tension and confined compression with more and more particles across."""
    return [
        point(rock, kind, across, seed + 1)
        for across, seeds in ROCKS[rock].seeds.items()
        for seed in range(seeds)
        for kind in ROCKS[rock].strains
    ]


def roundings(rock: str) -> list[Point]:
    """One specimen over and over."""
    return [point(rock, "compression", COARSE, 1, grain=1.0 + 1e-12 * k) for k in ROUNDINGS]


def paired(answers: Mapping[Point, Answer], above: list[Point], below: list[Point]) -> Mean:
    """Ratio of strengths, specimen by specimen."""
    return Mean.of(answers[a].strength / answers[b].strength for a, b in zip(above, below, strict=True))


def rate_rows(rock: str, answers: Mapping[Point, Answer]) -> list[Row]:
    """What half the rate and half the time step do to the mean peak."""
    asked = rates(rock)
    blocks = [asked[k : k + len(SEEDS)] for k in range(0, len(asked), len(SEEDS))]
    paces = ROCKS[rock].paces
    normal, slow, fine = blocks[paces.index(PACE)], blocks[paces.index(2.0 * PACE)], blocks[-1]
    rows = []
    for what, points in (("rate", slow), ("time step", fine)):
        ratio = paired(answers, points, normal)
        quantity = f"compressive strength at half the {what}, over that at the usual one"
        rows.append(_ratio(f"{rock}, {COARSE:g} across", quantity, ratio, 0.02, seconds(answers, points + normal)))
    return rows


def rounding_rows(rock: str, answers: Mapping[Point, Answer]) -> list[Row]:
    """How far the peak of one specimen scatters where only the rounding differs."""
    points = roundings(rock)
    found = Mean.of(answers[p].strength for p in points)
    quantity = f"deviation of the compressive strength of one specimen by rounding alone, {len(points)} runs"
    return [at_most(f"{rock}, {COARSE:g} across", quantity, found.deviation / found.value, 0.05,
                    seconds(answers, points), OURS)]  # fmt: skip


class Size(NamedTuple):
    """Means over the specimens with so many particles across; friction [rad]."""

    across: float
    strengths: Mapping[str, Mean]
    friction: Mean
    seconds: float


def sizes(rock: str, answers: Mapping[Point, Answer]) -> list[Size]:
    """One for each resolution, ascending."""
    r = ROCKS[rock]
    found = []
    for across, seeds in r.seeds.items():
        of = {
            kind: [point(rock, kind, across, seed + 1) for seed in range(seeds)] for kind in r.strains
        }
        frictions = [
            fit_envelope([0.0, r.pressure], [answers[a].strength, answers[b].strength]).friction_angle
            for a, b in zip(of["compression"], of["confined"], strict=True)
        ]
        means = {kind: Mean.of(answers[p].strength for p in points) for kind, points in of.items()}
        spent = sum(seconds(answers, points) for points in of.values())
        found.append(Size(across, means, Mean.of(frictions), spent))
    return found


def size_rows(rock: str, answers: Mapping[Point, Answer]) -> list[Row]:
    """Strengths and friction against those of the finest specimens."""
    *coarser, finest = sizes(rock, answers)
    rows = []
    for size in coarser:
        name = f"{rock}, {size.across:g} across"
        for kind, word in (("compression", "compressive"), ("tension", "tensile")):
            mean, end = size.strengths[kind], finest.strengths[kind]
            value = mean.value / end.value
            error = value * math.hypot(mean.error / mean.value, end.error / end.value)
            quantity = f"{word} strength over that with {finest.across:g} across"
            ratio = Mean(value, mean.deviation / mean.value, error, mean.number)
            rows.append(_ratio(name, quantity, ratio, 0.05, size.seconds))
        mean, end = size.friction, finest.friction
        apart = math.degrees(mean.value - end.value)
        error = math.degrees(math.hypot(mean.error, end.error))
        quantity = (
            f"friction angle [deg] against that with {finest.across:g} across, difference; deviation "
            f"{math.degrees(mean.deviation):.2g}, error {error:.2g}, {mean.number} specimens"
        )
        angles = math.degrees(mean.value), math.degrees(end.value)
        rows.append(Row(name, quantity, *angles, apart, 3.0, size.seconds, OURS))
    return rows


OURS = "bound ours"


def _ratio(name: str, quantity: str, ratio: Mean, bound: float, spent: float) -> Row:
    about = f"; deviation {100.0 * ratio.deviation:.2g} %, error {100.0 * ratio.error:.2g} %, {ratio.number} specimens"
    return Row(name, quantity + about, ratio.value, 1.0, ratio.value - 1.0, bound, spent, OURS)


def seconds(answers: Mapping[Point, Answer], points: list[Point]) -> float:
    """Run time of tests [s]."""
    return sum(answers[p].seconds for p in points)


def draw(answers: Mapping[Point, Answer]) -> bytes:
    """Strength against the rate, strengths and friction against the resolution."""
    from geodem.plotting.theme import OTHER_CIRCLES, SLIP, SOFT, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(9.0, 6.4)
        (top, left), (right, last) = figure.subplots(2, 2)
        for (rock, r), colour in zip(ROCKS.items(), (OTHER_CIRCLES[0], SLIP), strict=False):
            asked = rates(rock)
            count = len(SEEDS)
            normal = asked[r.paces.index(PACE) * count :][:count]
            means = [paired(answers, asked[k * count :][:count], normal) for k in range(len(r.paces))]
            look = {"color": colour, "markersize": 3.5, "linewidth": 0.9, "capsize": 2.0}
            top.errorbar(r.paces, [m.value for m in means], [m.error for m in means], fmt="o-", label=rock, **look)
            fine = paired(answers, asked[-count:], normal)
            top.errorbar([2.0 * PACE * 1.08], [fine.value], [fine.error], fmt="s", mfc="none", **look)
            found = sizes(rock, answers)
            at = np.array([size.across for size in found])
            for axes, kind in ((left, "compression"), (right, "tension")):
                scale = r.material.bond["tensile_strength"]
                strength = np.array([size.strengths[kind][:3] for size in found]) / scale
                _spread(axes, at, strength, rock, look)
            friction = np.degrees([size.friction[:3] for size in found])
            _spread(last, at, friction, rock, look)
        for axes, words in (
            (top, ("steps to the peak per particle of height", "compressive strength over that at 340")),
            (left, ("particles across", "compressive strength over Tb")),
            (right, ("particles across", "tensile strength over Tb")),
            (last, ("particles across", "friction angle [deg]")),
        ):
            axes.set_xscale("log")
            ticks = ROCKS["granite"].paces if axes is top else ROCKS["granite"].seeds
            axes.set_xticks(list(ticks), [f"{tick:g}" for tick in ticks])
            axes.minorticks_off()
            axes.set_xlabel(words[0])
            axes.set_ylabel(words[1])
            quiet_axes(axes)
        top.axhline(1.0, color=SOFT, linewidth=0.8)
        top.set_title("Rate (squares: half the time step)")
        left.set_title("Resolution (wide bars: error of the mean)")
        left.set_ylim(0.0, None)
        right.set_ylim(0.0, None)
        top.legend(loc="upper right")
        return png(figure)


def _spread(axes: Axes, at: Floats, values: Floats, label: str, look: Mapping[str, Any]) -> None:
    """Means, with thin bars for the deviation of one specimen and thick ones for the error of the mean."""
    axes.errorbar(at, values[:, 0], values[:, 1], fmt="o-", label=label, **look)
    axes.errorbar(at, values[:, 0], values[:, 2], fmt="none", ecolor=look["color"], elinewidth=3.0)


def points() -> list[Point]:
    """All tests."""
    return [p for rock in ROCKS for p in rates(rock) + resolutions(rock) + roundings(rock)]


def figures(answers: Mapping[Point, Answer]) -> list[Row]:
    """All figures."""
    return [
        row
        for rock in ROCKS
        for row in rate_rows(rock, answers) + rounding_rows(rock, answers) + size_rows(rock, answers)
    ]


def run() -> list[Row]:
    """All of them, and the picture."""
    answers = measure_all(points())
    PICTURE.write_bytes(draw(answers))
    return figures(answers)
