"""DICE2D's examples of two discs: a bond in tension and in shear, its failure, and Newton's balls (1.5.3 to 1.5.7).

The discs stand above one another, the lower one is held. The bond is the book's own, of two springs.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .dice2d_motion import mechanical_energy
from .dice2d_tables import GRAVITY, RADIUS, WIDTH_RATIO, book_step, disc_mass, friction
from .rows import Row, relative

LOAD = 1e6  # of tables 1.4 and 1.5 [N]
ENOUGH = 1e15
"""A strength that nothing reaches [N]."""


def bonded_pair(
    normal: float,
    shear: float,
    *,
    strength: float = ENOUGH,
    cohesion: float = ENOUGH,
    angle: float = 0.0,
    viscosity: float = 0.0,
) -> tuple[AssemblyBuilder, range]:
    """A builder with two bonded discs, the lower one held."""
    builder = AssemblyBuilder(2, bond_law="two_springs")
    spring = {
        "normal_stiffness": normal,
        "shear_stiffness": shear,
        "friction_coefficient": friction(angle),
        "normal_viscosity": viscosity,
    }
    bond = {**spring, "tensile_strength": strength, "cohesion": cohesion, "width_ratio": WIDTH_RATIO}
    builder.add_material("disc", density=1.0, contact=spring, bond=bond)
    discs = builder.add_particles([(0.0, 0.0), (0.0, 2.0 * RADIUS)], RADIUS, "disc")
    builder.bond([discs])
    builder.hold([0], x=0.0, y=0.0, rotation=0.0)
    return builder, discs


def _simulation(
    builder: AssemblyBuilder, normal: float, shear: float, damping: float, shorter: int = 1
) -> ParticleSimulation:
    step = book_step(0.2, disc_mass(1.0), normal, shear) / shorter
    return ParticleSimulation(builder.build(), time_step=step, local_damping=damping, energy=True)


def tension(steps: int = 2000) -> list[Row]:
    """Table 1.4: u = F/k (eq. 1.57), once the dashpot has brought it to rest."""
    started = time.perf_counter()
    builder, _ = bonded_pair(1e9, 1e9, viscosity=1e-4)
    builder.apply([1], force=(0.0, LOAD))
    simulation = _simulation(builder, 1e9, 1e9, 0.0)
    simulation.run(steps)
    moved = float(simulation.positions[1, 1]) - 2.0 * RADIUS
    seconds = time.perf_counter() - started
    return [
        relative("3 bond in tension", "displacement F/kn [m]", moved, LOAD / 1e9, 1e-6, seconds),
        # the whole load comes at once, in a step of 0.4 of the period over 2 pi
        _imbalance("3 bond in tension", simulation, 1e-6, seconds),
    ]


def shear(steps: int = 6000) -> list[Row]:
    """Table 1.5: u = F/ks + F r^2/kb, with kb = kn db^2/4 the bending stiffness of the two springs.

    The load in the upper centre turns the disc by F r/kb, since the bond's shear force acts at the arm r; its
    surface slips by F/ks, and its centre is r above the contact. The shear spring adds up slips, that of the half step
    before the start too, which leaves F dt^2/10m at rest: 3e-5 at the book's step.
    """
    rows = []
    width = 2.0 * RADIUS * WIDTH_RATIO
    turned = LOAD * RADIUS / (0.25 * 500e9 * width**2)
    for label, shorter, bound in (("book's step", 1, 1e-4), ("book's step/10", 10, 1e-6)):
        started = time.perf_counter()
        builder, _ = bonded_pair(500e9, 1e9)
        builder.apply([1], force=(LOAD, 0.0))
        simulation = _simulation(builder, 500e9, 1e9, 0.8, shorter)
        simulation.run(steps * shorter)
        moved = float(simulation.positions[1, 0])
        spun = -float(simulation.orientations[1, 0])
        seconds = time.perf_counter() - started
        name = f"4 bond in shear, {label}"
        rows += [
            relative(name, "displacement [m]", moved, LOAD / 1e9 + RADIUS * turned, bound, seconds),
            relative(name, "rotation F r/kb [rad]", spun, turned, 1e-6, seconds),
            _imbalance(name, simulation, 1e-6, seconds),
        ]
    return rows


SPEED = 1e-4  # of the upper disc when it is driven [m/s]


def tension_failure(steps: int = 2000) -> list[Row]:
    """Table 1.6: the force rises to Ft at the displacement Ft/kn and is gone; all that was stored is released."""
    started = time.perf_counter()
    strength, stiffness = 2e4, 1e9
    builder, _ = bonded_pair(stiffness, 1e9, strength=strength, cohesion=ENOUGH)
    builder.hold([1], x=0.0, y=SPEED, rotation=0.0)
    simulation = _simulation(builder, stiffness, 1e9, 0.8)
    peak, largest, after = 0.0, 0.0, math.nan
    for _ in range(steps):
        simulation.run(1)
        pull = float(simulation.forces[0, 1])
        if simulation.intact()[0]:
            peak, largest = max(peak, pull), SPEED * (simulation.steps - 1) * simulation.time_step
        else:
            after = abs(pull)
    broken = simulation.broken_bonds()
    seconds = time.perf_counter() - started
    step = SPEED * simulation.time_step * stiffness / strength
    name = "5 bond torn"
    released = float(broken.energy[0])
    return [
        relative(name, "peak force Ft [N]", peak, strength, 1e-6 + step, seconds),
        relative(name, "force over displacement [N/m]", peak / largest, stiffness, 1e-6, seconds),
        relative(name, "displacement Ft/kn [m]", largest, strength / stiffness, 1e-6 + step, seconds),
        Row(name, "force afterwards [N]", after, 0.0, after / strength, 0.0, seconds),
        relative(name, "energy released Ft^2/2kn [J]", released, 0.5 * strength**2 / stiffness, 3.0 * step, seconds),
        Row(name, "breaks in tension", float(len(broken.mode)), 1.0, float(broken.mode[0] - 1), 0.0, seconds),
    ]  # fmt: skip


def shear_failure(steps: int = 2000) -> list[Row]:
    """Table 1.7: the shear force rises to Fn tan(phi) + Fc, then stays at Fn tan(phi)."""
    started = time.perf_counter()
    pressed, cohesion, stiffness = 1e5, 2e4, 1e9
    builder, _ = bonded_pair(stiffness, stiffness, strength=2e4, cohesion=cohesion, angle=10.0)
    builder.apply([1], force=(0.0, -pressed))
    builder.hold([1], x=SPEED, rotation=0.0)
    simulation = _simulation(builder, stiffness, stiffness, 0.8)
    peak = 0.0
    later: list[float] = []
    for _ in range(steps):
        simulation.run(1)
        history: dict[str, Any] = simulation.contacts().history
        if simulation.intact()[0]:
            peak = max(peak, abs(float(history[_bond_shear(history)][0])))
        else:
            later.append(abs(float(history[_contact_shear(history)][0])))
    broken = simulation.broken_bonds()
    seconds = time.perf_counter() - started
    expected = pressed * friction(10.0)
    step = stiffness * SPEED * simulation.time_step / (expected + cohesion)
    name = "6 bond sheared off"
    worst = max(later, key=lambda force: abs(force - expected))
    return [
        relative(name, "peak shear force Fn tan(phi) + Fc [N]", peak, expected + cohesion, 1e-6 + step, seconds),
        relative(name, "shear force after it, worst [N]", worst, expected, 1e-6, seconds),
        Row(name, "breaks in shear", float(len(broken.mode)), 1.0, float(broken.mode[0] - 2), 0.0, seconds),
        _imbalance(name, simulation, 1e-4, seconds),
    ]  # fmt: skip


def _bond_shear(history: dict[str, Any]) -> str:
    return next(name for name in history if name.startswith("bond.shear"))


def _contact_shear(history: dict[str, Any]) -> str:
    return next(name for name in history if name.startswith("shear"))


STRING = 100.0
"""Length of the strings [m], which the text does not give: that of the pendulum."""


def newton_balls() -> list[Row]:
    """Table 1.8: two discs on strings hit each other; energy over ten exchanges, and that all of it goes across.

    Strings are springs as stiff as the contact and bear the weight from the start. The one thrown at 30 m/s
    swings out and back first.
    """
    rows = []
    mass = disc_mass(1.0)
    book = book_step(0.5, mass, 1e7, 1e7)
    # half a period of a pendulum of this amplitude, from one exchange to the next
    amplitude = math.acos(1.0 - 30.0**2 / (2.0 * GRAVITY * STRING))
    mean = 1.0
    half = math.cos(0.5 * amplitude)
    for _ in range(6):  # arithmetic-geometric mean
        mean, half = 0.5 * (mean + half), math.sqrt(mean * half)
    swing = math.pi * math.sqrt(STRING / GRAVITY) / mean
    for label, step, bound in (("book's step", book, 0.02), ("book's step/30", book / 30.0, 1e-4)):
        started = time.perf_counter()
        builder = AssemblyBuilder(2, gravity=(0.0, -GRAVITY))
        contact = {"normal_stiffness": 1e7, "shear_stiffness": 10.0, "friction_coefficient": 0.0}
        builder.add_material("disc", density=1.0, contact=contact)
        discs = builder.add_particles(
            [(-RADIUS, 0.0), (RADIUS, 0.0)], RADIUS, "disc", velocity=[(0.0, 0.0), (30.0, 0.0)]
        )
        ends = np.array([(-RADIUS, STRING), (RADIUS, STRING)])
        builder.anchor(discs, ends, 1e7, STRING - mass * GRAVITY / 1e7)
        simulation = ParticleSimulation(builder.build(), time_step=step, energy=True, buffer=50.0)
        initial = 0.5 * mass * 30.0**2
        # after the tenth exchange the right one flies again; a quarter of a period later it is as high as ever
        simulation.run(round(10.5 * swing / step))
        found = mechanical_energy(simulation)
        seconds = time.perf_counter() - started
        height = float(simulation.positions[:, 1].max())
        name = f"7 Newton's balls, {label}"
        rows += [
            relative(name, "energy after ten exchanges [J]", found, initial, bound, seconds),
            relative(name, "height then, v^2/2g [m]", height, 30.0**2 / (2.0 * GRAVITY), 0.1, seconds),
        ]
    return rows


def _imbalance(name: str, simulation: ParticleSimulation, bound: float, seconds: float) -> Row:
    value = simulation.energy().imbalance
    return Row(name, "imbalance of the energy account", value, 0.0, value, bound, seconds)


def run() -> list[Row]:
    """All of them."""
    return [*tension(), *shear(), *tension_failure(), *shear_failure(), *newton_balls()]
