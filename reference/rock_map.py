"""Measure the map from bonds to rock that `geodem calibrate` begins with, and store it with the package."""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import random
import time
from pathlib import Path
from typing import Any

from geodem.calibration.fit import residual_friction
from geodem.calibration.table import FORMAT
from geodem.calibration.trial import Outcome, SpecimenOptions, Trial, run_trials
from geodem.laboratory.confined import LOW
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import make_specimen
from geodem.provenance import versions

HELP = "measure the map from bonds to rock in one dimension and store it with geodem"

FOLDER = Path(__file__).parents[1] / "geodem" / "calibration"

TEXTURES: dict[str, dict[str, float]] = {
    "touching": {"bonding_range": 1.05, "moment_contribution": 0.0},
    "interlocked": {"bonding_range": 1.3, "moment_contribution": 0.3},
}
"""How far grains are bonded: their neighbours, or what is a little farther too, which interlocks."""

FRICTIONS = {"touching": (0.0, 0.3, 0.6, 1.0, 1.5), "interlocked": (0.1, 0.4, 0.8, 1.2)}
"""tan(phi_b)."""

RATIOS = (2.0, 3.0, 4.5, 7.0)
"""C/Tb."""

STIFFNESS = {2: (2.0, 4.5), 3: (2.5, 10.0)}
"""kn/ks: Poisson's ratios of most rocks lie between."""

CORNERS = {
    **{
        (2, texture): [((4, 10.0), place) for place in enumerate(frictions)]
        for texture, frictions in FRICTIONS.items()
    },
    (3, "touching"): [
        *[((i, RATIOS[i]), (5, 2.2)) for i in (1, 2, 3)],
        *[((4, 10.0), (k, friction)) for k, friction in ((1, 0.3), (2, 0.6))],
    ],
}
"""Further points (C/Tb, tan(phi_b)), each with its number for the seeds: hard rock needs more of both, of spheres above
all."""

ELASTIC = {
    2: (1.0, 1.3, 1.7, 2.2, 2.8, 3.6, 4.8, 6.5, 9.0, 12.0),
    3: (1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0),
}
"""kn/ks of the points where only the elastic constants are solved for, on all seeds."""

ACROSS = {2: 24.0, 3: 10.0}
PACE = {2: 340.0, 3: 200.0}
"""Faster than a test is driven for its own sake: what that adds is taken back by the tests of a calibration."""

SEEDS = (1, 2, 3, 4)
"""Of the specimens, in turn: so the surfaces through the points average over packings."""

MODULUS, TENSION = 60e9, 15e6
"""Of the bonds [Pa]. Only their quotient matters, and hardly: strains are small."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which map, and how many processes."""
    parser.add_argument("--dimension", type=int, choices=(2, 3), default=2)
    parser.add_argument("--workers", type=int, default=os.cpu_count())


def main(arguments: argparse.Namespace) -> int:
    """Measure, or go on where a measurement was interrupted; 0."""
    path = measure(arguments.dimension, arguments.workers)
    print(f"stored in {path}")
    return 0


def design(dimension: int) -> list[tuple[str, dict[str, float], int]]:
    """Texture, micro-parameters and seed of every point, in an order in which an interrupted map is of use."""
    points = []
    for texture, fixed in TEXTURES.items():
        grid = list(itertools.product(STIFFNESS[dimension], enumerate(RATIOS), enumerate(FRICTIONS[texture])))
        grid += [
            (s, *corner) for s in STIFFNESS[dimension] for corner in CORNERS.get((dimension, texture), ())
        ]
        for stiffness, (i, ratio), (k, friction) in grid:
            varied = {"stiffness_ratio": stiffness, "shear_over_tension": ratio, "bond_friction": friction}
            points.append((texture, {**varied, **fixed}, SEEDS[(3 * k + i) % len(SEEDS)]))
    random.Random(1).shuffle(points)
    return points


def trial_of(micro: dict[str, float], dimension: int, seed: int) -> Trial:
    """The tests of a point; how far it is to the peaks is left to pilots."""
    material = BondedMaterial.rock(
        density=2600.0,
        effective_modulus=MODULUS,
        stiffness_ratio=micro["stiffness_ratio"],
        tensile_strength=TENSION,
        shear_strength=micro["shear_over_tension"] * TENSION,
        friction_angle=math.atan(micro["bond_friction"]),
        moment_contribution=micro["moment_contribution"],
        residual_friction=residual_friction(micro["bond_friction"]),
        bonding_range=micro["bonding_range"],
    )
    options = SpecimenOptions(dimension=dimension, across=ACROSS[dimension], pace=PACE[dimension])
    return Trial(material, options, seed, {}, lower=LOW)


def measure(dimension: int, workers: int) -> Path:
    """Run what is not done yet and write the map."""
    points = design(dimension)
    trials = [trial_of(micro, dimension, seed) for _, micro, seed in points]
    part = FOLDER / f"map_{dimension}d.part"
    done: dict[str, Outcome] = json.loads(part.read_text()) if part.is_file() else {}
    begun = time.perf_counter()

    def finished(number: int, outcome: Outcome) -> None:
        part.write_text(json.dumps(done))
        print(f"{len(done)} of {len(trials)} points, {time.perf_counter() - begun:.0f} s", flush=True)

    outcomes = run_trials(trials, workers=workers, done=done, finished=finished)
    path = FOLDER / f"map_{dimension}d.json"
    path.write_text(written(dimension, points, outcomes, elastic_rows(dimension)))
    part.unlink(missing_ok=True)
    return path


def elastic_rows(dimension: int) -> dict[str, list[dict[str, Any]]]:
    """Points at which only the elastic constants are solved for, by texture."""
    found: dict[str, list[dict[str, Any]]] = {}
    specimens = [make_specimen(dimension, across=ACROSS[dimension], seed=seed) for seed in SEEDS]
    for texture, fixed in TEXTURES.items():
        rows = found.setdefault(texture, [])
        for stiffness in ELASTIC[dimension]:
            micro = {"stiffness_ratio": stiffness, "shear_over_tension": 4.0, "bond_friction": 0.5, **fixed}
            material = trial_of(micro, dimension, 1).material
            both = [Rig(specimen, material).elastic_constants() for specimen in specimens]
            macro = {
                "modulus_ratio": [round(young / MODULUS, 6) for young, _ in both],
                "poisson_ratio": [round(poisson, 6) for _, poisson in both],
            }
            rows.append({"micro": micro, "macro": macro, "seeds": list(SEEDS)})
    return found


def written(
    dimension: int,
    points: list[tuple[str, dict[str, float], int]],
    outcomes: list[Outcome],
    elastic: dict[str, list[dict[str, Any]]],
) -> str:
    """The map's file, a row a line."""
    head: dict[str, Any] = {
        "format": FORMAT,
        "dimension": dimension,
        "bond_law": "rock",
        "contact_law": "effective_modulus",
        "packing": "random",
        "across": ACROSS[dimension],
        "size_ratio": SpecimenOptions().size_ratio,
        "source": f"python -m reference map --dimension {dimension}, {time.strftime('%Y-%m-%d')}, {versions()}",
        "residual_friction": "min(0.5, 0.2 + 0.6 bond_friction)",
    }
    textures = []
    for texture in TEXTURES:
        rows = [
            row_of(micro, seed, outcome)
            for (of, micro, seed), outcome in zip(points, outcomes, strict=True)
            if of == texture
        ] + elastic[texture]
        lines = ",\n   ".join(json.dumps(row) for row in rows)
        start = json.dumps(head)[:-1]
        textures.append(f'  "{texture}": {start}, "rows": [\n   {lines}\n  ]}}')
    return '{"textures": {\n' + ",\n".join(textures) + "\n}}\n"


def row_of(micro: dict[str, float], seed: int, outcome: Outcome) -> dict[str, Any]:
    """One point of the map, dimensionless."""
    tension = outcome["tensile_strength"]
    macro = {
        "modulus_ratio": outcome["young_modulus"] / MODULUS,
        "poisson_ratio": outcome["poisson_ratio"],
        "tension_ratio": tension / TENSION,
        "strength_ratio": outcome["uniaxial_compressive_strength"] / tension,
        "friction_angle": outcome["friction_angle"],
        "low_friction_angle": outcome["low_friction_angle"],
    }
    return {
        "micro": micro,
        "macro": {name: [round(value, 6)] for name, value in macro.items()},
        "seeds": [seed],
    }
