"""geodem itself on a scene of `reference.scenes`: the one place where benchmarks call it."""

from __future__ import annotations

import time
from math import pi

import numpy as np

from geodem import __version__
from geodem._jit import ThreadPilot, set_threads
from geodem.assembly import Assembly
from geodem.boundaries.walls import box
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_layout import chunk_size
from geodem.particle_simulation import SERIAL_LIMIT, ParticleSimulation

from .backends.outcome import WARM_UP, Speed
from .scenes import Scene

NAME = "geodem"


def available() -> str | None:
    """None: geodem is always there."""
    return None


def run_speed(scene: Scene, steps: int, threads: int, *, damping: float = 0.0) -> Speed:
    """Seconds of one step after a warm-up, without building and compiling; `damping` is the local one."""
    set_threads(threads)
    # every call starts from the scene as it is given, as the other codes do
    simulation = ParticleSimulation(
        assembly(scene), time_step=scene.time_step, local_damping=damping, orientation=False
    )
    simulation._pilot = ThreadPilot()
    simulation.run(WARM_UP)
    begin = time.perf_counter()
    simulation.run(steps)
    seconds = (time.perf_counter() - begin) / steps
    found = simulation.contacts()
    law = simulation.assembly.contact_law
    if simulation.assembly.bond_law is not None:
        law += f", {simulation.assembly.bond_law}"
    return Speed(seconds, len(found.pairs), law, __version__)


_last: list[tuple[Scene, Assembly]] = []
"""The last scene and its assembly: building is not what is timed."""


def assembly(scene: Scene) -> Assembly:
    """The scene as geodem's assembly."""
    if not _last or _last[0][0] is not scene:
        _last[:] = [(scene, _build(scene))]
    return _last[0][1]


def _build(scene: Scene) -> Assembly:
    flat = scene.dimension == 2
    bonds = scene.bonds
    radius = float(scene.radii.mean())
    builder = AssemblyBuilder(
        scene.dimension,
        bond_law=None if bonds is None else ("two_springs" if flat else "parallel_bond"),
        gravity=np.asarray(scene.gravity)[: scene.dimension],
    )
    bond = None
    if bonds is not None and flat:
        width = 2.0 * (bonds.bend / bonds.normal) ** 0.5 / (2.0 * radius)
        bond = {
            "normal_stiffness": bonds.normal, "shear_stiffness": bonds.shear, "tensile_strength": bonds.tension,
            "cohesion": bonds.cohesion, "friction_coefficient": scene.friction, "width_ratio": width,
        }  # fmt: skip
    elif bonds is not None:
        area = pi * radius**2
        bond = {
            "radius_factor": 1.0, "normal_stiffness": bonds.normal / area, "shear_stiffness": bonds.shear / area,
            "tensile_strength": bonds.tension / area, "shear_strength": bonds.cohesion / area,
            "friction_coefficient": scene.friction,
        }  # fmt: skip
    builder.add_material(
        "grains",
        # discs have the mass of spheres here
        density=scene.density * (4.0 / 3.0 * radius if flat else 1.0),
        contact={
            "normal_stiffness": scene.normal, "shear_stiffness": scene.shear, "friction_coefficient": scene.friction,
        },
        bond=bond,
    )  # fmt: skip
    d = scene.dimension
    builder.add_particles(
        scene.positions[:, :d],
        scene.radii,
        "grains",
        velocity=scene.velocities[:, :d],
        spin=scene.spins[:, 2:] if flat else scene.spins,
    )
    if bonds is not None:
        builder.bond(bonds.pairs)
    if scene.box is not None:
        builder.add_wall(box("box", scene.box[0, :d], scene.box[1, :d]))
    return builder.build()


def chunk_of(scene: Scene) -> int:
    """Particles a chunk of geodem's pair list on this scene."""
    count = len(scene.radii)
    return chunk_size(count, count <= SERIAL_LIMIT)
