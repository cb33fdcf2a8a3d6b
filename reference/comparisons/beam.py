"""A bonded beam, held at one end and loaded at the other: stiffness and period in geodem, YADE and LAMMPS.

A square column of spheres on a cubic lattice, every touching pair bonded. A constant force on the spheres of the free
end, or forces round its axis, set it swinging without damping; it swings about the deflection at rest, which is the
mean with a window that ends smoothly. So no code needs a damping that another lacks. The loads are small: what differs
between the laws at large rotations does not show.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Floats, Integers, Posed, Trajectory
from .comparison import Row

CODES = ("yade", "lammps")

RADIUS = 0.01  # [m]
DENSITY = 2600.0  # [kg/m3]
NORMAL, SHEAR = 1.0e5, 4.0e4  # [N/m]
BENDING, TWISTING = 3.2, 2.4  # [N m/rad]
STRONG = 1e6  # [N], [N m], never reached
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY  # [kg]
TIME_STEP = 0.12 * math.sqrt(MASS / NORMAL)  # [s]
STRAIN = 1e-5
"""Of the bonds that are loaded."""
FRAMES = 600

STIFFNESS_BOUND = 1e-3
PERIOD_BOUND = 1e-3

CONTACT = {"normal_stiffness": NORMAL, "shear_stiffness": SHEAR, "friction_coefficient": 0.5}
ELASTIC = {
    "young_modulus": NORMAL / RADIUS, "stiffness_ratio": SHEAR / NORMAL, "friction_coefficient": 0.5,
}  # fmt: skip
LAWS: dict[str, tuple[str, str, Mapping[str, float], Mapping[str, float]]] = {
    "yade": (
        "elastic_frictional",
        "cohesive_moments",
        ELASTIC,
        {
            **ELASTIC,
            "normal_cohesion": STRONG / RADIUS**2,
            "shear_cohesion": STRONG / RADIUS**2,
            "bending_factor": BENDING / (RADIUS**2 * SHEAR),
            "twisting_factor": TWISTING / (RADIUS**2 * SHEAR),
        },
    ),
    "lammps": (
        "linear_frictional",
        "rotational_bond",
        CONTACT,
        {
            "normal_stiffness": NORMAL,
            "shear_stiffness": SHEAR,
            "twisting_stiffness": TWISTING,
            "bending_stiffness": BENDING,
            "tensile_strength": STRONG,
            "shear_strength": STRONG,
            "twisting_strength": STRONG,
            "bending_strength": STRONG,
        },
    ),
}
"""Contact law, bond law and their numbers with which geodem is compared: the same stiffnesses in both."""

_CEMENT = math.sqrt(4.0 * BENDING / NORMAL)  # [m]
CEMENT = {
    "radius_factor": _CEMENT / RADIUS,
    "normal_stiffness": NORMAL / (math.pi * _CEMENT**2),
    "shear_stiffness": SHEAR / (math.pi * _CEMENT**2),
    "tensile_strength": STRONG / RADIUS**2,
    "shear_strength": STRONG / RADIUS**2,
}
"""Parallel bond whose section gives the stiffnesses in tension, shear and bending; that in twist follows."""
CEMENT_TWISTING = 0.5 * SHEAR * _CEMENT**2  # [N m/rad]
SOFT = {"normal_stiffness": 1e-9 * NORMAL, "shear_stiffness": 1e-9 * SHEAR, "friction_coefficient": 0.5}
"""Contact beside a parallel bond, which must not count."""


@dataclass(frozen=True)
class Load:
    """How the free end is loaded.

    Attributes
    ----------
    name, unit : str
        What it does, and the unit of its stiffness.
    steps : int
        About eight periods of the lowest swing.
    """

    name: str
    unit: str
    steps: int


DRAWN = Load("drawn", "N/m", 6000)
TWISTED = Load("twisted", "N m/rad", 12000)
BENT = Load("bent", "N/m", 54000)


@dataclass(frozen=True)
class Beam:
    """A beam that is posed.

    Attributes
    ----------
    posed : Posed
    load : Load
    size : float
        Force, or torque about the axis [N], [N m].
    motion : (n, 3)
        Weights: the deflection, or the angle, is the sum of these times the displacements.
    """

    posed: Posed
    load: Load
    size: float
    motion: Floats


@dataclass(frozen=True)
class Swing:
    """What a beam's motion tells.

    Attributes
    ----------
    stiffness : float
        Load over the mean deflection.
    period : float
        [s]
    deflection : (f,)
    """

    stiffness: float
    period: float
    deflection: Floats


def column(across: int, along: int) -> tuple[Floats, Integers]:
    """Centres (n, 3) [m] of a cubic lattice of touching spheres, the axis along x, and its touching pairs."""
    cells = np.array([[x, y, z] for x in range(along) for y in range(across) for z in range(across)])
    middle = (across - 1) / 2.0
    number = {tuple(cell): k for k, cell in enumerate(cells.tolist())}
    pairs = [
        (k, number[x + dx, y + dy, z + dz])
        for (x, y, z), k in number.items()
        for dx, dy, dz in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        if (x + dx, y + dy, z + dz) in number
    ]
    return 2.0 * RADIUS * (cells - [0.0, middle, middle]), np.array(pairs, dtype=np.int64)


def beam(
    code: str,
    load: Load,
    *,
    across: int = 3,
    along: int = 20,
    law: tuple[str, str, Mapping[str, float], Mapping[str, float]] | None = None,
) -> Beam:
    """A beam in the convention of a code and in the law that it has, or in another `law` with its numbers."""
    contact_law, bond_law, contact, bond = law or LAWS[code]
    b = AssemblyBuilder(3, contact_law, bond_law)
    b.add_material("rock", density=DENSITY, contact=contact, bond=bond)
    positions, pairs = column(across, along)
    b.add_particles(positions, RADIUS, "rock")
    b.bond(pairs)
    b.hold(np.flatnonzero(positions[:, 0] == 0.0), x=0.0, y=0.0, z=0.0, rotation=0.0)
    end = np.flatnonzero(positions[:, 0] == positions[:, 0].max())
    force = NORMAL * 2.0 * RADIUS * STRAIN
    motion = np.zeros_like(positions)
    if load.name == TWISTED.name:
        arms = positions[end] * [0.0, 1.0, 1.0]
        # the corners alone: few groups of particles with one force each
        far = np.isclose((arms**2).sum(axis=1), (arms**2).sum(axis=1).max())
        end, arms = end[far], arms[far]
        round_axis = np.cross([1.0, 0.0, 0.0], arms)
        b.apply(end, force=force * round_axis / np.linalg.norm(arms, axis=1)[:, None])
        size = float(force * np.linalg.norm(arms, axis=1).sum())
        motion[end] = round_axis / (arms**2).sum()
    else:
        # bent, all of the end together bear what one of its spheres is drawn by
        share = force if load.name == DRAWN.name else force / across**2
        b.apply(end, force=[share, 0.0, 0.0] if load.name == DRAWN.name else [0.0, 0.0, share])
        size = share * len(end)
        motion[end, 0 if load.name == DRAWN.name else 2] = 1.0 / len(end)
    every = max(1, load.steps // FRAMES)
    posed = Posed(
        name=f"beam of {len(positions)} spheres, {load.name}, {bond_law}", assembly=b.build(), time_step=TIME_STEP,
        steps=load.steps // every * every, first=every, every=every, pairs_at=(),
        convention="yade" if code == "yade" else "geodem", quantities=("positions",),
        bound=STIFFNESS_BOUND,
    )  # fmt: skip
    return Beam(posed, load, size, motion)


def swing(one: Beam, run: Trajectory) -> Swing:
    """Mean deflection and period of a run. Raises ValueError where it does not swing twice."""
    moved = run.positions - one.posed.assembly.positions
    deflection = (moved * one.motion).sum(axis=(1, 2))
    phase = np.arange(1, len(deflection) + 1) / (len(deflection) + 1)
    window = np.sin(math.pi * phase) ** 4
    mean = float((window * deflection).sum() / window.sum())
    above = deflection - mean
    rising = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0))
    if len(rising) < 3:
        raise ValueError(f"{one.posed.name} swings less than twice in {one.posed.steps} steps")
    crossings = rising + above[rising] / (above[rising] - above[rising + 1])
    frame = one.posed.every * one.posed.time_step
    period = frame * float(crossings[-1] - crossings[0]) / (len(crossings) - 1)
    return Swing(one.size / mean, period, deflection)


def rows_of(one: Beam, ours: Trajectory, theirs: Trajectory) -> list[Row]:
    """Stiffness, period and the whole swing of one beam."""
    mine, yours = swing(one, ours), swing(one, theirs)
    apart = float(np.abs(mine.deflection - yours.deflection).max() / np.abs(yours.deflection).max())
    told = {
        f"stiffness {mine.stiffness:.6g} and {yours.stiffness:.6g} {one.load.unit}, differ by": (
            abs(mine.stiffness / yours.stiffness - 1.0),
            STIFFNESS_BOUND,
        ),
        f"period {mine.period:.6g} and {yours.period:.6g} s, differ by": (
            abs(mine.period / yours.period - 1.0),
            PERIOD_BOUND,
        ),
        "deflection at all times": (apart, math.nan),
    }
    return [
        Row(
            scene=one.posed.name, code=theirs.code, version=theirs.version, law=theirs.law, quantity=quantity,
            difference=difference, bound=bound, steps=one.posed.steps, particles=one.posed.assembly.particles,
            seconds=ours.seconds,
        )
        for quantity, (difference, bound) in told.items()
    ]  # fmt: skip


def cemented(load: Load, **shape: Any) -> tuple[Beam, Beam]:
    """A beam of parallel bonds for geodem, and one for YADE whose moments have the same stiffnesses."""
    ours = beam("geodem", load, law=("linear_frictional", "parallel_bond", SOFT, CEMENT), **shape)
    contact_law, bond_law, contact, bond = LAWS["yade"]
    twisting = {"twisting_factor": CEMENT_TWISTING / (RADIUS**2 * SHEAR)}
    return ours, beam("yade", load, law=(contact_law, bond_law, contact, {**bond, **twisting}), **shape)


def compare(codes: Sequence[str], **shape: Any) -> list[Row]:
    """Rows of all loads; with YADE in its convention, in geodem's own, and with geodem's parallel bond."""
    loads = (DRAWN, TWISTED, BENT)
    rows = []
    for code in codes:
        beams = [beam(code, load, **shape) for load in loads]
        pairs = [(one, one.posed) for one in beams]
        if code == "yade":
            for one in beams:
                own = replace(one.posed, convention="geodem", name=f"{one.posed.name}, own convention")
                pairs.append((replace(one, posed=own), one.posed))
            for load in loads:
                ours, theirs = cemented(load, **shape)
                pairs.append((ours, theirs.posed))
        # a scene that is asked of the other code twice is run once
        asked = list({id(posed): posed for _, posed in pairs}.values())
        found = dict(zip(map(id, asked), BACKENDS[code].run_posed(asked), strict=True))
        mine = run_posed([one.posed for one, _ in pairs])
        for (one, posed), run in zip(pairs, mine, strict=True):
            rows += rows_of(one, run, found[id(posed)])
    return rows
