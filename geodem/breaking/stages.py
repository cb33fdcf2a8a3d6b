"""Stages of a site: settle, excavate, change gravity or strength, move or open a wall, run; one after the other.

What a stage changes it changes gradually, in a number of steps that waves need to cross the ground a few times, and
then lets the ground come to rest, where the stage is not one of motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .criteria import Criteria
from .removal import remove_particles
from .search import SearchPlan
from .site import BATCH, Site
from .walls import wall_rows, without_walls
from .watching import Watcher

Floats = NDArray[np.float64]
Where = Callable[[Site], NDArray[np.bool_]]
"""Which particles (n,) of a site."""


@dataclass(frozen=True)
class Settle:
    """Bring gravity from nothing to its full size, and the ground to rest; displacements count from then on.

    Attributes
    ----------
    name : str
    factor : float
        Of gravity [-].
    from_nothing : bool
        False: gravity is on already, as after an initial stress.
    criteria : Criteria
    """

    name: str
    factor: float = 1.0
    from_nothing: bool = True
    criteria: Criteria = field(default_factory=Criteria)
    kind: ClassVar[str] = "settle"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        first = 0.0 if self.from_nothing else 1.0
        if first != self.factor:
            site.ramp(
                lambda share: site.set_gravity(first + share * (self.factor - first)),
                _ramp(self.criteria, site),
                watcher,
            )
        facts = {"gravity_factor": self.factor, **to_rest(site, self.criteria, watcher)}
        site.settled = _where_now(site)
        if self.from_nothing:
            site.per_gravity = (site.settled - site.origin) / self.factor
        return facts


@dataclass(frozen=True)
class Gravity:
    """Gravity times a factor, reached gradually; then to rest."""

    name: str
    factor: float
    criteria: Criteria = field(default_factory=Criteria)
    kind: ClassVar[str] = "gravity"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        first = site.gravity_factor
        site.ramp(
            lambda share: site.set_gravity(first + share * (self.factor - first)),
            _ramp(self.criteria, site),
            watcher,
        )
        return {"gravity_factor": self.factor, **to_rest(site, self.criteria, watcher)}


@dataclass(frozen=True)
class ChangeStrength:
    """The strength of some materials over a factor, reached gradually; then to rest.

    Attributes
    ----------
    name : str
    materials : tuple of int
        Their numbers in the assembly; all where it is empty.
    factor : float
        [-]; below 1: stronger.
    criteria : Criteria
    """

    name: str
    materials: tuple[int, ...]
    factor: float
    criteria: Criteria = field(default_factory=Criteria)
    kind: ClassVar[str] = "strength"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        which = np.isin(np.arange(len(site.weak)), self.materials or range(len(site.weak)))
        before = site.weak

        def change(share: float) -> None:
            site.weak = np.where(which, before * (1.0 + share * (self.factor - 1.0)), before)
            site.set_strength(site.strength_factor)

        site.ramp(change, _ramp(self.criteria, site), watcher)
        return {"strength_divided_by": self.factor, **to_rest(site, self.criteria, watcher)}


@dataclass(frozen=True)
class Excavate:
    """Take particles away, and what they bore in several shares.

    Attributes
    ----------
    name : str
    where : callable
        Which particles.
    shares : int
        Steps in which the forces of what was taken away go to nothing; 1: at once.
    rest : bool
        Come to rest in the end.
    criteria : Criteria
    """

    name: str
    where: Where
    shares: int = 10
    rest: bool = True
    criteria: Criteria = field(default_factory=Criteria)
    kind: ClassVar[str] = "excavate"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result; raises InputError where nothing, or everything, would be taken away."""
        mask = self.where(site)
        if not mask.any() or mask.all():
            what = "there is nothing to take away" if not mask.any() else "nothing would be left"
            raise InputError(f"stage {self.name!r}", what, "Mend its place or its material")
        mass = float(site.simulation.assembly.mass[mask].sum())
        gone = site.taken_away(remove_particles(site.simulation, mask))
        ramp = _ramp(self.criteria, site)
        for k in range(self.shares):
            gone.face.set(site.simulation, 1.0 - (k + 1) / self.shares)
            site.advance(max(BATCH, ramp // self.shares), watcher)
        facts = {"particles_removed": int(mask.sum()), "mass_removed": mass}
        return {**facts, **(to_rest(site, self.criteria, watcher) if self.rest else {})}


@dataclass(frozen=True)
class MoveWall:
    """Move a wall at a velocity [m/s] for a time [s]; then it stands still."""

    name: str
    wall: str
    velocity: tuple[float, ...]
    time: float
    frames_every: float | None = None
    kind: ClassVar[str] = "move-wall"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        s = site.simulation
        s.wake_all()
        s.walls.set_velocity(self.wall, np.array(self.velocity))
        _move(site, self.time, self.frames_every, watcher)
        s.walls.set_velocity(self.wall, np.zeros(s.dimension))
        way = s.walls.displacements()[s.walls.index(self.wall)]
        return {"wall_displacement_m": [float(part) for part in way]}


@dataclass(frozen=True)
class RemoveWalls:
    """Take walls away."""

    name: str
    walls: tuple[str, ...]
    kind: ClassVar[str] = "remove-wall"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        stay = np.array([wall.name not in self.walls for wall in site.simulation.assembly.walls])
        site.simulation = without_walls(site.simulation, self.walls)
        site.full = site.full._replace(wall=wall_rows(site.full.wall, stay))
        return {"walls_removed": list(self.walls)}


@dataclass(frozen=True)
class Run:
    """True motion for a time [s], or until at rest before that.

    Attributes
    ----------
    name : str
    time : float [s]
    until_rest : bool
    frames_every : float, optional [s]
        Time between frames.
    criteria : Criteria
    """

    name: str
    time: float
    until_rest: bool = False
    frames_every: float | None = None
    criteria: Criteria = field(default_factory=Criteria)
    kind: ClassVar[str] = "run"

    def carry_out(self, site: Site, watcher: Watcher) -> dict[str, Any]:
        """Facts for the result."""
        rest = self.criteria.rest if self.until_rest else None
        _move(site, self.time, self.frames_every, watcher, rest)
        return {"at_rest": bool(site.simulation.unbalanced_ratio() < self.criteria.rest)}


@dataclass(frozen=True)
class FindFactor:
    """A search for a factor, see `geodem.breaking.search`."""

    name: str
    plan: SearchPlan

    @property
    def kind(self) -> str:
        """That of the factor."""
        return self.plan.kind


Stage = Settle | Gravity | ChangeStrength | Excavate | MoveWall | RemoveWalls | Run | FindFactor


def to_rest(site: Site, criteria: Criteria, watcher: Watcher) -> dict[str, Any]:
    """Let the ground come to rest, as far as it does within the step limit."""
    s = site.simulation
    most = criteria.most_steps(len(site.origin), s.dimension)
    steps = 0
    while steps < most:
        site.advance(BATCH, watcher)
        steps += BATCH
        ratio = s.unbalanced_ratio()
        watcher.told(f"coming to rest: {steps:,} of at most {most:,} steps, unbalanced {ratio:.1e}")
        if ratio < criteria.rest:
            break
    return {"at_rest": bool(s.unbalanced_ratio() < criteria.rest), "unbalanced": s.unbalanced_ratio()}


def _move(
    site: Site, time: float, frames_every: float | None, watcher: Watcher, rest: float | None = None
) -> None:
    """True motion for a time [s], or until the unbalanced ratio is below `rest`; goes on where a stop broke off."""
    s = site.simulation
    total = _steps(site, time)
    every = None if frames_every is None else _steps(site, frames_every)
    while site.done < total:
        watcher.may_keep(site)
        part = min(total - site.done, BATCH)
        if every is not None:
            part = min(part, every - site.done % every)
        site.advance(part, watcher)
        site.done += part
        if every is not None and site.done % every == 0:
            watcher.frame(site)
        watcher.told(f"{s.time:.4g} s, {site.done:,} of {total:,} steps")
        if rest is not None and s.unbalanced_ratio() < rest:
            break
    site.done = 0


def _ramp(criteria: Criteria, site: Site) -> int:
    return criteria.ramp_steps(len(site.origin), site.simulation.dimension)


def _steps(site: Site, time: float) -> int:
    return max(1, math.ceil(time / site.simulation.time_step))


def _where_now(site: Site) -> Floats:
    """Present places, of what was taken away the last known ones (n0, d)."""
    found = site.settled.copy()
    found[site.number] = site.simulation.positions
    return found
