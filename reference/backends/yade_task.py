"""From an assembly to what `inside_yade` reads, and back: which of YADE's laws stands for which of geodem's.

A task has numbers (law "frictional", "moments" or "jointed", steps, frames, time step, damping, gravity) and arrays:
spheres, a table of materials, walls, bonds. YADE's stiffness of a contact is the harmonic mean of E r of its two
sides, and of E nu r in shear; its walls have the radius of the sphere that touches them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly
from geodem.laws import BOND_LAWS, CONTACT_LAWS

from ..posed import Memory, Posed, State, Trajectory, about_z, sorted_pairs, three
from .answer import checked
from .planes import plane_of
from .program import BackendError, refuse

Floats = NDArray[np.float64]
Arrays = dict[str, Any]

FORMAT = 2
"""Of the files that YADE leaves; the same number stands in `inside_yade`."""

RIGID = 1e30  # [Pa]
UNBREAKABLE = 1e30  # [Pa]

LAWS = {
    "frictional": "Law2_ScGeom_FrictPhys_CundallStrack",
    "moments": "Law2_ScGeom6D_CohFrictPhys_CohesionMoment with moments in total form; "
    "normal force from the overlap of the surfaces",
    "jointed": "Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM; contacts that are born later count their overlap "
    "from that at birth",
}
BONDS = {None: "frictional", "cohesive_moments": "moments", "jointed_cohesive": "jointed"}
CONVENTIONS = {"yade": True, "yade-plain": False}
"""Convention of geodem to YADE's avoidGranularRatcheting."""


def task_of(posed: Posed) -> tuple[dict[str, Any], Arrays]:
    """Numbers and arrays of a posed scene. Raises BackendError for what YADE cannot express."""
    a = posed.assembly
    if posed.convention not in CONVENTIONS:
        raise refuse("YADE", f"it does not step in the convention {posed.convention!r}")
    if posed.memory is not None:
        raise refuse("YADE", "the forces that its contacts remember cannot be handed to it here")
    if a.anchors is not None:
        raise refuse("YADE", "it has no springs to points in space")
    if getattr(a, "cell", None) is not None:
        raise refuse("YADE", "periodic cells are not translated")
    if a.bond_law not in BONDS:
        raise refuse("YADE", f"it has no bond law {a.bond_law!r}")
    law = BONDS[a.bond_law]
    numbers = {
        "law": law,
        "steps": posed.steps,
        # the first step sorts all bodies anew, as other codes do before their steps
        "warm_up": min(1, posed.steps - 1),
        "frames": _with_start(posed, posed.frames),
        "pairs_at": _with_start(posed, posed.frames if posed.pairs_at is None else posed.pairs_at),
        "time_step": float(posed.time_step),
        "damping": float(posed.local_damping),
        "gravity": three(a.gravity).tolist(),
        "avoid_ratcheting": CONVENTIONS[posed.convention],
    }
    held = np.zeros((a.particles, 6), dtype=bool)
    held[:, : a.dimension] = a.held[:, : a.dimension]
    held[:, 6 - a.rotations :] = a.held[:, a.dimension :]
    if a.dimension == 2:
        held[:, 2:5] = True
    material, table = _materials(a, law)
    arrays = {
        "positions": three(a.positions), "velocities": three(a.velocities), "spins": about_z(a.spins),
        "radii": a.radii, "mass": a.mass, "inertia": a.inertia, "held": held, "material": material,
        "group": a.material,
        "applied": np.hstack([three(a.applied[:, : a.dimension]), about_z(a.applied[:, a.dimension :])]),
        "bonds": a.bonds.astype(np.int64).reshape(-1, 2), "bond_factor": a.bond_scale,
    }  # fmt: skip
    walls = _walls(a, table)
    return numbers, arrays | walls | {f"material_{name}": values for name, values in table.items()}


def _with_start(posed: Posed, steps: Sequence[int]) -> list[int]:
    """Steps, and the one before the first frame where its state is asked for."""
    return [*([posed.first - 1] if posed.first > 1 else []), *steps]


def _materials(a: Assembly, law: str) -> tuple[NDArray[np.int64], Arrays]:
    """Row of every sphere in the table of materials, and the table."""
    contact = CONTACT_LAWS[a.contact_law]
    count = len(a.material_names)
    own = [contact.PARAMETERS(*a.pair_parameters(k, k)) for k in range(count)]
    _refuse_overrides(contact, own, a.contact_table, "contacts")
    if a.contact_law == "elastic_frictional":
        material = a.material.astype(np.int64)
        young, ratio = [p.young_modulus for p in own], [p.stiffness_ratio for p in own]
        friction = [p.friction_coefficient for p in own]
    elif a.contact_law == "linear_frictional":
        # E r = kn makes the harmonic means those of kn: every radius has a material of its own
        if any(getattr(p, name) for p in own for name in ("normal_viscosity", "shear_viscosity")):
            raise refuse("YADE", "its contacts have no dashpots")
        kinds, row = np.unique(np.column_stack([a.material, a.radii]), axis=0, return_inverse=True)
        material = row.ravel().astype(np.int64)
        of_kind = [own[int(kind)] for kind in kinds[:, 0]]
        young = [p.normal_stiffness / r for p, r in zip(of_kind, kinds[:, 1], strict=True)]
        ratio = [p.shear_stiffness / p.normal_stiffness for p in of_kind]
        friction = [p.friction_coefficient for p in of_kind]
        if len({p.shear_stiffness / p.normal_stiffness for p in own}) > 1:
            raise refuse(
                "YADE", "only one ratio of shear to normal stiffness makes both harmonic means the same"
            )
        if law != "frictional":
            raise refuse("YADE", "its bonds have the stiffness of contacts of the law elastic_frictional")
    else:
        raise refuse("YADE", f"it has no contact law {a.contact_law!r}")
    table = {
        "young": np.array(young),
        "poisson": np.array(ratio),
        "frictionAngle": np.arctan(friction),
        # masses are given to the bodies
        "density": np.full(len(young), 1000.0),
    }
    strengths = ("tension", "cohesion", "bend", "twist")
    table |= {name: np.zeros(len(young)) for name in strengths}
    if law != "frictional":
        table |= _bonds(a, law, table)
    return material, table


def _bonds(a: Assembly, law: str, table: Arrays) -> Arrays:
    """Strengths of the materials' bonds, which are those of the contacts with something added."""
    bond = BOND_LAWS[str(a.bond_law)]
    count = len(a.material_names)
    rows = [bond.PARAMETERS(*a.bond_table[k * count + k]) for k in range(count)]
    if any(math.isnan(rows[k][0]) for k in np.unique(a.material[a.bonds])):
        raise refuse("YADE", "bonds between two materials that have none of their own")
    _refuse_overrides(bond, rows, a.bond_table, "bonds")
    for k in range(count):
        for name, column in (("young_modulus", "young"), ("stiffness_ratio", "poisson")):
            value = getattr(rows[k], name)
            if not math.isnan(value) and value != table[column][k]:
                raise refuse("YADE", f"its bonds have the {name} of its contacts")
        value = rows[k].friction_coefficient
        if not math.isnan(value) and math.atan(value) != table["frictionAngle"][k]:
            raise refuse("YADE", "its bonds have the friction of its contacts")
    if law == "moments":
        names = {
            "tension": "normal_cohesion",
            "cohesion": "shear_cohesion",
            "bend": "bending_factor",
            "twist": "twisting_factor",
        }
    else:
        names = {"tension": "tensile_strength", "cohesion": "cohesion"}
    return {
        column: np.minimum(np.nan_to_num([getattr(row, name) for row in rows], nan=0.0), UNBREAKABLE)
        for column, name in names.items()
    }


def _refuse_overrides(law: Any, own: list[Any], table: Floats, what: str) -> None:
    """YADE knows materials, not pairs of them."""
    count = len(own)
    for i in range(count):
        for j in range(i + 1, count):
            expected = np.array(law.combine(own[i], own[j]), dtype=float)
            if not np.array_equal(expected, table[i * count + j], equal_nan=True):
                raise refuse(
                    "YADE", f"{what} between two materials follow from the materials; they cannot be set"
                )


def _walls(a: Assembly, table: Arrays) -> Arrays:
    """Walls as YADE's, each for one material of the spheres; rows of their materials are added to the table."""
    axis, sense, place, velocity, material, group, owner = [], [], [], [], [], [], []
    for number, wall in enumerate(a.walls):
        planes = plane_of(wall.name, wall, "YADE")
        for kind, name in enumerate(a.material_names):
            row = _wall_material(a, wall.contact[name], kind, table)
            for one in planes:
                axis.append(one[0])
                sense.append(one[1])
                place.append(one[2])
                velocity.append(three(wall.velocity))
                material.append(row)
                group.append(kind)
                owner.append(number)
    return {
        "wall_axis": np.array(axis, dtype=np.int64), "wall_sense": np.array(sense, dtype=np.int64),
        "wall_place": np.array(place), "wall_velocity": np.array(velocity).reshape(-1, 3),
        "wall_material": np.array(material, dtype=np.int64), "wall_group": np.array(group, dtype=np.int64),
        "wall_owner": np.array(owner, dtype=np.int64),
    }  # fmt: skip


def _wall_material(a: Assembly, contact: Any, kind: int, table: Arrays) -> int:
    """Row of a wall's material against one material of the spheres."""
    own = CONTACT_LAWS[a.contact_law].PARAMETERS(*a.pair_parameters(kind, kind))
    if a.contact_law == "linear_frictional":
        if (contact.normal_stiffness, contact.shear_stiffness) != (
            2.0 * own.normal_stiffness,
            2.0 * own.shear_stiffness,
        ):
            raise refuse("YADE", "a wall whose contacts are not twice as stiff as those of the particles")
        young, ratio = RIGID, own.shear_stiffness / own.normal_stiffness
    else:
        if (contact.young_modulus, contact.stiffness_ratio) != (own.young_modulus, own.stiffness_ratio):
            raise refuse("YADE", "a wall changes only its own side of a contact")
        young, ratio = contact.other_young_modulus, contact.other_stiffness_ratio
    new = {
        "young": young,
        "poisson": ratio,
        # YADE takes the smaller of the two angles
        "frictionAngle": math.atan(contact.friction_coefficient),
        "density": 1000.0,
    }
    if contact.friction_coefficient > own.friction_coefficient:
        raise refuse("YADE", "a wall rougher than the particles: it takes the smaller friction of the two")
    for name, values in table.items():
        table[name] = np.append(values, new.get(name, 0.0))
    return len(table["young"]) - 1


def trajectory_of(posed: Posed, arrays: Arrays, found: Arrays, law: str, printed: str) -> Trajectory:
    """What YADE left of a task. Raises BackendError where it is not all there."""
    a = posed.assembly
    steps = np.array(_with_start(posed, posed.frames))
    n, walls = a.particles, len(arrays["wall_axis"])
    shapes = {
        "steps": (len(steps),), "positions": (len(steps), n, 3), "velocities": (len(steps), n, 3),
        "spins": (len(steps), n, 3), "forces": (len(steps), n, 3), "torques": (len(steps), n, 3),
        "orientations": (len(steps), n, 4),
    }  # fmt: skip
    if walls:
        shapes["wall_forces"] = (len(steps), walls, 3)
    for name, width in (("pairs", 12), ("broken", 2)):
        # of these nobody knows how many there will be
        shapes[name] = (len(found.get(name, ())), width)
    checked("YADE", found, shapes, printed)
    if not np.array_equal(found["steps"], steps):
        raise BackendError(f"YADE gave frames of other steps than those asked for: {found['steps'][:5]}")
    before = len(steps) - len(posed.frames)
    on_walls = np.zeros((len(steps), len(a.walls), 3))
    for k, owner in enumerate(arrays["wall_owner"]):
        on_walls[:, owner] += found["wall_forces"][:, k]
    rows = found["pairs"]
    start = None
    if before:
        own = rows[rows[:, 0] == 0]
        pairs = sorted_pairs(own[:, 0], own[:, 1:3], own[:, 3:6], own[:, 6:9], own[:, 9:12])
        start = State(
            found["positions"][0], found["velocities"][0], found["spins"][0], Memory(pairs.pairs, pairs.shear)
        )
        rows = rows[rows[:, 0] > 0]
    return Trajectory(
        code="yade",
        version=str(found["version"]),
        law=LAWS[law],
        steps=steps[before:],
        positions=found["positions"][before:],
        velocities=found["velocities"][before:],
        spins=found["spins"][before:],
        # gravity is an acceleration there
        forces=found["forces"][before:] + a.mass[:, None] * three(a.gravity),
        torques=found["torques"][before:],
        orientations=found["orientations"][before:],
        pair_forces=sorted_pairs(
            rows[:, 0] - before, rows[:, 1:3], rows[:, 3:6], rows[:, 6:9], rows[:, 9:12]
        ),
        wall_forces=on_walls[before:],
        broken=tuple(
            sorted(
                ((int(a.bonds[bond][0]), int(a.bonds[bond][1]), int(step)) for bond, step in found["broken"]),
                key=lambda one: (one[2], one[0], one[1]),
            )
        ),
        start=start,
        # of all steps but the first
        loop_seconds=float(found.get("seconds", math.nan)) * posed.steps / max(posed.steps - 1, 1),
    )
