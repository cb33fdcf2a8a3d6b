"""What can be read off a particle simulation, in the order of the assembly: motion, contacts, breaks, walls, energy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .assembly import Assembly
from .boundaries.wall_table import WallTable
from .errors import InputError
from .kernels import motion
from .kernels.adapters import HistoryLayout
from .kernels.particle_kernel import Features
from .measure.particle_energy import ParticleEnergy
from .neighbors import Halo, PairList
from .particle_layout import Columns, RowArrays

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BrokenBonds:
    """Every break, in the order of time and then of the bonds' numbers.

    Attributes
    ----------
    bond : (k,) int64
    mode : (k,) int64
        1 tension, 2 shear.
    step : (k,) int64
    time : (k,) [s]
    static : (k,) bool
        Broke in the search for an equilibrium, where time stands still.
    place : (k, d) [m]
    energy : (k,) [J]
        Released; nan where the energy account is off.
    """

    bond: NDArray[np.int64]
    mode: NDArray[np.int64]
    step: NDArray[np.int64]
    time: Floats
    static: NDArray[np.bool_]
    place: Floats
    energy: Floats


@dataclass(frozen=True)
class Contacts:
    """Pairs that touch or are bonded, each once, in ascending order.

    Attributes
    ----------
    pairs : (k, 2) int64
    bonded : (k,) bool
    overlap : (k,) [m]
        ra + rb - distance.
    history : dict of str to (k,)
        What the laws remember, by name; "bond." before the names of the bond law.
    """

    pairs: NDArray[np.int64]
    bonded: NDArray[np.bool_]
    overlap: Floats
    history: dict[str, Floats]


class ParticleReading:
    """The arrays of a particle simulation, by row, and how they are read; nothing here changes them.

    Attributes
    ----------
    assembly : Assembly
        What does not change.
    arrays : RowArrays
        Particle of every row, and what steps read.
    rows : (2, n, W)
        Present and following state, see `Columns`; `phase` is the one of the present.
    angle : (n, 1) [rad] or (n, 4)
    force : (n, d + s) [N, N m]
    pairs : PairList
    halo : Halo
    halo_force : (h, d + s) [N, N m]
    walls : WallTable
    record : (b, 3 + d)
        Of every bond: mode of its break (0: intact), step, energy, place.
    utilisation : (b, 2) [-]
        Tension and shear over strength where the kernel notes them.
    sums : (chunks, 17)
        See `geodem.kernels.motion`.
    reference : (n, d) [m]
        Where the particles were at the last search.
    stages : list of (first step, time [s], moving)
    """

    assembly: Assembly
    dimension: int
    columns: Columns
    features: Features
    layout: HistoryLayout
    arrays: RowArrays
    rows: Floats
    phase: int
    angle: Floats
    force: Floats
    pairs: PairList
    halo: Halo
    halo_force: Floats
    walls: WallTable
    record: Floats
    utilisation: Floats
    sums: Floats
    reference: Floats
    stages: list[tuple[int, float, bool]]
    time_step: float
    initial_energy: float

    @property
    def now(self) -> Floats:
        """Rows of the present."""
        return np.asarray(self.rows[self.phase])

    def _by_particle(self, values: Floats) -> Floats:
        found = np.empty_like(values)
        found[self.arrays.ids] = values
        return found

    @property
    def positions(self) -> Floats:
        """Centres (n, d) [m], in the order of the assembly."""
        return self._by_particle(self.now[:, self.columns.position])

    @property
    def velocities(self) -> Floats:
        """Velocities (n, d) [m/s], half a step before the positions."""
        return self._by_particle(self.now[:, self.columns.velocity])

    @property
    def spins(self) -> Floats:
        """Angular velocities (n, 1 or 3) [rad/s], half a step before the positions."""
        return self._by_particle(self.now[:, self.columns.spin])

    @property
    def orientations(self) -> Floats:
        """Angles (n, 1) [rad] or quaternions (n, 4), w first.

        Raises
        ------
        InputError
            The simulation does not keep them.
        """
        if not self.features.orientation:
            raise InputError(
                "orientation", "this simulation does not keep it", "Give ParticleSimulation orientation=True"
            )
        return self._by_particle(self.angle)

    @property
    def forces(self) -> Floats:
        """Resultant forces and torques (n, d + s) [N, N m] of the last step, gravity and applied ones included."""
        return self._by_particle(self.force)

    def unbalanced_ratio(self) -> float:
        """Root mean square of the resultants of free particles over the mean contact force [-], last step."""
        free = int((~self.assembly.held[:, : self.dimension].all(axis=1)).sum())
        contacts = float(self.sums[:, motion.CONTACTS].sum())
        if free == 0:
            return 0.0
        unbalanced = math.sqrt(float(self.sums[:, motion.UNBALANCED].sum()) / free)
        if contacts == 0.0:
            return math.inf if unbalanced > 0.0 else 0.0
        thrust = float(self.sums[:, motion.THRUST].sum()) / contacts
        return unbalanced / thrust if thrust > 0.0 else (math.inf if unbalanced > 0.0 else 0.0)

    def contacts(self) -> Contacts:
        """Pairs that touch or are bonded."""
        p = self.pairs
        under = p.listed_under()
        once = (under == np.minimum(p.a, p.b)) & ((p.touching > 0) | (p.bond > 0))
        ids = self.arrays.ids
        pairs = np.stack([ids[p.a[once]], ids[p.b[once]]], axis=1)
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        apart = self.now[p.b[once]][:, self.columns.position] - self.now[p.a[once]][:, self.columns.position]
        radius = self.columns.radius
        overlap = self.now[p.a[once], radius] + self.now[p.b[once], radius] - np.sqrt((apart**2).sum(axis=1))
        history = p.history[once][order]
        names = [*self.layout.contact, *(f"bond.{name}" for name in self.layout.bond)]
        return Contacts(
            pairs[order],
            (p.bond[once] > 0)[order],
            overlap[order],
            {name: history[:, k] for k, name in enumerate(names)},
        )

    def intact(self) -> NDArray[np.bool_]:
        """Which bonds (b,) are intact."""
        return np.asarray(self.record[: len(self.assembly.bonds), 0] == 0)

    def broken_bonds(self) -> BrokenBonds:
        """Every break so far."""
        record = self.record[: len(self.assembly.bonds)]
        which = np.flatnonzero(record[:, 0] > 0)
        which = which[np.lexsort((which, record[which, 1]))]
        found = record[which]
        energy: Floats = found[:, 2] if self.features.energy else np.full(len(found), np.nan)
        step = found[:, 1].astype(np.int64)
        first, begun, moving = (np.array(column) for column in zip(*self.stages, strict=True))
        stage = np.searchsorted(first, step, side="right") - 1
        # in statics time stands still
        times = np.where(moving[stage], begun[stage] + (step - first[stage]) * self.time_step, begun[stage])
        place = np.ascontiguousarray(found[:, 3:], dtype=np.float64)
        return BrokenBonds(
            which, found[:, 0].astype(np.int64), step, times.astype(np.float64), ~moving[stage], place, energy
        )

    def wall_force(self, name: str) -> Floats:
        """Force (d,) of the particles on a wall in the last step [N]."""
        return self.walls.forces()[self.walls.index(name)].copy()

    def wall_torque(self, name: str) -> Floats:
        """Torque (1 or 3,) of the particles on a wall about its centre in the last step [N m]."""
        return self.walls.torques()[self.walls.index(name)].copy()

    def energy(self) -> ParticleEnergy:
        """Where the work went since the start.

        Raises
        ------
        InputError
            The simulation keeps no energy account.
        """
        if not self.features.energy:
            raise InputError(
                "energy", "this simulation keeps no account", "Give ParticleSimulation energy=True"
            )
        sums = self.sums.sum(axis=0)
        return ParticleEnergy(
            kinetic=float(sums[motion.KINETIC]),
            elastic=float(sums[motion.TOTAL_ELASTIC] + sums[motion.ANCHORED]),
            friction=float(sums[motion.TOTAL_FRICTION]),
            damping=float(sums[motion.DAMPING]),
            viscous=float(sums[motion.TOTAL_VISCOUS]),
            broken=float(sums[motion.TOTAL_BROKEN]),
            gravity=float(sums[motion.GRAVITATION]),
            applied=float(sums[motion.FORCING]),
            driven=float(sums[motion.DRIVEN]),
            walls=float(self.walls.work().sum()) if self.assembly.walls else 0.0,
            initial=self.initial_energy,
        )

    def nbytes(self) -> int:
        """Memory of the state, the lists and what the steps read [bytes]."""
        arrays = [self.rows, self.angle, self.force, self.reference, self.record, self.utilisation, self.sums]
        arrays += [self.halo_force, *vars(self.arrays).values()]
        return sum(array.nbytes for array in arrays) + self.pairs.nbytes + self.halo.nbytes
