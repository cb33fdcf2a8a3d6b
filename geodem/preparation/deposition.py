"""Deposition under gravity: particles rain into a box and settle."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..assembly import Wall
from ..boundaries.walls import plane
from ..builders.packings import Packing
from ..builders.random_addition import scatter_particles
from ..builders.sizes import Sizes
from ..errors import InputError
from ..particle_simulation import ParticleSimulation
from .grains import FRICTION, Grains
from .sample import PreparedSample, measure_sample
from .settling import Checkpoint, Progress, refuse_run, resumed, run_to_rest

Floats = NDArray[np.float64]

RAIN = {2: 0.4, 3: 0.25}
"""Solid fraction of the rain: as dense as is quickly made, so that the last particles fall not much farther."""
LOST = 2.0
"""Heights of the rain below the lowest wall at which a particle will not come back."""
SLOW = 1e-2
"""Speed of what counts as at rest, over that of a fall through a mean radius."""
EDGE = 2.0
"""Mean diameters at the floor and at the surface that are left out of the porosity."""


def deposit(
    dimension: int,
    grains: Grains,
    sizes: Sizes,
    *,
    width: Sequence[float],
    count: int,
    local_damping: float,
    global_damping: float = 0.0,
    gravity: float = 9.81,
    friction: float | None = None,
    wall_friction: float | None = None,
    walls: Sequence[Wall] | None = None,
    rain_fraction: float | None = None,
    tolerance: float = 1e-3,
    most_steps: int = 2_000_000,
    seed: int,
    checkpoint: Path | str | None = None,
    checkpoint_seconds: float = 60.0,
    progress: Progress | None = None,
) -> PreparedSample:
    """Let particles rain into a box from the origin up, and settle to rest.

    They begin at random places without overlap, in a column over the whole width, and all fall at once. It is true
    motion: real masses, and the damping that is given and no other. Local damping slows the fall too, to 1 - alpha of
    gravity.

    Parameters
    ----------
    dimension : int
        2 or 3; gravity points down y or z.
    grains : Grains
    sizes : Sizes
        See `geodem.builders.sizes`.
    width : (d - 1,) float
        Inner sides of the box [m].
    count : int
    local_damping, global_damping : float
        Cundall's coefficient [-] and the mass-proportional one [1/s].
    gravity : float [m/s2]
    friction, wall_friction : float, optional
        Between particles and against the walls while they settle [-]; those of `grains` where they are left out. 0
        makes a dense sample, much friction a loose one.
    walls : sequence of Wall, optional
        Instead of a box with a floor and sides (named "floor", "left", "right", "front", "back"): what the rain falls
        into. It begins above the origin. Porosity and mean stress are then not known.
    rain_fraction : float, optional
        Solid fraction of the rain [-]; 0.4 in 2D and 0.25 in 3D.
    tolerance : float
        Unbalanced ratio at rest [-]; no particle may be faster than a hundredth of a fall through its radius, either.
    most_steps : int
    seed : int
    checkpoint : path, optional
        Written every `checkpoint_seconds` and in the end. Where there is one of this preparation it is gone on with, to
        the same bits.
    progress : callable, optional
        Is told the steps and the unbalanced ratio now and then.

    Returns
    -------
    PreparedSample
        `reached` tells whether it is at rest.

    Raises
    ------
    InputError
        Numbers that cannot be; a box narrower than the largest particle; a checkpoint of another preparation.
    """
    refuse_run(tolerance=tolerance, most_steps=most_steps, share=0.5)
    if not (math.isfinite(gravity) and gravity > 0.0):
        raise InputError("gravity", "nothing falls without it", "Give 9.81 m/s2.", value=gravity)
    begun = time.perf_counter()
    rain = _rain(dimension, sizes, width, count, rain_fraction, seed)
    used = grains.with_friction(friction)
    boxed = walls is None
    if walls is None:
        walls = _box(rain.box, _wall_contact(used, wall_friction))
    elif wall_friction is not None:
        raise InputError(
            "wall_friction",
            "these walls are your own",
            "Give each of them contact={'friction_coefficient': ...}.",
        )
    down = np.zeros(dimension)
    down[-1] = -gravity
    assembly = used.assembly(rain.positions, rain.radii, gravity=down, walls=walls)
    simulation = ParticleSimulation(
        assembly, time_step=used.time_step(assembly), local_damping=local_damping, global_damping=global_damping,
        orientation=False,
    )  # fmt: skip
    kept = None if checkpoint is None else Checkpoint(Path(checkpoint), checkpoint_seconds)
    simulation = resumed(kept, simulation)
    slow = SLOW * math.sqrt(2.0 * gravity * float(rain.radii.mean()))
    why = run_to_rest(
        simulation, tolerance=tolerance, most_steps=most_steps, slow=slow,
        deepest=_lowest(walls) - LOST * float(rain.box[-1]), progress=progress, checkpoint=kept,
    )  # fmt: skip
    if kept is not None:
        kept.look(simulation, now=True)
    middle, porosity = None, math.nan
    if boxed:
        middle = middle_of_heap(simulation.positions, rain.radii, rain.box[:-1])
        porosity = 1.0 - solid_fraction_between(simulation.positions, rain.radii, middle)
    return measure_sample(
        simulation,
        used,
        porosity=porosity,
        container=middle,
        method="gravity deposition",
        target="unbalanced ratio",
        wanted=tolerance,
        got=simulation.unbalanced_ratio(),
        reached=not why,
        reason=why or "at rest",
        steps=simulation.steps,
        seconds=time.perf_counter() - begun,
        seed=rain.seed,
    )


def _rain(
    dimension: int, sizes: Sizes, width: Sequence[float], count: int, fraction: float | None, seed: int
) -> Packing:
    """Particles in a column over the width, none of them below the floor."""
    if dimension not in (2, 3):
        raise InputError("dimension", "particles are discs or spheres", "Give 2 or 3.", value=dimension)
    sides = np.asarray(width, dtype=np.float64)
    if sides.shape != (dimension - 1,) or not (np.isfinite(sides) & (sides > 0.0)).all():
        raise InputError(
            "width",
            f"the box has {dimension - 1} of them, positive",
            f"Give {dimension - 1} in m.",
            value=width,
        )
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError("count", "this is not a whole number from 1", "Give 1000.", value=count)
    share = RAIN[dimension] if fraction is None else fraction
    if not (math.isfinite(share) and 0.0 < share < 1.0):
        raise InputError("rain_fraction", "this is no share of a box", "Give 0.2.", value=share)
    # centres are in the box less a radius on every side, so that is what the fraction is of
    room = np.maximum(sides - sizes.largest, 0.1 * sides)
    height = count * sizes.mean_volume(dimension) / (share * float(np.prod(room))) + sizes.largest
    height = max(height, 2.0 * sizes.largest)
    return scatter_particles(dimension, sizes, box=(*sides, height), count=count, periodic=False, seed=seed)


def _wall_contact(grains: Grains, friction: float | None) -> dict[str, float]:
    """What walls have of their own: a friction coefficient, where it is given."""
    given = {} if friction is None else grains.with_friction(friction).contact
    return {FRICTION: given[FRICTION]} if FRICTION in given else {}


def _box(sides: Floats, contact: dict[str, float]) -> list[Wall]:
    """A floor and sides, each a wall of its own."""
    d = len(sides)
    axes = np.eye(d)
    walls = [plane("floor", np.zeros(d), axes[-1], contact=contact)]
    for axis, (low, high) in enumerate([("left", "right"), ("front", "back")][: d - 1]):
        walls.append(plane(low, np.zeros(d), axes[axis], contact=contact))
        walls.append(plane(high, sides[axis] * axes[axis], -axes[axis], contact=contact))
    return walls


def _lowest(walls: Sequence[Wall]) -> float:
    """Height of the lowest corner of walls, or of the lowest point given for a plane [m]."""
    heights = [0.0]
    for wall in walls:
        points = (wall.planes[:, 0], wall.segments.reshape(-1, 2), wall.triangles.reshape(-1, 3))
        heights += [float(part[:, -1].min()) for part in points if len(part)]
    return min(heights)


def middle_of_heap(positions: Floats, radii: Floats, width: Floats) -> Floats:
    """Corners (2, d) [m] of the heap without `EDGE` diameters at its floor and below its surface.

    The surface is that height which nineteen in twenty columns, two diameters wide, exceed. A heap too low for that is
    measured from the floor to the surface.
    """
    diameter = 2.0 * float(radii.mean())
    column = np.zeros(len(radii), dtype=np.int64)
    columns = 1
    for axis, side in enumerate(width):
        count = max(1, int(side / (2.0 * diameter)))
        inside = np.clip((positions[:, axis] / side * count).astype(np.int64), 0, count - 1)
        column = column * count + inside
        columns *= count
    top = np.zeros(columns)
    np.maximum.at(top, column, positions[:, -1] + radii)
    surface = float(np.quantile(top, 0.05))
    low, high = EDGE * diameter, surface - EDGE * diameter
    if high - low < EDGE * diameter:
        low, high = 0.0, max(surface, diameter)
    return np.array([[0.0] * len(width) + [low], [*width, high]])


def solid_fraction_between(positions: Floats, radii: Floats, corners: Floats) -> float:
    """Share of a layer between two heights that particles fill [-], each cut exactly; what overlaps counts twice."""
    (low, high), sides = corners[:, -1], corners[1, :-1] - corners[0, :-1]
    below = np.clip((np.array([[low], [high]]) - positions[:, -1]) / radii, -1.0, 1.0)
    if positions.shape[1] == 3:
        # volume of a sphere below h: pi (2 + 3 h - h^3)/3, of radius 1
        volume = np.pi / 3.0 * (2.0 + 3.0 * below - below**3) * radii**3
    else:
        volume = (np.pi / 2.0 + np.arcsin(below) + below * np.sqrt(1.0 - below**2)) * radii**2
    return float((volume[1] - volume[0]).sum() / (np.prod(sides) * (high - low)))
