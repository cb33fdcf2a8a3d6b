"""Masses and moments of inertia for which one step of the relaxation of an assembly is as long as stability allows.

As in `relaxation`, from the row sums of |K|. A rotation is measured by the displacement it gives at the contacts,
so that the units of length do not enter; a particle gets one mass and one moment of inertia, those of its stiffest
directions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .network import RIGID, Network, stiffness_matrix
from .relaxation import mass_of_rows, row_sums

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]


def lever_arms(network: Network) -> Floats:
    """Mean distance (n,) [m] from every particle to its contacts; of all of them where it has none."""
    links = network.links
    count = len(network.positions)
    second = links.second != RIGID
    particle = np.concatenate([links.first, links.second[second]])
    arm = np.concatenate([links.arms[:, 0], links.arms[second, 1]])
    number = np.bincount(particle, minlength=count)
    mean = float(arm.mean()) if len(arm) else 1.0
    return np.where(number > 0, np.bincount(particle, arm, minlength=count) / np.maximum(number, 1), mean)


def scaled_inertia(
    network: Network, held: NDArray[np.bool_], matrix: csr_matrix | None = None
) -> tuple[Floats, Floats]:
    """Mass (n,) [N step2/m] and moment of inertia (n,) [N m step2] of every particle for a step of one.

    Parameters
    ----------
    network : Network
    held : (n, d + s) bool
    matrix : sparse, optional
        `stiffness_matrix(network)`, where the caller has it. Slip and breakage only lower it; new contacts do not.
    """
    from scipy.sparse import diags

    matrix = stiffness_matrix(network) if matrix is None else matrix
    dimension, freedoms = network.dimension, network.freedoms
    arms = lever_arms(network)
    unit = np.ones((len(arms), freedoms))
    unit[:, dimension:] = 1.0 / arms[:, None]
    scale = diags(unit.ravel())
    scaled = (scale @ matrix @ scale).tocsr()
    rows = row_sums(scaled).reshape(unit.shape)
    rows[:, :dimension] = rows[:, :dimension].max(axis=1, keepdims=True)
    rows[:, dimension:] = rows[:, dimension:].max(axis=1, keepdims=True)
    # what has no stiffness now may get some at its first contact
    rows[rows == 0.0] = rows.max(initial=0.0) or 1.0
    mass = mass_of_rows(scaled, held, rows.ravel()).reshape(unit.shape)
    return mass[:, 0], mass[:, -1] * arms**2
