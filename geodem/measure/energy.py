"""The energy account of stress-carrying particles."""

from __future__ import annotations

from types import ModuleType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model import Links, Model


class EnergyAccount(NamedTuple):
    """Work and where it went, per metre of length [J/m].

    external_work = elastic + plastic + damping + kinetic, up to the scheme's error.
    """

    external_work: float
    elastic: float
    plastic: float
    damping: float
    kinetic: float

    @property
    def closure(self) -> float:
        """(external work - the rest) over the external work [-]."""
        spent = self.elastic + self.plastic + self.damping + self.kinetic
        scale = max(abs(self.external_work), abs(self.plastic), 1e-300)
        return (self.external_work - spent) / scale


def elastic_energy(model: Model, law: ModuleType, stress: NDArray[np.float64]) -> float:
    """Elastic energy of stresses (s, >= 3) [Pa] over all stress points [J/m]."""
    moduli = np.array([law.elastic_moduli(p) for p in model.parameters])[model.point_material]
    density = law.elastic_energy(moduli[:, 0], moduli[:, 1], stress[:, 0], stress[:, 1], stress[:, 2])
    return float((density * model.point_area).sum())


def links_energy(links: Links, support: NDArray[np.float64]) -> float:
    """Elastic energy of links (k, 3) of force, plastic stretch and plastic work [J/m]: force^2 / (2 stiffness)."""
    return float((0.5 * support[:, 0] ** 2 / links.table[:, 0]).sum())
