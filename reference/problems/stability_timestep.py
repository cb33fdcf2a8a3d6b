"""Every law from 0.1 of the critical time step to beyond it; part of `python -m reference run stability`.

A leap-frog of a linear system whose modes lie at shares x_i of their own critical steps keeps, mode by mode,
m v^2 (1 - x_i^2)/2 + k x^2/2 with the mean displacement of a step; shaken from rest, its kinetic energy is therefore
never more than that at the start over 1 - x^2, x the share of the critical step of the whole. A lattice that is shaken
by a twentieth of its overlap is linear but for a few per cent.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from geodem.assembly import Assembly
from geodem.particle_simulation import ParticleSimulation

from .stability_scenes import CASES, jointed_block, packings_of, shaken_lattice
from .stability_trial import Clock, Trial, ending, trial

SHARES = (0.1, 0.3, 0.5, 0.8, 0.95)
BEYOND = 1.05
BOUNDED = "bounded"
NOTHING_MADE = 0.1
"""Largest imbalance of an energy account of a motion that is bounded [-]."""
LINEAR = 1.1
"""What is let for the few per cent that are not linear."""
SOURCE = "closed form: kinetic energy of a leap-frog, at most the first over 1 - x^2"


def largest_kinetic(assembly: Assembly, share: float, steps: int, *, look: int = 50) -> float:
    """Largest kinetic energy over the first, times 1 - share^2, of those after every `look` steps."""
    simulation = ParticleSimulation(assembly, energy=True, orientation=False, time_step=None)
    simulation.time_step = simulation.span = share * simulation.critical_time_step
    first, largest = simulation.kinetic_energy(), 0.0
    for _ in range(steps // look):
        simulation.run(look)
        largest = max(largest, simulation.kinetic_energy())
    return largest / first * (1.0 - share**2)


def beyond(assembly: Assembly, steps: int) -> tuple[bool, str | None]:
    """Whether 1.05 of the critical step is refused, and the message of a run that is forced to take it."""
    critical = ParticleSimulation(assembly, energy=True, orientation=False).critical_time_step
    with ending() as first:
        ParticleSimulation(assembly, energy=True, orientation=False, time_step=BEYOND * critical)
    simulation = ParticleSimulation(assembly, energy=True, orientation=False)
    simulation.time_step = simulation.span = BEYOND * critical
    with ending() as second:
        simulation.run(steps)
    message = second.message
    if message is None and abs(simulation.energy().imbalance) < NOTHING_MADE:
        # contacts that open end the growth: what was stored in them is all that moves
        message = BOUNDED
    return first.message is not None and "critical time step" in first.message, message


def one_law(name: str, assemblies: Iterable[Assembly], steps: int, clock: Clock) -> list[Trial]:
    """Below the critical step, and beyond it."""
    below: list[float] = []
    above: list[tuple[bool, str | None]] = []
    for assembly in assemblies:
        for share in SHARES:
            with ending() as found:
                below.append(largest_kinetic(assembly, share, steps))
            if found.message is not None:
                below.append(math.inf)
        above.append(beyond(assembly, 5 * steps))
    bad = sum(not refused or message is None for refused, message in above)
    stopped = sum(message not in (None, BOUNDED) for _, message in above)
    return [
        trial(
            f"time step 0.1 to 0.95 of critical, {name}",
            f"largest kinetic energy in {steps} steps over that bound",
            max(below),
            LINEAR,
            len(below),
            clock.read(),
            SOURCE,
        ),
        trial(
            f"time step {BEYOND} of critical, {name}",
            "runs that were not refused, or exploded unnoticed when forced",
            bad,
            0.0,
            2 * len(above),
            clock.read(),
            "a step above the critical one grows without bound",
            f"asked for: refused; forced: {stopped} of {len(above)} stopped with a message, the others made no energy",
        ),
    ]


def rows(steps: int = 2000, cases: Iterable[tuple[str, str | None, int]] = tuple(CASES)) -> list[Trial]:
    """Every law of contacts, bonds and joints."""
    clock, found = Clock(), []
    for contact, bond, dimension in cases:
        name = f"{bond or contact} {dimension}D"
        kinds = packings_of(contact, bond, dimension)
        scenes = [shaken_lattice(contact, bond, dimension, kind) for kind in kinds]
        found += one_law(f"{name}, {' and '.join(kinds)}", scenes, steps, clock)
    return found


def joints(
    steps: int = 2000, laws: Iterable[str] = ("smooth_joint", "bolt"), dimensions: Iterable[int] = (2, 3)
) -> list[Trial]:
    """Every law of joints, in a bonded block."""
    clock, found = Clock(), []
    for law in laws:
        for dimension in dimensions:
            found += one_law(f"{law} {dimension}D", [jointed_block(law, dimension)], steps, clock)
    return found
