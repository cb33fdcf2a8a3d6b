"""Packings for timing: random dense spheres, a lattice with gaps, hexagonal discs. The unit is the mean radius.

The random packing is a quick one: soft spheres brought to rest in a box by minimising their energy, without
friction or gravity. It is made to be the same for every code that is timed on it, not to stand for a soil.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

TILE = 3000
"""Most spheres that are relaxed together; larger packings repeat them, mirrored."""
LEAST = 100
"""Fewest spheres of a random packing: a few in a box cannot have the contacts asked for."""
CONTACTS = 3.0
"""Contacts a sphere of the random packing."""


@dataclass(frozen=True)
class Packing:
    """Spheres in a box.

    Attributes
    ----------
    positions : (n, 3)
    radii : (n,)
    box : (2, 3)
        Low and high corner.
    """

    positions: Floats
    radii: Floats
    box: Floats


def random_spheres(n: int, *, seed: int = 1) -> Packing:
    """n spheres at random, radii uniform in 0.8-1.2, slightly pressed (about 3 contacts a sphere).

    Up to TILE spheres are relaxed in one box. More are made of equal boxes, each the mirror image of its
    neighbours: a sphere pressed by its own image feels what a wall of twice the stiffness did, so the whole is at
    rest as its parts are. The last spheres, the highest, are left out to reach n.

    Raises
    ------
    InputError
        Where n is below LEAST.
    """
    if n < LEAST:
        raise InputError("n", "is too few spheres for a packing", f"give at least {LEAST}", value=n)
    tiles = int(np.ceil((n / TILE) ** (1.0 / 3.0) - 1e-9))
    part = _relaxed_box(-(-n // tiles**3), seed)
    side = part.box[1]
    cells = np.stack(np.meshgrid(*[np.arange(tiles)] * 3, indexing="ij"), -1).reshape(-1, 3)
    placed = [np.where(c % 2 == 1, side - part.positions, part.positions) + c * side for c in cells]
    positions = np.concatenate(placed)
    radii = np.tile(part.radii, len(cells))
    kept = np.argsort(positions[:, 2], kind="stable")[:n]
    # neighbours in space are neighbours in memory: not every code sorts its particles itself
    x, y, z = np.floor(positions[kept] / 2.4).T
    kept = kept[np.lexsort((x, y, z))]
    return Packing(positions[kept], radii[kept], np.stack([np.zeros(3), tiles * side]))


def vacant_lattice(n: int, *, seed: int = 1, vacancies: float = 0.05) -> Floats:
    """(n, 3) face-centred cubic lattice of touching unit spheres in a cube, a share of the sites empty at random."""
    cells = int(np.ceil((n / (4.0 * (1.0 - vacancies))) ** (1.0 / 3.0)))
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    basis = np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]])
    sites = (corners + basis).reshape(-1, 3)
    # in order of height, so that what is cut off is the top
    sites = sites[np.lexsort((sites[:, 0], sites[:, 1], sites[:, 2]))]
    sites = sites[: min(len(sites), int(np.ceil(n / (1.0 - vacancies))))]
    kept = np.sort(np.random.default_rng(seed).choice(len(sites), n, replace=False))
    return np.asarray(sites[kept] * 2.0 * np.sqrt(2.0))


def hexagonal_discs(n: int) -> Floats:
    """(n, 3) touching unit discs in the plane z = 0, hexagonal, about as wide as high."""
    across = int(np.ceil(np.sqrt(n * np.sqrt(3.0) / 2.0)))
    row, column = np.divmod(np.arange(n), across)
    x = 2.0 * column + row % 2
    return np.stack([x, np.sqrt(3.0) * row, np.zeros(n)], -1)


def touching_pairs(positions: Floats, radii: Floats, margin: float = 0.0) -> Integers:
    """(p, 2) pairs whose surfaces are closer than `margin`, the lower number first, sorted."""
    pairs = cKDTree(positions).query_pairs(2.0 * float(radii.max()) + margin, output_type="ndarray")
    first, second = pairs.min(1), pairs.max(1)
    distance = np.linalg.norm(positions[second] - positions[first], axis=1)
    near = distance < radii[first] + radii[second] + margin
    pairs = np.stack([first[near], second[near]], -1)
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def _relaxed_box(n: int, seed: int) -> Packing:
    """n spheres at rest in a cube, pressed until a sphere has CONTACTS contacts on average."""
    random = np.random.default_rng(seed)
    radii = random.uniform(0.8, 1.2, n)
    side = (4.0 / 3.0 * np.pi * float((radii**3).sum()) / 0.60) ** (1.0 / 3.0)
    positions = random.uniform(0.8, side - 0.8, (n, 3))
    steps = 300
    while True:
        positions, contacts = _minimise(positions, radii, side, steps)
        if contacts >= CONTACTS * n:
            positions, _ = _minimise(positions, radii, side, 500)
            return Packing(positions, radii, np.stack([np.zeros(3), np.full(3, side)]))
        side *= 0.997
        positions *= 0.997
        steps = 100


def _minimise(positions: Floats, radii: Floats, side: float, steps: int) -> tuple[Floats, int]:
    """Spheres and walls as springs (1 and 2), brought near rest by FIRE (Bitzek et al., PRL 97, 170201, 2006)."""
    margin = 0.3
    velocity = np.zeros_like(positions)
    listed_at = positions
    pairs = touching_pairs(positions, radii, margin)
    step, mix, downhill, contacts = 0.1, 0.1, 0, 0
    for _ in range(steps):
        if np.abs(positions - listed_at).max() > margin / 4.0:
            listed_at = positions
            pairs = touching_pairs(positions, radii, margin)
        force, contacts = _forces(positions, radii, side, pairs)
        if float((force * velocity).sum()) > 0.0:
            downhill += 1
            share = np.linalg.norm(velocity) / max(float(np.linalg.norm(force)), 1e-300)
            velocity = (1.0 - mix) * velocity + mix * share * force
            if downhill > 5:
                step, mix = min(1.1 * step, 0.5), 0.99 * mix
        else:
            velocity, step, mix, downhill = np.zeros_like(velocity), max(0.5 * step, 0.02), 0.1, 0
        velocity = velocity + step * force
        positions = positions + step * velocity
    return positions, contacts


def _forces(positions: Floats, radii: Floats, side: float, pairs: Integers) -> tuple[Floats, int]:
    a, b = pairs[:, 0], pairs[:, 1]
    apart = positions[b] - positions[a]
    distance = np.sqrt((apart**2).sum(1))
    overlap = radii[a] + radii[b] - distance
    pressed = overlap > 0.0
    a, b = a[pressed], b[pressed]
    push = apart[pressed] * (overlap[pressed] / distance[pressed])[:, None]
    n = len(positions)
    force = np.stack([np.bincount(b, push[:, k], n) - np.bincount(a, push[:, k], n) for k in range(3)], -1)
    force += 2.0 * np.maximum(radii[:, None] - positions, 0.0)
    force -= 2.0 * np.maximum(positions + radii[:, None] - side, 0.0)
    return force, int(pressed.sum())
