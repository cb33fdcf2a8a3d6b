"""Contrasts, overlaps at the start, chains of bounces, by energy; part of `python -m reference run stability`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geodem.boundaries.walls import box, plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation

from .fewbody_motion import viscosity
from .stability_scenes import CONTACTS, DENSITY, RADIUS, builder_of
from .stability_trial import Clock, Trial, ending, refused, trial

Floats = NDArray[np.float64]

SHARE = 0.1
"""Time step over the critical one."""
RATIOS = (1.0, 1e2, 1e4, 1e6)
DENSITIES = (1.0, 1e2, 1e4)
SIZES = (1.0, 10.0, 100.0)
CLOSES = 0.01
"""Largest imbalance of an energy account at that share [-]."""
FIRST_LAW = "first law: the terms on both sides are counted apart"
WARM = 0.02
"""Depth that the mean particle is pressed in by its own energy, over its radius."""


def gas(
    dimension: int, *, stiffness: float = 1.0, density: float = 1.0, energy: bool = True, size: float = 1.0
) -> ParticleSimulation:
    """Two sorts of grains, by a ratio each softer, denser or larger than the other, of equal energies, in a box."""
    build = AssemblyBuilder(dimension)
    spring = CONTACTS["linear_frictional"]
    build.add_material("hard", density=DENSITY, contact=spring)
    soft = {name: spring[name] / stiffness for name in ("normal_stiffness", "shear_stiffness")}
    build.add_material("soft", density=DENSITY * density, contact={**spring, **soft})
    if size > 1.0:
        places, big = _around_a_big_one(dimension, size)
        radii, sort = np.full(len(places), RADIUS), np.zeros(len(places), dtype=bool)
        radii[0], sort[0] = big, True
    else:
        cells = (6, 6) if dimension == 2 else (3, 3, 4)
        places = lattice(
            "square" if dimension == 2 else "simple_cubic", RADIUS, cells=cells, gap=2e-3 * RADIUS
        ).positions
        radii = np.full(len(places), RADIUS)
        sort = np.arange(len(places)) % 2 == 1
    mass = DENSITY * (np.pi * radii**2 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3)
    mass = np.where(sort, density, 1.0) * mass
    softest = spring["normal_stiffness"] / stiffness
    direction = np.random.default_rng(8).normal(size=places.shape)
    direction /= np.sqrt((direction**2).sum(axis=1))[:, None]
    speed = WARM * RADIUS * np.sqrt(softest / mass)
    velocity = speed[:, None] * direction
    for k, name in ((False, "hard"), (True, "soft")):
        if (sort == k).any():
            build.add_particles(places[sort == k], radii[sort == k], name, velocity=velocity[sort == k])
    low = (places - radii[:, None]).min(axis=0) - 1e-3 * RADIUS
    high = (places + radii[:, None]).max(axis=0) + 1e-3 * RADIUS
    build.add_wall(box("box", low, high))
    return _with_share(build, SHARE, energy=energy)


def _around_a_big_one(dimension: int, size: float) -> tuple[Floats, float]:
    """A particle `size` times as large as forty small ones around it; the large one first."""
    count, big = 40, size * RADIUS
    k = np.arange(count)
    if dimension == 2:
        # side by side, as many as there is room for
        angle = k * min(2.0 * math.pi / count, 2.2 / (size + 1.0))
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    else:
        height = 1.0 - (2.0 * k + 1.0) / count
        angle = k * math.pi * (3.0 - math.sqrt(5.0))
        ring = np.sqrt(1.0 - height**2)
        unit = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
    unit = unit if size >= 10.0 else unit[:6]
    return np.concatenate([np.zeros((1, dimension)), (big + 1.002 * RADIUS) * unit]), big


def _with_share(build: AssemblyBuilder, share: float, *, energy: bool = True) -> ParticleSimulation:
    assembly = build.build()
    critical = ParticleSimulation(assembly, orientation=False, energy=energy).critical_time_step
    return ParticleSimulation(assembly, time_step=share * critical, energy=energy, orientation=False)


def contrasts(steps: int = 20_000) -> list[Trial]:
    """Ratios of stiffness, density and size, in 2D and 3D."""
    clock, found = Clock(), []
    kinds: list[tuple[Callable[[int, float], ParticleSimulation], str, tuple[float, ...]]] = [
        (lambda d, ratio: gas(d, stiffness=ratio), "stiffness ratios to 1e6", RATIOS),
        (lambda d, ratio: gas(d, density=ratio), "density ratios to 1e4", DENSITIES),
        (lambda d, ratio: gas(d, size=ratio), "size ratios to 100", SIZES),
    ]
    for made, title, ratios in kinds:
        for dimension in (2, 3):
            worst, met = 0.0, 0
            for ratio in ratios:
                with ending() as stopped:
                    simulation = made(dimension, ratio)
                    simulation.run(steps)
                    worst = max(worst, abs(simulation.energy().imbalance))
                    met += int(simulation.energy().friction > 0.0)
                if stopped.message is not None:
                    worst = math.inf
            found.append(
                trial(
                    f"{title}, {dimension}D",
                    f"largest imbalance of the energy account after {steps} steps",
                    worst,
                    CLOSES,
                    len(ratios),
                    clock.read(),
                    FIRST_LAW,
                    f"grains slid on each other in {met} of {len(ratios)}",
                )
            )
    return found


def overlapping(share: float, dimension: int, law: str, depth: float = 0.5) -> float:
    """Kinetic energy of two grains that began in each other by a part of their radius, over what was stored."""
    build = builder_of(dimension, law)
    apart = np.zeros((2, dimension))
    apart[1, 0] = (2.0 - depth) * RADIUS
    build.add_particles(apart, RADIUS, "grain")
    simulation = _with_share(build, share)
    simulation.run(1)
    stored = simulation.energy().elastic
    simulation.run(int(10.0 / share))
    return simulation.kinetic_energy() / stored


def overlaps(steps: int = 5000) -> list[Trial]:
    """Grains created in one another."""
    clock, found = Clock(), []
    for share in (0.1, 0.5):
        most = 1.0 / (1.0 - share**2)
        given = [
            overlapping(share, d, law)
            for law, d in (("linear_frictional", 2), ("linear_frictional", 3), ("hertz_mindlin", 3))
        ]
        found.append(
            trial(
                f"two grains created half a radius in one another, {share:g} of critical",
                "energy of flight over what was stored",
                max(given),
                1.02 * most,
                len(given),
                clock.read(),
                "closed form: at most 1/(1 - x^2), and 2 % for the step in which they part",
                f"least {min(given):.4f}",
            )
        )
    worst = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        build = builder_of(2, "linear_frictional")
        places = lattice("square", RADIUS, cells=(6, 6), gap=-0.45 * RADIUS).positions
        build.add_particles(places + rng.uniform(-0.015, 0.015, places.shape) * RADIUS, RADIUS, "grain")
        low, high = places.min(axis=0) - 1.1 * RADIUS, places.max(axis=0) + 1.1 * RADIUS
        build.add_wall(box("box", low - 10.0 * RADIUS, high + 10.0 * RADIUS))
        simulation = _with_share(build, SHARE)
        simulation.run(steps)
        worst.append(abs(simulation.energy().imbalance))
    found.append(
        trial(
            "36 discs created half a radius in one another",
            f"largest imbalance of the energy account after {steps} steps",
            max(worst),
            CLOSES,
            len(worst),
            clock.read(),
            FIRST_LAW,
        )
    )
    messages = []
    for dimension in (2, 3):
        for depth in (0.6, 1.0, 1.9):
            with ending() as stopped:
                overlapping(SHARE, dimension, "linear_frictional", depth)
            messages.append(stopped.message)
    found.append(
        refused(
            "grains created 0.6 to 1.9 radii in one another",
            "refused",
            messages,
            ["particle", "0"],
            clock.read(),
        )
    )
    return found


def bounces(restitution: float, count: int, share: float) -> float:
    """Speed of a ball after `count` bounces between two planes, over the closed form's."""
    mass = DENSITY * math.pi * RADIUS**2
    stiffness = 2.0 * CONTACTS["linear_frictional"]["normal_stiffness"]
    frequency = math.sqrt(stiffness / mass)
    build = builder_of(2, "linear_frictional", normal_viscosity=viscosity(restitution, frequency))
    speed = 1e-3 * RADIUS * frequency
    build.add_particles([[0.0, 0.0]], RADIUS, "grain", velocity=(speed, 0.0))
    build.add_wall(plane("left", (-1.0001 * RADIUS, 0.0), (1.0, 0.0)))
    build.add_wall(plane("right", (1.0001 * RADIUS, 0.0), (-1.0, 0.0)))
    simulation = _with_share(build, share)
    met, before = 0, 1.0
    while met < count:
        simulation.run(1)
        now = float(simulation.velocities[0, 0])
        free = simulation.contact_count() == 0
        if free and now * before < 0.0:
            met, before = met + 1, now
        if simulation.steps > 10_000_000:
            return math.nan
    return abs(now) / (speed * restitution**count)


def cradle(balls: int, share: float) -> tuple[float, float]:
    """Momentum and energy of a row of touching balls after one has struck it, over those before."""
    build = builder_of(2, "linear_frictional")
    places = np.zeros((balls, 2))
    places[:, 0] = 2.0 * RADIUS * np.arange(balls)
    places[0, 0] -= 1e-3 * RADIUS
    velocity = np.zeros((balls, 2))
    velocity[0, 0] = 0.1
    build.add_particles(places, RADIUS, "grain", velocity=velocity)
    simulation = _with_share(build, share)
    simulation.run(int(100.0 * balls / share))
    return float(simulation.velocities[:, 0].sum()) / 0.1, float((simulation.velocities**2).sum()) / 0.01


def chains() -> list[Trial]:
    """Restitution over many bounces, a stroke through a row."""
    clock = Clock()
    given: list[tuple[float, int]] = [(0.9, 20), (0.5, 10), (0.2, 5)]
    off = [abs(bounces(restitution, count, 0.02) - 1.0) for restitution, count in given]
    struck = [cradle(balls, share) for balls in (2, 5, 20) for share in (0.1, 0.5)]
    return [
        trial(
            "chains of 5 to 20 bounces, restitution 0.2 to 0.9, 0.02 of critical",
            "largest error of the last speed",
            max(off),
            0.05,
            len(off),
            0.5 * clock.read(),
            "closed form: e^n of a dashpot, Schwager & Poeschel 2007; within half a per cent a bounce",
        ),
        trial(
            "a stroke through rows of 2 to 20 discs",
            "largest error of the momentum",
            max(abs(momentum - 1.0) for momentum, _ in struck),
            1e-12,
            len(struck),
            clock.read(),
            "action is reaction",
        ),
        trial(
            "a stroke through rows of 2 to 20 discs",
            "largest energy over that of the stroke",
            max(energy for _, energy in struck),
            1.02 / (1.0 - 0.25),
            len(struck),
            0.0,
            "closed form: at most 1/(1 - x^2) at 0.5 of critical, and 2 %",
        ),
    ]


PARTS: tuple[Callable[[], list[Trial]], ...] = (contrasts, overlaps, chains)
