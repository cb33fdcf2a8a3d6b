"""Packing of Potyondy & Cundall (2004, section 2.4): pressed lightly without friction, and nobody floats.

Particles in a periodic cell are grown until they jam without friction, then shrunk a little again and again, so that
what is left of their overlaps is that of a pressure that is small against the strengths. Particles with fewer than
d + 1 contacts are moved to the middle of their cage and grown until they touch as many. Only pairs that touch are
bonded: nearly 2 d of them a particle, the fewest that make a frictionless packing rigid, and a contact acts beside
every bond.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Cell as PeriodicCell
from geodem.builders.close_pairs import close_pairs
from geodem.builders.random_packing import random_packing
from geodem.kernels.overlap_removal import remove_overlaps
from geodem.laboratory.specimen import Specimen

Floats = NDArray[np.float64]

SIZE_RATIO = 1.66
JAMMED = {2: 0.85, 3: 0.65}
"""Solid fraction, overlaps counted twice, at which any frictionless packing of these sizes is jammed."""
OVERLAP = 2e-5
"""Mean overlap over the mean diameter in the end: stresses in the cell are a thousandth of the strengths."""
SHRINKING = 1.0
"""Share of the mean overlap that is taken away at a time: about a tenth of it stays, where contacts share it anew."""
MOST_STEPS = 4000
"""Of the minimiser, after each change of size."""
TOUCHING = 1e-6
"""Gap over the radii up to which a pair touches."""
CAGE = {2: 0.5, 3: 1.5}
"""Neighbours that may bound a cage lie within so many mean radii of a particle's surface: in space cages are wide."""
MOST_CENTRINGS = 30


@dataclass(frozen=True, eq=False)
class Cell:
    """Particles in a periodic cell.

    Attributes
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    sides : (d,) [m]
    floaters : int
        How many had too few contacts before they were grown.
    coordination : float
        Contacts of a particle, mean of all, in the end.
    """

    positions: Floats
    radii: Floats
    sides: Floats
    floaters: int
    coordination: float


@lru_cache(maxsize=4)
def packed(dimension: int, width: float, across: float, seed: int) -> Cell:
    """Cell twice as high as wide [m], `across` particles wide."""
    mean = 0.5 * width / across
    sides = np.array([width] * (dimension - 1) + [2.0 * width])
    start = random_packing(
        dimension, radius=2.0 * mean * SIZE_RATIO / (1.0 + SIZE_RATIO), size_ratio=SIZE_RATIO, box=sides.tolist(),
        seed=seed,
    )  # fmt: skip
    positions, radii = start.positions, start.radii
    factor = (JAMMED[dimension] / start.solid_fraction) ** (1.0 / dimension)
    while True:
        radii = factor * radii
        positions = remove_overlaps(
            positions, radii, sides, periodic=True, tolerance=0.0, most_steps=MOST_STEPS
        ).positions
        pairs, distance = touching(positions, radii, sides, 0.0)
        overlap = float((radii[pairs].sum(axis=1) - distance).mean()) if len(pairs) else 0.0
        relative = 0.5 * overlap / float(radii.mean())
        if relative <= OVERLAP:
            break
        factor = 1.0 - SHRINKING * relative
    positions, radii, floaters = without_floaters(positions, radii, sides)
    pairs, _ = touching(positions, radii, sides, TOUCHING)
    # as many across as asked for: the sizes grew on the way
    scale = mean / float(radii.mean())
    return Cell(scale * positions, scale * radii, scale * sides, floaters, 2.0 * len(pairs) / len(radii))


def touching(positions: Floats, radii: Floats, sides: Floats, gap: float) -> tuple[NDArray[np.int64], Floats]:
    """Pairs (k, 2) with gaps up to `gap` times the sum of their radii, and their distances."""
    cell = PeriodicCell(np.diag(sides), (True,) * len(sides))
    return close_pairs(positions, radii, lambda a, b: (1.0 + gap) * (a + b), cell)


def without_floaters(positions: Floats, radii: Floats, sides: Floats) -> tuple[Floats, Floats, int]:
    """Positions, radii, and how many particles were grown until d + 1 others hold them."""
    positions, radii = positions.copy(), radii.copy()
    d = len(sides)
    reach = CAGE[d] * float(radii.mean())
    cell = PeriodicCell(np.diag(sides), (True,) * d)
    near, _ = close_pairs(positions, radii, lambda a, b: a + b + reach, cell)
    both = np.concatenate([near, near[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    begin = np.searchsorted(both[:, 0], np.arange(len(radii) + 1))
    pairs, _ = touching(positions, radii, sides, TOUCHING)
    floating = np.flatnonzero(np.bincount(pairs.ravel(), minlength=len(radii)) < d + 1)
    for particle in floating:
        others = both[begin[particle] : begin[particle + 1], 1]
        away = positions[others] - positions[particle]
        away -= sides * np.round(away / sides)
        shift, radius = widest(away, radii[others], float(radii[particle]), reach)
        positions[particle] = np.mod(positions[particle] + shift, sides)
        radii[particle] = radius
    return positions, radii, len(floating)


def widest(away: Floats, radii: Floats, radius: float, reach: float) -> tuple[Floats, float]:
    """Way (d,) to the middle of a cage of particles `away` (k, d), and the largest radius there, at least `radius`.

    What lies farther from its surface than `reach` [m] is not among them, so it goes and grows no farther than that.
    By linear programs: the gaps are linear for a small way, which is at most a tenth of the radius at a time.
    """
    from scipy.optimize import linprog

    d = away.shape[1]
    at = np.zeros(d)
    step = 0.1 * radius
    best = float((np.linalg.norm(away, axis=1) - radii).min())
    for _ in range(MOST_CENTRINGS):
        towards = away - at
        distance = np.linalg.norm(towards, axis=1)
        # largest r with r <= distance_j - n_j . step - radius_j
        rows = np.column_stack([towards / distance[:, None], np.ones(len(radii))])
        bounds = [(-step, step)] * d + [(0.0, None)]
        found = linprog(np.r_[np.zeros(d), -1.0], A_ub=rows, b_ub=distance - radii, bounds=bounds)
        if found.x is None:
            break
        trial = at + found.x[:d]
        room = float((np.linalg.norm(away - trial, axis=1) - radii).min())
        if room > best and float(np.linalg.norm(trial)) + room - radius < reach:
            gain, at, best = room - best, trial, room
            if gain < 1e-9 * radius:
                break
        else:
            step *= 0.25
            if step < 1e-9 * radius:
                break
    # pressed in by rounding, so that it touches
    return at, max(best * (1.0 + 0.1 * TOUCHING), radius)


def prism(cell: Cell, seed: int) -> Specimen:
    """Specimen cut open where the cell was periodic."""
    return Specimen(cell.positions, cell.radii, cell.sides, "prism", "compacted", seed)


def disc(cell: Cell, seed: int) -> Specimen:
    """Disc for splitting from the middle of the cell, as wide; in 3D as thick."""
    size = cell.sides.copy()
    size[-1] = size[0]
    places = cell.positions - np.r_[np.zeros(len(size) - 1), 0.5 * (cell.sides[-1] - size[-1])]
    away = places[:, [0, -1]] - 0.5 * size[[0, -1]]
    inside = np.sqrt((away**2).sum(axis=1)) <= 0.5 * size[0] - 0.25 * float(cell.radii.mean())
    return Specimen(places[inside], cell.radii[inside], size, "disc", "compacted", seed)


def contact_factor(cell: Cell) -> float:
    """Modulus of the law `effective_modulus` over the paper's Ec that gives contacts of the same stiffness on average.

    A grain of the paper has kn = 2 Ec t in 2D and 4 Ec R in 3D, two in series ka kb/(ka + kb); the law has
    E 2 min(R)/(Ra + Rb) and E pi min(R)^2/(Ra + Rb).
    """
    d = len(cell.sides)
    pairs, _ = touching(cell.positions, cell.radii, cell.sides, TOUCHING)
    a, b = cell.radii[pairs].T
    smaller = np.minimum(a, b)
    paper = np.ones(len(a)) if d == 2 else 4.0 * a * b / (a + b)
    law = (2.0 * smaller if d == 2 else math.pi * smaller**2) / (a + b)
    return float(paper.mean() / law.mean())
