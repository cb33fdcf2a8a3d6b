"""Columns of grains that collapse when the wall in front of them is gone: run-out over aspect ratio.

2D: discs beside a smooth wall, one half of a symmetric column. The run-out (r - r0)/r0 grows as a for low columns and
as a^(2/3) for tall ones: G. Lube, H. Huppert, R. Sparks and A. Freundt (2005), Collapses of two-dimensional granular
columns, Phys. Rev. E 72:041301; E. Lajeunesse, J. Monnier and G. Homsy (2005), Granular slumping on a horizontal
surface, Phys. Fluids 17:103302; L. Staron and E. Hinch (2005), Study of the collapse of granular columns using
two-dimensional discrete-grain simulation, J. Fluid Mech. 545:1-27 (0.7 for tall ones).
3D: round columns, a^(1/2) for tall ones: G. Lube, H. Huppert, R. Sparks and M. Hallworth (2004), Axisymmetric collapses
of granular columns, J. Fluid Mech. 508:175-199.

The floor is of grains that are held, so that none rolls on. The run-out is that of the grain which is farthest out and
hangs together with the heap, grain touching grain.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geodem.boundaries.walls import plane
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from .granular_grains import DIAMETER, GRAVITY, Floats, grain_builder, mean_mass

SIZE_RATIO = 1.5  # largest over smallest grain
SIDES = 16  # of the prism that a round column is filled into
FLOOR_SPACING = 1.2  # of the held grains, in mean diameters
SMOOTH = {"friction_coefficient": 0.0}
AT_REST = 2e-3  # kinetic energy of a grain over m g d


class Collapse(NamedTuple):
    """A column before and after."""

    aspect: float  # height over half width or radius, settled
    run_out: float  # (r - r0)/r0
    height: float  # of the heap in the middle over r0
    overlap: float  # mean of the contacts while it spreads fastest, over the mean diameter
    grains: int
    seconds: float
    outline: Floats  # (k, d) centres at the end [m]


def half_width(dimension: int, aspect: float, grains: int) -> float:
    """Half width or radius of a column of about so many grains [m]."""
    if dimension == 2:
        area = grains * math.pi / 4.0 / 0.83
        return DIAMETER * math.sqrt(area / aspect)
    volume = grains * math.pi / 6.0 / 0.60
    return DIAMETER * (volume / (math.pi * aspect)) ** (1.0 / 3.0)


def floor(dimension: int, reach: float, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Places and radii of the grains of the floor, whose tops are level at 0."""
    step = FLOOR_SPACING * DIAMETER
    along = np.arange(0.6 * step if dimension == 2 else -reach, reach, step)
    if dimension == 2:
        flat = along[:, None]
    else:
        flat = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
        flat = flat[np.hypot(*flat.T) < reach]
        flat += rng.uniform(-0.1, 0.1, flat.shape) * DIAMETER
    radii = 0.5 * DIAMETER * rng.uniform(0.8, 1.0, len(flat))
    return np.column_stack([flat, -radii]), radii


def packing(dimension: int, wide: float, tall: float, seed: int) -> tuple[Floats, Floats]:
    """Loose grains in the shape of a column, on the floor."""
    largest = 0.5 * DIAMETER * 2.0 * SIZE_RATIO / (1.0 + SIZE_RATIO)
    box = (wide, tall) if dimension == 2 else (2.0 * wide, 2.0 * wide, tall)
    found = random_packing(
        dimension,
        box=box,
        solid_fraction=0.80 if dimension == 2 else 0.58,
        radius=largest,
        size_ratio=SIZE_RATIO,
        periodic=False,
        seed=seed,
    )
    if dimension == 2:
        return found.positions, found.radii
    places = found.positions - (wide, wide, 0.0)
    inside = _prism_distance(places, wide) > found.radii
    return places[inside], found.radii[inside]


def _prism_normals() -> Floats:
    angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _prism_distance(places: Floats, wide: float) -> Floats:
    return np.asarray((wide - places[:, :2] @ _prism_normals().T).min(axis=1))


def released(
    dimension: int, stiffness: float, ground: tuple[Floats, Floats], places: Floats, radii: Floats
) -> ParticleSimulation:
    """Grains on their floor and, in 2D, beside the smooth wall of symmetry; those of the floor come first."""
    builder = grain_builder(dimension, stiffness)
    fixed = builder.add_particles(*ground, "grain")
    axes = dict.fromkeys("xyz"[:dimension], 0.0)
    builder.hold(fixed, **axes, rotation=0.0 if dimension == 2 else (0.0, 0.0, 0.0))
    builder.add_particles(places, radii, "grain")
    up = np.eye(dimension)[-1]
    builder.add_wall(plane("under the floor", -1.05 * DIAMETER * up, up))
    if dimension == 2:
        builder.add_wall(plane("middle", (0.0, 0.0), (1.0, 0.0), contact=SMOOTH))
    return ParticleSimulation(builder.build())


def settled(
    dimension: int, stiffness: float, wide: float, places: Floats, radii: Floats, rest: float
) -> Floats:
    """Where the grains come to rest on a flat floor, behind smooth walls."""
    builder = grain_builder(dimension, stiffness)
    builder.add_particles(places, radii, "grain")
    up = np.eye(dimension)[-1]
    builder.add_wall(plane("floor", 0.0 * up, up))
    if dimension == 2:
        builder.add_wall(plane("middle", (0.0, 0.0), (1.0, 0.0), contact=SMOOTH))
        builder.add_wall(plane("gate", (wide, 0.0), (-1.0, 0.0), contact=SMOOTH))
    else:
        for number, normal in enumerate(_prism_normals()):
            builder.add_wall(plane(f"gate{number}", (*(wide * normal), 0.0), (*-normal, 0.0), contact=SMOOTH))
    simulation = ParticleSimulation(builder.build(), local_damping=0.1)
    for _ in range(60):
        simulation.run(1000)
        if simulation.kinetic_energy() < rest:
            break
    return simulation.positions


def collapse(dimension: int, aspect: float, *, grains: int, stiffness: float, seed: int) -> Collapse:
    """Fill a column, take the wall away and wait until the heap rests."""
    started = time.perf_counter()
    rng = np.random.default_rng(seed)
    wide = half_width(dimension, aspect, grains)
    tall = aspect * wide
    # farther than any of the published run-outs
    far = wide * (1.5 + (3.6 * aspect**0.7 if dimension == 2 else 2.0 * aspect**0.5))
    ground = floor(dimension, far, rng)
    places, radii = packing(dimension, wide, tall, seed)
    fixed = len(ground[1])
    rest = AT_REST * mean_mass(dimension) * GRAVITY * DIAMETER * len(places)
    places = settled(dimension, stiffness, wide, places, radii, rest)
    # the mean height of an upright column is half its height
    high = 2.0 * float(places[:, -1].mean())
    simulation = released(dimension, stiffness, ground, places, radii)
    fall = math.sqrt(high / GRAVITY)
    overlap = 0.0
    each = math.ceil(0.25 * fall / simulation.time_step)
    for look in range(80):
        simulation.run(each)
        if look == 5:  # 1.5 fall times: it spreads fastest
            found = simulation.contacts().overlap
            overlap = float(found[found > 0.0].mean() / DIAMETER)
        if look >= 8 and simulation.kinetic_energy() < rest:
            break
    end = simulation.positions
    heap = _heap(simulation, fixed)
    if dimension == 2:
        reach = end[:, 0] + np.concatenate([ground[1], radii])
        run_out = float(reach[heap].max())
    else:
        # the front of a round heap has fingers: the mean of the farthest grains of 24 directions
        away = np.hypot(end[heap, 0], end[heap, 1])
        sector = np.floor((np.arctan2(end[heap, 1], end[heap, 0]) / (2.0 * math.pi) % 1.0) * 24.0).astype(int)
        run_out = float(np.mean([away[sector == k].max() for k in range(24)])) + 0.5 * DIAMETER
    middle = np.hypot(*end[heap, :-1].T) if dimension == 3 else end[heap, 0]
    height = float(end[heap][middle < 2.0 * DIAMETER, -1].max())
    return Collapse(
        high / wide,
        run_out / wide - 1.0,
        height / wide,
        overlap,
        len(places),
        time.perf_counter() - started,
        end[fixed:],
    )


def _heap(simulation: ParticleSimulation, fixed: int) -> NDArray[np.int64]:
    """Grains that hang together with most of the others, those of the floor left out."""
    found = simulation.contacts()
    pairs = found.pairs[(found.overlap > -0.02 * DIAMETER) & (found.pairs >= fixed).all(axis=1)]
    n = simulation.assembly.particles
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    main = np.bincount(label[fixed:]).argmax()
    return np.flatnonzero((label == main) & (np.arange(n) >= fixed))


def stiffness_for(height: float) -> float:
    """kn d/(m g) for a column of so many grains' height: contacts at its foot overlap by a few thousandths."""
    return max(2e4, 500.0 * height)
