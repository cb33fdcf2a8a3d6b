"""A round hole in a Mohr-Coulomb medium under even stress: wall displacement, yielded zone, reaction curve, supports.

Compression positive here. With pressure p on the wall of radius a, far stress P, Kp = (1 + sin phi)/(1 - sin phi),
q = 2 c cos phi / (1 - sin phi) and s = q / (Kp - 1), equilibrium d(sigma_r)/dr = (sigma_theta - sigma_r)/r with
sigma_theta = Kp sigma_r + q gives sigma_r + s = (p + s) (r/a)^(Kp - 1) where the ground yields. At the radius R of its
rim the elastic field outside, sigma_r + sigma_theta = 2 P, must be at yield: sigma_R = (2 P - q)/(Kp + 1), so that

    R/a = [2/(Kp + 1) (P + s)/(p + s)]^(1/(Kp - 1)).

The displacement inward u at R is that of the elastic ground, (P - sigma_R) R / (2 G). Inside, the plastic strains obey
eps_r + K eps_theta = 0 with K = (1 + sin psi)/(1 - sin psi); with the elastic strains of the stress change in plane
strain, e(r) = [eps_r + K eps_theta] elastic, du/dr + K u/r = e(r), whose integral is u r^K = u_R R^K - integral of
e r^K from r to R. With sigma_r + s = A r^(Kp - 1) every term is a power of r. J. Salencon 1969, Contraction
quasi-statique d'une cavite a symetrie spherique ou cylindrique dans un milieu elastoplastique, Annales des Ponts et
Chaussees 4:231, gives the same.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
import shapely

from geodem.builders.ground import GroundProperties
from geodem.builders.section import Section
from geodem.tunnelling.digging import Digging
from geodem.tunnelling.ground import make_tunnel_ground
from geodem.tunnelling.plan import Bolts, Lining, Opening, Plan, Stage, UniformStress

from .rows import Row, relative

RADIUS = 1.0
FAR_STRESS = 30e6
SHEAR, BULK = 2.8e9, 3.9e9
COHESION, FRICTION = 3.45e6, 30.0
"""The hole of the verification manuals of finite-difference codes [m, Pa, deg]."""
POISSON = (3.0 * BULK - 2.0 * SHEAR) / (2.0 * (3.0 * BULK + SHEAR))
YOUNG = 9.0 * BULK * SHEAR / (3.0 * BULK + SHEAR)
SOURCE = "Salencon 1969, as in the problem's file"


class Hole(NamedTuple):
    """Closed form at one pressure on the wall: inward displacement of the wall [m], rim of the yielded zone [m]."""

    displacement: float
    rim: float


class Medium(NamedTuple):
    """Ground around a round hole, SI and degrees."""

    radius: float
    far: float
    shear: float
    poisson: float
    cohesion: float
    friction: float
    dilation: float


def medium(dilation: float) -> Medium:
    """That of the verification manuals with a dilation angle [deg]."""
    return Medium(RADIUS, FAR_STRESS, SHEAR, POISSON, COHESION, FRICTION, dilation)


def salencon(pressure: float, ground: Medium) -> Hole:
    """Wall displacement and rim under a pressure [Pa] on the wall."""
    radius, far, nu = ground.radius, ground.far, ground.poisson
    sine, flow = math.sin(math.radians(ground.friction)), math.sin(math.radians(ground.dilation))
    kp, k = (1.0 + sine) / (1.0 - sine), (1.0 + flow) / (1.0 - flow)
    q = 2.0 * ground.cohesion * math.cos(math.radians(ground.friction)) / (1.0 - sine)
    s = q / (kp - 1.0)
    yields_at = (2.0 * far - q) / (kp + 1.0)
    if pressure >= yields_at:
        return Hole((far - pressure) * radius / (2.0 * ground.shear), radius)
    rim = radius * (2.0 / (kp + 1.0) * (far + s) / (pressure + s)) ** (1.0 / (kp - 1.0))
    at_rim = (far - yields_at) * rim / (2.0 * ground.shear)
    # elastic strains, extension positive, of the changes of stress dr and dt (compression positive):
    # eps_r = -((1 - nu) dr - nu dt)/(2 G), eps_t = -((1 - nu) dt - nu dr)/(2 G)
    scale = (pressure + s) / radius ** (kp - 1.0)
    growing = (1.0 - nu - nu * kp + k * ((1.0 - nu) * kp - nu)) * scale
    steady = (1.0 - 2.0 * nu) * (1.0 + k) * (far + s)

    # e(r) = -(growing r^(Kp - 1) - steady)/(2 G); times r^K, integrated from a to R
    def power(exponent: float) -> float:
        return float((rim**exponent - radius**exponent) / exponent)

    integral = -(growing * power(kp + k) - steady * power(k + 1.0)) / (2.0 * ground.shear)
    # outward displacement is -u: (-u r^K)(R) - (-u r^K)(a) = integral
    return Hole((at_rim * rim**k + integral) / radius**k, rim)


def rock(dilation: float) -> GroundProperties:
    """The medium without weight."""
    return GroundProperties.of(
        0.0, young_modulus=YOUNG, poisson_ratio=POISSON, cohesion=COHESION, friction_angle=math.radians(FRICTION),
        dilation_angle=math.radians(dilation), tensile_strength=math.inf,
    )  # fmt: skip


def circle(radius: float, corners: int = 360) -> shapely.Polygon:
    """A circle around the origin; corners at right angles lie exactly on the axes."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    return shapely.Polygon(radius * np.round(np.stack([np.cos(angle), np.sin(angle)], axis=1), 15))


def quarter(
    dilation: float, particles: int, stages: tuple[Stage, ...] | None = None, *, size: float = 10.0,
    outer: str = "far", increments: int = 20, linings: tuple[Lining, ...] = (), bolts: tuple[Bolts, ...] = (),
) -> Digging:  # fmt: skip
    """A quarter of the hole in a square of `size` radii, relaxed all the way unless the stages say otherwise."""
    section = Section.from_polygons([("rock", [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]])])
    opening = Opening("hole", circle(RADIUS), (0.0, 0.0))
    ground = make_tunnel_ground(
        section, [opening], {"rock": rock(dilation)},
        boundary={"left": "roller", "bottom": "roller", "right": outer, "top": outer}, particles=particles,
        wall_spacing=0.05 * math.sqrt(2500.0 / particles), gravity=0.0,
    )  # fmt: skip
    stages = stages or (Stage("dig", excavate=("hole",), relax=1.0),)
    plan = Plan((opening,), UniformStress(FAR_STRESS, FAR_STRESS), stages, linings, bolts)
    digging = Digging(ground, plan, increments=increments)
    digging.run()
    return digging


def convergence(dilation: float, particles: int, displacement_bound: float = 0.03) -> list[Row]:
    """Wall displacement and rim of the unsupported hole."""
    begun = time.perf_counter()
    last = quarter(dilation, particles).progress.rows[-1]
    seconds = time.perf_counter() - begun
    exact = salencon(0.0, medium(dilation))
    name = f"P16 hole, psi {dilation:g}, {particles} particles"
    return [
        relative(
            name,
            "mean wall displacement [m]",
            last["mean"],
            exact.displacement,
            displacement_bound,
            seconds,
            SOURCE,
        ),
        relative(
            name,
            "R0/a, of the yielded area [-]",
            last["plastic_radius_ratio"],
            exact.rim / RADIUS,
            0.015,
            seconds,
            SOURCE,
        ),
    ]


def grown_yield(particles: int) -> list[Row]:
    """The same with psi = 0, whose answer depends on the mesh: held to the same bounds, and told as measured."""
    return convergence(0.0, particles)


def far_boundary() -> list[Row]:
    """What the end of the section costs: the hole in squares of 10 and 20 radii, by what stands at their sides."""
    rows = []
    exact = salencon(0.0, medium(30.0)).displacement
    for outer, size in (("far", 10.0), ("far", 20.0), ("fixed", 20.0), ("free", 20.0)):
        begun = time.perf_counter()
        last = quarter(30.0, 2500, size=size, outer=outer).progress.rows[-1]
        rows.append(
            relative(
                f"P16 hole, sides {outer} at {size:g} a", "mean wall displacement [m]", last["mean"], exact, 0.03,
                time.perf_counter() - begun, SOURCE,
            )
        )  # fmt: skip
    return rows


def reaction_curve(particles: int) -> list[Row]:
    """Displacement at pressures along the whole curve, elastic and yielded."""
    begun = time.perf_counter()
    rows = quarter(30.0, particles).progress.rows
    seconds = time.perf_counter() - begun
    return [
        relative(
            "P16 ground reaction curve", f"displacement at p = {(1.0 - row['relaxed']) * 30.0:.3g} MPa [m]",
            row["mean"], salencon((1.0 - row["relaxed"]) * FAR_STRESS, medium(30.0)).displacement, 0.03, seconds,
            SOURCE,
        )
        for row in rows[2::3]
    ]  # fmt: skip


def equilibrium(relaxed: float, stiffness: float, ground: Medium) -> tuple[float, float]:
    """Pressure [Pa] and displacement [m] where a thin ring that was installed at a relaxed share balances the ground.

    stiffness: pressure over displacement of the ring [Pa/m].
    """
    at = salencon((1.0 - relaxed) * ground.far, ground).displacement
    low, high = 0.0, (1.0 - relaxed) * ground.far
    for _ in range(200):
        middle = 0.5 * (low + high)
        if stiffness * (salencon(middle, ground).displacement - at) > middle:
            low = middle
        else:
            high = middle
    return low, salencon(low, ground).displacement


def lining(particles: int, relaxed: float = 0.8, dilation: float = 30.0) -> list[Row]:
    """A thin ring installed on the way: where its line meets the ground's curve."""
    ring = Lining("ring", "hole", 0.05, 20e9, 0.2)
    begun = time.perf_counter()
    digging = quarter(
        dilation,
        particles,
        (
            Stage("dig", excavate=("hole",), relax=relaxed),
            Stage("line", install=("ring",)),
            Stage("rest", relax=1.0),
        ),
        linings=(ring,),
    )
    seconds = time.perf_counter() - begun
    last = digging.progress.rows[-1]
    pressure, displacement = equilibrium(relaxed, ring.axial_stiffness / RADIUS**2, medium(dilation))
    name = f"P16 hole with a ring, psi {dilation:g}"
    source = "intersection of Salencon's curve with p = E' t / a^2 (u - u0)"
    return [
        relative(
            name,
            "pressure on the ring [Pa]",
            last["lining_pressure"],
            pressure,
            0.03,
            seconds,
            source,
        ),
        relative(name, "mean wall displacement [m]", last["mean"], displacement, 0.03, seconds, source),
        relative(
            name,
            "thrust over p a [-]",
            last["largest_thrust"] / (last["lining_pressure"] * RADIUS),
            1.0,
            0.02,
            seconds,
            "ring under even pressure",
        ),
    ]


def bolts(particles: int) -> list[Row]:
    """Bars that end beyond the yielded zone, anchored at both ends and yielding at once.

    Spread over its share of the wall the constant force of a bar is a pressure p = F / (spacing a angle). Its anchors
    pull inward with q = p a / b on a circle of radius b in elastic ground. There the stress inside grows by s and that
    outside falls by t, s + t = q; equal displacements on both sides, s (1 - 2 nu) = t, give s = q / (2 (1 - nu)): the
    hole feels the far stress P + s.
    """
    number, reach, spacing = 18, 4.0, 1.0
    half = 0.5 * math.pi / number
    angles = half * (0.5 + np.arange(number))
    pressure = 1.5e6
    force = pressure * spacing * RADIUS * half
    bars = tuple(
        ((math.cos(a), math.sin(a)), (reach * math.cos(a), reach * math.sin(a))) for a in angles.tolist()
    )
    kind = Bolts(
        "bars", bars, area=1e-3, young_modulus=200e9, yield_force=force, spacing=spacing, anchored=True
    )
    begun = time.perf_counter()
    digging = quarter(
        30.0,
        particles,
        (
            Stage("dig", excavate=("hole",), relax=0.6),
            Stage("bolt", install=("bars",)),
            Stage("rest", relax=1.0),
        ),
        bolts=(kind,),
    )
    seconds = time.perf_counter() - begun
    last = digging.progress.rows[-1]
    pull = pressure * RADIUS / reach / (2.0 * (1.0 - POISSON))
    exact = salencon(pressure, medium(30.0)._replace(far=FAR_STRESS + pull))
    name = "P16 hole with yielding bars"
    return [
        relative(
            name,
            "bar force over its yield force [-]",
            last["largest_bolt_force"] * spacing / force,
            1.0,
            1e-6,
            seconds,
            "by its law",
        ),
        relative(
            name,
            "mean wall displacement [m]",
            last["mean"],
            exact.displacement,
            0.03,
            seconds,
            "Salencon with the bars' force as pressure on the wall and as pull of their anchors",
        ),
    ]


def two_stages(particles: int) -> list[Row]:
    """The same hole dug as heading and bench, elastic: the end does not depend on the order."""
    section = Section.from_polygons([("rock", [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]])])
    whole = circle(RADIUS)
    halves = [
        Opening(name, shapely.intersection(whole, shapely.box(-2.0, low, 2.0, low + 2.0)), (0.0, 0.0))
        for name, low in (("heading", 0.0), ("bench", -2.0))
    ]
    stiff = rock(30.0)
    strong = GroundProperties(0.0, stiff.law, stiff.parameters._replace(cohesion_cos_phi=1e12))
    sides = dict.fromkeys(("left", "right", "bottom", "top"), "far")
    begun = time.perf_counter()
    ground = make_tunnel_ground(
        section, halves, {"rock": strong}, boundary=sides, particles=particles, wall_spacing=0.12, gravity=0.0
    )
    ends = []
    for order in (("heading", "bench"), ("bench", "heading")):
        stages = tuple(Stage(name, excavate=(name,), relax=1.0) for name in order)
        digging = Digging(
            ground, Plan(tuple(halves), UniformStress(FAR_STRESS, FAR_STRESS), stages), increments=4
        )
        digging.run()
        wall = np.unique(np.concatenate([digging.ground.wall(k, digging.dug) for k in (0, 1)]))
        at, moved = ground.model.positions[wall], digging.progress.displacement[wall]
        ends.append(float(-(at * moved).sum(axis=1).mean() / RADIUS))
    seconds = time.perf_counter() - begun
    exact = FAR_STRESS * RADIUS / (2.0 * SHEAR)
    return [
        relative(
            f"hole dug as {order}",
            "mean wall displacement [m]",
            found,
            exact,
            0.02,
            seconds,
            "Kirsch: p a / (2 G)",
        )
        for order, found in zip(("heading, bench", "bench, heading"), ends, strict=True)
    ]
