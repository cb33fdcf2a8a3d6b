"""Where a specimen has failed: the plane that most cracks lie along, and how far they lie along one at all.

Of all bands of one thickness the one is taken that holds the largest share of the cracks beyond its share of the
particles, so that neither the shape of the specimen nor cracks that are spread over it lead astray. Within it, twice as
thick, the principal axes of the cracks weighted by their size give the plane: its normal is the axis of least variance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .record import Cracks
from .specimen import Specimen

Floats = NDArray[np.float64]

THICK = 5.0
"""Thickness of a band over the mean diameter: what a shear band of grains has at the least."""

NORMALS = {2: 180, 3: 2000}
"""Directions that are tried: every degree in 2D, 3 degrees apart in 3D."""

FEWEST = 10
"""Cracks, below which no plane is told."""

AROUND = 0.95
"""Cracks count from this share of the peak on."""


class FailurePlane(NamedTuple):
    """A plane through a specimen (2D: a line).

    Attributes
    ----------
    angle : float
        To the axis of loading [rad], 0 to pi/2.
    normal : (d,)
    centre : (d,) [m]
    localisation : float
        Share of the cracks in the band less its share of the particles [-]: 0 spread evenly, nearly 1 all in one plane.
    """

    angle: float
    normal: Floats
    centre: Floats
    localisation: float


def find_failure_plane(places: Floats, weights: Floats, particles: Floats, thickness: float) -> FailurePlane:
    """The plane that most of the weight lies along.

    Parameters
    ----------
    places : (k, d) [m]
        Of cracks, at least d of them.
    weights : (k,)
    particles : (n, d) [m]
        Centres of the whole specimen.
    thickness : float
        Of the band [m].
    """
    d = particles.shape[1]
    middle = particles.mean(axis=0)
    cracks, grains = places - middle, particles - middle
    best = (-math.inf, np.zeros(d), 0.0)
    for normal in _normals(d):
        across, all_across = cracks @ normal, grains @ normal
        low = float(min(across.min(), all_across.min()))
        # a quarter of a band from one to the next
        cell = 0.25 * thickness
        count = int((max(across.max(), all_across.max()) - low) / cell) + 1
        excess = _shares(across - low, weights, cell, count) - _shares(all_across - low, None, cell, count)
        held = np.convolve(excess, np.ones(4), mode="valid") if count > 4 else np.array([excess.sum()])
        at = int(np.argmax(held))
        if held[at] > best[0] + 1e-12:
            best = (float(held[at]), normal, low + (at + 2.0) * cell)
    localisation, normal, offset = best
    centre = offset * normal
    for _ in range(2):
        near = np.abs((cracks - centre) @ normal) < thickness
        if near.sum() <= d:
            break
        share = weights[near] / weights[near].sum()
        centre = share @ cracks[near]
        away = cracks[near] - centre
        _, axes = np.linalg.eigh((share[:, None] * away).T @ away)
        normal = axes[:, 0]
    return FailurePlane(
        math.asin(min(abs(float(normal[-1])), 1.0)), normal, centre + middle, max(localisation, 0.0)
    )


def _shares(values: Floats, weights: Floats | None, cell: float, count: int) -> Floats:
    at = np.minimum((values / cell).astype(np.int64), count - 1)
    found = np.bincount(at, weights, minlength=count).astype(float)
    return np.asarray(found / found.sum())


def _normals(dimension: int) -> Floats:
    """Unit vectors over half of the circle or sphere, evenly."""
    count = NORMALS[dimension]
    k = np.arange(count) + 0.5
    if dimension == 2:
        turn = math.pi * k / count
        return np.stack([np.cos(turn), np.sin(turn)], axis=1)
    # a spiral of the golden angle: Vogel 1979, Math. Biosci. 44:179, on the sphere
    up = k / count
    around = math.pi * (3.0 - math.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - up**2)
    return np.stack([flat * np.cos(around), flat * np.sin(around), up], axis=1)


def failure_numbers(specimen: Specimen, cracks: Cracks) -> dict[str, float]:
    """`failure_angle` [rad] to the axis and `localisation` [-] of the cracks from just before the peak on; nan for few.

    Parameters
    ----------
    specimen : Specimen
    cracks : Cracks
        In the order of time, with the stress at which each was made.
    """
    first = int(np.argmax(cracks.stress >= AROUND * cracks.stress.max())) if len(cracks.stress) else 0
    places, weights = cracks.place[first:], cracks.size[first:]
    if len(places) < FEWEST:
        return {"failure_angle": math.nan, "localisation": math.nan}
    plane = find_failure_plane(places, weights, specimen.positions, THICK * specimen.diameter)
    return {"failure_angle": plane.angle, "localisation": plane.localisation}
