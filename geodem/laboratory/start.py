"""The elastic state at a share of the load of the first break: where a test's motion begins."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..particle_simulation import ParticleSimulation
from ..particle_statics import balance, displace, find_equilibrium

Floats = NDArray[np.float64]

OPENED = 0.05
"""Unbalanced ratio above which a solved state is none: large turns leave a hundredth, contacts that open a half."""

NEARER = 0.25
"""Share of the way to the first break that is gone then: bonds that lose their contact bear a few times as much."""

SETTLED = 1e-3
"""Unbalanced ratio of the equilibrium that is sought then."""

WITHIN = 1.02
"""Utilisation over the share that is wanted, up to which nothing is taken back."""


class Start(NamedTuple):
    """Where a motion begins.

    Attributes
    ----------
    multiple : float
        Of the solved motion.
    steepest : float
        Largest rise of a utilisation per multiple, without what was there before.
    """

    multiple: float
    steepest: float


def go_to_first_break(
    simulation: ParticleSimulation, unit: Floats, trial: float, share: float, *, farthest: float
) -> Start:
    """Move by a multiple of a solved motion until the most stressed bond is at `share` of its strength.

    Where contacts act beside bonds, those across the load open and bonds bear what they bore: the motion then begins
    at a part of that multiple, in equilibrium.

    Utilisations by tension and by shear rise with the multiple each in its own way: one that begins low, because a
    pressure closes the bond, may overtake the other. Both are followed, along their tangents at the start. They are
    convex (sizes of vectors are), so that tangents lead too far; a chord from the start to there leads back, and never
    too far.

    Parameters
    ----------
    simulation : ParticleSimulation
        At rest, where the motion begins.
    unit : (n, d + s) [m, rad]
        The motion that is multiplied, in the order of the assembly.
    trial : float
        A small multiple, at which the bonds are looked at first; more is always gone.
    share : float
        Of the strength, below 1.
    farthest : float
        Multiple beyond which strains are no longer small: where no bond breaks before, no more than `trial` is gone.

    Returns
    -------
    Start
    """
    before = bond_utilisation(simulation, look=True)
    displace(simulation, trial * unit)
    slope = (bond_utilisation(simulation) - before) / trial
    rising = slope > 0.0
    steepest = float(slope.max(initial=0.0))
    room = np.where(rising, (share - before) / np.where(rising, slope, 1.0), math.inf)
    found = float(max(room.min(initial=math.inf), trial))
    if found == trial or not found < farthest:
        return Start(trial, steepest)
    displace(simulation, (found - trial) * unit)
    start, most = float(before.max(initial=0.0)), float(bond_utilisation(simulation).max(initial=0.0))
    if most > WITHIN * share and most > start:
        back = max(found * max(share - start, 0.0) / (most - start), trial)
        displace(simulation, (back - found) * unit)
        found = back
    if balance(simulation) > OPENED:
        # what acts only under pressure has opened, so that this is not the state that was solved for
        displace(simulation, (NEARER - 1.0) * found * unit)
        find_equilibrium(simulation, tolerance=SETTLED, breaking=False)
        found *= NEARER
    return Start(found, steepest)


def bond_utilisation(simulation: ParticleSimulation, *, look: bool = False) -> Floats:
    """Utilisations (b, 2) by tension and by shear of every bond [-]: 1 where it breaks, 0 where it is broken.

    With `look` they are noted anew where everything is; else those of the last `displace`.
    """
    s = simulation
    if look:
        displace(s, np.zeros((s.assembly.particles, s.assembly.held.shape[1])))
    return np.where(s.intact()[:, None], s.utilisation[: len(s.assembly.bonds)], 0.0)
