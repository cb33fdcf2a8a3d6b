"""How discs or spheres are packed: contacts a particle, directions of contacts, share of the volume."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def contacts_of_particles(pairs: NDArray[np.int64], particles: int) -> NDArray[np.int64]:
    """Contacts (n,) of every particle, of pairs (k, 2) of particle numbers."""
    return np.bincount(np.asarray(pairs, dtype=np.int64).ravel(), minlength=particles)


def coordination_number(pairs: NDArray[np.int64], particles: int, *, rattlers: bool = True) -> float:
    """Mean number of contacts of a particle with others [-].

    Without rattlers it is the mechanical coordination number (2 C - N1)/(N - N0 - N1) of C contacts and N particles,
    N0 of them without and N1 with a single contact; 0 where no particle is left. Source: Thornton 2000, Geotechnique
    50:43.
    """
    contacts = contacts_of_particles(pairs, particles)
    if rattlers:
        return float(contacts.sum()) / max(particles, 1)
    single = int((contacts == 1).sum())
    left = int((contacts > 1).sum())
    return (float(contacts.sum()) - single) / left if left else 0.0


def fabric_tensor(normals: Floats) -> Floats:
    """Mean of n_i n_j (d, d) [-] over contact normals (k, d); 0 without any. Source: Satake 1982."""
    normals = np.asarray(normals, dtype=float)
    return np.asarray(np.einsum("ki,kj->ij", normals, normals) / max(len(normals), 1))


def solid_fraction(radii: Floats, dimension: int, volume: float) -> float:
    """Areas of discs or volumes of spheres over the volume [-]; what overlaps counts twice. Porosity is 1 less this."""
    sizes = np.pi * radii**2 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3
    return float(sizes.sum()) / volume
