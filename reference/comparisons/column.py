"""A column of five thousand spheres collapses: geodem beside YADE and LIGGGHTS, three seeds, by their statistics.

The column stands in a slot between smooth walls, on a floor of held spheres, so that none rolls on. geodem lets it
settle behind a smooth gate; its positions are handed to all codes, at rest and without memory, and the gate is gone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from geodem.assembly import Assembly
from geodem.boundaries.walls import plane
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from ..posed import Floats, Posed, Trajectory
from ..results_file import load_rows, store_rows
from . import column_picture, grains
from .comparison import Row
from .grains import DIAMETER, GRAVITY, SMOOTH, UNIT_TIME, AtRest
from .scatter import Numbers, kolmogorov_smirnov, row_of_distance, rows_of_means, told_apart
from .settling import state_rows

CODES = ("yade", "liggghts")
SEEDS = (1, 2, 3)
COUNT = 5000
WIDTH = 24.0  # of the column in mean diameters; a multiple of FLOOR_SPACING
SLOT = 6.0  # between the smooth walls
FAR = 96.0  # to where the floor goes
FLOOR_SPACING = 1.2
SETTLING = 12.0  # time in sqrt(d/g)
DURATION = 30.0  # five times what a grain needs to fall from the top
LOCAL_DAMPING = 0.02
"""Of the collapse. It acts against all that moves by a share of the forces on it, which grow with the pressure: with
0.2, what flows twenty grains deep is held back by several times its weight."""
FRAMES = 24
BIN = 2.0  # of the profile, in mean diameters
OTHER_FRICTION = 0.3  # three seeds do not tell 0.4 from 0.5
CURVES = "column-curves"
"""File of results that holds the profiles, so that all codes can be drawn into one picture."""


@dataclass(frozen=True)
class Shape:
    """How many grains, and in what slot; lengths in mean diameters, times in sqrt(d/g)."""

    count: int = COUNT
    width: float = WIDTH
    slot: float = SLOT
    far: float = FAR
    settling: float = SETTLING
    duration: float = DURATION


SHAPE = Shape()


@dataclass(frozen=True)
class Collapse:
    """A run of one code.

    Attributes
    ----------
    rest : grains.AtRest
    numbers : dict of float
    height : (b,)
        Solid volume above every `BIN` of the floor, as a height in mean diameters of grains at a solid fraction of 0.6.
    times, front : (f,)
        In sqrt(d/g); place of the 95th percentile over the width of the column.
    """

    rest: AtRest
    numbers: Numbers
    height: Floats
    times: Floats
    front: Floats


def slot(
    code: str, ground: tuple[Floats, Floats], places: Floats, radii: Floats, shape: Shape, *, gate: bool,
    friction: float = grains.FRICTION,
) -> Assembly:  # fmt: skip
    """Grains on a floor of held ones, which come first, between smooth walls."""
    b = grains.builder_of(code, friction)
    fixed = b.add_particles(*ground, "grain")
    b.hold(fixed, x=0.0, y=0.0, z=0.0, rotation=(0.0, 0.0, 0.0))
    b.add_particles(places, radii, "grain")
    end = shape.width if gate else shape.far
    top = 1.2 * float(places[:, 2].max()) + 5.0 * DIAMETER
    for name, point, normal in (
        ("under the floor", (0.0, 0.0, -1.2), (0, 0, 1)),
        ("back", (0.0, 0.0, 0.0), (1, 0, 0)),
        ("gate" if gate else "end", (end, 0.0, 0.0), (-1, 0, 0)),
        ("left", (0.0, 0.0, 0.0), (0, 1, 0)),
        ("right", (0.0, shape.slot, 0.0), (0, -1, 0)),
        ("lid", (0.0, 0.0, top / DIAMETER), (0, 0, -1)),
    ):
        b.add_wall(plane(name, np.array(point) * DIAMETER, normal, contact=SMOOTH))
    return b.build()


def floor(shape: Shape, rng: np.random.Generator, far: float) -> tuple[Floats, Floats]:
    """Places and radii of the held grains, whose tops are level at 0."""
    along = np.arange(0.6, far - 0.6, FLOOR_SPACING)
    across = np.arange(0.6, shape.slot - 0.5, FLOOR_SPACING)
    flat = np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1).reshape(-1, 2)
    flat = flat + rng.uniform(-0.08, 0.08, flat.shape)
    radii = 0.5 * rng.uniform(0.8, 1.0, len(flat))
    return np.column_stack([flat, -radii]) * DIAMETER, radii * DIAMETER


@cache
def settled(seed: int, shape: Shape) -> tuple[tuple[Floats, Floats], Floats, Floats]:
    """Floor, places and radii of a column at rest behind its gate, made by geodem with local damping."""
    rng = np.random.default_rng(seed)
    ground = floor(shape, rng, shape.far)
    largest = 0.5 * DIAMETER * (1.0 + grains.SPREAD)
    volume = 1.02 * shape.count * math.pi / 6.0 * (1.0 + grains.SPREAD**2)
    box = (shape.width, shape.slot, volume / 0.55 / shape.width / shape.slot)
    found = random_packing(
        3, radius=largest, size_ratio=(1.0 + grains.SPREAD) / (1.0 - grains.SPREAD),
        box=tuple(DIAMETER * side for side in box), solid_fraction=0.55, periodic=False, seed=seed,
    )  # fmt: skip
    lowest = np.argsort(found.positions[:, 2])[: shape.count]
    places, radii = found.positions[lowest], found.radii[lowest]
    # a whole number of held grains stands before the gate, and none in it
    before = ground[0][:, 0] < shape.width * DIAMETER
    assembly = slot("yade", (ground[0][before], ground[1][before]), places, radii, shape, gate=True)
    simulation = ParticleSimulation(
        assembly, time_step=grains.TIME_STEP, local_damping=grains.LOCAL_DAMPING, orientation=False
    )
    simulation.run(math.ceil(shape.settling * UNIT_TIME / grains.TIME_STEP))
    return ground, simulation.positions[int(before.sum()) :].copy(), radii


def column(code: str, seed: int, shape: Shape = SHAPE, *, friction: float = grains.FRICTION) -> Posed:
    """The settled column with its gate gone, in the terms of a code."""
    ground, places, radii = settled(seed, shape)
    assembly = slot(code, ground, places, radii, shape, gate=False, friction=friction)
    name = f"column of {len(radii)} spheres, seed {seed}, friction {friction:g}"
    return grains.posed_for(name, code, assembly, shape.duration, FRAMES, LOCAL_DAMPING)


def measured(posed: Posed, run: Trajectory, shape: Shape = SHAPE) -> Collapse:
    """What is compared of a run."""
    a = posed.assembly
    fixed = int(a.held.all(axis=1).sum())
    rest = grains.at_rest(posed, run, fixed)
    x, volume = run.positions[:, fixed:], a.radii[fixed:] ** 3 * 4.0 / 3.0 * math.pi
    start = a.positions[fixed:]
    front: Floats = np.asarray(np.percentile(x[:, :, 0], 95.0, axis=1) / (shape.width * DIAMETER))
    edges = np.arange(0.0, shape.far + BIN, BIN) * DIAMETER
    above, _ = np.histogram(x[-1, :, 0], bins=edges, weights=volume)
    height = above / (0.6 * BIN * shape.slot * DIAMETER**2) / DIAMETER
    potential = float(a.mass[fixed:] @ start[:, 2])
    kinetic = 0.5 * np.einsum("n,fnk->f", a.mass[fixed:], run.velocities[:, fixed:] ** 2) / GRAVITY
    numbers = {
        "run-out of the nearest 95 % over the width of the column": float(front[-1]),
        "run-out of the nearest 99 % over the width of the column": float(
            np.percentile(x[-1, :, 0], 99.0) / (shape.width * DIAMETER)
        ),
        "height at the back wall in diameters": float(height[:2].mean()),
        "potential energy left, over that at the start": float(a.mass[fixed:] @ x[-1, :, 2]) / potential,
        "largest kinetic energy of the frames over the potential energy at the start": float(
            kinetic.max() / potential
        ),
        **rest.numbers,
    }
    times: Floats = np.asarray(run.steps * posed.time_step / UNIT_TIME, dtype=np.float64)
    return Collapse(rest, numbers, height, times, front)


def apart_in_height(one: Floats, other: Floats) -> float:
    """Root mean square difference of two profiles over the larger mean height [-]."""
    return float(np.sqrt(((one - other) ** 2).mean()) / max(one.mean(), other.mean()))


def compare(
    codes: Sequence[str], *, seeds: Sequence[int] = SEEDS, shape: Shape = SHAPE, keep: bool = True
) -> list[Row]:
    """Rows of all numbers, profile, forces, rest and times; `keep`: profiles are stored and drawn."""
    rows = []
    for code in codes:
        scenes = [column(code, seed, shape) for seed in seeds]
        our_runs = [grains.run("geodem", one) for one in scenes]
        their_runs = [grains.run(code, one) for one in scenes]
        ours = [measured(one, run, shape) for one, run in zip(scenes, our_runs, strict=True)]
        theirs = [measured(one, run, shape) for one, run in zip(scenes, their_runs, strict=True)]
        count = len(ours[0].rest.radii)
        about: dict[str, Any] = {
            "scene": f"column of {count:,} spheres, {grains.said(code, LOCAL_DAMPING)}", "code": code,
            "version": their_runs[0].version, "law": their_runs[0].law, "steps": scenes[0].steps, "particles": count,
            "seconds": sum(run.seconds for run in our_runs),
        }  # fmt: skip
        rows += rows_of_means(about, [one.numbers for one in ours], [one.numbers for one in theirs])
        rows.append(
            row_of_distance(
                about, "profiles of the heap, over the mean height",
                [one.height for one in ours], [one.height for one in theirs], apart_in_height,
            )
        )  # fmt: skip
        rows.append(
            row_of_distance(
                about, "distributions of the normal forces (Kolmogorov-Smirnov)",
                [one.rest.forces for one in ours], [one.rest.forces for one in theirs], kolmogorov_smirnov,
            )
        )  # fmt: skip
        rows += state_rows(about, [one.rest for one in ours], [one.rest for one in theirs])
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
            others = [column(code, seed, shape, friction=OTHER_FRICTION) for seed in seeds]
            changed = [measured(one, grains.run("geodem", one), shape).numbers for one in others]
            words = f"a friction of {OTHER_FRICTION:g} in place of {grains.FRICTION:g}"
            rows.append(told_apart(about, words, [one.numbers for one in ours], changed))
        if keep:
            _keep(code, seeds, {"geodem": ours, code: theirs})
    return rows


def _keep(beside: str, seeds: Sequence[int], runs: Mapping[str, Sequence[Collapse]]) -> None:
    """Store the curves of all codes and draw them; those beside other codes stay."""
    kept: list[dict[str, Any]] = [row for row in load_rows(CURVES) if row["beside"] != beside]
    for code, found in runs.items():
        for seed, one in zip(seeds, found, strict=True):
            kept.append(
                {
                    "beside": beside, "code": code, "seed": seed, "height": np.round(one.height, 3).tolist(),
                    "times": np.round(one.times, 3).tolist(), "front": np.round(one.front, 4).tolist(),
                }
            )  # fmt: skip
    store_rows(CURVES, kept, "python -m reference compare column")
    column_picture.draw(kept, WIDTH, BIN)
