"""One to six spheres, a thousand steps: where two codes that do the same differ by rounding only.

Every scene is posed in the convention of the code that it is compared with. Numbers are round and of the size of a
laboratory test; a collision takes some hundred steps, so that a thousand steps hold the whole event. All scenes of
contacts have gravity and a floor, if far below, and all scenes of bonds gravity and a held sphere: so one kernel of
geodem does for all scenes of a law.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geodem.assembly import Assembly
from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Posed
from .comparison import Row, rows_of

STEPS = 1000
BOUND = 1e-11
PILE_BOUND = 1e-9
"""Of twenty spheres: their motion is chaotic, rounding grows tenfold every few hundred steps."""

RADIUS = 0.01  # [m]
DENSITY = 2600.0  # [kg/m3]
GRAVITY = (0.0, 0.0, -9.81)

FLOOR = plane("floor", (0, 0, 0), (0, 0, 1))

Contact = Mapping[str, float]

# two materials for every law: the second softer, smoother, lighter where it may be
ELASTIC = (
    {"young_modulus": 1.0e7, "stiffness_ratio": 0.3, "friction_coefficient": 0.5},
    {"young_modulus": 0.4e7, "stiffness_ratio": 0.7, "friction_coefficient": 0.3},
)
HOOKE_STIFFNESS = (
    {
        "normal_stiffness": 1.0e5, "shear_stiffness": 4.0e4, "friction_coefficient": 0.5, "normal_damping": 60.0,
        "shear_damping": 30.0,
    },
    {
        "normal_stiffness": 0.4e5, "shear_stiffness": 3.0e4, "friction_coefficient": 0.3, "normal_damping": 20.0,
        "shear_damping": 50.0,
    },
)  # fmt: skip
HERTZ = (
    {"young_modulus": 5.0e7, "poisson_ratio": 0.3, "friction_coefficient": 0.5, "restitution": 0.7},
    {"young_modulus": 2.0e7, "poisson_ratio": 0.2, "friction_coefficient": 0.3, "restitution": 0.5},
)
HOOKE = tuple({**material, "characteristic_velocity": 0.5} for material in HERTZ)
LINEAR = (
    {"normal_stiffness": 1.0e5, "shear_stiffness": 4.0e4, "friction_coefficient": 0.5},
    {"normal_stiffness": 0.4e5, "shear_stiffness": 3.0e4, "friction_coefficient": 0.3},
)
MATERIALS: dict[str, tuple[Contact, ...]] = {
    "linear_frictional": LINEAR,
    "elastic_frictional": ELASTIC,
    "hooke_stiffness": HOOKE_STIFFNESS,
    "hooke": HOOKE,
    "hertz_history": HERTZ,
}
TIME_STEP = 4e-6  # [s]

MOMENTS = {"bending_factor": 0.8, "twisting_factor": 0.6}


def builder(
    contact_law: str, *, bond: tuple[str, Mapping[str, float]] | None = None, **given: Any
) -> AssemblyBuilder:
    """A builder with the two materials of a law, "a" and "b"; `bond`: its name, and its strengths and factors."""
    made = AssemblyBuilder(3, contact_law, None if bond is None else bond[0], **given)
    for name, density, contact in zip("ab", (DENSITY, 2000.0), MATERIALS[contact_law], strict=True):
        made.add_material(
            name, density=density, contact=contact, bond=None if bond is None else {**contact, **bond[1]}
        )
    return made


def _posed(name: str, assembly: Assembly, convention: str, **given: Any) -> Posed:
    law = assembly.contact_law
    settings = {"time_step": TIME_STEP, "steps": STEPS, "bound": BOUND} | given
    return Posed(
        name=f"{name}, {assembly.bond_law or law}", assembly=assembly, convention=convention, **settings
    )


def _above(law: str) -> AssemblyBuilder:
    """Room to fall freely for the time of a scene."""
    b = builder(law, gravity=GRAVITY)
    b.add_wall(plane("floor", (0, 0, -0.1), (0, 0, 1)))
    return b


def head_on(law: str, convention: str) -> Posed:
    """Two equal spheres that fall together meet and part."""
    b = _above(law)
    apart = 2.0 * RADIUS + 1e-5
    b.add_particles([[0.0, 0.0, 0.0], [apart, 0.0, 0.0]], RADIUS, "a", velocity=[[0.3, 0, 0], [-0.3, 0, 0]])
    return _posed("head-on", b.build(), convention)


def oblique(law: str, convention: str) -> Posed:
    """Two spheres of other sizes and materials meet askew, both spinning, and slide before they roll."""
    b = _above(law)
    b.add_particles([[0, 0, 0]], RADIUS, "a", velocity=[[0.4, 0.1, -0.05]], spin=[[3.0, -5.0, 20.0]])
    direction = np.array([0.8, 0.36, 0.48])
    b.add_particles(
        [((RADIUS + 0.6 * RADIUS) + 1e-5) * direction], 0.6 * RADIUS, "b", velocity=[[-0.3, -0.2, 0.1]],
        spin=[[-8.0, 6.0, -11.0]],
    )  # fmt: skip
    return _posed("oblique", b.build(), convention)


def on_wall(name: str, law: str, convention: str, velocity: Any, spin: Any, height: float) -> Posed:
    """A sphere at a height above a floor, under gravity."""
    b = builder(law, gravity=GRAVITY)
    b.add_particles([[0, 0, RADIUS + height]], RADIUS, "a", velocity=velocity, spin=spin)
    b.add_wall(FLOOR)
    quantities = ("positions", "velocities", "spins", "forces", "torques", "wall_forces")
    return _posed(name, b.build(), convention, quantities=quantities)


def _sunk(law: str) -> float:
    """About how deep a sphere lies in the floor under its weight [m]."""
    weight = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY * 9.81
    soft = {"elastic_frictional": 1e5, "hooke_stiffness": 2e5}.get(law, 1e5)
    return -weight / soft


def slide(law: str, convention: str) -> Posed:
    """A sphere that slides on a floor, faster than friction lets it roll."""
    return on_wall("slide", law, convention, [[0.6, 0.2, 0.0]], [[0.0, 0.0, 5.0]], _sunk(law))


def roll(law: str, convention: str) -> Posed:
    """A sphere that rolls on a floor: a little too slow at first, which the spring across the contact takes up."""
    pace = 0.05
    return on_wall(
        "roll", law, convention, [[pace, 0.0, 0.0]], [[0.0, 0.8 * pace / RADIUS, 0.0]], 0.2 * _sunk(law)
    )


def impact(law: str, convention: str) -> Posed:
    """A spinning sphere that meets a wall askew."""
    return on_wall("wall impact", law, convention, [[0.2, -0.1, -0.3]], [[10.0, 20.0, 15.0]], 1e-5)


def driven(law: str, convention: str, *, wall_speed: float = 0.0) -> Posed:
    """A sphere dragged along a floor at a given speed, another pressed on it by a constant force, a torque on it.

    LIGGGHTS has neither constant torques nor moving planes: there `wall_speed` is 0 and so is the torque.
    """
    b = builder(law, gravity=GRAVITY)
    dragged = b.add_particles([[0, 0, RADIUS + 0.5 * _sunk(law)]], RADIUS, "a", velocity=[[0.0, 0.0, 0.01]])
    b.hold(dragged, x=0.05)
    pressed = b.add_particles(
        [[0.0004, 0.0002, 2.7995 * RADIUS]], 0.8 * RADIUS, "b", velocity=[[0.1, 0.1, 0.0]]
    )
    b.apply(pressed, force=[[0.0, 0.1, -2.0]], torque=[[0.0, 1e-4, 2e-4]] if wall_speed else None)
    b.add_wall(
        plane("floor", (0, 0, 0), (0, 0, 1), velocity=(0.0, 0.02, wall_speed)) if wall_speed else FLOOR
    )
    quantities = ("positions", "velocities", "spins", "forces", "torques", "wall_forces")
    return _posed("driven and pressed", b.build(), convention, quantities=quantities)


def pile(law: str, convention: str, *, damping: float = 0.0) -> Posed:
    """Twenty spheres of three sizes and two materials, pressed between four walls, on a floor, open above."""
    b = builder(law, gravity=GRAVITY)
    random = np.random.default_rng(7)
    radii = RADIUS * random.choice([0.985, 0.9925, 1.0], 20)
    cells = np.array([[x, y, z] for z in range(5) for y in range(2) for x in range(2)], dtype=float)
    spacing = 1.985 * RADIUS
    positions = (cells + 0.5) * spacing + random.uniform(-0.004, 0.004, (20, 3)) * RADIUS
    velocity = random.normal(0.0, 0.1, (20, 3))
    spin = random.normal(0.0, 0.1 / RADIUS, (20, 3))
    for name, which in (("a", slice(0, None, 2)), ("b", slice(1, None, 2))):
        b.add_particles(positions[which], radii[which], name, velocity=velocity[which], spin=spin[which])
    width = 2.0 * spacing
    b.add_wall(FLOOR)
    b.add_wall(plane("left", (0, 0, 0), (1, 0, 0)))
    b.add_wall(plane("right", (width, 0, 0), (-1, 0, 0)))
    b.add_wall(plane("front", (0, 0, 0), (0, 1, 0)))
    b.add_wall(plane("back", (0, width, 0), (0, -1, 0)))
    quantities = ("positions", "velocities", "spins", "forces", "torques", "wall_forces")
    return _posed(
        "pile of twenty", b.build(), convention, local_damping=damping, bound=PILE_BOUND, quantities=quantities
    )  # fmt: skip


# --- bonds ---------------------------------------------------------------------------------------------------

STRONG = 1e5  # [N], never reached
PRESSING = (-1500.0, 0.0, 0.0)  # [m/s2]
BONDED = ("positions", "velocities", "spins", "forces", "torques", "pair_shear", "broken")


def strengths(law: str, tension: float, shear: float) -> tuple[str, dict[str, float]]:
    """Name of a bond law and its numbers for strengths [N] of a bond of radius `RADIUS`."""
    if law == "cohesive_moments":
        area = RADIUS**2
        return law, {"normal_cohesion": tension / area, "shear_cohesion": shear / area, **MOMENTS}
    area = math.pi * RADIUS**2
    return law, {"tensile_strength": tension / area, "cohesion": shear / area}


def pair(
    law: str,
    *,
    tension: float = STRONG,
    shear: float = STRONG,
    kinds: str = "ab",
    gravity: tuple[float, float, float] = GRAVITY,
    **motion: Any,
) -> Assembly:
    """Two bonded spheres, the first held; `motion` is that of the second."""
    b = builder("elastic_frictional", bond=strengths(law, tension, shear), gravity=gravity)
    radii = [RADIUS, RADIUS if kinds[0] == kinds[1] else 0.8 * RADIUS]
    first = b.add_particles([[0.0, 0.0, 0.0]], radii[0], kinds[0])
    b.hold(first, x=0.0, y=0.0, z=0.0, rotation=0.0)
    b.add_particles([[sum(radii), 0, 0]], radii[1], kinds[1], **motion)
    b.bond([[0, 1]])
    return b.build()


def tension(law: str, convention: str) -> Posed:
    """A bond drawn until it breaks; its ends fly apart."""
    assembly = pair(law, tension=1.5, kinds="aa", velocity=[[0.2, 0.0, 0.0]])
    return _posed("tension to break", assembly, convention, quantities=BONDED)


def shear(law: str, convention: str) -> Posed:
    """A bond sheared while a strong gravity presses it, until it breaks and the two slide."""
    assembly = pair(law, shear=1.0, gravity=PRESSING, velocity=[[0.0, 1.0, 0.4]], spin=[[0.0, 20.0, -50.0]])
    return _posed("shear to break, then slide", assembly, convention, quantities=BONDED)


def bending(law: str, convention: str) -> Posed:
    """A bond bent and turned without breaking."""
    assembly = pair(law, velocity=[[0.1, 0.5, -0.2]], spin=[[0.0, 80.0, -60.0]])
    return _posed("bending", assembly, convention, quantities=BONDED)


def twist(law: str, convention: str) -> Posed:
    """A bond twisted without breaking."""
    assembly = pair(law, velocity=[[0.1, 0.2, 0.0]], spin=[[150.0, 0.0, 10.0]])
    return _posed("twist", assembly, convention, quantities=BONDED)


def beam(law: str, convention: str) -> Posed:
    """Six bonded spheres, the first held, the last struck."""
    b = builder("elastic_frictional", bond=strengths(law, STRONG, STRONG), gravity=GRAVITY)
    b.add_particles([[2.0 * RADIUS * k, 0, 0] for k in range(6)], RADIUS, "a")
    b.hold([0], x=0.0, y=0.0, z=0.0, rotation=0.0)
    b.bond([[k, k + 1] for k in range(5)])
    assembly = b.build()
    assembly.velocities[5] = (0.2, 1.0, -0.5)
    return _posed("beam of six", assembly, convention, quantities=BONDED)


Maker = Callable[[str, str], Posed]
CONTACTS: tuple[Maker, ...] = (head_on, oblique, slide, roll, impact)
BONDS: tuple[Maker, ...] = (tension, shear, bending, twist, beam)

OF_CODE = {
    "yade": (("elastic_frictional",), ("cohesive_moments", "jointed_cohesive"), "yade"),
    "liggghts": (("hooke_stiffness", "hooke", "hertz_history"), (), "liggghts"),
}
"""Contact laws, bond laws and convention in which geodem does what a code does."""


def posed(code: str) -> list[Posed]:
    """All scenes for a code."""
    contacts, bonds, convention = OF_CODE[code]
    found = [make(law, convention) for law in contacts for make in CONTACTS]
    found += [driven(law, convention, wall_speed=0.05 if code == "yade" else 0.0) for law in contacts]
    found += [pile(law, convention, damping=0.2 if code == "yade" else 0.0) for law in contacts]
    if code == "yade":
        found += [_plain(make(law, "yade-plain")) for law in contacts for make in (oblique, slide)]
    return found + [make(law, convention) for law in bonds for make in BONDS]


def _plain(one: Posed) -> Posed:
    return replace(one, name=f"{one.name}, true branch vectors")


def compare(codes: Sequence[str]) -> list[Row]:
    """Rows for every scene of every code: all of a code in one go."""
    rows = []
    for code in codes:
        scenes = posed(code)
        theirs = BACKENDS[code].run_posed(scenes)
        for one, mine, yours in zip(scenes, run_posed(scenes), theirs, strict=True):
            rows += rows_of(one, mine, yours)
    return rows
