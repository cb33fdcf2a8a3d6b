"""Link of a bolt: a piece of its bar from particle to particle, or the grout from there to the ground.

Along the bolt an elastic spring that yields at a force and breaks where it has been stretched too far; across it an
elastic one. A link stands for a share: a piece of bar for one, grout for the length that it holds. A broken link bears
nothing.

Reference: bar and grout in series along the length, each elastic and ideally plastic, as in St. John & Van Dillen
(1983), Rockbolts: a new numerical representation and its application in tunnel design, 24th U.S. Symposium on Rock
Mechanics; with an elongation at break.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..parameters import Fault, faults

NAME = "bolt"
DIMENSIONS = (2, 3)
SCALAR = ("yielded",)
TANGENTIAL = ("shear",)
AXIAL: tuple[str, ...] = ()
MOMENT = False
LASTING = True


class BoltParameters(NamedTuple):
    """A link, per share: [1] for a piece of bar, [m] for grout."""

    axial_stiffness: float  # k [N/m per share]: EA over its length for a piece of bar
    yield_force: float  # Fy [N per share], in tension and in compression
    cross_stiffness: float = 0.0  # ks [N/m per share]
    elongation: float = math.inf  # at break, beyond the elastic one [m]
    pretension: float = 0.0  # [N per share]: tension before anything has moved


PARAMETERS = BoltParameters


def starts_bonded(parameters: BoltParameters) -> bool:
    """A link holds from the start, and its break is recorded."""
    return parameters.axial_stiffness > 0.0


def force(
    axial_stiffness, yield_force, cross_stiffness, elongation, pretension, overlap, slip_x, slip_y, slip_z, area,
    intact, yielded, shear_x, shear_y, shear_z,
):  # fmt: skip
    """Forces after a step, and how near the link is to its break.

    With A the share and u the overlap along the bolt: Fn = A (k (u + y) - pretension), within +- A Fy, where y is what
    has yielded; across it dFs = A ks slip. Breaks where -(yielded stretch) reaches the elongation.

    Returns
    -------
    normal, shear_force_x, shear_force_y, shear_force_z : float
        Along the bolt, tension negative, and across it [N].
    yielded, shear_x, shear_y, shear_z : float
        History: yielded stretch [m], shear force [N].
    tension_utilisation, shear_utilisation : float
        [-]; the second is 0.
    """
    trial = axial_stiffness * (overlap + yielded) - pretension
    least = -yield_force
    per_share = trial if trial > least else least
    per_share = per_share if per_share < yield_force else yield_force
    stretched = yielded + (per_share - trial) / axial_stiffness
    held = intact > 0.0
    stiff = cross_stiffness * area
    x = shear_x + stiff * slip_x if held else 0.0
    y = shear_y + stiff * slip_y if held else 0.0
    z = shear_z + stiff * slip_z if held else 0.0
    return (
        area * per_share if held else 0.0, x, y, z,
        stretched, x, y, z,
        abs(stretched) / elongation, 0.0,
    )  # fmt: skip


def energy(
    axial_stiffness, yield_force, cross_stiffness, pretension, overlap, area, intact, yielded, shear_x, shear_y,
    shear_z,
):  # fmt: skip
    """Elastic energy A F^2/(2 k) + Fs^2/(2 ks A) [J], F the axial force per share."""
    trial = axial_stiffness * (overlap + yielded) - pretension
    least = -yield_force
    per_share = trial if trial > least else least
    per_share = per_share if per_share < yield_force else yield_force
    shear = shear_x * shear_x + shear_y * shear_y + shear_z * shear_z
    stiff = cross_stiffness * area
    stored = area * per_share * per_share / axial_stiffness + (shear / stiff if stiff > 0.0 else 0.0)
    return 0.5 * stored if intact > 0.0 else 0.0


def stiffness(axial_stiffness, cross_stiffness, area):
    """Tangent stiffness k A, ks A [N/m], twist, bend [N m/rad]."""
    return axial_stiffness * area, cross_stiffness * area, 0.0, 0.0


def check(parameters: BoltParameters) -> list[Fault]:
    """Parameters out of range: (field, problem, remedy)."""
    found = faults(
        parameters,
        positive=("axial_stiffness", "yield_force", "elongation"),
        not_negative=("cross_stiffness", "pretension"),
        may_be_infinite=("yield_force", "elongation"),
    )
    if parameters.pretension > parameters.yield_force:
        found.append(Fault("pretension", "is above the yield force", "Give no more than that"))
    return found
