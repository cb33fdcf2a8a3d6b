"""Dry broken rock drawn through one opening: how it moves, and from where what is drawn comes, after Nedderman & Tuzun.

R. M. Nedderman and U. Tuzun (1979), A kinematic model for the flow of granular materials, Powder Technol. 22:243-253:
rock goes sideways as the velocity downwards v falls off, u = B dv/dx, so that above a point v spreads like heat,

    v(x, y) = Q/sqrt(4 pi B y) exp(-x^2/(4 B y)),  Q the area drawn a time, y the height.

B is a length of one to four grains: 2.24 d in their experiments, 1.3 to 3.5 d in others (J. Choi, A. Kudrolli and
M. Z. Bazant 2005, J. Phys.: Condens. Matter 17:S2533, tell of them). Streamlines are the parabolas x^2/y = const, so
what has been drawn, of area V, comes from within (`zone`)

    x^2 = 6 B y ln(H/y),  V = 4/3 sqrt(pi B) H^(3/2),

the ellipsoid of extraction of the miners, its greatest width at H/e. Lengths are in mean diameters, gravity and the
density of the grains are 1.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly
from geodem.boundaries.walls import plane, segments
from geodem.breaking.removal import remove_particles
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation.settling import run_to_rest
from geodem.runout.friction import SHEAR_STIFFNESS, disc_friction
from geodem.runout.handing import take_contacts

Floats = NDArray[np.float64]

ANGLE = 30.0  # residual friction angle of the discs [deg]
WIDE, HIGH = 60.0, 66.0  # of the ground
OPENING = 8.0
SIZE_RATIO = 1.5
SOLID = 0.80
STIFFNESS = 300.0  # normal stiffness of a contact over rho g H
RESTITUTION_RATIO = 0.3  # share of critical damping of a contact
GONE = -6.0  # below this what was drawn is taken away
PAUSE = 2.0  # time from one look to the next
STILL = 20.0  # time without anything drawn after which the grains over the opening have made an arch
ARCH = 5.0  # up to this height over the opening what hangs is taken away, as hang-ups are blasted
DRAWN = 0.25  # share of the grains that is drawn in all
STEADY = 0.05  # share after which velocities are measured
LEVELS = np.array([15.0, 20.0, 25.0, 30.0])
BAND = 2.5  # half the height of what is measured at a level, and of a slice of the zone
TOP, BELOW_TOP = (
    0.995,
    0.976,
)  # this share of the zone's area lies below this share of its height, by its formula
EDGES = np.linspace(-24.0, 24.0, 25)  # of columns


class Draw(NamedTuple):
    """What was drawn.

    Attributes
    ----------
    start : (n, 2)
        Centres before.
    radii : (n,)
    gone : (n,) bool
        Drawn.
    speed : (levels, columns)
        Mean velocity downwards.
    bulk : float
        Density of the ground before, voids included.
    masses : float, float, float
        Of all before, of what is left, of what was taken away.
    seconds : float
    """

    start: Floats
    radii: Floats
    gone: NDArray[np.bool_]
    speed: Floats
    bulk: float
    masses: tuple[float, float, float]
    seconds: float

    @property
    def area(self) -> float:
        """In the ground, of what was drawn [d^2]."""
        return float((math.pi * self.radii**2)[self.gone].sum()) / self.bulk


def zone(area: float, spreading: float) -> tuple[float, float]:
    """Height and greatest width of the zone that an area came from, for B = `spreading`."""
    height = (0.75 * area / math.sqrt(math.pi * spreading)) ** (2.0 / 3.0)
    return height, 2.0 * math.sqrt(6.0 * spreading * height / math.e)


def drawn(seed: int, wide: float = WIDE, high: float = HIGH) -> Draw:
    """Let grains settle in a box so wide and high, open its floor, draw."""
    begun = time.perf_counter()
    packing = random_packing(
        2, box=(wide, 1.04 * high), solid_fraction=SOLID, radius=2.0 * SIZE_RATIO / (1.0 + SIZE_RATIO) * 0.5,
        size_ratio=SIZE_RATIO, periodic=False, seed=seed,
    )  # fmt: skip
    places = packing.positions - (0.5 * wide, 0.0)
    rest = ParticleSimulation(_assembly(places, packing.radii, wide, high, closed=True), local_damping=0.3)
    run_to_rest(rest, tolerance=5e-3, most_steps=15_000)
    start = rest.positions
    s = ParticleSimulation(
        _assembly(start, packing.radii, wide, high, closed=False), local_damping=0.05, applied=True
    )
    take_contacts(rest, s)
    mass = s.assembly.mass.copy()
    middle = (start[:, 1] > 5.0) & (start[:, 1] < high - 10.0)
    bulk = float(mass[middle].sum()) / (wide * (high - 15.0))
    number = np.arange(len(start))
    taken, share, still = 0.0, 0.0, 0.0
    way, looks = np.zeros((len(LEVELS), len(EDGES) - 1)), np.zeros((len(LEVELS), len(EDGES) - 1))
    every = max(1, round(PAUSE / s.time_step))
    while share < DRAWN:
        before = s.positions
        s.run(every)
        if share > STEADY:
            _add(way, looks, before, s.positions)
        below = s.positions[:, 1] < GONE
        if still >= STILL:
            below |= (s.positions[:, 1] < ARCH) & (np.abs(s.positions[:, 0]) < 0.5 * OPENING)
        if below.any():
            removal = remove_particles(s, below, keep_forces=False)
            s, number = removal.simulation, number[removal.particles]
            taken += removal.mass
        out = s.positions[:, 1] < 0.0
        last, share = share, 1.0 - float(mass[number[~out]].sum() / mass.sum())
        still = still + PAUSE if share == last else 0.0
    gone = np.ones(len(start), dtype=bool)
    gone[number[~out]] = False
    masses = float(mass.sum()), float(s.assembly.mass.sum()), taken
    speed = way / np.maximum(looks, 1.0) / (every * s.time_step)
    return Draw(start, packing.radii, gone, speed, bulk, masses, time.perf_counter() - begun)


def _add(way: Floats, looks: Floats, before: Floats, after: Floats) -> None:
    """Add ways downwards to the bins that they were made in."""
    place = 0.5 * (before + after)
    column = np.digitize(place[:, 0], EDGES) - 1
    for k, level in enumerate(LEVELS):
        here = (np.abs(place[:, 1] - level) < BAND) & (column >= 0) & (column < len(EDGES) - 1)
        np.add.at(way[k], column[here], (before - after)[here, 1])
        np.add.at(looks[k], column[here], 1.0)


def spreading(speed: Floats) -> Floats:
    """B (levels,) of velocities (levels, columns): Gauss curves of least squares."""
    from scipy.optimize import curve_fit

    middles = 0.5 * (EDGES[1:] + EDGES[:-1])
    found = []
    for level, row in zip(LEVELS, speed, strict=True):
        fit, _ = curve_fit(
            lambda x, top, b, y=level: top * np.exp(-(x**2) / (4.0 * b * y)),
            middles,
            row,
            p0=(row.max(), 2.0),
        )
        found.append(fit[1])
    return np.array(found)


def measured_zone(draw: Draw) -> tuple[float, float]:
    """Height and greatest width of where the drawn grains were: of slices, by the area that was drawn of them."""
    edges = np.arange(0.0, float(draw.start[:, 1].max()), 2.0 * BAND)
    area = math.pi * draw.radii**2 / draw.bulk
    width = np.histogram(draw.start[:, 1], edges, weights=np.where(draw.gone, area, 0.0))[0] / (2.0 * BAND)
    return float(np.quantile(draw.start[draw.gone, 1], TOP)) / BELOW_TOP, float(width.max())


def _assembly(places: Floats, radii: Floats, wide: float, high: float, *, closed: bool) -> Assembly:
    friction = disc_friction(math.radians(ANGLE))
    stiffness = STIFFNESS * high * SOLID
    builder = AssemblyBuilder(2, contact_law="linear_rolling", gravity=(0.0, -1.0))
    builder.add_material(
        "grain",
        density=1.0,
        contact={
            "normal_stiffness": stiffness,
            "shear_stiffness": SHEAR_STIFFNESS * stiffness,
            "friction_coefficient": friction.sliding,
            "rolling_friction": friction.rolling,
            "normal_viscosity": 2.0 * RESTITUTION_RATIO * math.sqrt(0.125 * math.pi / stiffness),
            "shear_viscosity": 0.0,  # it would act beyond the friction
        },
    )
    builder.add_particles(places, radii, "grain")
    smooth = {"friction_coefficient": 0.0, "rolling_friction": 0.0}
    builder.add_wall(plane("left", (-0.5 * wide, 0.0), (1.0, 0.0), contact=smooth))
    builder.add_wall(plane("right", (0.5 * wide, 0.0), (-1.0, 0.0), contact=smooth))
    edge, far = 0.5 * OPENING, 0.5 * wide + 2.0
    builder.add_wall(segments("floor, left", [(-far, 0.0), (-edge, 0.0), (-edge, -3.0)]))
    builder.add_wall(segments("floor, right", [(edge, -3.0), (edge, 0.0), (far, 0.0)]))
    if closed:
        builder.add_wall(segments("door", [(-edge, 0.0), (edge, 0.0)]))
    return builder.build()
