"""Compaction in a periodic cell to a porosity, a coordination number or a pressure, then rest at zero strain rate.

As GEN of TRUBAL: Cundall (1988), Computer simulations of dense sphere assemblies, in Micromechanics of Granular
Materials, 113-123. The cell shrinks alike in all directions and carries the particles with it; contacts are made; when
there are enough of them the cell stops and the particles come to equilibrium. Contacts that only the motion made then
part, so a coordination number or a pressure is looked for in equilibrium: the cell goes on a little, or back, until it
is met.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..builders.packings import Packing, volumes
from ..errors import InputError
from ..particle_simulation import ParticleSimulation
from ..particle_statics import find_equilibrium
from .grains import Grains
from .growth import PRESSED, judged, refuse_porosity
from .sample import PreparedSample, measure_sample
from .settling import LOOK, Progress, measure_time_step, refuse_run

FAST = 5e-5
"""Strain in one step on the way, where no strain rate is given."""
SLOWER = 0.1
"""Share of the rate near the target: for the last hundredth of strain, or once most particles touch."""
NEAR = 0.01
TOUCHING = 0.75
"""Contacts on the way over those of a rigid packing of frictionless particles, from which on the cell slows down."""
ISOSTATIC = {2: 4.0, 3: 6.0}
"""Contacts of a particle in a rigid packing of frictionless particles: 2 d."""
MOST_CONTACTS = {2: 6.0, 3: 12.0}
"""Mean number of contacts that no packing of particles exceeds: Euler's formula in 2D; kissing number in 3D."""
FIRST_MOVE = 1e-3
"""Strain of the first move in the search in equilibrium."""
FINEST_MOVE = 1e-7
ROUNDS = 40
RELAXATION = 30_000
"""Most steps of one relaxation on the way."""


def compact(
    start: Packing | PreparedSample,
    grains: Grains,
    *,
    porosity: float | None = None,
    coordination: float | None = None,
    pressure: float | None = None,
    friction: float | None = 0.0,
    local_damping: float,
    global_damping: float = 0.0,
    strain_rate: float | None = None,
    tolerance: float = 1e-3,
    within: float | None = None,
    most_steps: int = 2_000_000,
    progress: Progress | None = None,
) -> PreparedSample:
    """Shrink a periodic cell with particles to one of three targets, then to equilibrium at zero strain rate.

    Parameters
    ----------
    start : Packing or PreparedSample
        Periodic: of `scatter_particles`, `random_packing`, or an earlier sample in a cell.
    grains : Grains
    porosity : float, optional
        Share of pores [-].
    coordination : float, optional
        Contacts of a particle, mean of all, in equilibrium [-].
    pressure : float, optional
        Mean stress in equilibrium, pressing where positive [Pa].
    friction : float, optional
        During the compaction [-]: 0 for a dense sample, more for a looser one; that of `grains` where it is None.
    local_damping, global_damping : float
        Cundall's coefficient [-] and the mass-proportional one [1/s], of motion relative to the cell.
    strain_rate : float, optional
        Of every direction on the way, positive [1/s]; near the target it is a tenth. A time step strains by 5e-5
        where it is left out.
    tolerance : float
        Unbalanced ratio in equilibrium [-].
    within : float, optional
        How near the target counts: 0.05 contacts, or 0.01 of the pressure. A porosity is met to rounding.
    most_steps : int
        Of motion and relaxation together.
    progress : callable, optional
        Is told the steps and the solid fraction now and then.

    Returns
    -------
    PreparedSample
        `reached` is False where the target was not met, or without equilibrium; `got` and `reason` tell more.

    Raises
    ------
    InputError
        Not one target; a target that no packing meets; a start without a periodic cell or denser than the target.
    """
    refuse_run(tolerance=tolerance, most_steps=most_steps, share=0.5)
    begun = time.perf_counter()
    used = grains.with_friction(friction)
    positions, radii, cell = _start(start)
    target = _target(porosity, coordination, pressure, within, positions.shape[1])
    simulation = _simulation(used, positions, radii, cell, local_damping, global_damping)
    run = _Compaction(simulation, strain_rate, tolerance, most_steps, progress)
    if target.name == "porosity":
        if run.porosity < target.wanted:
            raise InputError(
                "porosity", f"the start is denser already, {run.porosity:.4f}", "Begin looser, or ask for less.",
                value=target.wanted,
            )  # fmt: skip
        reason = run.to_porosity(target.wanted)
    else:
        reason = run.to_contacts(target)
    got = target.read(run)
    reached = not reason and abs(got - target.wanted) <= target.within
    return judged(
        measure_sample(
            simulation,
            used,
            porosity=run.porosity,
            method="compaction",
            target=target.name,
            wanted=target.wanted,
            got=got,
            reached=reached,
            reason=reason or "in equilibrium",
            steps=simulation.steps,
            seconds=time.perf_counter() - begun,
            seed=start.seed,
        )
    )


@dataclass(frozen=True)
class _Target:
    name: str
    wanted: float
    within: float
    read: Callable[[_Compaction], float]


def _target(
    porosity: float | None, coordination: float | None, pressure: float | None, within: float | None, d: int
) -> _Target:
    """The one that is given; raises InputError for none, several, or one that no packing meets."""
    if sum(value is not None for value in (porosity, coordination, pressure)) != 1:
        raise InputError(
            "compaction", "it has one target", "Give one of porosity, coordination and pressure."
        )
    if within is not None and not (math.isfinite(within) and within > 0.0):
        raise InputError("within", "this is no distance from a target", "Leave it out.", value=within)
    if porosity is not None:
        refuse_porosity(porosity, d)
        return _Target("porosity", porosity, within or 1e-6, lambda run: run.porosity)
    if coordination is not None:
        if not (math.isfinite(coordination) and 0.0 < coordination <= MOST_CONTACTS[d]):
            raise InputError(
                "coordination",
                f"no packing in {d}D has more than {MOST_CONTACTS[d]:g} contacts a particle, or less than 0",
                f"Give {ISOSTATIC[d] + 0.5:g}, say: without friction the least at rest is near {ISOSTATIC[d]:g}.",
                value=coordination,
            )  # fmt: skip
        return _Target("coordination", coordination, within or 0.05, lambda run: run.coordination)
    assert pressure is not None
    if not (math.isfinite(pressure) and pressure > 0.0):
        raise InputError("pressure", "nothing presses", "Give Pa, more than 0.", value=pressure)
    return _Target("pressure", pressure, (within or 0.01) * pressure, lambda run: run.pressure)


def _start(start: Packing | PreparedSample) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, radii and cell vectors."""
    if isinstance(start, PreparedSample):
        cell = start.cell
    else:
        cell = np.diag(start.box) if start.periodic else np.empty((0, len(start.box)))
    if not len(cell):
        raise InputError(
            "compaction",
            "the start has no periodic cell",
            "Make it with scatter_particles(..., periodic=True).",
        )
    return start.positions, start.radii, cell


def _simulation(
    grains: Grains,
    positions: np.ndarray,
    radii: np.ndarray,
    cell: np.ndarray,
    local_damping: float,
    global_damping: float,
) -> ParticleSimulation:
    assembly = grains.assembly(positions, radii, cell=cell)
    return ParticleSimulation(
        assembly, time_step=grains.time_step(assembly), local_damping=local_damping, global_damping=global_damping,
        orientation=False,
    )  # fmt: skip


class _Compaction:
    """A simulation whose cell is strained and stopped, and what is read off it."""

    def __init__(
        self,
        simulation: ParticleSimulation,
        strain_rate: float | None,
        tolerance: float,
        most_steps: int,
        progress: Progress | None,
    ) -> None:
        self.simulation = s = simulation
        if strain_rate is not None and not (math.isfinite(strain_rate) and strain_rate > 0.0):
            raise InputError(
                "strain_rate", "the cell has to shrink", "Give 1/s, more than 0.", value=strain_rate
            )
        self.rate = FAST / s.time_step if strain_rate is None else float(strain_rate)
        self.tolerance, self.most_steps, self.progress = tolerance, most_steps, progress
        self.solid = float(volumes(np.asarray(s.assembly.radii), s.dimension).sum())
        # the time step follows the contacts now and then
        self.measured = s.steps

    @property
    def porosity(self) -> float:
        """Share of pores in the cell now [-]."""
        cell = self.simulation.cell
        assert cell is not None
        return 1.0 - self.solid / cell.volume

    @property
    def coordination(self) -> float:
        """Contacts of a particle that press, mean of all [-]."""
        return 2.0 * self.simulation.contact_count() / self.simulation.assembly.particles

    @property
    def pressure(self) -> float:
        """Mean stress, pressing where positive [Pa]."""
        return -float(np.trace(self.simulation.stress())) / self.simulation.dimension

    def strain(self, amount: float, rate: float, enough: Callable[[], bool] | None = None) -> str:
        """Shrink every side by the factor exp(-amount), grow it where that is negative, until `enough` says so.

        Returns why it ended before, or nothing.
        """
        s = self.simulation
        steps = max(1, math.ceil(abs(amount) / (rate * s.time_step)))
        why = ""
        s.set_strain_rate(-amount / (steps * s.time_step))
        while steps > 0:
            part = min(steps, LOOK, self.most_steps - s.steps)
            if part <= 0:
                why = self._out_of_steps()
                break
            s.run(part)
            steps -= part
            if self.progress is not None:
                self.progress(s.steps, 1.0 - self.porosity)
            if enough is not None and enough():
                break
            if self.pressed() > PRESSED:
                why = f"particles are pressed into one another by more than {PRESSED:g} of their radius"
                break
        s.set_strain_rate(0.0)
        return why

    def pressed(self) -> float:
        """Mean overlap over the mean radius [-]."""
        overlap = self.simulation.contacts().overlap
        depth = overlap[overlap > 0.0]
        return float(depth.mean()) / float(self.simulation.assembly.radii.mean()) if len(depth) else 0.0

    def relax(self, most_steps: int | None = None) -> str:
        """Rest at zero strain rate; returns why there is none, or nothing."""
        s = self.simulation
        left = self.most_steps - s.steps
        if left <= 0:
            return self._out_of_steps()
        progress = self.progress
        told = None if progress is None else (lambda steps, ratio: progress(s.steps, 1.0 - self.porosity))
        found = find_equilibrium(
            s, tolerance=self.tolerance, most_steps=min(left, most_steps or left), progress=told
        )
        measure_time_step(s)
        return found.reason

    def _out_of_steps(self) -> str:
        return f"{self.most_steps:,} steps are done"

    def to_porosity(self, wanted: float) -> str:
        """Strain to a porosity, met to rounding, and relax."""
        d = self.simulation.dimension

        def way() -> float:
            return math.log((1.0 - wanted) / (1.0 - self.porosity)) / d

        why = ""
        if way() > NEAR:
            why = self.strain(way() - NEAR, self.rate)
        # the cell goes in straight steps, so a remainder is left, ever smaller
        for _ in range(4):
            if why or abs(way()) < 1e-12:
                break
            why = self.strain(way(), SLOWER * self.rate)
        return self.relax() or why

    def to_contacts(self, target: _Target) -> str:
        """Strain until the target is met on the way, relax, and go on, or back, until it is met in equilibrium."""
        d = self.simulation.dimension
        far = math.log(1.0 / (1.0 - self.porosity)) / d

        why = self.strain(far, self.rate, lambda: self.coordination >= TOUCHING * ISOSTATIC[d])
        if not why:
            why = self.strain(far, SLOWER * self.rate, lambda: target.read(self) >= target.wanted)
        if why:
            return self.relax() or why
        return self._search(target)

    def _search(self, target: _Target) -> str:
        """Meet the target in equilibrium by moves of the cell, halved between one too far and one not far enough."""
        strain, below, above, move = 0.0, -math.inf, math.inf, FIRST_MOVE
        values: dict[float, float] = {}
        why = ""
        for _ in range(ROUNDS):
            unrest = self.relax(RELAXATION)
            got = values[strain] = target.read(self)
            if abs(got - target.wanted) <= target.within and not unrest:
                return ""
            if self.simulation.steps >= self.most_steps:
                return self._out_of_steps()
            if got < target.wanted:
                below = strain
            else:
                above = strain
            if math.isinf(above):
                to, move = strain + move, 2.0 * move
            elif math.isinf(below):
                to, move = strain - move, 2.0 * move
            else:
                to = 0.5 * (below + above)
                if above - below < FINEST_MOVE:
                    break
            why = self.strain(to - strain, SLOWER * self.rate)
            if why:
                return self.relax() or why
            strain = to
        low, high = values.get(below, math.nan), values.get(above, math.nan)
        jump = f"the {target.name} goes from {low:.4g} to {high:.4g}"
        return f"no equilibrium has it: at a porosity of {self.porosity:.5f} {jump}"
