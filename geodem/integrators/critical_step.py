"""The longest time step that is stable: 2/omega for leap-frog, omega the largest frequency of K x = omega^2 M x.

The largest eigenvalue by Lanczos iteration, with its error bound added; where that does not converge, Gershgorin's
bound, which is never below. References: Belytschko 1983, An overview of semidiscretization and time integration
procedures, in Computational Methods for Transient Analysis (damping); O'Sullivan & Bray 2004, Engineering
Computations 21:278 (why rules from a single contact overestimate the step).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]

FREQUENCY_ACCURACY = 1e-3
"""Relative error of the squared frequency at which the iteration ends; it is added to the result."""

SMALL = 64
"""Freedoms up to which all frequencies are found at once."""

LARGE_ACCURACY = 5e-3
"""The same for networks without a matrix, whose highest frequencies lie close together."""

MOST_PRODUCTS = 80
"""Lanczos steps of these; what is left of the residual is added all the same."""


def _mass_scaled(matrix: csr_matrix, mass: Floats, held: NDArray[np.bool_] | None) -> csr_matrix:
    """M^-1/2 K M^-1/2 of the free freedoms: symmetric, and without units that rotations do not share."""
    from scipy.sparse import diags

    root = 1.0 / np.sqrt(mass.ravel())
    if held is not None:
        free = np.flatnonzero(~held.ravel())
        matrix, root = matrix[free][:, free], root[free]
    scale = diags(root)
    return (scale @ matrix @ scale).tocsr()


def gershgorin_frequency(matrix: csr_matrix, mass: Floats, held: NDArray[np.bool_] | None = None) -> float:
    """An upper bound of the largest frequency [rad/s], from the row sums of |M^-1/2 K M^-1/2|.

    Parameters as in `largest_frequency`; 1.0 to 1.55 times the true value in packings.
    """
    scaled = _mass_scaled(matrix, mass, held)
    return math.sqrt(abs(scaled).sum(axis=1).max()) if scaled.shape[0] else 0.0


def largest_frequency(
    matrix: csr_matrix,
    mass: Floats,
    held: NDArray[np.bool_] | None = None,
    *,
    accuracy: float = FREQUENCY_ACCURACY,
) -> float:
    """The largest angular frequency [rad/s] without damping, or a little more: 0 where nothing is free.

    Parameters
    ----------
    matrix : sparse (m, m) [N/m, N m/rad]
        Stiffness, symmetric.
    mass : (m,) or (n, d + s) [kg, kg m2]
        Inertia of every freedom.
    held : bool, shape of mass, optional
        Freedoms that do not move.
    accuracy : float, optional
        Of the squared frequency.
    """
    from scipy.sparse.linalg import ArpackNoConvergence, eigsh

    scaled = _mass_scaled(matrix, mass, held)
    size = scaled.shape[0]
    if size == 0 or scaled.nnz == 0:
        return 0.0
    if size <= SMALL:
        return math.sqrt(max(0.0, np.linalg.eigvalsh(scaled.toarray())[-1]))
    bound = float(abs(scaled).sum(axis=1).max())
    # a fixed start with all frequencies in it, so that the result does not change from run to run
    start = np.random.default_rng(20).uniform(-1.0, 1.0, size)
    try:
        found, vectors = eigsh(scaled, k=1, which="LA", v0=start, tol=0.5 * accuracy, maxiter=50)
    except ArpackNoConvergence:
        return math.sqrt(bound)
    value, vector = float(found[0]), vectors[:, 0]
    # one eigenvalue lies within the residual of the one found
    residual = float(np.linalg.norm(scaled @ vector - value * vector))
    return math.sqrt(min(bound, value + residual))


def largest_frequency_of_products(
    product: Callable[[Floats], Floats], mass: Floats, held: NDArray[np.bool_]
) -> float:
    """The largest angular frequency [rad/s], or a little more, of a network whose matrix is too large to make.

    Parameters
    ----------
    product : function
        K u (n, d + s) of u (n, d + s).
    mass : (n, d + s) [kg, kg m2]
    held : (n, d + s) bool
    """
    from scipy.linalg import eigh_tridiagonal

    root = np.where(held, 0.0, 1.0 / np.sqrt(mass))
    vector = np.random.default_rng(20).uniform(-1.0, 1.0, mass.shape)
    vector[held] = 0.0
    size = math.sqrt(float((vector * vector).sum()))
    if size == 0.0:
        return 0.0
    vector /= size
    before, beside = np.zeros_like(vector), 0.0
    diagonal: list[float] = []
    next_to_it: list[float] = []
    value = residual = 0.0
    for count in range(1, MOST_PRODUCTS + 1):
        # Lanczos without keeping the vectors: copies of a frequency that has been found do no harm
        image = root * product(root * vector)
        diagonal.append(float((image * vector).sum()))
        image -= diagonal[-1] * vector
        image -= beside * before
        beside = math.sqrt(float((image * image).sum()))
        if count % 10 == 0 or count == MOST_PRODUCTS or beside <= 1e-12 * abs(diagonal[0]):
            values, vectors = eigh_tridiagonal(np.array(diagonal), np.array(next_to_it))
            value = float(values[-1])
            residual = beside * abs(float(vectors[-1, -1]))
            if residual <= LARGE_ACCURACY * value or beside <= 1e-12 * abs(diagonal[0]):
                break
        next_to_it.append(beside)
        before, vector = vector, image / beside
    return math.sqrt(max(value + residual, 0.0))


def critical_step(frequency: float, *, viscous: float = 0.0, local: float = 0.0) -> float:
    """The longest stable step of leap-frog [s]; inf where the frequency is 0.

    Viscous forces read the velocity half a step back: dt = 2/omega (sqrt(1 + xi^2) - xi). Cundall's local damping
    alpha enlarges the force by up to 1 + alpha: omega grows by sqrt(1 + alpha), and xi with it. Mass-proportional
    damping in centred form, v+ = (v- (1 - a dt/2) + F/m dt)/(1 + a dt/2), does not shorten the step.

    Parameters
    ----------
    frequency : float
        Largest, without damping [rad/s].
    viscous : float, optional
        Damping ratio xi of a stiffness-proportional damping at that frequency [-].
    local : float, optional
        Cundall's local damping coefficient alpha [-].
    """
    if frequency <= 0.0:
        return math.inf
    enlarged = math.sqrt(1.0 + local)
    ratio = viscous * enlarged
    # (sqrt(1 + xi^2) - xi), written without the difference of two large numbers
    return 2.0 / (frequency * enlarged) / (math.sqrt(1.0 + ratio * ratio) + ratio)
