"""A cantilever of bonded spheres, at rest under a load and swinging, for geodem and YADE; LIGGGHTS has no bonds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from ..posed import Posed
from ..results_file import Row
from .frontier_codes_runs import (
    CONVENTIONS,
    GEODEM,
    LIGGGHTS,
    Floats,
    doubling,
    ending,
    from_then_on,
    in_turn,
    point,
)

RADIUS = 0.5  # [m]
DENSITY = 2000.0  # [kg/m3]
MASS = 4.0 / 3.0 * math.pi * DENSITY * RADIUS**3
NORMAL, SHEAR = 1e8, 5e7  # [N/m]
BENDING = 1.0
"""Moment a radian over the square of the radius and the shear stiffness."""
CONTACT = {"young_modulus": NORMAL / RADIUS, "stiffness_ratio": SHEAR / NORMAL, "friction_coefficient": 0.5}
BOND = {
    **CONTACT, "normal_cohesion": 1e15, "shear_cohesion": 1e15, "bending_factor": BENDING, "twisting_factor": BENDING,
}  # fmt: skip

BENT = 1e-3
"""Deflection at rest over the length: the answer is linear to its square."""
SWING = 1e-6
"""Speed of the end in units of the length of a bond and the frequency."""
SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9)
REST_SHARE = 0.9
"""Time step of the damped motion over the critical one."""
DAMPINGS = (0.2, 0.4, 0.8)
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
FRAMES = 64
"""Frames of a period of the swing."""


class Chain(NamedTuple):
    """Stiffness (2 n, 2 n) of the free spheres, deflection and rotation in turn, and inertia (2 n,)."""

    stiffness: Floats
    inertia: Floats


def chain(free: int) -> Chain:
    """A held sphere and so many free ones beside it in a row.

    A bond's slip is the difference of the deflections less the radius times the sum of the rotations, its bend the
    difference of the rotations.
    """
    bend = BENDING * RADIUS**2 * SHEAR
    whole = np.zeros((2 * free + 2, 2 * free + 2))
    for bond in range(free):
        slip, turn = np.zeros(2 * free + 2), np.zeros(2 * free + 2)
        slip[2 * bond : 2 * bond + 4] = [-1.0, -RADIUS, 1.0, -RADIUS]
        turn[[2 * bond + 1, 2 * bond + 3]] = [-1.0, 1.0]
        whole += SHEAR * np.outer(slip, slip) + bend * np.outer(turn, turn)
    return Chain(whole[2:, 2:], np.tile([MASS, 0.4 * MASS * RADIUS**2], free))


def cantilever(free: int, *, force: float = 0.0, speeds: Floats | None = None) -> Assembly:
    """The same as spheres; a load at the end [N], or the speeds (2 n,) at the start [m/s, rad/s]."""
    b = AssemblyBuilder(3, "elastic_frictional", "cohesive_moments")
    b.add_material("rock", density=DENSITY, contact=CONTACT, bond=BOND)
    positions = np.zeros((free + 1, 3))
    positions[:, 0] = 2.0 * RADIUS * np.arange(free + 1)
    velocity, spin = np.zeros((free + 1, 3)), np.zeros((free + 1, 3))
    if speeds is not None:
        velocity[1:, 1], spin[1:, 2] = speeds[::2], speeds[1::2]
    b.add_particles(positions, RADIUS, "rock", velocity=velocity, spin=spin)
    b.bond(np.stack([np.arange(free), np.arange(1, free + 1)], axis=1))
    b.hold([0], x=0.0, y=0.0, z=0.0, rotation=0.0)
    if force:
        b.apply([free], force=(0.0, force, 0.0))
    return b.build()


def critical(assembly: Assembly, damping: float = 0.0) -> float:
    """Critical time step [s] as geodem measures it, with local damping."""
    return ParticleSimulation(assembly, local_damping=damping, orientation=False).critical_time_step


# --- at rest ------------------------------------------------------------------------------------------------


def loaded(free: int) -> tuple[Assembly, float]:
    """The cantilever under the load that bends it by `BENT`, and the deflection of its end [m] in closed form."""
    load = np.zeros(2 * free)
    load[-2] = 1.0
    unit = float(np.linalg.solve(chain(free).stiffness, load)[-2])
    deflection = BENT * 2.0 * RADIUS * free
    return cantilever(free, force=deflection / unit), deflection


def coming_to_rest(code: str, free: int, damping: float, steps: int, every: int) -> Posed:
    """Damped motion under the load."""
    assembly, _ = loaded(free)
    step = REST_SHARE * critical(assembly, damping)
    posed = Posed("cantilever", assembly, step, 1, CONVENTIONS[code], local_damping=damping)
    return ending(posed, step, steps, every)


def rest_rows(codes: Sequence[str], free: int, longest: int, rounds: int) -> list[Row]:
    """Damped motion of both codes with more and more steps, and geodem's two ways to equilibrium."""
    every = max(longest // 256, 1)
    _, deflection = loaded(free)
    rows = []
    for damping in DAMPINGS:
        # half as long again, so that the last points are seen to stay
        scenes = {
            code: [coming_to_rest(code, free, damping, longest * 3 // 2, every)] for code in bonded(codes)
        }
        timed = in_turn(
            {code: [ending(one, one.time_step, one.steps)] for code, (one,) in scenes.items()}, rounds
        )
        for code, ((run, _),) in in_turn(scenes, 1).items():
            ((_, seconds),) = timed[code]
            errors = from_then_on(np.abs(run.positions[:, -1, 1] / deflection - 1.0))
            steps = scenes[code][0].steps
            for reached in doubling(4 * every, longest):
                rows.append(
                    point("cantilever", code, f"local damping {damping:g}", reached, "steps",
                          float(errors[reached // every - 1]), [s * reached / steps for s in seconds],
                          version=run.version, law=run.law, particles=free + 1)
                )  # fmt: skip
    return rows + _statics_rows(free, rounds)


def bonded(codes: Sequence[str]) -> list[str]:
    """Those that have bonds."""
    return [code for code in codes if code != LIGGGHTS]


def _statics_rows(free: int, rounds: int) -> list[Row]:
    assembly, deflection = loaded(free)

    def found(driver: str, tolerance: float) -> tuple[float, float]:
        simulation = ParticleSimulation(assembly, orientation=False)
        simulation.kernel(simulation.features.relaxing())
        result = find_equilibrium(simulation, tolerance=tolerance, solve=driver == "solve first")
        return result.seconds, float(simulation.positions[-1, 1]) / deflection - 1.0

    rows = []
    for driver in ("relaxation", "solve first"):
        found(driver, TOLERANCES[0])
        for tolerance in TOLERANCES:
            runs = [found(driver, tolerance) for _ in range(rounds)]
            rows.append(
                point("cantilever", GEODEM, driver, tolerance, "unbalanced ratio", runs[0][1], [r[0] for r in runs],
                      particles=free + 1)
            )  # fmt: skip
    return rows


# --- swing --------------------------------------------------------------------------------------------------


def lowest_mode(one: Chain) -> tuple[float, Floats]:
    """Angular frequency [rad/s] and shape of the slowest swing."""
    root = 1.0 / np.sqrt(one.inertia)
    values, vectors = np.linalg.eigh(root[:, None] * one.stiffness * root)
    shape = root * vectors[:, 0]
    return math.sqrt(float(values[0])), shape / shape[-2]


def swinging(code: str, free: int, share: float, periods: int) -> Posed:
    """The cantilever, straight, with the speeds of its lowest mode."""
    rate, shape = lowest_mode(chain(free))
    assembly = cantilever(free, speeds=SWING * 2.0 * RADIUS * rate * shape)
    step = share * critical(assembly)
    every = max(1, round(2.0 * math.pi / rate / step / FRAMES))
    posed = Posed("swing", assembly, step, 1, CONVENTIONS[code])
    return ending(posed, step, every * FRAMES * periods, every)


def period_error(posed: Posed, positions: Floats, free: int) -> float:
    """Relative error of the period.

    In one mode y(t + T) + y(t - T) = 2 cos(w T) y(t) + constant, whatever the phase and the place about which it
    swings (in YADE the way of the step before the start is part of the slip); T is about a quarter of the period.
    """
    rate, _ = lowest_mode(chain(free))
    y = positions[:, -1, 1]
    lag = FRAMES // 4
    middle, around = y[lag:-lag], y[2 * lag :] + y[: -2 * lag]
    middle = middle - middle.mean()
    cosine = 0.5 * float(middle @ around) / float(middle @ middle)
    found = math.acos(cosine) / (lag * posed.every * posed.time_step)
    return rate / found - 1.0


def swing_rows(codes: Sequence[str], free: int, periods: int, rounds: int) -> list[Row]:
    """Period against time step."""
    scenes = {code: [swinging(code, free, share, periods) for share in SHARES] for code in bonded(codes)}
    seen = in_turn(scenes, 1)
    # timed without frames: to stop and read takes as long as many steps of a few spheres
    timed = in_turn(
        {code: [ending(one, one.time_step, one.steps) for one in posed] for code, posed in scenes.items()}, rounds
    )  # fmt: skip
    rows: list[Any] = []
    for code, found in seen.items():
        for share, posed, (run, _), (_, seconds) in zip(
            SHARES, scenes[code], found, timed[code], strict=True
        ):
            rows.append(
                point("swing", code, "motion", share, "of the critical step",
                      period_error(posed, run.positions, free), seconds, version=run.version, law=run.law,
                      particles=free + 1, steps=posed.steps)
            )  # fmt: skip
    return rows
