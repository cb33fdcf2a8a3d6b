"""Elastic energy of many contacts or bonds as they are, from the law alone."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ..laws.protocol import argument_names, in_dimension

Floats = NDArray[np.float64]


def law_energy(law: ModuleType, dimension: int, parameters: Floats, known: Mapping[str, Floats]) -> Floats:
    """Elastic energy (p,) [J] (2D: J per m) of every link.

    Parameters
    ----------
    law : module
        One of `geodem.laws.CONTACT_LAWS` or `geodem.laws.BOND_LAWS`.
    dimension : int
        2 or 3.
    parameters : (p, k)
        In the order of ``law.PARAMETERS``.
    known : dict of str to (p,)
        Overlap, radii, distance, masses, scale and history by the law's names for them; what is missing is 0.
    """
    columns = dict(zip(law.PARAMETERS._fields, np.asarray(parameters, dtype=float).T, strict=True)) | dict(
        known
    )
    nothing = np.zeros(len(parameters))
    function = in_dimension(law.energy, dimension)
    wanted = [columns.get(name, nothing).tolist() for name in argument_names(law.energy)]
    return np.array([function(*values) for values in zip(*wanted, strict=True)], dtype=float)
