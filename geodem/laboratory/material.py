"""What a specimen is made of: the laws of its bonds and contacts with their parameters, and which pairs are bonded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..builders.bond_scatter import LognormalScatter, NormalScatter
from ..errors import InputError
from ..laws import BOND_LAWS, CONTACT_LAWS
from ..laws.protocol import make_parameters

DISTRIBUTIONS = ("normal", "lognormal")


@dataclass(frozen=True)
class BondedMaterial:
    """Bonded grains.

    Attributes
    ----------
    density : float
        Of the grains [kg/m3].
    bond, contact : dict of str to float
        Parameters of the laws, SI.
    bond_law, contact_law : str
        Names in `geodem.laws.BOND_LAWS` and `CONTACT_LAWS`.
    bonding_range : float
        Pairs up to this many times the sum of their radii apart are bonded [-].
    variation : float
        Coefficient of variation of the strength from bond to bond [-].
    distribution : str
        Of that strength, normal or lognormal.
    name : str
    """

    density: float
    bond: Mapping[str, float]
    contact: Mapping[str, float]
    bond_law: str = "rock"
    contact_law: str = "effective_modulus"
    bonding_range: float = 1.05
    variation: float = 0.0
    distribution: str = "lognormal"
    name: str = "rock"

    @classmethod
    def rock(
        cls,
        *,
        density: float,
        effective_modulus: float,
        stiffness_ratio: float,
        tensile_strength: float,
        shear_strength: float,
        friction_angle: float,
        moment_contribution: float = 0.0,
        residual_friction: float = 0.5,
        bonding_range: float = 1.05,
        name: str = "rock",
    ) -> BondedMaterial:
        """Bonds of the law `rock`, contacts as stiff as they are.

        Parameters
        ----------
        density : float [kg/m3]
        effective_modulus : float [Pa]
        stiffness_ratio : float
            kn/ks [-].
        tensile_strength, shear_strength : float
            Of a bond [Pa].
        friction_angle : float
            Of a bond [rad].
        moment_contribution : float [-]
        residual_friction : float
            Friction coefficient once a bond is broken [-].
        bonding_range : float [-]
        """
        bond = {
            "effective_modulus": effective_modulus,
            "stiffness_ratio": stiffness_ratio,
            "tensile_strength": tensile_strength,
            "shear_strength": shear_strength,
            "friction_coefficient": math.tan(friction_angle),
            "moment_contribution": moment_contribution,
        }
        contact = {
            "effective_modulus": effective_modulus,
            "stiffness_ratio": stiffness_ratio,
            "friction_coefficient": residual_friction,
        }
        return cls(density, bond, contact, bonding_range=bonding_range, name=name)

    def with_bond(self, **values: float) -> BondedMaterial:
        """The same with other values of the bond law."""
        return replace(self, bond={**self.bond, **values})

    def unbreakable(self) -> BondedMaterial:
        """The same with bonds of infinite strength."""
        strengths = {key: math.inf for key in self.bond if key.endswith("_strength")}
        return replace(self, bond={**self.bond, **strengths}, variation=0.0)

    def scatter(self, seed: int) -> float | LognormalScatter | NormalScatter:
        """Strength factors for `AssemblyBuilder.bond_within`."""
        if self.variation == 0.0:
            return 1.0
        kind = LognormalScatter if self.distribution == "lognormal" else NormalScatter
        return kind(self.variation, seed)

    def check(self) -> None:
        """Raise InputError where a law is not known, or a parameter is missing or out of range."""
        laws: list[tuple[str, str, Mapping[str, Any], Mapping[str, float]]] = [
            ("bond", self.bond_law, BOND_LAWS, self.bond),
            ("contact", self.contact_law, CONTACT_LAWS, self.contact),
        ]
        for kind, name, known, values in laws:
            if name not in known:
                remedy = f"Choose one of: {', '.join(known)}"
                raise InputError(f"material, {kind} law", "there is no such law", remedy, value=name)
            make_parameters(known[name], values, f"material, {kind}")
        if self.distribution not in DISTRIBUTIONS:
            remedy = f"Choose one of: {', '.join(DISTRIBUTIONS)}"
            raise InputError(
                "material, distribution", "no such distribution", remedy, value=self.distribution
            )
