"""A bonded block pressed between two driven layers until it fails: geodem beside YADE and LAMMPS.

A face-centred cubic block of touching spheres with vacancies, every touching pair bonded, the strengths of its bonds
scattered. The lowest and the highest layer move towards each other; all begins with the velocities of uniform strain,
so that no wave is set off. Up to the first break the codes can be held against each other closely. After it the motion
is chaotic; so the whole is done with several seeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from scipy.spatial import cKDTree

from geodem.builders.assembly_builder import AssemblyBuilder

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Floats, Integers, Posed, Trajectory
from . import block_picture
from .beam import BENDING, CONTACT, DENSITY, ELASTIC, MASS, NORMAL, RADIUS, SHEAR, TWISTING
from .comparison import Row

CODES = ("yade", "lammps")

SEEDS = (1, 2, 3)
CELLS, LAYERS = 5, 21
"""Cells across, layers of spheres along the axis: about 1,200 spheres."""
VACANCIES = 0.07
"""Share of the sites between the driven layers."""
FACTORS = (0.6, 0.8, 1.0, 1.2, 1.4)
"""On the strength of a bond, as likely one as another."""
STRENGTH = 3.0
"""Tension that breaks a bond of factor 1 [N]."""
EVERY = 20
TIME_STEP = 0.12 * math.sqrt(MASS / NORMAL)  # [s]
STRAIN_OF_STEP = 0.01 / 6000
STRAIN = {"yade": 0.01, "lammps": 0.007}
"""At the end. What breaks without damping, as in LAMMPS, flies apart soon after, and out of the domain."""

MODULUS_BOUND = 0.01
PEAK_BOUND = 0.03


def laws() -> dict[str, tuple[str, str, str, dict[str, float], dict[str, float], float]]:
    """Code, contact law, bond law, their numbers and local damping, by what they are called here.

    One spring has the stiffness of the other law's; the strengths are of the same size, the criteria are the codes'.
    """
    shear = STRENGTH
    return {
        "CohFrict": (
            "yade", "elastic_frictional", "cohesive_moments", ELASTIC,
            {
                **ELASTIC, "normal_cohesion": STRENGTH / RADIUS**2, "shear_cohesion": shear / RADIUS**2,
                "bending_factor": BENDING / (RADIUS**2 * SHEAR), "twisting_factor": TWISTING / (RADIUS**2 * SHEAR),
            },
            0.2,
        ),
        "JCFpm": (
            "yade", "elastic_frictional", "jointed_cohesive", ELASTIC,
            {
                **ELASTIC, "tensile_strength": STRENGTH / (math.pi * RADIUS**2),
                "cohesion": shear / (math.pi * RADIUS**2),
            },
            0.2,
        ),
        "bpm/rotational": (
            "lammps", "linear_frictional", "rotational_bond", CONTACT,
            {
                "normal_stiffness": NORMAL, "shear_stiffness": SHEAR,
                "twisting_stiffness": TWISTING, "bending_stiffness": BENDING,
                "tensile_strength": STRENGTH, "shear_strength": shear,
                "twisting_strength": shear * RADIUS, "bending_strength": STRENGTH * RADIUS,
            },
            0.0,
        ),
    }  # fmt: skip


@dataclass(frozen=True)
class Loading:
    """What a run of a block tells.

    Attributes
    ----------
    strain, stress : (f,) [-], [Pa]
        Pressure positive; the mean of both driven layers.
    unlike : float
        Largest difference of the two layers' forces over the largest force, before the peak.
    modulus, peak : float
        [Pa]
    peak_frame : int
    broken : (b, 2) int
        Bonds broken by the peak.
    first_break : int
        Frame of the first, the number of frames where none broke.
    """

    strain: Floats
    stress: Floats
    unlike: float
    modulus: float
    peak: float
    peak_frame: int
    broken: Integers
    first_break: int


def sites(cells: int, layers: int, seed: int) -> tuple[Floats, Integers, Floats]:
    """Centres (n, 3) [m], touching pairs, and the factors on their strength."""
    random = np.random.default_rng(seed)
    grid = np.stack(
        np.meshgrid(*[np.arange(n) for n in (2 * cells + 1, 2 * cells + 1, layers)], indexing="ij"), -1
    ).reshape(-1, 3)
    grid = grid[grid.sum(axis=1) % 2 == 0]
    grid = grid[np.lexsort((grid[:, 0], grid[:, 1], grid[:, 2]))]
    between = np.flatnonzero((grid[:, 2] > 0) & (grid[:, 2] < layers - 1))
    gone = random.choice(between, round(VACANCIES * len(between)), replace=False)
    kept = np.delete(grid, gone, axis=0)
    pairs = cKDTree(kept).query_pairs(1.5, output_type="ndarray").astype(np.int64)
    pairs = np.sort(pairs, axis=1)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return kept * math.sqrt(2.0) * RADIUS, pairs, random.choice(FACTORS, len(pairs))


def block(
    law: str,
    seed: int,
    *,
    cells: int = CELLS,
    layers: int = LAYERS,
    strain: float | None = None,
    strain_of_step: float = STRAIN_OF_STEP,
) -> Posed:
    """A block in one of `laws`, pressed up to a strain."""
    code, contact_law, bond_law, contact, bond, damping = laws()[law]
    positions, pairs, factors = sites(cells, layers, seed)
    height = float(positions[:, 2].max())
    steps = round((STRAIN[code] if strain is None else strain) / strain_of_step)
    pace = strain_of_step / TIME_STEP * (0.5 * height - positions[:, 2])
    b = AssemblyBuilder(3, contact_law, bond_law)
    b.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    b.add_particles(positions, RADIUS, "rock", velocity=pace[:, None] * [0.0, 0.0, 1.0])
    b.bond(pairs, scale=factors)
    for end in (0.0, height):
        layer = np.flatnonzero(positions[:, 2] == end)
        b.hold(layer, x=0.0, y=0.0, z=pace[layer], rotation=0.0)
    return Posed(
        name=f"block of {len(positions)} spheres, {law}, seed {seed}", assembly=b.build(), time_step=TIME_STEP,
        steps=steps // EVERY * EVERY, first=EVERY, every=EVERY, pairs_at=(),
        convention="yade" if code == "yade" else "geodem", local_damping=damping,
        quantities=("positions",), bound=PEAK_BOUND,
    )  # fmt: skip


def broken_by(run: Trajectory, step: int) -> Integers:
    """(b, 2) bonds that are broken after so many steps."""
    return np.array([row[:2] for row in run.broken if row[2] <= step], dtype=np.int64).reshape(-1, 2)


def loading(posed: Posed, run: Trajectory) -> Loading:
    """Stress and strain of a run, and what follows from them. Raises ValueError where nothing is loaded."""
    x = posed.assembly.positions
    low, high = x[:, 2] == x[:, 2].min(), x[:, 2] == x[:, 2].max()
    area = float(np.prod(np.ptp(x[:, :2], axis=0) + 2.0 * RADIUS))
    height = float(np.ptp(x[:, 2]))
    pressed = run.forces[:, high, 2].sum(axis=1), -run.forces[:, low, 2].sum(axis=1)
    force = 0.5 * (pressed[0] + pressed[1])
    moved = run.positions[:, :, 2] - x[:, 2]
    strain = (moved[:, low].mean(axis=1) - moved[:, high].mean(axis=1)) / height
    peak = int(np.argmax(force))
    if not force[peak] > 0.0:
        raise ValueError(f"{posed.name} bears no force")
    first = int(np.searchsorted(run.steps, min((row[2] for row in run.broken), default=run.steps[-1] + 1)))
    elastic = slice(0, max(2, first))
    modulus = float(np.polyfit(strain[elastic], force[elastic] / area, 1)[0])
    unlike = float(np.abs(pressed[0] - pressed[1])[: peak + 1].max() / force[peak])
    return Loading(
        strain,
        force / area,
        unlike,
        modulus,
        float(force[peak] / area),
        peak,
        broken_by(run, int(run.steps[peak])),
        first,
    )


def where_alike(posed: Posed, one: Integers, other: Integers, parts: int = 4) -> float:
    """Correlation of the numbers of broken bonds in parts of the block, `parts` along every axis [-]."""
    x = posed.assembly.positions
    low, size = x.min(axis=0), np.ptp(x, axis=0)

    def counts(bonds: Integers) -> Floats:
        middle = 0.5 * (x[bonds[:, 0]] + x[bonds[:, 1]])
        cell = np.minimum(((middle - low) / size * parts).astype(int), parts - 1)
        return np.bincount(cell @ [parts * parts, parts, 1], minlength=parts**3).astype(float)

    if not (len(one) and len(other)):
        return math.nan
    return float(np.corrcoef(counts(one), counts(other))[0, 1])


def shared(one: Integers, other: Integers) -> float:
    """Bonds broken in both over those broken in either [-]."""
    first, second = {tuple(pair) for pair in one.tolist()}, {tuple(pair) for pair in other.tolist()}
    return len(first & second) / max(1, len(first | second))


def rows_of(posed: Posed, ours: Trajectory, theirs: Trajectory) -> list[Row]:
    """Modulus, peak, broken bonds and where they are, of one block."""
    mine, yours = loading(posed, ours), loading(posed, theirs)
    until = min(mine.first_break, yours.first_break)
    apart = float(
        np.abs(mine.stress[:until] - yours.stress[:until]).max() / np.abs(yours.stress[:until]).max()
    )
    earlier = int(ours.steps[min(mine.peak_frame, yours.peak_frame)])
    sets = broken_by(ours, earlier), broken_by(theirs, earlier)
    correlation = where_alike(posed, *sets)
    count = len(mine.broken), len(yours.broken)
    told = {
        f"modulus {mine.modulus / 1e6:.5g} and {yours.modulus / 1e6:.5g} MPa, differ by": (
            abs(mine.modulus / yours.modulus - 1.0),
            MODULUS_BOUND,
        ),
        f"peak {mine.peak / 1e3:.5g} and {yours.peak / 1e3:.5g} kPa, differ by": (
            abs(mine.peak / yours.peak - 1.0),
            PEAK_BOUND,
        ),
        f"stress up to the first break, step {posed.every * until}": (apart, math.nan),
        f"strain at the peak {mine.strain[mine.peak_frame]:.3e} and {yours.strain[yours.peak_frame]:.3e}, differ by": (
            abs(mine.strain[mine.peak_frame] / yours.strain[yours.peak_frame] - 1.0),
            math.nan,
        ),
        f"{count[0]} and {count[1]} of {len(posed.assembly.bonds)} bonds broken by the peak, differ by": (
            abs(count[0] - count[1]) / max(1, count[1]),
            math.nan,
        ),
        f"of the bonds broken in either by the earlier peak {100.0 * shared(*sets):.0f} % are in both; correlation of "
        f"their numbers in 64 parts {correlation:.3f}, lacks to 1": (1.0 - correlation, math.nan),
        f"forces of the two layers before the peak ({yours.unlike:.1e} in the other code)": (
            mine.unlike,
            math.nan,
        ),
        f"time of a step {1e3 * ours.loop_seconds / posed.steps:.2f} ms on {numba.get_num_threads()} and "
        f"{1e3 * theirs.loop_seconds / posed.steps:.2f} ms on 1 threads, their ratio": (
            ours.loop_seconds / theirs.loop_seconds,
            math.nan,
        ),
    }
    return [
        Row(
            scene=posed.name, code=theirs.code, version=theirs.version, law=theirs.law, quantity=quantity,
            difference=difference, bound=bound, steps=posed.steps, particles=posed.assembly.particles,
            seconds=ours.seconds,
        )
        for quantity, (difference, bound) in told.items()
    ]  # fmt: skip


def over_seeds(law: str, runs: Sequence[tuple[Posed, Trajectory, Trajectory]]) -> list[Row]:
    """Means over the seeds, and how far the seeds are apart."""
    mine = [loading(posed, ours) for posed, ours, _ in runs]
    yours = [loading(posed, theirs) for posed, _, theirs in runs]
    rows = []
    for name, bound, unit in (("modulus", MODULUS_BOUND, "Pa"), ("peak", PEAK_BOUND, "Pa")):
        one, other = (np.array([getattr(run, name) for run in found]) for found in (mine, yours))
        rows.append((
            f"mean {name} {one.mean():.5g} and {other.mean():.5g} {unit}, of single blocks "
            f"{other.min():.5g} to {other.max():.5g}; means differ by",
            abs(float(one.mean() / other.mean()) - 1.0), bound,
        ))  # fmt: skip
    posed, ours, theirs = runs[0]
    return [
        Row(
            scene=f"blocks of {len(runs)} seeds, {law}", code=theirs.code, version=theirs.version, law=theirs.law,
            quantity=quantity, difference=difference, bound=bound, steps=posed.steps,
            particles=posed.assembly.particles, seconds=ours.seconds,
        )
        for quantity, difference, bound in rows
    ]  # fmt: skip


def compare(codes: Sequence[str], *, seeds: Sequence[int] = SEEDS) -> list[Row]:
    """Rows of every law and seed; the curves go to a picture."""
    rows, curves = [], []
    for law, (code, *_) in laws().items():
        if code not in codes:
            continue
        runs = []
        for seed in seeds:
            posed = block(law, seed)
            ((ours,), (theirs,)) = run_posed([posed]), BACKENDS[code].run_posed([posed])
            if math.isnan(ours.loop_seconds):
                # something was compiled on the way: once more, to be timed
                (ours,) = run_posed([posed])
            runs.append((posed, ours, theirs))
            rows += rows_of(posed, ours, theirs)
            mine, yours = loading(posed, ours), loading(posed, theirs)
            curves.append(
                block_picture.curve(law, code, seed, (mine.strain, mine.stress), (yours.strain, yours.stress))
            )
        rows += over_seeds(law, runs)
    block_picture.keep(curves)
    return rows
