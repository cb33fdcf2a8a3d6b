"""One trial of a calibration: the laboratory's tests on one specimen of one material, in a process of its own."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from typing import Any

from ..errors import StoppedError
from ..laboratory.material import BondedMaterial
from ..laboratory.pace import PACE
from ..laboratory.properties import measure_properties
from ..laboratory.specimen import SIZE_RATIO, make_specimen

WAIT = 0.5
"""Seconds between looks whether to stop."""


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
    """

    material: BondedMaterial
    options: SpecimenOptions
    seed: int
    expected: Mapping[str, float]
    confinement: float | None = None

    @property
    def key(self) -> str:
        """The same for the same trial, to find what was done already."""
        return repr(asdict(self))


Outcome = dict[str, Any]
"""What a trial gave: young_modulus [Pa], poisson_ratio, uniaxial_compressive_strength and tensile_strength [Pa],
friction_angle [rad], and of the compression peak_strain, crack_initiation_stress, crack_damage_stress [Pa]; particles,
steps, seconds; warnings."""


def run_trial(trial: Trial) -> Outcome:
    """All tests of one trial."""
    o = trial.options
    specimen = make_specimen(
        o.dimension, width=o.width, across=o.across, size_ratio=o.size_ratio, shape=o.shape, seed=trial.seed
    )
    found = measure_properties(
        specimen, trial.material, expected=dict(trial.expected), confinement=trial.confinement, pace=o.pace
    )
    pressed = found.records[1]
    return {
        "seed": trial.seed,
        "young_modulus": found.young_modulus,
        "poisson_ratio": found.poisson_ratio,
        "uniaxial_compressive_strength": found.compressive_strength,
        "tensile_strength": found.tensile_strength,
        "friction_angle": found.friction_angle,
        "confined_strength": found.records[2].strength,
        "confinement": found.records[2].numbers["confinement"],
        **{
            name: pressed.numbers[name]
            for name in ("peak_strain", "crack_initiation_stress", "crack_damage_stress")
        },
        "particles": specimen.particles,
        "steps": sum(record.steps for record in found.records),
        "seconds": found.seconds,
        "warnings": [f"{record.kind}: {text}" for record in found.records for text in record.warnings],
    }


def run_trials(
    trials: Sequence[Trial],
    *,
    workers: int,
    done: dict[str, Outcome],
    finished: Callable[[int, Outcome], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
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

    Raises
    ------
    StoppedError
        `stop_asked` said so; what had finished is in `done`.
    """
    waiting = [k for k, trial in enumerate(trials) if trial.key not in done]
    if waiting:
        with _workers(min(workers, len(waiting))) as pool:
            running = {pool.submit(run_trial, trials[k]): k for k in waiting}
            left = set(running)
            while left:
                ready, left = wait(left, timeout=WAIT, return_when=FIRST_COMPLETED)
                for future in ready:
                    k = running[future]
                    done[trials[k].key] = future.result()
                    if finished is not None:
                        finished(k, done[trials[k].key])
                if left and stop_asked is not None and stop_asked():
                    pool.shutdown(wait=False, cancel_futures=True)
                    raise StoppedError("stopped between two tests")
    return [done[trial.key] for trial in trials]


@contextmanager
def _workers(count: int) -> Iterator[ProcessPoolExecutor]:
    """Processes whose kernels have one thread: specimens side by side keep all cores busier than one on all."""
    names = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


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
