"""Small scenes of the stability battery: parameters of every law, lattices in a periodic cell, blocks with joints."""

from __future__ import annotations

import numpy as np

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.bolts import Bar, Grout, add_bolt
from geodem.builders.joints import plane
from geodem.builders.packings import lattice
from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.particle_simulation import ParticleSimulation

RADIUS = 0.01
DENSITY = 2500.0
_SPRINGS = {"normal_stiffness": 1e7, "shear_stiffness": 5e6, "friction_coefficient": 0.5}
_GLASS = {"young_modulus": 5e10, "poisson_ratio": 0.2}
_STRONG = 1e12

CONTACTS: dict[str, dict[str, float]] = {
    "linear_frictional": _SPRINGS,
    "linear_incremental": _SPRINGS,
    "cohesive_frictional": {**_SPRINGS, "adhesion": 10.0, "adhesion_shear": 5.0},
    "linear_rolling": {**_SPRINGS, "rolling_friction": 0.3, "twisting_friction": 0.2},
    "effective_modulus": {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5},
    "hertz": _GLASS,
    "hertz_mindlin": {**_GLASS, "friction_coefficient": 0.5},
    "hertz_mindlin_rolling": {
        **_GLASS,
        "friction_coefficient": 0.5,
        "rolling_friction": 0.3,
        "twisting_friction": 0.2,
    },
    "hertz_dmt": {**_GLASS, "friction_coefficient": 0.5, "work_of_adhesion": 0.1},
    "elastic_frictional": {"young_modulus": 1e9, "stiffness_ratio": 0.5, "friction_coefficient": 0.5},
    "hooke_stiffness": _SPRINGS,
    "hooke": {**_GLASS, "friction_coefficient": 0.5, "restitution": 0.9, "characteristic_velocity": 0.05},
    "hertz_history": {**_GLASS, "friction_coefficient": 0.5, "restitution": 0.9},
}
"""Of every law of contacts."""

_CEMENT = {"tensile_strength": _STRONG, "shear_strength": _STRONG, "friction_coefficient": 0.5}
_MODULUS = {"effective_modulus": 1e9, "stiffness_ratio": 2.0}
_DISCRETE = {"young_modulus": 1e9, "stiffness_ratio": 0.5, "friction_coefficient": 0.5}
BONDS: dict[str, dict[str, float]] = {
    "two_springs": {**_SPRINGS, "tensile_strength": _STRONG, "cohesion": _STRONG, "width_ratio": 0.8},
    "parallel_bond": {"radius_factor": 1.0, "normal_stiffness": 1e11, "shear_stiffness": 5e10, **_CEMENT},
    "cement": {"radius_factor": 1.0, **_MODULUS, **_CEMENT},
    "rotational_bond": {
        "normal_stiffness": 1e7,
        "shear_stiffness": 5e6,
        "twisting_stiffness": 200.0,
        "bending_stiffness": 300.0,
        "tensile_strength": _STRONG,
        "shear_strength": _STRONG,
        "twisting_strength": _STRONG,
        "bending_strength": _STRONG,
    },
    "rock": {**_MODULUS, **_CEMENT},
    "flat_joint": {**_MODULUS, **_CEMENT, "residual_friction_coefficient": 0.4},
    "cohesive_moments": {
        **_DISCRETE,
        "normal_cohesion": _STRONG,
        "shear_cohesion": _STRONG,
        "bending_factor": 0.8,
        "twisting_factor": 0.8,
    },
    "jointed_cohesive": {**_DISCRETE, "tensile_strength": _STRONG, "cohesion": _STRONG},
}
"""Of every law of bonds, too strong to break."""

BESIDE = {
    "cohesive_moments": "elastic_frictional",
    "jointed_cohesive": "elastic_frictional",
    "two_springs": "linear_frictional",
    "rotational_bond": "linear_frictional",
}
"""Contact laws that go with bond laws and are no stiffer; `effective_modulus` with the others."""

LATTICES: dict[int, dict[str, tuple[int, ...]]] = {
    2: {"square": (6, 6), "hexagonal": (6, 4)},
    3: {"simple_cubic": (4, 4, 4), "fcc": (3, 3, 3)},
}
CLOSED = 1e-3
"""Overlap of contacts in a pressed lattice, over the diameter."""
SHAKEN = 0.05
"""Share of that overlap by which the shaking alternates, so that every contact stays closed."""

CASES: list[tuple[str, str | None, int]] = [
    (name, None, d) for name in CONTACTS for d in CONTACT_LAWS[name].DIMENSIONS
]
CASES += [
    (BESIDE.get(name, "effective_modulus"), name, d) for name in BONDS for d in BOND_LAWS[name].DIMENSIONS
]
CASES = [(contact, bond, d) for contact, bond, d in CASES if d in CONTACT_LAWS[contact].DIMENSIONS]
"""Every law of contacts and of bonds in every dimension it is for."""


def builder_of(
    dimension: int,
    contact: str,
    bond: str | None = None,
    gravity: tuple[float, ...] | None = None,
    **changed: float,
) -> AssemblyBuilder:
    """A builder with one material, "grain"; `changed` parameters are the contact's."""
    build = AssemblyBuilder(dimension, contact, bond, gravity)
    build.add_material(
        "grain",
        density=DENSITY,
        contact={**CONTACTS[contact], **changed},
        bond=None if bond is None else BONDS[bond],
    )
    return build


def packings_of(contact: str, bond: str | None, dimension: int) -> list[str]:
    """Lattices that hold under pressure: without any shear stiffness only the dense ones do."""
    return [kind for kind in LATTICES[dimension] if bond or contact != "hertz" or kind == "fcc"]


def weak(bond: str) -> dict[str, float]:
    """Parameters of a bond that the least motion breaks: every strength is 1 Pa, N or N m."""
    return {name: 1.0 if value == _STRONG else value for name, value in BONDS[bond].items()}


def shaken_lattice(contact: str, bond: str | None, dimension: int, kind: str, **changed: float) -> Assembly:
    """A periodic lattice, pressed where nothing bonds it, whose particles get random velocities and spins.

    `changed` parameters are the contact's.
    """
    gap = 0.0 if bond else -2.0 * CLOSED * RADIUS
    packing = lattice(kind, RADIUS, cells=LATTICES[dimension][kind], gap=gap)

    def built(velocity: np.ndarray, spin: np.ndarray) -> Assembly:
        build = builder_of(dimension, contact, bond, None, **changed)
        build.set_cell(packing.box)
        build.add_particles(packing.positions, packing.radii, "grain", velocity=velocity, spin=spin)
        if bond:
            build.bond_within(1.01)
        return build.build()

    count = packing.particles
    turns = 1 if dimension == 2 else 3
    still = built(np.zeros((count, dimension)), np.zeros((count, turns)))
    return built(*noise(still))


def noise(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and spins that alternate the overlaps by a small share of `CLOSED`."""
    critical = ParticleSimulation(assembly, orientation=False).critical_time_step
    speed = SHAKEN * 2.0 * CLOSED * RADIUS * 2.0 / critical
    rng = np.random.default_rng(8)
    velocity = rng.uniform(-speed, speed, (assembly.particles, assembly.dimension))
    spin = rng.uniform(-speed, speed, (assembly.particles, 1 if assembly.dimension == 2 else 3)) / RADIUS
    return velocity - velocity.mean(axis=0), spin


def jointed_block(law: str, dimension: int) -> Assembly:
    """A bonded block, free in space, with a strong joint through its middle, or a bolt along it; shaken."""
    packing = lattice(
        "hexagonal" if dimension == 2 else "fcc", RADIUS, cells=(8, 5) if dimension == 2 else (4, 3, 3)
    )
    places = packing.positions - packing.positions.min(axis=0)
    size = places.max(axis=0)

    def built(velocity: np.ndarray | float, spin: np.ndarray | float) -> Assembly:
        build = builder_of(dimension, "effective_modulus", "rock")
        count = len(places)
        moving = velocity if np.ndim(velocity) == 0 else np.asarray(velocity)[:count]
        turning = spin if np.ndim(spin) == 0 else np.asarray(spin)[:count]
        build.add_particles(places, RADIUS, "grain", velocity=moving, spin=turning)
        build.bond_within(1.01)
        if law == "bolt":
            head = np.append(0.1 * size[:1], 0.5 * size[1:])
            end = np.append(0.9 * size[:1], 0.5 * size[1:])
            add_bolt(
                build,
                "bolt",
                head,
                end,
                Bar(1e6, density_per_length=1.0),
                Grout(1e8, 1e9),
                spacing=2.0 * RADIUS,
            )
            return build.build()
        build.add_joint_material(
            "joint",
            normal_stiffness=1e11,
            shear_stiffness=5e10,
            friction_coefficient=0.5,
            cohesion=_STRONG,
            tensile_strength=_STRONG,
        )
        bounds = np.array([places.min(axis=0) - RADIUS, places.max(axis=0) + RADIUS])
        normal = np.eye(dimension)[0]
        build.cut([plane(0.5 * size + 0.1 * RADIUS, normal, bounds, "joint")], bounds=bounds, within=1.05)
        return build.build()

    velocity, spin = noise(built(0.0, 0.0))
    return built(velocity, spin)
