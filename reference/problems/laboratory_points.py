"""Tests of the laboratory by the hundred: what is asked of each, what comes of it, several processes to make them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from geodem.laboratory.axial import compress, pull
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.pace import PACE
from geodem.laboratory.processes import Processes, Task
from geodem.laboratory.rig import STEP
from geodem.laboratory.specimen import make_specimen
from geodem.laboratory.workers import workers_allowed

Floats = NDArray[np.float64]
Asked = TypeVar("Asked")
Told = TypeVar("Told")

FAST = 0.5 * PACE
"""Pace where many specimens are tested and bounds are wide: hard rock comes out 6 % stronger, weak rock does not."""

FALL = 0.85
"""Of the peak: what lies beyond it is not asked for."""


@dataclass(frozen=True)
class Point:
    """One test on one specimen, twice as high as wide.

    `pressure` [Pa] is that on the sides, `expected_strain` the axial one at the peak, roughly: with `pace` it sets the
    rate, and where it is left out a pilot finds it. `grain` is a factor on the density, which changes nothing but the
    rounding.
    """

    key: str
    material: BondedMaterial = field(repr=False, hash=False)
    kind: str
    across: float
    seed: int
    expected_strain: float | None = field(default=None, repr=False)
    pressure: float = 0.0
    pace: float = PACE
    time_share: float = STEP
    dimension: int = 2
    grain: float = 1.0


class Answer(NamedTuple):
    """What came of it: strength and modulus [Pa], axial strain at the peak; the stresses of crack initiation and damage
    [Pa]; the shares of bonds that were broken at the peak, by tension and by shear."""

    strength: float
    young: float
    peak_strain: float
    initiation: float
    damage: float
    torn: float
    cut: float
    failed: bool
    particles: int
    steps: int
    seconds: float


def measure(point: Point) -> Answer:
    """Make one test."""
    specimen = make_specimen(point.dimension, across=point.across, seed=point.seed)
    material = replace(point.material, density=point.grain * point.material.density)
    if point.kind == "tension":
        record = pull(
            specimen, material, expected_strain=point.expected_strain, pace=point.pace,
            time_share=point.time_share, fall=FALL,
        )  # fmt: skip
    else:
        record = compress(
            specimen, material, confinement=point.pressure, expected_strain=point.expected_strain,
            pace=point.pace, time_share=point.time_share, fall=FALL,
        )  # fmt: skip
    n = record.numbers
    return Answer(
        record.strength, n["young_modulus"], n["peak_strain"], n["crack_initiation_stress"],
        n["crack_damage_stress"], n["tension_cracks_at_peak"] / n["bonds"], n["shear_cracks_at_peak"] / n["bonds"],
        record.failed, specimen.particles, record.steps, record.seconds,
    )  # fmt: skip


def measure_all(points: Sequence[Point], processes: int | None = None) -> dict[Point, Answer]:
    """Make the tests, the longest first."""
    order = sorted(set(points), key=lambda p: -p.pace * p.across ** (p.dimension + 1))
    return dict(zip(order, in_processes(measure, order, processes), strict=True))


def in_processes(
    function: Callable[[Asked], Told], asked: Sequence[Asked], processes: int | None = None
) -> list[Told]:
    """Results in the order of what was asked, each from one thread of one process; as many of these as cores."""
    count = workers_allowed(processes)
    if count == 1:
        return [function(one) for one in asked]
    told: dict[int, Told] = {}
    with Processes(count) as several:
        for event in several.events([Task(function, (one,)) for one in asked]):
            if event.what == "done":
                told[event.task] = event.content
    return [told[k] for k in range(len(asked))]


class Mean(NamedTuple):
    """Of several values, with the standard deviation of one of them and the standard error of the mean."""

    value: float
    deviation: float
    error: float
    number: int

    @classmethod
    def of(cls, values: Iterable[float]) -> Mean:
        """Of two values at least."""
        found = np.array(list(values))
        deviation = float(found.std(ddof=1))
        return cls(float(found.mean()), deviation, deviation / len(found) ** 0.5, len(found))
