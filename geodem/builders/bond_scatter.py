"""Scatter of strength from bond to bond."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError

Floats = NDArray[np.float64]

LEAST = 0.01
"""Smallest factor of a normal scatter, whose tail would be negative."""


def _refuse_variation(variation: float) -> None:
    if not (np.isfinite(variation) and variation >= 0.0):
        raise InputError(
            "scale, variation", "the coefficient of variation is negative or not finite",
            "Give a number such as 0.2.", value=variation,
        )  # fmt: skip


@dataclass(frozen=True)
class LognormalScatter:
    """Strength factors with the mean 1 that scatter from bond to bond.

    Attributes
    ----------
    variation : float
        Coefficient of variation: standard deviation over mean [-].
    seed : int
        The same seed gives the same factors to the same number of bonds.
    """

    variation: float
    seed: int

    def factors(self, count: int) -> Floats:
        """`count` factors [-]."""
        _refuse_variation(self.variation)
        variance = np.log1p(self.variation**2)
        rng = np.random.default_rng(self.seed)
        return np.asarray(rng.lognormal(-0.5 * variance, np.sqrt(variance), count))


@dataclass(frozen=True)
class NormalScatter:
    """Strength factors with the mean 1 that scatter normally from bond to bond, none below `LEAST`.

    Attributes
    ----------
    variation : float
        Standard deviation over mean [-].
    seed : int
    """

    variation: float
    seed: int

    def factors(self, count: int) -> Floats:
        """`count` factors [-]."""
        _refuse_variation(self.variation)
        rng = np.random.default_rng(self.seed)
        return np.maximum(rng.normal(1.0, self.variation, count), LEAST)
