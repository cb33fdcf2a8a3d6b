"""Equilibrium of discs or spheres without time: what is linear is solved, the rest is relaxed with scaled masses.

1. The elastic state: sparse solves on the bonds that are intact and the contacts that touch. Each one leaves out what
   the turning of the links changes, which is the load of the next; three to five of them are enough at small strains.
2. Adaptive viscous relaxation (`geodem.integrators.relaxation`): every particle has the inertia of its own
   stiffness, so that one step serves all; the damping follows the lowest frequency in motion. Bonds do not break on the
   way, so nothing breaks that the swing towards equilibrium, and no static load, would break.
3. In equilibrium the most overstressed bonds break, or pieces of them, and the next equilibrium is sought, until none
   is overstressed.

Displacements per step have no physical meaning as velocities; at the end everything is at rest.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .integrators.elastic_network import NetworkSolver
from .integrators.mass_scaling import scaled_inertia
from .integrators.network import RIGID, Links, build_network
from .kernels import motion
from .particle_network import current_links, current_springs, falling_freely, touching_links
from .particle_simulation import ParticleSimulation, UnstableError

Floats = NDArray[np.float64]

DAMPING_RATIO = 0.5
"""Share of critical damping of the lowest frequency in motion."""

LOOK = 25
"""Steps between looks at the balance."""

SHARE = 0.95
"""Bonds at least this share as overstressed as the most overstressed one break together with it."""

INERTIA_MARGIN = 1.1
"""Slip lowers the stiffness of the links, new contacts and turning normals may raise it a little."""

MOST_SOLVES = 12

RESIDUAL = 1e-2
"""Each solve leaves this share of its load at most: what the turning of the links leaves is more."""

STALE = 0.25
"""Solves go on with the stiffness of an earlier state until the unbalanced ratio falls by less than to this share."""

FIRST_FALL = 4
"""Looks at the balance before the first look for parts that fall freely; twice as many before each further one."""

SETTLED = 1e-4
"""The last solve moves nothing farther than this share of the way gone: small forces may yet bend a large body."""

SHRINKING = 0.5
"""Where forces do not fall, solves go on as long as each moves everything by less than this share of the last way."""

FINE_STRAIN = 1e-3
"""Share of a distance between centres that links stretch or slip by in one step of the way to where a solve leads."""

FAR = 1e30
"""Farther than anything goes [m]."""

LONGEST_STRAIN = 0.2
"""A solve goes this share of a distance between centres at most: beyond, normals turn too far for it to be right."""


@dataclass(frozen=True)
class Equilibrium:
    """What a search for equilibrium ended with.

    Attributes
    ----------
    reached : bool
        Whether the unbalanced ratio came below the tolerance.
    unbalanced_ratio : float
        See `balance` [-].
    steps : int
        Relaxation steps.
    rounds : int
        Equilibria on the way, one more than the times that bonds broke.
    broken : (k,) int64
        Bonds that broke, in order of their rounds.
    solves : int
        Solves of the elastic state before them.
    seconds : float
    reason : str
        Why it was not reached; empty where it was.
    """

    reached: bool
    unbalanced_ratio: float
    steps: int
    rounds: int
    broken: NDArray[np.int64]
    solves: int
    seconds: float
    reason: str = ""


def find_equilibrium(
    simulation: ParticleSimulation,
    *,
    tolerance: float = 1e-5,
    most_steps: int = 1_000_000,
    solve: bool = True,
    breaking: bool = True,
    share: float = SHARE,
    progress: Callable[[int, float], None] | None = None,
) -> Equilibrium:
    """Bring a simulation to rest under its gravity and applied forces; its time stands still.

    Parameters
    ----------
    simulation : ParticleSimulation
        Held freedoms do not move, whatever their velocity; walls neither, unless driven by a servo.
    tolerance : float
        Unbalanced ratio, see `balance` [-].
    most_steps : int
    solve : bool
        Start from the elastic state.
    breaking : bool
        Let overstressed bonds break in equilibrium; else they hold whatever they bear.
    share : float
        0 to 1: which bonds break together, see `SHARE`.
    progress : callable, optional
        Is told the steps and the unbalanced ratio now and then.
    """
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise InputError("tolerance", "no balance is that good", "Give 1e-5, for instance", value=tolerance)
    if not 0.0 <= share <= 1.0:
        raise InputError("share", "this is no share", "Give 0 to 1", value=share)
    start = time.perf_counter()
    search = _Search(simulation)
    with search.standing_still():
        solves = search.solve_elastic_state(tolerance) if solve else 0
        broken: list[NDArray[np.int64]] = []
        rounds = 1
        reason = search.relax(tolerance, most_steps, progress)
        while not reason and breaking:
            new = search.break_bonds(share)
            if new is None:
                break
            broken.append(new)
            rounds += 1
            reason = search.relax(tolerance, most_steps, progress)
        ratio = balance(simulation)
    return Equilibrium(
        not reason, ratio, search.steps, rounds, np.concatenate([np.empty(0, np.int64), *broken]), solves,
        time.perf_counter() - start, reason,
    )  # fmt: skip


def displace(simulation: ParticleSimulation, motion: Floats) -> None:
    """Move everything by a motion (n, d + s) [m, rad], in the order of the assembly; no time passes, no bond breaks.

    The laws add up their springs on a straight way, for instance to a state that was solved for. Everything is at rest
    in the end; held freedoms keep their velocities for the motion that follows. Held bodies are moved too.
    """
    search = _Search(simulation)
    with search.standing_still():
        search.go(motion[simulation.arrays.ids], touching_links(simulation))
        # the forces of where everything is now
        search.balanced(math.inf)


def balance(simulation: ParticleSimulation) -> float:
    """Unbalanced ratio of the last step [-]: root mean square of the resultants of free particles, over a force.

    That force is the mean normal force of the contacts, or the root mean square of the loads where that is more: a
    beam that is bent across carries its load without normal forces.
    """
    s = simulation
    d = s.dimension
    free = ~s.assembly.held[:, :d].all(axis=1)
    if not free.any():
        return 0.0
    unbalanced = math.sqrt(float(s.sums[:, motion.UNBALANCED].sum()) / int(free.sum()))
    load = s.assembly.applied[free, :d] + s.assembly.mass[free, None] * s.assembly.gravity
    force = math.sqrt(float((load**2).sum()) / len(load))
    contacts = float(s.sums[:, motion.CONTACTS].sum())
    if contacts > 0.0:
        force = max(force, float(s.sums[:, motion.THRUST].sum()) / contacts)
    return unbalanced / force if force > 0.0 else (math.inf if unbalanced > 0.0 else 0.0)


class _Search:
    """The relaxation kernel and its arrays, by row."""

    def __init__(self, simulation: ParticleSimulation) -> None:
        self.simulation = s = simulation
        self.kernel = s.kernel(s.features.relaxing())
        self.steps = 0
        self.damping = 0.0
        self.old_force = np.zeros((s.assembly.particles, s.assembly.held.shape[1]))
        self.still = np.zeros(s.assembly.particles)
        self.inverse = (self.still, self.still)
        self.searches = -1

    def standing_still(self) -> _Standstill:
        """Particles and walls have no velocity of their own while equilibrium is sought."""
        return _Standstill(self.simulation)

    def _held(self) -> NDArray[np.bool_]:
        s = self.simulation
        return np.asarray(s.assembly.held[s.arrays.ids])

    def _scale_inertia(self) -> None:
        """Inertia for a step of one; every listed pair counts as touching."""
        s = self.simulation
        positions = np.ascontiguousarray(s.now[:, s.columns.position])
        network = build_network(positions, current_links(s), current_springs(s))
        mass, inertia = scaled_inertia(network, self._held())
        self.inverse = (1.0 / (INERTIA_MARGIN * mass), 1.0 / (INERTIA_MARGIN * inertia))
        self.searches = s.searches

    def _step(
        self, steps: int, breaking: float, inverse: tuple[Floats, Floats], ratio: float = DAMPING_RATIO
    ) -> int:
        damping = self.damping if ratio > 0.0 else 0.0
        done, self.damping = self.simulation.batch(
            self.kernel, steps, 1.0, breaking, *inverse, damping, ratio, self.old_force
        )
        return done

    def solve_elastic_state(self, tolerance: float) -> int:
        """Go to the elastic state, solve by solve; returns their number, 0 where the links alone hold nothing."""
        s = self.simulation
        if s.assembly.bond_law is None:
            return 0
        # a servo's wall answers to every step: it is left to the relaxation
        most = 1 if any(wall.servo is not None for wall in s.assembly.walls) else MOST_SOLVES
        solver, age, last, way, farthest, before = None, 0, math.inf, 0.0, math.inf, math.inf
        solves = 0
        while True:
            # one step without inertia's answer: the resultants of where everything is now
            self._step(1, math.inf, (self.still, self.still))
            ratio = balance(s)
            if solves == most or (ratio < tolerance and farthest <= SETTLED * way):
                break
            if solver is not None and not ratio <= STALE * last:
                # slender bodies: the turning of their links stretches them, which the next solve takes back
                if age == 1 and not farthest <= SHRINKING * before:
                    break
                solver = None
            try:
                if solver is None:
                    solver, age = self._solver(), 0
                load = s.force.copy()
                load[solver.held] = 0.0
                # what is joined through the faces of a cell floats, and does not turn
                if solves == 0 and s.cell is None:
                    solver.refuse_floating(load)
                motion = solver.solve(load, residual=RESIDUAL)
            except InputError:
                break
            before, farthest = farthest, self.go(motion, solver.network.links)
            solves, age, last, way = solves + 1, age + 1, ratio, way + farthest
        self._stop()
        return solves

    def _solver(self) -> NetworkSolver:
        s = self.simulation
        links = touching_links(s)
        positions = np.ascontiguousarray(s.now[:, s.columns.position])
        network = build_network(positions, links, current_springs(s))
        return NetworkSolver(network, held=self._held() | self._loose(links))

    def go(self, motion: Floats, links: Links) -> float:
        """Move by a solution, or a part of it where it is long; the farthest that any particle goes [m]."""
        s = self.simulation
        inner = links.second != RIGID
        moved = motion[:, : s.dimension]
        apart = moved[links.first]
        apart[inner] -= moved[links.second[inner]]
        strain = np.sqrt((apart**2).sum(axis=1)) / links.arms.sum(axis=1)
        motion = motion * min(1.0, LONGEST_STRAIN / max(float(strain.max(initial=0.0)), 1e-300))
        # steps with these velocities move everything there and let the laws add up their springs
        largest = min(float(strain.max(initial=0.0)), LONGEST_STRAIN)
        steps = max(1, math.ceil(largest / FINE_STRAIN))
        now = s.rows[s.phase]
        now[:, s.columns.velocity] = motion[:, : s.dimension] / steps
        now[:, s.columns.spin] = motion[:, s.dimension :] / steps
        # a body may go far and its particles stay together: then a search at the end is enough
        together = largest * float(links.arms.sum(axis=1).max(initial=0.0)) <= s.buffer
        if together:
            s.moved = -FAR
        while steps > 0:
            steps -= self._step(steps, math.inf, (self.still, self.still), 0.0)
        if together:
            s.moved = 2.0 * s.buffer
        self._stop()
        return float(np.sqrt((motion[:, : s.dimension] ** 2).sum(axis=1)).max(initial=0.0))

    def _loose(self, links: Links) -> NDArray[np.bool_]:
        """Freedoms of particles without any link: they are left to the relaxation."""
        s = self.simulation
        linked = np.zeros(s.assembly.particles, dtype=bool)
        linked[links.first] = True
        linked[links.second[links.second != RIGID]] = True
        if s.assembly.anchors is not None:
            linked[np.isin(s.arrays.ids, s.assembly.anchors.particle)] = True
        return np.broadcast_to(~linked[:, None], s.assembly.held.shape)

    def _stop(self) -> None:
        s = self.simulation
        for rows in s.rows:
            rows[:, s.columns.velocity] = 0.0
            rows[:, s.columns.spin] = 0.0

    def relax(self, tolerance: float, most_steps: int, progress: Callable[[int, float], None] | None) -> str:
        """Relax until balanced; returns why it ended before, or nothing."""
        s = self.simulation
        self.damping = 0.0
        if self.balanced(tolerance):
            return ""
        looks, look_for_fall = 0, FIRST_FALL
        while self.steps < most_steps:
            left = min(LOOK, most_steps - self.steps)
            while left > 0:
                # before the steps: where a batch of them ends is up to the clock, which no bit may depend on
                s.keep_listed()
                if self.searches != s.searches:
                    self._scale_inertia()
                done = self._step(left, math.inf, self.inverse)
                left -= done
                self.steps += done
            ratio = balance(s)
            if not math.isfinite(ratio) and not np.isfinite(s.now).all():
                raise UnstableError(
                    "the relaxation has lost a particle: forces beyond what float64 can carry",
                    "Look for particles that were pressed into one another, and for loads in the wrong unit",
                    step=s.steps,
                )
            if progress is not None:
                progress(self.steps, ratio)
            if ratio < tolerance:
                self._stop()
                return ""
            looks += 1
            if looks == look_for_fall:
                look_for_fall *= 2
                falling = falling_freely(s)
                if len(falling):
                    word = "particle falls" if len(falling) == 1 else "particles fall"
                    return f"{len(falling)} {word} freely, the first is {falling.min()}"
        return f"not balanced after {self.steps} steps"

    def balanced(self, tolerance: float) -> bool:
        """Whether everything is in balance as it stands, so that there is nothing to relax."""
        s = self.simulation
        self._stop()
        self._step(1, math.inf, (self.still, self.still))
        return balance(s) < tolerance

    def break_bonds(self, share: float) -> NDArray[np.int64] | None:
        """Break the most overstressed bonds in the present equilibrium; None where none is overstressed.

        Returns the numbers of those that are gone: of bonds that break piece by piece some may only be weaker now.
        """
        s = self.simulation
        intact = s.intact()
        # "not 1" keeps the kernel noting utilisations
        limit = max(1.0 + 1e-15, share * self._most_utilised(intact))
        if self._most_utilised(intact) < limit:
            return None
        # at rest a step changes nothing but what breaks
        self._stop()
        self._step(1, limit, (self.still, self.still))
        gone = np.flatnonzero(intact & ~s.intact())
        return gone if len(gone) or self._most_utilised(intact) < limit else None

    def _most_utilised(self, which: NDArray[np.bool_]) -> float:
        """Largest utilisation of bonds (b,) that was noted last [-]."""
        most = self.simulation.utilisation[: len(which)].max(axis=1, initial=0.0)
        return float(np.where(which, most, 0.0).max(initial=0.0))


class _Standstill:
    """Takes the velocities of held freedoms and walls away, and gives them back."""

    def __init__(self, simulation: ParticleSimulation) -> None:
        self.simulation = simulation

    def __enter__(self) -> None:
        s = self.simulation
        if s.started:
            # the way of the last step is part of what the contacts remember
            s.feel(s.kernel(s.features))
        s.order_kept = True
        s.wake_all()
        s.begin_stage(moving=False)
        self.velocities = s.velocities
        self.spins = s.spins
        for rows in s.rows:
            rows[:, s.columns.velocity] = 0.0
            rows[:, s.columns.spin] = 0.0
        self.bodies = s.walls.stop()
        self.cell = None if s.cell is None else s.cell.stop()

    def __exit__(self, *problem: object) -> None:
        s = self.simulation
        d = s.dimension
        held = s.assembly.held
        ids = s.arrays.ids
        for rows in s.rows:
            rows[:, s.columns.velocity] = np.where(held[:, :d], self.velocities, 0.0)[ids]
            rows[:, s.columns.spin] = np.where(held[:, d:], self.spins, 0.0)[ids]
        s.walls.go_on(self.bodies)
        if s.cell is not None and self.cell is not None:
            s.cell.go_on(self.cell)
        s.order_kept = False
