"""Long rest of packs, and bodies that turn as a whole; part of `python -m reference run stability`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geodem.boundaries.walls import plane
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .stability_scenes import BESIDE, RADIUS, builder_of
from .stability_trial import Clock, Trial, ending, trial

Floats = NDArray[np.float64]

MILLION = 1_000_000
SETTLING = 20_000
CREEP = 1e-6
"""Way of the mean particle over its radius, at rest and damped."""
HEAT = 1e-12
"""Kinetic energy over the weight of all times a radius, at rest and damped."""
PACKS = ((2, "linear_frictional"), (3, "linear_frictional"))
"""Dimension and contact law of the packs at rest."""
BODIES = (("two_springs", 2), ("rock", 2), ("rock", 3), ("parallel_bond", 3))
"""Bond law and dimension of the bodies that turn."""
UNSTRESSED = 1e-8
"""Strain by shear of a body that is turned as a whole: force over stiffness and diameter [-]."""


def pack(dimension: int, law: str) -> ParticleSimulation:
    """Grains that have come to rest on a floor between two walls."""
    gravity = (0.0,) * (dimension - 1) + (-9.81,)
    build = builder_of(dimension, law, gravity=gravity)
    cells = (6, 3) if dimension == 2 else (2, 2, 2)
    packing = lattice("hexagonal" if dimension == 2 else "fcc", 1.01 * RADIUS, cells=cells)
    places = packing.positions - packing.positions.min(axis=0) + RADIUS
    rng = np.random.default_rng(8)
    build.add_particles(places, RADIUS * rng.uniform(0.8, 1.0, len(places)), "grain")
    size = places.max(axis=0) + RADIUS
    axes = np.eye(dimension)
    build.add_wall(plane("floor", np.zeros(dimension), axes[-1]))
    for axis in range(dimension - 1):
        build.add_wall(plane(f"low {axis}", np.zeros(dimension), axes[axis]))
        build.add_wall(plane(f"high {axis}", size * axes[axis], -axes[axis]))
    simulation = ParticleSimulation(build.build(), local_damping=0.7, orientation=False)
    simulation.run(SETTLING)
    find_equilibrium(simulation, tolerance=1e-9, most_steps=SETTLING)
    simulation.run(SETTLING)
    return simulation


def rest(steps: int = MILLION, packs: Sequence[tuple[int, str]] = PACKS) -> list[Trial]:
    """Creep and heat of packs at rest."""
    clock, found = Clock(), []
    for dimension, law in packs:
        simulation = pack(dimension, law)
        start = simulation.positions
        weight = float(simulation.assembly.mass.sum()) * 9.81 * RADIUS
        worst = 0.0
        for _ in range(10):
            simulation.run(steps // 10)
            worst = max(worst, simulation.kinetic_energy() / weight)
        moved = np.sqrt(((simulation.positions - start) ** 2).sum(axis=1)) / RADIUS
        name = f"rest of {len(start)} grains, {law} {dimension}D, local damping 0.7, {steps} steps"
        seen = f"the farthest {moved.max():.1e}, that is {moved.mean() / steps:.1e} of a radius a step"
        found += [
            trial(
                name,
                "way of the mean particle over its radius",
                float(moved.mean()),
                CREEP,
                1,
                clock.read(),
                "rest",
                seen,
            ),
            trial(name, "kinetic energy over the weight times a radius", worst, HEAT, 1, 0.0, "rest"),
        ]
    return found


def turned(bond: str, dimension: int, turns: int, steps_a_turn: int) -> float:
    """Largest shear strain of bonds whose particles are led round in a circle as one rigid body."""
    contact = BESIDE.get(bond, "effective_modulus")
    build = builder_of(dimension, contact, bond)
    cells = (3, 2) if dimension == 2 else (2, 1, 1)
    places = lattice("hexagonal" if dimension == 2 else "fcc", RADIUS, cells=cells).positions
    places = places - places.mean(axis=0)
    ids = build.add_particles(places, RADIUS, "grain")
    build.bond_within(1.01)
    build.hold(ids, **dict.fromkeys("xyz"[:dimension], 0.0), rotation=0.0)
    simulation = ParticleSimulation(build.build(), time_step=1e-6, orientation=False)
    axis = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0) if dimension == 3 else np.array([0.0, 0.0, 1.0])
    angle = 2.0 * math.pi / steps_a_turn
    rows = simulation.arrays.ids
    at = np.zeros((len(places), 3))
    at[:, :dimension] = places
    before = places
    for step in range(1, turns * steps_a_turn + 1):
        present = _rotated(at, axis, step * angle)[:, :dimension]
        # the laws are asked where particles are now, with the velocities that brought them there
        for row in simulation.rows:
            row[:, :dimension] = present[rows]
            row[:, simulation.columns.velocity] = (present - before)[rows] / simulation.time_step
            row[:, simulation.columns.spin] = (
                (axis if dimension == 3 else axis[2:]) * angle / simulation.time_step
            )
        simulation.run(1)
        before = present
    _, shear = simulation.contact_forces()
    stiffness = 5e6 if contact == "linear_frictional" else 1e9 * RADIUS
    return float(np.sqrt((shear**2).sum(axis=1)).max()) / stiffness / (2.0 * RADIUS)


def _rotated(places: Floats, axis: Floats, angle: float) -> Floats:
    """Rodrigues' formula."""
    along = (places @ axis)[:, None] * axis
    across = places - along
    return np.asarray(along + math.cos(angle) * across + math.sin(angle) * np.cross(axis, places))


def rotation(
    turns: int = 10, finest: int = 10_000, bodies: Sequence[tuple[str, int]] = BODIES
) -> list[Trial]:
    """Bonded bodies through many turns."""
    clock, found = Clock(), []
    for bond, dimension in bodies:
        with ending() as stopped:
            strain = turned(bond, dimension, turns, finest)
            coarse = turned(bond, dimension, turns, finest // 10)
        found.append(
            trial(
                f"a bonded body led through {turns} turns, {finest} steps each, {bond} {dimension}D",
                "largest shear strain of its bonds",
                math.inf if stopped.message else strain,
                UNSTRESSED,
                turns,
                clock.read(),
                "rigid motion strains nothing",
                f"with a tenth of the steps {coarse:.1e}",
            )
        )
    return found


PARTS = (rest, rotation)
