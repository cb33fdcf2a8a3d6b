"""TRUBAL's triaxial test of a random assembly: 150 equal spheres in a periodic cell, as TPM repeated it.

The spheres are thrown in at random, compacted isotropically until each has six contacts on average, and come to rest in
a cell that stands still. Then the cell is shortened along z and the stresses along x and y are kept up, until the axial
stress has fallen below its peak; it is drawn out again until the deviator stress is gone, and shortened a second time.

The text gives no numbers of this test ("selected on an arbitrary basis"): material and size are those of its other
one (table 4.1), friction is 0.5. It keeps a lateral strain rate constant that it does not give; a constant lateral
stress, as in a triaxial cell, is what makes a strength. Source: the thesis on TPM (New Jersey Institute of Technology),
section 3.4.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation

from .granular_grains import Floats
from .rows import Row, at_most, relative

SPHERES = 150
RADIUS = 20.0  # [m]
DENSITY = 2000.0  # [kg/m3]
STIFFNESS = 1.5e9  # kn = ks [N/m]
FRICTION = 0.5  # [-]
THROWN_AT = 0.45  # solid fraction
CONTACTS = 6.0  # of a particle, at the end of the compaction
UNIT_TIME = math.sqrt(DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3 / STIFFNESS)  # sqrt(m/kn) [s]
COMPACTION, SHEARING = 1e-4 / UNIT_TIME, 1e-5 / UNIT_TIME  # strain rates [1/s]
LARGEST_RATE = 5e-5 / UNIT_TIME  # of the sides while their stress is kept up [1/s]
DAMPING = 0.3  # local
FAILED_AT = 0.97  # of the peak: to where the deviator stress has fallen when it is unloaded
LEAST_STRAIN, MOST_STRAIN = 0.02, 0.45  # axial: where it is unloaded at the earliest and at the latest
FARTHER = 0.1  # how far it is loaded again beyond that
EACH = 100  # steps between readings
WINDOW = 40  # readings in a running mean
SEEDS = (1, 2, 3)


class Triaxial(NamedTuple):
    """Axial strain and stresses, pressing positive; a row is a reading."""

    strain: Floats
    axial: Floats  # [Pa]
    lateral: Floats  # mean of the two [Pa]
    phase: Floats  # 0 loading, 1 unloading, 2 loading again
    contacts: float  # of a particle, before
    solid_fraction: float
    pressure: float  # [Pa]
    overlap: float  # mean before over the diameter
    imbalance: float  # of the energy account, relative
    seconds: float

    def part(self, phase: int) -> tuple[Floats, Floats]:
        """Strain and deviator stress [Pa] of a phase."""
        inside = self.phase == phase
        return self.strain[inside], (self.axial - self.lateral)[inside]


def compacted(seed: int) -> ParticleSimulation:
    """Spheres with six contacts each, at rest."""
    packing = random_packing(3, radius=RADIUS, count=SPHERES, solid_fraction=THROWN_AT, seed=seed)
    builder = AssemblyBuilder(3)
    contact = {"normal_stiffness": STIFFNESS, "shear_stiffness": STIFFNESS, "friction_coefficient": FRICTION}
    builder.add_material("sphere", density=DENSITY, contact=contact)
    builder.add_particles(packing.positions, packing.radii, "sphere")
    builder.set_cell(packing.box)
    simulation = ParticleSimulation(builder.build(), local_damping=DAMPING, energy=True)
    simulation.set_strain_rate(-COMPACTION)
    for _ in range(20_000):
        simulation.run(EACH)
        if simulation.coordination_number() >= CONTACTS:
            break
    simulation.set_strain_rate(0.0)
    for _ in range(2_000):
        simulation.run(EACH)
        if simulation.unbalanced_ratio() < 1e-4:
            break
    return simulation


def triaxial(seed: int, *, slower: int = 1) -> Triaxial:
    """The whole test, at one over `slower` of the usual strain rate."""
    started = time.perf_counter()
    simulation = compacted(seed)
    contacts, solid = simulation.coordination_number(), simulation.solid_fraction()
    found = simulation.contacts()
    overlap = float(found.overlap[found.overlap > 0.0].mean() / (2.0 * RADIUS))
    stress = np.diag(simulation.stress())
    pressure = -float(stress.mean())
    nan = math.nan
    simulation.set_target_stress((-pressure, -pressure, nan), largest_rate=LARGEST_RATE)
    rate = SHEARING / slower
    start = -float(simulation.strain()[2, 2])
    readings: list[tuple[float, ...]] = []

    def read(phase: int) -> tuple[float, float]:
        simulation.run(EACH * slower)
        now = -np.diag(simulation.stress())
        strain = -float(simulation.strain()[2, 2]) - start
        readings.append((strain, float(now[2]), float(now[:2].mean()), float(phase)))
        return strain, float(now[2] - now[:2].mean())

    simulation.set_strain_rate((nan, nan, -rate))
    best, recent = 0.0, [0.0] * WINDOW
    unloaded = 0.0
    while unloaded < LEAST_STRAIN or (unloaded < MOST_STRAIN and not sum(recent) < FAILED_AT * best):
        unloaded, deviator = read(0)
        recent = [*recent[1:], deviator]
        best = max(best, sum(recent))
    simulation.set_strain_rate((nan, nan, rate))
    while read(1)[1] > 0.0:
        pass
    simulation.set_strain_rate((nan, nan, -rate))
    while read(2)[0] < unloaded + FARTHER:
        pass
    account = simulation.energy()
    strain, axial, lateral, phase = np.array(readings).T
    return Triaxial(
        strain, axial, lateral, phase, contacts, solid, pressure, overlap, account.imbalance,
        time.perf_counter() - started,
    )  # fmt: skip


def strengths(run: Triaxial) -> tuple[float, float]:
    """Largest deviator stress over the confining one, by running means: at the first loading, at the second."""
    window = np.ones(WINDOW) / WINDOW
    first, second = (np.convolve(run.part(phase)[1], window, mode="valid").max() for phase in (0, 2))
    return float(first / run.pressure), float(second / run.pressure)


def rejoined(run: Triaxial) -> tuple[float, float]:
    """Deviator over confining stress before unloading, and when loading again has come back to that strain."""
    (first, before), (again, second) = run.part(0), run.part(2)
    there = int(np.searchsorted(again, first[-1]))
    return float(before[-WINDOW:].mean() / run.pressure), float(
        second[there : there + WINDOW].mean() / run.pressure
    )


def stiffnesses(run: Triaxial) -> tuple[float, float, float]:
    """Secant moduli between none and half of the deviator stress [Pa]: loading, unloading, reloading."""
    found = []
    for phase in range(3):
        strain, deviator = run.part(phase)
        top = deviator.max() if phase != 1 else deviator[0]
        if phase == 1:
            inside = deviator > 0.5 * top
        else:
            inside = np.arange(len(deviator)) <= np.argmax(deviator > 0.5 * top)
        found.append(float(np.polyfit(strain[inside], deviator[inside], 1)[0]))
    return found[0], found[1], found[2]


def path_apart(run: Triaxial) -> float:
    """Mean distance of the reloading path from the unloading one at equal strains, over the stress it begins at."""
    (down, unloading), (up, reloading) = run.part(1), run.part(2)
    order = np.argsort(down)
    inside = (up > down.min()) & (up < down.max())
    apart = reloading[inside] - np.interp(up[inside], down[order], unloading[order])
    return float(np.abs(apart).mean() / unloading[0])


def rows_of(seed: int, run: Triaxial, half: Triaxial) -> list[Row]:
    """What the figure of the text shows, as numbers."""
    name = f"TPM {SPHERES} random spheres, seed {seed}"
    first, second = strengths(run)
    loading, unloading, reloading = stiffnesses(run)
    slow = strengths(half)
    last, back = rejoined(run)
    strength = "deviator over confining stress at failure"
    return [
        relative(name, "contacts of a particle before the test", run.contacts, CONTACTS, 0.1, run.seconds, "the text"),
        at_most(name, "stress before unloading over its peak, at most", last / first, FAILED_AT, run.seconds,
                "failure: the stress falls"),
        relative(name, "deviator over confining stress, back at the strain of unloading", back, last, 0.15,
                 run.seconds, "before unloading"),
        relative(name, f"{strength}, loaded again", second, first, 0.15, run.seconds, "loaded first"),
        relative(name, f"{strength}, half the strain rate", slow[0], first, 0.1, half.seconds, "the full rate"),
        relative(name, f"{strength}, loaded again, half the rate", slow[1], second, 0.1, half.seconds, "the full rate"),
        at_most(name, "stiffness of loading over that of unloading, at most", loading / unloading, 1.0, run.seconds,
                "elastic"),
        relative(name, "stiffness of reloading [Pa]", reloading, unloading, 0.5, run.seconds, "unloading"),
        at_most(name, "way back up from the way down, mean over stress, at most", path_apart(run), 0.2, run.seconds,
                "the same path"),
        Row(name, "imbalance of the energy account", run.imbalance, 0.0, run.imbalance, 1e-3, run.seconds, "first law"),
    ]  # fmt: skip


def draw(runs: dict[int, tuple[Triaxial, Triaxial]]) -> bytes:
    """Axial stress against axial strain: one seed at two rates, and stress ratios of all seeds."""
    from geodem.plotting.theme import FAILED, OTHER_CIRCLES, SOFT, STABLE, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(9.0, 3.7)
        left, right = figure.subplots(1, 2)
        seed, (run, half) = next(iter(runs.items()))
        for curve, colour, label in ((run, STABLE, "full rate"), (half, FAILED, "half the rate")):
            left.plot(100.0 * curve.strain, 1e-6 * curve.axial, "-", color=colour, linewidth=1.1, label=label)
        left.plot(
            100.0 * run.strain, 1e-6 * run.lateral, "-", color=SOFT, linewidth=0.9, label="lateral stress"
        )
        left.set_title(f"{SPHERES} spheres, seed {seed}")
        left.set_ylabel("axial stress [MPa]")
        for (number, (run, _)), colour in zip(runs.items(), OTHER_CIRCLES, strict=False):
            right.plot(100.0 * run.strain, run.axial / run.lateral, "-", color=colour, linewidth=1.1,
                       label=f"seed {number}")  # fmt: skip
        right.set_title("Seeds")
        right.set_ylabel("axial over lateral stress")
        for axes in (left, right):
            axes.set_xlabel("axial strain [%]")
            axes.set_ylim(bottom=0.0)
            axes.legend(loc="lower right")
            quiet_axes(axes)
        return png(figure)
