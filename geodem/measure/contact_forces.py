"""Forces of many contacts or bonds as they are, from the law alone: nothing moves, only what is remembered counts."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from ..laws.protocol import argument_names, in_dimension

Floats = NDArray[np.float64]


def law_forces(law: ModuleType, dimension: int, parameters: Floats, known: Mapping[str, Floats]) -> Floats:
    """Normal force and shear force on a (p, 4) [N] of every link; dashpots push nothing that stands still.

    Parameters
    ----------
    law : module
        One of `geodem.laws.CONTACT_LAWS` or `geodem.laws.BOND_LAWS`.
    dimension : int
        2 or 3. In 2D the shear force is along t = (-ny, nx), and the last two columns are 0.
    parameters : (p, k)
        In the order of ``law.PARAMETERS``.
    known : dict of str to (p,)
        Overlap, radii, distance, masses, scale and history by the law's names for them; what is missing is 0.
    """
    count = len(parameters)
    columns = dict(zip(law.PARAMETERS._fields, np.asarray(parameters, dtype=float).T, strict=True)) | dict(
        known
    )
    nothing = np.zeros(count)
    wanted = [columns.get(name, nothing).tolist() for name in argument_names(law.force)]
    function = in_dimension(law.force, dimension)
    # the plain function, called p times: about 2 s for a million links
    rows = [function(*values)[:4] for values in zip(*wanted, strict=True)]
    return np.array(rows, dtype=float).reshape(count, 4)
