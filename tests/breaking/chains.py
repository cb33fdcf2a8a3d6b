"""A chain of discs that hangs from its first one: what breaks it follows from its weight; with walls out of its way."""

from __future__ import annotations

from geodem.boundaries.walls import plane, segments
from geodem.breaking.site import Site
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

LINKS = 12
RADIUS = 0.5
DENSITY = 2000.0
GRAVITY = 10.0
WEIGHT = 3.141592653589793 * RADIUS**2 * DENSITY * GRAVITY
"""Of a disc [N/m]."""
STRENGTH = 1e6
"""Of a bond [Pa], on a section of its diameter."""
FACTOR = STRENGTH * 2.0 * RADIUS / ((LINKS - 1) * WEIGHT)
"""By which gravity, or the lack of strength, may grow until the top bond bears no more."""


def chain(damping: float = 0.7) -> ParticleSimulation:
    """The chain along y, its first disc held at the origin; a floor far below and a shelf beside it."""
    build = AssemblyBuilder(2, "effective_modulus", "rock", gravity=(0.0, -GRAVITY))
    bond = {
        "effective_modulus": 1e9, "stiffness_ratio": 2.0, "tensile_strength": STRENGTH, "shear_strength": 1e8,
        "friction_coefficient": 0.5,
    }  # fmt: skip
    contact = {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
    build.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    ids = build.add_particles([(0.0, -2.0 * RADIUS * k) for k in range(LINKS)], RADIUS, "rock")
    build.bond_within(1.01)
    build.hold([ids[0]], x=0.0, y=0.0, rotation=0.0)
    build.add_wall(plane("floor", (0.0, -200.0), (0.0, 1.0)))
    build.add_wall(segments("shelf", [(5.0, -5.0), (9.0, -5.0)]))
    return ParticleSimulation(build.build(), local_damping=damping, energy=True, applied=True)


def site(damping: float = 0.7) -> Site:
    """Its site, the last disc measured."""
    return Site.of(chain(damping), {"end": LINKS - 1})
