"""Splitting, bending and direct shear beside closed forms and other tests: `python -m reference run laboratory-tests`.

The elastic stresses in the middle of a split disc against the closed form; the Brazilian and the flexural strength over
the direct tensile one, as rock has it; the envelope of direct shear beside that of triaxial compression. All with the
law `rock`, in 2D but for one disc of spheres.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from geodem.laboratory.axial import compress, pull
from geodem.laboratory.bending import bearings, bend, modulus
from geodem.laboratory.brazilian import jaws, split, splitting_stress
from geodem.laboratory.direct_shear import shear
from geodem.laboratory.driven import Driven
from geodem.laboratory.envelope import fit_envelope
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import Specimen, make_specimen

from .rows import Row, relative

WIDTH = 0.05
ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=10e6, shear_strength=40e6,
    friction_angle=math.radians(30.0),
)  # fmt: skip
SEEDS = (1, 2, 3, 4, 5)
ACROSS = 40.0
NORMAL_STRESSES = (2.5e6, 5e6, 10e6)
CONFINEMENTS = (0.0, 5e6, 10e6)

TIMOSHENKO = (
    "Timoshenko & Goodier 1970, art. 41: 2P/(pi D t) in the middle, its mean over the circle from the same"
)
ISRM = 10.186e6
"""2P/(pi D t) of P = 20 kN, D = 50 mm, t = 25 mm [Pa]."""

PERRAS = (
    "Perras & Diederichs 2014, Geotech. Geol. Eng. 32:525: direct = 0.7 to 0.9 of Brazilian, so 1.11 to 1.43"
)

LAJTAI = "Lajtai 1969, Geotechnique 19:218: a block tears first at tau = sqrt(T (T + sigma_n)), T its tensile strength"


class Middle(NamedTuple):
    """Tension across and compression along the loaded diameter in the middle of a disc, over 2P/(pi D t) [-]."""

    tension: float
    compression: float


def middle(disc: Specimen, share: float) -> Middle:
    """From the mean over a circle of `share` of the diameter, by the closed form's ratio of the two.

    Over a circle of radius a both are less than in the middle by (a/R)^2 of 2P/(pi D t), over a sphere by 0.8 of that.
    """
    less = share**2 if disc.dimension == 2 else 0.8 * share**2
    driven = Driven(disc, ROCK.unbreakable(), jaws(disc))
    driven.begin(0.0)
    unit = splitting_stress(disc, driven.force())
    stress = driven.stress_in(0.5 * disc.size, 0.5 * share * disc.width)
    return Middle(
        float(-stress[0, 0] / unit / (1.0 - less)),
        float(stress[-1, -1] / unit / (1.0 - less / 3.0)),
    )


def elastic_disc(seeds: tuple[int, ...] = SEEDS, fine: float = 160.0) -> list[Row]:
    """A lattice and random discs, with circles of 40 particles across in discs of four times as many."""
    rows = []
    scenes = [
        ("triangular, 40 discs across, circle of 10", 2, 40.0, "triangular", (0,), 0.25),
        (f"triangular, {fine:g} discs across, circle of {fine / 4:g}", 2, fine, "triangular", (0,), 0.25),
        ("random, 40 discs across, circle of 20", 2, 40.0, "random", tuple(range(1, 11)), 0.5),
        (f"random, {fine:g} discs across, circle of {fine / 4:g}", 2, fine, "random", seeds[:3], 0.25),
        ("random, 24 spheres across, sphere of 12", 3, 24.0, "random", seeds[:2], 0.5),
    ]
    for name, dimension, across, packing, own, share in scenes:
        started = time.perf_counter()
        found = np.array(
            [
                middle(
                    make_specimen(
                        dimension,
                        width=WIDTH,
                        across=across,
                        shape="disc",
                        packing=packing,
                        seed=max(seed, 1),
                    ),
                    share,
                )
                for seed in own
            ]
        )
        seconds = time.perf_counter() - started
        mean = found.mean(axis=0)
        spread = found.std(axis=0, ddof=1) if len(own) > 1 else np.zeros(2)
        seen = f", {len(own)} seeds, deviation of one {{:.1%}}" if len(own) > 1 else ""
        rows += [
            relative(name, "tension in the middle at 20 kN [Pa]" + seen.format(spread[0]), ISRM * float(mean[0]),
                     ISRM, 0.04, seconds, TIMOSHENKO),
            relative(name, "compression there [Pa]" + seen.format(spread[1] / 3.0), ISRM * float(mean[1]),
                     3.0 * ISRM, 0.04, seconds, TIMOSHENKO),
        ]  # fmt: skip
    return rows


def beams() -> list[Row]:
    """Modulus from the deflection beside that along the axis.

    Rows of the lattice alternate by half a disc, so that its section is half a disc narrower than the box: one power of
    that is in both moduli, two more are in the bending.
    """
    rows = []
    for name, packing, slender, seeds in (
        ("triangular, 20 x 80 discs", "triangular", 4.0, (0,)),
        ("triangular, 20 x 160 discs", "triangular", 8.0, (0,)),
        ("random, 20 x 80 discs, 5 seeds", "random", 4.0, SEEDS),
    ):
        started = time.perf_counter()
        ratios = []
        for seed in seeds:
            beam = make_specimen(
                2, width=WIDTH, height=slender * WIDTH, across=20, packing=packing, seed=max(seed, 1)
            )
            young, nu = Rig(beam, ROCK).elastic_constants()
            driven = Driven(beam, ROCK, bearings(beam))
            driven.solve()
            ratios.append(modulus(beam, driven, nu) / young)
        expected = (19.5 / 20.0) ** 2 if packing == "triangular" else 1.0
        rows.append(
            relative(name, "E by bending over E along the axis", float(np.mean(ratios)), expected, 0.05,
                     time.perf_counter() - started, "Timoshenko & Goodier 1970, art. 40")
        )  # fmt: skip
    return rows


def tensions(seeds: tuple[int, ...] = SEEDS, across: float = ACROSS) -> list[Row]:
    """Three ways to the tensile strength."""
    started = time.perf_counter()
    direct = [pull(make_specimen(2, width=WIDTH, across=across, seed=k), ROCK).strength for k in seeds]
    by_pull = time.perf_counter() - started
    started = time.perf_counter()
    discs = [split(make_specimen(2, width=WIDTH, across=across, shape="disc", seed=k), ROCK) for k in seeds]
    by_split = time.perf_counter() - started
    started = time.perf_counter()
    bent = [
        bend(make_specimen(2, width=WIDTH, height=4.0 * WIDTH, across=0.5 * across, seed=k), ROCK).strength
        for k in seeds
    ]
    by_bend = time.perf_counter() - started
    brazilian = [record.strength for record in discs]
    name = f"random, {across:g} discs across, {len(seeds)} seeds"

    def spread(values: list[float]) -> str:
        return f"{np.mean(values) / 1e6:.3g} +- {np.std(values, ddof=1) / 1e6:.2g} MPa"

    mean = float(np.mean(direct))
    crushed = max(record.numbers["crushing"] for record in discs)
    return [
        Row(name, f"Brazilian ({spread(brazilian)}) over direct tensile strength ({spread(direct)})",
            float(np.mean(brazilian)) / mean, 1.27, float(np.mean(brazilian)) / mean / 1.27 - 1.0, 0.13,
            by_pull + by_split, PERRAS),
        Row(name, "largest share of first cracks that lie at the loads: the disc is split, not crushed", crushed, 0.0,
            crushed, 0.5, by_split, "a tensile strength only if the first cracks lie inside: ISRM 1978"),
        Row(name, f"flexural ({spread(bent)}, beams 20 discs high) over Brazilian strength: above 1",
            float(np.mean(bent) / np.mean(brazilian)), 1.0,
            min(float(np.mean(bent) / np.mean(brazilian)) - 1.0, 0.0), 0.0, by_bend,
            "rock: bending gives more than splitting, splitting more than pulling (Moleanos limestone, ISSMGE)"),
        Row(name, "flexural over direct tensile strength: 1.5 to 3", float(np.mean(bent)) / mean, 2.25,
            float(np.mean(bent)) / mean / 2.25 - 1.0, 1.0 / 3.0, by_bend,
            "Jaeger, Cook & Zimmerman 2007, section 6.7, and Coviello et al. 2005, as we recall them"),
    ]  # fmt: skip


def envelopes(seeds: tuple[int, ...] = (1, 2, 3), across: float = 30.0) -> list[Row]:
    """Direct shear's strengths beside those that the triaxial envelope has at the same normal stresses."""
    started = time.perf_counter()
    tall = [make_specimen(2, width=WIDTH, across=across, seed=k) for k in seeds]
    strengths = [
        [compress(one, ROCK, confinement=p, fall=0.85).strength for one in tall] for p in CONFINEMENTS
    ]
    tension = float(np.mean([pull(one, ROCK).strength for one in tall]))
    line = fit_envelope(np.repeat(CONFINEMENTS, len(seeds)), np.ravel(strengths))
    by_compression = time.perf_counter() - started
    started = time.perf_counter()
    blocks = [make_specimen(2, width=WIDTH, height=WIDTH, across=across, seed=k) for k in seeds]
    records = [[shear(one, ROCK, normal_stress=p) for one in blocks] for p in NORMAL_STRESSES]
    seconds = time.perf_counter() - started
    peaks = np.array([[record.strength for record in row] for row in records])
    rest = np.array([[record.numbers["residual_stress"] for record in row] for row in records])
    slope, cohesion = np.polyfit(NORMAL_STRESSES, peaks.mean(axis=1), 1)
    friction = math.degrees(math.atan(slope))
    name = f"random, {across:g} discs across, {len(seeds)} seeds"
    triaxial = math.degrees(line.friction_angle)
    told = f"c {cohesion / 1e6:.3g} MPa, phi {friction:.3g} deg beside {line.cohesion / 1e6:.3g} and {triaxial:.3g}"
    rows = []
    for p, own in zip(NORMAL_STRESSES, peaks, strict=True):
        torn = math.sqrt(tension * (tension + p))
        rows.append(
            Row(name, f"direct shear at {p / 1e6:g} MPa over the stress of the first tensile failure: above 1",
                float(own.mean()) / torn, 1.0, min(float(own.mean()) / torn - 1.0, 0.0), 0.0, seconds, LAJTAI)
        )  # fmt: skip
        expected = line.cohesion + p * math.tan(line.friction_angle)
        rows.append(
            relative(name, f"direct shear at {p / 1e6:g} MPa, deviation {own.std(ddof=1) / own.mean():.0%} [Pa]",
                     float(own.mean()), expected, 0.25, seconds + by_compression,
                     "Mohr-Coulomb through our own triaxial tests; bound ours")
        )  # fmt: skip
    residual = float(np.polyfit(NORMAL_STRESSES, rest.mean(axis=1), 1)[0])
    rows += [
        Row(name, f"friction angle of direct shear less that of triaxial tests [deg] ({told})", friction, triaxial,
            friction - triaxial, 10.0, seconds, "one material, one envelope; bound ours"),
        Row(name, "residual slope over the friction of broken bonds (0.5): above 1, grains ride over one another",
            residual / 0.5, 1.0, min(residual / 0.5 - 1.0, 0.0), 0.0, seconds, "Rowe 1962: dilation adds to friction"),
    ]  # fmt: skip
    return rows


def run() -> list[Row]:
    """All of them."""
    return [*elastic_disc(), *beams(), *tensions(), *envelopes()]
