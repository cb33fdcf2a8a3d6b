"""An undamped linear oscillator: period, energy and order of the leap-frog: `python -m reference run oscillator`.

With x = dt/dt_crit = omega dt/2 a leap-frog's motion is A cos(n theta) with sin(theta/2) = x, so its period is that of
the oscillator times x/asin(x): -0.042, -0.167, -0.674 and -4.5 % at x = 0.05, 0.1, 0.2 and 0.5.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .rows import Row, at_most, relative

Floats = NDArray[np.float64]

SHARES = (0.05, 0.1, 0.2, 0.5)
"""dt/dt_crit."""

AMPLITUDE = 1e-4  # [m]
STIFFNESS = 1e5  # [N/m]
SOURCE = "closed form: period x/asin(x), sin(omega' dt/2) = omega dt/2"


class Oscillator:
    """One freedom of a simulation: displacement and velocity, mass and stiffness."""

    def __init__(self, simulation: ParticleSimulation, mass: float, apart: float, sides: int) -> None:
        self.simulation = simulation
        self.mass, self.apart, self.sides = mass, apart, sides

    def state(self) -> tuple[float, float]:
        """Displacement [m] and velocity half a step before [m/s]."""
        x, v = self.simulation.positions[:, 0], self.simulation.velocities[:, 0]
        if self.sides == 1:
            return float(x[0]) - self.apart, float(v[0])
        return float(x[1] - x[0]) - self.apart, float(v[1] - v[0])

    def record(self, steps: int) -> tuple[Floats, Floats]:
        """Displacements and velocities after each of `steps` steps."""
        found = np.empty((steps, 2))
        for step in range(steps):
            self.simulation.run(1)
            found[step] = self.state()
        return found[:, 0], found[:, 1]


def disc_on_anchor(share: float) -> Oscillator:
    """A disc on a spring that is fixed in space."""
    builder = AssemblyBuilder(2)
    weak = {"normal_stiffness": 1.0, "shear_stiffness": 1.0, "friction_coefficient": 0.0}
    builder.add_material("m", density=2000.0, contact=weak)
    # far out, so that a place of about 1 m resolves it well
    builder.add_particles([[1.0 + 1e3 * AMPLITUDE, 0.0]], 0.05, "m")
    builder.anchor([0], (0.0, 0.0), STIFFNESS, length=1.0)
    assembly = builder.build()
    mass = float(assembly.mass[0])
    critical = 2.0 / math.sqrt(STIFFNESS / mass)
    # alone, it need not look for neighbours
    simulation = ParticleSimulation(assembly, time_step=share * critical, energy=True, buffer=1.0)
    return Oscillator(simulation, mass, 1.0, 1)


def bonded_spheres(share: float) -> Oscillator:
    """Two spheres, bonded, that swing along their line of centres."""
    # a slender bond hardly resists bending; the contact acts beside it, while pressed
    radius, factor = 0.05, 1e-3
    area = math.pi * (factor * radius) ** 2
    builder = AssemblyBuilder(3, bond_law="parallel_bond")
    weak = {"normal_stiffness": 1e-6, "shear_stiffness": 1e-6, "friction_coefficient": 0.0}
    bond = {
        "radius_factor": factor,
        "normal_stiffness": STIFFNESS / area,
        "shear_stiffness": 1e-3 * STIFFNESS / area,
        "tensile_strength": math.inf,
        "shear_strength": math.inf,
    }
    builder.add_material("m", density=2000.0, contact=weak, bond=bond)
    speed = AMPLITUDE * math.sqrt(2.0 * STIFFNESS / (2000.0 * 4.0 / 3.0 * math.pi * radius**3))
    # bonds are made at rest, so that it begins with a velocity
    builder.add_particles(
        [[0.0, 0.0, 0.0], [2.0 * radius, 0.0, 0.0]],
        radius,
        "m",
        velocity=[[-0.5 * speed, 0, 0], [0.5 * speed, 0, 0]],
    )
    builder.bond([(0, 1)])
    assembly = builder.build()
    mass = 0.5 * float(assembly.mass[0])
    critical = 2.0 / math.sqrt(STIFFNESS / mass)
    simulation = ParticleSimulation(assembly, time_step=share * critical, energy=True)
    return Oscillator(simulation, mass, 2.0 * radius, 2)


KINDS: dict[str, Callable[[float], Oscillator]] = {
    "disc on a spring": disc_on_anchor,
    "two bonded spheres": bonded_spheres,
}


def period(displacement: Floats, share: float) -> float:
    """Mean period in steps, from the first and the last rise through zero.

    Between two samples the crossing is that of a sine with the angle per step that is looked for, which is found first
    with straight lines.
    """
    before = np.flatnonzero((displacement[:-1] < 0.0) & (displacement[1:] >= 0.0))[[0, -1]]
    rises = int(((displacement[:-1] < 0.0) & (displacement[1:] >= 0.0)).sum()) - 1
    low, high = displacement[before], displacement[before + 1]
    crossing = before - low / (high - low)
    for _ in range(3):
        angle = 2.0 * math.pi * rises / (crossing[1] - crossing[0])
        crossing = before + np.arctan2(-low * math.sin(angle), high - low * math.cos(angle)) / angle
    return float(crossing[1] - crossing[0]) / rises


def swing(kind: str, share: float, *, periods: int = 30) -> list[Row]:
    """Error of the period, and the energy at half-steps and at steps."""
    started = time.perf_counter()
    oscillator = KINDS[kind](share)
    exact = math.pi / share
    steps = int(periods * exact)
    displacement, velocity = oscillator.record(steps)
    found = period(displacement, share) / exact - 1.0
    expected = share / math.asin(share) - 1.0
    # half-steps: the velocity is there, the displacement the mean of both sides
    middle = 0.5 * (displacement[1:] + displacement[:-1])
    energy = 0.5 * oscillator.mass * velocity[1:] ** 2 + 0.5 * STIFFNESS * middle**2
    ripple = float((energy.max() - energy.min()) / energy.max())
    seconds = time.perf_counter() - started
    name, source = f"P28 {kind}, dt/dt_crit {share:g}", "closed form: from 1 - x^2 to 1"
    quantity = "energy at half-steps, ripple over x^2"
    rows = [
        relative(name, "error of the period", found, expected, 1e-3, seconds, SOURCE),
        at_most(name, f"{quantity}: not above", ripple / share**2, 1.0, seconds, source),
    ]
    if share <= 0.2:
        # with fewer steps a period not every phase is seen
        rows.append(relative(name, quantity, ripple / share**2, 1.0, 1e-3, seconds, source))
    return rows


def drift(kind: str, share: float = 0.1, *, steps: int = 1_000_000) -> list[Row]:
    """Energy after many steps: that of steps (v-.v+) itself, that of half-steps by its largest value of two periods."""
    started = time.perf_counter()
    oscillator = KINDS[kind](share)
    simulation = oscillator.simulation
    window = int(2.0 * math.pi / share)

    def largest() -> float:
        displacement, velocity = oscillator.record(window)
        middle = 0.5 * (displacement[1:] + displacement[:-1])
        energy = 0.5 * oscillator.mass * velocity[1:] ** 2 + 0.5 * STIFFNESS * middle**2
        return float(energy.max())

    first = largest()
    account = simulation.energy()
    total = account.kinetic + account.elastic
    simulation.run(steps)
    account = simulation.energy()
    later = account.kinetic + account.elastic
    last = largest()
    seconds = time.perf_counter() - started
    name, source = f"P28 {kind}, {steps} steps", "a leap-frog of a linear system is a rotation"
    return [
        relative(name, "energy at steps [J]", later, total, 1e-8, seconds, source),
        relative(name, "energy at half-steps, largest [J]", last, first, 1e-3 * share**2, seconds, source),
    ]


def order(kind: str, *, periods: int = 20) -> Row:
    """Slope of the period's error over the step, both logarithmic."""
    started = time.perf_counter()
    shares = (0.025, 0.05, 0.1)
    errors = []
    for share in shares:
        displacement, _ = KINDS[kind](share).record(int(periods * math.pi / share))
        errors.append(1.0 - period(displacement, share) * share / math.pi)
    slope = float(np.polyfit(np.log(shares), np.log(errors), 1)[0])
    seconds = time.perf_counter() - started
    return relative(f"P28 {kind}", "order of the period's error", slope, 2.0, 5e-3, seconds, SOURCE)


def run() -> list[Row]:
    """All of them."""
    rows: list[Row] = []
    for kind in KINDS:
        for share in SHARES:
            rows += swing(kind, share)
        rows += [*drift(kind), order(kind)]
    return rows
