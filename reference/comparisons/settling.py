"""Three thousand spheres fall into a box: geodem beside YADE and LIGGGHTS, three seeds, by their statistics.

All begin at the same random places. What they collide with in the end is chaotic, so only means can be compared.
The side walls are smooth, so that the floor bears the whole weight, which is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from geodem.boundaries.walls import plane
from geodem.builders.random_addition import scatter_particles
from geodem.builders.sizes import uniform
from geodem.preparation.deposition import solid_fraction_between

from ..posed import Posed, Trajectory
from . import grains
from .comparison import Row
from .grains import DIAMETER, GRAVITY, SMOOTH, AtRest
from .scatter import Numbers, kolmogorov_smirnov, row_of_distance, rows_of_means, told_apart

CODES = ("yade", "liggghts")
SEEDS = (1, 2, 3)
COUNT = 3000
SIDE = 14.0  # of the box in mean diameters
LOOSE = 0.25  # solid fraction of the start
DURATION = {"yade": 28.0, "liggghts": 84.0}
"""In sqrt(d/g). They have fallen after 10; then the heap swings as a whole, which dashpots damp slowly."""
CORE = (3.0, 10.0)  # heights between which the solid fraction is measured, in mean diameters
OTHER_FRICTION = 0.3
WEIGHT_BOUND = 1e-3


def settling(
    code: str, seed: int, *, count: int = COUNT, side: float = SIDE, duration: float | None = None,
    friction: float = grains.FRICTION,
) -> Posed:  # fmt: skip
    """Spheres at random places above a floor, in the terms of a code."""
    low, high = (0.5 * DIAMETER * (1.0 + sign * grains.SPREAD) for sign in (-1.0, 1.0))
    volume = count * math.pi / 6.0 * DIAMETER**3 * (1.0 + grains.SPREAD**2)
    wide = side * DIAMETER
    tall = volume / LOOSE / wide**2
    start = scatter_particles(
        3, uniform(low, high), box=(wide, wide, tall), count=count, periodic=False, seed=seed
    )
    b = grains.builder_of(code, friction)
    b.add_particles(start.positions, start.radii, "grain")
    b.add_wall(plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    b.add_wall(plane("lid", (0.0, 0.0, 1.1 * tall), (0.0, 0.0, -1.0)))
    for axis in (0, 1):
        for at, sense in ((0.0, 1.0), (wide, -1.0)):
            point, normal = np.zeros(3), np.zeros(3)
            point[axis], normal[axis] = at, sense
            b.add_wall(plane(f"{'xy'[axis]}{at > 0.0:d}", point, normal, contact=SMOOTH))
    name = f"settling of {count} spheres, seed {seed}, friction {friction:g}"
    return grains.posed_for(name, code, b.build(), duration or DURATION[code], frames=8)


def measured(posed: Posed, run: Trajectory) -> tuple[AtRest, Numbers, float]:
    """The last frame, the numbers that are compared, and the force on the floor over the weight."""
    rest = grains.at_rest(posed, run)
    wide = float(np.max([wall.planes[0, 0, 0] for wall in posed.assembly.walls]))
    low, high = CORE[0] * DIAMETER, min(CORE[1] * DIAMETER, 0.7 * float(rest.positions[:, 2].max()))
    corners = np.array([[0.0, 0.0, low], [wide, wide, high]])
    numbers = {
        "height of the centre of mass in diameters": float(
            np.average(rest.positions[:, 2], weights=rest.mass) / DIAMETER
        ),
        "solid fraction between two heights": solid_fraction_between(rest.positions, rest.radii, corners),
        **rest.numbers,
    }
    if run.wall_forces is None:
        raise ValueError(f"{posed.name}: {run.code} tells no forces on walls")
    return rest, numbers, -float(run.wall_forces[-1, 0, 2]) / float(rest.mass.sum() * GRAVITY)


def compare(
    codes: Sequence[str], *, seeds: Sequence[int] = SEEDS, count: int = COUNT, side: float = SIDE,
    duration: float | None = None,
) -> list[Row]:  # fmt: skip
    """Rows of all numbers, the forces' distribution, the weight, rest and times; beside LIGGGHTS a changed friction."""
    shape: dict[str, Any] = {"count": count, "side": side, "duration": duration}
    rows = []
    for code in codes:
        scenes = [settling(code, seed, **shape) for seed in seeds]
        our_runs = [grains.run("geodem", one) for one in scenes]
        their_runs = [grains.run(code, one) for one in scenes]
        ours = [measured(one, run) for one, run in zip(scenes, our_runs, strict=True)]
        theirs = [measured(one, run) for one, run in zip(scenes, their_runs, strict=True)]
        about: dict[str, Any] = {
            "scene": f"{count:,} spheres settle, {grains.said(code)}", "code": code, "version": their_runs[0].version,
            "law": their_runs[0].law, "steps": scenes[0].steps, "particles": count,
            "seconds": sum(run.seconds for run in our_runs),
        }  # fmt: skip
        rows += rows_of_means(about, [one[1] for one in ours], [one[1] for one in theirs])
        rows.append(
            row_of_distance(
                about, "distributions of the normal forces (Kolmogorov-Smirnov)",
                [one[0].forces for one in ours], [one[0].forces for one in theirs], kolmogorov_smirnov,
            )
        )  # fmt: skip
        rows += state_rows(about, [one[0] for one in ours], [one[0] for one in theirs])
        # unlike max, it keeps what is no number
        weight = float(np.max([abs(one[2] - 1.0) for one in (*ours, *theirs)]))
        rows.append(
            Row(
                **{**about, "scene": f"{about['scene']}: force on the floor"},
                quantity="over the weight, largest of |ratio - 1| in both codes", difference=weight,
                bound=WEIGHT_BOUND,
            )
        )  # fmt: skip
        words, ratio = grains.seconds_of(our_runs, their_runs)
        rows.append(
            Row(
                **{**about, "scene": f"{about['scene']}: time"},
                quantity=words,
                difference=ratio,
                bound=math.nan,
            )
        )
        if code == "liggghts":
            others = [settling(code, seed, friction=OTHER_FRICTION, **shape) for seed in seeds]
            changed = [measured(one, grains.run("geodem", one))[1] for one in others]
            words = f"a friction of {OTHER_FRICTION:g} in place of {grains.FRICTION:g}"
            rows.append(told_apart(about, words, [one[1] for one in ours], changed))
    return rows


def state_rows(about: dict[str, Any], ours: Sequence[AtRest], theirs: Sequence[AtRest]) -> list[Row]:
    """Whether all is at rest, and how far contacts overlap."""
    both = [*ours, *theirs]
    said = {
        "kinetic energy of the slowest 95 % of the grains over m g d, each; largest in both codes": (
            float(np.max([one.kinetic for one in both])),
            grains.AT_REST,
        ),
        "mean overlap over the mean diameter, largest in both codes": (
            float(np.max([one.overlap for one in both])),
            0.01,
        ),
    }
    return [
        Row(
            **{**about, "scene": f"{about['scene']}: {'rest' if 'energy' in quantity else 'overlap'}"},
            quantity=quantity,
            difference=value,
            bound=bound,
        )
        for quantity, (value, bound) in said.items()
    ]
