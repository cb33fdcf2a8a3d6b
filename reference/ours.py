"""geodem itself on a scene of `reference.scenes`: the one place where comparisons and benchmarks call it."""

from __future__ import annotations

import math
import time

import numpy as np

from geodem._jit import set_threads, threads_allowed
from geodem._version import __version__
from geodem.assembly import Assembly
from geodem.boundaries import walls
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laws.convention import CONVENTIONS
from geodem.particle_simulation import ParticleSimulation

from .backends.outcome import Outcome, Speed, speed
from .backends.program import refuse
from .scenes import Scene

NAME = "geodem"

LAWS = {
    "frictional": "linear_frictional",
    "moments": "parallel_bond; the contact beside it has a millionth of the stiffness",
    "planar": "two_springs without width; discs have the mass of the scene's spheres and the inertia of discs",
}
SETTLING = 0.3
"""Seconds before speed is measured on several threads: how many pay is found out first, in a run of any length once."""
_BESIDE = 1e-6
"""Share of the contact's stiffness where a bond acts beside it: the other codes have no contact there."""


def run(
    scene: Scene,
    steps: int,
    *,
    threads: int = 1,
    warm_up: int = 0,
    every: int = 0,
    damping: float = 0.0,
    convention: str = "geodem",
) -> Outcome:
    """`warm_up` steps, then `steps` timed ones; frames every `every` steps (0: the last only).

    `damping` is the local one, `convention` a name in `geodem.laws.convention.CONVENTIONS`: codes that begin with the
    scene's velocities half a step back count that half step's slip, others do not. Velocities are half a step back.
    Building and compiling do not count. Raises BackendError where geodem's laws cannot stand for the scene.
    """
    law, assembly = _assembly(scene, CONVENTIONS[convention].VELOCITIES_BEFORE)
    before = threads_allowed()
    set_threads(threads)
    try:
        simulation = ParticleSimulation(
            assembly,
            time_step=scene.time_step,
            local_damping=damping,
            orientation=False,
            convention=convention,
        )
        simulation.kernel(simulation.features)
        simulation.run(warm_up)
        begin = time.perf_counter()
        while warm_up and threads > 1 and time.perf_counter() - begin < SETTLING:
            simulation.run(warm_up)
        frames, seconds, left = [], 0.0, steps
        while left > 0:
            batch = min(every or left, left)
            begin = time.perf_counter()
            simulation.run(batch)
            seconds += time.perf_counter() - begin
            left -= batch
            frames.append(_state(simulation))
    finally:
        set_threads(before)
    positions, velocities, spins = (np.array(values) for values in zip(*frames, strict=True))
    return Outcome(seconds / steps, LAWS[law], __version__, positions, velocities, spins)


def run_speed(scene: Scene, steps: int, threads: int, *, damping: float = 0.0) -> Speed:
    """Seconds of one step after a warm-up, without building and compiling; `damping` is the local one."""

    def damped(scene: Scene, steps: int, *, threads: int, warm_up: int) -> Outcome:
        return run(scene, steps, threads=threads, warm_up=warm_up, damping=damping)

    return speed(damped, scene, steps, threads)


def simulation_of(scene: Scene, *, damping: float = 0.0) -> ParticleSimulation:
    """geodem's simulation of a scene, at its start."""
    return ParticleSimulation(
        _assembly(scene)[1], time_step=scene.time_step, local_damping=damping, orientation=False
    )


def _assembly(scene: Scene, velocities_before: bool = False) -> tuple[str, Assembly]:
    """Name of the laws, and the assembly, with the velocities at the start or half a step before it."""
    d, bonds = scene.dimension, scene.bonds
    moments = bonds is not None and d == 3
    law = "frictional" if bonds is None else "moments" if moments else "planar"
    share = _BESIDE if moments else 1.0
    builder = AssemblyBuilder(
        d,
        bond_law={"frictional": None, "moments": "parallel_bond", "planar": "two_springs"}[law],
        gravity=scene.gravity[:d] if any(scene.gravity) else None,
    )
    contact = {
        "normal_stiffness": share * scene.normal,
        "shear_stiffness": share * scene.shear,
        "friction_coefficient": scene.friction,
    }
    builder.add_material("grain", density=scene.density, contact=contact, bond=_bond(scene))
    velocities = scene.velocities if velocities_before else scene.velocities_at_start()
    spins = scene.spins
    # discs weigh by the metre; these weigh what the scene's spheres do
    density = scene.mass / (np.pi * scene.radii**2) if d == 2 else scene.density
    builder.add_particles(
        scene.positions[:, :d],
        scene.radii,
        "grain",
        velocity=velocities[:, :d],
        spin=spins[:, 2:] if d == 2 else spins,
        density=density,
    )
    if scene.box is not None:
        builder.add_wall(walls.box("box", scene.box[0, :d], scene.box[1, :d]))
    if bonds is not None:
        builder.bond(bonds.pairs)
    return law, builder.build()


def _bond(scene: Scene) -> dict[str, float] | None:
    bonds = scene.bonds
    if bonds is None:
        return None
    if scene.dimension == 2:
        if bonds.twist or bonds.bend:
            raise refuse("geodem", "bonds of discs with a given stiffness against bending")
        return {
            "normal_stiffness": bonds.normal,
            "shear_stiffness": bonds.shear,
            "tensile_strength": bonds.tension,
            "cohesion": bonds.cohesion,
            "friction_coefficient": scene.friction,
            "width_ratio": 0.0,
        }
    radius = float(scene.radii[0])
    area = math.pi * radius**2
    if np.any(scene.radii != radius):
        raise refuse("geodem", "stiffnesses of its parallel bonds follow the radius, and the radii differ")
    stiff = (bonds.bend / (bonds.normal * radius**2), bonds.twist / (bonds.shear * radius**2))
    if not np.allclose(stiff, (0.25, 0.5)):
        raise refuse("geodem", "bend and twist of a parallel bond are kn r2/4 and ks r2/2")
    if not (math.isinf(bonds.tension) and math.isinf(bonds.cohesion)):
        raise refuse(
            "geodem", "a parallel bond breaks by stresses, not by forces; only unbreakable ones are the same"
        )
    return {
        "radius_factor": 1.0,
        "normal_stiffness": bonds.normal / area,
        "shear_stiffness": bonds.shear / area,
        "tensile_strength": math.inf,
        "shear_strength": math.inf,
    }


def _state(simulation: ParticleSimulation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, velocities and spins in three components."""
    parts = [simulation.positions, simulation.velocities, simulation.spins]
    if simulation.dimension == 2:
        parts = [
            np.pad(parts[0], ((0, 0), (0, 1))),
            np.pad(parts[1], ((0, 0), (0, 1))),
            np.pad(parts[2], ((0, 0), (2, 0))),
        ]
    return parts[0].copy(), parts[1].copy(), parts[2].copy()
