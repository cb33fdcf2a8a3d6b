"""Energy account of runs in which everything happens that it counts: `python -m reference run energy-account`.

Kinetic and elastic energy and what friction, damping, dashpots and breaking bonds took must equal the work of walls,
driven particles, gravity and applied forces to 0.1 %, at 0.1 of the critical step.
"""

from __future__ import annotations

import math
import time

import numpy as np

from geodem.assembly import Servo
from geodem.boundaries.walls import plane, segments
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.bond_scatter import LognormalScatter
from geodem.builders.packings import lattice
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from .rows import Row, at_most, relative

SHARE = 0.1
"""Time step over the critical one."""
BOUND = 1e-3
SOURCE = "first law: the terms on both sides are counted apart"

RADIUS = 0.01  # mean [m]
CONTACT = {
    "normal_stiffness": 1e6,
    "shear_stiffness": 5e5,
    "friction_coefficient": 0.4,
    "normal_viscosity": 2e-5,
    "shear_viscosity": 2e-5,
}


def _simulation(builder: AssemblyBuilder, damping: float) -> ParticleSimulation:
    critical = ParticleSimulation(builder.build(), local_damping=damping).critical_time_step
    return ParticleSimulation(builder.build(), time_step=SHARE * critical, local_damping=damping, energy=True)


def drum(particles: int = 60) -> ParticleSimulation:
    """Discs of three sizes that avalanche in a turning drum of twelve sides."""
    rng = np.random.default_rng(28)
    builder = AssemblyBuilder(2, gravity=(0.0, -9.81))
    builder.add_material("grain", density=2500.0, contact=CONTACT)
    packing = lattice("hexagonal", 1.02 * RADIUS, cells=(24, 14))
    places = packing.positions - packing.positions.mean(axis=0)
    # the drum is filled from below, to about half
    size = 1.5 * RADIUS * math.sqrt(particles)
    inside = np.flatnonzero(np.hypot(*places.T) < size * math.cos(math.pi / 12.0) - 1.1 * RADIUS)
    lowest = np.sort(inside[np.argsort(places[inside, 1], kind="stable")[:particles]])
    radii = RADIUS * rng.choice([0.8, 0.9, 1.0], particles)
    builder.add_particles(places[lowest], radii, "grain")
    angle = np.arange(12) * math.pi / 6.0
    corners = size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    builder.add_wall(segments("drum", corners, closed=True, spin=0.1, centre=(0.0, 0.0)))
    return _simulation(builder, damping=0.05)


def block(dimension: int, steps: int) -> ParticleSimulation:
    """A bonded block, driven together along its height until it breaks, between two walls that keep up a pressure.

    The lowest particles are held, the highest driven; gravity and an applied force across act as well. `steps` shorten
    it by 5 %.
    """
    law, kind, cells = ("two_springs", "hexagonal", (8, 10)) if dimension == 2 else (
        "parallel_bond", "fcc", (3, 3, 5)
    )  # fmt: skip
    up = dimension - 1
    builder = AssemblyBuilder(dimension, bond_law=law, gravity=(0.0,) * up + (-9.81,))
    bond: dict[str, float]
    if dimension == 2:
        bond = {
            **CONTACT,
            "tensile_strength": 150.0,
            "cohesion": 300.0,
            "friction_coefficient": 0.4,
            "width_ratio": 0.8,
        }
    else:
        # the same stiffness of a bond
        area = math.pi * RADIUS**2
        bond = {
            "radius_factor": 1.0,
            "normal_stiffness": 1e6 / area,
            "shear_stiffness": 5e5 / area,
            "tensile_strength": 150.0 / area,
            "shear_strength": 300.0 / area,
        }
    builder.add_material("rock", density=2500.0, contact=CONTACT, bond=bond)
    packing = lattice(kind, RADIUS, cells=cells)
    places = packing.positions - packing.positions.min(axis=0)
    ids = builder.add_particles(places, packing.radii, "rock")
    builder.bond_within(1.01, scale=LognormalScatter(0.2, 28))
    height = float(places[:, up].max())
    # a part of the particles is held or driven, so that the work of both is counted
    low = np.flatnonzero(places[:, up] < 0.5 * RADIUS)
    high = np.flatnonzero(places[:, up] > height - 0.5 * RADIUS)
    names = "xyz"[:dimension]
    builder.hold(low, **dict.fromkeys(names, 0.0))
    critical = ParticleSimulation(builder.build(), local_damping=0.1).critical_time_step
    speed = 0.05 * height / (steps * SHARE * critical)
    builder.hold(high, **{names[up]: -speed})
    builder.apply(ids, force=(0.5,) + (0.0,) * up)
    along = np.eye(dimension)[0]
    face = float(places[:, 0].max()) + RADIUS
    # for what falls off
    builder.add_wall(plane("floor", -2.0 * RADIUS * np.eye(dimension)[up], np.eye(dimension)[up]))
    for name, point, way in (("left", -RADIUS, 1.0), ("right", face, -1.0)):
        servo = Servo(tuple(way * along), 200.0, 2.0 * speed)
        builder.add_wall(plane(name, point * along, way * along, servo=servo))
    return _simulation(builder, damping=0.1)


def cell(steps: int) -> ParticleSimulation:
    """Discs of three sizes in a periodic cell that is pressed together along x, swells along y, and shears.

    `steps` shorten it by 20 %.
    """
    packing = random_packing(2, radius=RADIUS, size_ratio=1.5, count=60, solid_fraction=0.83, seed=28)
    builder = AssemblyBuilder(2)
    builder.add_material("grain", density=2500.0, contact=CONTACT)
    builder.set_cell(packing.box)
    builder.add_particles(packing.positions, packing.radii, "grain")
    simulation = _simulation(builder, damping=0.05)
    rate = 0.2 / (steps * simulation.time_step)
    simulation.set_target_stress((math.nan, -2000.0), largest_rate=5.0 * rate)
    simulation.set_strain_rate([[-rate, rate], [0.0, math.nan]])
    return simulation


def closes(name: str, simulation: ParticleSimulation, steps: int, *, breaks: bool) -> list[Row]:
    """The account after `steps` steps, and that no term of it is idle."""
    started = time.perf_counter()
    simulation.run(steps)
    account = simulation.energy()
    seconds = time.perf_counter() - started
    supplied = account.supplied
    name = f"P28 {name}, {steps} steps"
    lost = {"friction": account.friction, "damping": account.damping, "viscous": account.viscous}
    if breaks:
        lost["broken"] = account.broken
    given = (
        {"cell": account.cell} if simulation.cell else {"walls": account.walls, "gravity": account.gravity}
    )
    if breaks:
        given |= {"applied": account.applied, "driven": account.driven}
    idle = min(map(abs, [*lost.values(), *given.values()])) / supplied
    rows = [
        relative(name, "found over supplied [J]", account.found, supplied, BOUND, seconds, SOURCE),
        at_most(
            name, "least of the terms over supplied: not below", 1e-4 / idle, 1.0, seconds, "no term is idle"
        ),
    ]
    if breaks:
        broken = float((~simulation.intact()).mean())
        rows.append(
            at_most(name, "share of bonds broken: not below", 0.05 / broken, 1.0, seconds, "it breaks")
        )
    return rows


def run(steps: int = 1_000_000) -> list[Row]:
    """A million steps of each."""
    return [
        *closes("drum of discs", drum(), steps, breaks=False),
        *closes("discs in a periodic cell", cell(steps), steps, breaks=False),
        *closes("block of bonded discs", block(2, steps), steps, breaks=True),
        *closes("block of bonded spheres", block(3, steps), steps, breaks=True),
    ]
