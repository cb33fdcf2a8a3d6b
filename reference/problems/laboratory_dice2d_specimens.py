"""Specimens and materials of DICE2D's laboratory (Zhao 2015, sections 2.5 and 3.3).

Discs have the radius 10 m that the text calls their mean particle size: rows of 20 and 19 of them are the 400 m of its
large specimen, 40 rows its 695.5 m. Bonds are those of two springs, every one of the same stiffness and strength.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.builders.close_pairs import close_pairs
from geodem.builders.packings import lattice
from geodem.integrators.network import Network, build_network, pair_links
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.specimen import Specimen, make_specimen
from geodem.laws.bond.two_springs import stiffness

from .dice2d_tables import friction

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]

RADIUS = 10.0  # [m]
STIFFNESS = 1e8  # kn, tables 2.6, 2.7 and 3.7 [N/m]
DENSITY = 1000.0  # [kg/m3]
HEIGHT = math.sqrt(3.0) * RADIUS
"""Of a row of the triangular packing [m]."""
STRENGTH = 2e7  # Ft, table 3.7 [N]
UNIT = STRENGTH / (2.0 * RADIUS)
"""Ft over the diameter [Pa]: strengths are given in it as alpha (eq. 3.1)."""
COHESION = 10.0
"""Of the bonds over Ft, which the text does not give: enough that nothing fails in shear before it does in tension."""
FRICTION = 80.0  # [deg]
RATIO = 0.2
"""ks/kn where nothing else is said; table 3.7 leaves it open."""
WIDTH_RATIO = 0.1
"""WRT, the text's own default."""


@dataclass(frozen=True)
class Bonded:
    """Discs and the pairs of them that are bonded.

    Attributes
    ----------
    positions : (n, 2) [m]
        Inside a box from the origin.
    radii : (n,) [m]
    pairs : (b, 2) int64
    box : (2,) [m]
    """

    positions: Floats
    radii: Floats
    pairs: Pairs
    box: Floats

    @property
    def coordination(self) -> float:
        """Mean number of bonds of a disc [-]."""
        return 2.0 * len(self.pairs) / len(self.radii)

    def ends(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Discs (n,) within a diameter of the low and of the high end of the axis."""
        along = self.positions[:, 1]
        return along < 2.0 * RADIUS, along > self.box[1] - 2.0 * RADIUS

    def specimen(self, packing: str) -> Specimen:
        """The same for the laboratory's tests."""
        return Specimen(self.positions, self.radii, self.box, "prism", packing, None)

    def network(self, ratio: float, width_ratio: float = WIDTH_RATIO) -> Network:
        """Its links, with ks/kn and WRT."""
        smaller = self.radii[self.pairs].min(axis=1)
        bending = [stiffness(STIFFNESS, 0.0, width_ratio, r, r)[3] for r in smaller]
        return build_network(
            self.positions,
            pair_links(
                self.positions, self.radii, self.pairs, STIFFNESS, ratio * STIFFNESS, 0.0, np.array(bending)
            ),
        )


def bonded(positions: Floats, radii: Floats, box: Floats, factor: float) -> Bonded:
    """Every pair within `factor` times the sum of its radii is bonded; discs without a bond are left out."""
    pairs, _ = close_pairs(positions, radii, lambda a, b: factor * (a + b), None)
    while True:
        kept = np.bincount(pairs.ravel(), minlength=len(radii)) > 1
        if kept.all():
            return Bonded(positions, radii, pairs, box)
        new = np.cumsum(kept) - 1
        pairs = new[pairs[kept[pairs].all(axis=1)]]
        positions, radii = positions[kept], radii[kept]


def square(wide: int, high: int) -> Bonded:
    """Discs on a square lattice, in columns and rows."""
    found = lattice("square", RADIUS, box=(2.0 * RADIUS * wide, 2.0 * RADIUS * high))
    return bonded(found.positions, found.radii, found.box, 1.01)


def triangular(wide: int, high: int) -> Bonded:
    """Horizontal rows, `high` of them, of `wide` and `wide` - 1 discs in turn."""
    found = lattice("hexagonal", RADIUS, box=(2.0 * RADIUS * wide, 2.0 * RADIUS + HEIGHT * (high - 1)))
    return bonded(found.positions, found.radii, found.box, 1.01)


def irregular(width: float, height: float, factor: float, seed: int) -> Bonded:
    """A random packing of mean radius 10 m, bonded within `factor` times the sum of the radii.

    Sizes are those of the laboratory's specimens, 1.66 from smallest to largest; the text does not give its own.
    """
    found = make_specimen(2, width=width, height=height, across=0.5 * width / RADIUS, seed=seed)
    return bonded(found.positions, found.radii, found.size, factor)


def material(
    factor: float = 1.01,
    *,
    ratio: float = RATIO,
    width_ratio: float = WIDTH_RATIO,
    cohesion: float = COHESION,
    angle: float = FRICTION,
) -> BondedMaterial:
    """Table 3.7: bonds within `factor` times the sum of the radii, cohesion over Ft, friction angle [deg]."""
    contact = {
        "normal_stiffness": STIFFNESS,
        "shear_stiffness": ratio * STIFFNESS,
        "friction_coefficient": friction(angle),
    }
    bond = {
        **contact,
        "tensile_strength": STRENGTH,
        "cohesion": cohesion * STRENGTH,
        "width_ratio": width_ratio,
    }
    return BondedMaterial(
        DENSITY, bond, contact, bond_law="two_springs", contact_law="linear_frictional", bonding_range=factor,
        name="disc",
    )  # fmt: skip
