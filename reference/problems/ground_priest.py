"""A block on an inclined plane with a tension crack, dry and with water: Priest 1993, by rigid-block equilibrium.

Toe (0, 0), face to (17, 30), flat crest, plane at 30 degrees from the toe, tension crack at x = 25.981 m from the crest
down to the plane; c = 20 kPa, phi = 30 degrees, 25 kN/m3. With W the weight, A the length of the plane, U the water's
thrust on it and V that in the crack,

    F = (c A + (W cos(b) - U - V sin(b)) tan(phi)) / (W sin(b) + V cos(b)).

Dry F = 1.1456. With water z = 3.75 m high in the crack, and from there a pressure that falls to nothing at the toe,
V = 69.0 and U = 551.8 kN/m: F = 1.048 (1.049 published with the slope programs that have the example).
Source: Priest 1993, Discontinuity Analysis for Rock Engineering, Chapman & Hall; Hoek & Bray 1981, Rock Slope
Engineering, ch. 7.

Here the block is bonded particles on a smooth joint; those below are held. c and tan(phi) of the joint are divided by a
factor until the block finds no rest. The joint is ideally plastic, as in the formula.
"""

from __future__ import annotations

import math
import time
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.joint_cut import Cut
from geodem.builders.joint_loads import press_joints
from geodem.builders.joints import segment
from geodem.builders.random_packing import random_packing
from geodem.particle_joints import set_joint
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .rows import Row, relative

Floats = NDArray[np.float64]

CORNERS = np.array([[0.0, 0.0], [25.981, 15.0], [25.981, 30.0], [17.0, 30.0]])  # [m]
DIP = math.radians(30.0)
COHESION, FRICTION = 20e3, math.radians(30.0)
WEIGHT = 8239.3e3
"""329.57 m2 at 25 kN/m3 [N/m]."""
LENGTH = 30.0
HEAD = 3.75
"""Of the water in the crack above the plane [m]."""
WATER = 9810.0  # [N/m3]
DRY, WET = 1.1456, 1.048
GRAVITY = 9.81
STIFFNESS = 2e9
"""Of the joint [Pa/m]: a tenth of a millimetre under the block."""
SOURCE = "Priest 1993, rigid-block equilibrium"
MOST_STEPS = 6000
TOLERANCE = 1e-4


class Block(NamedTuple):
    """The block on its plane.

    `moving` are the particles of the block.
    """

    assembly: Assembly
    moving: NDArray[np.int64]
    cut: Cut


def inside(points: Floats, corners: Floats) -> NDArray[np.bool_]:
    """Which points lie in a convex polygon, counter-clockwise."""
    found = np.ones(len(points), dtype=bool)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        way = end - start
        found &= way[0] * (points[:, 1] - start[1]) - way[1] * (points[:, 0] - start[0]) >= 0.0
    return found


@cache
def block(wet: bool, diameter: float) -> Block:
    """The block of particles of a mean diameter [m]."""
    along = np.array([math.cos(DIP), math.sin(DIP)])
    across = np.array([-along[1], along[0]])
    box = (36.0, 40.0)
    packing = random_packing(
        2, radius=0.5 * diameter * 1.25, size_ratio=1.66, box=box, solid_fraction=0.83, seed=1
    )
    points, radii = packing.positions - np.array([5.0, 6.0]), packing.radii
    own = inside(points, CORNERS)
    height = points @ across
    below = (height < 0.0) & (height > -3.0 * diameter) & (points @ along > 0.0) & (points @ along < LENGTH)
    points, radii, own = (np.concatenate([part[own], part[below]]) for part in (points, radii, own))
    build = AssemblyBuilder(2, "effective_modulus", "rock", gravity=(0.0, -GRAVITY))
    contact = {"effective_modulus": 10e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
    bond = {
        "effective_modulus": 10e9, "stiffness_ratio": 2.0, "tensile_strength": 1e9, "shear_strength": 1e9,
        "friction_coefficient": 0.5,
    }  # fmt: skip
    # all of the block's weight on its particles
    density = WEIGHT / GRAVITY / float((math.pi * radii[own] ** 2).sum())
    build.add_material("rock", density=density, contact=contact, bond=bond)
    build.add_particles(points, radii, "rock")
    build.bond_within(1.05)
    moving = np.flatnonzero(own)
    build.add_joint_material(
        "plane", normal_stiffness=STIFFNESS, shear_stiffness=0.5 * STIFFNESS,
        friction_coefficient=math.tan(FRICTION), cohesion=COHESION, residual_cohesion=COHESION,
    )  # fmt: skip
    bounds = [CORNERS.min(axis=0) - 1.0, CORNERS.max(axis=0) + 1.0]
    cut = build.cut([segment(CORNERS[0], CORNERS[1], "plane")], bounds=bounds)
    build.hold(np.flatnonzero(~own), x=0.0, y=0.0, rotation=0.0)
    if wet:
        press_joints(build, cut, lambda places: WATER * HEAD * np.clip(places @ along / LENGTH, 0.0, 1.0))
        # the crack's water on the particles that line it
        line = moving[(points[moving, 0] > CORNERS[1, 0] - diameter) & (points[moving, 1] < 15.0 + HEAD)]
        share = np.clip(15.0 + HEAD - points[line, 1], 0.0, None) * radii[line]
        thrust = 0.5 * WATER * HEAD**2
        build.apply(line, force=np.column_stack([-thrust * share / share.sum(), 0.0 * share]))
    return Block(build.build(), moving, cut)


def rests(scene: Block, factor: float) -> bool:
    """Whether the block finds equilibrium with the joint's strength divided by a factor."""
    s = ParticleSimulation(scene.assembly)
    cohesion = COHESION / factor
    set_joint(
        s,
        "plane",
        friction_coefficient=math.tan(FRICTION) / factor,
        cohesion=cohesion,
        residual_cohesion=cohesion,
    )
    return find_equilibrium(s, tolerance=TOLERANCE, most_steps=MOST_STEPS).reached


def priest(*, wet: bool, diameter: float = 0.8, width: float = 0.005) -> list[Row]:
    """Rows of the factor of safety, of the area of the plane and of the block's weight.

    Parameters
    ----------
    wet : bool
    diameter : float
        Mean, of the particles [m].
    width : float
        Of the bracket of the factor.
    """
    begun = time.perf_counter()
    scene = block(wet, diameter)
    expected = WET if wet else DRY
    low, high = 0.9 * expected, 1.1 * expected
    if not rests(scene, low) or rests(scene, high):
        low = high = math.nan
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rests(scene, middle) else (low, middle)
    seconds = time.perf_counter() - begun
    name = "priest wet" if wet else "priest dry"
    count = len(scene.moving)
    return [
        relative(name, f"factor, {count} particles", 0.5 * (low + high), expected, 0.02, seconds, SOURCE),
        relative(
            name, "length of the plane [m]", float(scene.cut.areas.sum()), LENGTH, 0.02, 0.0, "geometry"
        ),
    ]
