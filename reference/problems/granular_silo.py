"""A square silo whose floor gives way slowly: the stress at depth saturates as Janssen says.

H. A. Janssen (1895), Versuche ueber Getreidedruck in Silozellen, Z. VDI 39:1045-1049. Of a silo of width D (a square
has the perimeter over area of a circle, 4/D) the vertical stress at depth z is
sigma = rho g D/(4 mu K) (1 - exp(-4 mu K z/D)). K, the horizontal stress on the walls over the vertical stress, is
measured, as is the bulk density rho; mu is the friction coefficient of the walls. The floor moves down so that friction
is mobilised on them all the way.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from geodem.boundaries.walls import plane
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from .granular_grains import DIAMETER, GRAVITY, Floats, grain_builder, mean_mass
from .rows import Row, relative

WIDTH = 8.0 * DIAMETER
DEPTH = 6.0  # of the fill over the width
THROWN, FILLED = 0.35, 0.57  # solid fractions: of the loose grains, and about that once they are at rest
SLICES = 24  # by depth
WALL_FRICTION = 0.25  # half that of the grains, so that they slide along the walls and do not roll
STIFFNESS = 1e5  # kn d/(m g): overlaps below 1e-3 d
SIZE_RATIO = 1.2
FLOOR_SPEED = 0.01 * math.sqrt(GRAVITY * DIAMETER)
MOBILISED, MEASURED = 0.6 * DIAMETER, 1.2 * DIAMETER  # ways of the floor: friction is mobilised; the end
SNAPSHOTS = 20
SATURATED = (0.5, 0.85)  # depths over the whole within which the stress is taken as saturated
JANSSEN = "Janssen 1895, K measured"


class Profile(NamedTuple):
    """Means over slices by depth and over snapshots."""

    depth: Floats  # of the lower faces of the slices [m]
    vertical: Floats  # stress at these depths [Pa]
    horizontal: Floats  # mean stress on the walls of the slices [Pa]
    shear: Floats  # upward stress on the walls of the slices [Pa]
    density: float  # bulk [kg/m3]
    floor: float  # stress on the floor by its force [Pa]
    fill: float  # depth of the whole [m]
    grains: int
    seconds: float


def silo(seed: int, *, depth: float = DEPTH) -> ParticleSimulation:
    """The silo, filled and at rest, friction not yet mobilised, the floor about to move.

    Grains fall into it from a loose state: a dense one would swell upwards and leave its walls under too high a thrust,
    which a plug that slides down keeps.
    """
    largest = 0.5 * DIAMETER * 2.0 * SIZE_RATIO / (1.0 + SIZE_RATIO)
    found = random_packing(
        3, radius=largest, size_ratio=SIZE_RATIO, box=(WIDTH, WIDTH, depth * WIDTH * FILLED / THROWN), periodic=False,
        solid_fraction=THROWN, seed=seed,
    )  # fmt: skip
    places = found.positions
    rest = 1e-3 * mean_mass(3) * GRAVITY * DIAMETER * len(places)
    for speed in (0.0, -FLOOR_SPEED):
        builder = grain_builder(3, STIFFNESS)
        builder.add_particles(places, found.radii, "grain")
        contact = {"friction_coefficient": WALL_FRICTION}
        for axis in range(2):
            normal = np.eye(3)[axis]
            builder.add_wall(plane(f"low{axis}", (0.0, 0.0, 0.0), normal, contact=contact))
            builder.add_wall(plane(f"high{axis}", WIDTH * normal, -normal, contact=contact))
        builder.add_wall(plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), velocity=(0.0, 0.0, speed)))
        simulation = ParticleSimulation(builder.build(), local_damping=0.1 if speed == 0.0 else 0.0)
        if speed == 0.0:
            for _ in range(60):
                simulation.run(1000)
                if simulation.kinetic_energy() < rest:
                    break
            places = simulation.positions
    return simulation


def profile(simulation: ParticleSimulation) -> Profile:
    """Move the floor down until friction is mobilised, then read stresses at intervals."""
    started = time.perf_counter()
    simulation.run(math.ceil(MOBILISED / FLOOR_SPEED / simulation.time_step))
    each = math.ceil((MEASURED - MOBILISED) / SNAPSHOTS / FLOOR_SPEED / simulation.time_step)
    radii, mass = simulation.assembly.radii, simulation.assembly.mass
    weights, thrusts, drags, floors, fills = [], [], [], [], []
    for _ in range(SNAPSHOTS):
        simulation.run(each)
        x = simulation.positions
        top = float(np.quantile(x[:, 2] + radii, 0.995))
        bottom = -FLOOR_SPEED * simulation.time
        slice_of = np.clip(((top - x[:, 2]) / (top - bottom) * SLICES).astype(int), 0, SLICES - 1)
        on_walls = _wall_forces(simulation)
        beside = np.zeros((len(x), 2))
        for axis in range(2):
            inward = np.where(x[:, axis] < 0.5 * WIDTH, 1.0, -1.0)
            away = np.minimum(x[:, axis], WIDTH - x[:, axis])
            beside[:, axis] = np.where(away < 1.02 * radii, inward * on_walls[:, axis], 0.0)
        near_wall = (beside != 0.0).any(axis=1) & (x[:, 2] - bottom > 1.02 * radii)
        weights.append(np.bincount(slice_of, GRAVITY * mass, SLICES))
        thrusts.append(np.bincount(slice_of, beside.sum(axis=1), SLICES))
        drags.append(np.bincount(slice_of, np.where(near_wall, on_walls[:, 2], 0.0), SLICES))
        floors.append(-simulation.wall_force("floor")[2])
        fills.append(top - bottom)
    fill = float(np.mean(fills))
    weight, thrust, drag = (np.mean(part, axis=0) for part in (weights, thrusts, drags))
    face = 4.0 * WIDTH * fill / SLICES
    return Profile(
        fill * np.arange(1, SLICES + 1) / SLICES,
        np.cumsum(weight - drag) / WIDTH**2,
        thrust / face,
        drag / face,
        float(weight[4:-2].sum() / GRAVITY / (WIDTH**2 * fill / SLICES * (SLICES - 6))),
        float(np.mean(floors)) / WIDTH**2,
        fill,
        len(mass),
        time.perf_counter() - started,
    )


def mean_profile(profiles: list[Profile]) -> Profile:
    """Means over seeds; the numbers of grains and the seconds are added up."""
    means = [np.mean(part, axis=0) for part in zip(*profiles, strict=True)]
    count = sum(one.grains for one in profiles)
    return Profile(*means)._replace(grains=count, seconds=sum(one.seconds for one in profiles))


def _wall_forces(simulation: ParticleSimulation) -> Floats:
    """Forces (n, 3) of walls on grains: their resultants less what other grains and gravity do [N]."""
    found = simulation.contacts()
    normal, shear = simulation.contact_forces()
    a, b = found.pairs.T
    x = simulation.positions
    along = x[b] - x[a]
    along /= np.linalg.norm(along, axis=1)[:, None]
    force = shear - normal[:, None] * along
    total = simulation.forces[:, :3] - simulation.assembly.mass[:, None] * simulation.assembly.gravity
    np.add.at(total, a, -force)
    np.add.at(total, b, force)
    return total


def janssen(found: Profile) -> tuple[float, float]:
    """K in the saturated part, and the saturated stress that Janssen's formula gives with it [Pa]."""
    inside = _saturated(found)
    middle = 0.5 * (found.vertical + np.concatenate([[0.0], found.vertical[:-1]]))
    ratio = float(found.horizontal[inside].sum() / middle[inside].sum())
    return ratio, saturation(found.density, WIDTH, WALL_FRICTION, ratio)


def saturation(density: float, width: float, friction: float, ratio: float) -> float:
    """Vertical stress far below the surface, rho g D/(4 mu K) [Pa]."""
    return density * GRAVITY * width / (4.0 * friction * ratio)


def _saturated(found: Profile) -> Floats:
    share = found.depth / found.fill
    return np.asarray((share > SATURATED[0]) & (share <= SATURATED[1]))


def rows_of(found: Profile) -> list[Row]:
    """Saturation and its approach."""
    ratio, expected = janssen(found)
    saturated = float(found.vertical[_saturated(found)].mean())
    name = "P31 silo, mean of three seeds"
    rows = [
        relative(name, "saturated vertical stress [Pa]", saturated, expected, 0.15, found.seconds, JANSSEN),
        relative(name, "stress on the floor, by its force [Pa]", found.floor, expected, 0.15, found.seconds, JANSSEN),
        relative(name, "share of rho g z borne by the walls at the floor",
                 1.0 - found.floor / (found.density * GRAVITY * found.fill),
                 1.0 - expected / (found.density * GRAVITY * found.fill), 0.05, found.seconds, JANSSEN),
    ]  # fmt: skip
    for widths in (1.0, 2.0):
        value = float(np.interp(widths * WIDTH, found.depth, found.vertical))
        formula = expected * (1.0 - math.exp(-4.0 * WALL_FRICTION * ratio * widths))
        rows.append(
            relative(
                name, f"stress at a depth of {widths:g} D [Pa]", value, formula, 0.15, found.seconds, JANSSEN
            )
        )
    drag, thrust = (float(part[_saturated(found)].sum()) for part in (found.shear, found.horizontal))
    rows.append(
        relative(name, "friction on the walls over what they can bear", drag / thrust / WALL_FRICTION, 1.0, 0.15,
                 found.seconds, "mobilised all the way")
    )  # fmt: skip
    return rows
