"""Hertz-Mindlin impacts, rolling resistance and adhesion against closed forms; used by `fewbody`.

Chung & Ooi's tests 3 and 4 (2011, Granular Matter 13:643-656) again, with their own contact law and at a hundredth of
the Rayleigh step; spin and roll that a moment takes away; the force that parts two spheres that stick.
"""

from __future__ import annotations

import math
import time

import numpy as np

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .fewbody_motion import BALL, GRAVITY
from .rows import Row, relative

CHUNG_OOI = "Chung & Ooi 2011, test"
BOUND = 5e-3

# aluminium oxide
YOUNG, POISSON, DENSITY, RADIUS = 380e9, 0.23, 4000.0, 2.5e-3
SPEED = 3.9


def rayleigh_step() -> float:
    """Time of a Rayleigh wave over a sphere of aluminium oxide [s]: pi r sqrt(rho/G)/(0.1631 nu + 0.8766)."""
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    return math.pi * RADIUS * math.sqrt(DENSITY / shear) / (0.1631 * POISSON + 0.8766)


def impact(
    along: float, down: float, *, restitution: float, friction: float, finer: int = 1
) -> ParticleSimulation:
    """A sphere that has met the rigid plane z = 0 and left it."""
    step = 0.01 * rayleigh_step() / finer
    builder = AssemblyBuilder(3, "hertz_mindlin")
    contact = {
        "young_modulus": YOUNG,
        "poisson_ratio": POISSON,
        "friction_coefficient": friction,
        "restitution": restitution,
    }
    builder.add_material("aluminium oxide", density=DENSITY, contact=contact)
    height = RADIUS + 0.37 * down * step
    builder.add_particles([[0.0, 0.0, height]], RADIUS, "aluminium oxide", velocity=(along, 0.0, -down))
    builder.add_wall(plane("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), time_step=step)
    # slow and damped impacts take several times as long as the elastic one at full speed, some 440 steps
    for _ in range(40):
        simulation.run(200 * finer)
        if float(simulation.positions[0, 2]) > RADIUS:
            return simulation
    raise RuntimeError("the sphere has not left the plane")


def restitution(asked: float, *, finer: int = 1) -> Row:
    """Test 3: the e that comes out for the one put in."""
    started = time.perf_counter()
    simulation = impact(0.0, SPEED, restitution=asked, friction=0.0, finer=finer)
    found = float(simulation.velocities[0, 2]) / SPEED
    name = f"P24 test 3, Hertz-Mindlin, {0.01 / finer:g} of the Rayleigh step"
    seconds = time.perf_counter() - started
    return relative(
        name, "coefficient of restitution", found, asked, BOUND, seconds, f"{CHUNG_OOI} 3: e out = e in"
    )


def oblique(angle: float, tangential: float, spin: float) -> list[Row]:
    """Test 4 where it slides all through (see `fewbody.oblique`): mu 0.092, e 0.98."""
    started = time.perf_counter()
    slope = math.radians(angle)
    along, down = SPEED * math.sin(slope), SPEED * math.cos(slope)
    simulation = impact(along, down, restitution=0.98, friction=0.092)
    seconds = time.perf_counter() - started
    name, source = f"P24 test 4, Hertz-Mindlin, {angle:g} degrees", f"{CHUNG_OOI} 4; impulse of gross sliding"
    kept = float(simulation.velocities[0, 0]) / along
    return [
        relative(name, "tangential restitution", kept, tangential, BOUND, seconds, source),
        relative(name, "spin [rad/s]", float(simulation.spins[0, 1]), spin, BOUND, seconds, source),
    ]


def _resting_ball(law: str, rolling: float, friction: float, speed: float, spin: float) -> ParticleSimulation:
    """A ball pressed into the plane z = 0 by its weight, by about 1e-5 of its radius."""
    weight, sunk = BALL.mass * GRAVITY, 1e-5 * BALL.radius
    contact = {"friction_coefficient": friction, "rolling_friction": rolling}
    if law == "linear_rolling":
        normal = 0.5 * weight / sunk
        frequency = math.sqrt(2.0 * normal / BALL.mass)
        contact |= {"normal_stiffness": normal, "shear_stiffness": 0.8 * normal}
        # the shear spring swings about rolling until it is damped; the dashpot knows no friction limit
        contact["shear_viscosity"] = 0.2 / frequency if friction > 0.0 else 0.0
    else:
        # weight = 4/3 E/(1 - nu^2) sqrt(r) u^1.5
        modulus = 0.75 * weight / (math.sqrt(BALL.radius) * sunk**1.5)
        contact |= {"young_modulus": modulus * (1.0 - 0.25**2), "poisson_ratio": 0.25}
        frequency = math.sqrt(1.5 * weight / sunk / BALL.mass)
    builder = AssemblyBuilder(3, law, gravity=(0.0, 0.0, -GRAVITY))
    builder.add_material("ball", density=BALL.density, contact=contact)
    builder.add_particles(
        [[0.0, 0.0, BALL.radius - sunk]], BALL.radius, "ball", velocity=(speed, 0.0, 0.0),
        spin=(0.0, spin, 0.0),
    )  # fmt: skip
    builder.add_wall(plane("plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    return ParticleSimulation(builder.build(), time_step=0.1 / frequency)


def spin_down(law: str, rolling: float = 0.05, spin: float = 50.0) -> Row:
    """On a plane without friction: omega = omega0 - 5 mu_r g t/(2 r), looked at when half of it is gone."""
    started = time.perf_counter()
    simulation = _resting_ball(law, rolling, 0.0, 0.0, spin)
    rate = 2.5 * rolling * GRAVITY / BALL.radius
    simulation.run(int(0.5 * spin / rate / simulation.time_step))
    expected = spin - rate * simulation.time
    seconds = time.perf_counter() - started
    return relative(
        f"P33 rolling resistance, {law}", "spin of a ball that turns on the spot [rad/s]",
        float(simulation.spins[0, 1]), expected, BOUND, seconds, "angular momentum: M = mu_r r m g",
    )  # fmt: skip


def roll_down(law: str, rolling: float = 0.05, speed: float = 0.5) -> Row:
    """Rolling on a rough plane: v = v0 - 5/7 mu_r g t, looked at when half of it is gone."""
    started = time.perf_counter()
    simulation = _resting_ball(law, rolling, 0.5, speed, speed / BALL.radius)
    rate = 5.0 / 7.0 * rolling * GRAVITY
    simulation.run(int(0.5 * speed / rate / simulation.time_step))
    expected = speed - rate * simulation.time
    seconds = time.perf_counter() - started
    return relative(
        f"P33 rolling resistance, {law}", "speed of a ball that rolls [m/s]",
        float(simulation.velocities[0, 0]), expected, BOUND, seconds,
        "angular momentum about the contact: 7/5 m r^2 domega/dt = -mu_r r m g",
    )  # fmt: skip


def pull_off(first: float, second: float | None, energy: float = 0.05, steps: int = 2000) -> Row:
    """Largest tension of two spheres, or of a sphere on a plane, that are drawn apart from rest: 4 pi gamma R*.

    Aluminium oxide grains of micrometres; surface energy in J/m2.
    """
    started = time.perf_counter()
    curvature = first if second is None else first * second / (first + second)
    expected = 4.0 * math.pi * energy * curvature
    modulus = YOUNG / (1.0 - POISSON**2) * (1.0 if second is None else 0.5)
    sunk = (0.75 * expected / (modulus * math.sqrt(curvature))) ** (2.0 / 3.0)
    builder = AssemblyBuilder(3, "hertz_dmt")
    contact = {
        "young_modulus": YOUNG,
        "poisson_ratio": POISSON,
        "friction_coefficient": 0.3,
        "work_of_adhesion": 2.0 * energy,
    }
    builder.add_material("grain", density=DENSITY, contact=contact)
    # slow beside the waves in the grain, though nothing here has inertia
    step = 1e-9
    speed = sunk / (steps * step)
    grain = builder.add_particles([[0.0, 0.0, 0.0]], first, "grain")
    builder.hold(grain, x=0.0, y=0.0, z=speed, rotation=np.zeros(3))
    if second is None:
        builder.add_wall(plane("plane", (0.0, 0.0, sunk - first), (0.0, 0.0, 1.0)))
    else:
        other = builder.add_particles([[0.0, 0.0, sunk - first - second]], second, "grain")
        builder.hold(other, x=0.0, y=0.0, z=0.0, rotation=np.zeros(3))
    simulation = ParticleSimulation(builder.build(), time_step=step)
    largest = 0.0
    for _ in range(steps + 10):
        simulation.run(1)
        largest = max(largest, -float(simulation.forces[0, 2]))
    seconds = time.perf_counter() - started
    what = "sphere on a plane" if second is None else f"two spheres, radii {first:g} and {second:g} m"
    source = "Derjaguin, Muller & Toporov 1975: 4 pi gamma R*"
    return relative(f"P33 pull-off, {what}", "largest tension [N]", largest, expected, BOUND, seconds, source)


def run() -> list[Row]:
    """All but the oblique impacts, whose table is that of `fewbody`."""
    # the dashpot works with velocities half a step old: strong ones need shorter steps
    rows = [restitution(asked) for asked in (0.2, 0.4, 0.6, 0.8, 0.9, 1.0)]
    rows += [restitution(asked, finer=4) for asked in (0.05, 0.1, 0.2)]
    for law in ("linear_rolling", "hertz_mindlin_rolling"):
        rows += [spin_down(law), roll_down(law)]
    return [*rows, pull_off(10e-6, 10e-6), pull_off(10e-6, 25e-6), pull_off(10e-6, None)]
