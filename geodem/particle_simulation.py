"""ParticleSimulation: discs or spheres that move, touch, break; the only object whose behaviour unfolds over time.

Time is real here (leap-frog with true masses). Equilibrium without time is `geodem.particle_statics`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._jit import ThreadPilot, add_compile_seconds
from .assembly import Assembly
from .boundaries.wall_pairs import WallPairs, check_servo_contact, find_wall_pairs
from .boundaries.wall_table import wall_table
from .errors import InputError
from .kernels.particle_kernel import Features, compile_particle_kernel
from .neighbors import PairList, find_halo, max_displacement, rebuild, spatial_order
from .particle_layout import Columns, anchor_table, chunk_size, first_order, first_rows, row_arrays
from .particle_network import critical_time_step
from .particle_reading import BrokenBonds, Contacts, ParticleReading
from .particle_setup import (
    choose_buffer,
    choose_servo_gains,
    choose_time_step,
    first_pairs,
    parameter_tables,
    refuse_damping,
    scene_features,
    start_half_a_step_back,
)

__all__ = ["BrokenBonds", "Contacts", "ParticleSimulation", "Sleep", "UnstableError"]

Floats = NDArray[np.float64]

SERIAL_LIMIT = 400
"""Up to this many particles the serial kernel wins: a parallel region costs more than its work."""

BATCH = 1000
"""Steps between looks at the clock, at interrupts and at the numbers."""

DISORDER = 0.15
"""Rows are sorted anew once the share of pairs across chunks has grown by this much."""


class UnstableError(RuntimeError):
    """A number is no longer finite: a step too long, or forces beyond what float64 can carry."""


class Sleep(NamedTuple):
    """When parts at rest are skipped.

    Chunks of particles (neighbours in space) slower than `speed` for `steps` steps, they and all chunks they touch, are
    taken to stand still and cost nothing until something near them moves faster.
    """

    speed: float  # [m/s]
    steps: int = 100


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
    sleep : Sleep, optional
        Skip what is at rest; nothing sleeps where it is left out.
    buffer : float, optional
        Distance of surfaces below which pairs are listed [m].

    Raises
    ------
    InputError
        A time step above the critical one; damping out of range; a servo without contact.
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
        sleep: Sleep | None = None,
        buffer: float | None = None,
    ) -> None:
        refuse_damping(local_damping, global_damping, stiffness_damping)
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
        tables = parameter_tables(assembly, stiffness_damping)
        self.table, self.bond_table, self.wall_parameters = tables
        orientation = self.dimension == 2 if orientation is None else orientation
        self.features = scene_features(self, energy=energy, orientation=orientation)
        self.layout = self.features.layout()

        ids = first_order(assembly)
        self.arrays = row_arrays(assembly, ids)
        self.rows = first_rows(assembly, ids)
        self.phase = 0
        self.angle = np.zeros((n if orientation else 1, 1 if self.dimension == 2 else 4))
        if self.dimension == 3:
            self.angle[:, 0] = 1.0
        self.anchors = anchor_table(assembly)
        self.walls = wall_table(assembly.walls, self.dimension)
        self.steps = 0
        self.time = 0.0
        self.stages = [(0, 0.0, True)]
        bonds = len(assembly.bonds)
        self.record = np.zeros((max(bonds, 1), 3 + self.dimension))
        self.utilisation = np.zeros((max(bonds, 1), 2))
        self.bond_scale = np.ascontiguousarray(assembly.bond_scale) if bonds else np.ones(1)
        chunks = (n + self.chunk - 1) // self.chunk
        self.sums = np.zeros((chunks, 17))
        self.wall_sums = np.zeros((chunks, max(len(assembly.walls), 1), assembly.held.shape[1]))
        self.force = np.zeros((n, assembly.held.shape[1]))
        self.asleep = np.zeros(chunks, dtype=np.uint8)
        self.quiet = np.zeros(chunks, dtype=np.int64)
        self.pairs = first_pairs(self)
        self.wall_pairs = WallPairs.empty(n, chunk=self.chunk, history_width=self.layout.width)
        self._searched()
        self.searches = 1
        check_servo_contact(self.now, self.walls, assembly.walls)
        self.critical_time_step = critical_time_step(self, local_damping=local_damping)
        self.time_step = choose_time_step(self.critical_time_step, time_step)
        choose_servo_gains(self)
        self._kernels: dict[Features, ModuleType] = {}
        self._pilot = ThreadPilot()

    # ------------------------------------------------------------------ neighbours

    def _searched(self) -> None:
        """What follows a search: wall pairs, where everything was, the chunks around each chunk."""
        if self.assembly.walls:
            self.wall_pairs = find_wall_pairs(
                self.now, self.walls, buffer=self.buffer, chunk=self.chunk, history_width=self.layout.width,
                old=self.wall_pairs, old_row_of_new=self._old_row_of_new,
            )  # fmt: skip
        self._old_row_of_new = None
        self.halo = find_halo(self.pairs)
        self.halo_force = np.zeros((len(self.halo.source), self.force.shape[1]))
        self.reference = self.now[:, self.columns.position].copy()
        self.moved = 0.0
        self.carried = 0.0
        if self.sleep is not None:
            self._around = _chunks_around(self.pairs)

    _old_row_of_new: NDArray[np.int64] | None = None
    _sorted_share: float = -1.0
    order_kept: bool = False
    """Rows are not sorted anew while others hold arrays by row."""

    def wake_all(self) -> None:
        """Wake every sleeping part; to be called when something from outside has changed."""
        self.asleep[:] = 0
        self.quiet[:] = 0

    def search(self, *, sort: bool | None = None) -> None:
        """Make the pair list anew; rows are sorted where they have lost their order (or `sort` says so)."""
        if sort is None:
            sort = (
                not self.order_kept
                and self._sorted_share >= 0.0
                and self._share_across() > DISORDER + self._sorted_share
            )
        new_of_old = None
        if sort:
            order = spatial_order(
                np.ascontiguousarray(self.now[:, self.columns.position]),
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
        )  # fmt: skip
        self._searched()
        if sort or self._sorted_share < 0.0:
            self._sorted_share = self._share_across()
        self.searches += 1
        choose_servo_gains(self)

    def _share_across(self) -> float:
        """Share of the pairs that lie across chunks."""
        return self.halo.across / max(self.pairs.pairs, 1)

    def _look(self) -> None:
        """Search anew where particles may have moved too far."""
        # the bound counts every swing; what counts is where the particles are
        self.moved = 2.0 * max_displacement(self.now, self.reference)
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
            A position or velocity is no longer finite; the state before the batch of steps is lost.
        """
        if steps < 0:
            raise InputError("steps", "time runs forwards", "Give 0 or more", value=steps)
        kernel = self.kernel(self.features)
        if steps > 0 and not self.started:
            self._start(kernel)
        self.begin_stage(moving=True)
        left = steps
        while left > 0:
            # rows may be sorted anew here: before inverse masses by row are handed over
            if not self.moved + self.carried <= self.buffer:
                self._look()
            done, _ = self.batch(
                kernel, min(left, BATCH), self.time_step, 1.0, self.arrays.inverse_mass,
                self.arrays.inverse_inertia, self.global_damping, 0.0, _NOTHING,
            )  # fmt: skip
            left -= done
            self.time += done * self.time_step
            if progress is not None:
                progress(steps - left)

    def _start(self, kernel: ModuleType) -> None:
        """Find the forces of the given state by a step of no length, and begin half a step before it."""
        self.batch(
            kernel, 1, NO_TIME, math.inf, self.arrays.inverse_mass, self.arrays.inverse_inertia,
            self.global_damping, 0.0, _NOTHING,
        )  # fmt: skip
        self.steps -= 1
        self.started = True
        start_half_a_step_back(self)

    started: bool = False
    initial_energy = 0.0

    def begin_stage(self, *, moving: bool) -> None:
        """Note that from now on steps are true motion, or those of a search for equilibrium."""
        if self.stages[-1][2] != moving:
            self.stages.append((self.steps, self.time, moving))

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
    ) -> tuple[int, float]:
        """Up to `steps` steps of a kernel, with a search where one is due; returns steps done and the last damping."""
        if not self.moved + self.carried <= self.buffer:
            self._look()
        known = len(kernel.advance.signatures)
        threads, most = self._pilot.choose() if self.parallel else (1, steps)
        steps = min(steps, most)
        start = time.perf_counter()
        done, moved, carried, damping = kernel.advance(
            threads,
            *self._arguments(
                steps,
                time_step,
                breaking,
                inverse_mass,
                inverse_inertia,
                global_damping,
                damping_ratio,
                old_force,
            )
        )
        seconds = time.perf_counter() - start
        if len(kernel.advance.signatures) > known:
            add_compile_seconds(seconds)
        elif self.parallel:
            self._pilot.learn(seconds / done)
        self.phase = (self.phase + done) & 1
        self.steps += done
        self.moved += moved
        self.carried += carried
        if not math.isfinite(self.moved) or not math.isfinite(self.carried):
            raise self._unstable()
        return int(done), float(damping)

    def _arguments(
        self,
        steps: int,
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
        around, neighbour = self._around
        sleep = self.sleep or Sleep(0.0, 0)
        return (
            steps, self.rows, self.phase, self.chunk, p.start, p.a, p.b,
            h.local_a, h.local_b, p.bond, p.touching, p.history, h.start, h.into, h.source, h.target, h.lowest,
            self.table, self.bond_table, self.bond_scale, inverse_mass, inverse_inertia, self.assembly.gravity,
            rows.applied, rows.held, rows.anchor_of, self.anchors, self.angle,
            w.start, w.particle, w.primitive, w.touching, w.history, w.normal, w.geometry, w.feature,
            t.shape, t.kind, t.body, t.vertex, t.bodies, self.wall_parameters, self.wall_sums,
            float(time_step), self.steps, float(breaking), float(self.local_damping), float(global_damping),
            float(damping_ratio), old_force, self.utilisation, self.record, self.sums, self.force, self.halo_force,
            float(self.buffer - self.moved - self.carried), self.asleep, self.quiet, around, neighbour,
            float(sleep.speed), sleep.steps,
        )  # fmt: skip

    _around: tuple[NDArray[np.int64], NDArray[np.int64]] = (np.zeros(1, np.int64), np.zeros(1, np.int64))

    def _unstable(self) -> UnstableError:
        lost = np.flatnonzero(~np.isfinite(self.now).all(axis=1))
        which = f"particle {int(self.arrays.ids[lost[0]])}" if len(lost) else "a wall"
        return UnstableError(
            f"{which} has no finite place or velocity after step {self.steps} (time step {self.time_step:.6g} s, "
            f"critical at the start {self.critical_time_step:.6g} s). Take a shorter time step, or look for "
            "particles that were pressed into one another"
        )


_NOTHING = np.zeros((1, 6))

NO_TIME = 1e-200
"""A step in which nothing moves, yet velocities can be told from increments [s]."""


def _chunks_around(pairs: PairList) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Chunks that share pairs with each chunk, as compressed rows."""
    first, second = pairs.a.astype(np.int64) // pairs.chunk, pairs.b.astype(np.int64) // pairs.chunk
    across = first != second
    chunks = len(pairs.start) - 1
    key = np.unique(
        np.concatenate([first[across] * chunks + second[across], second[across] * chunks + first[across]])
    )
    start = np.zeros(chunks + 1, dtype=np.int64)
    np.cumsum(np.bincount(key // chunks, minlength=chunks), out=start[1:])
    neighbour = key % chunks
    return start, neighbour if len(neighbour) else np.zeros(1, np.int64)
