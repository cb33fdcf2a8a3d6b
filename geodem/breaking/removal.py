"""Excavation: particles are taken out of a running simulation, and all the rest goes on as it was.

What is left keeps its places, velocities, bonds, contact history and stresses to the bit. The forces that the removed
particles exerted on it may stay as applied forces, so that nothing moves, and be let go step by step: the staged
relaxation of a face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..kernels import motion
from ..particle_reading import BrokenBonds
from ..particle_simulation import ParticleSimulation
from .reduction import reduced

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
    new = reduced(s, left, new_of_old, bonds, applied=keep_forces or s.features.applied)
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
