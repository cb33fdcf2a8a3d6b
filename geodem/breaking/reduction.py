"""An assembly, and a simulation that is under way, less some of their particles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..assembly import Assembly, Joints
from ..boundaries.cell import PeriodicCell
from ..boundaries.wall_pairs import WallPairs
from ..boundaries.wall_table import wall_table
from ..neighbors import PairList
from ..particle_layout import RowArrays, anchor_table, chunk_size, row_arrays
from ..particle_simulation import SERIAL_LIMIT, ParticleSimulation
from ..particle_state import NUMBERS

Integers = NDArray[np.int64]


def without(assembly: Assembly, left: NDArray[np.bool_], bonds: Integers) -> Assembly:
    """An assembly of the particles (n,) that are left and these bonds (b,); materials and walls stay."""
    number = np.cumsum(left) - 1
    own = np.flatnonzero(left)
    a = assembly
    arrays = {
        name: getattr(a, name)[own].copy()
        for name in (
            "positions",
            "radii",
            "mass",
            "inertia",
            "velocities",
            "spins",
            "material",
            "held",
            "applied",
        )
    }
    anchors = a.anchors
    if anchors is not None:
        kept = left[anchors.particle]
        anchors = replace(
            anchors, particle=number[anchors.particle[kept]].astype(np.int32), point=anchors.point[kept],
            stiffness=anchors.stiffness[kept], length=anchors.length[kept],
        )  # fmt: skip
    return replace(
        a, **arrays, bonds=number[a.bonds[bonds]].astype(np.int32).reshape(-1, 2), bond_scale=a.bond_scale[bonds],
        anchors=anchors, joints=None if a.joints is None else _joints(a.joints, left, number),
    )  # fmt: skip


def _joints(joints: Joints, left: NDArray[np.bool_], number: Integers) -> Joints:
    crossed = left[joints.pairs].all(axis=1)
    beside = left[joints.side_particle]
    return replace(
        joints, pairs=number[joints.pairs[crossed]].astype(np.int32).reshape(-1, 2), face=joints.face[crossed],
        area=joints.area[crossed], side_particle=number[joints.side_particle[beside]].astype(np.int32),
        side_joint=joints.side_joint[beside], side_face=joints.side_face[beside],
    )  # fmt: skip


def reduced(
    s: ParticleSimulation, left: NDArray[np.bool_], new_of_old: Integers, bonds: Integers, *, applied: bool
) -> ParticleSimulation:
    """A simulation of the particles (n,) that are left, before its forces are known anew.

    `new_of_old`: number of every particle then, -1 of those that are gone; `bonds`: those that are left.
    """
    new = ParticleSimulation.__new__(ParticleSimulation)
    for name in (*NUMBERS, "dimension", "columns", "sleep", "features", "layout", "table", "bond_table"):
        setattr(new, name, getattr(s, name))
    for name in ("joint_table", "wall_parameters"):
        setattr(new, name, getattr(s, name).copy())
    new.features = replace(s.features, applied=applied)
    new.stages = list(s.stages)
    new.assembly = without(s.assembly, left, bonds)
    count = new.assembly.particles
    new.parallel = count > SERIAL_LIMIT
    new.chunk = chunk_size(count, not new.parallel)
    new.cell = None if s.cell is None else PeriodicCell(s.cell.periodic, s.cell.state.copy())
    rows = left[s.arrays.ids]
    new.arrays = _row_arrays(s, new.assembly, rows, new_of_old, applied=applied)
    new.rows = np.ascontiguousarray(s.rows[:, rows])
    new.angle = s.angle[rows] if len(s.angle) == len(rows) else s.angle.copy()
    new.force = np.ascontiguousarray(s.force[rows])
    new.anchors = anchor_table(new.assembly)
    new.walls = wall_table(s.assembly.walls, s.dimension)
    new.walls.bodies = s.walls.bodies.copy()
    own = bonds if len(bonds) else np.zeros(1, dtype=np.int64)
    new.record, new.utilisation, new.bond_scale = (
        each[own].copy() if len(bonds) else each[:1] * 0.0 + (1.0 if each.ndim == 1 else 0.0)
        for each in (s.record, s.utilisation, s.bond_scale)
    )
    chunks = -(-count // new.chunk)
    new.sums = np.zeros((chunks, s.sums.shape[1]))
    new.sums[0] = s.sums.sum(axis=0)
    new.wall_sums = np.zeros((chunks, *s.wall_sums.shape[1:]))
    new.asleep = np.zeros(chunks, dtype=np.uint8)
    new.quiet = np.zeros(chunks, dtype=np.int64)
    new._ready()
    new.pairs = _pairs(s, new, rows, bonds)
    new.wall_pairs = _wall_pairs(s, new, rows)
    new.sorted_share = -1.0
    new.search(sort=False)
    return new


def _row_arrays(
    s: ParticleSimulation, assembly: Assembly, rows: NDArray[np.bool_], new_of_old: Integers, *, applied: bool
) -> RowArrays:
    ids = new_of_old[s.arrays.ids[rows]]
    found = row_arrays(assembly, ids, applied=applied)
    for name in ("inverse_mass", "inverse_inertia", "held"):
        setattr(found, name, np.ascontiguousarray(getattr(s.arrays, name)[rows]))
    if s.features.applied:
        found.applied = np.ascontiguousarray(s.arrays.applied[rows])
    return found


def _pairs(
    s: ParticleSimulation, new: ParticleSimulation, rows: NDArray[np.bool_], bonds: Integers
) -> PairList:
    """Listed pairs whose particles are both left, under the numbers that their rows and bonds have now."""
    p = s.pairs
    number = np.cumsum(rows) - 1
    both = rows[p.a] & rows[p.b]
    row = np.zeros(int(rows.sum()) + 1, dtype=np.int64)
    np.cumsum(np.bincount(number[p.listed_under()[both]], minlength=len(row) - 1), out=row[1:])
    found = PairList.allocate(row, chunk=new.chunk, history_width=p.history.shape[1])
    bond = np.zeros(len(s.assembly.bonds) + 1, dtype=np.int32)
    bond[1 + bonds] = 1 + np.arange(len(bonds), dtype=np.int32)
    found.a[:], found.b[:] = number[p.a[both]], number[p.b[both]]
    found.bond[:], found.touching[:] = bond[p.bond[both]], p.touching[both]
    found.history[:] = p.history[both]
    found.far = p.far
    if len(p.image) == len(p.a):
        found.image = p.image[both]
    return found


def _wall_pairs(s: ParticleSimulation, new: ParticleSimulation, rows: NDArray[np.bool_]) -> WallPairs:
    w = s.wall_pairs
    number = np.cumsum(rows) - 1
    own = rows[w.particle]
    row = np.zeros(int(rows.sum()) + 1, dtype=np.int64)
    np.cumsum(np.bincount(number[w.particle[own]], minlength=len(row) - 1), out=row[1:])
    found = WallPairs.allocate(row, chunk=new.chunk, history_width=w.history.shape[1])
    found.particle[:] = number[w.particle[own]]
    for name in ("primitive", "touching", "history", "normal", "geometry", "feature"):
        getattr(found, name)[:] = getattr(w, name)[own]
    return found
