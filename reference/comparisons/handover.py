"""Ten thousand spheres: another code goes first, its whole state is handed to geodem, and both go on.

Motion in a packing is chaotic, so that two codes that do the same part after some thousand steps; twenty steps from
one state tell whether every formula is the same in every contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geodem.boundaries.walls import box

from ..backends import BACKENDS
from ..ours_posed import handed_over, run_posed
from ..posed import Posed
from ..scene_packings import random_spheres
from .comparison import Row, rows_of
from .fewbody import GRAVITY, OF_CODE, RADIUS, TIME_STEP, builder

PARTICLES = 10_000
BEFORE = 200
"""Steps that the other code does alone: springs across the contacts have grown, many slide."""
STEPS = 20
BOUND = 1e-10
SPEED = 0.3  # [m/s]


def posed(law: str, convention: str, particles: int = PARTICLES, before: int = BEFORE) -> Posed:
    """A packing of spheres of two materials that move at random in a smooth box."""
    packing = random_spheres(particles, seed=3)
    b = builder(law, gravity=GRAVITY)
    random = np.random.default_rng(11)
    velocity = random.normal(0.0, SPEED, (particles, 3))
    spin = random.normal(0.0, SPEED / RADIUS, (particles, 3))
    kind = random.random(particles) < 0.5
    for name, which in (("a", np.flatnonzero(kind)), ("b", np.flatnonzero(~kind))):
        b.add_particles(
            packing.positions[which] * RADIUS, packing.radii[which] * RADIUS, name, velocity=velocity[which],
            spin=spin[which],
        )  # fmt: skip
    # what a wall remembers cannot be handed over: these remember nothing
    b.add_wall(
        box("box", packing.box[0] * RADIUS, packing.box[1] * RADIUS, contact={"friction_coefficient": 0.0})
    )
    return Posed(
        name=f"{particles} spheres handed over, {law}", assembly=b.build(), time_step=TIME_STEP,
        steps=before + STEPS, first=before + 1, pairs_at=(), convention=convention, bound=BOUND,
    )  # fmt: skip


def compare(codes: Sequence[str]) -> list[Row]:
    """Rows for every contact law of every code."""
    return [row for code in codes for law in OF_CODE[code][0] for row in compare_one(code, law)]


def compare_one(code: str, law: str, *, particles: int = PARTICLES, before: int = BEFORE) -> list[Row]:
    """Rows of one contact law."""
    one = posed(law, OF_CODE[code][2], particles, before)
    (theirs,) = BACKENDS[code].run_posed([one])
    assert theirs.start is not None
    continued = handed_over(one, theirs.start)
    (ours,) = run_posed([continued])
    return rows_of(continued, ours, replace(theirs, steps=theirs.steps - before))
