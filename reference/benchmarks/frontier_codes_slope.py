"""A slope of bonded spheres whose gravity grows until it breaks, for geodem and YADE; LIGGGHTS has no bonds.

One layer of equal spheres in a hexagonal lattice that moves in its plane, cut to 45 degrees, on a held row. The answers
are the factors on gravity at which the first bond and a twentieth of them are broken, without any motion: geodem's
statics tell them in small increments of gravity. It never slides away: a hexagonal lattice keeps standing at 45 degrees
by friction alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from ..backends import yade
from ..posed import Posed
from ..results_file import Row
from .frontier_codes_runs import CONVENTIONS, GEODEM, YADE, Floats, point

RADIUS = 0.5  # [m]
DENSITY = 2000.0  # [kg/m3]
CONTACT = {"young_modulus": 2e8, "stiffness_ratio": 0.5, "friction_coefficient": 0.5}
BOND = {**CONTACT, "tensile_strength": 4e3, "cohesion": 8e3}
GRAVITY = 9.81  # [m/s2], at a factor of 1
DAMAGE = 0.05
"""Share of the bonds that are broken in the second answer."""
LOCAL_DAMPING = 0.5
SHARE = 0.5
"""Time step over the critical one."""
EVERY = 10
"""Steps between settings of gravity."""
BEYOND = 1.25
"""Factor at the end of a ramp over that of the damage in statics."""
INCREMENTS = (0.1, 0.05, 0.02, 0.01)
"""Of gravity, over the first break."""
FINE = 0.002
"""That of the answer."""
MOST_INCREASE = 5.0


def slope(height: int) -> Assembly:
    """So many rows above the held one; behind the crest the ground is as wide as the slope is high."""
    rise = math.sqrt(3.0) * RADIUS
    high = height * rise
    positions = [
        (x, row * rise, 0.0)
        for row in range(height + 1)
        for x in np.arange(RADIUS * (row % 2), 2.0 * high + RADIUS, 2.0 * RADIUS)
        if x <= 2.0 * high - row * rise + 1e-9 * RADIUS
    ]
    places = np.array(positions) * (1.0 - 1e-9)
    b = AssemblyBuilder(3, "elastic_frictional", "jointed_cohesive", gravity=(0.0, -GRAVITY, 0.0))
    b.add_material("rock", density=DENSITY, contact=CONTACT, bond=BOND)
    b.add_particles(places, RADIUS, "rock")
    b.bond_within(1.001)
    base = np.flatnonzero(places[:, 1] == 0.0)
    b.hold(base, x=0.0, y=0.0, rotation=0.0)
    behind = np.flatnonzero(places[:, 0] < 0.75 * RADIUS)
    b.hold(behind, x=0.0)
    assembly = b.build()
    held = assembly.held.copy()
    # out of the plane
    held[:, [2, 3, 4]] = True
    return replace(assembly, held=held)


def at(assembly: Assembly, factor: float) -> Assembly:
    """The slope at a factor on gravity."""
    return replace(assembly, gravity=factor * assembly.gravity)


# --- statics ------------------------------------------------------------------------------------------------


class Found(NamedTuple):
    """Factors on gravity at which one bond and so many of them were broken, and seconds until then; nan: never."""

    first: float
    damage: float
    seconds_first: float
    seconds_damage: float


def many(assembly: Assembly) -> int:
    """Broken bonds that count as damage."""
    return math.ceil(DAMAGE * len(assembly.bonds))


def elastic_first(assembly: Assembly, factor: float = 1.0) -> tuple[float, float]:
    """Factor of the first break from the elastic state at a factor, forces taken to be in proportion; and seconds."""
    simulation = ParticleSimulation(at(assembly, factor), orientation=False)
    simulation.kernel(simulation.features.relaxing())
    begun = time.perf_counter()
    find_equilibrium(simulation, breaking=False)
    normal, shear = simulation.contact_forces()
    size = np.sqrt((shear.reshape(len(normal), -1) ** 2).sum(axis=1))
    area = math.pi * RADIUS**2
    with np.errstate(divide="ignore"):
        tension = np.where(normal < 0.0, BOND["tensile_strength"] * area / -normal, np.inf)
        beyond = size - CONTACT["friction_coefficient"] * normal
        sheared = np.where(beyond > 0.0, BOND["cohesion"] * area / beyond, np.inf)
    return factor * float(min(tension.min(), sheared.min())), time.perf_counter() - begun


def first_break(assembly: Assembly) -> float:
    """Factor of the first break in statics: the elastic state at the factor that the one before told."""
    factor = 1.0
    for _ in range(4):
        factor, _ = elastic_first(assembly, factor)
    return factor


def by_increments(assembly: Assembly, increment: float) -> Found:
    """Gravity raised by shares of the first break, each to equilibrium with breaking bonds; factors between trials."""
    first, seconds = elastic_first(assembly)
    step = increment * first
    factor = first - 0.5 * step
    simulation = ParticleSimulation(at(assembly, factor), orientation=False)
    simulation.kernel(simulation.features.relaxing())
    gravity, until = simulation.assembly.gravity, many(assembly)
    begun = time.perf_counter() - seconds
    while factor < MOST_INCREASE * first:
        gravity[:] = factor * assembly.gravity
        find_equilibrium(simulation)
        if np.count_nonzero(~simulation.intact()) >= until:
            return Found(first, factor - 0.5 * step, seconds, time.perf_counter() - begun)
        factor += step
    return Found(first, math.nan, seconds, math.nan)


# --- ramps --------------------------------------------------------------------------------------------------


def rising(assembly: Assembly, top: float, steps: int, code: str) -> Posed:
    """Gravity from nothing to a factor `top` in so many steps, with local damping."""
    critical = ParticleSimulation(assembly, local_damping=LOCAL_DAMPING, orientation=False).critical_time_step
    return Posed(
        "slope", at(assembly, top), SHARE * critical, steps, CONVENTIONS[code], local_damping=LOCAL_DAMPING
    )


def ramp(posed: Posed, until: int) -> Floats:
    """geodem's run: steps done, bonds broken and seconds in the loop, as `reference.backends.yade.run_ramp` tells."""
    full = posed.assembly.gravity
    simulation = ParticleSimulation(
        replace(posed.assembly, gravity=full.copy()), time_step=posed.time_step, local_damping=posed.local_damping,
        convention=posed.convention, orientation=False,
    )  # fmt: skip
    simulation.kernel(simulation.features)
    simulation.assembly.gravity[:] = 0.0
    watched = []
    begun = time.perf_counter()
    while simulation.steps < posed.steps:
        simulation.run(EVERY)
        simulation.assembly.gravity[:] = min(simulation.steps / posed.steps, 1.0) * full
        broken = np.count_nonzero(~simulation.intact())
        watched.append((simulation.steps, broken, time.perf_counter() - begun))
        if broken >= until:
            break
    return np.array(watched)


def read(watched: Floats, top: float, steps: int, until: int) -> Found:
    """Factors and seconds from a run."""
    values = []
    for least in (1, until):
        reached = np.flatnonzero(watched[:, 1] >= least)
        values.append(watched[reached[0]] if len(reached) else np.full(3, math.nan))
    # breaks fall between two settings of gravity
    factors = [top * (value[0] - 0.5 * EVERY) / steps for value in values]
    return Found(factors[0], factors[1], values[0][2], values[1][2])


# --- rows ---------------------------------------------------------------------------------------------------


def slope_rows(codes: Sequence[str], height: int, ramps: Sequence[int], rounds: int) -> list[Row]:
    """Ramps of both codes, and geodem's statics."""
    assembly = slope(height)
    until = many(assembly)
    # compiled beforehand
    by_increments(assembly, INCREMENTS[0])
    first, damage = first_break(assembly), by_increments(assembly, FINE).damage
    top = BEYOND * damage
    runs: dict[str, Callable[[Posed], Floats]] = {
        GEODEM: lambda posed: ramp(posed, until),
        YADE: lambda posed: yade.run_ramp(posed, every=EVERY, until=until),
    }
    runs = {code: run for code, run in runs.items() if code in codes}
    if GEODEM in runs:
        runs[GEODEM](rising(assembly, top, min(ramps), GEODEM))
    rows = []
    for steps in ramps:
        found: dict[str, list[Found]] = {code: [] for code in runs}
        for _ in range(rounds):
            for code, run in runs.items():
                found[code].append(read(run(rising(assembly, top, steps, code)), top, steps, until))
        for code, results in found.items():
            rows += _rows(
                code, "gravity ramp", steps, "steps of the ramp", results, (first, damage), assembly
            )
    for increment in INCREMENTS:
        results = [by_increments(assembly, increment) for _ in range(rounds)]
        rows += _rows(
            GEODEM, "statics", increment, "increment of gravity", results, (first, damage), assembly
        )
    return rows


def _rows(
    code: str,
    driver: str,
    setting: float,
    unit: str,
    found: Sequence[Found],
    answers: tuple[float, float],
    assembly: Assembly,
) -> list[Row]:
    one = found[0]
    about: dict[str, Any] = {"particles": assembly.particles, "bonds": len(assembly.bonds)}
    rows = []
    if driver != "statics":
        rows = [(driver, setting, unit)]
    elif setting == INCREMENTS[0]:
        # which knows no increments
        rows = [("elastic state", 1.0, "of gravity")]
    return [
        *(
            point("first break", code, *row, one.first / answers[0] - 1.0, [f.seconds_first for f in found],
                  answer=answers[0], **about)
            for row in rows
        ),
        point("damage", code, driver, setting, unit, one.damage / answers[1] - 1.0,
              [f.seconds_damage for f in found], answer=answers[1], **about),
    ]  # fmt: skip
