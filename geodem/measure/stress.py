"""Mean stress in a volume, from the forces of contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

Floats = NDArray[np.float64]


def stress_of_contacts(forces: ArrayLike, branches: ArrayLike, volume: float) -> Floats:
    """Mean stress, positive in tension: sum of f_i l_j over the contacts, over the volume.

    Source: Weber 1966, Recherches concernant les contraintes intergranulaires dans les milieux pulverulents; Love 1927.
    Of particles in balance; what is not in balance adds the stress of its inertia.

    Parameters
    ----------
    forces : (k, d) [N]
        On the first particle of every contact.
    branches : (k, d) [m]
        From its centre to that of the second one, or to the point where it touches a wall.
    volume : float
        [m3] (2D: area [m2], forces in N per m).

    Returns
    -------
    (d, d) [Pa]
    """
    force, branch = np.asarray(forces, dtype=float), np.asarray(branches, dtype=float)
    if force.shape != branch.shape or force.ndim != 2:
        raise InputError(
            "stress", f"forces {force.shape} and branches {branch.shape} do not belong together",
            "Give one row of each a contact",
        )  # fmt: skip
    if not (np.isfinite(volume) and volume > 0.0):
        raise InputError("volume", "this is no volume", "Give more than 0", value=volume)
    return np.asarray(np.einsum("ki,kj->ij", force, branch) / volume)
