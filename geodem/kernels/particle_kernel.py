"""One kernel a scene: the loops, the laws and the adapters between them, with what the scene lacks left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

from .._jit import compile_kernel, function_source
from ..laws import BOND_LAWS, CONTACT_LAWS, JOINT_LAWS
from ..laws.convention import CONVENTIONS
from ..laws.protocol import IN_SPACE, argument_names
from ..laws.protocol import constants as law_constants
from . import blocks, cell, fours, joints, motion, pairs, sleep, steps, wall_geometry, wall_motion, walls
from .adapters import (
    HistoryLayout,
    bond_adapters,
    contact_adapters,
    convention_texts,
    history_layout,
    joint_adapters,
    module_constants,
    no_bond_adapters,
    wall_adapters,
)


@dataclass(frozen=True)
class Features:
    """What a scene has; everything else is not compiled in.

    Attributes
    ----------
    dimension : int
    contact_law : str
    bond_law : str or None
    materials : int
    shear : bool
        Some contact has friction, so that shear is carried and kept.
    contact_viscous, bond_viscous : bool
        Some viscosity is not zero.
    bonds_scaled : bool
        Some bond is stronger or weaker than its material.
    rotation : bool
        Some particle may turn.
    orientation : bool
        Angles or quaternions are kept.
    gravity, applied, held, anchors, walls : bool
    walls_turn : bool
    facets : bool
        Some wall has segments or triangles.
    local_damping, global_damping : bool
    relax : bool
        Mass-scaled adaptive relaxation instead of true motion.
    energy : bool
        Energy account.
    idle_account : bool
        There are columns of an energy account, which this kernel does not keep: joints lie behind them.
    sleep : bool
        Chunks at rest are skipped.
    periodic : bool
        There is a periodic cell.
    blocked : bool
        Vectorised loop over blocks of pairs that touch (3D).
    convention : str
        Name in `geodem.laws.convention.CONVENTIONS`.
    joint_laws : tuple of str
        Laws of pairs across joints and along bolts; empty where there are none.
    """

    dimension: int
    contact_law: str
    bond_law: str | None = None
    materials: int = 1
    shear: bool = True
    contact_viscous: bool = False
    bond_viscous: bool = False
    bonds_scaled: bool = True
    rotation: bool = True
    orientation: bool = False
    gravity: bool = True
    applied: bool = False
    held: bool = False
    anchors: bool = False
    walls: bool = False
    walls_turn: bool = False
    facets: bool = True
    local_damping: bool = False
    global_damping: bool = False
    relax: bool = False
    energy: bool = False
    idle_account: bool = False
    sleep: bool = False
    periodic: bool = False
    blocked: bool = False
    convention: str = "geodem"
    joint_laws: tuple[str, ...] = ()

    def layout(self) -> HistoryLayout:
        """Columns of the history of pairs."""
        contact, bond = self.laws()
        return history_layout(
            contact,
            bond,
            dimension=self.dimension,
            energy=self.energy or self.idle_account,
            shear=self.shear,
            joints=self.joints(),
        )

    def joints(self) -> tuple[ModuleType, ...]:
        """Modules of the laws of joints."""
        return tuple(JOINT_LAWS[name] for name in self.joint_laws)

    def laws(self) -> tuple[ModuleType, ModuleType | None]:
        """Modules of the laws."""
        return CONTACT_LAWS[self.contact_law], None if self.bond_law is None else BOND_LAWS[self.bond_law]

    def in_blocks(self) -> bool:
        """Whether pairs are computed in blocks; without shear some fours of a block would not be read whole."""
        layout = self.layout()
        if not self.blocked or self.dimension != 3 or self.energy or "shear_x" not in layout.contact:
            return False
        # joints are met pair by pair
        if self.joint_laws:
            return False
        contact, bond = self.laws()
        laws = [law for law in (contact, bond) if law is not None]
        # blocks know geodem's own convention, and what does not depend on the directions of space
        if self.convention != "geodem" or any(set(argument_names(law.force)) & set(IN_SPACE) for law in laws):
            return False
        if bond is not None and getattr(bond, "LINGERS", False):
            return False
        # a block has so many places for what the laws remember
        return max(len(layout.contact), len(layout.bond)) <= blocks.HISTORIES and (
            self.bond_law is None or len(layout.contact) <= blocks.BESIDE_HISTORIES
        )

    def relaxing(self) -> Features:
        """The same scene for the static relaxation: no real time, hence nothing that damps it."""
        return replace(
            self, relax=True, global_damping=True, local_damping=False, contact_viscous=False, bond_viscous=False,
            energy=False, idle_account=self.energy and bool(self.joint_laws), sleep=False,
        )  # fmt: skip


def compile_particle_kernel(features: Features, *, parallel: bool) -> ModuleType:
    """Module with ``advance`` for a scene with these features; see `geodem.kernels.steps.advance`."""
    contact, bond = features.laws()
    layout = features.layout()
    blocked = features.in_blocks()
    law_functions, adapters = contact_adapters(
        contact, name="contact", dimension=features.dimension, layout=layout, viscous=features.contact_viscous
    )
    if bond is None:
        adapters += no_bond_adapters()
    else:
        bond_functions, more = bond_adapters(
            bond, dimension=features.dimension, layout=layout, viscous=features.bond_viscous
        )
        law_functions += bond_functions
        adapters += more
    if not features.joint_laws:
        adapters += ["joint_pair = None"]
    else:
        joint_functions, more = joint_adapters(features.joints(), dimension=features.dimension, layout=layout)
        law_functions += joint_functions
        adapters += more
    adapters = [*convention_texts(CONVENTIONS[features.convention]), *adapters]
    adapters += [*fours.texts(), function_source(pairs.fetch_ahead)]
    loops: list[Callable[..., Any]] = []
    if not blocked:
        loops += [pairs.account]
        loops += joints.FUNCTIONS if features.joint_laws else ()
        loops += [pairs.range_of_pairs, pairs.pairs]
    if features.walls:
        law_texts, more = wall_adapters(
            contact, dimension=features.dimension, layout=layout, viscous=features.contact_viscous
        )
        law_functions += law_texts
        adapters += more
        if blocked:
            loops += [pairs.account]
        if features.facets:
            loops += walls.FACET_FUNCTIONS
        else:
            adapters += [function_source(f) for f in walls.PLANE_FUNCTIONS]
        loops += [walls.wall_forces, *wall_motion.MOTION_FUNCTIONS]
    else:
        adapters += ["wall_forces = None", "gather_wall_forces = None", "move_walls = None"]
    if blocked:
        adapters += [function_source(f) for f in blocks.INLINED]
        loops += blocks.FUNCTIONS
    if features.periodic:
        adapters += [function_source(f) for f in cell.INLINED]
        adapters += [function_source(f) for f in cell.BLOCK_INLINED] if blocked else []
        loops += cell.FUNCTIONS
    else:
        adapters += ["move_cell = None"]
    if features.sleep:
        loops += sleep.FUNCTIONS
    else:
        adapters += ["sleep_and_wake = None"]
    loops += [
        motion.direction,
        motion.turn,
        motion.move,
        steps.watched,
        steps.chunk_forces,
        steps.chunk_motion,
    ]
    loops.append(steps.advance)
    return compile_kernel(
        loops,
        _constants(features, contact, bond),
        parallel=parallel,
        texts=[*law_functions, *adapters],
        finite=True,
        entries=[steps.advance],
    )


def _constants(features: Features, contact: ModuleType, bond: ModuleType | None) -> dict[str, object]:
    layout = features.layout()
    space = features.dimension == 3
    called = [(contact, "force"), (contact, "reach"), (bond, "force")]
    called += [(contact, "viscous")] if features.contact_viscous else []
    called += [(bond, "viscous")] if features.bond_viscous else []
    asked = {
        name
        for law, function in called
        if hasattr(law, function)
        for name in argument_names(getattr(law, function))
    }
    return {
        **law_constants(contact, features.dimension),
        **({} if bond is None else law_constants(bond, features.dimension)),
        **module_constants(pairs, motion, sleep, steps, wall_geometry, blocks, cell, joints),
        "SPHERES": space,
        "SPACE": space,
        "BONDS": bond is not None,
        "REPLACES": bond is not None and bond.REPLACES_CONTACT,
        "LINGERS": bond is not None and bool(getattr(bond, "LINGERS", False)),
        "REACH": hasattr(contact, "reach"),
        "ONE_MATERIAL": features.materials == 1,
        "MATERIALS": features.materials,
        "MOMENT": contact.MOMENT or (bond is not None and bond.MOMENT),
        "ENERGY": features.energy,
        "SCALED": features.bonds_scaled,
        "VISCOUS_CONTACT": features.contact_viscous,
        "VISCOUS_BOND": features.bond_viscous,
        "OFFSET": layout.offset or 0,
        "STORED": layout.stored or 0,
        "ASKS_RADII": bool(asked & {"radius_a", "radius_b"}),
        "ASKS_MASS": bool(asked & {"mass_a", "mass_b"}),
        "ASKS_APPROACH": "approach" in asked,
        "WIDTH": 12 if space else 8,
        "RADIUS": 3 if space else 2,
        "MATERIAL": 11 if space else 3,
        "SPIN": 8 if space else 6,
        "FREEDOMS": 6 if space else 3,
        "ROTATION": features.rotation,
        "ORIENTATION": features.orientation and features.rotation,
        "GRAVITY": features.gravity,
        "APPLIED": features.applied,
        "HELD": features.held,
        "ANCHORS": features.anchors,
        "WALLS": features.walls,
        "WALLS_TURN": features.walls_turn,
        "FACETS": features.facets,
        "LOCAL": features.local_damping,
        "AT_MIDDLE": CONVENTIONS[features.convention].AT_MIDDLE,
        "GLOBAL": features.global_damping,
        "RELAX": features.relax,
        "SLEEP": features.sleep,
        "PERIODIC": features.periodic,
        "JOINTS": bool(features.joint_laws),
        "JOINT": layout.place or 0,
        "JOINT_ROWS": features.materials**2,
    }
