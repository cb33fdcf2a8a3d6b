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
from .measure.contact_forces import law_forces
from .measure.particle_energy import HalfStep, ParticleEnergy, half_step_ahead
from .neighbors import Halo, PairList
from .particle_cell import ParticleCell
from .particle_joints import joint_forces, joint_pairs
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


class ParticleReading(ParticleCell):
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
    table, bond_table : (m * m, k)
        Parameters of contacts and bonds by pair of materials.
    joint_table : (k, q)
        Those of joints by their material.
    bond_scale : (b,) [-]
    record : (b, 3 + d)
        Of every bond: mode of its break (0: intact), step, energy, place.
    utilisation : (b, 2) [-]
        Tension and shear over strength where the kernel notes them.
    sums : (chunks, 17)
        See `geodem.kernels.motion`.
    asleep : (chunks,) uint8
        Of chunks of `chunk` rows each.
    reference : (n, d) [m]
        Where the particles were at the last search.
    stages : list of (first step, time [s], time step [s])
        The step is 0 where time stands still.
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
    table: Floats
    bond_table: Floats
    joint_table: Floats
    bond_scale: Floats
    record: Floats
    utilisation: Floats
    sums: Floats
    chunk: int
    asleep: NDArray[np.uint8]
    reference: Floats
    stages: list[tuple[int, float, float]]
    steps: int
    time_step: float
    lag: float
    span: float
    local_damping: float
    global_damping: float
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
    def time(self) -> float:
        """Time since the start [s]; the same however the steps were asked for."""
        first, begun, length = self.stages[-1]
        return begun + (self.steps - first) * length

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
        """Resultant forces and torques (n, d + s) [N, N m] of the last step, gravity and applied ones included.

        What sleeps is taken to be in balance.
        """
        asleep = np.repeat(self.asleep > 0, self.chunk)[: len(self.force)]
        return self._by_particle(np.where(asleep[:, None], 0.0, self.force))

    def kinetic_energy(self) -> float:
        """Kinetic energy of all velocities, held ones included, half a step before the positions [J] (2D: J per m)."""
        ids = self.arrays.ids
        moving = self.assembly.mass[ids] * (self.now[:, self.columns.velocity] ** 2).sum(axis=1)
        turning = self.assembly.inertia[ids] * (self.now[:, self.columns.spin] ** 2).sum(axis=1)
        # not a product of vectors, whose bits depend on the library's threads
        return 0.5 * float((moving + turning).sum())

    def contact_count(self) -> int:
        """Contacts and bonds that carried force in the last step, walls included."""
        return int(self.sums[:, motion.CONTACTS].sum())

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

    def _touching_pairs(self) -> NDArray[np.int64]:
        """Where in the list the pairs stand that touch or are bonded, in the order of `contacts`."""
        p, ids = self.pairs, self.arrays.ids
        which = np.flatnonzero((p.touching > 0) | (p.bond > 0))
        return which[np.lexsort((ids[p.b[which]], ids[p.a[which]]))]

    def contacts(self) -> Contacts:
        """Pairs that touch or are bonded."""
        p, ids, which = self.pairs, self.arrays.ids, self._touching_pairs()
        a, b = p.a[which], p.b[which]
        apart = self._branches(which)
        radius = self.columns.radius
        overlap = self.now[a, radius] + self.now[b, radius] - np.sqrt((apart**2).sum(axis=1))
        history = p.history[which]
        names = [*self.layout.contact, *(f"bond.{name}" for name in self.layout.bond)]
        return Contacts(
            np.stack([ids[a], ids[b]], axis=1),
            p.bond[which] > 0,
            overlap,
            {name: history[:, k] for k, name in enumerate(names)},
        )

    def contact_forces(self) -> tuple[Floats, Floats]:
        """Forces of contacts and their bonds where the particles are, in the order of `contacts`.

        Returns
        -------
        normal : (k,) [N]
            Pressing where positive.
        shear : (k, d) [N]
            On the first of the two. Forces of dashpots are left out of both.
        """
        p, columns, which = self.pairs, self.columns, self._touching_pairs()
        a, b = self.now[p.a[which]], self.now[p.b[which]]
        apart = self._branches(which)
        distance = np.sqrt((apart**2).sum(axis=1))
        along = apart / distance[:, None]
        radius = columns.radius
        history = p.history[which]
        overlap = a[:, radius] + b[:, radius] - distance
        if self.layout.offset is not None:
            overlap = overlap + history[:, self.layout.offset]
        known = {
            "overlap": overlap, "radius_a": a[:, radius], "radius_b": b[:, radius], "distance": distance,
            "mass_a": a[:, columns.mass], "mass_b": b[:, columns.mass],
            "time_step": np.full(len(which), self.time_step),
        }  # fmt: skip
        row = (a[:, columns.material] * len(self.assembly.material_names) + b[:, columns.material]).astype(
            int
        )
        contact, bond = self.features.laws()
        found = np.zeros((len(which), 4))
        bonded = p.bond[which] > 0
        crossing = np.isin(which, joint_pairs(self))
        bonded &= ~crossing
        pressed = ~crossing & (p.touching[which] > 0) & ((overlap > 0.0) | hasattr(contact, "reach"))
        if bond is not None:
            if bond.REPLACES_CONTACT:
                pressed &= ~bonded
            first = len(self.layout.contact)
            own = known | {name: history[:, first + k] for k, name in enumerate(self.layout.bond)}
            own["scale"] = self.bond_scale[np.maximum(p.bond[which] - 1, 0)]
            chosen = {name: value[bonded] for name, value in own.items()}
            found[bonded] += law_forces(bond, self.dimension, self.bond_table[row[bonded]], chosen)
        own = known | {name: history[:, k] for k, name in enumerate(self.layout.contact)}
        chosen = {name: value[pressed] for name, value in own.items()}
        found[pressed] += law_forces(contact, self.dimension, self.table[row[pressed]], chosen)
        if self.dimension == 3:
            normal, shear = found[:, 0], found[:, 1:]
        else:
            normal = found[:, 0]
            shear = found[:, 1:2] * np.stack([-along[:, 1], along[:, 0]], axis=1)
        if crossing.any():
            # along the line of centres and across it, like the others
            force = joint_forces(self, which[crossing])
            normal[crossing] = -(force * along[crossing]).sum(axis=1)
            shear[crossing] = force + normal[crossing, None] * along[crossing]
        return normal, shear

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
        first, begun, length = (np.array(column) for column in zip(*self.stages, strict=True))
        stage = np.searchsorted(first, step, side="right") - 1
        times = begun[stage] + (step - first[stage]) * length[stage]
        place = np.ascontiguousarray(found[:, 3:], dtype=np.float64)
        return BrokenBonds(
            which, found[:, 0].astype(np.int64), step, times, length[stage] == 0.0, place, energy
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
        ahead = self._half_step_ahead()
        return ParticleEnergy(
            kinetic=float(sums[motion.KINETIC]),
            elastic=float(sums[motion.TOTAL_ELASTIC] + sums[motion.ANCHORED]),
            friction=float(sums[motion.TOTAL_FRICTION]),
            damping=float(sums[motion.DAMPING]) - ahead.damping,
            viscous=float(sums[motion.TOTAL_VISCOUS]),
            broken=float(sums[motion.TOTAL_BROKEN]),
            gravity=float(sums[motion.GRAVITATION]),
            applied=float(sums[motion.FORCING]),
            driven=float(sums[motion.DRIVEN]) - ahead.driven,
            walls=float(self.walls.work().sum()) if self.assembly.walls else 0.0,
            cell=0.0 if self.cell is None else self.cell.work,
            initial=self.initial_energy,
        )

    def _half_step_ahead(self) -> HalfStep:
        arrays, d = self.arrays, self.dimension
        inertia = np.column_stack(
            [1.0 / arrays.inverse_mass] * d + [1.0 / arrays.inverse_inertia] * self.assembly.rotations
        )
        given = np.broadcast_to(arrays.applied, inertia.shape).copy()
        given[:, :d] += self.assembly.gravity * inertia[:, :d]
        velocity, spin = self.columns.velocity, self.columns.spin
        after, before = (
            np.hstack([rows[:, velocity], rows[:, spin]]) for rows in (self.now, self.rows[1 - self.phase])
        )
        return half_step_ahead(
            self.force, given, inertia, self.assembly.held[arrays.ids], before, after,
            time_step=self.time_step, local_damping=self.local_damping, global_damping=self.global_damping,
        )  # fmt: skip

    def nbytes(self) -> int:
        """Memory of the state, the lists and what the steps read [bytes]."""
        arrays = [self.rows, self.angle, self.force, self.reference, self.record, self.utilisation, self.sums]
        arrays += [self.halo_force, *vars(self.arrays).values()]
        return sum(array.nbytes for array in arrays) + self.pairs.nbytes + self.halo.nbytes
