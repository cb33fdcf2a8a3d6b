"""What must be stopped with a message, or stay in bounds all the same; part of `python -m reference run stability`."""

from __future__ import annotations

import math

import numpy as np

from geodem.assembly import Assembly, Servo
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
    builder_of,
    shaken_lattice,
    weak,
)
from .stability_trial import Clock, Trial, ending, refused, trial

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


def _disc(**more: tuple[float, ...]) -> AssemblyBuilder:
    build = builder_of(2, "linear_frictional", gravity=more.get("gravity"))
    build.add_particles(
        [[0.3, -0.7]], RADIUS, "grain", velocity=more.get("velocity", (0.0, 0.0)), spin=more.get("spin", 0.0)
    )
    return build


def little() -> list[Trial]:
    """No gravity, a single particle, none, all held, a servo that loses its specimen."""
    clock, found = Clock(), []
    simulation = ParticleSimulation(_disc(velocity=(1.0, 2.0), spin=(3.0,)).build())
    steps = 100_000
    simulation.run(steps)
    # the first velocity is half a step after the start, as far as free flight can tell
    way = np.hypot(*(simulation.positions[0] - (0.3, -0.7))) / (math.hypot(1.0, 2.0) * simulation.time)
    turned = simulation.orientations[0, 0] / (3.0 * simulation.time)
    found.append(
        trial(
            "a single disc without gravity",
            f"error of its way and turn after {steps} steps",
            max(abs(way - 1.0), abs(turned - 1.0)),
            1e-10,
            1,
            clock.read(),
            "straight on; 1e-10 for 1e5 roundings",
        )
    )
    with ending() as stopped:
        AssemblyBuilder(2).build()
    found.append(refused("no particles", "refused", [stopped.message], ["no particle"], clock.read()))
    build = builder_of(2, "linear_frictional", gravity=(0.0, -9.81))
    places = lattice("hexagonal", RADIUS, cells=(4, 3), gap=-1e-3 * RADIUS).positions
    build.hold(build.add_particles(places, RADIUS, "grain"), x=0.0, y=0.0, rotation=0.0)
    with ending() as stopped:
        ParticleSimulation(build.build())
    found.append(
        refused(
            "all particles held, no time step given",
            "refused",
            [stopped.message],
            ["time_step"],
            clock.read(),
        )
    )
    simulation = ParticleSimulation(build.build(), time_step=1e-5)
    simulation.run(10_000)
    moved = float(np.abs(simulation.positions - places).max())
    found.append(
        trial("all particles held", "way of any in 10,000 steps [m]", moved, 0.0, 1, clock.read(), "held")
    )
    build = builder_of(2, "linear_frictional")
    build.add_particles(
        [[0.0, RADIUS * (2 * k + 1)] for k in range(3)], RADIUS, "grain", velocity=(0.0, -1e-3)
    )
    limit = 0.01
    servo = Servo((0.0, -1.0), 10.0, limit)
    build.add_wall(plane("press", (0.0, 6.0 * RADIUS), (0.0, -1.0), servo=servo))
    build.apply([0, 1, 2], force=(1.0, 0.0))
    simulation = ParticleSimulation(build.build())
    fastest = 0.0
    for _ in range(50):
        simulation.run(100)
        fastest = max(fastest, _wall_speed(simulation))
    found.append(
        trial(
            "a servo that loses its specimen",
            "speed of its wall over its limit",
            fastest / limit,
            1.0 + 1e-9,
            1,
            clock.read(),
            "the limit that it is given",
        )
    )
    return found


def _wall_speed(simulation: ParticleSimulation) -> float:
    before = simulation.walls.displacements()[0].copy()
    start = simulation.time
    simulation.run(1)
    return float(np.hypot(*(simulation.walls.displacements()[0] - before))) / (simulation.time - start)


def _message(
    assembly: Assembly, steps: int, *, number: float | None = None, energy: bool = False, share: float = 0.0
) -> str | None:
    """What stops a motion into which a number is put, or whose step is forced."""
    simulation = ParticleSimulation(assembly, energy=energy, orientation=False)
    if share:
        simulation.time_step = simulation.span = share * simulation.critical_time_step
    with ending() as stopped:
        simulation.run(100)
        if number is not None:
            simulation.rows[:, 5, simulation.columns.velocity.start] = number
        simulation.run(steps)
    return stopped.message


def stops() -> list[Trial]:
    """Numbers that are none, steps that are forced, particles that leave."""
    clock, found = Clock(), []
    bonded = shaken_lattice("effective_modulus", "rock", 2, "hexagonal")
    loose = shaken_lattice("linear_frictional", None, 2, "hexagonal")
    wanted = ["step", "particle", "last_good"]
    numbers = [math.nan, math.inf, -math.inf, 1e300]
    messages = [
        _message(assembly, 20_000, number=number, energy=True)
        for assembly in (bonded, loose)
        for number in numbers
    ]
    found.append(
        refused("velocities that are no numbers, or 1e300", "stopped", messages, wanted, clock.read())
    )
    messages = [
        _message(bonded, 20_000, share=share, energy=e)
        for share in (1.02, 1.05, 1.2, 1.5, 3.0)
        for e in (True, False)
    ]
    found.append(
        refused("1.02 to 3 times the critical step forced, bonded", "stopped", messages, wanted, clock.read())
    )
    messages = []
    for force in (1e8, 1e12, 1e100, 1e300):
        build = builder_of(2, "effective_modulus", "rock")
        build.add_particles([[0.0, 0.0], [2.0 * RADIUS, 0.0]], RADIUS, "grain")
        build.bond([(0, 1)])
        build.apply([0], force=(force, 0.0))
        messages.append(_message(build.build(), 100_000))
    found.append(
        refused("a load of 1e8 to 1e300 N on a grain of 0.8 kg", "stopped", messages, wanted, clock.read())
    )
    messages = []
    for gravity in ((0.0, -9.81), (0.0, -1e6)):
        messages.append(_message(_disc(gravity=gravity).build(), 10_000_000))
    found.append(
        refused("a grain that falls and is never stopped", "stopped", messages, wanted, clock.read())
    )
    return found


def kept() -> list[Trial]:
    """The last good state goes on as the motion itself did."""
    clock = Clock()
    assembly = shaken_lattice("effective_modulus", "rock", 2, "hexagonal")
    differ, ways = 0.0, []
    for broken_at in (3_000, 45_000):
        one, other = (ParticleSimulation(assembly, energy=True, orientation=False) for _ in range(2))
        other.run(broken_at)
        one.run(broken_at)
        one.rows[:, 3, one.columns.velocity.start] = math.nan
        with ending():
            one.run(50_000)
        again = one.last_good()
        ways.append(broken_at - again.steps)
        again.run(broken_at - again.steps)
        differ += float(not np.array_equal(again.now, other.now))
    return [
        trial(
            "the last good state after a stop, run on",
            "states that differ in a bit from the motion itself",
            differ,
            0.0,
            len(ways),
            clock.read(),
            "same input, same bits",
            f"states of {' and '.join(map(str, ways))} steps before",
        )
    ]


PARTS = (tunnelling, sheared_bonds, little, stops, kept)
