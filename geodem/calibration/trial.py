"""One trial of a calibration: the laboratory's tests on one specimen of one material, in a process of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from .._jit import compile_seconds
from ..laboratory.material import BondedMaterial
from ..laboratory.pace import PACE
from ..laboratory.processes import Processes, Task
from ..laboratory.properties import measure_properties
from ..laboratory.specimen import SIZE_RATIO, make_specimen


@dataclass(frozen=True)
class SpecimenOptions:
    """How every specimen is made; see `geodem.laboratory.specimen.make_specimen`.

    Attributes
    ----------
    dimension : int
    width : float [m]
    across : float
        Particles across the width.
    size_ratio : float
        Largest over smallest radius [-].
    shape : str
    pace : float
        Of the tests, see `geodem.laboratory.pace`.
    """

    dimension: int = 2
    width: float = 0.05
    across: float = 30.0
    size_ratio: float = SIZE_RATIO
    shape: str = "prism"
    pace: float = PACE


@dataclass(frozen=True)
class Trial:
    """A specimen that waits for its tests.

    Attributes
    ----------
    material : BondedMaterial
    options : SpecimenOptions
    seed : int
        Of the specimen.
    expected : dict of str to float
        Strains at the peaks, see `measure_properties`.
    confinement : float or None
        Of the confined test [Pa].
    lower : float or None
        Of one more confined test, over the compressive strength that was measured.
    """

    material: BondedMaterial
    options: SpecimenOptions
    seed: int
    expected: Mapping[str, float]
    confinement: float | None = None
    lower: float | None = None

    @property
    def key(self) -> str:
        """The same for the same trial, to find what was done already."""
        return repr(asdict(self))


Outcome = dict[str, Any]
"""What a trial gave: young_modulus [Pa], poisson_ratio, uniaxial_compressive_strength and tensile_strength [Pa],
friction_angle and, where it was asked for, low_friction_angle [rad], and of the compression peak_strain,
crack_initiation_stress, crack_damage_stress [Pa]; particles, steps; seconds, and those that went into compiling
kernels; warnings."""


def run_trial(trial: Trial) -> Outcome:
    """All tests of one trial."""
    o = trial.options
    before = compile_seconds()
    specimen = make_specimen(
        o.dimension, width=o.width, across=o.across, size_ratio=o.size_ratio, shape=o.shape, seed=trial.seed
    )
    found = measure_properties(
        specimen, trial.material, expected=dict(trial.expected), confinement=trial.confinement, lower=trial.lower,
        pace=o.pace,
    )  # fmt: skip
    pressed = found.records[1]
    compiled = compile_seconds() - before
    return {
        "seed": trial.seed,
        "young_modulus": found.young_modulus,
        "poisson_ratio": found.poisson_ratio,
        "uniaxial_compressive_strength": found.compressive_strength,
        "tensile_strength": found.tensile_strength,
        "friction_angle": found.friction_angle,
        **({} if trial.lower is None else {"low_friction_angle": found.low_friction_angle}),
        "confined_strength": found.records[2].strength,
        "confinement": found.records[2].numbers["confinement"],
        **{
            name: pressed.numbers[name]
            for name in ("peak_strain", "crack_initiation_stress", "crack_damage_stress")
        },
        "particles": specimen.particles,
        "steps": sum(record.steps for record in found.records),
        "seconds": found.seconds - compiled,
        "compile_seconds": compiled,
        "warnings": [f"{record.kind}: {text}" for record in found.records for text in record.warnings],
    }


def run_trials(
    trials: Sequence[Trial],
    *,
    workers: int,
    done: dict[str, Outcome],
    finished: Callable[[int, Outcome], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    waiting: Callable[[list[float]], None] | None = None,
) -> list[Outcome]:
    """Run trials side by side; outcomes in the order of the trials, the same whatever the number of workers.

    Parameters
    ----------
    trials : sequence of Trial
    workers : int
        Processes, of one thread each.
    done : dict
        Outcomes by `Trial.key`: what is there is not run again, what is run is added.
    finished : callable, optional
        Is told the number of a trial and its outcome as soon as it is there.
    stop_asked : callable, optional
    waiting : callable, optional
        Is told now and then for how long each trial has been under way [s].

    Raises
    ------
    StoppedError
        `stop_asked` said so; what had finished is in `done`.
    """
    left = [k for k, trial in enumerate(trials) if trial.key not in done]
    with Processes(workers) as processes:
        for what, number, outcome in processes.events(
            [Task(run_trial, (trials[k],)) for k in left], stop_asked
        ):
            if what == "done":
                k = left[number]
                done[trials[k].key] = outcome
                if finished is not None:
                    finished(k, outcome)
            elif waiting is not None:
                waiting([running.seconds for running in processes.running()])
    return [done[trial.key] for trial in trials]


def peaks_of(
    young: float, compression: float, tension: float, friction: float, sides: float
) -> dict[str, float]:
    """Strains at the peaks of a rock with these properties [Pa, rad], roughly: what sets the rates.

    Specimens soften on the way: in compression they go a quarter farther than an elastic one would, confined by half.
    """
    sine = math.sin(friction)
    confined = compression + sides * (1.0 + sine) / (1.0 - sine)
    return {
        "compression": 1.25 * compression / young,
        "tension": 1.05 * tension / young,
        "confined": 1.5 * confined / young,
    }
