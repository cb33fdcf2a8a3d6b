"""Excavation: particles are taken out of a running simulation, and all the rest goes on as it was.

What is left keeps its places, velocities, bonds, contact history and stresses to the bit. The forces that the removed
particles exerted on it may stay as applied forces, so that nothing moves, and be let go step by step: the staged
relaxation of a face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Assembly, Joints
from ..boundaries.cell import PeriodicCell
from ..boundaries.wall_pairs import WallPairs
from ..boundaries.wall_table import wall_table
from ..errors import InputError
from ..kernels import motion
from ..neighbors import PairList
from ..particle_layout import RowArrays, anchor_table, chunk_size, row_arrays
from ..particle_reading import BrokenBonds
from ..particle_simulation import SERIAL_LIMIT, ParticleSimulation
from ..particle_state import NUMBERS

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

STORED = [motion.TOTAL_ELASTIC, motion.ANCHORED]
"""Sums that hold elastic energy; the others add up work."""


@dataclass(eq=False)
class FaceForces:
    """Forces and torques that removed particles exerted on those that are left.

    Attributes
    ----------
    particles : (k,) int64
        Numbers in the simulation that is left.
    forces : (k, d + s) [N, N m]
    factor : float
        Share of them that is applied now [-].
    """

    particles: Integers
    forces: Floats
    factor: float = 0.0

    @property
    def resultant(self) -> Floats:
        """Sum of the forces (d,) [N] at factor 1."""
        d = 2 if self.forces.shape[1] == 3 else 3
        return np.asarray(self.forces[:, :d].sum(axis=0))

    def set(self, simulation: ParticleSimulation, factor: float) -> None:
        """Apply this share of the forces from now on: 1 as before the removal, 0 fully excavated.

        Raises
        ------
        InputError
            The simulation has no room for applied forces: nothing was kept at the removal.
        """
        s = simulation
        if not np.isfinite(factor):
            raise InputError("factor", "this is no factor", "Give 1 to 0", value=factor)
        if not s.features.applied:
            raise InputError(
                "forces", "this simulation applies none", "Give remove_particles keep_forces=True"
            )
        change = (factor - self.factor) * self.forces
        row = np.empty(len(s.arrays.ids), dtype=np.int64)
        row[s.arrays.ids] = np.arange(len(row))
        s.arrays.applied[row[self.particles]] += change
        # a search for equilibrium reads what is applied here
        s.assembly.applied[self.particles] += change
        if s.features.energy:
            # the next step counts the work of the way that is behind
            motion_now = np.where(s.assembly.held, 0.0, np.hstack([s.velocities, s.spins]))[self.particles]
            s.initial_energy -= float((change * motion_now).sum()) * s.time_step
        self.factor = float(factor)
        s.wake_all()

    def after(self, removal: Removal) -> FaceForces:
        """The same forces, of the particles that a later removal has left."""
        new = removal.new_of_old[self.particles]
        left = new >= 0
        return FaceForces(new[left], self.forces[left], self.factor)


@dataclass(frozen=True, eq=False)
class Removal:
    """What a removal leaves.

    Attributes
    ----------
    simulation : ParticleSimulation
        The one it was made of is not to be run any more.
    particles, bonds : (n,), (b,) int64
        Numbers before, of every particle and bond that is left.
    new_of_old : (n before,) int64
        Number now of every particle, -1 of those that are gone.
    face : FaceForces
        Applied in full, or not at all where they were not to be kept.
    broken : BrokenBonds
        All breaks before, with the numbers of bonds as they were then.
    energy : float
        Kinetic and elastic, that went with the removed particles [J]; nan without an energy account.
    mass : float
        Of the removed [kg] (2D: kg per m).
    """

    simulation: ParticleSimulation
    particles: Integers
    bonds: Integers
    new_of_old: Integers
    face: FaceForces
    broken: BrokenBonds
    energy: float
    mass: float


def remove_particles(
    simulation: ParticleSimulation, which: ArrayLike, *, keep_forces: bool = True
) -> Removal:
    """Take particles out of a simulation.

    Parameters
    ----------
    simulation : ParticleSimulation
        It must not be run afterwards.
    which : (n,) bool or (k,) int
        Particles.
    keep_forces : bool
        Apply the forces that they exerted; the simulation then has room for applied forces. One that was made with
        ``applied=True`` needs no other kernel.

    Raises
    ------
    InputError
        Numbers of no particles; nothing or everything is removed; a search for equilibrium is under way.
    """
    s = simulation
    gone = _mask(which, s.assembly.particles)
    if s.order_kept:
        raise InputError("removal", "a search for equilibrium is under way", "Remove when it has returned")
    # the laws take in what has moved since they were last asked
    s.feel(s.kernel(s.features))
    before = s.forces
    stored = float(s.sums[:, STORED].sum())
    broken = s.broken_bonds()
    left = ~gone
    new_of_old = np.where(left, np.cumsum(left) - 1, -1).astype(np.int64)
    bonds = np.flatnonzero(left[s.assembly.bonds].all(axis=1)) if len(s.assembly.bonds) else _NONE
    face = new_of_old[_neighbours(s, gone)]
    new = _reduced(s, left, new_of_old, bonds, applied=keep_forces or s.features.applied)
    new.feel(new.kernel(new.features))
    energy = float("nan")
    if s.features.energy:
        energy = stored - float(new.sums[:, STORED].sum()) + _kinetic(s, gone, before)
        new.initial_energy -= energy - _last_work(s, gone, before)
    exerted = before[np.flatnonzero(left)[face]] - new.forces[face]
    forces = FaceForces(face, exerted)
    if keep_forces and len(face):
        forces.set(new, 1.0)
        new.feel(new.kernel(new.features))
    particles = np.flatnonzero(left)
    mass = float(s.assembly.mass[gone].sum())
    return Removal(new, particles, bonds, new_of_old, forces, broken, energy, mass)


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


def _reduced(
    s: ParticleSimulation, left: NDArray[np.bool_], new_of_old: Integers, bonds: Integers, *, applied: bool
) -> ParticleSimulation:
    """A simulation of what is left, before its forces are known anew."""
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


def _neighbours(s: ParticleSimulation, gone: NDArray[np.bool_]) -> Integers:
    """Particles that are left and touch, or are bonded to, one that goes; ascending."""
    p, ids = s.pairs, s.arrays.ids
    linked = (p.touching > 0) | (p.bond > 0)
    a, b = ids[p.a[linked]], ids[p.b[linked]]
    across = gone[a] != gone[b]
    ends = np.where(gone[a[across]], b[across], a[across])
    return np.unique(ends).astype(np.int64)


def _kinetic(s: ParticleSimulation, gone: NDArray[np.bool_], forces: Floats) -> float:
    """Kinetic energy [J] of particles as the account has it, m v(n - 1/2).v(n + 1/2)/2."""
    a, d = s.assembly, s.dimension
    inertia = np.column_stack([*[a.mass] * d, *[a.inertia] * a.rotations])
    velocity = np.hstack([s.velocities, s.spins])
    ahead = np.where(a.held, 0.0, forces * s.time_step)
    return 0.5 * float((velocity * (inertia * velocity + ahead))[gone].sum())


def _last_work(s: ParticleSimulation, gone: NDArray[np.bool_], forces: Floats) -> float:
    """Work [J] of weight and applied forces on particles in the last step, less what damping took of it.

    Steps count it one later, and for the removed there is none.
    """
    a, d = s.assembly, s.dimension
    load = np.zeros_like(forces)
    if s.features.applied:
        load[s.arrays.ids] = s.arrays.applied
    load[:, :d] += a.mass[:, None] * a.gravity
    velocity = np.hstack([s.velocities, s.spins])
    inertia = np.column_stack([*[a.mass] * d, *[a.inertia] * a.rotations])
    # half of the last step's damping has been counted
    drag = s.local_damping * np.abs(forces) * np.sign(velocity) + s.global_damping * inertia * velocity
    work = np.where(a.held, 0.0, (load - 0.5 * drag) * velocity * s.time_step)
    return float(work[gone].sum())


def _mask(which: ArrayLike, particles: int) -> NDArray[np.bool_]:
    given = np.asarray(which)
    if given.dtype == np.bool_:
        if given.shape != (particles,):
            raise InputError(
                "which", f"this is no mask of {particles} particles", "Give one entry a particle"
            )
        gone = given.copy()
    else:
        numbers = given.astype(np.int64)
        if len(numbers) and not 0 <= numbers.min() <= numbers.max() < particles:
            raise InputError("which", f"there are particles 0 to {particles - 1}", "Give their numbers")
        gone = np.zeros(particles, dtype=bool)
        gone[numbers] = True
    if not gone.any() or gone.all():
        what = "nothing is removed" if not gone.any() else "everything is removed"
        raise InputError("which", what, "Check the shape against the ground")
    return gone


_NONE = np.empty(0, dtype=np.int64)
