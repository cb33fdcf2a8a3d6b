"""Spheres that spin, roll and bounce on a plane or meet each other, against closed forms; used by `fewbody`.

All with the linear frictional law. Its dashpot sets the coefficient of restitution e, see `viscosity`. Springs are so
stiff that the deepest overlap is 1e-4 of the radius, because the closed forms know none.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .rows import Row, relative

IMPULSES = "impulse and angular momentum of rigid spheres"
BOUND = 5e-3

A_COLLISION = 312
"""Steps of a collision: 0.01 of the Rayleigh step takes so many for the glass spheres of Chung & Ooi's test 1."""

DEEPEST = 1e-4
"""Largest overlap over the radius."""


def viscosity(restitution: float, frequency: float) -> float:
    """eta [s] of a linear contact of undamped frequency omega [1/s] that ends where the overlap is zero.

    ln e = -pi zeta/sqrt(1 - zeta^2), zeta = eta omega/2; see Schwager & Poeschel (2007), Granular Matter 9:465-469, who
    also treat the contact that ends where the force is zero.
    """
    log = -math.log(restitution)
    return 2.0 * log / math.sqrt(math.pi**2 + log * log) / frequency


class Ball(NamedTuple):
    """A sphere, and the collisions that are asked of it."""

    radius: float  # [m]
    density: float  # [kg/m3]

    @property
    def mass(self) -> float:
        """[kg]"""
        return self.density * 4.0 / 3.0 * math.pi * self.radius**3

    def contact(self, frequency: float, restitution: float, friction: float) -> dict[str, float]:
        """Parameters between two of it, such that it meets a rigid plane (twice as stiff) at omega [1/s]."""
        normal = 0.5 * self.mass * frequency**2
        return {
            "normal_stiffness": normal,
            "shear_stiffness": 0.8 * normal,
            "friction_coefficient": friction,
            "normal_viscosity": viscosity(restitution, frequency),
        }

    def against_plane(
        self,
        velocity: tuple[float, float, float],
        *,
        spin: float = 0.0,
        restitution: float,
        friction: float = 0.092,
        finer: int = 1,
    ) -> tuple[ParticleSimulation, int]:
        """Just above the plane z = 0, spinning about y; and steps until it has surely left it."""
        down = -velocity[2]
        frequency = down / (DEEPEST * self.radius)
        step = math.pi / frequency / (A_COLLISION * finer)
        builder = AssemblyBuilder(3)
        builder.add_material(
            "ball", density=self.density, contact=self.contact(frequency, restitution, friction)
        )
        # the contact begins inside a step, as it may
        height = self.radius + 0.37 * down * step
        builder.add_particles([[0, 0, height]], self.radius, "ball", velocity=velocity, spin=(0.0, spin, 0.0))
        builder.add_wall(plane("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        # a dashpot makes a collision up to twice as long
        return ParticleSimulation(builder.build(), time_step=step), 3 * A_COLLISION * finer


BALL = Ball(radius=0.01, density=2500.0)
GRAVITY = 9.81


def slide_to_roll(speed: float = 1.0, friction: float = 0.3) -> list[Row]:
    """Let go sliding without spin, a ball ends up rolling at 5/7 of its speed, whatever the friction."""
    started = time.perf_counter()
    weight = BALL.mass * GRAVITY
    # pressed in by its weight by 1e-5 of the radius
    normal = 0.5 * weight / (1e-5 * BALL.radius)
    frequency = math.sqrt(2.0 * normal / BALL.mass)
    contact = {
        "normal_stiffness": normal,
        "shear_stiffness": 0.8 * normal,
        "friction_coefficient": friction,
        "normal_viscosity": 0.2 / frequency,
        # the shear spring swings about rolling until it is damped
        "shear_viscosity": 0.2 / frequency,
    }
    builder = AssemblyBuilder(3, gravity=(0.0, 0.0, -GRAVITY))
    builder.add_material("ball", density=BALL.density, contact=contact)
    builder.add_particles(
        [[0.0, 0.0, BALL.radius * (1.0 - 1e-5)]], BALL.radius, "ball", velocity=(speed, 0.0, 0.0)
    )
    builder.add_wall(plane("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), time_step=0.1 / frequency)
    slides = 2.0 / 7.0 * speed / (friction * GRAVITY)
    simulation.run(int(1.5 * slides / simulation.time_step))
    found = float(simulation.velocities[0, 0])
    turning = float(simulation.spins[0, 1]) * BALL.radius
    seconds = time.perf_counter() - started
    name, source = "P33 slide to roll", "angular momentum about the contact: u = 5 u0/7, omega = u/r"
    return [
        relative(name, "speed [m/s]", found, 5.0 / 7.0 * speed, BOUND, seconds, source),
        relative(name, "spin times radius [m/s]", turning, 5.0 / 7.0 * speed, BOUND, seconds, source),
    ]


def spinning_impact(speed: float = 2.0, restitution: float = 0.7, friction: float = 0.2) -> list[Row]:
    """A spinning ball falls straight down and slides all through: v_x = mu (1 + e) v, omega less 5/2 of it over r."""
    started = time.perf_counter()
    impulse = friction * (1.0 + restitution) * speed
    # it slides to the end where r omega > 7/2 mu (1 + e) v
    before = 2.0 * 3.5 * impulse / BALL.radius
    simulation, steps = BALL.against_plane(
        (0.0, 0.0, -speed), spin=before, restitution=restitution, friction=friction
    )
    simulation.run(steps)
    found, turning = float(simulation.velocities[0, 0]), float(simulation.spins[0, 1])
    seconds = time.perf_counter() - started
    name = "P33 spinning impact"
    return [
        relative(name, "speed along the plane [m/s]", found, impulse, BOUND, seconds, IMPULSES),
        relative(
            name, "spin [rad/s]", turning, before - 2.5 * impulse / BALL.radius, BOUND, seconds, IMPULSES
        ),
    ]


def bounces(restitution: float = 0.8, count: int = 4) -> list[Row]:
    """Dropped, a ball rises to h = r + e^(2k) (h0 - r) after its k-th bounce; the error is that of h - r."""
    started = time.perf_counter()
    drop = 10.0 * BALL.radius
    speed = math.sqrt(2.0 * GRAVITY * drop)
    frequency = speed / (50.0 * DEEPEST * BALL.radius)
    builder = AssemblyBuilder(3, gravity=(0.0, 0.0, -GRAVITY))
    builder.add_material("ball", density=BALL.density, contact=BALL.contact(frequency, restitution, 0.3))
    builder.add_particles([[0.0, 0.0, BALL.radius + drop]], BALL.radius, "ball")
    builder.add_wall(plane("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    step = math.pi / frequency / A_COLLISION
    simulation = ParticleSimulation(builder.build(), time_step=step, buffer=10.0 * BALL.radius)
    rows = []
    fall = speed / GRAVITY
    contact = math.pi / frequency
    apex = 0.0
    for k in range(1, count + 1):
        # down from the last apex, up to the next
        apex += fall * (restitution ** (k - 1) + restitution**k) + contact
        simulation.run(round(apex / step) - simulation.steps)
        rise = float(simulation.velocities[0, 2]) - 0.5 * GRAVITY * step
        height = float(simulation.positions[0, 2]) + 0.5 * rise**2 / GRAVITY - BALL.radius
        rows.append(
            relative(
                "P33 bounces", f"apex {k} above the first touch [m]", height, restitution ** (2 * k) * drop,
                BOUND, time.perf_counter() - started, "h = r + e^(2k) (h0 - r)",
            )
        )  # fmt: skip
    return rows


def spinning_pair(*, counter: bool, speed: float = 2.0, spin: float = 800.0) -> list[Row]:
    """Equal balls that meet head-on, spinning about an axis across the line of centres, against or with each other.

    Counter-spinning surfaces do not rub: nothing happens across the line. Spinning alike they rub all through, and each
    gets mu (1 + e) v across, as from a plane.
    """
    started = time.perf_counter()
    restitution, friction = 0.7, 0.2
    frequency = speed / (DEEPEST * BALL.radius)
    # two halves that meet in the middle: as stiff as a ball and a plane
    contact = BALL.contact(frequency, restitution, friction)
    builder = AssemblyBuilder(3)
    builder.add_material("ball", density=BALL.density, contact=contact)
    step = math.pi / frequency / A_COLLISION
    gap = 2.0 * 0.37 * speed * step
    builder.add_particles(
        [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0 * BALL.radius + gap]], BALL.radius, "ball",
        velocity=[[0.0, 0.0, speed], [0.0, 0.0, -speed]],
        spin=[[0.0, spin, 0.0], [0.0, -spin if counter else spin, 0.0]],
    )  # fmt: skip
    simulation = ParticleSimulation(builder.build(), time_step=step)
    simulation.run(3 * A_COLLISION)
    across = float(simulation.velocities[1, 0])
    turning = float(simulation.spins[0, 1])
    seconds = time.perf_counter() - started
    apart = float(simulation.velocities[1, 2])
    rows = [
        relative(
            f"P33 spheres spinning {'against each other' if counter else 'alike'}",
            "speed along the line of centres [m/s]", apart, restitution * speed, BOUND, seconds, IMPULSES,
        )
    ]  # fmt: skip
    name = rows[0].name
    impulse = friction * (1.0 + restitution) * speed
    if counter:
        rows += [
            Row(name, "speed across, over v", across, 0.0, across / speed, 1e-12, seconds, IMPULSES),
            relative(name, "spin [rad/s]", turning, spin, 1e-12, seconds, IMPULSES),
        ]
    else:
        after = spin - 2.5 * impulse / BALL.radius
        rows += [
            relative(name, "speed across [m/s]", across, impulse, BOUND, seconds, IMPULSES),
            relative(name, "spin [rad/s]", turning, after, BOUND, seconds, IMPULSES),
        ]
    return rows


def run() -> list[Row]:
    """All of them."""
    return [
        *slide_to_roll(),
        *spinning_impact(),
        *bounces(),
        *spinning_pair(counter=True),
        *spinning_pair(counter=False),
    ]
