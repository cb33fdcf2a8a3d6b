"""The cut itself: the tool driven, its forces taken down, frames and cracks collected, resumable between frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly import Assembly
from ..io.checkpoint import Tree
from ..measure.fragments import Fragments, find_fragments
from ..particle_simulation import ParticleSimulation
from ..particle_state import state_tree
from ..run_progress import Work
from .plan import CuttingPlan, Placed
from .tool import NAME, PARTS
from .tool_forces import ToolForces

Floats = NDArray[np.float64]

SAMPLE = 0.02
"""Way of the tool between two looks, over the mean diameter."""

FEWEST, MOST = 5, 100
"""Steps between two looks."""

SLOWEST = 1e-3
"""Share of the speed at which the tool sets out."""

ENERGIES = ("tool", "gravity", "kinetic", "elastic", "friction", "damping", "broken")

COLUMNS = (
    "step", "time", "way", "speed",
    *(f"cutting_{part}" for part in PARTS), *(f"normal_{part}" for part in PARTS),
    "cutting", "normal", "pressed", "slid", "cutting_slid", "normal_slid",
    "tension_cracks", "shear_cracks", *ENERGIES, "imbalance",
)  # fmt: skip
"""Of a look: way [m] of the tool, speed [m/s], forces of the ground on the tool [N/m] against its motion and upwards by
part and in total, normal force on the face and that of contacts that slide up it, the force of these against the motion
and upwards, cracks so far, energies [J/m], imbalance of their account [-]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """What is drawn at one moment.

    Attributes
    ----------
    way : float
        Of the tool [m].
    time : float [s]
    positions : (n, 2) [m]
    velocities : (n, 2) [m/s]
    broken : (b,) bool
        Bonds that have broken.
    """

    way: float
    time: float
    positions: Floats
    velocities: Floats
    broken: NDArray[np.bool_]


class Course:
    """A cut under way.

    Parameters
    ----------
    assembly : Assembly
        With the tool as its wall `geodem.cutting.tool.NAME`.
    plan : CuttingPlan
    placed : Placed
    simulation : ParticleSimulation, optional
        At rest before the cut; made from the assembly where it is left out.
    """

    def __init__(
        self,
        assembly: Assembly,
        plan: CuttingPlan,
        placed: Placed,
        *,
        simulation: ParticleSimulation | None = None,
    ) -> None:
        if simulation is None:
            simulation = make_simulation(assembly, plan)
        self.assembly, self.plan, self.placed = assembly, plan, placed
        self.simulation = simulation
        self.rows: list[tuple[float, ...]] = []
        self.frames: list[Frame] = []
        self._ready()
        self.frames.append(self.frame())

    def _ready(self) -> None:
        s = self.simulation
        self.forces = ToolForces(s, self.plan.tool)
        way = SAMPLE * self.placed.diameter / (self.plan.speed * s.time_step)
        self.every = int(min(max(round(way), FEWEST), MOST))

    @property
    def way(self) -> float:
        """Of the tool so far [m]."""
        return float(self.simulation.walls.displacements()[self.forces.body, 0])

    @property
    def finished(self) -> bool:
        """Whether the tool has gone its whole way."""
        return self.way >= self.plan.distance

    @property
    def expected_steps(self) -> int:
        """Of the whole cut."""
        ahead = self.plan.distance + self.placed.ramp
        return math.ceil(ahead / (self.plan.speed * self.simulation.time_step))

    def work(self) -> Work:
        """Steps so far and still to come."""
        done = self.simulation.time / self.simulation.time_step
        return Work(done, max(self.expected_steps - done, 0.0))

    def speed(self) -> float:
        """That the tool shall have now [m/s]: a smooth rise over twice the time that full speed needs for the ramp."""
        ramp = self.placed.ramp
        share = min(self.simulation.time * self.plan.speed / (2.0 * ramp), 1.0) if ramp > 0.0 else 1.0
        return self.plan.speed * max(share * share * (3.0 - 2.0 * share), SLOWEST)

    def advance(self, *, looked: Callable[[tuple[float, ...]], None] | None = None) -> None:
        """Go on to the next frame; `looked` is given what every look sees, see `COLUMNS`."""
        target = len(self.frames) * self.plan.distance / self.plan.frames
        s = self.simulation
        while self.way < target:
            speed = self.speed()
            s.walls.set_velocity(NAME, np.array([speed, 0.0]))
            s.run(self.every)
            self.rows.append(self._look(speed))
            if looked is not None:
                looked(self.rows[-1])
        self.frames.append(self.frame())

    def _look(self, speed: float) -> tuple[float, ...]:
        s = self.simulation
        felt = self.forces.now()
        parts, sliding = felt.parts, felt.sliding
        total = s.wall_force(NAME)
        mode = s.record[: len(s.assembly.bonds), 0]
        e = s.energy()
        return (
            s.steps, s.time, self.way, speed, *(-parts[:, 0]), *parts[:, 1], -total[0], total[1],
            felt.pressed, felt.slid, -sliding[0], sliding[1],
            int((mode == 1).sum()), int((mode == 2).sum()),
            e.walls, e.gravity, e.kinetic, e.elastic, e.friction, e.damping + e.viscous, e.broken, e.imbalance,
        )  # fmt: skip

    def frame(self) -> Frame:
        """The present."""
        s = self.simulation
        return Frame(self.way, s.time, s.positions, s.velocities, ~s.intact())

    def columns(self) -> dict[str, Floats]:
        """All looks so far by the names of `COLUMNS`, (k,) each."""
        table = np.array(self.rows, dtype=float).reshape(-1, len(COLUMNS))
        return {name: table[:, k].copy() for k, name in enumerate(COLUMNS)}

    def fragments(self, solid_fraction: float = 1.0) -> Fragments:
        """The pieces there are now."""
        s, a = self.simulation, self.assembly
        return find_fragments(
            s.positions, a.radii, a.mass, a.bonds, s.intact(), solid_fraction=solid_fraction
        )

    # ------------------------------------------------------------------ to go on later

    def tree(self) -> Tree:
        """Everything that `resumed` needs."""
        frames = {
            "way": np.array([frame.way for frame in self.frames]),
            "time": np.array([frame.time for frame in self.frames]),
            "positions": np.stack([frame.positions for frame in self.frames]),
            "velocities": np.stack([frame.velocities for frame in self.frames]),
            "broken": np.stack([frame.broken for frame in self.frames]).astype(np.uint8),
        }
        rows = np.array(self.rows, dtype=float).reshape(-1, len(COLUMNS))
        return {"state": state_tree(self.simulation), "rows": rows, "frames": frames}

    @classmethod
    def resumed(
        cls, assembly: Assembly, plan: CuttingPlan, placed: Placed, tree: Mapping[str, Any]
    ) -> Course:
        """The cut of a tree, as it was, to the same bits.

        Raises
        ------
        InputError
            The tree does not belong to the assembly.
        """
        self = cls.__new__(cls)
        self.assembly, self.plan, self.placed = assembly, plan, placed
        self.simulation = ParticleSimulation.of_state(assembly, tree["state"], "a kept cut")
        self.rows = [tuple(row) for row in np.asarray(tree["rows"]).tolist()]
        f = tree["frames"]
        self.frames = [
            Frame(float(way), float(time), positions, velocities, broken.astype(bool))
            for way, time, positions, velocities, broken in zip(
                f["way"], f["time"], f["positions"], f["velocities"], f["broken"], strict=True
            )
        ]
        self._ready()
        return self


def make_simulation(assembly: Assembly, plan: CuttingPlan) -> ParticleSimulation:
    """A simulation with the energy account, at rest."""
    return ParticleSimulation(assembly, local_damping=plan.damping, energy=True, orientation=False)
