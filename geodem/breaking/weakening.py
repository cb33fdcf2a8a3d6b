"""Strength divided by a factor: of every law, by the names of its parameters; stiffness stays.

Divided are strengths, cohesions, adhesions and coefficients of friction, which are tangents: what Zienkiewicz,
Humpheson & Lewis 1975 (Geotechnique 25:671) do to c and tan(phi). Bolts are not ground: they keep what they bear.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..laws import BOND_LAWS, CONTACT_LAWS, JOINT_LAWS
from ..particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

MARKS = ("strength", "cohesion", "adhesion", "friction")
"""Parts of the names of what is divided."""


class Strength(NamedTuple):
    """Tables of a simulation as they are at full strength, see `ParticleReading`."""

    contact: Floats
    bond: Floats
    wall: Floats
    joint: Floats

    @classmethod
    def of(cls, simulation: ParticleSimulation) -> Strength:
        """Those that a simulation has now."""
        s = simulation
        return cls(s.table.copy(), s.bond_table.copy(), s.wall_parameters.copy(), s.joint_table.copy())


def set_strength(simulation: ParticleSimulation, full: Strength, factors: Floats, joints: float) -> None:
    """Divide the strength of every material.

    Parameters
    ----------
    simulation : ParticleSimulation
        Its tables are replaced.
    full : Strength
    factors : (m,) float
        By material of particles [-]; between two materials the larger counts.
    joints : float
        Of all joints [-].
    """
    s, a = simulation, simulation.assembly
    pairs = np.maximum(factors[:, None], factors[None, :]).ravel()
    fields = CONTACT_LAWS[a.contact_law].PARAMETERS._fields
    s.table = _divided(full.contact, fields, pairs)
    if a.walls:
        s.wall_parameters = _divided(full.wall, fields, np.repeat(factors, len(a.walls)))
    if a.bond_law is not None:
        s.bond_table = _divided(full.bond, BOND_LAWS[a.bond_law].PARAMETERS._fields, pairs)
    if a.joints is not None:
        s.joint_table = full.joint.copy()
        for row in s.joint_table:
            law = JOINT_LAWS[a.joints.laws[int(row[0])]]
            row[1:] = _divided(row[None, 1:], law.PARAMETERS._fields, np.array([joints]))[0]


def _divided(table: Floats, fields: tuple[str, ...], factors: Floats) -> Floats:
    weak = np.array([any(mark in name for mark in MARKS) for name in fields])
    found = table.copy()
    # rows of a law with more columns than parameters have what follows from several of them
    columns = np.flatnonzero(weak)
    found[:, columns] = table[:, columns] / factors[:, None]
    return found
