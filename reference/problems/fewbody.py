"""One or two spheres that collide, slide, roll and bounce, against closed forms: `python -m reference run fewbody`.

Chung & Ooi's impact tests 1 to 4 (2011, Granular Matter 13:643-656) stand here, spin, roll and bounce in
`fewbody_motion`, Hertz-Mindlin impacts, rolling resistance and adhesion in `fewbody_laws`.

What a collision costs is set here by the linear law's dashpot. Its contact ends where the overlap is zero, so that the
dashpot may pull for a moment before; half a damped oscillation then gives e = exp(-pi zeta/sqrt(1 - zeta^2)) with
zeta = eta omega/2, which is solved for eta in `fewbody_motion.viscosity`.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from . import fewbody_laws, fewbody_motion
from .fewbody_motion import A_COLLISION, Ball
from .rows import Row, relative

CHUNG_OOI = "Chung & Ooi 2011, test"
HERTZ = "Johnson 1985, Contact Mechanics, eq. 11.22 to 11.24"

BOUND = 5e-3


class Impact(NamedTuple):
    """Elastic spheres that meet, and what the tables say."""

    young: float  # [Pa]
    poisson: float
    density: float  # [kg/m3]
    force: float  # largest [N]
    approach: float  # largest [m]
    duration: float  # [s]


# values to the four places that Hertz's theory gives for the published parameters
TWO_SPHERES = {
    "glass": Impact(48e9, 0.20, 2800.0, 10.70e3, 274.1e-6, 40.3e-6),
    "limestone": Impact(20e9, 0.25, 2500.0, 7.108e3, 368.3e-6, 54.2e-6),
}
ON_PLANE = {
    "aluminium alloy": Impact(70e9, 0.33, 2699.0, 8.69e3, 65.0e-6, 957e-6),
    "magnesium alloy": Impact(40e9, 0.35, 1800.0, 5.48e3, 68.8e-6, 1012e-6),
}


def hertz(mass: float, radius: float, modulus: float, speed: float) -> tuple[float, float, float]:
    """Largest force [N] and overlap [m] and the duration [s] of a collision; effective mass, radius and modulus."""
    deepest = (15.0 * mass * speed**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4
    duration = math.sqrt(math.pi) * 4 / 5 * math.gamma(0.4) / math.gamma(0.9) * deepest / speed
    return 4 / 3 * modulus * math.sqrt(radius) * deepest**1.5, deepest, duration


def _collision(simulation: ParticleSimulation, centre: float, radii: float, steps: int) -> tuple[float, ...]:
    """Largest force, largest overlap, duration; the first particle meets the second, or the plane through `centre`."""
    largest, deepest, begun, ended = 0.0, 0.0, math.nan, math.nan
    for _ in range(steps):
        simulation.run(1)
        force = abs(float(simulation.forces[0, 0]))
        largest = max(largest, force)
        places = simulation.positions[:, 0]
        apart = float(places[1] - places[0]) if len(places) > 1 else centre - float(places[0])
        deepest = max(deepest, radii - apart)
        if force > 0.0 and math.isnan(begun):
            begun = simulation.time
        if force == 0.0 and not math.isnan(begun):
            ended = simulation.time
            break
    return largest, deepest, ended - begun


def _impact_rows(
    name: str, found: tuple[float, ...], expected: tuple[float, ...], source: str, seconds: float
) -> list[Row]:
    quantities = ("largest force [N]", "largest overlap [m]", "duration [s]")
    return [
        relative(name, quantity, value, answer, BOUND, seconds, source)
        for quantity, value, answer in zip(quantities, found, expected, strict=True)
    ]


def two_spheres(kind: str) -> list[Row]:
    """Test 1: radius 10 mm, 10 m/s each, head-on."""
    started = time.perf_counter()
    impact, radius, speed = TWO_SPHERES[kind], 0.01, 10.0
    step = impact.duration / A_COLLISION
    builder = AssemblyBuilder(3, "hertz")
    builder.add_material(
        "m",
        density=impact.density,
        contact={"young_modulus": impact.young, "poisson_ratio": impact.poisson},
    )
    gap = 2.0 * speed * 0.37 * step
    builder.add_particles(
        [[0.0, 0.0, 0.0], [2.0 * radius + gap, 0.0, 0.0]],
        radius,
        "m",
        velocity=[[speed, 0, 0], [-speed, 0, 0]],
    )
    simulation = ParticleSimulation(builder.build(), time_step=step)
    found = _collision(simulation, math.nan, 2.0 * radius, 2 * A_COLLISION)
    seconds = time.perf_counter() - started
    name = f"P24 test 1, {kind}"
    rows = _impact_rows(name, found, impact[3:], f"{CHUNG_OOI} 1; {HERTZ}", seconds)
    speed_after = float(simulation.velocities[1, 0])
    rows.append(relative(name, "speed afterwards [m/s]", speed_after, speed, BOUND, seconds, "elastic"))
    return rows


def on_plane(kind: str, *, rigid: bool) -> list[Row]:
    """Test 2: radius 0.1 m, 0.2 m/s, on a plane of the same material or a rigid one.

    The published figures are those of a plane that deforms as the sphere does, so that E* = E/(2 (1 - nu^2)): the
    wall is given the sphere's own modulus. Against a rigid wall, the engine's own choice, E* is twice that.
    """
    started = time.perf_counter()
    impact, radius, speed = ON_PLANE[kind], 0.1, 0.2
    mass = impact.density * 4 / 3 * math.pi * radius**3
    modulus = impact.young / (1.0 - impact.poisson**2)
    expected = hertz(mass, radius, modulus, speed) if rigid else impact[3:]
    step = expected[2] / A_COLLISION
    builder = AssemblyBuilder(3, "hertz")
    builder.add_material(
        "m",
        density=impact.density,
        contact={"young_modulus": impact.young, "poisson_ratio": impact.poisson},
    )
    face = radius + 0.37 * speed * step
    builder.add_particles([[0.0, 0.0, 0.0]], radius, "m", velocity=(speed, 0.0, 0.0))
    own = {} if rigid else {"young_modulus": impact.young}
    builder.add_wall(plane("plane", (face, 0.0, 0.0), (-1.0, 0.0, 0.0), contact=own))
    simulation = ParticleSimulation(builder.build(), time_step=step)
    found = _collision(simulation, face, radius, 2 * A_COLLISION)
    seconds = time.perf_counter() - started
    name = f"P24 test 2, {kind}, {'rigid plane' if rigid else 'plane of the same'}"
    source = f"closed form: {HERTZ}" if rigid else f"{CHUNG_OOI} 2; {HERTZ}"
    rows = _impact_rows(name, found, expected, source, seconds)
    after = -float(simulation.velocities[0, 0])
    rows.append(relative(name, "speed afterwards [m/s]", after, speed, BOUND, seconds, "elastic"))
    return rows


ALUMINIUM_OXIDE = Ball(radius=2.5e-3, density=4000.0)
RESTITUTIONS = (0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0)


def restitution(asked: float, *, finer: int = 1) -> Row:
    """Test 3: aluminium oxide, radius 2.5 mm, 3.9 m/s on a rigid plane; the e that comes out for the one put in."""
    started = time.perf_counter()
    simulation, steps = ALUMINIUM_OXIDE.against_plane((0.0, 0.0, -3.9), restitution=asked, finer=finer)
    simulation.run(steps)
    found = float(simulation.velocities[0, 2]) / 3.9
    name = f"P24 test 3, {finer * A_COLLISION} steps a collision"
    source = f"{CHUNG_OOI} 3: e out = e in"
    seconds = time.perf_counter() - started
    return relative(name, "coefficient of restitution", found, asked, BOUND, seconds, source)


# angle from the normal [deg], tangential restitution, spin afterwards [rad/s]
OBLIQUE = ((45.0, 0.8178, 502.3), (60.0, 0.8948, 355.2), (70.0, 0.9337, 243.0))


def oblique(angle: float, tangential: float, spin: float) -> list[Row]:
    """Test 4: radius 2.5 mm, 3.9 m/s, mu 0.092, e 0.98, where it slides all through: tan > 3.5 mu (1 + e).

    e_t = 1 - mu (1 + e)/tan, omega = 5/2 mu (1 + e) v cos/r: the friction's impulse is mu times the normal one.
    """
    started = time.perf_counter()
    slope = math.radians(angle)
    along, down = 3.9 * math.sin(slope), 3.9 * math.cos(slope)
    simulation, steps = ALUMINIUM_OXIDE.against_plane((along, 0.0, -down), restitution=0.98, friction=0.092)
    simulation.run(steps)
    seconds = time.perf_counter() - started
    name, source = f"P24 test 4, {angle:g} degrees", f"{CHUNG_OOI} 4; impulse of gross sliding"
    kept = float(simulation.velocities[0, 0]) / along
    turned = float(simulation.spins[0, 1])
    return [
        relative(name, "tangential restitution", kept, tangential, BOUND, seconds, source),
        relative(name, "spin [rad/s]", turned, spin, BOUND, seconds, source),
    ]


def run() -> list[Row]:
    """All of them."""
    rows: list[Row] = []
    for kind in TWO_SPHERES:
        rows += two_spheres(kind)
    for kind in ON_PLANE:
        rows += on_plane(kind, rigid=False) + on_plane(kind, rigid=True)
    # the dashpot works with velocities half a step old: strong ones need shorter steps
    rows += [restitution(asked) for asked in RESTITUTIONS if asked >= 0.4]
    rows += [restitution(asked, finer=4) for asked in RESTITUTIONS]
    for each in OBLIQUE:
        rows += oblique(*each) + fewbody_laws.oblique(*each)
    return [*rows, *fewbody_laws.run(), *fewbody_motion.run()]
