"""What moving the particles of a case of ground would take: time step, run time, memory."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ._jit import compile_seconds
from .builders.body_filling import BodyFilling, add_body
from .builders.memory import needed_bytes
from .case.ground import GroundCase
from .units import GRAVITY

if TYPE_CHECKING:
    from .assembly import Assembly

PROBE_STEPS = 20


@dataclass(frozen=True)
class Cost:
    """What moving the particles would take.

    Attributes
    ----------
    time_step : float [s]
        Half the critical one; NaN where nothing tells the stiffnesses.
    critical_time_step : float [s]
    step_seconds : float [s]
        Run time of a step.
    bonds : int
    memory_bytes : int
    why : str
        Why there is no time step, empty where there is one.
    """

    time_step: float
    critical_time_step: float
    step_seconds: float
    bonds: int
    memory_bytes: int
    why: str = ""
    compile_seconds: float = 0.0


def cost(case: GroundCase, filling: BodyFilling, scene: Assembly | None = None) -> Cost:
    """Time step, run time and memory of the particles as an assembly under gravity, bonded as the case says.

    `scene`: the assembly, where the case says all of it.
    """
    if scene is not None:
        return _measured(scene)
    d, count = filling.dimension, filling.particles
    bonded = [material.bonded for material in case.materials.values()]
    if None in bonded:
        lacking = ", ".join(name for name, material in case.materials.items() if material.bonded is None)
        return Cost(
            math.nan, math.nan, math.nan, 0, needed_bytes(d, count), f"no stiffness is given for {lacking}"
        )
    laws = {(own.bond_law, own.contact_law) for own in bonded if own is not None}
    if len(laws) > 1:
        return Cost(
            math.nan, math.nan, math.nan, 0, needed_bytes(d, count), "the materials have several laws"
        )
    return _measured(_assembly(case, filling))


def _measured(assembly: Assembly) -> Cost:
    from .particle_simulation import ParticleSimulation

    before = compile_seconds()
    motion = ParticleSimulation(assembly, local_damping=0.7)
    motion.run(2)
    begun = time.perf_counter()
    motion.run(PROBE_STEPS)
    seconds = (time.perf_counter() - begun) / PROBE_STEPS
    bonds = len(assembly.bonds)
    return Cost(
        time_step=motion.time_step,
        critical_time_step=motion.critical_time_step,
        step_seconds=seconds,
        bonds=bonds,
        memory_bytes=needed_bytes(assembly.dimension, assembly.particles, bonds),
        compile_seconds=compile_seconds() - before,
    )


def _assembly(case: GroundCase, filling: BodyFilling) -> Assembly:
    from .builders.assembly_builder import AssemblyBuilder

    d = filling.dimension
    materials = {name: case.materials[name] for name in filling.materials}
    first = next(iter(materials.values())).bonded
    assert first is not None
    gravity = (0.0,) * (d - 1) + (-GRAVITY,)
    build = AssemblyBuilder(d, contact_law=first.contact_law, bond_law=first.bond_law, gravity=gravity)
    for name, material in materials.items():
        own = material.bonded
        assert own is not None
        build.add_material(name, density=material.density, contact=dict(own.contact), bond=dict(own.bond))
    add_body(build, filling, {name: material.density for name, material in materials.items()})
    names = list(materials)
    for k, name in enumerate(names):
        for other in names[k:]:
            a, b = materials[name].bonded, materials[other].bonded
            assert a is not None
            assert b is not None
            weaker = a if a.bonding_range <= b.bonding_range else b
            build.bond_within(
                weaker.bonding_range, (name, other), scale=weaker.scatter(case.particles.seed + k)
            )
    return build.build()
