"""When the wall of a tunnel begins to crack: what the laboratory tells beforehand.

A specimen under uniaxial pressure has so many cracks a grain at so much axial stress. Damage begins at a constant
difference of the principal stresses, whatever their mean (C. D. Martin 1997, Can. Geotech. J. 34:698-725; C. D. Martin,
P. K. Kaiser and D. R. McCreath 1999, Can. Geotech. J. 36:136-151). So as many cracks are expected around a tunnel as
the grains there would have in a specimen under the difference that Kirsch's stresses have at their places: the few
grains at the wall that bear the most have their first crack later than the thousands of a specimen.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.laboratory.axial import compress
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.specimen import make_specimen

from .tunnels_spalling_kirsch import RADIUS, kirsch_deviator

Floats = NDArray[np.float64]

SPECIMENS = (1, 2, 3)
"""Seeds."""
ACROSS = 30.0
"""Grains across a specimen, that is twice as high."""
FARTHEST = 3.0
"""Over the radius: farther from the middle the difference of the principal stresses is that of the far field."""
MOST_LOAD = 100.0
"""Up to which a load is looked for."""


class Laboratory(NamedTuple):
    """What specimens tell.

    Attributes
    ----------
    strength, initiation : float
        Means of the uniaxial compressive strength and of the crack initiation stress [Pa].
    stresses : (k,)
        Largest axial stress so far [Pa] at every crack before the peak of its specimen, ascending.
    grains : int
        Of all specimens.
    seconds : float
    """

    strength: float
    initiation: float
    stresses: Floats
    grains: int
    seconds: float

    def cracks_per_grain(self, stress: Floats) -> Floats:
        """Cracks of a grain (n,) [-] under uniaxial stresses (n,) [Pa]."""
        return np.asarray(np.searchsorted(self.stresses, stress, side="right") / self.grains)


def laboratory(rock: BondedMaterial, size_ratio: float) -> Laboratory:
    """Uniaxial compression of specimens with the bonds and the sizes of grains of the ground."""
    begun = time.perf_counter()
    strength, initiation, cracks, grains = [], [], [], 0
    for seed in SPECIMENS:
        specimen = make_specimen(2, width=1.0, across=ACROSS, size_ratio=size_ratio, seed=seed)
        record = compress(specimen, rock)
        numbers = record.numbers
        strength.append(record.strength)
        initiation.append(numbers["crack_initiation_stress"])
        before = int(numbers["tension_cracks_at_peak"] + numbers["shear_cracks_at_peak"])
        cracks.append(np.maximum.accumulate(record.cracks.stress[:before]))
        grains += specimen.particles
    return Laboratory(
        float(np.mean(strength)), float(np.mean(initiation)), np.sort(np.concatenate(cracks)), grains,
        time.perf_counter() - begun,
    )  # fmt: skip


def expected_load(found: Laboratory, count: float, pressure: tuple[float, float], grains: float) -> float:
    """Load, over the far field `pressure`, at which so many cracks are expected around the tunnel.

    Parameters
    ----------
    found : Laboratory
    count : float
    pressure : (float, float)
        Of the far field along x and y at load 1 [Pa].
    grains : float
        Per area [1/m2].
    """
    rings, turns = 400, 720
    r = RADIUS * (1.0 + (FARTHEST - 1.0) * (np.arange(rings) + 0.5) / rings)
    angle = 2.0 * np.pi * (np.arange(turns) + 0.5) / turns
    away, turned = (each.ravel() for each in np.meshgrid(r, angle, indexing="ij"))
    deviator = kirsch_deviator(away[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=1), pressure)
    there = away * (r[1] - r[0]) * (angle[1] - angle[0]) * grains
    low, high = 0.0, MOST_LOAD
    # the number grows with the load: bisection
    for _ in range(40):
        middle = 0.5 * (low + high)
        many = float((there * found.cracks_per_grain(middle * deviator)).sum()) >= count
        low, high = (low, middle) if many else (middle, high)
    return 0.5 * (low + high)
