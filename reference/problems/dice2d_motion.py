"""DICE2D's examples of one disc: falling, swinging, bouncing, sliding, rolling (1.5.1, 1.5.2, 1.5.8 to 1.5.10).

Each is held to its closed form. Where the book's springs or its time step leave a difference that is not the
scheme's, a second row takes stiffer springs or a shorter step, and the first has a bound of its own.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .dice2d_tables import GRAVITY, RADIUS, book_step, disc_mass, friction
from .rows import Row, relative

Floats = NDArray[np.float64]

LENGTH = 100.0  # of the pendulum [m]


def one_disc(
    density: float, stiffness: float, *, viscosity: float = 0.0, shear: bool = False
) -> AssemblyBuilder:
    """A builder with the material "disc", without friction.

    Walls that have some need shear springs; ks = kn then. Without friction ks plays no part, yet counts in the
    critical time step, so that the book's step of the bouncing disc would be refused: then ks is next to nothing.
    """
    builder = AssemblyBuilder(2, gravity=(0.0, -GRAVITY))
    contact = {
        "normal_stiffness": stiffness,
        "shear_stiffness": stiffness if shear else 1e-6 * stiffness,
        "friction_coefficient": 0.0,
        "normal_viscosity": viscosity,
    }
    builder.add_material("disc", density=density, contact=contact)
    return builder


def falling(steps: int = 20_000) -> list[Row]:
    """Table 1.2: y = -g t^2/2 (eq. 1.55).

    With velocities that start half a step back a leap-frog is exact under constant acceleration at any step, so there
    is no order to measure; what remains is rounding.
    """
    started = time.perf_counter()
    book = book_step(0.2, disc_mass(1.0), 1e9, 1e9)
    rows = []
    for times in (1, 10, 100):
        # nothing is touched; softer springs let the longer steps pass
        builder = one_disc(1.0, 1e9 / times**2)
        builder.add_particles([(0.0, 0.0)], RADIUS, "disc")
        simulation = ParticleSimulation(builder.build(), time_step=times * book, energy=True)
        simulation.run(steps // times)
        expected = -0.5 * GRAVITY * simulation.time**2
        name = f"1 falling disc, {times} x the book's step"
        seconds = time.perf_counter() - started
        rows.append(relative(name, "y [m]", float(simulation.positions[0, 1]), expected, 1e-11, seconds))
        # v(n-1/2) v(n+1/2) is (g dt/2)^2 less than v(n)^2, always
        less = -0.125 * disc_mass(1.0) * (GRAVITY * simulation.time_step) ** 2
        left = mechanical_energy(simulation)
        off = (left - less) / simulation.energy().kinetic
        rows.append(
            Row(name, "energy -m (g dt)^2/8, over the kinetic one [J]", left, less, off, 1e-11, seconds)
        )
    return rows


def rigid_pendulum(when: float) -> float:
    """Height of the mass of a rigid pendulum let go where it is level [m]; exact (Jacobi's elliptic functions)."""
    m = 0.5  # sin^2 of half the amplitude of 90 degrees
    omega = math.sqrt(GRAVITY / LENGTH)
    sine_half = math.sqrt(m) * ellipj(float(ellipk(m)) - omega * when, m)[0]
    return -LENGTH * (1.0 - 2.0 * float(sine_half) ** 2)


def elastic_pendulum(stiffness: float, mass: float, when: float) -> Floats:
    """Place (2,) of the mass of a pendulum whose bar is a spring [m]; an eighth-order solution of its equations."""

    def rate(_: float, state: Floats) -> list[float]:
        x, y, u, v = state
        length = math.hypot(x, y)
        pull = stiffness / mass * (length - LENGTH) / length
        return [u, v, -pull * x, -pull * y - GRAVITY]

    found = solve_ivp(rate, (0.0, when), [LENGTH, 0.0, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-11)
    return np.asarray(found.y[:2, -1])


def _swing(stiffness: float, time_step: float, steps: int) -> ParticleSimulation:
    builder = one_disc(1.0, stiffness)
    disc = builder.add_particles([(LENGTH, 0.0)], RADIUS, "disc")
    builder.anchor(disc, (0.0, 0.0), stiffness)
    simulation = ParticleSimulation(builder.build(), time_step=time_step, energy=True)
    simulation.run(steps)
    return simulation


def pendulum(steps: int = 80_000) -> list[Row]:
    """Table 1.3: against the rigid pendulum, whose bar the spring stretches by 3 m g/k = 1e-5 m at most; its order.

    The order is measured on a soft spring (k = 1e4 N/m), against its own equations of motion.
    """
    started = time.perf_counter()
    mass = disc_mass(1.0)
    simulation = _swing(1e9, book_step(0.2, mass, 1e9, 1e9), steps)
    seconds = time.perf_counter() - started
    name = "2 pendulum"
    expected = rigid_pendulum(simulation.time)
    left = mechanical_energy(simulation)
    off = (float(simulation.positions[0, 1]) - expected) / LENGTH
    rows = [
        Row(
            name,
            "y after 17.9 s, over L [m]",
            float(simulation.positions[0, 1]),
            expected,
            off,
            1e-6,
            seconds,
        ),
        Row(name, "energy, over m g L [J]", left, 0.0, left / (mass * GRAVITY * LENGTH), 1e-8, seconds),
    ]
    started = time.perf_counter()
    soft, when = 1e4, 8.0
    exact = elastic_pendulum(soft, mass, when)
    counts = (1000, 2000, 4000)
    errors = [
        float(np.linalg.norm(_swing(soft, when / count, count).positions[0] - exact)) for count in counts
    ]
    slope = float(np.polyfit(np.log(when / np.array(counts)), np.log(errors), 1)[0])
    seconds = time.perf_counter() - started
    for count, error in zip(counts, errors, strict=True):
        off = error / LENGTH
        # a second-order scheme: the bound falls with the square of the step
        bound = 1e-5 * (counts[0] / count) ** 2
        rows.append(Row(name, f"error at {when / count:g} s, over L [m]", error, 0.0, off, bound, seconds))
    rows.append(relative(name, "order of the error", slope, 2.0, 0.02, seconds))
    return rows


def _bouncing(time_step: float, viscosity: float = 0.0) -> ParticleSimulation:
    builder = one_disc(1.0, 1e7, viscosity=viscosity)
    builder.add_particles([(0.0, RADIUS)], RADIUS, "disc", velocity=(0.0, 30.0))
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    return ParticleSimulation(builder.build(), time_step=time_step, energy=True, buffer=50.0)


def mechanical_energy(simulation: ParticleSimulation) -> float:
    """Kinetic, elastic and potential energy of one step [J]: of the last forces, one step before the positions."""
    account = simulation.energy()
    height = simulation.positions[:, 1] - simulation.time_step * simulation.velocities[:, 1]
    return account.kinetic + account.elastic + GRAVITY * float(simulation.assembly.mass @ height)


def bouncing() -> list[Row]:
    """Table 1.9 without viscosity: energy after ten bounces, at the book's step and at a hundredth of it.

    A contact that begins inside a step is felt at its end only; the book's step is 0.71 of the critical one (a wall
    is twice as stiff as a pair), so every bounce has 2 or 3 steps.
    """
    rows = []
    book = book_step(0.5, disc_mass(1.0), 1e7, 1e7)
    flight = 2.0 * 30.0 / GRAVITY
    for label, step, bound in (("book's step", book, 0.5), ("book's step/100", 0.01 * book, 1e-4)):
        started = time.perf_counter()
        simulation = _bouncing(step)
        simulation.run(int(10.5 * flight / step))
        mass = disc_mass(1.0)
        start = 0.5 * mass * 30.0**2 + mass * GRAVITY * RADIUS
        name = f"8 bouncing disc, {label}"
        rows.append(
            relative(
                name,
                "energy after ten bounces [J]",
                mechanical_energy(simulation),
                start,
                bound,
                time.perf_counter() - started,
            )
        )
    return rows


def restitution(stiffness: float, viscosity: float, mass: float, speed: float) -> float:
    """Speed after a bounce over that before: linear spring and dashpot c = eta k, and gravity.

    Half a damped oscillation u'' + 2 zeta omega u' + omega^2 u = g from u = 0 until u is 0 again; the dashpot may pull.
    """
    omega = math.sqrt(stiffness / mass)
    zeta = 0.5 * viscosity * omega
    damped = omega * math.sqrt(1.0 - zeta * zeta)
    rest = GRAVITY / omega**2
    sine = (speed - zeta * omega * rest) / damped

    def overlap(when: float) -> float:
        fade = math.exp(-zeta * omega * when)
        return rest + fade * (sine * math.sin(damped * when) - rest * math.cos(damped * when))

    end = float(brentq(overlap, 0.5 * math.pi / damped, 1.5 * math.pi / damped, xtol=1e-15))
    fade = math.exp(-zeta * omega * end)
    s, c = math.sin(damped * end), math.cos(damped * end)
    rate = fade * ((damped * sine + zeta * omega * rest) * c + (damped * rest - zeta * omega * sine) * s)
    return -rate / speed


def viscous_bouncing() -> list[Row]:
    """Table 1.9 with eta = 1e-4 s: coefficient of restitution of the first bounce."""
    rows = []
    mass = disc_mass(1.0)
    book = book_step(0.5, mass, 1e7, 1e7)
    flight = 2.0 * 30.0 / GRAVITY
    expected = restitution(2e7, 1e-4, mass, 30.0)
    for label, step, bound in (("book's step", book, 2e-3), ("book's step/100", 0.01 * book, 5e-4)):
        started = time.perf_counter()
        simulation = _bouncing(step, viscosity=1e-4)
        simulation.run(int(1.5 * flight / step))
        height = float(simulation.positions[0, 1]) - RADIUS
        speed = float(simulation.velocities[0, 1]) - 0.5 * GRAVITY * step
        found = math.sqrt(speed**2 + 2.0 * GRAVITY * height) / 30.0
        name = f"8 viscous bouncing disc, {label}"
        seconds = time.perf_counter() - started
        rows.append(relative(name, "coefficient of restitution", found, expected, bound, seconds))
        if step < book:
            rows.append(_imbalance(name, simulation, 1e-4, seconds))
    return rows


INCLINE = math.radians(30.0)


def _on_incline(stiffness: float, angle: float, *, rolling: bool) -> tuple[ParticleSimulation, int]:
    """A disc at rest on the incline, pressed in by its weight; and the steps of the book's 800."""
    mass = disc_mass(1000.0)
    builder = one_disc(1000.0, stiffness, shear=True)
    up = np.array([math.sin(INCLINE), math.cos(INCLINE)])
    pressed = mass * GRAVITY * math.cos(INCLINE) / (2.0 * stiffness)
    disc = builder.add_particles([(RADIUS - pressed) * up], RADIUS, "disc")
    if not rolling:
        builder.hold(disc, rotation=0.0)
    builder.add_wall(plane("slope", (0.0, 0.0), up, contact={"friction_coefficient": friction(angle)}))
    book = book_step(0.1, mass, 1e8, 1e8)
    step = book * math.sqrt(1e8 / stiffness)
    steps = round(800 * book / step)
    return ParticleSimulation(builder.build(), time_step=step, energy=True), steps


STIFFER = 1e4


def sliding() -> list[Row]:
    """Table 1.10, rotation held: L = g t^2/2 (sin - tan(phi) cos) (eq. 1.58).

    The shear spring must be stretched by mu N/ks before the disc slides, which lets it get ahead; this phase has a
    closed form too. It fades with the stiffness, so that 1e4 times stiffer springs come to eq. 1.58 itself.
    """
    rows = []
    down, normal = GRAVITY * math.sin(INCLINE), GRAVITY * math.cos(INCLINE)
    rate = down - friction(20.0) * normal
    for label, stiffness in (("book's springs", 1e8), ("springs 1e4 times stiffer", 1e8 * STIFFER)):
        started = time.perf_counter()
        simulation, steps = _on_incline(stiffness, 20.0, rolling=False)
        along = np.array([math.cos(INCLINE), -math.sin(INCLINE)])
        start = float(simulation.positions[0] @ along)
        simulation.run(steps // 2)
        half_time, half_speed = simulation.time, float(simulation.velocities[0] @ along)
        simulation.run(steps - steps // 2)
        found = float(simulation.positions[0] @ along) - start
        speed = float(simulation.velocities[0] @ along)
        seconds = time.perf_counter() - started
        # until it slides: x'' = down - omega^2 x
        omega = math.sqrt(2.0 * stiffness / disc_mass(1000.0))
        stretch = friction(20.0) * normal / omega**2
        slips = math.acos(1.0 - stretch * omega**2 / down) / omega
        first = down / omega * math.sin(omega * slips)
        left = simulation.time - slips
        ahead = stretch + first * left + 0.5 * rate * left**2
        name = f"9 sliding disc, {label}"
        acceleration = (speed - half_speed) / (simulation.time - half_time)
        bound = 0.015 if stiffness == 1e8 else 1e-3
        rows += [
            relative(name, "acceleration [m/s2]", acceleration, rate, 1e-3, seconds),
            relative(name, "distance, spring and eq. 1.58 [m]", found, ahead, 1e-3, seconds),
            relative(name, "distance, eq. 1.58 [m]", found, 0.5 * rate * simulation.time**2, bound, seconds),
            _imbalance(name, simulation, 1e-6, seconds),
        ]  # fmt: skip
    return rows


def rolling() -> list[Row]:
    """Table 1.10 with a friction angle of 80 degrees: v = sqrt(4 g h/3) (eq. 1.59).

    The shear spring swings about the force that rolling needs; 1e4 times stiffer springs hardly swing.
    """
    rows = []
    for label, stiffness, bound in (
        ("book's springs", 1e8, 0.01),
        ("springs 1e4 times stiffer", 1e8 * STIFFER, 1e-3),
    ):
        started = time.perf_counter()
        simulation, steps = _on_incline(stiffness, 80.0, rolling=True)
        along = np.array([math.cos(INCLINE), -math.sin(INCLINE)])
        start = float(simulation.positions[0, 1])
        # velocities are those of half a step before: take the height there
        simulation.run(steps - 1)
        before = float(simulation.positions[0, 1])
        simulation.run(1)
        height = start - 0.5 * (before + float(simulation.positions[0, 1]))
        speed = float(simulation.velocities[0] @ along)
        spin = -float(simulation.spins[0, 0]) * RADIUS
        seconds = time.perf_counter() - started
        name = f"10 rolling disc, {label}"
        rows += [
            relative(name, "speed [m/s]", speed, math.sqrt(4.0 / 3.0 * GRAVITY * height), bound, seconds),
            relative(name, "spin times radius, without slip [m/s]", spin, speed, bound, seconds),
            _imbalance(name, simulation, 1e-6, seconds),
        ]
    return rows


def _imbalance(name: str, simulation: ParticleSimulation, bound: float, seconds: float) -> Row:
    """The account adds up the work of gravity half a step farther than the energies: 1/steps of it in a fall."""
    value = simulation.energy().imbalance
    return Row(name, "imbalance of the energy account", value, 0.0, value, bound, seconds)


def run() -> list[Row]:
    """All of them."""
    return [*falling(), *pendulum(), *bouncing(), *viscous_bouncing(), *sliding(), *rolling()]
