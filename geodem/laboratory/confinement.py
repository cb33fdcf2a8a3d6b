"""Pressure on the sides of a specimen, on whatever lies outermost: a membrane without stiffness.

Rays across the axis, a fraction of a particle apart, meet the outermost particle from both sides; each gives it the
pressure times the area it stands for. Of a pressure on a closed surface the component across the axis is the pressure
on the projected area, so the resultants are exact whatever the shape, and what bulges is pressed where it is
then. Parts that have come off and touch nothing are not pressed: one of them would carry the rays' share away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

RAYS = 3.0
"""Rays per smallest radius."""


class Confinement:
    """Rays for one specimen.

    Parameters
    ----------
    low, high : float
        Ends of the part of the axis that is pressed [m].
    smallest : float
        Smallest radius [m].
    """

    def __init__(self, low: float, high: float, smallest: float) -> None:
        self.low = low
        self.high = high
        self.spacing = smallest / RAYS

    def forces(self, positions: Floats, radii: Floats, joined: NDArray[np.bool_]) -> Floats:
        """Forces (n, d) of a pressure of 1 [N/Pa] on the particles that are `joined` to the rest.

        Parameters
        ----------
        positions : (n, d) [m]
        radii : (n,) [m]
        joined : (n,) bool
        """
        d = positions.shape[1]
        which = np.flatnonzero(joined)
        found = np.zeros_like(positions)
        for axis in range(d - 1):
            across = [k for k in range(d) if k != axis]
            found[which, axis] = self._pressed(positions[which], radii[which], axis, across)
        return found

    def _pressed(self, positions: Floats, radii: Floats, axis: int, across: list[int]) -> Floats:
        """Resultants (k,) of both sides along one axis."""
        h = self.spacing
        low = np.array([(positions[:, k] - radii).min() for k in across])
        high = np.array([(positions[:, k] + radii).max() for k in across])
        low[-1], high[-1] = self.low, self.high
        counts = np.maximum(((high - low) / h).astype(np.int64), 1)
        first = np.ceil((positions[:, across] - radii[:, None] - low) / h - 0.5).astype(np.int64)
        width = int(np.ceil(2.0 * radii.max() / h)) + 1
        steps = np.stack(np.meshgrid(*[np.arange(width)] * len(across), indexing="ij"), -1).reshape(
            -1, len(across)
        )
        cell = first[:, None, :] + steps
        away = low + (cell + 0.5) * h - positions[:, None, across]
        reach = radii[:, None] ** 2 - (away**2).sum(axis=2)
        met = (reach > 0.0) & (cell >= 0).all(axis=2) & (cell < counts).all(axis=2)
        particle = np.broadcast_to(np.arange(len(radii))[:, None], met.shape)[met]
        ray = cell[met][:, 0] if len(across) == 1 else cell[met][:, 0] * counts[1] + cell[met][:, 1]
        half = np.sqrt(reach[met])
        result = np.zeros(len(radii))
        area = h ** len(across)
        for sign in (1.0, -1.0):
            # the side where the coordinate is lowest is pressed upwards
            front = sign * positions[particle, axis] - half
            order = np.lexsort((particle, front, ray))
            outermost = order[np.flatnonzero(np.diff(ray[order], prepend=-1))]
            result += sign * area * np.bincount(particle[outermost], minlength=len(radii))
        return result


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
