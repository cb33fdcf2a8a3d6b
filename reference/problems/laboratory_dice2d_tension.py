"""DICE2D's direct tension (Zhao 2015, section 3.3.1): alpha = strength D/Ft of regular and irregular specimens.

An infinite triangular sheet under the stress sigma across its rows bears sigma D = 2 (Fn sin 60 + Fs cos 60) per disc
of a row, with Fs/Fn = s from the lattice's own strains. All inclined bonds reach Ft together at

    alpha = sqrt3 + s,    s = ks/kn sqrt3/4 (1 + nu)/(3/4 - nu/4),    nu = (kn - ks)/(3 kn + ks)

and they fail in shear before, at the share C/Ft / (tan phi + s) of it, where that is below 1. A specimen of rows of w
and w - 1 discs has 2 (w - 1) bonds where the sheet has 2 w, and its most loaded bond bears more than the others: its
strength follows from one elastic solve, since the first break is the last.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from geodem.laboratory.axial import pull
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import Specimen

from .dice2d_tables import friction
from .laboratory_dice2d_specimens import (
    COHESION,
    FRICTION,
    HEIGHT,
    RADIUS,
    RATIO,
    STIFFNESS,
    UNIT,
    Bonded,
    irregular,
    material,
    triangular,
)
from .laboratory_elastic import pressed_discs
from .laboratory_points import FAST
from .rows import Row, at_most, relative

SMALL, LARGE = (10, 10), (20, 40)  # discs in the longest rows, rows: 95 and 780
SIZE = (400.0, 695.5)  # of the irregular specimens [m]
LOOSE, DENSE, DENSEST = 1.02, 1.2, 1.5
"""Thresholds of bonding over the sum of the radii; the second gives the 5.08 bonds a disc of the text, nearly."""
SEEDS = (1, 2, 3, 4, 5)
WIDTHS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
"""WRT."""
RATIOS = (0.01, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
"""ks/kn."""
COHESIONS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Over Ft."""
ANGLES = (0.0, 20.0, 40.0, 60.0, 70.0, 80.0, 85.0)
"""Of the bonds' friction [deg], at a cohesion of twice Ft."""
FEW = 2.0

TEXT = "Zhao 2015, section 3.3.1"
SHEET = "closed form of the infinite triangular sheet"
SOLVED = "elastic solve: the load at which the most loaded bond reaches its strength"


def shear_share(ratio: float) -> float:
    """Shear over normal force of the inclined bonds of the sheet under tension across its rows."""
    nu = (1.0 - ratio) / (3.0 + ratio)
    return ratio * math.sqrt(3.0) * (1.0 + nu) / (3.0 - nu)


def sheet(ratio: float) -> float:
    """alpha of the infinite sheet that fails in tension."""
    return math.sqrt(3.0) + shear_share(ratio)


def cut_off(cohesion: float, angle: float, ratio: float = RATIO) -> float:
    """Share of it that is left where bonds fail in shear first."""
    return min(1.0, cohesion / (friction(angle) + shear_share(ratio)))


class Torn(NamedTuple):
    """alpha at the peak, at the first break by an elastic solve, cracks by tension and shear, and seconds."""

    alpha: float
    first_break: float
    tension: int
    shear: int
    failed: bool
    seconds: float


def torn(specimen: Specimen, made_of: BondedMaterial) -> Torn:
    """Pull until it breaks, and solve for the first break."""
    rig = Rig(specimen, made_of)
    rig.begin(-1e-15)
    record = pull(specimen, made_of, pace=FAST)
    first = rig.first_break * rig.modulus
    return Torn(
        record.strength / UNIT, first / UNIT, record.cracks.tension, record.cracks.shear, record.failed,
        record.seconds,
    )  # fmt: skip


def inside(ratio: float = RATIO) -> Row:
    """Stress over the mean normal force of the inclined bonds in the middle of the large specimen."""
    started = time.perf_counter()
    sample = triangular(*LARGE)
    found = pressed_discs(sample, ratio)
    stress = float(found.work[found.inner, 1].mean()) / (2.0 * RADIUS * HEIGHT)
    pairs = sample.pairs[found.inner[sample.pairs].all(axis=1)]
    apart = sample.positions[pairs[:, 1]] - sample.positions[pairs[:, 0]]
    apart /= np.linalg.norm(apart, axis=1)[:, None]
    longer = ((found.moved[pairs[:, 1]] - found.moved[pairs[:, 0]]) * apart).sum(axis=1)
    force = STIFFNESS * float(longer[np.abs(apart[:, 1]) > 0.5].mean())
    seconds = time.perf_counter() - started
    return relative(
        f"tension, 780 discs, ks/kn {ratio:g}", "stress times D over the force of an inclined bond inside",
        2.0 * RADIUS * stress / force, sheet(ratio), 0.01, seconds, SHEET,
    )  # fmt: skip


def regular() -> list[Row]:
    """95 and 780 discs."""
    rows = [inside(ratio) for ratio in (0.01, RATIO, 1.0)]
    net = {}
    for shape in (SMALL, LARGE):
        sample = triangular(*shape)
        found = torn(sample.specimen("triangular"), material())
        name = f"tension, {len(sample.radii)} discs"
        bonds = (shape[0] - 1.0) / shape[0]
        net[shape] = found.alpha / bonds
        rows += [
            relative(name, "alpha", found.alpha, 1.5, 0.1, found.seconds, f"{TEXT}: about 1.5"),
            relative(name, "alpha at the peak", found.alpha, found.first_break, 0.01, found.seconds, SOLVED),
            at_most(name, "alpha over the bonds that cross, over that of the sheet: at most 1",
                    net[shape] / sheet(RATIO), 1.0, found.seconds, SHEET),
        ]  # fmt: skip
    rows.append(
        relative("tension, 95 against 780 discs", "alpha over the bonds that cross, (w - 1)/w", net[SMALL],
                 net[LARGE], 0.02, 0.0, f"{TEXT}: no influence of the size")
    )  # fmt: skip
    return rows


def sections(sample: Bonded) -> tuple[float, float]:
    """alpha of straight sections all of whose bonds bear Ft at once: of the mean one, of the weakest [-]."""
    first, second = sample.pairs.T
    apart = sample.positions[second] - sample.positions[first]
    along = np.abs(apart[:, 1]) / np.linalg.norm(apart, axis=1)
    low = np.minimum(sample.positions[first, 1], sample.positions[second, 1])
    high = np.maximum(sample.positions[first, 1], sample.positions[second, 1])
    at = np.linspace(0.15, 0.85, 281) * sample.box[1]
    crossing = (low[:, None] < at) & (at < high[:, None])
    total = (along[:, None] * crossing).sum(axis=0) * 2.0 * RADIUS / sample.box[0]
    return float(total.mean()), float(total.min())


def irregular_discs(seeds: tuple[int, ...] = SEEDS) -> list[Row]:
    """Few, more and many bonds; what the text has is what the bonds of a straight section bear together."""
    rows: list[Row] = []
    before = 0.0
    for factor, expected in ((LOOSE, 1.0), (DENSE, 1.25), (DENSEST, 1.5)):
        samples = [irregular(*SIZE, factor, seed) for seed in seeds]
        found = [torn(sample.specimen("random"), material(factor)) for sample in samples]
        alpha = np.array([each.alpha for each in found])
        first = np.array([each.first_break for each in found])
        section = np.array([sections(sample) for sample in samples])
        seconds = sum(each.seconds for each in found)
        bonds = float(np.mean([sample.coordination for sample in samples]))
        name = f"tension, irregular, {bonds:.2f} bonds a disc"
        spread = f"{len(seeds)} seeds, deviation {alpha.std(ddof=1):.2f}"
        source = (
            f"{TEXT}: {'very closely packed' if factor == DENSEST else 'low' if factor == LOOSE else 'high'}"
        )
        rows += [
            relative(name, f"alpha, {spread}", float(alpha.mean()), expected, 0.15, seconds, source),
            relative(name, "the same if all bonds of the mean straight section bore Ft at once",
                     float(section[:, 0].mean()), expected, 0.15, seconds, source),
            at_most(name, "first break over peak, of the seed where it is most: at most 1",
                    float((first / alpha).max()), 1.01, seconds, SOLVED),
            at_most(name, "peak over the weakest straight section, of the seed where it is most: at most 1",
                    float((alpha / section[:, 1]).max()), 1.0, seconds, "no bond bears more than Ft"),
        ]  # fmt: skip
        if before:
            rows.append(
                at_most(name, "alpha with fewer bonds over this one: at most 1", before / float(alpha.mean()), 1.0,
                        seconds, f"{TEXT}: more bonds, more strength")
            )  # fmt: skip
        before = float(alpha.mean())
    return rows


class Study(NamedTuple):
    """One parameter's values, the alphas at them, and what they ought to be."""

    label: str
    values: tuple[float, ...]
    found: tuple[Torn, ...]


def study(label: str, values: tuple[float, ...]) -> Study:
    """One parameter of the 95 discs, all others as they are."""
    specimen = triangular(*SMALL).specimen("triangular")
    found = []
    for value in values:
        if label == "WRT":
            made_of = material(width_ratio=value)
        elif label == "ks/kn":
            made_of = material(ratio=value)
        elif label == "C/Ft":
            made_of = material(cohesion=value)
        else:
            made_of = material(cohesion=FEW, angle=value)
        found.append(torn(specimen, made_of))
    return Study(label, values, tuple(found))


def influences() -> tuple[list[Row], list[Study]]:
    """28 tests on 95 discs: bond width, shear stiffness, cohesion, friction."""
    studies = [study("WRT", WIDTHS), study("ks/kn", RATIOS), study("C/Ft", COHESIONS), study("phi", ANGLES)]
    rows = []
    whole = torn(triangular(*SMALL).specimen("triangular"), material()).alpha
    for each in studies:
        name = f"tension, 95 discs, {each.label} {each.values[0]:g} to {each.values[-1]:g}"
        alpha = np.array([test.alpha for test in each.found])
        first = np.array([test.first_break for test in each.found])
        seconds = sum(test.seconds for test in each.found)
        apart = alpha / first - 1.0
        worst = int(np.argmax(np.abs(apart)))
        rows.append(
            relative(name, f"alpha, farthest of {len(alpha)} from the first break", float(alpha[worst]),
                     float(first[worst]), 0.01, seconds, SOLVED)
        )  # fmt: skip
        if each.label in ("WRT", "ks/kn"):
            most = float(1.0 - alpha.min() / alpha.max())
            rows.append(
                at_most(
                    name, "largest difference, at most", most, 0.1, seconds, f"{TEXT}: about 10 % at most"
                )
            )
        if each.label == "ks/kn":
            rows.append(
                relative(name, "alpha at the largest over that at the least", float(alpha[-1] / alpha[0]),
                         sheet(RATIOS[-1]) / sheet(RATIOS[0]), 0.15, seconds, SHEET)
            )  # fmt: skip
        elif each.label != "WRT":
            cohesions = each.values if each.label == "C/Ft" else (FEW,) * len(each.values)
            angles = each.values if each.label == "phi" else (FRICTION,) * len(each.values)
            for cohesion, angle, value in zip(cohesions, angles, alpha, strict=True):
                label = f"C/Ft {cohesion:g}, phi {angle:g} deg"
                rows.append(
                    relative(f"tension, 95 discs, {label}", f"alpha over that at C/Ft {COHESION:g}",
                             float(value) / whole, cut_off(cohesion, angle), 0.01, seconds, SHEET)
                )  # fmt: skip
    return rows, studies


def draw(studies: list[Study]) -> bytes:
    """alpha against the four parameters (figures 3.12 to 3.15 of the text)."""
    from geodem.plotting.theme import INK, STABLE, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(9.0, 5.6)
        titles = ("bond width WRT", "ks/kn", "cohesion C/Ft, phi 80 deg", "friction angle [deg], C/Ft 2")
        for axes, each, title in zip(figure.subplots(2, 2).flat, studies, titles, strict=True):
            axes.plot(each.values, [test.alpha for test in each.found], "o-", color=STABLE, markersize=4.0,
                      linewidth=1.0, label="tested")  # fmt: skip
            axes.plot(each.values, [test.first_break for test in each.found], "x", color=INK, markersize=5.0,
                      label="first break, solved")  # fmt: skip
            axes.set_xlabel(title)
            axes.set_ylabel("strength D/Ft")
            axes.set_ylim(bottom=0.0)
            quiet_axes(axes)
            axes.legend(loc="lower right" if each.label != "phi" else "lower left")
        return png(figure)
