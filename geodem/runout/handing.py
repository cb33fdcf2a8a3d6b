"""The hand-over: from stress-carrying particles to discs at rest under their weight, with what was kept and what not.

The discs come to rest under their weight before they are let go, with contacts that stick, so that overlaps and shear
forces carry the stress of the ground at rest. Then the packing is moved as a whole to the centre of gravity of the
source. Its springs make it about as stiff as the ground, within bounds, so that the elastic energy is carried over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..assembly import DISC_INERTIA, Assembly
from ..builders.assembly_builder import AssemblyBuilder
from ..errors import InputError
from ..laws import CONTACT_LAWS
from ..measure.contact_energy import law_energy
from ..particle_simulation import ParticleSimulation
from ..preparation.settling import run_to_rest
from .carrying import carried_masses, carried_motion, shift_to_centre
from .friction import SHEAR_STIFFNESS, DiscFriction, friction_tangent
from .placing import Discs, place_discs
from .source import Source

Floats = NDArray[np.float64]

LAW = "linear_rolling"
STICKING = DiscFriction(1.0, 1.0)
"""Friction of contacts while the discs come to rest."""

SOFTEST, STIFFEST = 200.0, 1000.0
"""Normal stiffness of a contact over rho g H, H the height of what moves: below, discs overlap too much to be grains;
above, steps are short for nothing."""

MODULUS = 0.83
"""Young's modulus of a dense packing over the normal stiffness, at half of it across [-]."""

DAMPING = 0.7
"""Local damping of the discs while they come to rest."""

BALANCED = 2e-3
"""Unbalanced ratio of the discs when they are let go."""

MOST_STEPS = 15_000
"""Until then. A few discs that roll off a face keep them from it without harm."""

FARTHEST = 2.0
"""Way of the packing to the centre of gravity of the source, in mean diameters at most."""

LOOSE = 0.1
"""Unbalanced ratio beyond which the discs are not at rest at all."""


@dataclass(frozen=True)
class Conserved:
    """A quantity before and after the hand-over; `scale` is what a difference is measured by."""

    name: str
    unit: str
    before: float
    after: float
    scale: float

    @property
    def error(self) -> float:
        """Difference over the scale [-]."""
        return (
            abs(self.after - self.before) / self.scale if self.scale > 0.0 else abs(self.after - self.before)
        )


@dataclass(frozen=True, eq=False)
class HandOver:
    """Discs ready to flow.

    Attributes
    ----------
    simulation : ParticleSimulation
        With the friction that it flows with; rigid ground held.
    source : Source
    moving : (n,) bool
    mass : (n,) [kg/m]
        Zero for the rigid ground.
    surface : (k, 2) [m]
    diameter : float
        Mean [m].
    stiffness : float
        Normal stiffness of contacts [N/m per m].
    friction : float
        Tangent of the residual friction angle, the mean of the materials by their mass [-].
    unbalanced_ratio : float
    settlement : float
        Of the centre of gravity while the discs came to rest [m].
    shift : (2,) [m]
        Of all discs, the rigid ones too, to the centre of gravity of the source.
    conserved : tuple of Conserved
    """

    simulation: ParticleSimulation
    source: Source
    moving: NDArray[np.bool_]
    mass: Floats
    surface: Floats
    diameter: float
    stiffness: float
    friction: float
    unbalanced_ratio: float
    settlement: float
    shift: Floats
    conserved: tuple[Conserved, ...]

    def error(self, name: str) -> float:
        """Of what is conserved by this name [-]."""
        return next(entry.error for entry in self.conserved if entry.name == name)


def hand_over(
    source: Source,
    friction: Sequence[DiscFriction],
    *,
    discs: int = 2000,
    beyond: float,
    restitution: float = 0.5,
    young_modulus: float = math.inf,
    seed: int = 1,
) -> HandOver:
    """Make discs of what moves, bring them to rest under its weight, and give them its motion.

    Parameters
    ----------
    source : Source
    friction : sequence of DiscFriction
        Of every material of the source, for the flow.
    discs : int
        Of what moves, about.
    beyond : float
        Level ground beyond the section [m].
    restitution : float
        Of two discs that meet head-on, 0 to 1 [-].
    young_modulus : float
        Of the ground [Pa]; decides the stiffness of contacts between the bounds of this module.
    seed : int
        Of the packing.

    Raises
    ------
    InputError
        As `place_discs`; discs that do not come to rest, or are too few for the shape of what moves.
    """
    if not 0.0 < restitution <= 1.0:
        raise InputError("restitution", "this is not between 0 and 1", "Give 0.5, say.", value=restitution)
    placed = place_discs(source, discs=discs, beyond=beyond, seed=seed)
    unit = source.mass / source.area * source.gravity * source.height
    stiffness = min(max(young_modulus / MODULUS, SOFTEST * unit), STIFFEST * unit)
    mass = _masses(source, placed)
    settling = ParticleSimulation(
        _assembly(source, placed, mass, [STICKING] * len(friction), stiffness, restitution),
        local_damping=DAMPING,
    )
    run_to_rest(settling, tolerance=BALANCED, most_steps=MOST_STEPS)
    unbalanced = settling.unbalanced_ratio()
    if not unbalanced < LOOSE:
        raise InputError(
            "runout",
            f"the discs do not come to rest: they are out of balance by {unbalanced:.2g}",
            "Take another seed.",
        )
    own = placed.moving
    settled = settling.positions
    sunk = float((mass * (placed.positions - settled)[:, 1])[own].sum() / source.mass)
    shift = shift_to_centre(source, settled[own], mass[own])
    if float(np.hypot(*shift)) > FARTHEST * placed.diameter:
        raise InputError(
            "discs", f"the packing would have to be moved by {np.hypot(*shift):.3g} m for the centre of gravity",
            "Take more discs.", value=discs,
        )  # fmt: skip
    # twice, for what the first leaves to rounding
    settled = settled + shift
    rest = replace(placed, positions=settled + shift_to_centre(source, settled[own], mass[own]))
    assembly = _moving(source, rest, _assembly(source, rest, mass, friction, stiffness, restitution))
    simulation = ParticleSimulation(assembly, orientation=True)
    tangent = float(np.average([friction_tangent(own) for own in friction], weights=source.material_mass))
    take_contacts(settling, simulation)
    return HandOver(
        simulation, source, own, np.where(own, assembly.mass, 0.0), rest.surface, rest.diameter, stiffness, tangent,
        unbalanced, sunk, shift, _account(source, simulation, rest, elastic_energy(settling)),
    )  # fmt: skip


def take_contacts(before: ParticleSimulation, after: ParticleSimulation) -> None:
    """Let the contacts of discs remember what those of the same discs in another simulation do (`linear_rolling`)."""
    contacts = before.contacts()
    # of vectors a disc's contact has one component, by the name with its axis
    kept = {name.rsplit("_", 1)[0]: values for name, values in contacts.history.items()}
    after.hand_over(contacts.pairs, shear=kept["shear"], rolling=kept["rolling"])


def elastic_energy(s: ParticleSimulation) -> Floats:
    """Elastic energy (n,) [J/m] of every disc: half of that of each of its contacts."""
    contacts, a = s.contacts(), s.assembly
    first, second = contacts.pairs.T
    rows = a.material[first] * len(a.material_names) + a.material[second]
    known = {
        "overlap": np.maximum(contacts.overlap, 0.0), "radius_a": a.radii[first], "radius_b": a.radii[second],
        **contacts.history,
    }  # fmt: skip
    found = law_energy(CONTACT_LAWS[a.contact_law], a.dimension, a.contact_table[rows], known)
    count = a.particles
    both = np.bincount(first, found, minlength=count) + np.bincount(second, found, minlength=count)
    return np.asarray(0.5 * both, dtype=np.float64)


def flow_materials(names: Sequence[str]) -> list[str]:
    """Names of the materials of discs."""
    return [f"{name} (discs)" for name in names]


def _masses(source: Source, placed: Discs) -> Floats:
    """Masses (n,) [kg/m] of all discs; the rigid ground is as dense as the mean."""
    own = placed.moving
    mass = np.pi * placed.radii**2 * source.mass / source.area
    mass[own] = carried_masses(source, placed.radii[own], placed.material[own])
    return np.asarray(mass)


def _assembly(
    source: Source, placed: Discs, mass: Floats, friction: Sequence[DiscFriction], stiffness: float,
    restitution: float,
) -> Assembly:  # fmt: skip
    builder = AssemblyBuilder(2, contact_law=LAW, gravity=(0.0, -source.gravity))
    loss = -math.log(restitution)
    typical = float(mass[placed.moving].mean())
    viscosity = 2.0 * loss / math.hypot(math.pi, loss) * math.sqrt(0.5 * typical / stiffness)
    for kind, (name, own) in enumerate(zip(flow_materials(source.materials), friction, strict=True)):
        builder.add_material(
            name,
            density=1.0,
            contact={
                "normal_stiffness": stiffness,
                "shear_stiffness": SHEAR_STIFFNESS * stiffness,
                "friction_coefficient": own.sliding,
                "rolling_friction": own.rolling,
                "normal_viscosity": viscosity,
                "shear_viscosity": 0.0,  # it would act beyond the friction
            },
        )
        which = np.flatnonzero(placed.material == kind)
        if len(which):
            density = mass[which] / (np.pi * placed.radii[which] ** 2)
            builder.add_particles(placed.positions[which], placed.radii[which], name, density=density)
    order = np.argsort(placed.material, kind="stable")
    held = np.flatnonzero(~placed.moving[order])
    builder.hold(held, x=0.0, y=0.0, rotation=0.0)
    assembly = builder.build()
    # as they were placed: what is told of discs is in that order everywhere
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return replace(
        assembly, positions=placed.positions.copy(), radii=placed.radii.copy(), mass=mass.copy(),
        inertia=DISC_INERTIA * mass * placed.radii**2, material=placed.material.astype(np.int32),
        velocities=assembly.velocities[back], spins=assembly.spins[back], held=assembly.held[back],
        applied=assembly.applied[back],
    )  # fmt: skip


def _moving(source: Source, placed: Discs, assembly: Assembly) -> Assembly:
    """The assembly with the motion of the source."""
    own = placed.moving
    velocities, spins = assembly.velocities.copy(), assembly.spins.copy()
    if source.velocity.any():
        velocities[own], spin = carried_motion(
            source, assembly.positions[own], assembly.mass[own], assembly.inertia[own], placed.velocity[own],
            placed.spin[own],
        )  # fmt: skip
        spins[own, 0] = spin
    return replace(assembly, velocities=velocities, spins=spins)


def _account(source: Source, s: ParticleSimulation, placed: Discs, elastic: Floats) -> tuple[Conserved, ...]:
    """What is kept: `elastic` (n,) is the energy of every disc's share of its contacts [J/m]."""
    own, a = placed.moving, s.assembly
    mass, where, speed = a.mass[own], a.positions[own], a.velocities[own]
    total = float(mass.sum())
    centre = (mass[:, None] * where).sum(axis=0) / total
    arm = where - centre
    momentum = (mass[:, None] * speed).sum(axis=0)
    turning = float(
        (mass * (arm[:, 0] * speed[:, 1] - arm[:, 1] * speed[:, 0])).sum()
        + (a.inertia[own] * a.spins[own, 0]).sum()
    )
    kinetic = 0.5 * float(
        (mass * (speed**2).sum(axis=1)).sum() + (a.inertia[own] * a.spins[own, 0] ** 2).sum()
    )
    potential = total * source.gravity * float(centre[1] - source.datum)
    bent = float(elastic[own].sum())
    thrust = math.sqrt(2.0 * source.kinetic * source.mass)
    energy = source.energy
    by_material = np.bincount(placed.material[own], mass, minlength=len(source.materials))
    return (
        Conserved("mass", "kg/m", source.mass, total, source.mass),
        *(
            Conserved(f"mass of {name}", "kg/m", float(old), float(new), float(old))
            for name, old, new in zip(source.materials, source.material_mass, by_material, strict=True)
            if old > 0.0
        ),
        *(
            Conserved(f"centre of gravity, {axis}", "m", float(source.centre[k]), float(centre[k]), source.height)
            for k, axis in enumerate("xy")
        ),
        *(
            Conserved(f"momentum, {axis}", "kg/s", float(source.momentum[k]), float(momentum[k]), thrust)
            for k, axis in enumerate("xy")
        ),
        Conserved("angular momentum", "kg m/s", source.angular_momentum, turning, thrust * source.height),
        Conserved("potential energy", "J/m", source.potential, potential, energy),
        Conserved("kinetic energy", "J/m", source.kinetic, kinetic, energy),
        Conserved("elastic energy", "J/m", source.elastic, bent, energy),
        Conserved("energy", "J/m", energy, potential + kinetic + bent, energy),
    )  # fmt: skip
