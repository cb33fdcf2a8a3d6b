"""Bonded ground: an assembly from a body, its particles and its materials, with all that holds, cuts and loads it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Assembly, Wall
from ..builders.assembly_builder import AssemblyBuilder
from ..builders.body import Body
from ..builders.body_filling import BodyFilling, add_body
from ..errors import InputError
from ..laboratory.material import BondedMaterial
from ..particle_simulation import ParticleSimulation
from ..preparation.initial_stress import InitialStress, WantedStress, set_initial_stress
from .bonding import BondCount, bond_ground
from .materials import Interface, SceneMaterial, check_interfaces, laws_of
from .structures import BoltPlan, JointPlan, LiningPlan, Structures, add_bolts, add_linings, cut_joints
from .supports import HELD, add_supports, check_supports, side

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FEW_TOUCHING = 0.25
"""Share of the particles along a wall that touch it at the start, below which a remark is made."""


@dataclass(frozen=True, eq=False)
class BondedScene:
    """Ground that can break, ready to be simulated.

    Attributes
    ----------
    assembly : Assembly
    body : Body
    filling : BodyFilling
        Of the ground; bolts and linings are not in it.
    ids : (n,) int64
        Particle of the assembly of every one of the filling.
    walls : tuple of str
        Sides with a wall, and walls that were given.
    supports : dict of str to str
        By side.
    held : dict of str to (k,) int64
        Particles held on each side that is a roller or fixed.
    bonds : dict of (str, str) to BondCount
        By the two materials, sorted; pairs of materials that meet only.
    loose : (l,) int64
        Particles of bonded materials without any bond.
    structures : Structures
    initial_stress : WantedStress or None
        What `start` brings about.
    warnings : tuple of str
    """

    assembly: Assembly
    body: Body
    filling: BodyFilling
    ids: Integers
    walls: tuple[str, ...]
    supports: Mapping[str, str]
    held: Mapping[str, Integers]
    bonds: Mapping[tuple[str, str], BondCount]
    loose: Integers
    structures: Structures = field(default_factory=Structures)
    initial_stress: WantedStress | None = None
    warnings: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.assembly.dimension

    @property
    def materials(self) -> tuple[str, ...]:
        """Of the ground."""
        return self.filling.materials

    @property
    def box(self) -> Floats:
        """Lowest and highest coordinates of the ground (2, d) [m]."""
        return np.asarray(self.body.bounds, dtype=np.float64)

    def material_ids(self, name: str) -> Integers:
        """Particles of one material of the ground.

        Raises
        ------
        InputError
            There is no such material.
        """
        if name not in self.materials:
            known = ", ".join(self.materials)
            raise InputError("material", "there is no such material", f"Known: {known}", value=name)
        return self.ids[self.filling.material == self.materials.index(name)]


def build_scene(
    body: Body,
    filling: BodyFilling,
    materials: Mapping[str, SceneMaterial],
    *,
    supports: Mapping[str, str] | None = None,
    gravity: ArrayLike | None = None,
    interfaces: Sequence[Interface] = (),
    across: float = 1.0,
    seed: int = 1,
    joints: Sequence[JointPlan] = (),
    bolts: Sequence[BoltPlan] = (),
    linings: Sequence[LiningPlan] = (),
    walls: Sequence[Wall] = (),
    initial_stress: WantedStress | None = None,
) -> BondedScene:
    """Bond the ground, cut, reinforce and hold it.

    The same arguments give the same bits.

    Parameters
    ----------
    body : Body
    filling : BodyFilling
        Its particles.
    materials : dict
        By name, one for each of the filling; all have one law of contacts and one of bonds, see `Interface`.
    supports : dict of str to str, optional
        By side, see `geodem.breaking.supports`; sides that are left out are free.
    gravity : (d,) float, optional
        [m/s2]; none where it is left out.
    interfaces : sequence of Interface
    across : float
        Factor on the strength of bonds between two grains or blocks of the body [-]; 0: not bonded.
    seed : int
        Of the scatter of strength.
    joints, bolts, linings : sequences
        Cut and set in this order.
    walls : sequence of Wall
        Besides those of the sides.
    initial_stress : WantedStress, optional

    Raises
    ------
    InputError
        Materials that do not fit, a side or structure that cannot be, an initial stress that nothing holds.
    """
    supports = dict(supports or {})
    check_supports(supports, filling.dimension)
    missing = [name for name in filling.materials if name not in materials]
    if missing:
        raise InputError("materials", "one is missing", f"Give one for {missing[0]!r}", value=missing[0])
    used = {name: materials[name] for name in filling.materials}
    check_interfaces(interfaces, used)
    contact_law, bond_law = laws_of(used)
    if initial_stress is not None:
        check_stress(initial_stress, supports, filling.dimension)
    build = AssemblyBuilder(filling.dimension, contact_law, bond_law, gravity)
    for name, material in used.items():
        material.check()
        bond = material.bond if isinstance(material, BondedMaterial) else None
        build.add_material(name, density=material.density, contact=material.contact, bond=bond)
    for one in interfaces:
        if one.contact:
            build.set_contact(one.first, one.second, **one.contact)
        if one.bond:
            build.set_bond(one.first, one.second, **one.bond)
    ids = add_body(build, filling, {name: material.density for name, material in used.items()}).ids
    counts, loose = bond_ground(build, filling, ids, used, interfaces, across=across, seed=seed)
    structures = Structures(joints=cut_joints(build, joints, np.asarray(body.bounds)))
    diameter = 2.0 * float(filling.radii.mean())
    structures.bolts.update(add_bolts(build, bolts, body, diameter))
    if linings:
        first = used[filling.materials[0]]
        structures.linings.update(add_linings(build, linings, first.contact, diameter))
    held = add_supports(build, supports, filling.positions, filling.radii, ids, np.asarray(body.bounds))
    for wall in walls:
        build.add_wall(wall)
    return BondedScene(
        assembly=build.build(),
        body=body,
        filling=filling,
        ids=ids,
        walls=(*(wall.name for wall in held.walls), *(wall.name for wall in walls)),
        supports=supports,
        held=held.particles,
        bonds=counts,
        loose=loose,
        structures=structures,
        initial_stress=initial_stress,
        warnings=(*_loose_words(filling, loose), *wall_words(filling, held.touching, supports)),
    )


LOOSE = 'Hold or bond them to what is held; or leave [initial_stress] out and begin with a stage of kind = "settle"'
"""What to do about particles that keep ground from its initial stress."""


def start(scene: BondedScene, **options: Any) -> tuple[ParticleSimulation, InitialStress | None]:
    """A simulation of a scene, brought to its initial stress where it has one.

    Parameters
    ----------
    options
        Of `ParticleSimulation`.

    Raises
    ------
    InputError
        As of `ParticleSimulation` and `set_initial_stress`.
    """
    simulation = ParticleSimulation(scene.assembly, **options)
    if scene.initial_stress is None:
        return simulation, None
    try:
        return simulation, set_initial_stress(simulation, scene.initial_stress)
    except InputError as error:
        if error.place != "assembly":
            raise
        raise InputError("initial_stress", error.problem, LOOSE) from error


def check_stress(wanted: WantedStress, supports: Mapping[str, str], dimension: int) -> None:
    """Raise InputError where no side bears what an initial stress presses on it."""
    peak = np.abs(wanted.at_top) + np.abs(wanted.per_depth)
    free: list[str] = []
    for axis in range(dimension):
        if not peak[axis, axis] > 0.0:
            continue
        kinds = [
            (name, kind)
            for name, kind in supports.items()
            if side(name, dimension).axis == axis and kind in HELD
        ]
        if not kinds:
            free.append("xyz"[axis])
    if free:
        raise InputError(
            "initial_stress",
            f"nothing holds the ground along {' and '.join(free)}: walls do not press on bonded ground",
            'Make its sides there "roller" or "fixed"; the surface may be free',
        )  # fmt: skip
    if (peak - np.diag(np.diag(peak))).any() and "roller" in supports.values():
        raise InputError(
            "initial_stress",
            "rollers bear no shear stress",
            'Make the sides "fixed", or leave the shear stress out',
        )


def _loose_words(filling: BodyFilling, loose: Integers) -> list[str]:
    if not len(loose):
        return []
    share = 100.0 * len(loose) / filling.particles
    return [
        f"{len(loose)} of {filling.particles} particles ({share:.2g} %) belong to bonded materials and have no bond: "
        "they are loose grains. A larger bonding range bonds them."
    ]


def wall_words(filling: BodyFilling, touching: Mapping[str, int], supports: Mapping[str, str]) -> list[str]:
    """Words on walls that hardly anything touches yet."""
    low, high = filling.positions.min(axis=0), filling.positions.max(axis=0)
    diameter = 2.0 * float(filling.radii.mean())
    words = []
    for name, count in touching.items():
        axis = side(name, filling.dimension).axis
        along = np.delete(high - low, axis) / diameter + 1.0
        room = float(np.prod(along))
        if count < FEW_TOUCHING * room:
            words.append(
                f"{count} of about {room:.0f} particles along {name!r} touch its wall ({supports[name]}) at the start: "
                'the ground settles on it first. Bonded ground is held evenly by "roller" or "fixed".'
            )
    return words
