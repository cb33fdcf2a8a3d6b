"""Order of accuracy of the motion, law by law: `python -m reference run order`.

The same closed lattice, shaken by a twentieth of its overlap, is moved to one instant with eight time steps, each half
of the one before. The places of two steps following each other differ by an error that falls as the step to the power
of the order. A leap-frog has order 2 where forces depend on places alone; forces that read the velocity half a step
back (dashpots, Cundall's damping by its sign) have order 1, and mass-proportional damping in centred form has 2.
Nothing slides: where a bond acts beside a contact, which the shaking opens and closes, that contact has no friction,
since sliding at the moment of parting is of order 1.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.laws import BOND_LAWS
from geodem.particle_simulation import ParticleSimulation

from .stability_scenes import CASES, CLOSED, CONTACTS, DENSITY, LATTICES, RADIUS, noise, shaken_lattice

Floats = NDArray[np.float64]

SHARES = tuple(0.4 / 2**k for k in range(8))
"""Time steps over the critical one."""
LAST = 4
"""Errors, those of the smallest steps, whose slope is the order: a force that reads a sign has no smooth error."""
SPAN = 20.0
"""How long everything moves, over the critical step."""
BOUND = 0.15
"""Of the order: what is let for the terms of higher order."""
DAMPED = {"hooke", "hertz_history"}
"""Laws whose force holds a dashpot that is on here."""
LEAP_FROG = "a leap-frog of forces that depend on places: Verlet 1967"
LAGGING = "forces that read the velocity half a step back"


class Order(NamedTuple):
    """A measured order of accuracy; `errors` are root mean squares over the first way, by `steps` over the critical."""

    name: str
    quantity: str
    value: float
    expected: float
    error: float
    bound: float
    seconds: float
    source: str
    steps: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def good(self) -> bool:
        """Within its bound."""
        return abs(self.error) <= self.bound


Moving = Callable[[float], tuple[Floats, float]]
"""From a share of the critical step to what is compared, in one unit, and the size that errors are told over."""


def measured(name: str, moving: Moving, expected: float, source: str) -> Order:
    """The order of what moves: slope of the last errors over the step, both logarithmic."""
    started = time.perf_counter()
    found = [moving(share) for share in SHARES]
    errors = [
        math.sqrt(float(((coarse - fine) ** 2).mean())) / unit
        for (coarse, unit), (fine, _) in itertools.pairwise(found)
    ]
    order = float(np.polyfit(np.log(SHARES[-LAST - 1 : -1]), np.log(errors[-LAST:]), 1)[0])
    seconds = time.perf_counter() - started
    off = order / expected - 1.0
    return Order(
        name,
        "order of the error of places",
        order,
        expected,
        off,
        BOUND / expected,
        seconds,
        source,
        SHARES[:-1],
        tuple(errors),
    )


def lattice_motion(assembly: Assembly, **damping: float) -> Moving:
    """Places of a shaken lattice after `SPAN`; damping [1/critical step, critical steps, -] by its name."""
    plain = ParticleSimulation(assembly, energy=not damping, orientation=False).critical_time_step
    given: dict[str, Any] = dict(damping)
    if "global_damping" in given:
        given["global_damping"] /= plain
    if "stiffness_damping" in given:
        given["stiffness_damping"] *= plain
    unit = 2.0 * 0.05 * CLOSED * RADIUS

    def moving(share: float) -> tuple[Floats, float]:
        steps = round(SPAN / share)
        simulation = ParticleSimulation(assembly, energy=not damping, orientation=False, **given)
        simulation.time_step = simulation.span = SPAN * plain / steps
        simulation.run(steps)
        return simulation.positions, unit

    return moving


def spinning(share: float) -> tuple[Floats, float]:
    """Attitude of a free sphere whose axis of spin is turned by a torque, after 20 critical steps."""
    build = AssemblyBuilder(3)
    build.add_material("grain", density=DENSITY, contact=CONTACTS["linear_frictional"])
    build.add_particles([[0.0, 0.0, 0.0]], RADIUS, "grain", spin=(0.0, 0.0, 1.0))
    assembly = build.build()
    critical = ParticleSimulation(assembly).critical_time_step
    assembly.spins[:] *= 2.0 / (SPAN * critical)
    torque = float(assembly.inertia[0]) * 4.0 / (SPAN * critical) ** 2
    assembly.applied[0, 3] = torque
    steps = round(SPAN / share)
    simulation = ParticleSimulation(assembly, time_step=SPAN * critical / steps, orientation=True)
    simulation.run(steps)
    return simulation.orientations, 1.0


def frictionless(contact: str, bond: str | None) -> dict[str, float]:
    """What takes the friction out of a contact that acts beside a bond."""
    return {} if bond is None or BOND_LAWS[bond].REPLACES_CONTACT else {"friction_coefficient": 0.0}


def undamped(cases: list[tuple[str, str | None, int]]) -> list[Order]:
    """Every law of contacts and bonds."""
    found = []
    for contact, bond, dimension in cases:
        kind = list(LATTICES[dimension])[-1]
        law = bond or contact
        lagging = law in DAMPED
        found.append(
            measured(
                f"{law} {dimension}D" + (", restitution 0.9" if lagging else ""),
                lattice_motion(shaken_lattice(contact, bond, dimension, kind, **frictionless(contact, bond))),
                1.0 if lagging else 2.0,
                LAGGING if lagging else LEAP_FROG,
            )
        )
    return found


def viscous_lattice() -> Assembly:
    """The hexagonal lattice of linear contacts with dashpots in its contacts."""
    packing = lattice("hexagonal", RADIUS, cells=LATTICES[2]["hexagonal"], gap=-2.0 * CLOSED * RADIUS)

    def built(velocity: Floats, spin: Floats) -> Assembly:
        build = AssemblyBuilder(2)
        dashpots = {"normal_viscosity": 1e-5, "shear_viscosity": 1e-5}
        build.add_material("grain", density=DENSITY, contact={**CONTACTS["linear_frictional"], **dashpots})
        build.set_cell(packing.box)
        build.add_particles(packing.positions, packing.radii, "grain", velocity=velocity, spin=spin)
        return build.build()

    still = built(np.zeros((packing.particles, 2)), np.zeros((packing.particles, 1)))
    return built(*noise(still))


def damped() -> list[Order]:
    """Every kind of damping, and the turning of a sphere."""
    plain = shaken_lattice("linear_frictional", None, 2, "hexagonal")
    return [
        measured(
            "mass-proportional damping, linear 2D",
            lattice_motion(plain, global_damping=0.2),
            2.0,
            "centred form: Cundall 1988",
        ),
        measured(
            "stiffness-proportional damping, linear 2D",
            lattice_motion(plain, stiffness_damping=0.05),
            1.0,
            LAGGING,
        ),
        measured("dashpots of contacts, linear 2D", lattice_motion(viscous_lattice()), 1.0, LAGGING),
        measured(
            "Cundall's local damping 0.3, linear 2D", lattice_motion(plain, local_damping=0.3), 1.0, LAGGING
        ),
        measured("attitude of a sphere under a torque 3D", spinning, 2.0, "spin of the middle of a step"),
    ]


def run() -> list[Order]:
    """Every law, every damping."""
    return [*undamped(CASES), *damped()]
