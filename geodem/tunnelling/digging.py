"""Dig, relax and support in the order of a plan; every increment ends at rest, or the opening has collapsed.

Convergence-confinement: the forces that the excavated ground exerted on the wall are kept when it is taken out, and
relaxed by a factor from one to zero (M. Panet & A. Guenot 1982, Tunnelling '82, IMM, London: 197). What is installed
on the way bears what comes after it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..integrators.direct_solve import solve_elastic
from ..model import make_links
from ..simulation import ElasticState, Simulation
from ..stability.criteria import Criteria
from .forecast import PRESSURE_WAY, increments_of
from .ground import Standing, TunnelGround, internal_forces, standing
from .initial import InitialState, initial_state, loaded
from .measure import mean_pressure, wall_length, wall_normals
from .plan import INCREMENTS, Plan, Stage
from .progress import Collapse, Progress
from .reading import read_row
from .supports import FAR_NAME, Built, build_bolts, build_far, build_lining

Floats = NDArray[np.float64]

DAMPING_RATIO = 1.0
"""Critical: an increment that overshoots yields ground that a slow excavation leaves elastic. The hole of P16 moves by
29.1 mm at half of it with 20 increments and 28.3 mm with 80; at critical by 27.9 mm with 20 and with 40."""
COLLAPSE_WIDTH = 0.01
"""Width of the bracket of a collapse, in share of the kept forces."""
LAST_RATIO = 1e-6
"""Unbalanced force ratio of the last increment of a stage; the others end at that of the criteria."""


@dataclass
class Scene:
    """The standing ground with its supports, ready to be relaxed."""

    standing: Standing
    simulation: Simulation
    criteria: Criteria


class Digging:
    """A plan being carried out.

    Parameters
    ----------
    ground : TunnelGround
        Of `make_tunnel_ground`.
    plan : Plan
    increments : int
        In which all of the kept forces are relaxed.
    progress : Progress, optional
        To go on from.
    on_increment : callable, optional
        Called after every increment; what it raises stops the work there.
    """

    def __init__(
        self,
        ground: TunnelGround,
        plan: Plan,
        *,
        increments: int = INCREMENTS,
        progress: Progress | None = None,
        on_increment: Callable[[Digging], None] | None = None,
    ) -> None:
        self.initial: InitialState = initial_state(ground, plan.initial)
        self.ground = loaded(ground, self.initial)
        self.plan = plan
        self.increments = increments
        self.on_increment = on_increment or (lambda digging: None)
        self.on_row: Callable[[dict[str, Any]], None] = lambda row: None  # is given every new row
        self.built: list[Built] = []
        model = ground.model
        stress = np.concatenate([self.initial.stress, np.zeros((model.stress_points, 1))], axis=1)
        self.progress = Progress(stress, np.zeros_like(model.positions), np.zeros((0, 2)), [])
        if ground.far_sides:
            centre = np.mean([o.centre for o in plan.openings], axis=0)
            self._add(build_far(self.ground, centre))
        if progress is not None:
            self._take_up(progress)

    def _take_up(self, progress: Progress) -> None:
        """Build again what stands, and go on from there."""
        dug: list[int] = []
        names = [name for name in progress.installed if name != FAR_NAME]
        for stage in self.plan.stages[: progress.stage + (progress.increment > 0)]:
            dug += [self.plan.opening(name) for name in stage.excavate]
            for name in stage.install:
                if name in names:
                    self._build(name, dug)
        self.progress = progress

    # --- building -----------------------------------------------------------------------------------------------

    @property
    def dug(self) -> list[int]:
        """Openings that are out."""
        return list(self.progress.shares)

    def _add(self, built: Built) -> None:
        self.built.append(built)
        now = self.progress
        now.installed.append(built.name)
        now.support.append(np.zeros((len(built.rows), 3)))
        now.nodes = np.concatenate([now.nodes, np.zeros((len(built.nodes), 2))])

    def _build(self, name: str, dug: list[int]) -> None:
        for lining in self.plan.linings:
            if lining.name == name:
                number = self.plan.opening(lining.opening)
                self._add(build_lining(self.ground, lining, self.ground.wall(number, dug)))
        for bolts in self.plan.bolts:
            if bolts.name == name:
                first = self.ground.model.particles + sum(len(b.nodes) for b in self.built)
                self._add(build_bolts(self.ground, bolts, dug, first, self.wall_spacing(dug)))

    def wall_spacing(self, dug: list[int]) -> float:
        """Mean distance of neighbours on the walls [m]."""
        walls = [self.ground.wall(number, dug) for number in dug]
        edges = sum(len(wall) for wall in walls)
        return sum(wall_length(self.ground.model.positions, wall) for wall in walls) / max(edges, 1)

    def _standing(self) -> Standing:
        rows = [row for built in self.built for row in built.rows]
        bare = standing(self.ground, self.dug)
        if not rows:
            return bare
        nodes = np.concatenate([built.nodes for built in self.built])
        count = self.ground.model.particles
        number = np.concatenate(
            [bare.own(np.arange(count), count), len(bare.particle) + np.arange(len(nodes))]
        )
        links = make_links(
            [(number[list(row.particles)].tolist(), row.vectors) for row in rows],
            np.array([[row.stiffness, row.lower, row.upper] for row in rows]),
            len(bare.particle) + len(nodes),
        )
        return standing(self.ground, self.dug, nodes, links)

    def external(self, stands: Standing, shares: dict[int, float] | None = None) -> Floats:
        """Kept forces and pressures on the walls, on the model's particles (n, 2) [N/m].

        `shares`: of the kept forces per opening; as they are now where left out.
        """
        now = self.progress
        shares = now.shares if shares is None else shares
        whole = np.zeros_like(self.ground.model.positions)
        for number, force in now.kept.items():
            whole += shares[number] * force
            if now.pressures[number]:
                wall = self.ground.wall(number, self.dug)
                particles, normals = wall_normals(self.ground.model.positions, wall)
                whole[particles] += now.pressures[number] * normals
        return self._to_model(stands, whole)

    @staticmethod
    def _to_model(stands: Standing, whole: Floats) -> Floats:
        force = np.zeros((stands.model.particles, 2))
        force[: len(stands.particle)] = whole[stands.particle]
        return force

    def _support_state(self) -> Floats:
        return np.concatenate([np.zeros((0, 3)), *self.progress.support])

    def _excavate(self, number: int) -> None:
        """Take an opening out; what its ground exerted stays."""
        now = self.progress
        now.shares[number], now.pressures[number] = 1.0, 0.0
        now.kept[number] = np.zeros_like(self.ground.model.positions)
        for built in self.built:
            self._refuse_lost(built)
        stands = self._standing()
        model = stands.model
        missing = internal_forces(model, now.stress[stands.point]) - model.weight - model.load
        missing -= self.external(stands)
        if model.links is not None:
            missing += self._link_forces(stands)
        missing[model.held] = 0.0
        now.kept[number][stands.particle] = missing[: len(stands.particle)]

    def _refuse_lost(self, built: Built) -> None:
        from ..errors import InputError

        stands = standing(self.ground, self.dug)
        here = np.isin(np.arange(self.ground.model.particles), stands.particle)
        for row in built.rows:
            if any(p < len(here) and not here[p] for p in row.particles):
                raise InputError(
                    f"support {built.name!r}", "a later excavation takes away the ground that it stands on",
                    "Install it after that excavation, or on the part of the wall that stays.",
                )  # fmt: skip

    def _link_forces(self, stands: Standing) -> Floats:
        links = stands.model.links
        assert links is not None
        force = self._support_state()[:, 0]
        start, index, vector = links.particle_gradient
        row = np.repeat(np.arange(stands.model.particles), np.diff(start))
        return np.stack(
            [np.bincount(row, force[index] * vector[:, k], minlength=stands.model.particles) for k in (0, 1)],
            axis=1,
        )

    # --- relaxing -----------------------------------------------------------------------------------------------

    def scene(self) -> Scene:
        """The standing ground with its supports."""
        stands = self._standing()
        model = stands.model
        now = self.progress
        full = np.zeros_like(self.ground.model.positions)
        for force in now.kept.values():
            full += force
        kept = self._to_model(stands, full)
        moved, _ = solve_elastic(model, -kept) if kept.any() else (np.zeros_like(kept), None)
        elastic = ElasticState(
            self._to_model(stands, now.displacement), now.stress[stands.point, :3], 1.0, self._support_state()
        )
        simulation = Simulation(model, energy=False, elastic=elastic, kept=kept, damping_ratio=DAMPING_RATIO)
        size = simulation.mean_size(moved)
        simulation.elastic = replace(elastic, mean_displacement=size or 1e-9)
        return Scene(stands, simulation, Criteria())

    def run(self) -> Progress:
        """Carry the plan out to its end or to the collapse of an opening."""
        now = self.progress
        while now.stage < len(self.plan.stages) and now.collapse is None:
            self.run_stage()
        return now

    def run_stage(self) -> None:
        """Carry out the stage that is next, or the rest of it."""
        now = self.progress
        stage = self.plan.stages[now.stage]
        if now.increment == 0:
            self.set_up(stage)
            if not now.rows or stage.excavate:
                self._record(stage, self.scene(), 0, 0.0, "at rest as it was")
        chosen = self.dug if stage.opening is None else [self.plan.opening(stage.opening)]
        targets = {k: now.shares[k] if stage.relax is None else 1.0 - stage.relax for k in chosen}
        pressures = {k: now.pressures[k] if stage.pressure is None else stage.pressure for k in chosen}
        if chosen and (stage.relax is not None or stage.pressure is not None):
            self._relax(stage, targets, pressures)
        if now.collapse is None:
            now.stage += 1
            now.increment = 0

    def set_up(self, stage: Stage) -> None:
        """What a stage takes out and puts in, nothing relaxed."""
        for name in stage.excavate:
            self._excavate(self.plan.opening(name))
        for name in stage.install:
            self._build(name, self.dug)

    def _relax(self, stage: Stage, targets: dict[int, float], pressures: dict[int, float]) -> None:
        now = self.progress
        scene = self.scene()
        begun = self._begun(stage, targets, pressures)
        count = increments_of(begun["way"], self.increments)
        while now.increment < count:
            at = (now.increment + 1) / count
            self._set(begun, targets, pressures, at)
            verdict, words = self._to_rest(scene, last=now.increment + 1 == count)
            if verdict == "failed":
                self._bracket(stage, scene, begun, targets, pressures, now.increment / count, at, words)
                return
            now.increment += 1
            self._keep(scene)
            self._record(stage, scene, scene.simulation.state.steps, self._ratio, words)
            self.on_increment(self)

    def _begun(self, stage: Stage, targets: dict[int, float], pressures: dict[int, float]) -> dict[str, Any]:
        """Shares and pressures at the beginning of the stage, from the plan, so that a resumed run finds them too."""
        shares: dict[int, float] = {}
        before: dict[int, float] = {}
        dug: list[int] = []
        for entry in self.plan.stages:
            for name in entry.excavate:
                number = self.plan.opening(name)
                dug.append(number)
                shares[number], before[number] = 1.0, 0.0
            if entry is stage:
                break
            chosen = dug if entry.opening is None else [self.plan.opening(entry.opening)]
            for number in chosen:
                shares[number] = shares[number] if entry.relax is None else 1.0 - entry.relax
                before[number] = before[number] if entry.pressure is None else entry.pressure
        way = max(abs(targets[k] - shares[k]) for k in targets)
        if any(pressures[k] != before[k] for k in pressures):
            way = max(way, PRESSURE_WAY)
        return {"shares": shares, "pressures": before, "way": way}

    def _set(
        self, begun: dict[str, Any], targets: dict[int, float], pressures: dict[int, float], at: float
    ) -> None:
        now = self.progress
        for k, target in targets.items():
            now.shares[k] = begun["shares"][k] + at * (target - begun["shares"][k])
            now.pressures[k] = begun["pressures"][k] + at * (pressures[k] - begun["pressures"][k])

    def _to_rest(self, scene: Scene, *, last: bool) -> tuple[str, str]:
        """Relax the forces as they are set now, from the state kept; the verdict and the rule that gave it."""
        now, simulation, stands = self.progress, scene.simulation, scene.standing
        stress = now.stress[stands.point]
        displacement = self._to_model(stands, now.displacement)
        displacement[len(stands.particle) :] = now.nodes
        simulation.begin(
            stress[:, :3], displacement=displacement, plastic_shear_strain=stress[:, 3],
            support=self._support_state(),
        )  # fmt: skip
        simulation.set_kept(self.external(stands))
        criteria = replace(scene.criteria, stable_ratio=LAST_RATIO) if last else scene.criteria
        history: list[tuple[int, float, float]] = []
        limit = criteria.max_steps(simulation.model.particles)
        while True:
            measures = simulation.run(criteria.batch)
            history.append((simulation.state.steps, measures.unbalanced_ratio, measures.mean_displacement))
            answer = criteria.judge(
                history, simulation.elastic.mean_displacement, limit, measures.moving_share
            )
            if answer is not None:
                self._ratio = measures.unbalanced_ratio
                now.steps += simulation.state.steps
                return answer

    def _keep(self, scene: Scene) -> None:
        now, state, stands = self.progress, scene.simulation.state, scene.standing
        now.stress[stands.point] = state.stress
        now.displacement[stands.particle] = state.displacement[: len(stands.particle)]
        now.nodes = state.displacement[len(stands.particle) :].copy()
        place = 0
        for k, built in enumerate(self.built):
            now.support[k] = state.support[place : place + len(built.rows)].copy()
            place += len(built.rows)

    def _bracket(
        self, stage: Stage, scene: Scene, begun: dict[str, Any], targets: dict[int, float],
        pressures: dict[int, float], stable: float, failed: float, words: str,
    ) -> None:  # fmt: skip
        """Halve the increment that did not come to rest, and keep where it collapses."""
        now = self.progress
        way = max(begun["way"], 1e-12)
        while (failed - stable) * way > COLLAPSE_WIDTH:
            middle = 0.5 * (stable + failed)
            self._set(begun, targets, pressures, middle)
            verdict, found = self._to_rest(scene, last=False)
            if verdict == "failed":
                failed, words = middle, found
            else:
                stable = middle
                self._keep(scene)
                self._record(stage, scene, scene.simulation.state.steps, self._ratio, found)
        number = max(targets, key=lambda k: abs(targets[k] - begun["shares"][k]))
        ends = []
        for at in (failed, stable):
            self._set(begun, targets, pressures, at)
            ends.append((1.0 - now.shares[number], self._pressure(number)))
        (failed_share, failed_pressure), (stable_share, stable_pressure) = ends
        now.collapse = Collapse(
            stage.name, self.plan.openings[number].name, stable_share, failed_share, stable_pressure,
            failed_pressure, words,
        )  # fmt: skip

    def _pressure(self, number: int) -> float:
        """Mean pressure of kept forces and air on a wall [Pa], supports not counted."""
        now = self.progress
        wall = self.ground.wall(number, self.dug)
        return (
            mean_pressure(self.ground.model.positions, now.shares[number] * now.kept[number], wall)
            + now.pressures[number]
        )

    def _record(self, stage: Stage, scene: Scene, steps: int, ratio: float, words: str) -> None:
        for number in self.dug:
            wall = self.ground.wall(number, self.dug)
            if len(wall):
                ended = {"steps": steps, "unbalanced": ratio, "criterion": words}
                self.progress.rows.append(
                    {**self._place(stage, number), **read_row(self, scene.standing, number, wall), **ended}
                )
                self.on_row(self.progress.rows[-1])

    def _place(self, stage: Stage, number: int) -> dict[str, Any]:
        return {
            "stage": stage.name,
            "opening": self.plan.openings[number].name,
            "relaxed": 1.0 - self.progress.shares[number],
            "pressure": self._pressure(number),
        }
