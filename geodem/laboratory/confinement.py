"""Pressure on the sides of a specimen, on whatever lies outermost: a membrane without stiffness.

Rays across the axis, a fraction of a particle apart, meet the outermost particle from both sides; each gives it the
pressure times the area it stands for. Of a pressure on a closed surface the component across the axis is the pressure
on the projected area, so the resultants are exact whatever the shape, and what bulges is pressed where it is
then. Parts that have come off and touch nothing are not pressed: one of them would carry the rays' share away.

A force acts where its ray meets the surface: between spheres that hide each other in part it turns them about the axis
of loading, and only with these torques the pressure does not turn the specimen as a whole.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..kernels.outermost import outermost
from ..particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

RAYS = {2: 3.0, 3: 2.0}
"""Rays per smallest radius: in 3D a dozen at least meet a sphere, and they cost a twentieth of the run."""


class Confinement:
    """Rays for one specimen.

    Parameters
    ----------
    low, high : float
        Ends of the part of the axis that is pressed [m].
    smallest : float
        Smallest radius [m].
    dimension : int
    """

    def __init__(self, low: float, high: float, smallest: float, dimension: int) -> None:
        self.low = low
        self.high = high
        self.spacing = smallest / RAYS[dimension]

    def loads(self, positions: Floats, radii: Floats, joined: NDArray[np.bool_]) -> Floats:
        """Forces and torques (n, d + s) of a pressure of 1 [N/Pa, N m/Pa] on the particles that are `joined`.

        Parameters
        ----------
        positions : (n, d) [m]
        radii : (n,) [m]
        joined : (n,) bool
            To the rest: the others are not there.
        """
        count, d = positions.shape
        which = np.flatnonzero(joined)
        found = np.zeros((count, 3 if d == 2 else 6))
        for axis in range(d - 1):
            force, turn = self._pressed(positions[which], radii[which], axis)
            found[which, axis] = force
            if d == 3:
                # a force along x turns by what it lies aside in y, one along y by what it lies aside in x
                found[which, 5] += turn if axis == 1 else -turn
        return found

    def _pressed(self, positions: Floats, radii: Floats, axis: int) -> tuple[Floats, Floats]:
        """Resultants (k,) of both sides along one axis, and their moments about the particles' axes of loading."""
        h = self.spacing
        across = [k for k in range(positions.shape[1]) if k != axis]
        low = np.array([(positions[:, k] - radii).min() for k in across])
        high = np.array([(positions[:, k] + radii).max() for k in across])
        low[-1], high[-1] = self.low, self.high
        cells = tuple(int(c) for c in np.maximum(((high - low) / h).astype(np.int64), 1))
        met = outermost(
            np.ascontiguousarray(positions[:, axis]), positions[:, across], radii, low, h, cells
        ).reshape(2, -1)
        area = h ** len(across)
        force, turn = np.zeros(len(radii)), np.zeros(len(radii))
        aside = low[0] + (np.arange(cells[0]) + 0.5) * h
        for sign, owner in zip((1.0, -1.0), met, strict=True):
            # the side where the coordinate is lowest is pressed upwards
            rays = np.flatnonzero(owner >= 0)
            particle = owner[rays]
            force += sign * area * np.bincount(particle, minlength=len(radii))
            if len(across) == 2:
                away = aside[rays // cells[1]] - positions[particle, across[0]]
                turn += sign * area * np.bincount(particle, away, minlength=len(radii))
        return force, turn


def joined_to_most(simulation: ParticleSimulation) -> NDArray[np.bool_]:
    """Particles (n,) of the largest part that bonds and touching contacts join, in the order of the assembly."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    s = simulation
    p = s.pairs
    which = (p.bond > 0) | (p.touching > 0)
    n = s.assembly.particles
    ends = (p.a[which].astype(np.int64), p.b[which].astype(np.int64))
    _, part = connected_components(coo_matrix((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False)
    largest = int(np.bincount(part).argmax())
    found = np.zeros(n, dtype=bool)
    found[s.arrays.ids[part == largest]] = True
    return found
