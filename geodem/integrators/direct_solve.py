"""The elastic state under given loads, solved instead of relaxed.

Sparse Cholesky-like factorisation (SuperLU, symmetric mode) up to `DIRECT_LIMIT` particles, conjugate gradients
beyond: measured on two cores, 0.03 / 0.3 / 3.3 s for the factorisation and 0.03 / 0.2 / 1.7 s for conjugate
gradients at 2,500 / 10,000 / 50,000 particles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..laws import GROUND_LAWS
from ..model import Model

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]

DIRECT_LIMIT = 20_000

UNBALANCED_LIMIT = 1e-6
"""Largest unbalanced force over the largest force: round-off leaves 1e-10 at most, ground that floats over 1."""


def strain_operators(model: Model) -> tuple[csr_matrix, csr_matrix, csr_matrix]:
    """Sparse (s, 2 n) matrices from displacements to A e_xx, A e_yy and A gamma_xy of the stress points [m2]."""
    from scipy.sparse import csr_matrix

    start, index, vector = model.point_gradient
    row = np.repeat(np.arange(model.stress_points), np.diff(start))
    shape = (model.stress_points, 2 * model.particles)
    x, y = 2 * index.astype(np.int64), 2 * index.astype(np.int64) + 1
    along_x = csr_matrix((vector[:, 0], (row, x)), shape=shape)
    along_y = csr_matrix((vector[:, 1], (row, y)), shape=shape)
    shear = csr_matrix(
        (np.concatenate([vector[:, 1], vector[:, 0]]), (np.concatenate([row, row]), np.concatenate([x, y]))),
        shape=shape,
    )
    return along_x, along_y, shear


def elastic_moduli(model: Model) -> tuple[Floats, Floats]:
    """lambda + G and G of every stress point (s,) [Pa]."""
    moduli = np.array([GROUND_LAWS[model.law].elastic_moduli(p) for p in model.parameters])
    at_points = moduli[model.point_material]
    return at_points[:, 0], at_points[:, 1]


def stiffness(model: Model) -> csr_matrix:
    """Elastic stiffness matrix (2 n, 2 n) [N/m per m], freedoms ordered x0, y0, x1, y1..."""
    from scipy.sparse import diags

    along_x, along_y, shear = strain_operators(model)
    area_modulus, shear_modulus = elastic_moduli(model)
    inverse = 1.0 / model.point_area
    normal = diags((area_modulus + shear_modulus) * inverse)
    cross = diags((area_modulus - shear_modulus) * inverse)
    tangent = diags(shear_modulus * inverse)
    mixed = along_x.T @ cross @ along_y
    matrix = (
        along_x.T @ normal @ along_x
        + along_y.T @ normal @ along_y
        + mixed
        + mixed.T
        + shear.T @ tangent @ shear
    )
    if model.links is not None:
        stretches = link_operator(model)
        matrix = matrix + stretches.T @ diags(model.links.table[:, 0]) @ stretches
    return matrix.tocsr()


def link_operator(model: Model) -> csr_matrix:
    """Sparse (k, 2 n) matrix from displacements to the stretches of the links."""
    from scipy.sparse import csr_matrix

    assert model.links is not None
    start, index, vector = model.links.gradient
    row = np.repeat(np.arange(model.links.number), np.diff(start))
    column = 2 * index.astype(np.int64)
    shape = (model.links.number, 2 * model.particles)
    return csr_matrix(
        (
            np.concatenate([vector[:, 0], vector[:, 1]]),
            (np.concatenate([row, row]), np.concatenate([column, column + 1])),
        ),
        shape=shape,
    )


def elastic_stress(model: Model, displacement: Floats) -> Floats:
    """In-plane elastic stress (s, 3) [Pa] of displacements (n, 2) [m]."""
    u = displacement.ravel()
    xx, yy, xy = (operator @ u / model.point_area for operator in strain_operators(model))
    area_modulus, shear_modulus = elastic_moduli(model)
    mean, deviator = area_modulus * (xx + yy), shear_modulus * (xx - yy)
    return np.stack([mean + deviator, mean - deviator, shear_modulus * xy], axis=1)


def solve_elastic(
    model: Model, external: Floats, *, matrix: csr_matrix | None = None, prescribed: Floats | None = None
) -> tuple[Floats, Floats]:
    """Elastic equilibrium.

    Parameters
    ----------
    model : Model
    external : (n, 2) [N/m]
    matrix : sparse (2 n, 2 n), optional
        `stiffness(model)`, where the caller has it.
    prescribed : (n, 2) [m], optional
        Displacements of the held freedoms; zero if left out.

    Returns
    -------
    displacement (n, 2) [m], stress (s, 3) [Pa]

    Raises
    ------
    InputError
        Part of the ground is not held.
    """
    from scipy.sparse.linalg import MatrixRankWarning, cg, splu
    from threadpoolctl import threadpool_limits

    matrix = stiffness(model) if matrix is None else matrix
    free = ~model.held.ravel()
    displacement = np.zeros(2 * model.particles)
    load = external.ravel().copy()
    if prescribed is not None:
        displacement[~free] = prescribed.ravel()[~free]
        load -= matrix @ displacement
    reduced = matrix[free][:, free]
    floating = InputError(
        "boundary",
        "part of the ground is not held, so it has no equilibrium",
        "Hold it: bottom = 'fixed' or a roller",
    )
    # BLAS threads change the order of sums, and with it the bits
    with threadpool_limits(1):
        if free.any() and model.particles <= DIRECT_LIMIT:
            try:
                options = {"SymmetricMode": True}
                factors = splu(
                    reduced.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
                )
            except (RuntimeError, MatrixRankWarning) as error:
                raise floating from error
            displacement[free] = factors.solve(load[free])
        elif free.any():
            from scipy.sparse import diags

            solution, status = cg(
                reduced, load[free], rtol=1e-11, maxiter=20_000, M=diags(1.0 / reduced.diagonal())
            )
            if status != 0:
                raise floating
            displacement[free] = solution
    # the factors of a singular matrix may well be finite: what they give then balances nothing
    scale = np.abs(load[free]).max(initial=0.0)
    unbalanced = np.abs(load[free] - reduced @ displacement[free]).max(initial=0.0)
    if not unbalanced <= UNBALANCED_LIMIT * scale:
        raise floating
    result = displacement.reshape(-1, 2)
    return result, elastic_stress(model, result)
