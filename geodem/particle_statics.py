"""Equilibrium of discs or spheres without time: what is linear is solved, the rest is relaxed with scaled masses.

1. The elastic state: one sparse solve on the bonds that are intact and the contacts that touch.
2. Adaptive viscous relaxation (`geodem.integrators.relaxation`): every particle has the inertia of its own
   stiffness, so that one step serves all; the damping follows the lowest frequency in motion. Bonds do not break on the
   way, so nothing breaks that the swing towards equilibrium, and no static load, would break.
3. In equilibrium the most overstressed bonds break, and the next equilibrium is sought, until none is overstressed.

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
from .integrators.elastic_network import solve_network
from .integrators.mass_scaling import scaled_inertia
from .integrators.network import RIGID, Links, build_network
from .particle_network import current_links, current_springs, touching_links
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


@dataclass(frozen=True)
class Equilibrium:
    """What a search for equilibrium ended with.

    Attributes
    ----------
    reached : bool
        Whether the unbalanced ratio came below the tolerance.
    unbalanced_ratio : float
        [-]
    steps : int
        Relaxation steps.
    rounds : int
        Equilibria on the way, one more than the times that bonds broke.
    broken : (k,) int64
        Bonds that broke, in order of their rounds.
    solved : bool
        Whether the elastic state was solved first.
    seconds : float
    """

    reached: bool
    unbalanced_ratio: float
    steps: int
    rounds: int
    broken: NDArray[np.int64]
    solved: bool
    seconds: float


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
        Unbalanced ratio: root mean square of the resultants over the mean contact force [-].
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
        solved = solve and search.jump_to_elastic_state()
        broken: list[NDArray[np.int64]] = []
        rounds = 1
        reached = search.relax(tolerance, most_steps, progress)
        while reached and breaking:
            new = search.break_bonds(share)
            if not len(new):
                break
            broken.append(new)
            rounds += 1
            reached = search.relax(tolerance, most_steps, progress)
        ratio = simulation.unbalanced_ratio()
    return Equilibrium(
        reached, ratio, search.steps, rounds, np.concatenate([np.empty(0, np.int64), *broken]), solved,
        time.perf_counter() - start,
    )  # fmt: skip


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

    def _step(self, steps: int, breaking: float, inverse: tuple[Floats, Floats]) -> int:
        done, self.damping = self.simulation.batch(
            self.kernel, steps, 1.0, breaking, *inverse, self.damping, DAMPING_RATIO, self.old_force
        )
        return done

    def jump_to_elastic_state(self) -> bool:
        """Solve for the elastic state and go there in one step; False where the links alone hold nothing."""
        s = self.simulation
        links = touching_links(s)
        if s.assembly.bond_law is None or not len(links.first):
            return False
        # one step without inertia's answer: the resultants of where everything is now
        self._step(1, math.inf, (self.still, self.still))
        positions = np.ascontiguousarray(s.now[:, s.columns.position])
        network = build_network(positions, links, current_springs(s))
        held = self._held() | self._loose(links)
        load = s.force.copy()
        load[held] = 0.0
        try:
            motion = solve_network(network, load, held=held)
        except InputError:
            return False
        # a step with these velocities moves everything there and lets the laws add up their springs
        velocity, spin = s.columns.velocity, s.columns.spin
        now = s.rows[s.phase]
        now[:, velocity] = motion[:, : s.dimension]
        now[:, spin] = motion[:, s.dimension :]
        self._step(1, math.inf, (self.still, self.still))
        self._stop()
        return True

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

    def relax(self, tolerance: float, most_steps: int, progress: Callable[[int, float], None] | None) -> bool:
        """Relax until balanced; False where the steps run out."""
        s = self.simulation
        self.damping = 0.0
        while self.steps < most_steps:
            if self.searches != s.searches:
                self._scale_inertia()
            left = min(LOOK, most_steps - self.steps)
            while left > 0:
                done = self._step(left, math.inf, self.inverse)
                left -= done
                self.steps += done
                if self.searches != s.searches:
                    break
            ratio = s.unbalanced_ratio()
            if not math.isfinite(ratio) and not np.isfinite(s.now).all():
                raise UnstableError(
                    "the relaxation has lost a particle: forces beyond what float64 can carry"
                )
            if progress is not None:
                progress(self.steps, ratio)
            if ratio < tolerance:
                self._stop()
                return True
        return False

    def break_bonds(self, share: float) -> NDArray[np.int64]:
        """Break the most overstressed bonds in the present equilibrium; their numbers."""
        s = self.simulation
        bonds = len(s.assembly.bonds)
        intact = s.intact()
        most = np.where(intact, s.utilisation[:bonds].max(axis=1, initial=0.0), 0.0).max(initial=0.0)
        if most < 1.0:
            return np.empty(0, dtype=np.int64)
        # at rest a step changes nothing but what breaks; "not 1" keeps the kernel noting utilisations
        limit = max(1.0 + 1e-15, share * float(most))
        self._stop()
        self._step(1, limit, (self.still, self.still))
        return np.flatnonzero(intact & ~s.intact())


class _Standstill:
    """Takes the velocities of held freedoms and walls away, and gives them back."""

    def __init__(self, simulation: ParticleSimulation) -> None:
        self.simulation = simulation

    def __enter__(self) -> None:
        s = self.simulation
        s.order_kept = True
        s.begin_stage(moving=False)
        self.velocities = s.velocities
        self.spins = s.spins
        for rows in s.rows:
            rows[:, s.columns.velocity] = 0.0
            rows[:, s.columns.spin] = 0.0
        self.bodies = s.walls.stop()

    def __exit__(self, *problem: object) -> None:
        s = self.simulation
        d = s.dimension
        held = s.assembly.held
        ids = s.arrays.ids
        for rows in s.rows:
            rows[:, s.columns.velocity] = np.where(held[:, :d], self.velocities, 0.0)[ids]
            rows[:, s.columns.spin] = np.where(held[:, d:], self.spins, 0.0)[ids]
        s.walls.go_on(self.bodies)
        s.order_kept = False
