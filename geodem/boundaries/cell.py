"""A periodic cell while it moves: its edges, its strain, and what it is told to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Cell
from ..errors import InputError
from ..kernels import cell as columns
from ..neighbors import Lattice, lattice

Floats = NDArray[np.float64]

SERVO_SHARE = 0.5
"""Share of its error that a servo makes good in one step, at most: it answers to the stress of the step before."""

GIVEN, STRESS, MEAN = 0.0, 1.0, 2.0
"""What a component answers to: a given rate, its own stress, the mean stress."""


@dataclass
class PeriodicCell:
    """The state of a periodic cell, and its control. Tension and extension are positive.

    Attributes
    ----------
    periodic : (d,) bool
        Along which edges it is periodic.
    state : (CELL_WIDTH,)
        Changed by the steps; columns in `geodem.kernels.cell`.
    """

    periodic: tuple[bool, ...]
    state: Floats

    @classmethod
    def at_start(cls, cell: Cell, reach: float) -> PeriodicCell:
        """A cell at rest; `reach` [m]: the longest distance of a near pair."""
        d = len(cell.periodic)
        state = np.zeros(columns.CELL_WIDTH)
        vectors = np.eye(3)
        vectors[:d, :d] = cell.vectors
        for first, matrix in (
            (columns.CELL_VECTORS, vectors),
            (columns.CELL_DEFORMATION, np.eye(3)),
            (columns.CELL_SEARCHED, np.eye(3)),
        ):
            state[first : first + 9] = matrix.ravel()
        state[columns.CELL_REACH] = reach
        return cls(cell.periodic, state)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.periodic)

    def _matrix(self, first: int) -> Floats:
        """A matrix (d, d) of the state; writes go through."""
        return self.state[first : first + 9].reshape(3, 3)[: self.dimension, : self.dimension]

    @property
    def vectors(self) -> Floats:
        """Edges (d, d) [m] as rows; where the cell shears on, other edges of the same lattice are taken at a search."""
        return self._matrix(columns.CELL_VECTORS).copy()

    @property
    def volume(self) -> float:
        """Volume [m3] (2D: area [m2])."""
        return abs(float(np.linalg.det(self.vectors)))

    @property
    def velocity_gradient(self) -> Floats:
        """dv_i/dx_j (d, d) [1/s] of the next step."""
        return self._matrix(columns.CELL_GRADIENT).copy()

    @property
    def deformation_gradient(self) -> Floats:
        """dx_i/dX_j (d, d) [-] since the start."""
        return self._matrix(columns.CELL_DEFORMATION).copy()

    @property
    def stress(self) -> Floats:
        """Sum of force on the first times branch to the second over the volume (d, d) [Pa], over pairs, last step."""
        return self._matrix(columns.CELL_MOMENT) / self.volume

    @property
    def work(self) -> float:
        """Work of the cell on the particles since the start [J]."""
        return float(self.state[columns.CELL_WORK])

    def lattice(self) -> Lattice:
        """What a search reads."""
        return lattice(self.vectors, self.periodic)

    def corners(self) -> Floats:
        """Corners (2^d, d) [m], the first at the origin; bit k of a corner's number: edge k leads to it."""
        d = self.dimension
        bits = (np.arange(2**d)[:, None] >> np.arange(d)) & 1
        return np.asarray(bits @ self.vectors)

    def outline(self) -> Floats:
        """Ends (k, 2, d) [m] of the cell's edges, 4 in 2D and 12 in 3D."""
        corners, d = self.corners(), self.dimension
        ends = [(c, c | 1 << k) for c in range(2**d) for k in range(d) if not c >> k & 1]
        return corners[np.array(ends)]

    def nearest(self, apart: Floats) -> Floats:
        """Ways (k, d) [m] to the nearest images."""
        return Cell(self.vectors, self.periodic).nearest(apart)

    def shifts(self, image: NDArray[np.int32]) -> Floats:
        """Ways (p, d) [m] to images (p, d)."""
        return image @ self._matrix(columns.CELL_VECTORS)

    # ------------------------------------------------------------------ searches

    def settle(self) -> None:
        """Before a search: take the shortest edges of the lattice, so that shear does not make the cell thin.

        Raises
        ------
        InputError
            The cell has become too thin.
        """
        vectors = self.vectors
        axes = [k for k in range(self.dimension) if self.periodic[k]]
        shorter = True
        while shorter:
            shorter = False
            for j in axes:
                for k in axes:
                    if j != k:
                        whole = np.round((vectors[j] @ vectors[k]) / (vectors[k] @ vectors[k]) * (1.0 - 1e-9))
                        if whole != 0.0:
                            vectors[j] -= whole * vectors[k]
                            shorter = True
        refuse_thin(vectors, self.periodic, float(self.state[columns.CELL_REACH]))
        self._matrix(columns.CELL_VECTORS)[:] = vectors

    @property
    def servo(self) -> bool:
        """Whether some component answers to a stress."""
        return bool((self._matrix(columns.CELL_CONTROL) != GIVEN).any())

    def searched(self) -> None:
        """After a search: note the deformation."""
        first = columns.CELL_SEARCHED
        self.state[first : first + 9] = self.state[columns.CELL_DEFORMATION : columns.CELL_DEFORMATION + 9]

    def carried_along(self, places: Floats) -> Floats:
        """Where places (n, d) of the last search would be now if they had only moved with the cell [m]."""
        now, then = self._matrix(columns.CELL_DEFORMATION), self._matrix(columns.CELL_SEARCHED)
        if np.array_equal(now, then):
            return places
        return np.ascontiguousarray(places @ np.linalg.solve(then.T, now.T))

    # ------------------------------------------------------------------ control

    def set_strain_rate(self, rate: ArrayLike) -> None:
        """See `geodem.particle_cell.ParticleCell.set_strain_rate`."""
        wanted = _square("strain rate", rate, self.dimension, "1/s")
        given = np.isfinite(wanted)
        self._refuse_still(wanted[given])
        # a component of its stress drives both of its entries
        control = self._matrix(columns.CELL_CONTROL)
        gradient = self._matrix(columns.CELL_GRADIENT)
        for i, j in np.argwhere(given):
            if i != j and control[min(i, j), max(i, j)] != GIVEN and not given[j, i]:
                raise InputError(
                    "strain rate", f"components {i}, {j} and {j}, {i} answer to a stress together",
                    "Give both a rate",
                )  # fmt: skip
        gradient[given] = wanted[given]
        control[given] = GIVEN

    def set_target_stress(self, stress: ArrayLike, *, largest_rate: float, gain: float | None) -> None:
        """See `geodem.particle_cell.ParticleCell.set_target_stress`."""
        wanted = _square("stress", stress, self.dimension, "Pa", shear=np.nan)
        given = np.isfinite(wanted)
        if not np.array_equal(
            np.where(given, wanted, 0.0), np.where(given, wanted, 0.0).T
        ) or not np.array_equal(given, given.T):
            raise InputError(
                "stress", "a stress tensor is symmetric", "Give both shear entries", value=stress
            )
        self._servo(given, np.where(given, wanted, 0.0), STRESS, largest_rate, gain)

    def set_mean_stress(
        self, mean: float, *, largest_rate: float, axial: tuple[int, float] | None, gain: float | None
    ) -> None:
        """See `geodem.particle_cell.ParticleCell.set_mean_stress`."""
        d = self.dimension
        if not np.isfinite(mean):
            raise InputError(
                "mean stress", "this is no finite stress", "Give Pa, less than 0 in compression", value=mean
            )
        given = np.eye(d, dtype=bool)
        if axial is not None:
            axis, rate = axial
            if axis not in range(d):
                raise InputError("axial", "there is no such axis", f"Give 0 to {d - 1}", value=axis)
            if not np.isfinite(rate):
                raise InputError("axial", "this is no finite rate", "Give 1/s", value=rate)
            given[axis, axis] = False
        self._servo(given, np.full((d, d), float(mean)), MEAN, largest_rate, gain)
        if axial is not None:
            self._matrix(columns.CELL_GRADIENT)[axis, axis] = rate
            self._matrix(columns.CELL_CONTROL)[axis, axis] = GIVEN

    def _servo(
        self, given: NDArray[np.bool_], target: Floats, kind: float, largest_rate: float, gain: float | None
    ) -> None:
        if not (np.isfinite(largest_rate) and largest_rate > 0.0):
            raise InputError("largest_rate", "this is no rate", "Give more than 0 1/s", value=largest_rate)
        if gain is not None and not (np.isfinite(gain) and gain > 0.0):
            raise InputError(
                "gain", "this is no gain", "Give more than 0 1/(Pa s), or leave it out", value=gain
            )
        self._refuse_still(np.ones(int(given.any())))
        self._matrix(columns.CELL_CONTROL)[given] = kind
        self._matrix(columns.CELL_TARGET)[given] = target[given]
        self._matrix(columns.CELL_LIMIT)[given] = largest_rate
        self._matrix(columns.CELL_GAIN)[given] = gain or 0.0
        # until the first step has told the stress
        self._matrix(columns.CELL_GRADIENT)[given] = 0.0

    def _refuse_still(self, rates: Floats) -> None:
        if not all(self.periodic) and np.any(rates != 0.0):
            raise InputError(
                "cell", "a cell that is not periodic in every direction does not deform",
                "Move walls instead, or make it periodic in every direction",
            )  # fmt: skip

    def set_gain(self, modulus: float, time_step: float) -> None:
        """Choose the gain of servos that were given none, for a modulus of all contacts [Pa]."""
        self.state[columns.CELL_OWN_GAIN] = SERVO_SHARE / (modulus * time_step)

    def stop(self) -> Floats:
        """Hold the cell as it is; returns what `go_on` gives back."""
        before = self.state.copy()
        for first in (columns.CELL_GRADIENT, columns.CELL_LAST, columns.CELL_CONTROL):
            self.state[first : first + 9] = 0.0
        return before

    def go_on(self, before: Floats) -> None:
        """Take up the motion and the control that `stop` ended; what has moved meanwhile is no motion of the cell."""
        for first in (columns.CELL_GRADIENT, columns.CELL_CONTROL):
            self.state[first : first + 9] = before[first : first + 9]


def refuse_thin(vectors: Floats, periodic: tuple[bool, ...], reach: float) -> None:
    """Raise InputError where opposite faces are nearer than two of the longest near pairs `reach` [m]."""
    found = lattice(vectors, periodic).slope[: len(periodic)]
    thickness = np.full(len(found), np.inf)
    thickness[found > 0.0] = 1.0 / found[found > 0.0]
    thin = int(np.argmin(thickness))
    if thickness[thin] < 2.0 * reach:
        raise InputError(
            "cell", f"across edge {thin} it is {thickness[thin]:.6g} m thick, less than twice the reach of a pair of "
            f"{reach:.6g} m (two of the largest radii and the buffer), so a pair might touch twice",
            "Take a larger cell, or more and smaller particles",
        )  # fmt: skip


def _square(what: str, values: ArrayLike, dimension: int, unit: str, shear: float = 0.0) -> Floats:
    """A matrix (d, d) from a number, a diagonal or a matrix; nan is let pass, infinity is not."""
    given = np.asarray(values, dtype=np.float64)
    d = dimension
    if given.ndim == 0 or given.shape == (d,):
        square = np.full((d, d), shear)
        square[np.arange(d), np.arange(d)] = given
    elif given.shape == (d, d):
        square = given.copy()
    else:
        raise InputError(
            what, f"an array of shape {given.shape} is no tensor in {d}D",
            f"Give a number, {d} numbers or {d} rows of {d}, in {unit}", value=values,
        )  # fmt: skip
    if np.isinf(square).any():
        raise InputError(
            what, "these are not finite numbers", f"Give {unit}; nan leaves a component", value=values
        )
    return square
