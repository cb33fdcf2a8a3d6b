"""ParticleSimulation: discs or spheres that move, touch, break; the only object whose behaviour unfolds over time.

Time is real here (leap-frog with true masses). Equilibrium without time is `geodem.particle_statics`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._jit import ThreadPilot, add_compile_seconds, alone, run_from_cache
from .assembly import Assembly
from .boundaries.wall_pairs import WallPairs, check_servo_contact, find_wall_pairs
from .boundaries.wall_table import wall_table
from .errors import InputError, UnstableError
from .io.particle_checkpoint import read_particles, write_particles
from .kernels.particle_kernel import Features, compile_particle_kernel
from .laws.convention import CONVENTIONS
from .neighbors import find_halo, max_displacement, rebuild, spatial_order, wrapped
from .particle_guard import Guard
from .particle_joints import bond_table, mark_joints
from .particle_layout import (
    NOTHING_AROUND,
    Columns,
    Sleep,
    anchor_table,
    chunk_size,
    chunks_around,
    first_order,
    first_rows,
    row_arrays,
)
from .particle_reading import BrokenBonds, Contacts, ParticleReading
from .particle_setup import (
    begin_account,
    choose_buffer,
    choose_servo_gains,
    choose_time_step,
    first_pairs,
    hand_over,
    joint_table,
    parameter_tables,
    refuse_anchors,
    refuse_convention,
    refuse_damping,
    refuse_time_step,
    scene_features,
    start_cell,
)
from .particle_state import restore, state_tree
from .particle_step import critical_time_step

__all__ = ["BrokenBonds", "Contacts", "ParticleSimulation", "Sleep", "UnstableError"]

Floats = NDArray[np.float64]

SERIAL_LIMIT = 400
"""Up to this many particles the serial kernel wins: a parallel region costs more than its work."""

BATCH = 1000
"""Steps between looks at the clock, at interrupts and at the numbers."""

DISORDER = 0.15
"""Rows are sorted anew once the share of pairs across chunks has grown by this much."""


class ParticleSimulation(ParticleReading):
    """Discs or spheres in motion; what can be read off them is in `ParticleReading`.

    Parameters
    ----------
    assembly : Assembly
    time_step : float, optional
        [s]; half the critical one, which is measured, where it is left out.
    local_damping : float
        Cundall's coefficient [-], 0 to below 1.
    global_damping : float
        Mass-proportional damping alpha [1/s].
    stiffness_damping : float
        Stiffness-proportional damping beta [s]: dashpots beta k at every contact and bond.
    energy : bool
        Keep the energy account.
    orientation : bool, optional
        Keep angles (2D, the default there) or quaternions (3D).
    applied : bool
        Forces will be applied to particles while it runs (`arrays.applied`), though the assembly has none.
    sleep : Sleep, optional
        Skip what is at rest; nothing sleeps where it is left out.
    buffer : float, optional
        Distance of surfaces below which pairs are listed [m].
    convention : str
        How motion becomes what the laws ask for, a name in `geodem.laws.convention.CONVENTIONS`; another than
        geodem's own only to compare with the code of that name.

    Raises
    ------
    InputError
        A time step above the critical one; damping out of range; a servo without contact; a convention that cannot
        stand for the scene.
    """

    def __init__(
        self,
        assembly: Assembly,
        *,
        time_step: float | None = None,
        local_damping: float = 0.0,
        global_damping: float = 0.0,
        stiffness_damping: float = 0.0,
        energy: bool = False,
        orientation: bool | None = None,
        applied: bool = False,
        sleep: Sleep | None = None,
        buffer: float | None = None,
        convention: str = "geodem",
    ) -> None:
        refuse_damping(local_damping, global_damping, stiffness_damping)
        refuse_convention(convention, assembly.dimension, energy, global_damping, local_damping)
        # what is wrong with the input is told before anything is compiled
        refuse_time_step(time_step)
        refuse_anchors(assembly)
        self.assembly = assembly
        self.dimension = assembly.dimension
        self.columns = Columns(assembly.dimension)
        self.local_damping = local_damping
        self.global_damping = global_damping
        self.sleep = sleep
        n = assembly.particles
        self.parallel = n > SERIAL_LIMIT
        self.chunk = chunk_size(n, not self.parallel)
        self.buffer = choose_buffer(assembly, buffer)
        self.cell = start_cell(assembly, self.buffer, sleep)
        tables = parameter_tables(assembly, stiffness_damping)
        self.table, self.bond_table, self.wall_parameters = tables
        self.walls = wall_table(assembly.walls, self.dimension)
        check_servo_contact(first_rows(assembly, np.arange(n))[0], self.walls, assembly.walls)
        self.joint_table = joint_table(assembly)
        orientation = self.dimension == 2 if orientation is None else orientation
        self.features = scene_features(
            self, energy=energy, orientation=orientation, applied=applied, convention=convention
        )
        self.layout = self.features.layout()

        ids = first_order(assembly)
        self.arrays = row_arrays(assembly, ids, applied=self.features.applied)
        self.rows = first_rows(assembly, ids)
        self.phase = 0
        self.angle = np.zeros((n if orientation else 1, 1 if self.dimension == 2 else 4))
        if self.dimension == 3:
            self.angle[:, 0] = 1.0
        self.anchors = anchor_table(assembly)
        self.steps = 0
        self.stages = [(0, 0.0, 0.0)]
        bonds = len(assembly.bonds)
        self.record = np.zeros((max(bonds, 1), 3 + self.dimension))
        self.utilisation = np.zeros((max(bonds, 1), 2))
        self.bond_scale = np.ascontiguousarray(assembly.bond_scale) if bonds else np.ones(1)
        chunks = (n + self.chunk - 1) // self.chunk
        self.sums = np.zeros((chunks, 17 if self.cell is None else 26))
        self.wall_sums = np.zeros((chunks, max(len(assembly.walls), 1), assembly.held.shape[1]))
        self.force = np.zeros((n, assembly.held.shape[1]))
        self.asleep = np.zeros(chunks, dtype=np.uint8)
        self.quiet = np.zeros(chunks, dtype=np.int64)
        self.started = False
        self.lag = 0.0
        self.initial_energy = 0.0
        self._ready()
        self.pairs = first_pairs(self)
        self.sorted_share = -1.0
        self.around = NOTHING_AROUND
        self.wall_pairs = WallPairs.empty(n, chunk=self.chunk, history_width=self.layout.width)
        self._searched()
        self.searches = 1
        self.critical_time_step = critical_time_step(self, local_damping=local_damping)
        self.time_step = choose_time_step(self.critical_time_step, time_step)
        self.span = self.time_step
        choose_servo_gains(self)

    def _ready(self) -> None:
        """What a simulation needs beside its state."""
        # rows are not sorted anew while others hold arrays by row
        self.order_kept = False
        self._old_row_of_new: NDArray[np.int64] | None = None
        self._kernels: dict[Features, ModuleType] = {}
        self._pilot = ThreadPilot()
        self._guard: Guard | None = None

    @property
    def guard(self) -> Guard:
        """What watches over the motion."""
        if self._guard is None:
            self._guard = Guard(self)
        return self._guard

    # ------------------------------------------------------------------ checkpoints

    def save(self, path: Path | str) -> None:
        """Write a checkpoint, whole or not at all, from which `resume` goes on with the same bits.

        Raises
        ------
        InputError
            The file cannot be written (the old one is untouched), or a search for equilibrium is under way.
        """
        write_particles(path, self.assembly, state_tree(self))

    @classmethod
    def resume(cls, path: Path | str, *, other_version: bool = False) -> ParticleSimulation:
        """The simulation of a checkpoint, as it was, on any number of threads; nothing in the file is executed.

        Parameters
        ----------
        other_version : bool
            Take a checkpoint of other sources of geodem or versions of its libraries too: the motion goes on, but
            its last bits may differ.

        Raises
        ------
        InputError
            No such file, cut off, changed, no checkpoint of discs or spheres, or of another version.
        """
        assembly, tree = read_particles(path, other_version=other_version)
        return cls.of_state(assembly, tree, str(path))

    @classmethod
    def of_state(cls, assembly: Assembly, tree: Mapping[str, Any], place: str) -> ParticleSimulation:
        """The simulation that a state of `geodem.particle_state` belongs to, which it takes over; `place`: from where.

        Raises
        ------
        InputError
            Parts are missing or do not fit the assembly.
        """
        self = cls.__new__(cls)
        restore(self, assembly, tree, place)
        self._ready()
        return self

    def last_good(self) -> ParticleSimulation:
        """The last state that was kept while everything was well, as a simulation of its own; `save` writes it.

        A state is kept where a motion begins, and then about every 4000 steps, see `geodem.particle_guard`. From it
        the motion goes on with the same bits.

        Raises
        ------
        InputError
            Nothing has moved yet.
        """
        if self.guard.kept is None:
            raise InputError(
                "last_good", "nothing has moved yet, or the state is too large to be kept in memory",
                "Run some steps before, or save checkpoints on the way",
            )  # fmt: skip
        return self.guard.before(self)

    # ------------------------------------------------------------------ neighbours

    def _searched(self) -> None:
        """What follows a search: wall pairs, where everything was, the chunks around each chunk."""
        if self.assembly.walls:
            self.wall_pairs = find_wall_pairs(
                self.now, self.walls, buffer=self.buffer, chunk=self.chunk, history_width=self.layout.width,
                old=self.wall_pairs, old_row_of_new=self._old_row_of_new,
            )  # fmt: skip
        self._old_row_of_new = None
        mark_joints(self)
        self.listed()
        self.reference = self.now[:, self.columns.position].copy()
        if self.cell is not None:
            self.cell.searched()
        self.moved = 0.0
        self.carried = 0.0

    def listed(self) -> None:
        """What follows from the list of pairs alone: the halos of the chunks, the chunks around each one."""
        self.halo = find_halo(self.pairs)
        self.halo_force = np.zeros((len(self.halo.source), self.force.shape[1]))
        self.around = NOTHING_AROUND if self.sleep is None else chunks_around(self.pairs)

    def wake_all(self) -> None:
        """Wake every sleeping part; to be called when something from outside has changed."""
        self.asleep[:] = 0
        self.quiet[:] = 0

    def search(self, *, sort: bool | None = None) -> None:
        """Make the pair list anew; rows are sorted where they have lost their order (or `sort` says so)."""
        if sort is None:
            sort = (
                not self.order_kept
                and self.sorted_share >= 0.0
                and self._share_across() > DISORDER + self.sorted_share
            )
        new_of_old = None
        if self.cell is not None:
            self.cell.settle()
        if sort:
            order = spatial_order(
                np.ascontiguousarray(self._places_in_order()),
                np.ascontiguousarray(self.now[:, self.columns.radius]),
            )
            new_of_old = np.empty_like(order)
            new_of_old[order] = np.arange(len(order))
            self._old_row_of_new = order
            self.rows = np.ascontiguousarray(self.rows[:, order])
            self.arrays = self.arrays.taken(order)
            self.force = np.ascontiguousarray(self.force[order])
            if len(self.angle) == len(order):
                self.angle = np.ascontiguousarray(self.angle[order])
        if sort:
            self.wake_all()
        self.pairs = rebuild(
            self.now, self.arrays.ids, self.pairs, self._old_row_of_new, new_of_old, chunk=self.chunk,
            buffer=self.buffer, dimension=self.dimension, history_width=self.layout.width,
            cell=None if self.cell is None else self.cell.lattice(),
        )  # fmt: skip
        self._searched()
        if sort or self.sorted_share < 0.0:
            self.sorted_share = self._share_across()
        self.searches += 1
        choose_servo_gains(self)

    def _places_in_order(self) -> Floats:
        """Places by row, as near to each other as they act on each other."""
        if self.cell is None:
            return np.asarray(self.now[:, self.columns.position])
        return wrapped(self.now, self.cell.lattice(), self.dimension)

    def _choose_cell_gain(self) -> None:
        choose_servo_gains(self)

    def _share_across(self) -> float:
        """Share of the pairs that lie across chunks."""
        return self.halo.across / max(self.pairs.pairs, 1)

    def keep_listed(self) -> None:
        """Make the pair list anew where what moved since it was made may have come near what it does not name."""
        if self.moved + self.carried <= self.buffer:
            return
        with nullcontext() if self.parallel else alone():
            self._keep_listed()

    def _keep_listed(self) -> None:
        # the bound counts every swing; what counts is where the particles are
        reference = self.reference if self.cell is None else self.cell.carried_along(self.reference)
        self.moved = 2.0 * max_displacement(self.now, reference)
        if not self.moved + self.carried <= 0.7 * self.buffer:
            self.search()

    # ------------------------------------------------------------------ time

    def kernel(self, features: Features) -> ModuleType:
        """The compiled kernel for these features."""
        module = self._kernels.get(features)
        if module is None:
            start = time.perf_counter()
            module = compile_particle_kernel(features, parallel=self.parallel)
            add_compile_seconds(time.perf_counter() - start)
            self._kernels[features] = module
        return module

    def run(self, steps: int, *, progress: Callable[[int], None] | None = None) -> None:
        """Advance `steps` steps of true motion; `progress` is told the steps done now and then.

        Raises
        ------
        UnstableError
            The motion has come to mean nothing, see `geodem.particle_guard`; `last_good` gives the state before.
        """
        if steps < 0:
            raise InputError("steps", "time runs forwards", "Give 0 or more", value=steps)
        kernel = self.kernel(self.features)
        if steps > 0 and not self.started:
            self._start()
        if self.begin_stage(moving=True) or not self.guard.begun:
            self.guard.begin(self)
        left = steps
        while left > 0:
            # rows may be sorted anew here: before inverse masses by row are handed over
            self.keep_listed()
            # what was interrupted before its first step still has that one to come
            first = self.span != self.time_step
            done, _ = self.batch(
                kernel, 1 if first else min(left, BATCH), self.time_step, 1.0, self.arrays.inverse_mass,
                self.arrays.inverse_inertia, self.global_damping, 0.0, _NOTHING,
                lapse=self.lag or NO_TIME, span=self.span,
            )  # fmt: skip
            self.lag = self.span = self.time_step
            left -= done
            if first and self.features.energy:
                begin_account(self)
            self.guard.stepped(self, done)
            if progress is not None:
                progress(steps - left)
        self.guard.ended(self)

    def _start(self) -> None:
        """Begin as the convention does: with velocities at the start, on which the first forces act for half a step."""
        self.started = True
        if CONVENTIONS[self.features.convention].VELOCITIES_BEFORE:
            self.lag = self.time_step
        else:
            self.span = 0.5 * self.time_step

    def hand_over(self, pairs: ArrayLike, *, wall: str | None = None, **history: ArrayLike) -> None:
        """Take over what contacts remember from a motion that is under way, for instance in another code.

        From then on the velocities are those half a step before the positions, whatever the convention, and the motion
        goes on without a start. Where the contacts were a step ago follows from the velocities.

        Parameters
        ----------
        pairs : (k, 2) int
            Particles of every pair; with `wall` (k,) those that touch it.
        wall : str, optional
        history
            By the names of the contact law's history, as they were at the step before: vectors (k, 3) in 3D and (k,) in
            2D, such as `shear`, the shear force on the first of the two [N]; scalars (k,).

        Raises
        ------
        InputError
            A name that the law does not remember, a pair that is not listed as near, or an energy account, which cannot
            know what another motion began with.
        """
        hand_over(self, pairs, wall, history)

    def feel(self, kernel: ModuleType) -> None:
        """Let the laws take in what has moved since they were last asked, by a step of no length; bonds hold."""
        self.batch(
            kernel, 1, NO_TIME, math.inf, self.arrays.inverse_mass, self.arrays.inverse_inertia,
            0.0, 0.0, _NOTHING, lapse=self.lag or NO_TIME,
        )  # fmt: skip
        self.steps -= 1
        self.lag = 0.0

    def begin_stage(self, *, moving: bool) -> bool:
        """Note that from now on steps are true motion, or those of a search for equilibrium: time stands still.

        Returns whether they were not before.
        """
        length = self.time_step if moving else 0.0
        if self.stages[-1][2] == length:
            return False
        self.stages.append((self.steps, self.time, length))
        return True

    def batch(
        self,
        kernel: ModuleType,
        steps: int,
        time_step: float,
        breaking: float,
        inverse_mass: Floats,
        inverse_inertia: Floats,
        global_damping: float,
        damping_ratio: float,
        old_force: Floats,
        *,
        lapse: float | None = None,
        span: float | None = None,
    ) -> tuple[int, float]:
        """Up to `steps` steps of a kernel, with a search where one is due; returns steps done and the last damping.

        Of the first step, `lapse` is how long things have moved since the laws were last asked [s], and `span` how long
        its forces act; the time step where they are left out.
        """
        self.keep_listed()
        known = len(kernel.advance.overloads)
        threads, most = self._pilot.choose() if self.parallel else (1, steps)
        given = (
            min(steps, most),
            time_step if lapse is None else lapse,
            time_step if span is None else span,
            time_step,
            breaking,
            inverse_mass,
            inverse_inertia,
            global_damping,
            damping_ratio,
        )
        arguments = (threads, *self._arguments(*given, old_force))
        start = time.perf_counter()
        if self.parallel:
            run_from_cache(kernel, "advance", arguments)
        done, moved, carried, damping = kernel.advance(*arguments)
        seconds = time.perf_counter() - start
        if len(kernel.advance.overloads) > known:
            add_compile_seconds(seconds)
        elif self.parallel:
            self._pilot.learn(seconds / done)
        self.phase = (self.phase + done) & 1
        self.steps += done
        self.moved = moved
        self.carried = carried
        if not math.isfinite(self.moved) or not math.isfinite(self.carried):
            raise self.guard.lost(self)
        return int(done), float(damping)

    def _arguments(
        self,
        steps: int,
        lapse: float,
        span: float,
        time_step: float,
        breaking: float,
        inverse_mass: Floats,
        inverse_inertia: Floats,
        global_damping: float,
        damping_ratio: float,
        old_force: Floats,
    ) -> tuple[Any, ...]:
        """Arguments of `geodem.kernels.steps.advance` after the first."""
        p, h, w, t, rows = self.pairs, self.halo, self.wall_pairs, self.walls, self.arrays
        around, neighbour = self.around
        sleep = self.sleep or Sleep(0.0, 0)
        return (
            steps, self.rows, self.phase, self.chunk, p.start, p.a, p.b,
            h.local_a, h.local_b, p.bond, p.touching, p.history, h.start, h.into, h.source, h.target, h.lowest,
            self.table, bond_table(self), self.bond_scale, inverse_mass, inverse_inertia, self.assembly.gravity,
            rows.applied, rows.held, rows.anchor_of, self.anchors, self.angle,
            w.start, w.particle, w.primitive, w.touching, w.history, w.normal, w.geometry, w.feature,
            t.shape, t.kind, t.body, t.vertex, t.bodies, self.wall_parameters, self.wall_sums,
            float(lapse), float(span), float(time_step), self.steps, float(breaking), float(self.local_damping),
            float(global_damping), float(damping_ratio), old_force, self.utilisation, self.record, self.sums,
            self.force, self.halo_force, float(self.moved), float(self.carried), float(self.buffer), self.asleep,
            self.quiet, around, neighbour, float(sleep.speed), sleep.steps, p.image,
            NO_CELL if self.cell is None else self.cell.state,
        )  # fmt: skip


_NOTHING = np.zeros((1, 6))

NO_CELL = np.zeros(1)

NO_TIME = 1e-200
"""A step in which nothing moves, yet velocities can be told from increments [s]."""
