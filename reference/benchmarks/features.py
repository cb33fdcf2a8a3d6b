"""What each feature costs, and what is saved where there is nothing to do.

Features are timed on one scene of discs that all touch, pressed by 0.1 % of their diameter, with a step so short that
nothing moves: every kernel has the same pairs. Each one alone is added to the bare normal contact.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Collection
from typing import Any

import numpy as np

from geodem._jit import set_threads, threads_allowed
from geodem.boundaries import walls
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.neighbors import spatial_order
from geodem.particle_layout import chunk_size
from geodem.particle_simulation import ParticleSimulation, Sleep

from .. import ours, scenes
from ..results_file import Row
from .bond_laws import cost_of_bond_laws
from .checks import Results, check, in_turn, ratios

NAME = "features"
RADIUS = 5e-3
STIFFNESS = 1e6
SHORT = 1e-4
"""Time step over the critical one where nothing is to move."""
FEATURES = {
    "bonds": "bonds that may break",
    "friction": "friction and rotation",
    "viscosity": "viscosity",
    "orientation": "rotation and orientation",
    "local": "local damping",
    "global": "global damping",
    "gravity": "gravity",
    "walls": "walls",
    "energy": "energy account",
}
ALL_OFF = 2.0
FIRST_CALL = 0.3
"""Seconds of the first call of a kernel that is in the disk cache."""
ASLEEP = 8.0
ACTIVE = 0.1
"""Share of the discs that move."""
REBUILD = {2: 2.7, 3: 1.6}
"""Searches over force steps, by dimension."""
THREADS = 1.9


def pressed_discs(count: int, features: Collection[str] = ()) -> ParticleSimulation:
    """Touching discs with some of `FEATURES`, and nothing else but normal contact."""
    across = max(2, round(np.sqrt(count)))
    box = (2.0 * across * RADIUS, (1.732 * across + 0.3) * RADIUS)
    packing = lattice("hexagonal", RADIUS, box=box, gap=-2e-3 * RADIUS)
    builder = AssemblyBuilder(
        2,
        bond_law="two_springs" if "bonds" in features else None,
        gravity=(0.0, -9.81) if "gravity" in features else None,
    )
    viscosity = 1e-6 if "viscosity" in features else 0.0
    contact = {
        "normal_stiffness": STIFFNESS,
        "shear_stiffness": 0.5 * STIFFNESS,
        "friction_coefficient": 0.5 if "friction" in features else 0.0,
        "normal_viscosity": viscosity,
        "shear_viscosity": viscosity,
    }
    bond = None
    if "bonds" in features:
        bond = {**contact, "tensile_strength": 1e9, "cohesion": 1e9, "width_ratio": 0.5}
    builder.add_material("rock", density=2600.0, contact=contact, bond=bond)
    rng = np.random.default_rng(1)
    builder.add_particles(
        packing.positions,
        packing.radii,
        "rock",
        velocity=rng.normal(0.0, 1e-3, packing.positions.shape),
        spin=rng.normal(0.0, 1e-2, packing.particles) if "orientation" in features else 0.0,
    )
    if "bonds" in features:
        builder.bond_within(1.01)
    if "walls" in features:
        builder.add_wall(walls.box("box", (0.0, 0.0), packing.box))
    options: dict[str, Any] = {
        "local_damping": 0.2 if "local" in features else 0.0,
        "global_damping": 1.0 if "global" in features else 0.0,
        "energy": "energy" in features,
        "orientation": "orientation" in features,
    }
    assembly = builder.build()
    step = SHORT * ParticleSimulation(assembly, **options).critical_time_step
    return ParticleSimulation(assembly, time_step=step, **options)


def seconds_a_step(simulation: ParticleSimulation, seconds: float) -> float:
    """Of as many steps as take about so many seconds; the first ones do not count."""
    # the number of threads is chosen by the clock: all and one are tried first
    simulation.run(5)
    simulation.run(5)
    start = time.perf_counter()
    simulation.run(10)
    steps = int(min(max(seconds / (time.perf_counter() - start), 10), 1000))
    done, start = 0, time.perf_counter()
    while (taken := time.perf_counter() - start) < seconds or not done:
        simulation.run(steps)
        done += steps
    return taken / done


def stepping(simulation: ParticleSimulation, seconds: float) -> Callable[[], float]:
    """`seconds_a_step` as a measurement."""
    return lambda: seconds_a_step(simulation, seconds)


def cost_of_features(
    count: int, seconds: float, rounds: int, wanted: Collection[str] = tuple(FEATURES)
) -> list[Row]:
    """All on over all off, and each one that is wanted over none."""
    bare = pressed_discs(count)
    rows = []
    chosen: list[tuple[str, Collection[str], float | None]] = []
    if set(wanted) == set(FEATURES):
        chosen.append(("all features", FEATURES, ALL_OFF))
    chosen += [(said, [name], None) for name, said in FEATURES.items() if name in wanted]
    for said, features, least in chosen:
        both = in_turn([stepping(bare, seconds), stepping(pressed_discs(count, features), seconds)], rounds)
        rows.append(
            check(
                f"time with {said} over bare normal contact, {bare.assembly.particles} discs",
                ratios(both),
                least=least,
                seconds=both,
            )
        )
    return rows


FIRST_CALL_SCRIPT = """
import time
start = time.perf_counter()
import numba
numba_seconds = time.perf_counter() - start
from reference import ours, scenes
scene = getattr(scenes, {scene!r})({count})
start = time.perf_counter()
simulation = ours.simulation_of(scene)
setup_seconds = time.perf_counter() - start
start = time.perf_counter()
simulation.run(1)
print([numba_seconds, setup_seconds, time.perf_counter() - start])
"""


def first_calls(count: int, rounds: int) -> list[Row]:
    """Seconds of the first step in a process of its own, loading of the kernel from the disk cache and all."""
    rows = []
    for scene, said in (("bonded_discs", "bonded discs"), ("touching_spheres", "spheres")):
        text = FIRST_CALL_SCRIPT.format(scene=scene, count=count)
        figures = []
        # the first process fills the cache
        for _ in range(rounds + 1):
            done = subprocess.run(
                [sys.executable, "-c", text], capture_output=True, text=True, check=True
            ).stdout
            figures.append(json.loads(done))
        figures = figures[1:]
        rows.append(
            check(
                f"first step from the disk cache, {said}",
                [one[2] for one in figures],
                unit="s",
                most=FIRST_CALL,
                seconds_import_numba=[one[0] for one in figures],
                seconds_setup=[one[1] for one in figures],
            )
        )
    return rows


def sleeping_discs(count: int, sleep: Sleep | None) -> ParticleSimulation:
    """Discs of a lattice at rest, and a tenth of all, whole chunks with a ditch around them, that shakes."""
    from scipy.spatial import cKDTree

    across = max(2, round(np.sqrt(count)))
    row, column = np.divmod(np.arange(across * across), across)
    positions = np.stack([2.0 * RADIUS * column + RADIUS * (row % 2), np.sqrt(3.0) * RADIUS * row], axis=1)
    chunk = chunk_size(len(positions), False)
    order = spatial_order(positions, np.full(len(positions), RADIUS))
    shaking = np.zeros(len(positions), dtype=bool)
    shaking[order[: max(1, round(ACTIVE * len(positions) / chunk)) * chunk]] = True
    ditch = ~shaking & (cKDTree(positions[shaking]).query(positions)[0] < 3.0 * RADIUS)
    positions, shaking = positions[~ditch], shaking[~ditch]
    builder = AssemblyBuilder(2, bond_law="two_springs")
    contact = {"normal_stiffness": STIFFNESS, "shear_stiffness": 0.5 * STIFFNESS, "friction_coefficient": 0.5}
    bond = {**contact, "tensile_strength": 1e9, "cohesion": 1e9, "width_ratio": 0.5}
    builder.add_material("rock", density=2600.0, contact=contact, bond=bond)
    velocity = np.random.default_rng(1).normal(0.0, 0.01, positions.shape)
    velocity[~shaking] = 0.0
    velocity[shaking] -= velocity[shaking].mean(axis=0)
    builder.add_particles(positions, RADIUS, "rock", velocity=velocity)
    builder.bond_within(1.01)
    return ParticleSimulation(builder.build(), orientation=False, sleep=sleep)


def cost_of_sleep(count: int, seconds: float, rounds: int) -> list[Row]:
    """Everything awake over a tenth of it awake."""
    awake, asleep = sleeping_discs(count, None), sleeping_discs(count, Sleep(1e-5, 20))
    asleep.run(60)
    both = in_turn([stepping(asleep, seconds), stepping(awake, seconds)], rounds)
    share = 1.0 - float(asleep.asleep.mean())
    return [
        check(
            f"time with all awake over that with a tenth awake, {count} discs",
            ratios(both),
            least=ASLEEP,
            active=share,
            seconds=both,
        )
    ]  # fmt: skip


def cost_of_search(count: int, seconds: float, rounds: int) -> list[Row]:
    """A search over a force step."""
    rows = []
    for make, said in ((scenes.bonded_discs, "bonded discs"), (scenes.touching_spheres, "touching spheres")):
        scene = make(count)
        simulation = ours.simulation_of(scene)

        def search(simulation: ParticleSimulation = simulation) -> float:
            found, start = 0, time.perf_counter()
            while time.perf_counter() - start < seconds or not found:
                simulation.search(sort=False)
                found += 1
            return (time.perf_counter() - start) / found

        both = in_turn([stepping(simulation, seconds), search], rounds)
        rows.append(
            check(
                f"time of a search over a force step, {scene.particles} {said}",
                ratios(both),
                most=REBUILD[scene.dimension],
                seconds=both,
            )
        )
    return rows


def gain_of_threads(counts: Collection[int], seconds: float, rounds: int) -> list[Row]:
    """One thread over two."""
    rows = []
    before = threads_allowed()
    for count in counts:
        for make, said in (
            (scenes.bonded_discs, "bonded discs"),
            (scenes.touching_spheres, "touching spheres"),
        ):
            runs = []
            for threads in (2, 1):
                set_threads(threads)
                simulation = ours.simulation_of(make(count))
                runs.append(_on_threads(simulation, threads, seconds))
            both = in_turn(runs, rounds)
            rows.append(
                check(f"one thread over two, {count} {said}", ratios(both), least=THREADS, seconds=both)
            )
    set_threads(before)
    return rows


def _on_threads(simulation: ParticleSimulation, threads: int, seconds: float) -> Callable[[], float]:
    def run() -> float:
        set_threads(threads)
        return seconds_a_step(simulation, seconds)

    return run


PARTS = ("cost", "bonds", "first", "sleep", "search", "threads")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench features``."""
    parser.add_argument("--parts", nargs="*", default=list(PARTS), choices=PARTS)
    parser.add_argument("--features", nargs="*", default=list(FEATURES), choices=list(FEATURES))
    parser.add_argument("--count", type=int, default=100_000, help="particles of the large scenes")
    parser.add_argument("--few", type=int, default=10_000, help="particles of the small ones")
    parser.add_argument("--rounds", type=int, default=5, help="measurements of each")
    parser.add_argument("--seconds", type=float, default=0.5, help="length of a measurement")


def main(arguments: argparse.Namespace) -> int:
    """Measure what is asked, print a line a row, store the rows."""
    results = Results(NAME)
    seconds, rounds, count, few = arguments.seconds, arguments.rounds, arguments.count, arguments.few
    before = threads_allowed()
    # one thread but where threads are the question
    set_threads(1)
    parts = {
        "cost": lambda: cost_of_features(few, seconds, rounds, arguments.features),
        "bonds": lambda: cost_of_bond_laws(
            {2: (few / 2.1) ** 0.5, 3: (few / 1.8) ** (1.0 / 3.0)}, rounds, lambda s: stepping(s, seconds)
        ),
        "first": lambda: first_calls(min(few, 1000), rounds),
        "sleep": lambda: cost_of_sleep(count, seconds, rounds),
        "search": lambda: cost_of_search(count, seconds, rounds),
        "threads": lambda: gain_of_threads((few, count), seconds, rounds),
    }
    for part in arguments.parts:
        for row in parts[part]():
            results.add(row)
    set_threads(before)
    return 0
