"""Run time against error: what a shorter step, or another way to rest, buys.

Three problems with an answer in closed form. Collisions of two discs with a linear spring: each pair parts at the
speed at which it met, after half a period, wherever in a step the two meet. The swing of a cantilever of bonded
discs, started in its lowest mode. The same cantilever at rest under a load at its end. The cantilever is a chain whose
bonds resist slip and bending: its stiffness is written down here once more, as a small matrix.
"""

from __future__ import annotations

import argparse
import math
import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem._jit import set_threads, threads_allowed
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import balance, find_equilibrium

from ..results_file import Row
from .checks import Results, check

NAME = "frontier"
Floats = NDArray[np.float64]

SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9)
"""Time steps over the critical one."""
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Unbalanced ratios at which a search for rest ends."""
USUAL_SHARE = 0.5
"""The time step where none is given."""
COLLISION, SWING, REST = 0.1, 1e-4, 1e-4
"""Held to: errors of the parting discs and the period at the usual step, of the deflection at the usual tolerance."""

BENT = 1e-3
"""Deflection of the cantilever at rest over its length."""

RADIUS = 0.5
NORMAL, SHEAR, WIDTH = 1e8, 5e7, 1.0
DENSITY = 2000.0
MASS = DENSITY * math.pi * RADIUS**2


# --- collisions ---------------------------------------------------------------------------------------------


def collisions(share: float, pairs: int) -> tuple[float, float, float]:
    """Seconds and error of pairs that collide: root mean square over the way in half a period, and largest speed error.

    The distance of every pair is compared when all have parted.
    """
    speed = 0.01
    rate = math.sqrt(2.0 * NORMAL / MASS)
    gaps = np.random.default_rng(1).uniform(0.05, 1.0, pairs) * speed * math.pi / rate
    x = np.stack([np.zeros(pairs), 2.0 * RADIUS + gaps], axis=1).ravel()
    positions = np.stack([x, np.repeat(4.0 * RADIUS * np.arange(pairs), 2)], axis=1)
    builder = AssemblyBuilder(2)
    contact = {"normal_stiffness": NORMAL, "shear_stiffness": SHEAR, "friction_coefficient": 0.0}
    builder.add_material("rock", density=DENSITY, contact=contact)
    velocity = np.tile([[0.5 * speed, 0.0], [-0.5 * speed, 0.0]], (pairs, 1))
    builder.add_particles(positions, RADIUS, "rock", velocity=velocity)
    step = share * 2.0 / rate
    simulation = ParticleSimulation(builder.build(), time_step=step, orientation=False)
    steps = math.ceil(3.0 * math.pi / rate / step)
    simulation.kernel(simulation.features)
    start = time.perf_counter()
    simulation.run(steps)
    seconds = time.perf_counter() - start
    distance = np.diff(simulation.positions[:, 0].reshape(-1, 2), axis=1)[:, 0]
    # they meet after gap/speed and stay together for pi/rate, at the end of which they are as far as they began
    expected = 2.0 * RADIUS + speed * (steps * step - gaps / speed - math.pi / rate)
    off = (distance - expected) / (speed * math.pi / rate)
    away = np.diff(simulation.velocities[:, 0].reshape(-1, 2), axis=1)[:, 0]
    return seconds, float(np.sqrt((off**2).mean())), float(np.abs(away / speed - 1.0).max())


# --- cantilever ---------------------------------------------------------------------------------------------


class Chain(NamedTuple):
    """Stiffness (2 n, 2 n) of the free discs of a cantilever, deflection and rotation in turn, and inertia (2 n,)."""

    stiffness: Floats
    inertia: Floats


def chain(free: int) -> Chain:
    """A held disc and so many free ones beside it in a row.

    A bond's slip is the difference of the deflections less the radius times the sum of the rotations, its bend the
    difference of the rotations; kb = kn width^2/4.
    """
    bend = 0.25 * NORMAL * (2.0 * WIDTH * RADIUS) ** 2
    whole = np.zeros((2 * free + 2, 2 * free + 2))
    for bond in range(free):
        slip, turn = np.zeros(2 * free + 2), np.zeros(2 * free + 2)
        slip[2 * bond : 2 * bond + 4] = [-1.0, -RADIUS, 1.0, -RADIUS]
        turn[[2 * bond + 1, 2 * bond + 3]] = [-1.0, 1.0]
        whole += SHEAR * np.outer(slip, slip) + bend * np.outer(turn, turn)
    return Chain(whole[2:, 2:], np.tile([MASS, 0.5 * MASS * RADIUS**2], free))


def cantilever(free: int, *, force: float = 0.0, speeds: Floats | None = None) -> AssemblyBuilder:
    """The same in geodem; a load at the end [N], or the speeds (2 n,) of the free discs at the start [m/s, rad/s]."""
    builder = AssemblyBuilder(2, bond_law="two_springs")
    contact = {"normal_stiffness": NORMAL, "shear_stiffness": SHEAR, "friction_coefficient": 0.5}
    bond = {**contact, "tensile_strength": 1e15, "cohesion": 1e15, "width_ratio": WIDTH}
    builder.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    x = 2.0 * RADIUS * np.arange(free + 1)
    velocity, spin = np.zeros((free + 1, 2)), np.zeros(free + 1)
    if speeds is not None:
        velocity[1:, 1], spin[1:] = speeds[::2], speeds[1::2]
    builder.add_particles(np.stack([x, 0.0 * x], axis=1), RADIUS, "rock", velocity=velocity, spin=spin)
    builder.bond_within(1.001)
    builder.hold([0], x=0.0, y=0.0, rotation=0.0)
    if force:
        builder.apply([free], force=(0.0, force))
    return builder


def lowest_mode(one: Chain) -> tuple[float, Floats]:
    """Angular frequency [rad/s] and shape of the slowest swing."""
    root = 1.0 / np.sqrt(one.inertia)
    values, vectors = np.linalg.eigh(root[:, None] * one.stiffness * root)
    shape = root * vectors[:, 0]
    # the end goes upwards
    return math.sqrt(float(values[0])), shape / shape[-2]


def swing(share: float, free: int, periods: int) -> tuple[float, float]:
    """Seconds, and relative error of the period, of a cantilever that starts straight with the speeds of its mode."""
    rate, shape = lowest_mode(chain(free))
    # small enough to be linear, large enough against rounding
    assembly = cantilever(free, speeds=1e-6 * rate * shape).build()
    critical = ParticleSimulation(assembly, orientation=False).critical_time_step
    simulation = ParticleSimulation(assembly, time_step=share * critical, orientation=False)
    simulation.kernel(simulation.features)
    step = simulation.time_step
    # to just before the end passes its place after so many periods, upwards as at the start
    steps = int(2.0 * math.pi * periods / rate / step) - 3
    start = time.perf_counter()
    simulation.run(steps)
    seconds = time.perf_counter() - start
    for _ in range(10 + int(0.25 * 2.0 * math.pi / rate / step)):
        before = simulation.positions[-1, 1]
        simulation.run(1)
        if before < 0.0 <= simulation.positions[-1, 1]:
            break
    after = simulation.positions[-1, 1]
    passed = (simulation.steps - after / (after - before)) * step
    return seconds, passed * rate / (2.0 * math.pi * periods) - 1.0


def rest(driver: str, tolerance: float, free: int) -> tuple[float, float]:
    """Seconds, and relative error of the deflection of the end, of a cantilever under a load at its end."""
    one = chain(free)
    load = np.zeros(2 * free)
    load[-2] = 1.0
    unit = float(np.linalg.solve(one.stiffness, load)[-2])
    # small against the length, so that the answer is linear to 1e-6, and large against rounding
    force = BENT * 2.0 * RADIUS * free / unit
    assembly = cantilever(free, force=force).build()
    if driver == DAMPED:
        simulation = ParticleSimulation(assembly, local_damping=0.8, orientation=False)
        simulation = ParticleSimulation(
            assembly, time_step=0.9 * simulation.critical_time_step, local_damping=0.8, orientation=False
        )
        simulation.kernel(simulation.features)
        start = time.perf_counter()
        while simulation.steps < MOST_STEPS:
            simulation.run(100)
            if balance(simulation) < tolerance:
                break
        seconds = time.perf_counter() - start
    else:
        simulation = ParticleSimulation(assembly, orientation=False)
        simulation.kernel(simulation.features.relaxing())
        seconds = find_equilibrium(simulation, tolerance=tolerance, solve=driver == SOLVED).seconds
    return seconds, float(simulation.positions[-1, 1]) / (force * unit) - 1.0


DAMPED, RELAXED, SOLVED = "damped motion", "relaxation", "solve first"
MOST_STEPS = 2_000_000


# --- rows ---------------------------------------------------------------------------------------------------


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench frontier``."""
    parser.add_argument("--pairs", type=int, default=2000, help="collisions at once")
    parser.add_argument("--free", type=int, default=8, help="discs of the cantilever that swings")
    parser.add_argument("--long", type=int, default=40, help="discs of the cantilever that comes to rest")
    parser.add_argument("--periods", type=int, default=5)
    parser.add_argument("--rounds", type=int, default=7, help="measurements of the run time")


def main(arguments: argparse.Namespace) -> int:
    """Measure, print a line a row, store the rows."""
    before = threads_allowed()
    # scenes of milliseconds: to find out whether a second thread pays would take longer
    set_threads(1)
    try:
        _measure(arguments)
    finally:
        set_threads(before)
    return 0


def _measure(arguments: argparse.Namespace) -> None:
    results = Results(NAME)
    rounds = arguments.rounds
    collisions(SHARES[-1], arguments.pairs)
    swing(SHARES[-1], arguments.free, 1)
    for share in SHARES:
        found = [collisions(share, arguments.pairs) for _ in range(rounds)]
        about = f"{arguments.pairs} collisions"
        results.add(
            _row("collision", "motion", share, "way of parted discs", about, [f[:2] for f in found],
                 COLLISION, speed_error=found[0][2])
        )  # fmt: skip
    for share in SHARES:
        measured = [swing(share, arguments.free, arguments.periods) for _ in range(rounds)]
        about = f"cantilever of {arguments.free} discs"
        results.add(_row("swing", "motion", share, "period", about, measured, SWING))
    for driver in (DAMPED, RELAXED, SOLVED):
        rest(driver, TOLERANCES[0], arguments.long)
        for tolerance in TOLERANCES:
            measured = [rest(driver, tolerance, arguments.long) for _ in range(rounds)]
            about = f"cantilever of {arguments.long} discs"
            results.add(_row("rest", driver, tolerance, "deflection", about, measured, REST))


def _row(
    problem: str,
    driver: str,
    setting: float,
    what: str,
    about: str,
    measured: list[tuple[float, float]],
    most: float,
    **details: Any,
) -> Row:
    at = f"unbalanced ratio {setting:g}" if problem == "rest" else f"{setting:g} of the critical step"
    held = setting == (1e-5 if problem == "rest" else USUAL_SHARE) and driver in ("motion", SOLVED)
    return check(
        f"error of the {what}, {about}, {driver}, {at}",
        [abs(error) for _, error in measured],
        most=most if held else None,
        problem=problem,
        driver=driver,
        setting=setting,
        seconds=[seconds for seconds, _ in measured],
        **details,
    )
