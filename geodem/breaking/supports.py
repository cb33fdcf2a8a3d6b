"""What holds a block of ground on its sides: walls, rollers, fixed particles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..assembly import Wall
from ..boundaries.walls import plane
from ..builders.assembly_builder import AXES, AssemblyBuilder
from ..errors import InputError
from ..laws import CONTACT_LAWS

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SUPPORTS = ("wall", "rough", "roller", "fixed", "free")
"""A smooth rigid plane; one with the friction of the ground; particles held across the side; held wholly; nothing."""

SIDES = {2: ("left", "right", "bottom", "top"), 3: ("left", "right", "front", "back", "bottom", "top")}
"""By dimension; left and right along x, front and back along y in 3D, bottom and top along the last axis."""

WALLS = ("wall", "rough")
HELD = ("roller", "fixed")


class Side(NamedTuple):
    """One side of the ground's box: its axis, and whether it is the upper end of it."""

    axis: int
    upper: bool


class Held(NamedTuple):
    """What supports did.

    Attributes
    ----------
    particles : dict of str to (k,) int64
        Held on each side that is a roller or fixed.
    walls : tuple of Wall
    touching : dict of str to int
        Particles within a hundredth of a mean diameter of each wall.
    """

    particles: dict[str, Integers]
    walls: tuple[Wall, ...]
    touching: dict[str, int]


def side(name: str, dimension: int) -> Side:
    """The side of that name, or InputError."""
    names = SIDES[dimension]
    if name not in names:
        raise InputError(
            f"supports, {name}", f"there is no such side in {dimension}D", f"Known: {', '.join(names)}"
        )
    number = names.index(name)
    return Side(number // 2, number % 2 == 1)


def check_supports(supports: Mapping[str, str], dimension: int) -> None:
    """Raise InputError for a side or a support that does not exist."""
    for name, kind in supports.items():
        side(name, dimension)
        if kind not in SUPPORTS:
            raise InputError(
                f"supports, {name}",
                "there is no such support",
                f"Choose one of: {', '.join(SUPPORTS)}",
                value=kind,
            )


def add_supports(
    build: AssemblyBuilder,
    supports: Mapping[str, str],
    positions: Floats,
    radii: Floats,
    ids: Integers,
    bounds: Floats,
) -> Held:
    """Hold a block of ground.

    A wall touches the particle that reaches out farthest. A roller and a fixed side hold the particles whose centres
    are within a mean diameter of the side.

    Parameters
    ----------
    build : AssemblyBuilder
        That has the particles.
    supports : dict
        Of `SUPPORTS` by side; sides that are left out are free.
    positions, radii : (n, d), (n,) [m]
        Of the ground.
    ids : (n,) int64
        Their numbers in the assembly.
    bounds : (2, d) [m]
        Box of the ground.
    """
    dimension = positions.shape[1]
    check_supports(supports, dimension)
    reach = 2.0 * float(radii.mean())
    held: dict[str, Integers] = {}
    walls: list[Wall] = []
    touching: dict[str, int] = {}
    for name, kind in supports.items():
        axis, upper = side(name, dimension)
        along = positions[:, axis]
        if kind in HELD:
            near = along >= bounds[1, axis] - reach if upper else along <= bounds[0, axis] + reach
            held[name] = ids[near]
            _hold(build, held[name], axis, kind)
        elif kind in WALLS:
            surface, touching[name] = wall_place(name, positions, radii)
            fields = CONTACT_LAWS[build.contact_law].PARAMETERS._fields
            smooth = dict.fromkeys((field for field in fields if "friction" in field), 0.0)
            walls.append(_wall(name, axis, upper, surface, bounds, smooth if kind == "wall" else {}))
            build.add_wall(walls[-1])
    return Held(held, tuple(walls), touching)


def wall_place(name: str, positions: Floats, radii: Floats) -> tuple[float, int]:
    """Coordinate of a wall on a side [m], and how many particles touch it, within a hundredth of the mean diameter."""
    axis, upper = side(name, positions.shape[1])
    out = positions[:, axis] + radii if upper else radii - positions[:, axis]
    farthest = float(out.max())
    near = int((farthest - out < 0.02 * float(radii.mean())).sum())
    return (farthest if upper else -farthest), near


def _hold(build: AssemblyBuilder, ids: Integers, axis: int, kind: str) -> None:
    if not len(ids):
        return
    axes = AXES[: build.dimension] if kind == "fixed" else AXES[axis]
    # a roller lets particles slide along the side, and roll on it where they are not bonded to what is held
    still: dict[str, float] = dict.fromkeys(axes, 0.0)
    build.hold(
        ids, x=still.get("x"), y=still.get("y"), z=still.get("z"), rotation=0.0 if kind == "fixed" else None
    )


def _wall(
    name: str, axis: int, upper: bool, surface: float, bounds: Floats, contact: dict[str, float]
) -> Wall:
    point = 0.5 * (bounds[0] + bounds[1])
    point[axis] = surface
    normal = np.zeros(len(point))
    normal[axis] = -1.0 if upper else 1.0
    return plane(name, point, normal, contact=contact)
