"""Faults with a filling: bands of another material along a joint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..builders.body_filling import BodyFilling
from ..builders.joints import Joint, in_band
from ..builders.packings import volumes
from ..errors import InputError


def with_band(
    filling: BodyFilling, joint: Joint, thickness: float, material: str, *, place: str = "fault"
) -> BodyFilling:
    """The filling with the particles of a band along a joint in another material.

    What the band takes from the other materials is what its particles stand for there, so all masses together are
    those of the source with a band of that size.

    Parameters
    ----------
    filling : BodyFilling
    joint : Joint
    thickness : float [m]
        Half of it on each side.
    material : str
        One of the filling's, or a new one.
    place : str
        For messages.

    Raises
    ------
    InputError
        No particle lies in the band, or a material loses all of its own.
    """
    band = in_band(joint, filling.positions, thickness)
    if not band.any():
        diameter = 2.0 * float(filling.radii.mean())
        raise InputError(
            place, f"no particle lies in this band of {thickness:g} m: the ground is elsewhere, or its particles "
            f"of {diameter:.3g} m are too large", "Move it, widen it to a diameter at least, or take smaller particles",
        )  # fmt: skip
    names = filling.materials if material in filling.materials else (*filling.materials, material)
    number = names.index(material)
    moved = band & (filling.material != number)
    own = volumes(filling.radii, filling.dimension)
    count = len(names)
    before = np.bincount(filling.material, own, minlength=count)
    taken = np.bincount(filling.material[moved], own[moved], minlength=count)
    emptied = np.flatnonzero((before > 0.0) & (taken >= before * (1.0 - 1e-12)))
    if len(emptied):
        raise InputError(
            place, f"the band takes all particles of {names[int(emptied[0])]!r}",
            "Make it thinner, or leave that material out",
        )  # fmt: skip
    sources = np.append(filling.sources, 0.0) if count > len(filling.sources) else filling.sources.copy()
    # what a particle stands for differs a little from material to material
    share = np.divide(taken, before, out=np.zeros(count), where=before > 0.0) * sources
    sources = sources - share
    sources[number] += share.sum()
    materials = np.where(moved, number, filling.material).astype(np.int32)
    return replace(filling, material=materials, materials=names, sources=sources)
