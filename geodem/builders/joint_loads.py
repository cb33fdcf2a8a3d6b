"""Water in joints: a pressure on both faces, as forces on the particles on both sides."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.assembly_checks import bad_entries, raise_all
from geodem.builders.joint_cut import Cut

Floats = NDArray[np.float64]
Pressure = float | Callable[[Floats], Floats]
"""[Pa], or a function of places (k, d) [m] that tells it (k,)."""


def press_joints(builder: AssemblyBuilder, cut: Cut, pressure: Pressure) -> Floats:
    """Press the faces of joints apart; the forces stay what they are however the joint moves.

    Parameters
    ----------
    builder : AssemblyBuilder
        That was cut.
    cut : Cut
    pressure : float or callable
        See `Pressure`; it acts against the normal stress of the joint, so what is left of that has friction.

    Returns
    -------
    (c, d) [N] (2D: N per m)
        On the second particle of every pair of the cut; the first bears the opposite.
    """
    given = pressure(cut.places) if callable(pressure) else pressure
    values = np.array(np.broadcast_to(np.asarray(given, dtype=float), (len(cut.pairs),)))
    raise_all(bad_entries("joint, pressure", values, 0, "Pa", item="pair"))
    force = (values * cut.areas)[:, None] * cut.normals
    builder.apply(cut.pairs[:, 1], force=force)
    builder.apply(cut.pairs[:, 0], force=-force)
    return np.asarray(force)
