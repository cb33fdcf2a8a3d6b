"""From an assembly to a script of LIGGGHTS, and back: which of its models stands for which of geodem's laws.

Spheres of a material are a type; every wall adds a type of its own. LIGGGHTS begins with the velocities at the time
of the positions and ends with such; they are brought back by half a step with the forces it tells.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geodem.assembly import Assembly
from geodem.laws import CONTACT_LAWS

from ..posed import Memory, PairForces, Posed, State, Trajectory, sorted_pairs, three
from .granular_text import SKIN, read_local
from .planes import plane_of
from .program import refuse
from .verlet import Read, columns_of, held_lines, read_verlet, refuse_half_held

MODELS = {"hooke_stiffness": "hooke/stiffness", "hooke": "hooke", "hertz_history": "hertz"}
"""Contact law of geodem to LIGGGHTS's model; all with tangential history."""

PAIRS = 12
"""Columns of a dump of pairs: two numbers, a sign of periodicity, normal force, tangential force, spring."""
RIGID = 1e30  # [Pa]


def refuse_what_it_lacks(posed: Posed) -> None:
    """Raise BackendError for what LIGGGHTS cannot express."""
    a = posed.assembly
    reasons = {
        f"it does not step in the convention {posed.convention!r}": posed.convention != "liggghts",
        "the springs that its contacts remember cannot be handed to it": posed.memory is not None,
        "it has no local damping": posed.local_damping != 0.0,
        f"it has no bonds, such as {a.bond_law!r}": a.bond_law is not None,
        f"it has no contact law {a.contact_law!r}": a.contact_law not in MODELS,
        "it has no springs to points in space": a.anchors is not None,
        "periodic cells are not translated": getattr(a, "cell", None) is not None,
        "it has no constant torques": bool(a.applied[:, a.dimension :].any()),
        "steps that are recorded must be multiples of how often": posed.every > 1
        and posed.first % posed.every != 0,
    }
    for reason, holds in reasons.items():
        if holds:
            raise refuse("LIGGGHTS", reason)
    refuse_half_held(a, "LIGGGHTS")


def _pairwise(a: Assembly, field: str) -> str:
    """A parameter by pair of types, walls after the materials."""
    law = CONTACT_LAWS[a.contact_law]
    column = law.PARAMETERS._fields.index(field)
    count, walls = len(a.material_names), len(a.walls)
    table = np.zeros((count + walls, count + walls))
    table[:count, :count] = a.contact_table[:, column].reshape(count, count)
    for k, wall in enumerate(a.walls):
        for i, name in enumerate(a.material_names):
            table[i, count + k] = table[count + k, i] = getattr(wall.contact[name], field)
        # two walls never touch
        table[count + k, count:] = table[count:, count + k] = table[0, 0]
    return f"peratomtypepair {len(table)} " + " ".join(repr(float(value)) for value in table.ravel())


def _moduli(a: Assembly) -> list[str]:
    """Young's modulus and Poisson's ratio by type: those of pairs must follow from them."""
    law = CONTACT_LAWS[a.contact_law]
    count = len(a.material_names)
    own = [law.PARAMETERS(*a.pair_parameters(k, k)) for k in range(count)]
    for i in range(count):
        for j in range(i + 1, count):
            made, given = law.combine(own[i], own[j])._asdict(), a.pair_parameters(i, j)
            for name, value in zip(law.PARAMETERS._fields, given, strict=True):
                if name in ("young_modulus", "poisson_ratio") and made[name] != value:
                    raise refuse(
                        "LIGGGHTS", f"the {name} between two materials follows from theirs; it cannot be set"
                    )
    young, ratio = [p.young_modulus for p in own], [p.poisson_ratio for p in own]
    for wall in a.walls:
        sides = {
            _wall_side(wall, wall.contact[name], one) for name, one in zip(a.material_names, own, strict=True)
        }
        rigid = {side for side in sides if side[0] == RIGID}
        if len(sides) > 1 and sides != rigid:
            raise refuse("LIGGGHTS", f"wall {wall.name!r} must have one modulus for all particles")
        one_side = min(sides)
        young.append(one_side[0])
        ratio.append(one_side[1])
    return [
        "fix young all property/global youngsModulus peratomtype " + " ".join(map(repr, map(float, young))),
        "fix ratio all property/global poissonsRatio peratomtype " + " ".join(map(repr, map(float, ratio))),
    ]


def _wall_side(wall: Any, contact: Any, own: Any) -> tuple[float, float]:
    """Modulus and ratio of a wall against one material: 2 (1 - nu^2)/E of the contact is the sum of both sides."""
    if contact.poisson_ratio != own.poisson_ratio or contact.young_modulus > 2.0 * own.young_modulus:
        raise refuse("LIGGGHTS", f"wall {wall.name!r} is stiffer than a rigid one, or of another ratio")
    if contact.young_modulus == 2.0 * own.young_modulus:
        return RIGID, own.poisson_ratio
    if contact.young_modulus == own.young_modulus:
        return own.young_modulus, own.poisson_ratio
    return 1.0 / (2.0 / contact.young_modulus - 1.0 / own.young_modulus), own.poisson_ratio


def _properties(a: Assembly) -> list[str]:
    """Lines that give the model its numbers."""
    lines = [f"fix mu all property/global coefficientFriction {_pairwise(a, 'friction_coefficient')}"]
    if a.contact_law == "hooke_stiffness":
        names = {
            "kn": "normal_stiffness", "kt": "shear_stiffness", "gamman": "normal_damping", "gammat": "shear_damping",
        }  # fmt: skip
        return lines + [
            f"fix {word} all property/global {word} {_pairwise(a, field)}" for word, field in names.items()
        ]
    lines += _moduli(a)
    lines.append(f"fix bounce all property/global coefficientRestitution {_pairwise(a, 'restitution')}")
    if a.contact_law == "hooke":
        column = CONTACT_LAWS["hooke"].PARAMETERS._fields.index("characteristic_velocity")
        speeds = set(a.contact_table[:, column].tolist())
        speeds |= {contact.characteristic_velocity for w in a.walls for contact in w.contact.values()}
        if len(speeds) > 1:
            raise refuse("LIGGGHTS", "it has one characteristic velocity for all")
        lines.append(f"fix pace all property/global characteristicVelocity scalar {speeds.pop()!r}")
    return lines


def script_of(posed: Posed) -> str:
    """The script; particles are in particles.data, frames go to frames.txt and pairs.txt."""
    a = posed.assembly
    model = f"gran model {MODELS[a.contact_law]} tangential history"
    size = float(np.sqrt((a.gravity**2).sum()))
    count = len(a.material_names)
    lines = [
        "atom_style granular",
        "atom_modify map array",
        "dimension 2" if a.dimension == 2 else "",
        f"boundary f f {'p' if a.dimension == 2 else 'f'}",
        "newton off",
        "communicate single vel yes",
        "units si",
        # its limits on moduli are advice
        "hard_particles yes",
        "soft_particles yes",
        "read_data particles.data",
        f"neighbor {SKIN * float(a.radii.max())!r} bin",
        # the factor makes it drop the spring of a pair that has parted
        "neigh_modify delay 0 contact_distance_factor 1.1",
        *_properties(a),
        f"pair_style {model}",
        "pair_coeff * *",
        f"timestep {posed.time_step!r}",
    ]
    if size > 0.0:
        direction = " ".join(repr(float(c)) for c in three(a.gravity) / size)
        lines.append(f"fix fall all gravity {size!r} vector {direction}")
    for k, wall in enumerate(a.walls):
        if np.any(wall.velocity):
            raise refuse("LIGGGHTS", f"wall {wall.name!r} moves; its planes are fixed")
        for one, (axis, _, place) in enumerate(plane_of(wall.name, wall, "LIGGGHTS")):
            lines.append(
                f"fix wall{k}x{one} all wall/{model} primitive type {count + k + 1} "
                f"{'xyz'[axis]}plane {place!r} store_force yes"
            )
    lines += [
        *held_lines(a, "LIGGGHTS"),
        "fix move all nve/sphere",
        "thermo 1000000",
        "thermo_modify lost error",
    ]
    columns = columns_of([f"f_force_{name}" for name in _wall_names(a)])
    if steps_of_pairs(posed):
        lines.append("compute pairs all pair/gran/local id force_normal force_tangential history")
    if posed.first > 1 and posed.every == 1:
        lines.append(f"run {posed.first - 1}")
    lines += [
        f"dump frames all custom {posed.every} frames.txt {columns}",
        'dump_modify frames sort id format "%d' + " %.17g" * (len(columns.split()) - 1) + '"',
    ]
    if steps_of_pairs(posed):
        lines += [
            f"dump pairs all local {_every_pairs(posed)} pairs.txt "
            + " ".join(f"c_pairs[{c + 1}]" for c in range(PAIRS)),
            'dump_modify pairs format "%g %g %g' + " %.17g" * 9 + '"',
        ]
    lines.append(f"run {posed.steps - (posed.first - 1 if posed.every == 1 else 0)}")
    return "\n".join(line for line in lines if line) + "\n"


def _wall_names(a: Assembly) -> list[str]:
    return [f"wall{k}x{one}" for k, wall in enumerate(a.walls) for one in range(len(wall.planes))]


def steps_of_pairs(posed: Posed) -> list[int]:
    """Steps of which pairs are read: one before those of the frames, where all are recorded, and that of the start."""
    wanted = posed.frames if posed.pairs_at is None else posed.pairs_at
    back = 1 if posed.every == 1 else 0
    return sorted(
        {*(step - back for step in wanted), *([posed.first - 1] if posed.first > 1 and back else [])}
    )


def _every_pairs(posed: Posed) -> int:
    """How often pairs are written: seldom, where only those of the start are asked for."""
    start = posed.first - 1
    return start if steps_of_pairs(posed) == [start] and 2 * start > posed.steps else posed.every


def trajectory_of(posed: Posed, folder: Path, printed: str, version: str) -> Trajectory:
    """What LIGGGHTS left. Raises BackendError where it is not all there."""
    read = read_verlet(posed, folder, printed, [f"f_force_{name}" for name in _wall_names(posed.assembly)])
    pairs = _pairs(posed, folder, printed, read)
    start = None
    if posed.first > 1 and read.lag and pairs is not None:
        # its run begins anew there, with the velocities of that moment
        own, at = pairs.of_frame(0), read.table[0]
        start = State(at[:, 0:3], at[:, 3:6], at[:, 6:9], Memory(own.pairs, own.shear, own.spring))
    law = f"gran model {MODELS[posed.assembly.contact_law]} tangential history"
    return replace(read.trajectory, code="liggghts", version=version, law=law, pair_forces=pairs, start=start)


def _pairs(posed: Posed, folder: Path, printed: str, read: Read) -> PairForces | None:
    """Forces and springs of the pairs.

    Normal forces are those that LIGGGHTS makes for output, with its dampers at the velocities of that moment, half a
    step later than when they acted. Shear forces are the springs' alone but for hertz, whose are made likewise.
    """
    steps = steps_of_pairs(posed)
    if not steps:
        return None
    a = posed.assembly
    found = read_local(folder / "pairs.txt", PAIRS, steps, printed)
    lag, positions = read.lag, read.table[:, :, 0:3]
    first = posed.first - lag
    frame = np.concatenate(
        [np.full(len(found[s]), (s + lag - posed.first) // posed.every) for s in steps]
    ).astype(np.int64)
    rows = np.concatenate([found[s] for s in steps])
    if not len(rows):
        return sorted_pairs(frame, np.zeros((0, 2), dtype=np.int64), *[np.zeros((0, 3))] * 4)
    pairs = rows[:, :2].astype(np.int64) - 1
    places = np.concatenate([np.full(len(found[s]), (s - first) // posed.every) for s in steps]).astype(
        np.int64
    )
    apart = positions[places, pairs[:, 1]] - positions[places, pairs[:, 0]]
    distance = np.sqrt((apart**2).sum(axis=1))[:, None]
    normal, shear, spring = rows[:, 3:6], rows[:, 6:9], rows[:, 9:12]
    if a.contact_law != "hertz_history":
        shear = -_shear_stiffness(a, pairs)[:, None] * spring
    touching = (distance[:, 0] < a.radii[pairs].sum(axis=1)).nonzero()[0]
    return sorted_pairs(
        frame[touching],
        pairs[touching],
        normal[touching],
        shear[touching],
        (apart / distance)[touching],
        spring[touching],
    )


def _shear_stiffness(a: Assembly, pairs: Any) -> Any:
    """Stiffness (k,) [N/m] across the contacts of pairs: the one given, or hooke's own, as documented."""
    fields = CONTACT_LAWS[a.contact_law].PARAMETERS._fields
    count = len(a.material_names)
    first, second = a.material[pairs[:, 0]].astype(int), a.material[pairs[:, 1]].astype(int)
    rows = a.contact_table[first * count + second]
    if a.contact_law == "hooke_stiffness":
        return rows[:, fields.index("shear_stiffness")]
    own = a.contact_table[np.arange(count) * (count + 1)]
    softness = (1.0 - own[:, fields.index("poisson_ratio")] ** 2) / own[:, fields.index("young_modulus")]
    young = 1.0 / (softness[first] + softness[second])
    radius, mass = a.radii[pairs], a.mass[pairs]
    root = np.sqrt(radius.prod(axis=1) / radius.sum(axis=1))
    reduced = mass.prod(axis=1) / mass.sum(axis=1)
    pace = rows[:, fields.index("characteristic_velocity")]
    return 16 / 15 * root * young * (15.0 * reduced * pace**2 / (16.0 * root * young)) ** 0.2
