"""Collisions and a settling pack, for geodem, YADE and LIGGGHTS."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from geodem.assembly import Assembly
from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from ..posed import Posed, Trajectory
from ..results_file import Row
from ..scene_packings import Packing, random_spheres, touching_pairs
from .frontier_codes_runs import (
    CONVENTIONS,
    GEODEM,
    LIGGGHTS,
    YADE,
    Floats,
    doubling,
    ending,
    from_then_on,
    in_turn,
    point,
)

RADIUS = 5e-3  # [m]
DENSITY = 2600.0  # [kg/m3]
MASS = 4.0 / 3.0 * math.pi * DENSITY * RADIUS**3
STIFFNESS = 1e4  # [N/m], of two equal spheres
SHEAR_SHARE = 0.2
RATE = math.sqrt(2.0 * STIFFNESS / MASS)
SPEED = 1e-3 * RADIUS * RATE
"""Relative speed at which spheres meet [m/s]: they overlap by a thousandth of their radius."""

SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9)
"""Time steps over the critical one."""
FINEST = 0.002
"""That of the answers where there is no closed form."""


def contact(code: str, friction: float, damping: float = 0.0) -> tuple[str, dict[str, float]]:
    """Contact law and its numbers, the same stiffness for equal spheres in all codes; `damping` [1/s] in LIGGGHTS."""
    if code == LIGGGHTS:
        return "hooke_stiffness", {
            "normal_stiffness": STIFFNESS, "shear_stiffness": SHEAR_SHARE * STIFFNESS, "friction_coefficient": friction,
            "normal_damping": damping, "shear_damping": SHEAR_SHARE * damping,
        }  # fmt: skip
    return "elastic_frictional", {
        "young_modulus": STIFFNESS / RADIUS,
        "stiffness_ratio": SHEAR_SHARE,
        "friction_coefficient": friction,
    }


# --- collisions ---------------------------------------------------------------------------------------------


def gaps(pairs: int) -> Floats:
    """Distances of surfaces at the start [m]: at random, so that they meet anywhere in a step."""
    return np.random.default_rng(1).uniform(0.05, 1.0, pairs) * SPEED * math.pi / RATE


def colliding(code: str, pairs: int, *, oblique: bool) -> Assembly:
    """Pairs that meet, all far from each other; `oblique`: askew, with friction and spins."""
    law, numbers = contact(code, 0.3 if oblique else 0.0)
    b = AssemblyBuilder(3, law)
    b.add_material("glass", density=DENSITY, contact=numbers)
    row, column = np.divmod(np.arange(pairs), math.ceil(math.sqrt(pairs)))
    positions = np.zeros((pairs, 2, 3))
    positions[:, :, 1] = 4.0 * RADIUS * row[:, None]
    positions[:, :, 2] = 4.0 * RADIUS * column[:, None]
    positions[:, 1, 0] = 2.0 * RADIUS + gaps(pairs)
    velocity = np.zeros((pairs, 2, 3))
    velocity[:, :, 0] = [0.5 * SPEED, -0.5 * SPEED]
    spin = np.zeros((pairs, 2, 3))
    if oblique:
        random = np.random.default_rng(2)
        velocity[:, :, 1:] = random.uniform(-0.5, 0.5, (pairs, 2, 2)) * SPEED
        spin[:] = random.uniform(-0.5, 0.5, (pairs, 2, 3)) * SPEED / RADIUS
    b.add_particles(
        positions.reshape(-1, 3), RADIUS, "glass", velocity=velocity.reshape(-1, 3), spin=spin.reshape(-1, 3)
    )
    return b.build()


def collisions(code: str, pairs: int, shares: Iterable[float], *, oblique: bool) -> list[Posed]:
    """The same collisions with several time steps, until all have parted."""
    found = []
    assembly = colliding(code, pairs, oblique=oblique)
    for share in shares:
        step = share * 2.0 / RATE
        posed = Posed("collisions", assembly, step, 1, CONVENTIONS[code])
        found.append(ending(posed, step, math.ceil(3.0 * math.pi / RATE / step)))
    return found


def parting_error(posed: Posed, run: Trajectory) -> float:
    """Root mean square error of the distances at the end over the way in half a period: they part as they met."""
    x = run.positions[-1, :, 0].reshape(-1, 2)
    own = gaps(len(x))
    # they meet after gap/speed and stay together for pi/rate, at the end of which they are as far as they began
    expected = 2.0 * RADIUS + SPEED * (posed.steps * posed.time_step - own / SPEED - math.pi / RATE)
    off = (x[:, 1] - x[:, 0] - expected) / (SPEED * math.pi / RATE)
    return float(np.sqrt((off**2).mean()))


def speed_error(run: Trajectory, answer: Trajectory) -> float:
    """Root mean square error of the velocities and rim speeds at the end over the speed at which they met."""
    off = np.hstack([run.velocities[-1] - answer.velocities[-1], RADIUS * (run.spins[-1] - answer.spins[-1])])
    return float(np.sqrt((off**2).sum(axis=1).mean())) / SPEED


def collision_rows(codes: Sequence[str], pairs: int, rounds: int) -> list[Row]:
    """Head-on against the closed form, and oblique against each code's own answer at a tenth of the finest step."""
    rows = []
    unit = "of the critical step"
    for problem, oblique in (("collision", False), ("oblique", True)):
        scenes = {code: collisions(code, pairs, SHARES, oblique=oblique) for code in codes}
        for code, found in in_turn(scenes, rounds).items():
            if oblique:
                finest = collisions(code, pairs, [FINEST], oblique=True)
                answer = in_turn({code: finest}, 1)[code][0].run
            for share, posed, (run, seconds) in zip(SHARES, scenes[code], found, strict=True):
                error = speed_error(run, answer) if oblique else parting_error(posed, run)
                rows.append(
                    point(problem, code, "motion", share, unit, error, seconds, version=run.version, law=run.law,
                          particles=2 * pairs, steps=posed.steps)
                )  # fmt: skip
    return rows


# --- pack ---------------------------------------------------------------------------------------------------

DAMPINGS = {"contact damping": 0.0, "local damping 0.3": 0.3, "local damping 0.7": 0.7}
CONTACT_DAMPING = 0.3
"""Share of critical damping, in LIGGGHTS's contacts."""
PACK_STEP = 0.25 * math.sqrt(0.8**3 * MASS / STIFFNESS)
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
TIGHT = 1e-8
"""Unbalanced ratio of the answer."""
MOST_STEPS = 200_000
LONGER = 10
"""Steps of the run whose end is the answer, over those that are timed."""


def pack(code: str, spheres: int) -> Assembly:
    """Spheres at random, not quite touching, in a box that is open above; in LIGGGHTS's contacts there are dashpots."""
    law, numbers = contact(code, 0.5, CONTACT_DAMPING * 2.0 * math.sqrt(2.0 * STIFFNESS / MASS))
    b = AssemblyBuilder(3, law, gravity=(0.0, 0.0, -9.81))
    b.add_material("glass", density=DENSITY, contact=numbers)
    packing = random_spheres(spheres)
    opened = RADIUS * _until_free(packing)
    b.add_particles(opened * packing.positions, RADIUS * packing.radii, "glass")
    low, high = opened * packing.box
    b.add_wall(plane("floor", low, (0, 0, 1)))
    for axis, name in enumerate("xy"):
        inwards = np.eye(3)[axis]
        b.add_wall(plane(f"{name} low", low, inwards))
        b.add_wall(plane(f"{name} high", high, -inwards))
    return b.build()


def _until_free(packing: Packing) -> float:
    """Factor on the distances of a pressed packing by which nothing touches any more."""
    first, second = touching_pairs(packing.positions, packing.radii).T
    apart = np.linalg.norm(packing.positions[first] - packing.positions[second], axis=1)
    inwards = np.minimum(packing.positions, packing.box[1] - packing.positions).min(axis=1)
    most = ((packing.radii[first] + packing.radii[second]) / apart).max(initial=1.0)
    return 1.0001 * max(float(most), float((packing.radii / inwards).max()))


def settling(code: str, spheres: int, damping: float, steps: int, every: int = 0) -> Posed:
    """The pack in motion, with local damping, or where that is 0 with the contacts of LIGGGHTS, which are damped."""
    assembly = pack(code if damping > 0.0 else LIGGGHTS, spheres)
    posed = Posed("pack", assembly, PACK_STEP, steps, CONVENTIONS[code], local_damping=damping)
    return ending(posed, PACK_STEP, steps, every)


def place_errors(positions: Floats, start: Floats, answer: Floats) -> Floats:
    """(f,) root mean square distance from the answer over that from the start to it."""
    way = math.sqrt(float(((answer - start) ** 2).sum()))
    return np.asarray(np.sqrt(((positions - answer) ** 2).sum(axis=(-2, -1))) / way)


def weight_errors(assembly: Assembly, upwards: Floats) -> Floats:
    """Errors of the upward force of all walls against the weight."""
    weight = 9.81 * float(assembly.mass.sum())
    return np.asarray(np.abs(upwards / weight - 1.0))


def pack_rows(codes: Sequence[str], spheres: int, steps: int, rounds: int) -> list[Row]:
    """Damped motion of all codes with more and more steps, and geodem's search for equilibrium.

    Timed are the first `steps` steps; the time of more is taken to be in proportion.
    """
    every = max(steps // 32, 1)
    rows = []
    for driver, damping in DAMPINGS.items():
        # YADE has no dashpots in these contacts, LIGGGHTS no local damping
        lacks = LIGGGHTS if damping > 0.0 else YADE
        those = [code for code in codes if code != lacks]
        timed = in_turn({code: [settling(code, spheres, damping, steps)] for code in those}, rounds)
        for code in those:
            posed = settling(code, spheres, damping, LONGER * steps, every)
            run = in_turn({code: [posed]}, 1)[code][0].run
            rows += _settled(posed, run, driver, [s / steps for s in timed[code][0].seconds])
    return rows + equilibrium_rows(pack(GEODEM, spheres), rounds)


def _settled(posed: Posed, run: Trajectory, driver: str, per_step: Sequence[float]) -> list[Row]:
    """Rows of one run, whose end is the answer; `per_step` are seconds of one step."""
    assert run.wall_forces is not None
    errors = from_then_on(place_errors(run.positions, posed.assembly.positions, run.positions[-1]))
    # the force on a wall is downwards where it carries
    weights = from_then_on(weight_errors(posed.assembly, -run.wall_forces.sum(axis=1)[:, 2]))
    return [
        point("pack", run.code, driver, steps, "steps", errors[steps // posed.every - 1],
              [s * steps for s in per_step], weight_error=float(weights[steps // posed.every - 1]),
              version=run.version, law=run.law, particles=posed.assembly.particles)
        for steps in doubling(posed.every, posed.steps // 2)
    ]  # fmt: skip


def equilibrium_rows(assembly: Assembly, rounds: int) -> list[Row]:
    """`find_equilibrium` on the pack, to several tolerances."""

    def found(tolerance: float) -> tuple[float, ParticleSimulation, bool]:
        simulation = ParticleSimulation(assembly, orientation=False)
        simulation.kernel(simulation.features.relaxing())
        result = find_equilibrium(simulation, tolerance=tolerance, most_steps=MOST_STEPS)
        return result.seconds, simulation, result.reached

    _, answer, good = found(TIGHT)
    rows = []
    for tolerance in TOLERANCES:
        runs = [found(tolerance) for _ in range(rounds)]
        simulation = runs[0][1]
        error = place_errors(simulation.positions[None], assembly.positions, answer.positions)[0]
        upwards = -sum(simulation.wall_force(wall.name)[2] for wall in assembly.walls)
        rows.append(
            point("pack", GEODEM, "find_equilibrium", tolerance, "unbalanced ratio", error, [r[0] for r in runs],
                  weight_error=float(weight_errors(assembly, upwards)), reached=bool(good and runs[0][2]),
                  particles=assembly.particles)
        )  # fmt: skip
    return rows
