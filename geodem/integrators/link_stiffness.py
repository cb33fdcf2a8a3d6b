"""Stiffness of many links from the law of contacts or bonds."""

from __future__ import annotations

from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ..laws.protocol import argument_names, in_dimension

Floats = NDArray[np.float64]


def law_stiffness(
    law: ModuleType,
    dimension: int,
    parameters: Floats,
    *,
    radius_a: Floats,
    radius_b: Floats,
    distance: Floats,
    overlap: Floats,
) -> Floats:
    """kn, ks [N/m], k_twist, k_bend [N m/rad] of every link (p, 4).

    Parameters
    ----------
    law : module
        One of `geodem.laws.CONTACT_LAWS` or `geodem.laws.BOND_LAWS`.
    dimension : int
        2 or 3.
    parameters : (p, k)
        In the order of ``law.PARAMETERS``.
    radius_a, radius_b, distance, overlap : (p,) [m]
    """
    columns = dict(zip(law.PARAMETERS._fields, np.asarray(parameters, dtype=float).T, strict=True))
    columns |= {"radius_a": radius_a, "radius_b": radius_b, "distance": distance, "overlap": overlap}
    wanted = [columns[name].tolist() for name in argument_names(law.stiffness)]
    function = in_dimension(law.stiffness, dimension)
    # the plain function, called p times: about 1 s for a million links, once per scene
    rows = [function(*values) for values in zip(*wanted, strict=True)]
    return np.array(rows, dtype=float).reshape(len(overlap), 4)
