"""Six rocks calibrated, then tested on specimens that the calibration has not seen: `python -m reference run rocks`.

Granite and sandstone also of spheres. The bounds are those of the mean over the fresh specimens; those of spheres are
twice as wide. `GEODEM_ROCKS`, a list such as "granite 2, sandstone 3", runs only these. What is done is kept in a part
file until all is, so that a run that was stopped goes on.
"""

from __future__ import annotations

import json
import math
import os
import time
from typing import Any

from geodem.calibration.fit import Calibration, calibrate
from geodem.calibration.targets import RockTargets
from geodem.calibration.trial import Outcome, SpecimenOptions, Trial, peaks_of, run_trials
from geodem.laboratory.properties import CONFINED

from ..results_file import FOLDER
from .rocks import read_rocks, targets_of
from .rows import Row, at_most

PART = FOLDER / "rocks.part"

FRESH = {2: 8, 3: 4}
"""Specimens that the calibration has not seen."""

FIRST_FRESH = 7_000_000
"""Seed of the first of them."""

BOUNDS = {
    "young_modulus": 0.04,
    "poisson_ratio": 0.02,
    "uniaxial_compressive_strength": 0.06,
    "tensile_strength": 0.08,
    "friction_angle": math.radians(2.0),
}
"""Of the mean over fresh specimens: shares, or for the ratio and the angle differences; of spheres twice as much."""

ABSOLUTE = ("poisson_ratio", "friction_angle")

LONGEST = 300.0
"""Of a calibration on two cores [s]."""

OPTIONS = {2: SpecimenOptions(dimension=2), 3: SpecimenOptions(dimension=3, across=10.0)}

CASES = [(rock, 2) for rock in ("granite", "marble", "sandstone", "shale", "mudstone", "concrete")]
CASES += [("granite", 3), ("sandstone", 3)]


def run() -> list[Row]:
    """Every rock, and how well fresh specimens hit it."""
    chosen = os.environ.get("GEODEM_ROCKS")
    cases = CASES
    if chosen:
        cases = [(name, int(d)) for name, d in (entry.split() for entry in chosen.split(","))]
    rocks = read_rocks()
    done: dict[str, list[Any]] = json.loads(PART.read_text()) if PART.is_file() else {}
    rows: list[Row] = []
    for name, dimension in cases:
        label = f"{name} {dimension}D"
        if label not in done:
            done[label] = rows_of(name, rocks[name], dimension)
            PART.write_text(json.dumps(done))
        rows += [Row(*row) for row in done[label]]
    PART.unlink(missing_ok=True)
    return rows


def rows_of(name: str, rock: dict[str, Any], dimension: int) -> list[Row]:
    """Calibrate one rock, test fresh specimens, and hold the means to the bounds."""
    targets = targets_of(rock)
    workers = os.cpu_count() or 1
    begun = time.perf_counter()
    found = calibrate(targets, OPTIONS[dimension], name=name, workers=workers)
    seconds = time.perf_counter() - begun
    print(f"{name} {dimension}D: {found.tests} specimens, {seconds:.0f} s\n{found.summary()}", flush=True)
    outcomes = fresh(found, workers)
    label = f"{name} {dimension}D"
    rows = [at_most(label, "seconds of the calibration on two cores", seconds, LONGEST, seconds, "asked for")]
    for quantity, bound in BOUNDS.items():
        rows.append(_row(label, quantity, targets, outcomes, bound * (1 if dimension == 2 else 2), rock))
    for row in rows:
        print(f"   {row.quantity}: {row.value:.5g}, {row.expected:.5g} wanted, {'good' if row.good else 'MISS'}")
    brittle = [o["peak_strain"] * o["young_modulus"] / o["uniaxial_compressive_strength"] for o in outcomes]
    print(f"   peak strain over UCS/E {sum(brittle) / len(brittle):.2f}, {found.texture}", flush=True)
    return rows


def fresh(found: Calibration, workers: int) -> list[Outcome]:
    """Outcomes of specimens that the calibration has not seen."""
    targets = found.targets
    sides = CONFINED * targets.uniaxial_compressive_strength
    expected = peaks_of(
        targets.young_modulus, targets.uniaxial_compressive_strength, targets.tensile_strength,
        targets.friction_angle, sides,
    )  # fmt: skip
    trials = [
        Trial(found.material, found.options, FIRST_FRESH + k, expected, sides)
        for k in range(FRESH[found.options.dimension])
    ]
    return run_trials(trials, workers=workers, done={})


def _row(
    label: str,
    quantity: str,
    targets: RockTargets,
    outcomes: list[Outcome],
    bound: float,
    rock: dict[str, Any],
) -> Row:
    values = [float(outcome[quantity]) for outcome in outcomes]
    mean = sum(values) / len(values)
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))
    wanted = float(getattr(targets, quantity))
    scale = math.degrees(1.0) if quantity == "friction_angle" else 1.0
    if quantity in ABSOLUTE:
        error, shown = mean - wanted, f"{quantity} (difference)"
    else:
        error, shown = mean / wanted - 1.0, quantity
    seconds = sum(float(outcome["seconds"]) for outcome in outcomes)
    source = f"{rock['source'].get(quantity, '')}; standard deviation of one specimen {scale * deviation:.3g}"
    if quantity == "friction_angle":
        return Row(
            label,
            f"{shown} [deg]",
            scale * mean,
            scale * wanted,
            scale * error,
            scale * bound,
            seconds,
            source,
        )
    return Row(label, shown, mean, wanted, error, bound, seconds, source)
