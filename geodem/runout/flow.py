"""The flow of what was handed over, from one look to the next, until it rests."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..measure.deposit import Deposit, main_body, measure_deposit
from ..particle_simulation import ParticleSimulation
from ..run_progress import Work
from .handing import HandOver, elastic_energy

Floats = NDArray[np.float64]

LOOK = 0.25
"""Time between two looks over that of a fall, sqrt(H/g)."""

AT_REST = 1e-3
"""Kinetic energy over that of all discs fallen by their mean diameter, below which they rest."""

TWICE = 2
"""Looks in a row for that."""

LONGEST = 60.0
"""Times of a fall after which a flow is ended that does not come to rest."""

RESTS = 2.6
"""Times of a fall after which a flow rests, times the tangent of its friction angle: 2.3 to 2.9 in the flows that it
was looked at in, of 150 to 2,200 discs with friction angles of 16 and 20 degrees, from rest and as they failed."""

SLOWER = ((0.1, 1.55), (0.5, 2.1))
"""Once the kinetic energy has fallen to this share of its largest, a flow rests at this multiple of that time."""

AGAIN = 0.25
"""A flow that has gone on for longer is expected to go on for at most this share of it again."""

FOLLOWED = 6
"""Looks over which a flow that slows down is followed."""


class Look(NamedTuple):
    """What is told of a moment.

    time [s]; centre_x, centre_y [m] of gravity; kinetic, potential (over the datum of the source), elastic [J/m];
    dissipated [J/m] since the hand-over; front [m]; fastest [m/s].
    """

    time: float
    centre_x: float
    centre_y: float
    kinetic: float
    potential: float
    elastic: float
    dissipated: float
    front: float
    fastest: float


class Flow:
    """A flow and what was seen of it.

    Parameters
    ----------
    simulation : ParticleSimulation
        Of the hand-over, or as it was kept.
    start : (n, 2) [m]
        All discs at the hand-over.
    moving : (n,) bool
    mass : (n,) [kg/m]
    surface : (k, 2) [m]
    gravity : float [m/s2]
    datum, height : float [m]
    downhill : float
    energy : float
        At the hand-over [J/m].
    friction : float
        Tangent of the residual friction angle [-].
    looks : list of Look
    """

    def __init__(
        self,
        simulation: ParticleSimulation,
        *,
        start: Floats,
        moving: NDArray[np.bool_],
        mass: Floats,
        surface: Floats,
        gravity: float,
        datum: float,
        height: float,
        downhill: float,
        energy: float,
        friction: float,
        looks: list[Look] | None = None,
    ) -> None:
        self.simulation = simulation
        self.start, self.moving, self.mass, self.surface = start, moving, mass, surface
        self.gravity, self.datum, self.height = gravity, datum, height
        self.downhill, self.energy, self.friction = downhill, energy, friction
        self.looks: list[Look] = looks or []
        if not self.looks:
            self.looks.append(self.look())

    @classmethod
    def of(cls, hand: HandOver) -> Flow:
        """Of what was handed over."""
        source, after = hand.source, {entry.name: entry.after for entry in hand.conserved}
        return cls(
            hand.simulation, start=hand.simulation.positions, moving=hand.moving, mass=hand.mass,
            surface=hand.surface, gravity=source.gravity, datum=source.datum, height=source.height,
            downhill=source.downhill, energy=after["energy"], friction=hand.friction,
        )  # fmt: skip

    @property
    def fall_time(self) -> float:
        """sqrt(H/g) [s]."""
        return math.sqrt(self.height / self.gravity)

    @property
    def steps_per_look(self) -> int:
        """Steps between two looks."""
        return max(1, math.ceil(LOOK * self.fall_time / self.simulation.time_step))

    def work(self) -> Work:
        """Steps so far, steps until it is expected to rest, and at most."""
        s, fall, now = self.simulation, self.fall_time, self.looks[-1]
        kinetic = np.array([look.kinetic for look in self.looks])
        rests = RESTS * fall / self.friction
        for share, times in SLOWER:
            above = np.flatnonzero(kinetic > share * kinetic.max())
            if len(above) and above[-1] < len(kinetic) - 1:
                rests = times * self.looks[above[-1] + 1].time
                break
        rests -= now.time
        left = max(rests, TWICE * LOOK * fall)
        before = kinetic[-1 - FOLLOWED] if len(kinetic) > FOLLOWED else 0.0
        if 0.0 < kinetic[-1] < before:
            # slowing down: on at that pace to the energy of rest
            each = FOLLOWED * LOOK * fall / math.log(before / kinetic[-1])
            falls = each * max(math.log(kinetic[-1] / self._little), 0.0) + TWICE * LOOK * fall
            left = min(max(left, AGAIN * now.time) if rests <= 0.0 else left, falls)
        most = LONGEST * fall - now.time
        return Work(s.steps, min(left, most) / s.time_step, most / s.time_step)

    @property
    def _little(self) -> float:
        """Kinetic energy of what rests [J/m]."""
        diameter = 2.0 * float(self.simulation.assembly.radii[self.moving].mean())
        return AT_REST * float(self.mass.sum()) * self.gravity * diameter

    @property
    def at_rest(self) -> bool:
        """Whether the flow has ended."""
        last = self.looks[-TWICE:]
        # what begins at rest is not at its end
        begun = self.looks[-1].time > self.fall_time
        return begun and len(last) == TWICE and all(look.kinetic < self._little for look in last)

    @property
    def too_long(self) -> bool:
        """Whether it has gone on for as long as it may."""
        return self.looks[-1].time > LONGEST * self.fall_time

    def advance(self) -> Look:
        """To the next look."""
        self.simulation.run(self.steps_per_look)
        self.looks.append(self.look())
        return self.looks[-1]

    def look(self) -> Look:
        """The flow as it is."""
        s, own = self.simulation, self.moving
        place, speed, mass = s.positions[own], s.velocities[own], self.mass[own]
        centre = (mass[:, None] * place).sum(axis=0) / mass.sum()
        kinetic = 0.5 * float(
            (mass * (speed**2).sum(axis=1)).sum() + (s.assembly.inertia[own] * s.spins[own, 0] ** 2).sum()
        )
        potential = float(mass.sum()) * self.gravity * float(centre[1] - self.datum)
        elastic = float(elastic_energy(s)[own].sum())
        radii = s.assembly.radii[own]
        body = main_body(place, radii)
        return Look(
            s.time, float(centre[0]), float(centre[1]), kinetic, potential, elastic,
            self.energy - kinetic - potential - elastic,
            self.downhill * float((self.downhill * place[:, 0] + radii)[body].max()),
            float(np.sqrt((speed**2).sum(axis=1)).max()),
        )  # fmt: skip

    def deposit(self) -> Deposit:
        """Where it lies."""
        own = self.moving
        return measure_deposit(
            self.simulation.positions[own], self.simulation.assembly.radii[own], self.mass[own],
            self.start[own], surface=self.surface, downhill=self.downhill,
        )  # fmt: skip
