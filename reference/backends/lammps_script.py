"""From an assembly to a script of LAMMPS, and back: bonded spheres by bpm/rotational, frictional ones by granular.

Stiffnesses and strengths are the same numbers; what differs is in `BONDED` and `FRICTIONAL`, so a comparison with
LAMMPS is one within a share of a per cent, not one of rounding.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geodem.assembly import Assembly
from geodem.laws import BOND_LAWS, CONTACT_LAWS

from ..posed import Posed, Trajectory, three
from .granular_text import SKIN, read_local
from .planes import plane_of
from .program import refuse
from .verlet import columns_of, held_lines, read_verlet, refuse_half_held

UNBREAKABLE = 1e30  # [N], [N m]

FRICTIONAL = (
    "granular hooke with linear_history, without damping; lever arms are whole radii, not those to the middle of the "
    "overlap; velocity Verlet"
)
BONDED = "bpm/rotational without damping, bonded pairs without contact; " + FRICTIONAL
FORCES, FORCES_TOLD = " fx fy fz", " f_told[1] f_told[2] f_told[3]"
BOND_NUMBERS = (
    "normal_stiffness", "shear_stiffness", "twisting_stiffness", "bending_stiffness",
    "tensile_strength", "shear_strength", "twisting_strength", "bending_strength",
)  # fmt: skip


def refuse_what_it_lacks(posed: Posed) -> None:
    """Raise BackendError for what LAMMPS cannot express, or what is not translated."""
    a = posed.assembly
    reasons = {
        "its discs are not translated": a.dimension != 3,
        f"it does not step in the convention {posed.convention!r}": posed.convention != "geodem",
        "the springs that its contacts remember cannot be handed to it": posed.memory is not None,
        "it has no local damping": posed.local_damping != 0.0,
        f"it has no bond law {a.bond_law!r}": a.bond_law not in (None, "rotational_bond"),
        f"it has no contact law {a.contact_law!r}": a.contact_law != "linear_frictional",
        "it has no springs to points in space": a.anchors is not None,
        "periodic cells are not translated": getattr(a, "cell", None) is not None,
        "it has no constant torques": bool(a.applied[:, a.dimension :].any()),
        "steps that are recorded must be multiples of how often": posed.every > 1
        and posed.first % posed.every != 0,
        "a state before the first frame is not told": posed.first > 1 and posed.every == 1,
        "its contacts have no dashpots here": _viscous(a.contact_law, CONTACT_LAWS, a.contact_table),
        "its bonds have no dashpots here": a.bond_law is not None
        and _viscous(a.bond_law, BOND_LAWS, a.bond_table),
    }
    for reason, holds in reasons.items():
        if holds:
            raise refuse("LAMMPS", reason)
    refuse_half_held(a, "LAMMPS")


def _viscous(name: str, laws: Any, table: Any) -> bool:
    fields = laws[name].PARAMETERS._fields if name in laws else ()
    columns = [k for k, field in enumerate(fields) if field.endswith("_viscosity")]
    return bool(np.nan_to_num(table[:, columns]).any()) if columns else False


def bond_kinds(a: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of every kind of bond, (k, 8), and the kind of every bond, from 1."""
    if a.bond_law is None:
        return np.zeros((0, len(BOND_NUMBERS))), np.zeros(0, dtype=np.int64)
    fields = BOND_LAWS[a.bond_law].PARAMETERS._fields
    rows = a.material[a.bonds[:, 0]].astype(int) * len(a.material_names) + a.material[a.bonds[:, 1]]
    numbers = np.array(a.bond_table[rows][:, [fields.index(name) for name in BOND_NUMBERS]])
    numbers[:, 4:] = np.minimum(numbers[:, 4:] * a.bond_scale[:, None], UNBREAKABLE)
    kinds, kind = np.unique(numbers, axis=0, return_inverse=True)
    return kinds, kind.ravel().astype(np.int64) + 1


def script_of(posed: Posed) -> str:
    """The script; particles are in particles.data, frames go to frames.txt, broken bonds to broken.txt."""
    a = posed.assembly
    bonded, count = a.bond_law is not None, len(a.material_names)
    size = math.sqrt(float((a.gravity**2).sum()))
    lines = [
        "units si",
        f"atom_style {'bpm/sphere' if bonded else 'sphere'}",
        "atom_modify map array",
        "boundary f f f",
        f"newton {'on off' if bonded else 'off'}",
        "comm_modify mode single vel yes",
        # bonded pairs have no contact
        "special_bonds lj 0 1 1 coul 1 1 1" if bonded else "",
        "read_data particles.data",
        f"neighbor {SKIN * float(a.radii.max())!r} bin",
        "neigh_modify every 1 delay 0 check yes",
        "pair_style granular",
    ]
    for i in range(count):
        for j in range(i, count):
            lines.append(f"pair_coeff {i + 1} {j + 1} {_contact(a.pair_parameters(i, j))}")
    if bonded:
        # by default forces fade before a bond breaks
        lines.append("bond_style bpm/rotational store/local broken 1 time id1 id2 smooth no")
        for k, row in enumerate(bond_kinds(a)[0]):
            lines.append(f"bond_coeff {k + 1} " + " ".join(repr(float(value)) for value in row) + " 0.0" * 4)
        lines.append("dump broken all local 1 broken.txt f_broken[1] f_broken[2] f_broken[3]")
        lines.append('dump_modify broken format line "%g %g %g"')
    lines.append(f"timestep {float(posed.time_step)!r}")
    if size > 0.0:
        direction = " ".join(repr(float(c)) for c in three(a.gravity) / size)
        lines.append(f"fix fall all gravity {size!r} vector {direction}")
    walls = wall_names(a)
    for k, wall in enumerate(a.walls):
        if np.any(wall.velocity):
            raise refuse("LAMMPS", f"wall {wall.name!r} moves; its planes are fixed")
        numbers = {tuple(wall.contact[name]) for name in a.material_names}
        if len(numbers) > 1:
            raise refuse("LAMMPS", f"wall {wall.name!r} must be the same to all materials")
        for one, (axis, sense, place) in enumerate(plane_of(wall.name, wall, "LAMMPS")):
            ends = f"{place!r} NULL" if sense > 0 else f"NULL {place!r}"
            law = _contact(np.array(wall.contact[a.material_names[0]], dtype=float))
            lines.append(f"fix wall{k}x{one} all wall/gran granular {law} {'xyz'[axis]}plane {ends} contacts")
    lines += held_lines(a, "LAMMPS")
    held = next((k for k, line in enumerate(lines) if line.startswith("fix hold")), len(lines))
    lines.insert(held, "fix told all store/force")
    lines += [f"fix move all {'nve/bpm/sphere' if bonded else 'nve/sphere'}"]
    columns = columns_of(walls)
    # forces of a wall stand in the columns 2 to 4 of its array
    told = columns
    for name in walls:
        for c in (3, 2, 1):
            told = told.replace(f"{name}[{c}]", f"{name}[{c + 1}]")
    # as they are before those of held freedoms are set to zero
    told = told.replace(FORCES, FORCES_TOLD)
    lines += [
        "thermo 1000000",
        "thermo_modify lost error",
        f"dump frames all custom {posed.every} frames.txt {told}",
        'dump_modify frames sort id format line "%d' + " %.17g" * (len(columns.split()) - 1) + '"',
        f"run {posed.steps}",
    ]
    return "\n".join(line for line in lines if line) + "\n"


def _contact(row: Any) -> str:
    normal, shear, friction = (float(value) for value in row[:3])
    return f"hooke {normal!r} 0.0 tangential linear_history {shear!r} 0.0 {friction!r} damping mass_velocity"


def wall_names(a: Assembly) -> list[str]:
    """Arrays that hold what the planes do to the particles."""
    return [f"f_wall{k}x{one}" for k, wall in enumerate(a.walls) for one in range(len(wall.planes))]


def trajectory_of(posed: Posed, folder: Path, printed: str, version: str) -> Trajectory:
    """What LAMMPS left. Raises BackendError where it is not all there."""
    a = posed.assembly
    names = wall_names(a)
    path = folder / "frames.txt"
    if path.exists():
        text = path.read_text().replace(FORCES_TOLD, FORCES)
        for name in names:
            for c in (1, 2, 3):
                text = text.replace(f"{name}[{c + 1}]", f"{name}[{c}]")
        path.write_text(text)
    read = read_verlet(posed, folder, printed, names)
    broken: list[tuple[int, int, int]] = []
    if a.bond_law is not None:
        local = read_local(folder / "broken.txt", 3, range(posed.steps + 1), printed)
        for step, rows in local.items():
            for _, first, second in rows:
                low, high = int(min(first, second)) - 1, int(max(first, second)) - 1
                # it breaks with the forces that lead to the next frame
                after = [frame for frame in posed.frames if frame >= step + read.lag]
                broken.append((low, high, after[0] if after else step + read.lag))
    return replace(
        read.trajectory, code="lammps", version=version, law=FRICTIONAL if a.bond_law is None else BONDED,
        broken=tuple(sorted(set(broken), key=lambda one: (one[2], one[0], one[1]))),
    )  # fmt: skip
