"""Radius growth in a periodic cell: particles that begin loose grow by one common factor to a porosity."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..builders.packings import Packing, box_sides, volumes
from ..builders.random_addition import scatter_particles
from ..builders.sizes import Sizes
from ..errors import InputError
from ..kernels.overlap_removal import remove_overlaps
from ..particle_simulation import ParticleSimulation
from ..particle_statics import find_equilibrium
from .grains import Grains
from .sample import PreparedSample, measure_sample
from .settling import refuse_run

Floats = NDArray[np.float64]

LOOSE = {2: 0.4, 3: 0.25}
"""Solid fraction to begin with."""
STAGE = 1.015
"""Growth of radii from one stage to the next: touching particles overlap by so much."""
INFLATION = 1e-3
"""Share by which radii are larger while frictionless particles are pushed apart: none overlap once they are not."""
PUSHED_APART = 2.0 * INFLATION / (1.0 + INFLATION) * (1.0 - 1e-9)
"""Overlap of the inflated particles over the smaller radius at which a stage ends; a hair less for rounding."""
STAGE_STEPS = {"pushes": 20_000, "relaxation": 400}
"""At most: close to jamming thousands of pushes are needed, far from it some tens."""
STAGE_BALANCE = 1e-2
"""Unbalanced ratio at which a stage with friction ends."""
PRESSED = 0.1
"""Overlap over the smaller radius above which a sample is no longer one of these grains."""
DENSEST = {2: math.pi / math.sqrt(12.0), 3: math.pi / math.sqrt(18.0)}
"""Solid fraction of the densest packing of equal particles."""


def grow_radii(
    dimension: int,
    grains: Grains,
    sizes: Sizes,
    *,
    porosity: float,
    box: Sequence[float] | None = None,
    count: int | None = None,
    friction: float | None = 0.0,
    tolerance: float = 1e-3,
    most_steps: int = 200_000,
    seed: int,
    progress: Callable[[int, float], None] | None = None,
) -> PreparedSample:
    """A sample of a given porosity in a periodic cell, by growth of radii, then brought to equilibrium.

    Particles are placed at random without overlap and grow in stages to their sizes; between stages they push each
    other apart. Their density is that of `grains` all the time. Without friction a stage pushes particles down to the
    least energy of their overlaps, with friction it relaxes the contacts of `grains`. Where the porosity is larger than
    that at which particles jam no contact presses, where it is smaller there is a pressure.

    Parameters
    ----------
    dimension : int
        2 or 3.
    grains : Grains
    sizes : Sizes
        See `geodem.builders.sizes`. In the end radii are larger or smaller by a common factor near 1, so that a whole
        number of particles meets the porosity.
    porosity : float
        Share of pores [-].
    box : (d,) float, optional
        Sides of the cell [m]
    count : int, optional
        Instead of `box`: the cell is a square or cube.
    friction : float, optional
        While they grow [-]; that of `grains` where it is None. Without friction particles jam at a porosity of about
        0.16 in 2D and 0.36 in 3D, earlier with it.
    tolerance : float
        Unbalanced ratio at the end [-].
    most_steps : int
        Of the last relaxation.
    seed : int
    progress : callable, optional
        Is told the stages and steps and the solid fraction now and then.

    Returns
    -------
    PreparedSample
        `reached` is False where the particles had to be pressed into one another, or no equilibrium was found.

    Raises
    ------
    InputError
        A porosity that no packing has; numbers that cannot be.
    """
    refuse_run(tolerance=tolerance, most_steps=most_steps, share=0.5)
    refuse_porosity(porosity, dimension, sizes)
    begun = time.perf_counter()
    used = grains.with_friction(friction)
    goal = 1.0 - porosity
    loose = _loose(dimension, sizes, goal, box, count, seed)
    radii = loose.radii * (goal / loose.solid_fraction) ** (1.0 / dimension)
    positions = loose.positions
    largest = float(loose.radii.max() / radii.max())
    stages = max(1, math.ceil(-math.log(largest) / math.log(STAGE)))
    for stage in range(1, stages + 1):
        now = radii * largest ** (1.0 - stage / stages)
        if used.friction == 0.0:
            apart = remove_overlaps(
                positions, now * (1.0 + INFLATION), loose.box, periodic=True, tolerance=PUSHED_APART,
                most_steps=STAGE_STEPS["pushes"],
            )  # fmt: skip
            positions = apart.positions
        else:
            positions = _relaxed(used, positions, now, loose.box)
        if progress is not None:
            progress(stage, goal * (now[0] / radii[0]) ** dimension)
    simulation = _simulation(used, positions, radii, loose.box)
    told = None if progress is None else (lambda steps, ratio: progress(stages + steps, goal))
    found = find_equilibrium(simulation, tolerance=tolerance, most_steps=most_steps, progress=told)
    sample = measure_sample(
        simulation,
        used,
        porosity=porosity,
        method="radius growth",
        target="porosity",
        wanted=porosity,
        got=1.0 - float(volumes(radii, dimension).sum() / np.prod(loose.box)),
        reached=found.reached,
        reason=found.reason or "in equilibrium",
        steps=found.steps,
        seconds=time.perf_counter() - begun,
        seed=seed,
    )
    return judged(sample)


def judged(sample: PreparedSample) -> PreparedSample:
    """The sample, as not reached where its particles are pressed too deeply into one another."""
    if sample.largest_overlap <= PRESSED:
        return sample
    why = (
        f"particles are pressed into one another by {sample.largest_overlap:.2g} of their radius; without pressure "
        f"these jam at a porosity of about {unpressed_porosity(sample):.3f}"
    )
    return replace(sample, reached=False, reason=why)


def unpressed_porosity(sample: PreparedSample) -> float:
    """Porosity at which the contacts of a sample would just touch: radii less their mean relative overlap."""
    if not len(sample.pairs):
        return sample.porosity
    step = sample.positions[sample.pairs[:, 1]] - sample.positions[sample.pairs[:, 0]]
    if len(sample.cell):
        fraction = step @ np.linalg.inv(sample.cell)
        step = (fraction - np.round(fraction)) @ sample.cell
    touch = sample.radii[sample.pairs].sum(axis=1)
    depth = np.maximum(1.0 - np.sqrt((step**2).sum(axis=1)) / touch, 0.0)
    return 1.0 - sample.solid_fraction * (1.0 - float(depth.mean())) ** sample.dimension


def refuse_porosity(porosity: float, dimension: int, sizes: Sizes | None = None) -> None:
    """Raise InputError for a porosity that no packing has."""
    if dimension not in (2, 3):
        raise InputError("dimension", "particles are discs or spheres", "Give 2 or 3.", value=dimension)
    least = 1.0 - DENSEST[dimension]
    jam = "0.16" if dimension == 2 else "0.36"
    if not (math.isfinite(porosity) and 0.0 < porosity < 1.0):
        raise InputError(
            "porosity", "this is no share of pores", f"Give {jam}, for instance.", value=porosity
        )
    alike = sizes is not None and float(sizes.quantile(np.zeros(1))[0]) > 0.999 * sizes.largest
    # small particles fill the pores of large ones: then nothing is said before it is tried
    if porosity < least and (alike or porosity < 0.25 * least):
        raise InputError(
            "porosity", f"no packing of equal particles is denser than {least:.3f}",
            f"Give more: random particles without friction jam at about {jam}.", value=porosity,
        )  # fmt: skip


def _loose(
    dimension: int, sizes: Sizes, goal: float, box: Sequence[float] | None, count: int | None, seed: int
) -> Packing:
    """Particles without overlap in the cell they will have; their radii are not yet those of the end."""
    if (box is None) == (count is None):
        raise InputError("radius growth", "it takes either a box or a count", "Give one of the two.")
    share = min(LOOSE[dimension], 0.7 * goal)
    if box is None:
        wide = scatter_particles(dimension, sizes, count=count, solid_fraction=share, seed=seed)
        shrink = (wide.solid_fraction / goal) ** (1.0 / dimension)
    else:
        sides = box_sides("radius growth", box, dimension)
        shrink = (share / goal) ** (1.0 / dimension)
        wide = scatter_particles(dimension, sizes, box=tuple(sides / shrink), solid_fraction=share, seed=seed)
    return replace(wide, positions=wide.positions * shrink, radii=wide.radii * shrink, box=wide.box * shrink)


def _simulation(grains: Grains, positions: Floats, radii: Floats, box: Floats) -> ParticleSimulation:
    assembly = grains.assembly(positions, radii, cell=np.diag(box))
    # given, since no stiffness can be measured where nothing touches
    return ParticleSimulation(assembly, time_step=grains.time_step(assembly), orientation=False)


def _relaxed(grains: Grains, positions: Floats, radii: Floats, box: Floats) -> Floats:
    """Positions after the contacts of a stage have pushed for a while."""
    simulation = _simulation(grains, positions, radii, box)
    find_equilibrium(simulation, tolerance=STAGE_BALANCE, most_steps=STAGE_STEPS["relaxation"], solve=False)
    return simulation.positions
