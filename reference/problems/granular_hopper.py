"""A flat-bottomed box that drains through a round hole: rate of flow over its diameter, after Beverloo.

W. A. Beverloo, H. A. Leniger and J. van de Velde (1961), The flow of granular solids through orifices, Chem. Eng. Sci.
15:260-269: W = 0.58 rho sqrt(g) (D - 1.5 d)^(5/2), with the bulk density rho and the diameter d of the grains.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from geodem.boundaries.walls import plane, triangles
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from .granular_grains import DIAMETER, GRAVITY, UNIT_TIME, Floats, exponent, grain_builder, mean_mass
from .rows import Row, relative

FRICTIONS = (0.3, 0.5)
OPENINGS = (4.5, 5.5, 6.5, 8.0)  # over the mean diameter
WIDTH = 16.0 * DIAMETER
FILL = 18.0 * DIAMETER
STIFFNESS = 2e4  # kn d/(m g)
SIZE_RATIO = 1.2
CORNERS = 24  # of the hole
DROP = 25.0 * DIAMETER  # to what catches the grains
BEGIN = 6.0 * UNIT_TIME  # the flow is steady
LEAST, MOST = 0.55, 45.0 * UNIT_TIME  # share of the grains that stay; longest time measured
EMPTY = 1.5  # Beverloo's k: the outermost 1.5 d of the hole let nothing through
BEVERLOO = "Beverloo 1961, k 1.5"


class Discharge(NamedTuple):
    """Flow through one hole."""

    opening: float  # diameter [m]
    rate: float  # [kg/s]
    density: float  # bulk, before [kg/m3]
    passed: int  # grains while it was measured
    seconds: float
    friction: float  # of grains and walls


def annulus(opening: float) -> Floats:
    """Triangles (k, 3, 3) of a floor with a hole in the middle, of the area of a circle of the given diameter."""
    angle = 2.0 * math.pi * (np.arange(CORNERS) + 0.5) / CORNERS
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # a polygon of the area of the circle
    radius = 0.5 * opening * math.sqrt(2.0 * math.pi / CORNERS / math.sin(2.0 * math.pi / CORNERS))
    inner = np.column_stack([radius * way, np.zeros(CORNERS)])
    outer = np.column_stack([1.5 * WIDTH * way, np.zeros(CORNERS)])
    after = np.roll(np.arange(CORNERS), -1)
    return np.concatenate(
        [
            np.stack([inner, outer, outer[after]], axis=1),
            np.stack([inner, outer[after], inner[after]], axis=1),
        ]
    )


def bed(seed: int, friction: float) -> tuple[Floats, Floats]:
    """Grains at rest in the box with its hole closed."""
    largest = 0.5 * DIAMETER * 2.0 * SIZE_RATIO / (1.0 + SIZE_RATIO)
    found = random_packing(
        3, radius=largest, size_ratio=SIZE_RATIO, box=(WIDTH, WIDTH, FILL), periodic=False, solid_fraction=0.56,
        seed=seed,
    )  # fmt: skip
    places = found.positions - (0.5 * WIDTH, 0.5 * WIDTH, 0.0)
    builder = grain_builder(3, STIFFNESS, friction)
    builder.add_particles(places, found.radii, "grain")
    _sides(builder)
    builder.add_wall(plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), local_damping=0.1)
    rest = 1e-3 * mean_mass(3) * GRAVITY * DIAMETER * len(places)
    for _ in range(30):
        simulation.run(500)
        if simulation.kinetic_energy() < rest:
            break
    return simulation.positions, found.radii


def _sides(builder: AssemblyBuilder) -> None:
    for axis in range(2):
        normal = np.eye(3)[axis]
        builder.add_wall(plane(f"low{axis}", -0.5 * WIDTH * normal, normal))
        builder.add_wall(plane(f"high{axis}", 0.5 * WIDTH * normal, -normal))


def discharge(opening: float, friction: float, places: Floats, radii: Floats) -> Discharge:
    """Open the hole and measure the steady flow."""
    started = time.perf_counter()
    builder = grain_builder(3, STIFFNESS, friction)
    builder.add_particles(places, radii, "grain")
    _sides(builder)
    builder.add_wall(triangles("floor", annulus(opening)))
    builder.add_wall(plane("catcher", (0.0, 0.0, -DROP), (0.0, 0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), buffer=0.2 * DIAMETER)
    mass = simulation.assembly.mass
    middle = (places[:, 2] > 3.0 * DIAMETER) & (places[:, 2] < 12.0 * DIAMETER)
    density = float(mass[middle].sum()) / (WIDTH**2 * 9.0 * DIAMETER)
    each = math.ceil(0.5 * UNIT_TIME / simulation.time_step)
    times, gone, counts = [], [], []
    while simulation.time < BEGIN + MOST:
        simulation.run(each)
        below = simulation.positions[:, 2] < -0.5 * DIAMETER
        times.append(simulation.time)
        gone.append(float(mass[below].sum()))
        counts.append(int(below.sum()))
        if below.mean() > 1.0 - LEAST:
            break
    steady = np.array(times) > BEGIN
    rate = float(np.polyfit(np.array(times)[steady], np.array(gone)[steady], 1)[0])
    passed = int(counts[-1] - np.array(counts)[steady][0])
    return Discharge(opening, rate, density, passed, time.perf_counter() - started, friction)


def beverloo(opening: float, density: float, diameter: float = DIAMETER) -> float:
    """Rate of flow [kg/s] of grains of the bulk density [kg/m3] and the diameter [m] through an opening [m]."""
    return 0.58 * density * math.sqrt(GRAVITY) * (opening - EMPTY * diameter) ** 2.5


def rows_of(runs: list[Discharge]) -> list[Row]:
    """The exponent over all openings, and the rates, of grains of one friction."""
    seconds = sum(run.seconds for run in runs)
    wide = np.array([run.opening for run in runs]) - EMPTY * DIAMETER
    rate = np.array([run.rate for run in runs])
    power = exponent(wide, rate)
    friction = f"friction {runs[0].friction:g}"
    name = f"P31 hopper, D/d {min(OPENINGS):g} to {max(OPENINGS):g}, {friction}"
    rows = [
        Row(
            name,
            "exponent of the rate over D - 1.5 d",
            power,
            2.5,
            power / 2.5 - 1.0,
            0.15 / 2.5,
            seconds,
            BEVERLOO,
        )
    ]
    for run in runs:
        rows.append(
            relative(f"P31 hopper, D/d {run.opening / DIAMETER:g}, {friction}", "rate [kg/s]", run.rate,
                     beverloo(run.opening, run.density), 0.15, run.seconds, BEVERLOO)
        )  # fmt: skip
    return rows
