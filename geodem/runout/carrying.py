"""What the discs carry over: masses, velocities and spins whose sums are those of the ground they stand for.

Masses: all discs of a material have the density at which their mass is that of the source. Places: the whole packing,
its rigid part too, is moved so that the centre of gravity is that of the source. Velocities: a motion of a rigid body
gives the linear and angular momentum of the source, and what differs from it is scaled so that the kinetic energy is
kept, too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .source import Source

Floats = NDArray[np.float64]


def carried_masses(source: Source, radii: Floats, material: NDArray[np.int32]) -> Floats:
    """Masses (n,) [kg/m] of discs with the mass of every material of the source.

    Parameters
    ----------
    source : Source
    radii : (n,) [m]
    material : (n,) int
        As in the source.
    """
    area = np.pi * radii**2
    own = np.bincount(material, area, minlength=len(source.materials))
    return np.asarray(area * (source.material_mass / np.maximum(own, 1e-300))[material])


def shift_to_centre(source: Source, positions: Floats, mass: Floats) -> Floats:
    """Way (2,) [m] from the centre of gravity of discs to that of the source."""
    return np.asarray(source.centre - (mass[:, None] * positions).sum(axis=0) / mass.sum())


def carried_motion(
    source: Source, positions: Floats, mass: Floats, inertia: Floats, velocity: Floats, spin: Floats
) -> tuple[Floats, Floats]:
    """Velocities (n, 2) [m/s] and spins (n,) [rad/s] with the momenta and the kinetic energy of the source.

    Parameters
    ----------
    source : Source
    positions : (n, 2) [m]
    mass, inertia : (n,) [kg/m, kg m]
    velocity : (n, 2) [m/s], spin : (n,) [rad/s]
        Of the source at the discs.

    Notes
    -----
    Where the rigid motion alone holds more energy than the source, which takes a difference in moments of inertia, what
    remains of the rest is nothing and the energy is a little higher.
    """
    total = float(mass.sum())
    arm = positions - (mass[:, None] * positions).sum(axis=0) / total
    turning = float((mass * (arm**2).sum(axis=1)).sum() + inertia.sum())
    drift, turn = _rigid(arm, mass, inertia, velocity, spin)
    rest = velocity - drift - turn * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    own = spin - turn
    wanted_drift, wanted_turn = source.momentum / total, source.angular_momentum / turning
    rigid = 0.5 * total * float((wanted_drift**2).sum()) + 0.5 * turning * wanted_turn**2
    held = 0.5 * float((mass * (rest**2).sum(axis=1)).sum() + (inertia * own**2).sum())
    scale = float(np.sqrt(max(source.kinetic - rigid, 0.0) / held)) if held > 0.0 else 0.0
    speed = scale * rest + wanted_drift + wanted_turn * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    return np.asarray(speed), np.asarray(scale * own + wanted_turn)


def _rigid(
    arm: Floats, mass: Floats, inertia: Floats, velocity: Floats, spin: Floats
) -> tuple[Floats, float]:
    """Velocity and angular velocity of the rigid body with the same momenta."""
    drift = (mass[:, None] * velocity).sum(axis=0) / mass.sum()
    moment = float(
        (mass * (arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0])).sum() + (inertia * spin).sum()
    )
    turning = float((mass * (arm**2).sum(axis=1)).sum() + inertia.sum())
    return drift, moment / turning
