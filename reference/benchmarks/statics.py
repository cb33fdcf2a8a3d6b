"""Equilibrium under gravity: find_equilibrium against damped motion in real time, on the same bonded discs.

The other way is the usual one: Cundall's local damping of 0.8 at the time step of PFC and YADE, 0.8 of the least
sqrt(m/k) and sqrt(I/k) of all particles, k the sum of the stiffnesses of a particle's contacts (PFC's manual,
"Mechanical time step"; YADE's GlobalStiffnessTimeStepper). Both start from the same state without load, and both end at
the same unbalanced ratio.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.close_pairs import close_pairs
from geodem.builders.packings import lattice
from geodem.builders.random_packing import random_packing
from geodem.particle_network import current_links
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .checks import Results, check

NAME = "statics"
Floats = NDArray[np.float64]

TOLERANCE = 1e-5
"""Unbalanced ratio at which both end."""
LOOK = 50
"""Steps between looks at the balance of the damped motion."""
DAMPING = 0.8
SAFETY = 0.8
STEPS, SECONDS, DISPLACEMENT = 8.0, 10.0, 1e-4
"""Held to: times fewer steps, times less time, difference of the displacements over the largest one."""
CLOSE_BY = 1e-8
"""Unbalanced ratio of the state that displacements are compared with."""
BORNE = 0.8
"""Strength of the bonds that may break: the most loaded one bears this share of it at rest."""
MOST_STEPS = 400_000

NORMAL, SHEAR, WIDTH, DENSITY = 1e8, 5e7, 0.5, 2500.0
NO_LIMIT = 1e15  # [N]


def random_discs(count: int, size_ratio: float, *, strength: float = NO_LIMIT) -> Assembly:
    """Discs thrown into a square, radii up to 1 m, bonded to what is near, the lowest held."""
    packing = random_packing(2, radius=1.0, size_ratio=size_ratio, count=count, periodic=False, seed=1)
    return _bonded(packing.positions, packing.radii, 1.2, strength)


def lattice_discs(count: int, *, strength: float = NO_LIMIT) -> Assembly:
    """Equal discs of 1 m, hexagonal, a little wider than high, the lowest held."""
    across = round(math.sqrt(1.3 * count))
    packing = lattice("hexagonal", 1.0, box=(2.0 * across, math.sqrt(3.0) * count / across + 0.3))
    return _bonded(packing.positions, packing.radii, 1.01, strength)


def _bonded(positions: Floats, radii: Floats, factor: float, strength: float) -> Assembly:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs, _ = close_pairs(positions, radii, lambda a, b: factor * (a + b))
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(radii),) * 2)
    part = connected_components(graph, directed=False)[1]
    # what hangs on nothing would fall
    kept = part == part[np.argmin(positions[:, 1])]
    positions, radii = positions[kept], radii[kept]
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -9.81))
    contact = {"normal_stiffness": NORMAL, "shear_stiffness": SHEAR, "friction_coefficient": 0.5}
    bond = {**contact, "tensile_strength": strength, "cohesion": strength, "width_ratio": WIDTH}
    builder.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    builder.add_particles(positions, radii, "rock")
    builder.bond_within(factor)
    builder.hold(positions[:, 1] < 1.5 * radii.max(), x=0.0, y=0.0, rotation=0.0)
    return builder.build()


def usual_step(assembly: Assembly) -> float:
    """0.8 of the least sqrt(m/k) and sqrt(I/k) of the free particles [s]."""
    links = current_links(simulation := ParticleSimulation(assembly))
    n, d = assembly.particles, assembly.dimension
    stiffness = np.zeros((n, d + 1))
    for particle, arm in ((links.first, links.arms[:, 0]), (links.second, links.arms[:, 1])):
        there = particle >= 0
        across = links.ks[there, None] * (1.0 - links.normal[there] ** 2)
        along = links.kn[there, None] * links.normal[there] ** 2
        turning = links.ks[there] * arm[there] ** 2 + links.k_bend[there]
        for axis in range(d):
            stiffness[:, axis] += np.bincount(particle[there], (along + across)[:, axis], n)
        stiffness[:, d] += np.bincount(particle[there], turning, n)
    ids = simulation.arrays.ids
    inertia = np.column_stack([assembly.mass[ids]] * d + [assembly.inertia[ids]])
    acting = (stiffness > 0.0) & ~assembly.held[ids]
    return SAFETY * math.sqrt(float((inertia[acting] / stiffness[acting]).min()))


class Rest(NamedTuple):
    """A state at rest and the way there."""

    steps: int
    seconds: float
    reached: bool
    displacements: Floats
    broken: int


def by_damping(
    assembly: Assembly, step: float, tolerance: float = TOLERANCE, most_steps: int = MOST_STEPS
) -> Rest:
    """Damped motion until balanced; building and compiling do not count."""
    simulation = ParticleSimulation(assembly, time_step=step, local_damping=DAMPING, orientation=False)
    simulation.kernel(simulation.features)
    start = time.perf_counter()
    reached = False
    while not reached and simulation.steps < most_steps:
        simulation.run(LOOK)
        reached = simulation.unbalanced_ratio() < tolerance
    seconds = time.perf_counter() - start
    return _rest(simulation, simulation.steps, seconds, reached)


def by_search(assembly: Assembly, tolerance: float = TOLERANCE, *, solve: bool = True) -> Rest:
    """find_equilibrium; building and compiling do not count."""
    simulation = ParticleSimulation(assembly, orientation=False)
    simulation.kernel(simulation.features.relaxing())
    found = find_equilibrium(simulation, tolerance=tolerance, solve=solve)
    # all steps of the kernel: those that go where a solve leads as well
    return _rest(simulation, simulation.steps, found.seconds, found.reached)


def _rest(simulation: ParticleSimulation, steps: int, seconds: float, reached: bool) -> Rest:
    moved = simulation.positions - simulation.assembly.positions
    return Rest(steps, seconds, reached, moved, int((~simulation.intact()).sum()))


def breakable(assembly: Assembly) -> float:
    """Strength [N] at which the most loaded bond bears `BORNE` of it at rest."""
    simulation = ParticleSimulation(assembly, orientation=False)
    find_equilibrium(simulation, tolerance=TOLERANCE)
    return NO_LIMIT * float(simulation.utilisation.max()) / BORNE


@dataclass(frozen=True)
class Case:
    """A scene, its size in the whole benchmark, and whether its bonds are let break as well."""

    title: str
    size_ratio: float | None
    count: int
    breaks: bool

    def build(self, count: int, strength: float = NO_LIMIT) -> Assembly:
        """The scene with about so many discs."""
        if self.size_ratio is None:
            return lattice_discs(count, strength=strength)
        return random_discs(count, self.size_ratio, strength=strength)


CASES = {
    "narrow": Case("radii 0.6 to 1", 1.0 / 0.6, 7231, True),
    "wide": Case("radii 0.1 to 1", 10.0, 7231, False),
    "lattice": Case("equal discs", None, 10_000, True),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench statics``."""
    parser.add_argument("--cases", nargs="*", default=list(CASES), choices=list(CASES))
    parser.add_argument("--count", type=int, default=None, help="discs; those of the case if left out")
    parser.add_argument("--rounds", type=int, default=3, help="measurements of find_equilibrium")


def main(arguments: argparse.Namespace) -> int:
    """Measure what is asked, print a line a row, store the rows."""
    results = Results(NAME)
    for name in arguments.cases:
        measure(CASES[name], arguments.count or CASES[name].count, arguments.rounds, results)
    return 0


def measure(case: Case, count: int, rounds: int, results: Results) -> None:
    """Rows of one case."""
    assembly = case.build(count)
    step = usual_step(assembly)
    by_search(assembly)
    by_damping(assembly, step, most_steps=LOOK)
    ours = [by_search(assembly) for _ in range(rounds)]
    relaxed = by_search(assembly, solve=False)
    theirs = by_damping(assembly, step)
    close = by_search(assembly, CLOSE_BY)
    details: dict[str, Any] = {
        "case": case.title,
        "particles": assembly.particles,
        "bonds": len(assembly.bonds),
        "tolerance": TOLERANCE,
        "steps_ours": ours[0].steps,
        "steps_relaxed": relaxed.steps,
        "steps_theirs": theirs.steps,
        "seconds_ours": [rest.seconds for rest in ours],
        "seconds_theirs": theirs.seconds,
        "seconds_relaxed": relaxed.seconds,
        "reached": [rest.reached for rest in (*ours, relaxed, theirs, close)],
    }
    about = f"{case.title}, {assembly.particles} discs"
    results.add(
        check(f"steps of damped motion over those of find_equilibrium, {about}",
              [theirs.steps / ours[0].steps], least=STEPS, **details)
    )  # fmt: skip
    results.add(
        check(f"steps of damped motion over those of relaxation without a solve, {about}",
              [theirs.steps / relaxed.steps], **details)
    )  # fmt: skip
    results.add(
        check(f"time of damped motion over that of find_equilibrium, {about}",
              [theirs.seconds / rest.seconds for rest in ours], least=SECONDS, **details)
    )  # fmt: skip
    for whose, rest in (("find_equilibrium", ours[0]), ("damped motion", theirs)):
        largest = float(np.sqrt((close.displacements**2).sum(1)).max())
        off = float(np.sqrt(((rest.displacements - close.displacements) ** 2).sum(1)).max()) / largest
        most = DISPLACEMENT if whose == "find_equilibrium" else None
        results.add(
            check(f"error of a displacement over the largest one, {whose}, {about}", [off], most=most, **details)
        )  # fmt: skip
    if case.breaks:
        measure_breaks(case, count, breakable(assembly), about, results)


def measure_breaks(case: Case, count: int, strength: float, about: str, results: Results) -> None:
    """Bonds broken on the way to a state that breaks none."""
    assembly = case.build(count, strength)
    ours = by_search(assembly)
    # a shower of breaks may never come to rest: what has broken until the usual number of steps is enough
    theirs = by_damping(assembly, usual_step(assembly), most_steps=4000)
    for whose, rest, most in (("find_equilibrium", ours, 0.0), ("damped motion", theirs, None)):
        results.add(
            check(f"bonds broken though none is overstressed at rest, {whose}, {about}", [float(rest.broken)],
                  most=most, case=case.title, particles=assembly.particles, bonds=len(assembly.bonds),
                  strength=strength)
        )  # fmt: skip
