"""What must be stopped with a message, or stay in bounds all the same; part of `python -m reference run stability`."""

from __future__ import annotations

import math

import numpy as np

from geodem.boundaries.walls import plane, segments, triangles
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation

from .stability_scenes import (
    BESIDE,
    BONDS,
    CONTACTS,
    DENSITY,
    LATTICES,
    RADIUS,
    weak,
)
from .stability_trial import Clock, Trial, ending, trial

SPEEDS = tuple(10.0 ** np.arange(-2.0, 4.5, 0.5))
"""Of a grain that strikes, over its radius by half the critical step of the scene."""
TARGETS = ("plane 2D", "plane 3D", "segment 2D", "triangle 3D", "held disc", "held sphere")


def strike(target: str, speed: float, *, heavy: bool) -> tuple[float, str | None]:
    """A grain that flies at a wall or a held grain, and the message; `heavy`: a light grain elsewhere sets the step.

    Returns what is left of the way on its own side, or negative where it went through, and energy over the first.
    """
    dimension = 3 if target.endswith(("3D", "sphere")) else 2
    build = AssemblyBuilder(dimension)
    build.add_material("grain", density=DENSITY, contact=CONTACTS["linear_frictional"])
    up = np.eye(dimension)[-1]
    if target.startswith("plane"):
        build.add_wall(plane("floor", 0.0 * up, up))
    elif target.startswith("segment"):
        build.add_wall(segments("floor", [(-1.0, 0.0), (1.0, 0.0)]))
    elif target.startswith("triangle"):
        build.add_wall(triangles("floor", np.array([[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]])))
    else:
        build.hold(
            build.add_particles([-RADIUS * up], RADIUS, "grain"),
            **dict.fromkeys("xyz"[:dimension], 0.0),
            rotation=0.0,
        )
    dense = 1e4 * DENSITY if heavy else DENSITY
    ids = build.add_particles([1.2 * RADIUS * up], RADIUS, "grain", density=dense)
    if heavy:
        aside = 0.5 * np.eye(dimension)[0] + 1.2 * RADIUS * up
        build.add_particles([aside], RADIUS, "grain")
    step = 0.5 * ParticleSimulation(build.build()).critical_time_step
    flying = build.build()
    flying.velocities[ids[0]] = -speed * RADIUS / step * up
    simulation = ParticleSimulation(flying, time_step=step)
    most = int(min(3.0 / speed + 20.0 * (100.0 if heavy else 1.0), 5e4)) + 20
    with ending() as stopped:
        for _ in range(20):
            simulation.run(most // 20 + 1)
            if simulation.velocities[ids[0], -1] > 0.0 and simulation.positions[ids[0], -1] > RADIUS:
                break
    if stopped.message is not None:
        return math.nan, stopped.message
    first = (speed * RADIUS / step) ** 2
    return float((simulation.velocities[ids[0]] ** 2).sum()) / first * np.sign(
        simulation.positions[ids[0], -1]
    ), None


def tunnelling(speeds: tuple[float, ...] = SPEEDS) -> list[Trial]:
    """Fast grains: thrown back, or stopped with a message; never through."""
    clock, through, most, stops, count, shown = Clock(), 0, 0.0, 0, 0, ""
    for target in TARGETS:
        for heavy in (False, True):
            for speed in speeds:
                energy, message = strike(target, speed, heavy=heavy)
                count += 1
                if message is not None:
                    stops += 1
                    shown = shown or message
                    through += int("particle" not in message or "step" not in message)
                elif energy <= 0.0:
                    through += 1
                else:
                    most = max(most, energy)
    name = "a grain that flies at walls and held grains, 0.01 to 3e4 radii a step, up to 1e4 times as dense"
    return [
        trial(
            name,
            "passed through without a message that names particle and step",
            through,
            0.0,
            count,
            clock.read(),
            "what is passed through is not stopped by anything",
            f"{stops} of {count} stopped: {shown.split(':')[0]}",
        ),
        trial(
            name,
            "energy thrown back, over the first",
            most,
            1.0 / (1.0 - 0.25) * 1.02,
            count - stops,
            0.0,
            "closed form: at most 1/(1 - x^2) at 0.5 of critical, and 2 % for the step in which they part",
        ),
    ]


def sheared_bonds(bonds: tuple[str, ...] = tuple(BONDS), steps: int = 500) -> list[Trial]:
    """Bonds of every law that are sheared at a thousand times their strength in one step."""
    from geodem.laws import BOND_LAWS

    clock, found = Clock(), []
    for bond in bonds:
        contact = BESIDE.get(bond, "effective_modulus")
        for dimension in BOND_LAWS[bond].DIMENSIONS:
            if dimension == 2 and contact == "hertz":
                continue
            kind = next(iter(LATTICES[dimension]))
            packing = lattice(kind, RADIUS, cells=LATTICES[dimension][kind])
            build = AssemblyBuilder(dimension, contact, bond)
            build.add_material("grain", density=DENSITY, contact=CONTACTS[contact], bond=weak(bond))
            build.set_cell(packing.box)
            build.add_particles(packing.positions, RADIUS, "grain")
            pairs = build.bond_within(1.01)
            assembly = build.build()
            step = 0.1 * ParticleSimulation(assembly, energy=True, orientation=False).critical_time_step
            # rows of grains go to and fro, so that every bond across is sheared
            row = np.round(packing.positions[:, -1] / (2.0 * RADIUS)).astype(int) % 2
            assembly.velocities[:, 0] = np.where(row == 0, 1.0, -1.0) * 0.0105 * RADIUS / step
            simulation = ParticleSimulation(assembly, energy=True, orientation=False, time_step=step)
            across = row[pairs[:, 0]] != row[pairs[:, 1]]
            with ending() as stopped:
                simulation.run(3)
                held = float(simulation.intact()[across].mean())
                simulation.run(steps)
                account = simulation.energy()
            worst = math.inf if stopped.message else (account.kinetic + account.elastic) / account.supplied
            source = "first law: nothing supplies energy"
            name = f"bonds sheared at 1000 times their strength in a step, {bond} {dimension}D"
            seen = f"{100.0 * (1.0 - held):.0f} % of them broken after 3 steps, imbalance {account.imbalance:.2g}"
            found += [
                trial(
                    name,
                    f"energy after {steps} steps over the first",
                    worst,
                    1.01,
                    int(across.sum()),
                    clock.read(),
                    source,
                    seen,
                ),
                trial(
                    name,
                    "share of them that holds after 3 steps",
                    held,
                    0.0,
                    int(across.sum()),
                    0.0,
                    "it is beyond its strength",
                ),
            ]
    return found


PARTS = (tunnelling, sheared_bonds)
