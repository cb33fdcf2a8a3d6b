"""A grouted bar that is pulled out of rigid ground, and a lining bent as a beam, against closed forms.

Elastic: EA u'' = k u with the grout's stiffness k per length and nothing at the far end gives, with
lambda = sqrt(k/EA),

    P = sqrt(EA k) tanh(lambda L) u(0),    N(x) = P sinh(lambda (L - x)) / sinh(lambda L).

The grout slips everywhere at P = strength * L; a bar that yields before holds its yield force.
Source: Farmer 1975, Stress distribution along a resin grouted rock anchor, Int. J. Rock Mech. Min. Sci. 12:347.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.bolts import Bar, Bolt, Grout, add_bolt, add_lining
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .rows import Row, relative

Floats = NDArray[np.float64]

LENGTH = 3.0  # [m]
STIFFNESS = 1e8
"""EA of the bar [N]: 25 mm of steel."""
GROUT = 1e8  # [N/m2]
STRENGTH = 1e5  # [N/m]
YIELD = 1.5e5  # [N]
FREE = 0.3
"""Of the bar that yields, from the head [m]."""
SPACING = 0.05
SPEED = 0.02
"""Of the head [m/s]."""
SOURCE = "Farmer 1975, elastic bar in elastic grout"
CONTACT = {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
BOND = {
    "effective_modulus": 1e9, "stiffness_ratio": 2.0, "tensile_strength": 1e9, "shear_strength": 1e9,
    "friction_coefficient": 0.5,
}  # fmt: skip


class PullOut:
    """A bolt in rigid ground, its head drawn along it."""

    def __init__(self, bar: Bar, grouted: tuple[float, float] = (0.0, math.inf)) -> None:
        build = AssemblyBuilder(2, "effective_modulus", "rock")
        build.add_material("rock", density=2500.0, contact=CONTACT, bond=BOND)
        ground = lattice("hexagonal", 0.1, box=(LENGTH + 0.6, 1.2)).positions - np.array([0.3, 0.6])
        held = build.add_particles(ground, 0.1, "rock")
        build.hold(held, x=0.0, y=0.0, rotation=0.0)
        self.bolt: Bolt = add_bolt(
            build,
            "bolt",
            (0.0, 0.0),
            (LENGTH, 0.0),
            bar,
            Grout(GROUT, STRENGTH),
            spacing=SPACING,
            grouted=grouted,
        )
        build.hold(self.bolt.particles[:1], x=-SPEED, y=0.0, rotation=0.0)
        self.simulation = ParticleSimulation(build.build(), local_damping=0.7)

    def draw(self, way: float) -> None:
        """Draw the head until it has gone so far [m]."""
        s = self.simulation
        s.run(max(1, round((way - self.way) / (SPEED * s.time_step))))

    @property
    def way(self) -> float:
        """Of the head [m]."""
        s, head = self.simulation, self.bolt.particles[0]
        return float(s.assembly.positions[head, 0] - s.positions[head, 0])

    @property
    def force(self) -> float:
        """That draws the head [N]."""
        return float(self.simulation.forces[self.bolt.particles[0], 0])

    def axial(self) -> Floats:
        """Tension of every piece of bar [N]."""
        return bar_forces(self.simulation, self.bolt)


def bar_forces(simulation: ParticleSimulation, bolt: Bolt) -> Floats:
    """Tension (k,) of every piece of a bolt's bar [N], from its head on."""
    pairs = simulation.contacts().pairs
    normal, _ = simulation.contact_forces()
    found = {tuple(pair): -force for pair, force in zip(pairs.tolist(), normal.tolist(), strict=True)}
    return np.array([found.get(tuple(sorted(piece)), 0.0) for piece in bolt.pieces.tolist()])


def pull_out() -> list[Row]:
    """Stiffness, profile of the axial force, pull-out force, and the force of a bar that yields."""
    begun = time.perf_counter()
    elastic = PullOut(Bar(STIFFNESS))
    # well before the grout slips anywhere
    elastic.draw(0.3 * STRENGTH / GROUT)
    rate = math.sqrt(GROUT / STIFFNESS)
    stiffness = math.sqrt(STIFFNESS * GROUT) * math.tanh(rate * LENGTH)
    middle = 0.5 * (elastic.bolt.along[1:] + elastic.bolt.along[:-1])
    expected = elastic.force * np.sinh(rate * (LENGTH - middle)) / math.sinh(rate * LENGTH)
    off = float(np.abs(elastic.axial() - expected).max()) / elastic.force
    rows = [
        relative(
            "pull-out", "stiffness [MN/m]", 1e-6 * elastic.force / elastic.way, 1e-6 * stiffness, 0.02,
            time.perf_counter() - begun, SOURCE,
        ),
        Row(
            "pull-out", "axial force, farthest off the profile over P", off, 0.0, off, 0.05, 0.0, SOURCE
        ),
    ]  # fmt: skip
    most = STRENGTH * LENGTH
    elastic.draw(1.3 * (STRENGTH / GROUT + 0.5 * most * LENGTH / STIFFNESS))
    rows.append(
        relative("pull-out", "pull-out force [kN]", 1e-3 * elastic.force, 1e-3 * most, 0.02, 0.0, SOURCE)
    )
    begun = time.perf_counter()
    yielding = PullOut(Bar(STIFFNESS, yield_force=YIELD), (FREE, math.inf))
    yielding.draw(0.008)
    rows.append(
        relative(
            "pull-out", "force of a bar that yields [kN]", 1e-3 * yielding.force, 1e-3 * YIELD, 0.02,
            time.perf_counter() - begun, "ideally plastic bar",
        )
    )  # fmt: skip
    return rows


def lining() -> list[Row]:
    """A lining held at one end: deflection P L^3/(3 EI) under a load across, P L/EA along."""
    begun = time.perf_counter()
    axial, bending, length, load = 3e9, 2.5e6, 4.0, 10.0
    build = AssemblyBuilder(2, "effective_modulus", "rock")
    chain = add_lining(
        build, "concrete", [(0.0, 0.0), (length, 0.0)], axial_stiffness=axial, bending_stiffness=bending,
        density_per_length=250.0, contact=CONTACT,
    )  # fmt: skip
    build.hold(chain[:1], x=0.0, y=0.0, rotation=0.0)
    build.apply(chain[-1:], force=(100.0 * load, load))
    s = ParticleSimulation(build.build())
    state = find_equilibrium(s, tolerance=1e-6)
    if not state.reached:
        raise RuntimeError(state.reason)
    along, across = (s.positions - s.assembly.positions)[chain[-1]]
    # the pull stiffens it by 0.4 T L^2/EI: a quarter of a percent here
    return [
        relative(
            "lining", "deflection [mm]", 1e3 * across, 1e3 * load * length**3 / (3.0 * bending), 0.02,
            time.perf_counter() - begun, "Euler-Bernoulli beam",
        ),
        relative("lining", "extension [mm]", 1e3 * along, 1e5 * load * length / axial, 0.02, 0.0, "bar"),
    ]  # fmt: skip


def run() -> list[Row]:
    """All of them."""
    return [*pull_out(), *lining()]
