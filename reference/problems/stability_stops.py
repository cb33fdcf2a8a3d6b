"""Very little in a scene, and motions that must stop; part of `python -m reference run stability`."""

from __future__ import annotations

import math

import numpy as np

from geodem.assembly import Assembly, Servo
from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation

from .stability_scenes import RADIUS, builder_of, shaken_lattice
from .stability_trial import Clock, Trial, ending, refused, trial


def _disc(**more: tuple[float, ...]) -> AssemblyBuilder:
    build = builder_of(2, "linear_frictional", gravity=more.get("gravity"))
    build.add_particles(
        [[0.3, -0.7]], RADIUS, "grain", velocity=more.get("velocity", (0.0, 0.0)), spin=more.get("spin", 0.0)
    )
    return build


def little(steps: int = 100_000) -> list[Trial]:
    """No gravity, a single particle, none, all held, a servo that loses its specimen."""
    clock, found = Clock(), []
    simulation = ParticleSimulation(_disc(velocity=(1.0, 2.0), spin=(3.0,)).build())
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


def stops(pulls: tuple[float, ...] = (9.81, 1e6)) -> list[Trial]:
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
    for pull in pulls:
        messages.append(_message(_disc(gravity=(0.0, -pull)).build(), 10_000_000))
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


PARTS = (little, stops, kept)
