"""Calibration: bonds from the map, specimens of them in the laboratory, bonds mended by what these gave.

Every round tests new specimens. What they give corrects the map near its place (`Surrogate.corrected`), so that all
rounds count, and the corrected map is turned round again. That is a secant step in which noise is known to be noise.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from json import loads
from pathlib import Path

from ..errors import InputError, InputErrors
from ..laboratory.confined import CONFINED
from ..laboratory.material import BondedMaterial
from .inverse import Fit, Miss, invert
from .surrogate import Estimate, Measured, Surrogate, fit_surrogate
from .table import table_of
from .targets import RockTargets, check_targets
from .trial import Outcome, SpecimenOptions, Trial, peaks_of, run_trials

ROUNDS = 3
"""Most rounds of tests."""

SPECIMENS = 4
"""Of a round."""

GOOD = {
    "young_modulus": 0.02,
    "poisson_ratio": 0.01,
    "uniaxial_compressive_strength": 0.04,
    "tensile_strength": 0.04,
    "friction_angle": math.radians(1.5),
}
"""Half width of the interval of the mean at which no more tests are needed: a share, or for the ratio and the angle a
difference."""

SEEDS_APART = 100_003
"""Between the first seeds of calibrations with neighbouring seeds, so that they share no specimen."""

OF_TARGETS = tuple(GOOD)


@dataclass(frozen=True)
class Progress:
    """Told while a calibration runs.

    Attributes
    ----------
    round, rounds : int
        The present one from 1, and the most there can be.
    done, tests : int
        Specimens of all rounds so far, and the most there can be.
    seconds : float
        So far.
    seconds_left, seconds_most : float
        Between the end after the next round that may be the last one and after the last; and after the last, if what is
        to come takes as long as the longest specimen did. nan while no specimen is done.
    text : str
    """

    round: int
    rounds: int
    done: int
    tests: int
    seconds: float
    seconds_left: float
    seconds_most: float
    text: str


@dataclass(frozen=True)
class Round:
    """Bonds that were tested, and what their specimens gave."""

    fit: Fit
    material: BondedMaterial
    outcomes: tuple[Outcome, ...]

    def mean(self, name: str) -> float:
        """Of a property over the specimens of this round."""
        return sum(float(outcome[name]) for outcome in self.outcomes) / len(self.outcomes)


@dataclass(frozen=True)
class Calibration:
    """Bonds for a rock, and what they are worth.

    Attributes
    ----------
    targets : RockTargets
    options : SpecimenOptions
    material : BondedMaterial
    achieved : dict of str to Estimate
        Names of `RockTargets`: the mean over specimens of the material, with its interval at 95 %.
    missed : tuple of Miss
        Properties that the map says cannot be had, with what is nearest.
    edges : dict of str to float
        Micro-parameters that stand at an end of what was measured: beyond it, other bonds might be nearer.
    rounds : tuple of Round
    texture : str
        Which of the maps: how far grains are bonded.
    good : bool
        Whether all intervals are as narrow as `GOOD` asks for.
    seed : int
    seconds : float
    """

    targets: RockTargets
    options: SpecimenOptions
    material: BondedMaterial
    achieved: Mapping[str, Estimate]
    missed: tuple[Miss, ...]
    edges: Mapping[str, float]
    rounds: tuple[Round, ...]
    texture: str
    good: bool
    seed: int
    seconds: float

    @property
    def tests(self) -> int:
        """Specimens that were tested."""
        return sum(len(each.outcomes) for each in self.rounds)

    def summary(self) -> str:
        """A line for each property: target, achieved, interval."""
        lines = []
        for name in OF_TARGETS:
            got = self.achieved[name]
            low, high = replace(self.targets, **{name: got.low}), replace(self.targets, **{name: got.high})
            lines.append(
                f"{name.replace('_', ' ')}: {self.targets.shown(name)} wanted, "
                f"{replace(self.targets, **{name: got.value}).shown(name)} achieved "
                f"({low.shown(name)} to {high.shown(name)})"
            )
        return "\n".join(lines)


def residual_friction(bond_friction: float) -> float:
    """Friction coefficient of broken bonds that goes with that of intact ones [-]: more of it, up to a half.

    A free choice that the map makes: without less friction of what is broken no friction angle comes below 25 degrees.
    """
    return min(0.5, 0.2 + 0.6 * bond_friction)


@lru_cache(maxsize=8)
def surrogates(dimension: int, confinement: float = CONFINED) -> dict[str, Surrogate]:
    """Maps of a dimension by texture, from the tables stored with the package.

    Parameters
    ----------
    dimension : int
    confinement : float
        Up to which friction angles are meant, over the compressive strength [-].

    Raises
    ------
    InputError
        There is none of this dimension.
    """
    folder = files("geodem.calibration")
    name = f"map_{dimension}d.json"
    entry = folder / name
    if not entry.is_file():
        raise InputError("dimension", "there is no map", "Give 2 or 3", value=dimension)
    content = loads(entry.read_text(encoding="utf-8"))
    return {
        texture: fit_surrogate(table_of(table, place=f"{Path(name)}, {texture}").up_to(confinement))
        for texture, table in content["textures"].items()
    }


def first_fit(targets: RockTargets, dimension: int) -> tuple[str, Surrogate, Fit]:
    """Which map suits a rock, and the bonds it gives before any test.

    The first of those that can have all properties: grains that are bonded to their neighbours alone scatter less, from
    specimen to specimen, than interlocked ones, and crack later. Where none has all, the one that misses least.
    """
    share = targets.sides / targets.uniaxial_compressive_strength
    found = []
    for order, (texture, surrogate) in enumerate(surrogates(dimension, share).items()):
        fit = invert(surrogate, targets)
        lack = sum(abs(math.log(miss.nearest / miss.wanted)) for miss in fit.missed)
        found.append((lack, order, texture, surrogate, fit))
    _, _, texture, surrogate, fit = min(found, key=lambda entry: entry[:2])
    return texture, surrogate, fit


def material_of(fit: Fit, targets: RockTargets, name: str) -> BondedMaterial:
    """Bonds and contacts; the friction of broken bonds follows that of intact ones."""
    micro = {**fit.micro, "residual_friction": residual_friction(fit.micro["bond_friction"])}
    return replace(fit, micro=micro).material(targets.density, name=name)


def calibrate(
    targets: RockTargets,
    options: SpecimenOptions | None = None,
    *,
    seed: int = 1,
    name: str = "rock",
    rounds: int = ROUNDS,
    specimens: int = SPECIMENS,
    workers: int = 1,
    done: dict[str, Outcome] | None = None,
    watch: Callable[[Progress], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    after: float = 0.0,
) -> Calibration:
    """Find bonds for a rock.

    Parameters
    ----------
    targets : RockTargets
    options : SpecimenOptions, optional
    seed : int
        Of the specimens: others are tested with another.
    name : str
        Of the material.
    rounds : int
        Most rounds of tests; fewer where the intervals are narrow before.
    specimens : int
        Of a round.
    workers : int
        Processes; the result does not depend on them.
    done : dict, optional
        Outcomes of an interrupted calibration; new ones are added.
    watch, stop_asked : callables, optional
    after : float
        What follows, over the work of a specimen: for the time left that is told.

    Raises
    ------
    InputError
        Targets that contradict each other (`check_targets`), several at once as `InputErrors`.
    StoppedError
        `stop_asked` said so; what had finished is in `done`.
    """
    begun = time.perf_counter()
    options = options or SpecimenOptions()
    faults = check_targets(targets, options.dimension)
    if faults:
        raise faults[0] if len(faults) == 1 else InputErrors(faults)
    if rounds < 1 or specimens < 2:
        raise InputError(
            "rounds, specimens", "an interval needs one round of two specimens at least", "Give 4 and 4",
            value=(rounds, specimens),
        )  # fmt: skip
    known = {} if done is None else done
    texture, surrogate, fit = first_fit(targets, options.dimension)
    sides = targets.sides
    expected = peaks_of(
        targets.young_modulus, targets.uniaxial_compressive_strength, targets.tensile_strength,
        targets.friction_angle, sides,
    )  # fmt: skip
    tested: list[Round] = []
    spent: list[float] = []
    good = False
    for number in range(1, rounds + 1):
        material = material_of(fit, targets, name)
        first = SEEDS_APART * seed + (number - 1) * specimens
        trials = [Trial(material, options, first + k, expected, sides) for k in range(specimens)]

        def tell(running: Sequence[float] = (), number: int = number) -> None:
            if watch is not None:
                watch(_progress(number, rounds, specimens, spent, running, workers, after, begun))

        def finished(_: int, outcome: Outcome, tell: Callable[[], None] = tell) -> None:
            spent.append(float(outcome["seconds"]))
            tell()

        tell()
        outcomes = run_trials(
            trials, workers=workers, done=known, finished=finished, stop_asked=stop_asked, waiting=tell
        )
        tested.append(Round(fit, material, tuple(outcomes)))
        surrogate = surrogate.corrected([_measured(each) for each in tested])
        fit = invert(surrogate, targets)
        good = number > 1 and all(_narrow(name, fit.answers[name]) for name in OF_TARGETS)
        if good:
            break
    return Calibration(
        targets, options, material_of(fit, targets, name), fit.answers, fit.missed, surrogate.edges(fit.micro),
        tuple(tested), texture, good, seed, time.perf_counter() - begun,
    )  # fmt: skip


def _progress(
    number: int,
    rounds: int,
    specimens: int,
    spent: Sequence[float],
    running: Sequence[float],
    workers: int,
    after: float,
    begun: float,
) -> Progress:
    """Where a calibration is; of specimens that are under way: for how long [s]."""
    most, done = rounds * specimens, len(spent)
    mean = sum(spent) / done if spent else math.nan
    # the first that end are the quickest: what is under way for longer than they took counts as well
    longer = [seconds for seconds in running if seconds > mean]
    if longer:
        mean = (sum(spent) + sum(longer)) / (done + len(longer))
    longest = max([*spent, *longer], default=math.nan)
    gone = sum(min(seconds, mean) for seconds in running)

    def left(last: int, each: float) -> float:
        return (max((last * specimens - done + after) * each - gone, 0.0)) / workers

    text = f"round {number} of at most {rounds}, {done} of at most {most} specimens tested"
    # the second round is the first that may be the last
    expected = 0.5 * (left(min(max(number, 2), rounds), mean) + left(rounds, mean))
    at_most = left(rounds, longest)
    return Progress(number, rounds, done, most, time.perf_counter() - begun, expected, at_most, text)


def _measured(tested: Round) -> Measured:
    """What a round gave, dimensionless as the map is."""
    modulus, strength = tested.fit.effective_modulus, tested.fit.tensile_strength

    def column(name: str) -> list[float]:
        return [float(outcome[name]) for outcome in tested.outcomes]

    tension, compression = column("tensile_strength"), column("uniaxial_compressive_strength")
    return Measured(
        tested.fit.micro,
        {
            "modulus_ratio": [value / modulus for value in column("young_modulus")],
            "poisson_ratio": column("poisson_ratio"),
            "tension_ratio": [value / strength for value in tension],
            "strength_ratio": [c / t for c, t in zip(compression, tension, strict=True)],
            "compression_ratio": [value / strength for value in compression],
            "friction_angle": column("friction_angle"),
        },
    )


def _narrow(name: str, estimate: Estimate) -> bool:
    half = 0.5 * (estimate.high - estimate.low)
    share = half if name in ("poisson_ratio", "friction_angle") else half / estimate.value
    return share <= GOOD[name]
