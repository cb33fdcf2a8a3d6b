"""What stops a motion that has come to mean nothing, and the last state that still meant something.

Nothing of it is in the loops. After every batch of steps one comparison of numbers that the kernel gives says whether
a particle may have gone too far in a step; every thousand steps or more the state is looked at as a whole, and every
fourth time it is kept. Looking changes no bit of the motion.

Rules, each with the particle, the step and what to do in its message:

- every place and velocity is finite;
- in one step no particle goes farther than 0.4 of its own radius, so that nothing is passed through unseen (pairs are
  listed anew before the next forces, so the buffer of the list is no limit);
- where particles are fast enough to press a contact by their whole radius, none is pressed deeper than `DEEPEST`;
- no particle leaves a box far around everything that was there at the start;
- with an energy account: what is found stays within a tenth of what was supplied. Without one: kinetic energy stays
  below `EXPLOSION` times all that was there at the last kept state and was supplied since.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .errors import UnstableError
from .io.checkpoint import Tree
from .kernels import motion
from .particle_extremes import (
    FAR,
    far_box,
    overlaps_of_strangers,
    overlaps_with_walls,
    rounding,
    slowest_contact,
    stored_energy,
    supplied,
)
from .particle_state import state_tree

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

DEEPEST = {"particle": 1.5, "wall": 0.8}
"""Overlap over the smaller radius beyond which two particles, or one and a wall, are about to pass each other: the
centres of equal particles meet at 2, a centre meets a wall at 1. Soft contacts under hard blows come to 1."""

LONGEST_WAY = 0.4
"""Of a particle in one step, over its radius: what passes through a wall is seen at between `DEEPEST` and 1.2."""

EXPLOSION = 10.0
"""Kinetic energy over all that can have become it."""

IMBALANCE = 0.1
"""Of the energy account [-]."""

LOOK_WORK = 1_000_000
"""Particles times steps between two looks; 1000 to 10,000 steps."""

KEEP = 4
"""Looks between two kept states."""

MOST_KEPT = 2**30
"""A state larger than this is not kept [bytes]: what has filled the memory cannot be there twice."""


class Guard:
    """Looks at a simulation now and then, and raises `UnstableError`; keeps the last good state.

    Parameters
    ----------
    simulation : ParticleSimulation
    """

    def __init__(self, simulation: ParticleSimulation) -> None:
        s = simulation
        self.low, self.high = far_box(s)
        radii = s.assembly.radii
        self.smallest = float(radii.min())
        self.alone = len(radii) == 1 and not s.assembly.walls
        self.every = min(max(LOOK_WORK // len(radii), 1000), 10_000)
        self.slowest = slowest_contact(s)
        self.searches = 0
        self.kept: Tree | None = None
        self.kinetic = 0.0
        self.begun = False
        self.since = 0  # steps since the last look
        self.looks = 0

    # ------------------------------------------------------------------ when

    def begin(self, s: ParticleSimulation) -> None:
        """Keep the state that a motion begins with; what went before, such as a search for equilibrium, is over."""
        self.since = self.looks = 0
        self.begun = True
        self._keep(s)

    def stepped(self, s: ParticleSimulation, steps: int) -> None:
        """Take note of a batch of steps, and look where it is due.

        Raises
        ------
        UnstableError
            The motion has come to mean nothing.
        """
        # a single particle has nothing to pass through
        if s.moved > 2.0 * LONGEST_WAY * self.smallest and not self.alone:
            self._look_at_the_fastest(s)
        if s.searches != self.searches:
            # whatever is pressed into something else has moved, so that this comes up often enough
            self.searches = s.searches
            if float(s.sums[:, motion.FASTEST].max()) * self.slowest > self.smallest:
                self._look_for_deep_contacts(s)
        self.since += steps
        if self.since >= self.every:
            self.look(s)

    def ended(self, s: ParticleSimulation) -> None:
        """Look at what a run of some length ended with."""
        if self.since >= self.every // 4:
            self.look(s)

    def look(self, s: ParticleSimulation) -> None:
        """Look at the state as a whole, and keep it now and then; raises UnstableError."""
        self.since = 0
        with np.errstate(all="ignore"):
            kinetic = s.kinetic_energy()
        places = s.now[:, s.columns.position]
        low, high = places.min(axis=0), places.max(axis=0)
        if not (math.isfinite(kinetic) and np.isfinite(low).all() and np.isfinite(high).all()):
            raise self.lost(s)
        if s.cell is None and not ((low >= self.low).all() and (high <= self.high).all()):
            raise self._away(s)
        if s.features.energy:
            self._close_the_account(s)
        elif kinetic > EXPLOSION * self.kinetic:
            self._ask_where_it_comes_from(s, kinetic)
        self.looks += 1
        if self.looks % KEEP == 0:
            self._keep(s)

    # ------------------------------------------------------------------ the rules

    def lost(self, s: ParticleSimulation) -> UnstableError:
        """Something is no longer finite."""
        bad = np.flatnonzero(~np.isfinite(s.now).all(axis=1))
        return self.error(
            s,
            int(bad[0]) if len(bad) else None,
            "no finite place or velocity" + ("" if len(bad) else ": a wall or the cell"),
            "Take a shorter time step, or look for particles that were pressed into one another, and for loads in "
            "the wrong unit",
        )

    def _look_at_the_fastest(self, s: ParticleSimulation) -> None:
        fastest = float(s.sums[:, motion.FASTEST].max())
        if not fastest * s.time_step > LONGEST_WAY * self.smallest:
            return
        radius = s.now[:, s.columns.radius]
        ways = np.sqrt((s.now[:, s.columns.velocity] ** 2).sum(axis=1)) * s.time_step
        worst = int(np.argmax(ways / radius))
        if ways[worst] > LONGEST_WAY * radius[worst]:
            raise self.error(
                s, worst,
                f"it goes {ways[worst]:.3g} m in one step, more than {LONGEST_WAY:g} of its radius of "
                f"{radius[worst]:.3g} m, and may pass through particles or walls unseen",
                "Take a shorter time step, or look for what drives it: a step that is too long, an overlap at the "
                "start, a velocity or load in the wrong unit",
            )  # fmt: skip

    def _look_for_deep_contacts(self, s: ParticleSimulation) -> None:
        for found, with_whom in ((overlaps_of_strangers(s), "particle"), (overlaps_with_walls(s), "wall")):
            rows, others, depth = found
            if not len(depth) or not depth.max() > DEEPEST[with_whom]:
                continue
            worst = int(np.argmax(depth))
            other = others[worst]
            name = f"particle {s.arrays.ids[other]}" if with_whom == "particle" else s.walls.names[other]
            raise self.error(
                s, int(rows[worst]),
                f"it is pressed into {name} by {depth[worst]:.2f} of its radius and about to pass through",
                "Take a stiffer contact or less speed: the contact cannot stop it",
            )  # fmt: skip

    def _away(self, s: ParticleSimulation) -> UnstableError:
        places = s.now[:, s.columns.position]
        out = np.flatnonzero(~((places >= self.low) & (places <= self.high)).all(axis=1))
        return self.error(
            s, int(out[0]),
            f"it has left the box from {_listed(self.low)} to {_listed(self.high)} m, {FAR:g} times the size of the "
            "scene on every side",
            "Let something hold it, or stop the run before; where it may go so far, set simulation.guard.low and .high",
        )  # fmt: skip

    def _close_the_account(self, s: ParticleSimulation) -> None:
        account = s.energy()
        if abs(account.imbalance) > IMBALANCE:
            raise self.error(
                s, _fastest(s),
                f"energy is made from nothing: {account.found:.6g} J found, {account.supplied:.6g} J supplied, and "
                "this is the fastest particle",
                "Take a shorter time step: at a tenth of the critical one accounts close to 0.1 %",
            )  # fmt: skip

    def _ask_where_it_comes_from(self, s: ParticleSimulation, kinetic: float) -> None:
        """Kinetic energy has risen much: raise UnstableError where nothing explains it."""
        if s.features.joint_laws or self.kept is None:
            return
        # what drives particles gives energy that only the account knows
        if s.assembly.held.any() and np.hstack([s.velocities, s.spins])[s.assembly.held].any():
            return
        before = self.before(s)
        given = self.kinetic + supplied(before, s)
        if kinetic > EXPLOSION * given:
            given += stored_energy(before) + rounding(before, s)
        if kinetic > EXPLOSION * given:
            raise self.error(
                s, _fastest(s),
                f"kinetic energy is {kinetic:.6g} J, and since step {before.steps} all energy there was, and all work "
                f"of loads and walls, is {given:.6g} J; this is the fastest particle",
                "Take a shorter time step: energy is made from nothing",
            )  # fmt: skip

    def error(self, s: ParticleSimulation, row: int | None, cause: str, remedy: str) -> UnstableError:
        """What is raised, and with it where the last good state is."""
        kept = None if self.kept is None else int(self.kept["plain"]["numbers"]["steps"])
        return UnstableError(
            cause,
            remedy,
            step=s.steps,
            particle=None if row is None else int(s.arrays.ids[row]),
            place=None if row is None else tuple(map(float, s.now[row, s.columns.position])),
            detail=f"time step {s.time_step:.6g} s, critical at the start {s.critical_time_step:.6g} s",
            last_good=kept,
        )

    # ------------------------------------------------------------------ the last good state

    def _keep(self, s: ParticleSimulation) -> None:
        self.kept = copied(state_tree(s), self.kept) if s.nbytes() <= MOST_KEPT else None
        with np.errstate(all="ignore"):
            # before the first step nobody knows what contacts store
            self.kinetic = s.kinetic_energy() if s.steps > 0 else math.inf

    def before(self, s: ParticleSimulation) -> ParticleSimulation:
        """The kept state as a simulation of its own."""
        assert self.kept is not None
        return s.of_state(s.assembly, copied(self.kept, None), "a state that was kept")


def copied(tree: Tree, into: Tree | None) -> Tree:
    """A tree whose arrays are its own; those of `into` are written over where they fit."""
    made: Tree = {}
    for name, value in tree.items():
        old = None if into is None else into.get(name)
        if isinstance(value, np.ndarray):
            if isinstance(old, np.ndarray) and old.shape == value.shape and old.dtype == value.dtype:
                np.copyto(old, value)
                made[name] = old
            else:
                made[name] = value.copy()
        elif isinstance(value, dict):
            made[name] = copied(value, old if isinstance(old, dict) else None)
        else:
            made[name] = value
    return made


def _fastest(s: ParticleSimulation) -> int:
    """Row of the fastest particle."""
    return int(np.argmax((s.now[:, s.columns.velocity] ** 2).sum(axis=1)))


def _listed(point: Floats) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in point) + ")"
