"""A site: bonded ground on its way through stages, and what is remembered of it beside the motion itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import StoppedError
from ..io.checkpoint import Tree
from ..measure.particle_energy import ParticleEnergy
from ..particle_simulation import ParticleSimulation
from .cracks import Cracks, cracks_of
from .removal import Removal
from .snapshot import bring_back, keep
from .watching import Watcher
from .weakening import Strength, set_strength

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BATCH = 100
"""Steps between two looks."""
RAMP_STEPS = 20
"""Steps between two changes of what is changed gradually."""
UNBALANCED = 6
"""Place of the unbalanced force ratio in a line of the history, see `Site.columns`."""


@dataclass(eq=False)
class Site:
    """Ground under way.

    Attributes
    ----------
    simulation : ParticleSimulation
    origin : (n0, d) [m]
        Where the particles of the scene were at the start; of all, those that are taken away later included.
    number : (n,) int64
        Of every particle now, that in the scene.
    bond : (b,) int64
        The same of every bond.
    settled : (n0, d) [m]
        From where displacements count: where they were when they had settled.
    per_gravity : (n0, d) [m]
        Ways in which the ground settled, per gravity: about what another gravity adds while nothing breaks.
    gravity : (d,) [m/s2]
        At the factor 1.
    full : Strength
        Tables at full strength.
    weak : (m,) [-]
        By what stages divided the strength of every material.
    points : dict of str to int
        Measured points: their particles in the scene.
    walls : tuple of str
        That there were at the start.
    gravity_factor, strength_factor : float
    gone : list of Cracks
        Of bonds that were taken away with their particles.
    history : list of tuples
        See `columns`.
    place : (int, float)
        What goes on: number of the stage, and the factor on trial, NaN where there is none.
    energy_removed : float [J]
        What was taken away with excavated ground.
    done : int
        Steps of a stage of motion that is under way.
    """

    simulation: ParticleSimulation
    origin: Floats
    number: Integers
    bond: Integers
    settled: Floats
    per_gravity: Floats
    gravity: Floats
    full: Strength
    weak: Floats
    points: dict[str, int]
    walls: tuple[str, ...]
    gravity_factor: float = 1.0
    strength_factor: float = 1.0
    gone: list[Cracks] = field(default_factory=list)
    history: list[tuple[float, ...]] = field(default_factory=list)
    place: tuple[int, float] = (0, math.nan)
    energy_removed: float = 0.0
    done: int = 0

    @classmethod
    def of(cls, simulation: ParticleSimulation, points: Mapping[str, int]) -> Site:
        """The site of a simulation that has not moved yet; `points`: particles that are measured, by name."""
        s = simulation
        start = s.positions
        return cls(
            simulation=s,
            origin=start,
            number=np.arange(len(start)),
            bond=np.arange(len(s.assembly.bonds)),
            settled=start.copy(),
            per_gravity=np.zeros_like(start),
            gravity=s.assembly.gravity.copy(),
            full=Strength.of(s),
            weak=np.ones(len(s.assembly.material_names)),
            points=dict(points),
            walls=tuple(wall.name for wall in s.assembly.walls),
        )

    # ------------------------------------------------------------------ what is changed

    def set_gravity(self, factor: float) -> None:
        """Gravity times a factor from now on."""
        s = self.simulation
        self.gravity_factor = factor
        s.assembly = replace(s.assembly, gravity=factor * self.gravity)
        s.wake_all()

    def set_strength(self, factor: float) -> None:
        """Strength over a factor from now on, beside what stages have done to it."""
        self.strength_factor = factor
        set_strength(self.simulation, self.full, factor * self.weak, factor)
        self.simulation.wake_all()

    def taken_away(self, removal: Removal) -> Removal:
        """Go on with what a removal has left, and remember what it took."""
        broken = cracks_of(self.simulation, self.bond)
        self.gone.append(broken.where(~np.isin(broken.bond, self.bond[removal.bonds])))
        self.simulation = removal.simulation
        self.number = self.number[removal.particles]
        self.bond = self.bond[removal.bonds]
        self.energy_removed += removal.energy
        return removal

    # ------------------------------------------------------------------ time

    def advance(self, steps: int, watcher: Watcher) -> None:
        """So many steps of true motion, with a line of the history at every look.

        Raises
        ------
        StoppedError
            The watcher said so.
        """
        while steps > 0:
            if watcher.stop_asked():
                raise StoppedError("stopped")
            done = min(steps, BATCH)
            self.simulation.run(done)
            steps -= done
            watcher.recorded(self.record(), done)

    def ramp(self, change: Callable[[float], None], steps: int, watcher: Watcher) -> None:
        """Steps during which `change` is called with shares growing to 1."""
        parts, recorded = max(1, round(steps / RAMP_STEPS)), 0
        for k in range(parts):
            if watcher.stop_asked():
                raise StoppedError("stopped")
            change((k + 1) / parts)
            self.simulation.run(RAMP_STEPS)
            if (k + 1) % (BATCH // RAMP_STEPS) == 0 or k + 1 == parts:
                watcher.recorded(self.record(), (k + 1 - recorded) * RAMP_STEPS)
                recorded = k + 1

    # ------------------------------------------------------------------ what is read

    @property
    def diameter(self) -> float:
        """Mean diameter of the particles [m]."""
        return 2.0 * float(self.simulation.assembly.radii.mean())

    def displacement(self, since: Floats) -> Floats:
        """Ways (n, d) [m] of the particles since they were at `since` (n0, d)."""
        return np.asarray(self.simulation.positions - since[self.number])

    def positions_of_all(self) -> Floats:
        """Places (n0, d) [m] of all particles of the scene; NaN of those that were taken away."""
        found = np.full_like(self.origin, np.nan)
        found[self.number] = self.simulation.positions
        return found

    def cracks(self) -> Cracks:
        """Every bond that broke so far, with those that were taken away later, in the order of time."""
        return Cracks.joined([*self.gone, cracks_of(self.simulation, self.bond)])

    def at_points(self) -> dict[str, Floats]:
        """Displacement (d,) [m] of every measured point since the start; NaN once it was taken away."""
        where = self.positions_of_all()
        return {name: where[k] - self.origin[k] for name, k in self.points.items()}

    def wall_forces(self) -> dict[str, Floats]:
        """Force (d,) [N] of the particles on every wall in the last step; NaN of walls that were taken away."""
        s = self.simulation
        forces = dict(zip(s.walls.names, s.walls.forces(), strict=True))
        return {name: forces.get(name, np.full(s.dimension, np.nan)) for name in self.walls}

    def columns(self) -> tuple[str, ...]:
        """Names with units of what a line of the history holds."""
        s = self.simulation
        d = s.dimension
        deep = "" if d == 3 else "/m"
        axes = "xyz"[:d]
        return (
            "stage [-]", "factor on trial [-]", "step [-]", "time [s]", "gravity factor [-]", "strength factor [-]",
            "unbalanced force ratio [-]", "cracks in tension [-]", "cracks in shear [-]",
            *(f"displacement of {name}, {axis} [m]" for name in self.points for axis in axes),
            *(f"force on {name}, {axis} [N{deep}]" for name in self.walls for axis in axes),
            *(f"energy account, {term} [J{deep}]" for term in ParticleEnergy._fields),
        )  # fmt: skip

    def record(self) -> tuple[float, ...]:
        """One more line of the history."""
        s = self.simulation
        mode = s.record[: len(s.assembly.bonds), 0]
        gone = [cracks.mode for cracks in self.gone]
        # numbers as they come back from what is kept, so that a line is the same whenever it is written
        modes = [float((mode == k).sum()) + sum(float((m == k).sum()) for m in gone) for k in (1, 2)]
        energy = s.energy() if s.features.energy else [math.nan] * len(ParticleEnergy._fields)
        self.history.append(
            (
                float(self.place[0]), self.place[1], float(s.steps), s.time, self.gravity_factor,
                self.strength_factor, s.unbalanced_ratio(), *modes,
                *(float(part) for way in self.at_points().values() for part in way),
                *(float(part) for force in self.wall_forces().values() for part in force),
                *(float(term) for term in energy),
            )
        )  # fmt: skip
        return self.history[-1]

    def take_over(self, other: Site) -> None:
        """Become another site."""
        for part in fields(Site):
            setattr(self, part.name, getattr(other, part.name))

    # ------------------------------------------------------------------ kept and brought back

    def tree(self) -> Tree:
        """Everything, as a checkpoint tree of copies."""
        return {
            "simulation": keep(self.simulation),
            "origin": self.origin.copy(),
            "number": self.number.copy(),
            "bond": self.bond.copy(),
            "settled": self.settled.copy(),
            "per_gravity": self.per_gravity.copy(),
            "gravity": self.gravity.copy(),
            "weak": self.weak.copy(),
            "full": {name: table.copy() for name, table in self.full._asdict().items()},
            "history": table_of(self.history),
            "gone": {str(k): cracks.tree() for k, cracks in enumerate(self.gone)},
            "plain": {
                "points": self.points,
                "walls": list(self.walls),
                "gravity_factor": self.gravity_factor,
                "strength_factor": self.strength_factor,
                "place": [self.place[0], None if math.isnan(self.place[1]) else self.place[1]],
                "energy_removed": self.energy_removed,
                "done": self.done,
                "gone": len(self.gone),
            },
        }

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any]) -> Site:
        """The site of a tree; the tree can be used again."""
        plain = tree["plain"]
        stage, factor = plain["place"]
        return cls(
            simulation=bring_back(tree["simulation"]),
            origin=tree["origin"].copy(),
            number=tree["number"].copy(),
            bond=tree["bond"].copy(),
            settled=tree["settled"].copy(),
            per_gravity=tree["per_gravity"].copy(),
            gravity=tree["gravity"].copy(),
            full=Strength(**{name: table.copy() for name, table in tree["full"].items()}),
            weak=tree["weak"].copy(),
            points=dict(plain["points"]),
            walls=tuple(plain["walls"]),
            gravity_factor=plain["gravity_factor"],
            strength_factor=plain["strength_factor"],
            gone=[Cracks.from_tree(tree["gone"][str(k)]) for k in range(plain["gone"])],
            history=[tuple(row) for row in tree["history"].tolist()],
            place=(int(stage), math.nan if factor is None else factor),
            energy_removed=plain["energy_removed"],
            done=plain["done"],
        )


def table_of(rows: list[tuple[float, ...]]) -> Floats:
    """Lines of a history as an array, also where there is none."""
    return np.array(rows, dtype=np.float64) if rows else np.empty((0, 1))
