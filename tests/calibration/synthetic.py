"""A map that is known in closed form, to see whether the surfaces find it from noisy samples.

The formulas are those of a set of two-dimensional prototypes (bonds without moments, discs of size ratio 1.66):
ln R = 1.02 + 0.86 ln(C/Tb) + 0.52 t + 0.035 t ln(C/Tb), phi = 30.8 + 1.3 ln(C/Tb) + 24.3 t - 3.3 t ln(C/Tb) in degrees,
T = 0.62 Tb, E = 0.85 Ec, ks/kn = (1 - 3 nu)/(1 + nu) + 0.12.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from geodem.calibration.table import MapTable, table_of

KAPPAS = (1.2, 1.5, 1.9, 2.5, 3.5, 5.0, 8.0)
RATIOS = (1.5, 3.0, 6.0, 10.0)
FRICTIONS = (0.0, 0.35, 0.7, 1.05)
NOISE = 0.03
"""Of the logarithms; of angles this share of 40 deg, of Poisson's ratio this share of 0.2."""

SCATTER = {"friction_angle": NOISE * math.radians(40.0), "poisson_ratio": NOISE * 0.2}


def truth(micro: dict[str, float]) -> dict[str, float]:
    """Macro answers without noise."""
    kappa, ratio, t = (micro[name] for name in ("stiffness_ratio", "shear_over_tension", "bond_friction"))
    log = math.log(ratio)
    stiffness = 1.0 / kappa - 0.12
    return {
        "modulus_ratio": 0.85,
        # (1 - 3 nu)/(1 + nu) = s, so nu = (1 - s)/(3 + s)
        "poisson_ratio": (1.0 - stiffness) / (3.0 + stiffness),
        "tension_ratio": 0.62,
        "strength_ratio": math.exp(1.02 + 0.86 * log + 0.52 * t + 0.035 * t * log),
        "friction_angle": math.radians(30.8 + 1.3 * log + 24.3 * t - 3.3 * t * log),
    }


class Specimens:
    """Specimens of several seeds: half of the variance of a test is the seed's, the same in all tests of one kind."""

    def __init__(self, seeds: int, rng: np.random.Generator) -> None:
        self.seeds = seeds
        self._rng = rng
        self._own = {name: rng.normal(0.0, 1.0, seeds) for name in ANSWERS}
        self._elastic: dict[tuple[str, float], Any] = {}

    def tested(self, micro: dict[str, float]) -> dict[str, list[float]]:
        """Macro answers; the elastic ones are the same whenever the stiffness ratio is."""
        found = {}
        for name, value in truth(micro).items():
            fresh = self._rng.normal(0.0, 1.0, self.seeds)
            if name in ("modulus_ratio", "poisson_ratio"):
                fresh = self._elastic.setdefault((name, micro["stiffness_ratio"]), fresh)
            noise = math.sqrt(0.5) * (self._own[name] + fresh)
            if name in SCATTER:
                found[name] = [float(value + SCATTER[name] * z) for z in noise]
            else:
                found[name] = [float(value * math.exp(NOISE * z)) for z in noise]
        return found


ANSWERS = ("modulus_ratio", "poisson_ratio", "tension_ratio", "strength_ratio", "friction_angle")


def content(seed: int, *, seeds: int = 4, apart: bool = False) -> dict[str, Any]:
    """A map file: strengths at 16 points, six more stiffness ratios at one of them.

    The same seeds everywhere, or seeds of its own for every point (`apart`).
    """
    rng = np.random.default_rng(seed)
    specimens = Specimens(seeds, rng)
    points = [(2.5, ratio, t) for ratio, t in itertools.product(RATIOS, FRICTIONS)]
    points += [(kappa, 3.0, 0.35) for kappa in KAPPAS if kappa != 2.5]
    rows = []
    for number, (kappa, ratio, t) in enumerate(points):
        if apart:
            specimens = Specimens(seeds, rng)
        micro = {"stiffness_ratio": kappa, "shear_over_tension": ratio, "bond_friction": t}
        first = 1 + number * seeds if apart else 1
        rows.append(
            {"micro": micro, "macro": specimens.tested(micro), "seeds": list(range(first, first + seeds))}
        )
    return {"format": 1, "dimension": 2, "source": "closed form with noise", "rows": rows}


def table(seed: int, *, seeds: int = 4) -> MapTable:
    """The same, read."""
    return table_of(content(seed, seeds=seeds))
