"""What a step costs by the law of the bonds: the same grains, the same pairs, one law after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laboratory.specimen import make_specimen
from geodem.particle_simulation import ParticleSimulation

from ..results_file import Row
from .checks import check, in_turn, ratios

BASE = "parallel_bond"
"""The law that the others are compared with: the usual one of bonded grains."""

MODULUS, RATIO, FRICTION = 30e9, 2.5, 0.5
RANGE = 1.05
SHORT = 1e-4
"""Time step over the critical one, so that nothing moves and every law has the same pairs."""
UNBREAKABLE = 1e15

_MODULI = {"effective_modulus": MODULUS, "stiffness_ratio": RATIO}
_STRENGTHS = {"tensile_strength": UNBREAKABLE, "shear_strength": UNBREAKABLE, "friction_coefficient": 1.0}
_WHOLE = {"radius_factor": 1.0, "moment_contribution": 1.0}


class BondLaw(NamedTuple):
    """A law with its parameters: of bonds, and of the contacts that take over where one has broken."""

    bond: Mapping[str, float]
    contact_law: str = "effective_modulus"


LAWS = {
    "parallel_bond": BondLaw({"normal_stiffness": 1e13, "shear_stiffness": 4e12, **_WHOLE, **_STRENGTHS}),
    "rock": BondLaw({**_MODULI, **_STRENGTHS, "moment_contribution": 0.3}),
    "cement": BondLaw({**_MODULI, **_WHOLE, **_STRENGTHS}),
    "flat_joint": BondLaw({**_MODULI, **_STRENGTHS, "residual_friction_coefficient": FRICTION}),
}


def bonded_specimen(dimension: int, across: float, law: str) -> ParticleSimulation:
    """A random specimen, twice as high as wide, whose grains tremble."""
    specimen = make_specimen(dimension, across=across, seed=1)
    chosen = LAWS[law]
    build = AssemblyBuilder(dimension, contact_law=chosen.contact_law, bond_law=law)
    contact = {**_MODULI, "friction_coefficient": FRICTION}
    build.add_material("rock", density=2600.0, contact=contact, bond=chosen.bond)
    build.add_particles(specimen.positions, specimen.radii, "rock")
    build.bond_within(RANGE)
    assembly = build.build()
    step = SHORT * ParticleSimulation(assembly, orientation=False).critical_time_step
    return ParticleSimulation(assembly, time_step=step, local_damping=0.7, orientation=False)


def cost_of_bond_laws(
    across: Mapping[int, float], rounds: int, measured: Callable[[ParticleSimulation], Callable[[], float]]
) -> list[Row]:
    """Time of a step of every law over that of `BASE`.

    Parameters
    ----------
    across : mapping of int to float
        Particles across a specimen by dimension.
    rounds : int
    measured : callable
        A measurement of seconds a step.
    """
    rows = []
    for dimension, wide in across.items():
        bare = bonded_specimen(dimension, wide, BASE)
        grains = f"{bare.assembly.particles} {'discs' if dimension == 2 else 'spheres'}"
        for law in LAWS:
            if law == BASE:
                continue
            both = in_turn([measured(bare), measured(bonded_specimen(dimension, wide, law))], rounds)
            rows.append(check(f"time with bonds {law} over {BASE}, {grains}", ratios(both), seconds=both))
    return rows
