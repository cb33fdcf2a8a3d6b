"""Rock bolts, cables and linings: chains of small particles in and along the ground.

A bolt's particles touch nothing. Pieces of bar join them, grout joins each to the particles of the ground around it,
and a plate its head to those at the face: links of the law `bolt`, along the bolt's own direction. In 2D a bolt is a
sheet: stiffness and forces are those of one bolt over the distance between bolts out of the plane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.assembly_checks import as_numbers
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

AROUND = {2: 2, 3: 4}
"""Particles of the ground that each particle of a bolt is grouted to."""

PLATE = {2: 4, 3: 8}
"""Particles of the ground that a plate presses on."""

STIFF = 10.0
"""A plate is this many times as stiff as a piece of bar."""


@dataclass(frozen=True)
class Bar:
    """What a bolt is made of; in 2D each number over the distance between bolts out of the plane.

    Attributes
    ----------
    axial_stiffness : float
        EA [N].
    yield_force : float
        [N]; infinite: it does not yield.
    elongation : float
        Strain at break, beyond the elastic one [-].
    density_per_length : float
        [kg/m]
    pretension : float
        Tension before the ground has moved [N].
    """

    axial_stiffness: float
    yield_force: float = math.inf
    elongation: float = math.inf
    density_per_length: float = 10.0
    pretension: float = 0.0


@dataclass(frozen=True)
class Grout:
    """What holds a bolt in the ground, per length of the bolt.

    Attributes
    ----------
    stiffness : float
        Shear force over slip and length [N/m2].
    strength : float
        Shear force over length at which it slips [N/m].
    cross_stiffness : float, optional
        Across the bolt [N/m2]; as along it where it is left out.
    """

    stiffness: float
    strength: float = math.inf
    cross_stiffness: float | None = None


@dataclass(frozen=True, eq=False)
class Bolt:
    """A bolt in an assembly.

    Attributes
    ----------
    particles : (k,) int64
        From the head to the far end.
    along : (k,) [m]
        How far each is from the head.
    pieces : (k - 1, 2) int64
        Pieces of bar.
    grouted : (g, 2) int64
        Particle of the bolt, particle of the ground.
    plate : (p, 2) int64
        Head, particle of the ground.
    """

    particles: Integers
    along: Floats
    pieces: Integers
    grouted: Integers
    plate: Integers


def add_bolt(
    builder: AssemblyBuilder,
    name: str,
    head: ArrayLike,
    end: ArrayLike,
    bar: Bar,
    grout: Grout,
    *,
    spacing: float,
    grouted: tuple[float, float] = (0.0, math.inf),
    plate: bool = False,
) -> Bolt:
    """Add a bolt from its head to its far end; the ground is to be there and bonded, and joints cut, before.

    Parameters
    ----------
    builder : AssemblyBuilder
        With a bond law.
    name : str
        Of its materials, no other bolt's.
    head, end : (d,) float [m]
    bar : Bar
    grout : Grout
    spacing : float
        Of its particles, about [m]: no more than the diameter of those of the ground.
    grouted : (float, float)
        From where to where, from the head [m]; elsewhere it is free.
    plate : bool
        A plate holds the head to the face.

    Raises
    ------
    InputError
        Numbers out of range; nothing to grout it to.
    """
    d = builder.dimension
    first, last = (as_numbers(f"bolt {name!r}, ends", each, (d,), "m") for each in (head, end))
    length = float(np.linalg.norm(last - first))
    if not (math.isfinite(length) and length > 0.0 and 0.0 < spacing <= length):
        raise InputError(
            f"bolt {name!r}", "its length or the spacing of its particles is none",
            "Give two ends, and a spacing up to their distance", value=spacing,
        )  # fmt: skip
    ground, places, radii = builder.solid()
    if not len(ground):
        raise InputError(f"bolt {name!r}", "there is no ground around it", "Add the ground first")
    count = max(1, round(length / spacing))
    piece = length / count
    along = piece * np.arange(count + 1, dtype=np.float64)
    axis = (last - first) / length
    points = first + along[:, None] * axis
    radius = 0.5 * piece
    volume = math.pi * radius**2 if d == 2 else 4.0 / 3.0 * math.pi * radius**3
    builder.add_untouched_material(f"{name} bolt", density=bar.density_per_length * piece / volume)
    particles = np.arange(builder.particles, builder.particles + count + 1)
    builder.add_particles(points, radius, f"{name} bolt")
    per_piece = bar.axial_stiffness / piece
    builder.add_joint_material(
        f"{name} bar", law="bolt", axial_stiffness=per_piece, yield_force=bar.yield_force,
        elongation=bar.elongation * piece, pretension=bar.pretension,
    )  # fmt: skip
    pieces = np.stack([particles[:-1], particles[1:]], axis=1)
    builder.link(pieces, axis, 1.0, f"{name} bar")

    held = _nearest(points, places, radii, AROUND[d])
    # half a piece at both ends, and what of each lies within the grouted length
    low = np.maximum(along - 0.5 * piece, max(grouted[0], 0.0))
    high = np.minimum(along + 0.5 * piece, min(grouted[1], length))
    share = np.maximum(high - low, 0.0)
    own = np.flatnonzero(share > 1e-9 * piece)
    if not len(own):
        raise InputError(
            f"bolt {name!r}, grouted", "none of it is", "Give from where to where", value=grouted
        )
    cross = grout.stiffness if grout.cross_stiffness is None else grout.cross_stiffness
    builder.add_joint_material(
        f"{name} grout", law="bolt", axial_stiffness=grout.stiffness, yield_force=grout.strength,
        cross_stiffness=cross,
    )  # fmt: skip
    around = held.shape[1]
    joined = np.stack([np.repeat(particles[own], around), ground[held[own]].ravel()], axis=1)
    builder.link(joined, axis, np.repeat(share[own] / around, around), f"{name} grout")

    pressed = np.empty((0, 2), dtype=np.int64)
    if plate:
        face = _nearest(points[:1], places, radii, PLATE[d])[0]
        # grouted ones are linked to the head already
        face = np.setdiff1d(ground[face], joined[joined[:, 0] == particles[0], 1])
        if not len(face):
            raise InputError(
                f"bolt {name!r}, plate", "nothing is left for it", "Leave the head without grout"
            )
        pressed = np.stack([np.full(len(face), particles[0]), face], axis=1)
        builder.add_joint_material(
            f"{name} plate", law="bolt", axial_stiffness=STIFF * per_piece, yield_force=math.inf,
            cross_stiffness=STIFF * per_piece,
        )  # fmt: skip
        builder.link(pressed, axis, 1.0 / len(face), f"{name} plate")
    return Bolt(particles, np.asarray(along), pieces, joined, pressed)


def add_lining(
    builder: AssemblyBuilder,
    name: str,
    points: ArrayLike,
    *,
    axial_stiffness: float,
    bending_stiffness: float,
    density_per_length: float,
    contact: dict[str, float],
    closed: bool = False,
) -> Integers:
    """Add a lining: a chain of touching particles, bonded as a beam, that never breaks; it touches the ground.

    The particles' radius follows from the section, r = sqrt(3 EI/EA) in 2D (half of a solid section's height) and
    2 sqrt(EI/EA) in 3D, and they lie a diameter apart, as near as the outline allows.

    Parameters
    ----------
    builder : AssemblyBuilder
        With the bond law `rock`.
    name : str
        Of its material.
    points : (k, d) float [m]
        Outline of its middle line.
    axial_stiffness, bending_stiffness : float
        EA [N] and EI [N m2]; in 2D per metre.
    density_per_length : float
        [kg/m]
    contact : dict
        Of the builder's contact law, with itself.
    closed : bool
        The last point is joined to the first.

    Returns
    -------
    (n,) int64
        Its particles, in order.

    Raises
    ------
    InputError
        Another bond law; a section or an outline that is none.
    """
    d = builder.dimension
    if builder.bond_law != "rock":
        problem = "its bonds are those of the law 'rock'"
        raise InputError(
            f"lining {name!r}", problem, "Give AssemblyBuilder bond_law='rock'", value=builder.bond_law
        )
    for what, value in (("axial_stiffness", axial_stiffness), ("bending_stiffness", bending_stiffness)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(
                f"lining {name!r}, {what}", "this is no stiffness", "Give more than 0", value=value
            )
    radius = math.sqrt((3.0 if d == 2 else 4.0) * bending_stiffness / axial_stiffness)
    corners = np.asarray(points, dtype=float)
    if corners.ndim != 2 or corners.shape[1] != d or len(corners) < 2:
        raise InputError(
            f"lining {name!r}, points", "these are no outline", f"Give two points or more in {d}D"
        )
    line = np.concatenate([corners, corners[:1]]) if closed else corners
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    count = round(float(lengths[-1]) / (2.0 * radius))
    if count < 2:
        raise InputError(
            f"lining {name!r}", "it is thicker than long: its particles are as thick as the section",
            "Give a longer outline, or a thinner section", value=2.0 * radius,
        )  # fmt: skip
    at = np.linspace(0.0, lengths[-1], count + 1)
    at = at[:-1] if closed else at
    centres = np.stack([np.interp(at, lengths, line[:, axis]) for axis in range(d)], axis=1)
    piece = float(lengths[-1]) / count
    volume = math.pi * radius**2 if d == 2 else 4.0 / 3.0 * math.pi * radius**3
    # kn of the bond, Ec (2D) or Ec pi r/2 (3D), is EA over the piece
    modulus = axial_stiffness / piece / (1.0 if d == 2 else 0.5 * math.pi * radius)
    bond = {
        "effective_modulus": modulus, "stiffness_ratio": 2.0, "tensile_strength": math.inf,
        "shear_strength": math.inf, "friction_coefficient": 0.0,
    }  # fmt: skip
    builder.add_material(name, density=density_per_length * piece / volume, contact=contact, bond=bond)
    particles = np.array(builder.add_particles(centres, radius, name), dtype=np.int64)
    builder.bond(np.stack([particles[:-1], particles[1:]], axis=1))
    if closed:
        builder.bond([[particles[-1], particles[0]]])
    return particles


def _nearest(points: Floats, places: Floats, radii: Floats, count: int) -> Integers:
    """Particles (k, count) whose surfaces are nearest to each point, ascending."""
    found = np.empty((len(points), min(count, len(places))), dtype=np.int64)
    for row, point in zip(found, points, strict=True):
        gap = np.sqrt(((places - point) ** 2).sum(axis=1)) - radii
        row[:] = np.sort(np.argsort(gap, kind="stable")[: len(row)])
    return found
