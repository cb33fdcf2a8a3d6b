"""A million particles beside a hundred thousand: set-up, memory, speed of a particle and step, and whether it behaves.

Two scenes, 24 layers of spheres and 200 rows of discs whatever their number, so that a particle has as much to do in
the small scene as in the large one: spheres a little apart that fall upon each other in a box, with friction; bonded
discs on a triangular lattice that hang on what holds their lowest row. Every scene runs in a process of its own, and
the memory is that of the process.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import geodem.particle_simulation as engine
from geodem._jit import compile_seconds, set_threads
from geodem.assembly import Assembly
from geodem.boundaries import walls
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from ..results_file import Row
from .checks import Results, check

NAME = "large"

RADIUS = 5e-3
DENSITY = 2600.0
GRAVITY = 9.81
LAYERS = 24
ROWS = 200
GAP = 0.02
"""Between surfaces of spheres at the start, over the radius, of which they lie up to 0.4 off at random."""
JITTER = 0.03
"""Speed of the spheres at the start along each axis [m/s]: neighbours are searched every fifty steps or so."""
STIFFNESS = {"spheres": 5e4, "discs": 1e8}
# bonds bear twenty times what the weight above the lowest row asks for
STRENGTH = 20.0 * ROWS * DENSITY * math.pi * RADIUS**2 * GRAVITY
DAMPING = 0.3
WARM_UP = 30_000
"""Particles of a scene that is run before: large enough for the loops of large scenes only."""

SLOWER = 1.35
"""Time of a particle and step at a million, over that at a hundred thousand: held to at most."""
BYTES = 600.0
"""Of a sphere, with the six contacts of a dense packing."""
SETUP = 60.0
"""Seconds of a million, without compiling."""
DEEPEST = 0.05
"""Overlap of spheres over the radius that would show a scene that is not what it is meant to be."""
ORDER = 4.0
"""Rows at random over rows in the order of the curve."""
WEIGHT = 1e-3
"""Relative error of the force at the bottom in the discs' equilibrium."""


def falling_spheres(count: int) -> Assembly:
    """Spheres on a square lattice with gaps, each a little off its place, in a box with room above."""
    across = max(2, round(math.sqrt(count / LAYERS)))
    pitch = RADIUS * (2.0 + GAP)
    places = np.stack(np.meshgrid(np.arange(across), np.arange(across), np.arange(LAYERS), indexing="ij"), -1)
    positions = (places.reshape(-1, 3) + 0.5) * pitch
    positions += np.random.default_rng(1).uniform(-0.4, 0.4, positions.shape) * GAP * RADIUS
    builder = AssemblyBuilder(3, gravity=(0.0, 0.0, -GRAVITY))
    stiffness = STIFFNESS["spheres"]
    contact = {"normal_stiffness": stiffness, "shear_stiffness": 0.8 * stiffness, "friction_coefficient": 0.5}
    builder.add_material("grain", density=DENSITY, contact=contact)
    velocity = np.random.default_rng(2).normal(0.0, JITTER, positions.shape)
    builder.add_particles(positions, RADIUS, "grain", velocity=velocity)
    builder.add_wall(
        walls.box("box", (0.0, 0.0, 0.0), (across * pitch, across * pitch, (LAYERS + 2) * pitch))
    )
    return builder.build()


def packed_spheres(count: int) -> Assembly:
    """Spheres on a face-centred lattice that touch and are pressed by 0.1 %: twelve contacts each, six pairs."""
    cells = max(1, round((count / 4.0) ** (1.0 / 3.0)))
    packing = lattice("fcc", RADIUS, cells=(cells,) * 3, gap=-2e-3 * RADIUS)
    builder = AssemblyBuilder(3)
    stiffness = STIFFNESS["spheres"]
    contact = {"normal_stiffness": stiffness, "shear_stiffness": 0.8 * stiffness, "friction_coefficient": 0.5}
    builder.add_material("grain", density=DENSITY, contact=contact)
    builder.add_particles(packing.positions, RADIUS, "grain")
    return builder.build()


def bonded_discs(count: int) -> Assembly:
    """Discs on a triangular lattice, all neighbours bonded, the lowest row held."""
    across = max(2, round(count / ROWS))
    packing = lattice(
        "hexagonal", RADIUS, box=(2.0 * across * RADIUS, (math.sqrt(3.0) * ROWS + 0.3) * RADIUS)
    )
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -GRAVITY))
    stiffness = STIFFNESS["discs"]
    contact = {"normal_stiffness": stiffness, "shear_stiffness": 0.5 * stiffness, "friction_coefficient": 0.5}
    bond = {**contact, "tensile_strength": STRENGTH, "cohesion": STRENGTH, "width_ratio": 0.5}
    builder.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    builder.add_particles(packing.positions, packing.radii, "rock")
    builder.bond_within(1.01)
    builder.hold(packing.positions[:, 1] < 1.5 * RADIUS, x=0.0, y=0.0, rotation=0.0)
    return builder.build()


SCENES = {"spheres": falling_spheres, "packed": packed_spheres, "discs": bonded_discs}


def in_memory() -> float:
    """Memory of this process now [B]."""
    lines = Path("/proc/self/statm").read_text().split()
    return float(lines[1]) * os.sysconf("SC_PAGE_SIZE")


def run_scene(task: dict[str, Any]) -> dict[str, Any]:
    """Build a scene, run it, and say what it took: a part of a row.

    The task names scene, count, threads, steps; and, where they are wanted, shuffled rows or a state at rest.
    """
    set_threads(task["threads"])
    # kernels are loaded on a small scene first: what they take is not a million's
    _simulation(SCENES[task["scene"]](min(task["count"], WARM_UP))).run(2)
    before, start, compiled = in_memory(), time.perf_counter(), compile_seconds()
    assembly = SCENES[task["scene"]](task["count"])
    built = time.perf_counter() - start
    with _rows_at_random() if task.get("shuffled") else contextlib.nullcontext():
        simulation = _simulation(assembly)
    simulation.kernel(simulation.features)
    setup = time.perf_counter() - start - (compile_seconds() - compiled)
    n = assembly.particles
    found: dict[str, Any] = {
        "particles": n,
        "seconds_build": built,
        "seconds_setup": setup,
        "bytes_held": simulation.nbytes() / n,
        "bytes_resident": (in_memory() - before) / n,
        "bytes_peak": (1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / n,
        "pairs": simulation.pairs.pairs / n,
        "time_step": simulation.time_step,
    }
    if task.get("rest"):
        return found | _rest(simulation)
    return found | _motion(simulation, task["steps"])


@contextlib.contextmanager
def _rows_at_random() -> Iterator[None]:
    """Rows that begin in no order; nothing sorts them later, since their lists do not grow."""

    def shuffled(assembly: Assembly) -> NDArray[np.int64]:
        return np.random.default_rng(1).permutation(assembly.particles)

    sorting = engine.first_order
    engine.first_order = shuffled
    try:
        yield
    finally:
        engine.first_order = sorting


def _simulation(assembly: Assembly) -> ParticleSimulation:
    return ParticleSimulation(assembly, local_damping=DAMPING, orientation=False)


def _motion(simulation: ParticleSimulation, steps: int) -> dict[str, Any]:
    # the number of threads is chosen by the clock: all and one are tried first
    for _ in range(3):
        simulation.run(3)
    mass, gravity = simulation.assembly.mass, simulation.assembly.gravity
    # of those that have not moved yet
    height = float(mass @ simulation.positions[:, -1]) / mass.sum()
    searches = simulation.searches
    start = time.perf_counter()
    simulation.run(steps)
    seconds = time.perf_counter() - start
    contacts = simulation.contacts()
    speed = simulation.velocities
    sunk = height - float(mass @ simulation.positions[:, -1]) / mass.sum()
    return {
        "steps": steps,
        "seconds_step": seconds / steps / len(mass),
        "searches": simulation.searches - searches,
        "contacts": len(contacts.pairs) / len(mass),
        "sunk": sunk / RADIUS,
        "deepest": float(contacts.overlap.max(initial=0.0)) / RADIUS,
        # what the fall would give without contacts and damping
        "kinetic_share": float(0.5 * (mass * (speed**2).sum(1)).sum())
        / max(-float(gravity[-1]) * sunk * mass.sum(), 1e-300),
    }


def _rest(simulation: ParticleSimulation) -> dict[str, Any]:
    """Equilibrium of the discs: what the held ones carry against the weight of all others."""
    found = find_equilibrium(simulation)
    assembly = simulation.assembly
    held = assembly.held[:, 0]
    weight = float(assembly.mass[~held].sum()) * GRAVITY
    own = float(assembly.mass[held].sum()) * GRAVITY
    carried = -float(simulation.forces[held, 1].sum()) - own
    return {
        "reached": found.reached,
        "seconds_rest": found.seconds,
        "broken": int((~simulation.intact()).sum()),
        "weight_error": carried / weight - 1.0,
        "settled": float(-(simulation.positions - assembly.positions)[:, 1].min()) / RADIUS,
    }


def elsewhere(**task: Any) -> dict[str, Any]:
    """`run_scene` in a process of its own."""
    command = [sys.executable, "-m", "reference.benchmarks.large", json.dumps(task)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{task}: {done.stderr.strip()}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


PARTS = ("spheres", "discs", "order", "fall", "rest")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench large``."""
    parser.add_argument("--sizes", nargs=2, type=int, default=[100_000, 1_000_000], help="small and large")
    parser.add_argument("--parts", nargs="*", default=list(PARTS), choices=PARTS)
    parser.add_argument(
        "--steps", type=int, default=800, help="of the large falling spheres; others have fewer"
    )
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=2, help="measurements of speed")


def main(arguments: argparse.Namespace) -> int:
    """Measure, print a line a row, store the rows."""
    results = Results(NAME)
    small, large = arguments.sizes
    threads, steps = arguments.threads, arguments.steps
    speed = {"threads": threads, "steps": max(steps // 8, 2)}
    for scene in ("spheres", "discs"):
        if scene not in arguments.parts:
            continue
        rounds = [
            [elsewhere(scene=scene, count=count, **speed) for count in (small, large)]
            for _ in range(arguments.rounds)
        ]
        for row in speed_and_memory(scene, rounds, large):
            results.add(row)
    if "order" in arguments.parts:
        for row in order_of_rows(large, speed, arguments.rounds):
            results.add(row)
    if "fall" in arguments.parts:
        for row in spheres_fall(elsewhere(scene="spheres", count=large, threads=threads, steps=steps)):
            results.add(row)
    if "rest" in arguments.parts:
        for row in discs_rest(elsewhere(scene="discs", count=large, threads=threads, rest=True)):
            results.add(row)
    return 0


def speed_and_memory(scene: str, rounds: list[list[dict[str, Any]]], large: int) -> list[Row]:
    """What a particle costs in the large scene, and what the set-up takes."""
    said = {"spheres": "falling spheres", "discs": "bonded discs"}[scene]
    about = f"{large} {said}"
    last = rounds[-1][1]
    setup = [pair[1]["seconds_setup"] for pair in rounds]
    ratio = [pair[1]["seconds_step"] / pair[0]["seconds_step"] for pair in rounds]
    return [
        check(f"time of a particle and step over that of {rounds[-1][0]['particles']}, {about}", ratio,
              most=SLOWER, small=[pair[0] for pair in rounds], large=[pair[1] for pair in rounds]),
        check(f"million particle-steps a second with searches, {about}",
              [1e-6 / pair[1]["seconds_step"] for pair in rounds], searches=last["searches"]),
        check(f"set-up, {about}", setup, unit="s", most=SETUP, build=last["seconds_build"]),
        check(f"memory of a particle held, {about}", [last["bytes_held"]], unit="B", pairs=last["pairs"]),
        check(f"growth of the process, {about}", [last["bytes_resident"]], unit="B a particle"),
        check(f"growth of the process at its peak, {about}", [last["bytes_peak"]], unit="B a particle"),
    ]  # fmt: skip


def order_of_rows(large: int, speed: dict[str, int], rounds: int) -> list[Row]:
    """Packed spheres in the order of the curve and shuffled; memory of a sphere with six pairs."""
    few = {**speed, "steps": max(speed["steps"] // 2, 2)}
    pairs = [
        [elsewhere(scene="packed", count=large, shuffled=shuffled, **few) for shuffled in (False, True)]
        for _ in range(rounds)
    ]
    ratio = [b["seconds_step"] / a["seconds_step"] for a, b in pairs]
    one = pairs[-1][0]
    about = f"{large} packed spheres"
    return [
        check(f"time of rows at random over rows in order, {about}", ratio, least=ORDER,
              contacts=one["contacts"], sorted=[a for a, _ in pairs], shuffled=[b for _, b in pairs]),
        check(f"memory of a sphere held, {about}", [one["bytes_held"]], unit="B", most=BYTES,
              pairs=one["pairs"]),
        check(f"set-up, {about}", [a["seconds_setup"] for a, _ in pairs], unit="s", most=SETUP),
        check(f"growth of the process, {about}", [one["bytes_resident"]], unit="B a sphere"),
        check(f"growth of the process at its peak, {about}", [one["bytes_peak"]], unit="B a sphere"),
    ]  # fmt: skip


def spheres_fall(found: dict[str, Any]) -> list[Row]:
    """Whether spheres that fall do so: they sink, do not pass through each other, and lose energy."""
    about = f"{found['particles']} falling spheres after {found['steps']} steps"
    return [
        check(f"radii that the centre of mass has sunk, {about}", [found["sunk"]], least=0.0,
              searches=found["searches"], seconds=found["seconds_step"] * found["steps"] * found["particles"]),
        check(f"deepest overlap over the radius, {about}", [found["deepest"]], most=DEEPEST),
        check(f"kinetic energy over that of a free fall, {about}", [found["kinetic_share"]], most=1.0),
        check(f"contacts of a sphere, {about}", [2.0 * found["contacts"]]),
    ]  # fmt: skip


def discs_rest(found: dict[str, Any]) -> list[Row]:
    """Whether the discs' equilibrium is one."""
    about = f"{found['particles']} bonded discs at rest"
    return [
        check(f"equilibrium reached, {about}", [float(found["reached"])], least=1.0),
        check(f"time of find_equilibrium, {about}", [found["seconds_rest"]], unit="s"),
        check(f"broken bonds, {about}", [float(found["broken"])], most=0.0),
        check(f"error of the force at the bottom over the weight, {about}", [abs(found["weight_error"])],
              most=WEIGHT),
        check(f"radii that the top has settled, {about}", [found["settled"]], least=0.0),
    ]  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(run_scene(json.loads(sys.argv[1]))))
