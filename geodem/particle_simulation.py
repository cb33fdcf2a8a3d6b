"""ParticleSimulation: discs or spheres that move, touch, break; the only object whose behaviour unfolds over time.

Time is real here (leap-frog with true masses). Equilibrium without time is `geodem.particle_statics`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._jit import ThreadPilot, add_compile_seconds
from .assembly import Assembly
from .boundaries.wall_pairs import WallPairs, check_servo_contact, contact_sum, find_wall_pairs
from .boundaries.wall_table import WallTable, set_servo_gains, wall_table
from .errors import InputError
from .kernels import motion
from .kernels.particle_kernel import Features, compile_particle_kernel
from .measure.particle_energy import ParticleEnergy
from .neighbors import PairList, bond_pairs, max_displacement, rebuild, spatial_order
from .particle_layout import (
    Columns,
    RowArrays,
    anchor_table,
    chunk_size,
    finite,
    first_order,
    first_rows,
    row_arrays,
    wall_parameters,
)
from .particle_network import critical_time_step, current_links

Floats = NDArray[np.float64]

SERIAL_LIMIT = 400
"""Up to this many particles the serial kernel wins: a parallel region costs more than its work."""

SAFETY = 0.5
"""Share of the critical time step that is used where none is given: a collision then takes at least three steps."""

BUFFER_SHARE = 0.1
"""Buffer of the pair list over the mean radius."""

BATCH = 1000
"""Steps between looks at the clock, at interrupts and at the numbers."""

DISORDER = 1.15
"""Rows are sorted anew once pairs across chunks have made the list this much longer."""


class UnstableError(RuntimeError):
    """A number is no longer finite: a step too long, or forces beyond what float64 can carry."""


class Sleep(NamedTuple):
    """When parts at rest are skipped.

    Chunks of particles (neighbours in space) slower than `speed` for `steps` steps, they and all chunks they touch, are
    taken to stand still and cost nothing until something near them moves faster.
    """

    speed: float  # [m/s]
    steps: int = 100


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


class ParticleSimulation:
    """Discs or spheres in motion.

    Parameters
    ----------
    assembly : Assembly
    time_step : float, optional
        [s]; `SAFETY` times the critical one, which is measured, where it is left out.
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
        _refuse_damping(local_damping, global_damping, stiffness_damping)
        self.assembly = assembly
        self.dimension = assembly.dimension
        self.columns = Columns(assembly.dimension)
        self.local_damping = local_damping
        self.global_damping = global_damping
        self.sleep = sleep
        n = assembly.particles
        self.parallel = n > SERIAL_LIMIT
        self.chunk = chunk_size(n, not self.parallel)
        self.buffer = BUFFER_SHARE * float(assembly.radii.mean()) if buffer is None else float(buffer)
        if not (math.isfinite(self.buffer) and self.buffer > 0.0):
            raise InputError(
                "buffer", "this is no distance", "Give more than 0 m, or leave it out", value=buffer
            )
        self.table = finite(assembly.contact_table)
        self.bond_table = finite(assembly.bond_table) if assembly.bond_law is not None else np.zeros((1, 1))
        self.wall_parameters = wall_parameters(assembly) if assembly.walls else np.zeros((1, 1))
        self._add_stiffness_damping(stiffness_damping)
        orientation = self.dimension == 2 if orientation is None else orientation
        self.features = self._features(energy=energy, orientation=orientation)
        self.layout = self.features.layout()

        ids = first_order(assembly)
        self.arrays: RowArrays = row_arrays(assembly, ids)
        self.rows = first_rows(assembly, ids)
        self.phase = 0
        self.angle = np.zeros((n if orientation else 1, 1 if self.dimension == 2 else 4))
        if self.dimension == 3:
            self.angle[:, 0] = 1.0
        self.anchors = anchor_table(assembly)
        self.walls: WallTable = wall_table(assembly.walls, self.dimension)
        self.steps = 0
        self.time = 0.0
        self.stages: list[tuple[int, float, bool]] = [(0, 0.0, True)]
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
        self.pairs = self._first_pairs()
        self.wall_pairs = WallPairs.empty(n, chunk=self.chunk, history_width=self.layout.width)
        self._searched()
        self.searches = 1
        check_servo_contact(self.now, self.walls, assembly.walls)
        self.critical_time_step = critical_time_step(self, local_damping=local_damping)
        self.time_step = self._choose_time_step(time_step)
        self._set_servo_gains()
        self._kernels: dict[Features, ModuleType] = {}
        self._pilot = ThreadPilot()

    # ------------------------------------------------------------------ set-up

    def _features(self, *, energy: bool, orientation: bool) -> Features:
        a = self.assembly
        contact, bond = Features(self.dimension, a.contact_law, a.bond_law).laws()
        fields = contact.PARAMETERS._fields
        tables = np.concatenate([self.table, self.wall_parameters]) if a.walls else self.table
        shear = _any_friction(fields, tables)
        d = self.dimension
        turns = not a.held[:, d:].all() or bool(a.spins.any())
        moment = contact.MOMENT or (bond is not None)
        return Features(
            dimension=d,
            contact_law=a.contact_law,
            bond_law=a.bond_law,
            materials=len(a.material_names),
            shear=shear or bond is not None,
            contact_viscous=bool(getattr(contact, "VISCOUS", False)) and _any_viscosity(fields, tables),
            bond_viscous=bond is not None
            and bool(getattr(bond, "VISCOUS", False))
            and _any_viscosity(bond.PARAMETERS._fields, self.bond_table),
            bonds_scaled=bond is not None and bool((a.bond_scale != 1.0).any()),
            rotation=turns and (shear or moment or bool(a.applied[:, d:].any()) or bool(a.spins.any())),
            orientation=orientation,
            gravity=bool(a.gravity.any()),
            applied=bool(a.applied.any()),
            held=bool(a.held.any()),
            anchors=a.anchors is not None,
            walls=bool(a.walls),
            walls_turn=any(bool(np.any(wall.spin)) for wall in a.walls),
            local_damping=self.local_damping > 0.0,
            global_damping=self.global_damping > 0.0,
            energy=energy,
            sleep=self.sleep is not None,
            blocked=d == 3 and self.parallel and not energy,
        )

    def _add_stiffness_damping(self, beta: float) -> None:
        if beta == 0.0:
            return
        contact, bond = Features(self.dimension, self.assembly.contact_law, self.assembly.bond_law).laws()
        tables = [(contact, self.table), (contact, self.wall_parameters)]
        if bond is not None:
            tables.append((bond, self.bond_table))
        for law, table in tables:
            viscous = [k for k, name in enumerate(law.PARAMETERS._fields) if name.endswith("_viscosity")]
            if not viscous:
                raise InputError(
                    "stiffness_damping", f"the law {law.NAME!r} has no dashpots",
                    "Use global_damping or local_damping, or another law", value=beta,
                )  # fmt: skip
            if table.shape[1] == len(law.PARAMETERS._fields):
                table[:, viscous] += beta

    def _first_pairs(self) -> PairList:
        a, layout = self.assembly, self.layout
        common: dict[str, Any] = {
            "chunk": self.chunk, "buffer": self.buffer, "dimension": self.dimension, "history_width": layout.width,
        }  # fmt: skip
        if a.bond_law is None or not len(a.bonds):
            return rebuild(self.now, self.arrays.ids, None, **common)
        assert layout.offset is not None
        distance = np.linalg.norm(a.positions[a.bonds[:, 0]] - a.positions[a.bonds[:, 1]], axis=1)
        histories = np.zeros((len(a.bonds), len(layout.bond) + 1))
        histories[:, -1] = distance - a.radii[a.bonds].sum(axis=1)
        return bond_pairs(self.now, self.arrays.ids, a.bonds, histories, offset=len(layout.contact), **common)

    def _choose_time_step(self, given: float | None) -> float:
        critical = self.critical_time_step
        if given is None:
            if not math.isfinite(critical):
                raise InputError(
                    "time_step", "nothing in this scene has a stiffness, so no step follows from it",
                    "Give one in seconds",
                )  # fmt: skip
            return SAFETY * critical
        if not (math.isfinite(given) and given > 0.0):
            raise InputError("time_step", "this is no time", "Give seconds, more than 0", value=given)
        if given > critical:
            raise InputError(
                "time_step", f"this is above the critical time step of {critical:.6g} s, so the motion would explode",
                f"Give {SAFETY * critical:.3g} s, or leave it out", value=given,
            )  # fmt: skip
        return float(given)

    def _set_servo_gains(self) -> None:
        if any(wall.servo is not None and wall.servo.gain is None for wall in self.assembly.walls):
            stiffness = np.full(len(self.wall_pairs.particle), self._wall_stiffness())
            total = contact_sum(self.walls, self.wall_pairs, stiffness)
            one = self._wall_stiffness()
            set_servo_gains(self.walls, self.assembly.walls, np.maximum(total, one), self.time_step)

    def _wall_stiffness(self) -> float:
        links = current_links(self, walls_only=True)
        return float(links.kn.max()) if len(links.kn) else float(self.table[:, 0].max())

    # ------------------------------------------------------------------ neighbours

    @property
    def now(self) -> Floats:
        """Rows of the present."""
        return np.asarray(self.rows[self.phase])

    def _searched(self) -> None:
        """What follows a search: wall pairs, where everything was, the chunks around each chunk."""
        if self.assembly.walls:
            self.wall_pairs = find_wall_pairs(
                self.now, self.walls, buffer=self.buffer, chunk=self.chunk, history_width=self.layout.width,
                old=self.wall_pairs, old_row_of_new=self._old_row_of_new,
            )  # fmt: skip
        self._old_row_of_new = None
        self.reference = self.now[:, self.columns.position].copy()
        self.moved = 0.0
        self.carried = 0.0
        if self.sleep is not None:
            self._around = _chunks_around(self.pairs)

    _old_row_of_new: NDArray[np.int64] | None = None
    _sorted_pairs: int = 0
    order_kept: bool = False
    """Rows are not sorted anew while others hold arrays by row."""

    def wake_all(self) -> None:
        """Wake every sleeping part; to be called when something from outside has changed."""
        self._remind_sleepers()
        self.asleep[:] = 0
        self.quiet[:] = 0

    def _remind_sleepers(self) -> None:
        """Sleeping chunks take over what their awake neighbours remember of the pairs across."""
        p = self.pairs
        for chunk in np.flatnonzero(self.asleep):
            self.kernel(self.features).take_over(
                chunk, self.chunk, p.start, p.a, p.b, p.bond, p.touching, p.history, self.asleep
            )

    def search(self, *, sort: bool | None = None) -> None:
        """Make the pair list anew; rows are sorted where they have lost their order (or `sort` says so)."""
        if sort is None:
            sort = (
                not self.order_kept
                and self._sorted_pairs > 0
                and self.pairs.pairs > DISORDER * self._sorted_pairs
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
        else:
            self._remind_sleepers()
        self.pairs = rebuild(
            self.now, self.arrays.ids, self.pairs, self._old_row_of_new, new_of_old, chunk=self.chunk,
            buffer=self.buffer, dimension=self.dimension, history_width=self.layout.width,
        )  # fmt: skip
        if sort or self._sorted_pairs == 0:
            self._sorted_pairs = self.pairs.pairs
        self._searched()
        self.searches += 1
        self._set_servo_gains()

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
        """Velocities half a step back from those given, so that the motion is of second order from its first step."""
        arrays, d = self.arrays, self.dimension
        # a step of no length: the forces of the given state
        self.batch(
            kernel,
            1,
            NO_TIME,
            math.inf,
            arrays.inverse_mass,
            arrays.inverse_inertia,
            self.global_damping,
            0.0,
            _NOTHING,
        )
        self.steps -= 1
        self.started = True
        now = self.rows[self.phase]
        # as given: even a step of no length leaves nothing quite at rest
        given = self.rows[1 - self.phase]
        velocity = np.hstack([given[:, self.columns.velocity], given[:, self.columns.spin]])
        resultant = self.force - self.local_damping * np.abs(self.force) * np.sign(velocity)
        inverse = np.column_stack(
            [arrays.inverse_mass] * d + [arrays.inverse_inertia] * self.assembly.rotations
        )
        rate = np.where(
            self.assembly.held[arrays.ids], 0.0, resultant * inverse - self.global_damping * velocity
        )
        if not self.features.rotation:
            rate[:, d:] = 0.0
        if self.local_damping > 0.0:
            # half a step back from rest is a way backwards, on which local damping would push
            rate[velocity == 0.0] = 0.0
        before = velocity - 0.5 * self.time_step * rate
        now[:, self.columns.velocity] = before[:, :d]
        now[:, self.columns.spin] = before[:, d:]
        free = ~self.assembly.held[arrays.ids]
        both = before * (before + self.time_step * rate) / inverse
        self.initial_energy = float(0.5 * both[free].sum())
        if self.features.energy:
            self.initial_energy += float(self.sums[:, [motion.TOTAL_ELASTIC, motion.ANCHORED]].sum())
            # the first step counts the work on a way of half a step back, which was never gone
            back = np.where(free, self.time_step * before, 0.0)
            weight = self.assembly.gravity / arrays.inverse_mass[:, None]
            self.sums[0, motion.GRAVITATION] -= float((weight * back[:, :d]).sum())
            self.sums[0, motion.FORCING] -= float((arrays.applied * back).sum())
            drag = self.local_damping * np.abs(self.force) * np.sign(before)
            self.sums[0, motion.DAMPING] -= 0.5 * float((drag * back).sum())

    started: bool = False
    initial_energy: float = 0.0

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
        threads = self._pilot.choose() if self.parallel else 1
        start = time.perf_counter()
        done, moved, carried, damping = kernel.advance(
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
        elif threads:
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
        """Arguments of `geodem.kernels.steps.advance`."""
        p, w, t, rows = self.pairs, self.wall_pairs, self.walls, self.arrays
        around, neighbour = self._around
        sleep = self.sleep or Sleep(0.0, 0)
        return (
            steps, self.rows, self.phase, self.chunk, p.start, p.a, p.b, p.bond, p.touching, p.history,
            self.table, self.bond_table, self.bond_scale, inverse_mass, inverse_inertia, self.assembly.gravity,
            rows.applied, rows.held, rows.anchor_of, self.anchors, self.angle,
            w.start, w.particle, w.primitive, w.touching, w.history, w.normal, w.geometry, w.feature,
            t.shape, t.kind, t.body, t.vertex, t.bodies, self.wall_parameters, self.wall_sums,
            float(time_step), self.steps, float(breaking), float(self.local_damping), float(global_damping),
            float(damping_ratio), old_force, self.utilisation, self.record, self.sums, self.force,
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

    # ------------------------------------------------------------------ reading

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
        arrays += list(vars(self.arrays).values())
        return sum(array.nbytes for array in arrays) + self.pairs.nbytes


_NOTHING = np.zeros((1, 6))

NO_TIME = 1e-200
"""A step in which nothing moves, yet velocities can be told from increments [s]."""


def _refuse_damping(local: float, global_: float, stiffness: float) -> None:
    for name, value, most in (
        ("local_damping", local, 1.0),
        ("global_damping", global_, math.inf),
        ("stiffness_damping", stiffness, math.inf),
    ):
        if not (math.isfinite(value) and 0.0 <= value < most):
            bound = "0 to below 1" if most == 1.0 else "0 or more"
            raise InputError(name, "this damping is out of range", f"Give {bound}", value=value)


def _any_friction(fields: tuple[str, ...], table: Floats) -> bool:
    """Some contact carries shear: laws without a friction coefficient always do."""
    columns = [k for k, name in enumerate(fields) if name in ("friction_coefficient", "adhesion_shear")]
    return bool(table[:, columns].any()) if columns else True


def _any_viscosity(fields: tuple[str, ...], table: Floats) -> bool:
    columns = [k for k, name in enumerate(fields) if name.endswith("_viscosity")]
    return bool(table[:, columns].any()) if columns else False


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
