"""Masses for which one step of the relaxation is as long as stability allows.

Every freedom gets the inertia of its own stiffness (density scaling: it changes the way to equilibrium, not the
equilibrium). With D the row sums of |K|, D^-1 K has eigenvalues in (0, 1]; a few power iterations find the
largest, Gershgorin's bound gives one. Reference: Underwood 1983, Dynamic relaxation, in Computational Methods for
Transient Analysis; the adaptive damping after Joldes, Wittek & Miller 2011 (Int. J. Numer. Meth. Biomed. Eng. 27:173).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]

SHARE_OF_CRITICAL = 0.95
"""Step length over the critical one. Damping of the lowest mode shortens the critical step by less than 1 %."""

POWER_ITERATIONS = 60
EIGENVALUE_MARGIN = 1.02
"""Power iteration approaches the largest eigenvalue from below; after 60 iterations it is within 1-2 %."""


def scaled_mass(matrix: csr_matrix, held: NDArray[np.bool_]) -> Floats:
    """Inertia of every freedom (n, 2) [N step2/m per m] for a step of one.

    Parameters
    ----------
    matrix : sparse (2 n, 2 n) [N/m per m]
        Elastic stiffness; yielding only lowers it.
    held : (n, 2) bool
    """
    return mass_of_rows(matrix, held, row_sums(matrix)).reshape(-1, 2)


def row_sums(matrix: csr_matrix) -> Floats:
    """Sums (m,) of |K_ij| over j."""
    return np.asarray(abs(matrix).sum(axis=1), dtype=float).ravel()


def mass_of_rows(matrix: csr_matrix, held: NDArray[np.bool_], rows: Floats) -> Floats:
    """Inertia (m,) in proportion to `rows`, each at least the row sum of |K|, for a step of one."""
    free = ~held.ravel()
    largest = 1.0
    if free.any():
        reduced, scale = matrix[free][:, free], rows[free]
        # a fixed start with all frequencies in it; the highest mode of a mesh is a checkerboard
        vector = np.cos(np.arange(free.sum()) * 2.399963) + 0.5
        for _ in range(POWER_ITERATIONS):
            vector /= np.sqrt((vector * vector).sum())
            image = (reduced @ vector) / scale
            largest = float((vector * image * scale).sum() / (vector * vector * scale).sum())
            vector = image
    largest = min(1.0, largest * EIGENVALUE_MARGIN)
    return np.asarray(rows * (largest / 4.0 / SHARE_OF_CRITICAL**2))
