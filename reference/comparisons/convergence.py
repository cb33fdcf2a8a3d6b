"""geodem's own convention beside the other codes': what differs vanishes with the time step.

Conventions differ in how a remembered force turns with its contact and in when the first velocities count; both are
errors of the time stepping. Scenes are those of `fewbody` in which nothing else differs: with YADE's true branch
vectors (its default lengthens them by the overlap, which no time step takes away), and with LIGGGHTS where nothing
spins about the normal (it does not turn its springs with such a spin).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Posed
from ..posed_difference import differences
from . import fewbody
from .comparison import Row

HALVINGS = 4
LEAST_ORDER = 0.9
FRAMES = 50
QUANTITIES = ("positions", "velocities", "spins")


def in_plane(law: str, convention: str) -> Posed:
    """`fewbody.oblique` with all that turns, turning in the plane in which the two move."""
    one = fewbody.oblique(law, convention)
    a = one.assembly
    away = a.positions[1] / np.linalg.norm(a.positions[1])
    axis = np.cross(away, [0.0, 0.0, 1.0])
    axis /= np.linalg.norm(axis)
    flat = a.velocities - np.outer(a.velocities @ axis, axis)
    turning = np.outer(a.spins @ axis, axis)
    return replace(
        one, assembly=replace(a, velocities=flat, spins=turning), name=f"oblique in a plane, {law}"
    )


def posed(code: str) -> list[Posed]:
    """Scenes for a code, in its convention."""
    if code == "yade":
        return [
            fewbody.oblique("elastic_frictional", "yade-plain"),
            fewbody.bending("cohesive_moments", "yade-plain"),
        ]
    return [in_plane(law, "liggghts") for law in fewbody.OF_CODE[code][0]]


def finer(one: Posed, times: int) -> Posed:
    """The same time in shorter steps, with frames at the same times."""
    every = times * one.steps // FRAMES
    return replace(
        one, time_step=one.time_step / times, steps=one.steps * times, first=every, every=every,
        quantities=QUANTITIES, pairs_at=(),
    )  # fmt: skip


def compare(codes: Sequence[str], *, halvings: int = HALVINGS) -> list[Row]:
    """Rows with the order by which the differences vanish: |order - 1| or what it lacks to 1, and all differences."""
    rows = []
    for code in codes:
        scenes = posed(code)
        shorter = [finer(one, 2**k) for one in scenes for k in range(halvings)]
        theirs = BACKENDS[code].run_posed(shorter)
        ours = run_posed([replace(one, convention="geodem") for one in shorter])
        found = [
            max(differences(mine, yours, one).values())
            for mine, yours, one in zip(ours, theirs, shorter, strict=True)
        ]
        for number, one in enumerate(scenes):
            own = found[number * halvings : (number + 1) * halvings]
            # the mean over all halvings: a birth or a break falls now here, now there within a step
            told = all(0.0 < value < math.inf for value in own)
            order = math.log2(own[0] / own[-1]) / (halvings - 1) if told else -math.inf
            shown = ", ".join(f"{value:.1e}" for value in own)
            run = ours[number * halvings]
            rows.append(
                Row(
                    scene=f"{one.name}: own convention", code=code, version=theirs[0].version,
                    law=theirs[number * halvings].law,
                    quantity=f"order {order:.2f} of the differences {shown}; what it lacks to 1",
                    difference=max(1.0 - order, 0.0), bound=1.0 - LEAST_ORDER, steps=one.steps,
                    particles=one.assembly.particles, seconds=run.seconds,
                )
            )  # fmt: skip
    return rows
