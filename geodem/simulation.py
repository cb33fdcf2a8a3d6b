"""Simulation: a model, its state, and the only object whose behaviour unfolds over time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._jit import ThreadPilot, add_compile_seconds, compile_kernel
from .errors import UnstableError
from .integrators.direct_solve import solve_elastic, stiffness
from .integrators.relaxation import scaled_mass
from .kernels import stress_particles, supports
from .laws import GROUND_LAWS
from .laws.support import bar
from .measure.energy import EnergyAccount, elastic_energy, links_energy
from .model import Model, make_links
from .state import State

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]

CHUNK = 128
SERIAL_LIMIT = 400
"""Below this many particles the serial kernel wins: a parallel region costs more than its work."""

KEEP = 1000
"""Steps between two states that are kept in memory."""

DAMPING_RATIO = 0.5
"""Share of critical damping of the lowest frequency in motion; 0.3 to 0.7 need about the same number of steps."""


class Measures(NamedTuple):
    """What a stretch of steps ended with."""

    unbalanced_ratio: float  # root of the sum of squares of unbalanced forces over that of the weights [-]
    mean_displacement: float  # of what moves, see `Simulation.mean_size` [m]
    moving_share: float  # of the section's area, see `Simulation.moving_share` [-]


@dataclass
class ElasticState:
    """The elastic state under gravity: where every trial begins."""

    displacement: Floats  # (n, 2) [m], from the unloaded state
    stress: Floats  # (s, 3) [Pa]
    mean_displacement: float  # [m]
    support: Floats | None = None  # (k, 3) of links, zero where left out


class Simulation:
    """Stress-carrying particles that move to equilibrium, or do not.

    All results are quasi-static: inertia is scaled, so velocities and times have no physical meaning.

    Parameters
    ----------
    model : Model
    plastic : bool
        Compile the yield condition in.
    energy : bool
        Keep the energy account (plastic work, work of damping).
    damping_ratio : float
        Damping over critical of the lowest frequency in motion [-].
    elastic : ElasticState, optional
        The elastic state, where a checkpoint holds it; solved if left out.
    kept : (n, 2) [N/m], optional
        Forces beside weight and loads that `set_kept` takes away: those of ground that was excavated.

    Attributes
    ----------
    last_good : State
        A copy of the state at the start, and of every thousandth step or so that was finite.
    """

    def __init__(
        self,
        model: Model,
        *,
        plastic: bool = True,
        energy: bool = True,
        damping_ratio: float = DAMPING_RATIO,
        elastic: ElasticState | None = None,
        kept: Floats | None = None,
    ) -> None:
        self.model = model
        self.law = GROUND_LAWS[model.law]
        self.plastic = plastic
        self.damping_ratio = damping_ratio
        self.table = model.parameter_table()
        matrix = stiffness(model)
        self.mass = scaled_mass(matrix, model.held)
        self.inverse_mass = np.where(model.held, 0.0, 1.0 / self.mass)
        self.gravity_factor = 1.0
        self.load_factor = 1.0
        self.kept = np.zeros_like(model.load) if kept is None else kept
        self.external = model.weight + model.load + self.kept
        sizes = [np.sqrt((part[~model.held] ** 2).sum()) for part in (model.weight, model.load, self.kept)]
        self.force_scale = float(max(sizes)) or 1.0
        self.links = make_links([], np.zeros((0, 3)), model.particles) if model.links is None else model.links
        self._pushed = np.zeros((model.particles if self.links.number else 0, 2))
        self.elastic = self.solve(self.external, matrix) if elastic is None else elastic
        self.matrix = matrix
        chunks = (model.particles + CHUNK - 1) // CHUNK
        self._sums = np.zeros((chunks, 4))
        self._kernel = self._compile(energy)
        self._pilot = ThreadPilot()
        self.state = State.at_rest(model)
        self.begin()

    def _compile(self, energy: bool) -> ModuleType:
        supported = self.links.number > 0
        functions = [
            self.law.update_stress,
            self.law.elastic_energy,
            stress_particles.deform,
            *([bar.update_force, supports.stretch, supports.hold] if supported else []),
            stress_particles.move,
            stress_particles.relax,
        ]
        constants = {
            **self.law.features(self.model.parameters, plastic=self.plastic),
            "ONE_MATERIAL": len(self.model.parameters) == 1,
            "ENERGY": energy,
            "SUPPORTED": supported,
            "CHUNK": CHUNK,
        }
        return compile_kernel(
            functions,
            constants,
            parallel=self.model.particles > SERIAL_LIMIT,
            entries=[stress_particles.relax],
        )

    def solve(self, external: Floats, matrix: csr_matrix | None = None) -> ElasticState:
        """The elastic state under forces (n, 2) [N/m], by a direct sparse solve or conjugate gradients."""
        displacement, stress = solve_elastic(self.model, external, matrix=matrix)
        return ElasticState(displacement, stress, self.mean_size(displacement))

    def begin(
        self,
        stress: Floats | None = None,
        *,
        displacement: Floats | None = None,
        plastic_shear_strain: Floats | None = None,
        support: Floats | None = None,
    ) -> None:
        """Start again at rest, with a new energy account.

        Parameters
        ----------
        stress : (s, 3) [Pa], optional
            The elastic state's if left out.
        displacement : (n, 2) [m], optional
        plastic_shear_strain : (s,) [-], optional
            Zero if left out; given, they are continued.
        support : (k, 3), optional
            Of the links; the elastic state's if left out.
        """
        state = State.at_rest(self.model)
        state.stress[:, :3] = self.elastic.stress if stress is None else stress
        if displacement is not None:
            state.displacement[:] = displacement
        if plastic_shear_strain is not None:
            state.stress[:, 3] = plastic_shear_strain
        support = self.elastic.support if support is None else support
        if support is not None:
            state.support[:] = support
        state.start_work = float((self.external * state.displacement).sum())
        state.start_elastic = self._stored(state)
        state.start_links = float(state.support[:, 2].sum())
        self.state = state
        self._kept_at, self.last_good = 0, state.copy()

    def _stored(self, state: State) -> float:
        """Elastic energy of ground and links [J/m]."""
        return elastic_energy(self.model, self.law, state.stress) + links_energy(self.links, state.support)

    def set_kept(self, kept: Floats) -> None:
        """Forces (n, 2) [N/m] beside weight and loads from now on: of ground that was excavated, of an air pressure."""
        self.kept = kept
        self._set_external()

    def set_gravity(self, factor: float) -> None:
        """Multiply gravity (and its pseudo-static part) by `factor`; loads stay."""
        self.gravity_factor = factor
        self._set_external()

    def set_load(self, factor: float) -> None:
        """Multiply the loads by `factor`; gravity stays."""
        self.load_factor = factor
        self._set_external()

    def _set_external(self) -> None:
        self.external = (
            self.model.weight * self.gravity_factor + self.model.load * self.load_factor + self.kept
        )

    def set_strength(self, factor: float) -> None:
        """Divide the strength of every material by `factor`."""
        reduced = [tuple(self.law.reduced(p, factor)) for p in self.model.parameters]
        self.table = np.array(reduced, dtype=np.float64)

    def run(self, steps: int) -> Measures:
        """Advance `steps` relaxation steps.

        Raises
        ------
        UnstableError
            A force or displacement is no longer finite; `last_good` is the state of up to `KEEP` steps before.
        """
        model, state = self.model, self.state
        known = len(self._kernel.relax.overloads)
        self._pilot.choose()
        start = time.perf_counter()
        state.damping, unbalanced, damped = self._kernel.relax(
            steps, self.damping_ratio, state.damping, self.external, self.inverse_mass,
            *model.point_gradient, model.point_area, model.point_material, self.table,
            *model.particle_gradient,
            state.velocity, state.displacement, state.force, state.stress, state.dissipation, self._sums,
            *self.links.gradient, self.links.table, *self.links.particle_gradient, state.support, self._pushed,
        )  # fmt: skip
        seconds = time.perf_counter() - start
        if len(self._kernel.relax.overloads) > known:
            add_compile_seconds(seconds)
        else:
            self._pilot.learn(seconds / steps)
        state.steps += steps
        state.damping_work += damped
        displacement = self.mean_size(state.displacement)
        if not (np.isfinite(unbalanced) and np.isfinite(displacement)):
            worst = int(np.argmax(~np.isfinite(state.force).all(axis=1)))
            raise UnstableError(
                "the force on it is not finite",
                "Look for a stiffness, a strength or a load in the wrong unit; last_good holds the state before",
                step=state.steps,
                particle=worst,
                place=tuple(map(float, self.model.positions[worst])),
                last_good=self.last_good.steps,
            )
        self._kept_at += steps
        if self._kept_at >= KEEP:
            self._kept_at, self.last_good = 0, state.copy()
        return Measures(
            float(unbalanced) / self.force_scale, displacement, self.moving_share(state.displacement)
        )

    def relax(self, tolerance: float = 1e-6, max_steps: int = 100_000, batch: int = 50) -> Measures:
        """Run until the unbalanced force ratio is below `tolerance`, or `max_steps` are done."""
        measures = self.run(batch)
        while measures.unbalanced_ratio > tolerance and self.state.steps < max_steps:
            measures = self.run(batch)
        return measures

    def mean_size(self, displacement: Floats) -> float:
        """Mean of |displacement| (n, 2) over what moves [m]: sum of A u^2 over sum of A u.

        Weighted by itself, so that a slab that falls off a large section counts as what it is: a plain mean over
        the section would hardly notice it.
        """
        size = np.sqrt((displacement**2).sum(axis=1))
        moved = float((size * self.model.particle_area).sum())
        return float((size**2 * self.model.particle_area).sum()) / moved if moved > 0.0 else 0.0

    def moving_share(self, displacement: Floats) -> float:
        """Share of the section's area that moves [-]: (sum of A u)^2 over (sum of A) (sum of A u^2)."""
        size = np.sqrt((displacement**2).sum(axis=1))
        area = self.model.particle_area
        square = float((size**2 * area).sum())
        return float((size * area).sum()) ** 2 / (float(area.sum()) * square) if square > 0.0 else 1.0

    def particle_stress(self) -> Floats:
        """Stress and plastic shear strain of every particle (n, 4): the area-weighted mean of its stress points."""
        return self.model.particle_mean(self.state.stress)

    def energy(self) -> EnergyAccount:
        """Where the work of gravity and loads went since `begin` (constant external forces in between)."""
        state, model = self.state, self.model
        return EnergyAccount(
            external_work=float((self.external * state.displacement).sum()) - state.start_work,
            elastic=self._stored(state) - state.start_elastic,
            plastic=float((state.dissipation * model.point_area).sum())
            + float(state.support[:, 2].sum())
            - state.start_links,
            damping=state.damping_work,
            kinetic=float(0.5 * (self.mass * state.velocity**2)[~model.held].sum()),
        )
