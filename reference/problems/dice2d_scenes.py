"""DICE2D's examples of many discs: rock fall (1.5.11) and beam collision (1.5.12).

The drawings of both scenes are lost; they are rebuilt from the text, and this much is assumed. Rock fall: the
mean radius of 11.66 m of 12 discs leaves a boulder of 30 m beside eleven discs of 10 m; these are one column, and
the slope, 25 m of it up to the corner, has 45 degrees. "Strength zero" is 1 N. Beam: 100 and 98 discs are four layers
of 25, and of 25 and 24 in turn; the beam comes down at 150 m/s on a rigid block (bonds of the table break at a
strain of 0.5).
"""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.boundaries.walls import segments
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .dice2d_tables import GRAVITY, RADIUS, WIDTH_RATIO, book_step, disc_mass, friction
from .rows import Row

Floats = NDArray[np.float64]

STEPS = 800
BOULDER = 30.0  # [m]
CORNER = -90.0
"""Where the slope meets the ground [m]; the building stands at 0."""
HILL = [(CORNER - 220.0, 220.0), (CORNER, 0.0), (260.0, 0.0)]
BLOCK = [(-30.0, -400.0), (-30.0, 0.0), (30.0, 0.0), (30.0, -400.0)]
SPEED = 150.0  # of the beam [m/s]


def _builder(angle: float, strength: float, cohesion: float, viscosity: float) -> AssemblyBuilder:
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -GRAVITY))
    contact = {
        "normal_stiffness": 1e8,
        "shear_stiffness": 1e8,
        "friction_coefficient": friction(angle),
        "normal_viscosity": viscosity,
    }
    bond = {**contact, "tensile_strength": strength, "cohesion": cohesion, "width_ratio": WIDTH_RATIO}
    builder.add_material("rock", density=1000.0, contact=contact, bond=bond)
    return builder


def _simulation(builder: AssemblyBuilder) -> ParticleSimulation:
    step = book_step(0.1, disc_mass(1000.0), 1e8, 1e8)
    return ParticleSimulation(builder.build(), time_step=step, energy=True, buffer=5.0)


def rock_fall() -> ParticleSimulation:
    """Table 1.11: a boulder rolls down a slope against a column of eleven discs without strength."""
    builder = _builder(0.0, 1.0, 1.0, 1e-2)
    tower = builder.add_particles([(0.0, RADIUS * (2 * k + 1)) for k in range(11)], RADIUS, "rock")
    builder.bond([(k, k + 1) for k in tower[:-1]])
    along = 25.0
    # touching the slope; in the corner the centre is r tan(45/2) from it along the slope
    reach = along + BOULDER * math.tan(math.radians(22.5))
    down = math.sqrt(0.5)
    place = np.array([CORNER - reach * down, reach * down]) + BOULDER * down
    builder.add_particles([place], BOULDER, "rock")
    builder.add_wall(segments("ground", HILL, contact={"friction_coefficient": friction(30.0)}))
    return _simulation(builder)


def beam(packing: str) -> ParticleSimulation:
    """Table 1.12: a bonded beam of square (100) or triangular (98 discs) packing comes down on a block."""
    builder = _builder(80.0, 1e9, 1e9, 0.0)
    centres = []
    for layer in range(4):
        short = packing == "triangular" and layer % 2 == 1
        height = RADIUS * (1.0 + layer * (math.sqrt(3.0) if packing == "triangular" else 2.0))
        centres += [
            (2.0 * RADIUS * (k - 12.0 + 0.5 * short), height + 5.0) for k in range(24 if short else 25)
        ]
    builder.add_particles(centres, RADIUS, "rock", velocity=(0.0, -SPEED))
    builder.bond_within(1.01)
    builder.add_wall(segments("block", BLOCK, contact={"friction_coefficient": friction(80.0)}))
    return _simulation(builder)


def followed(name: str, simulation: ParticleSimulation, wall: str, imbalance: float) -> list[Row]:
    """Run it and hold the energy account, the momentum and the number of broken bonds to what they must be."""
    started = time.perf_counter()
    mass = simulation.assembly.mass
    simulation.run(1)
    before = mass @ simulation.velocities
    pushed = np.zeros(2)
    largest = float(np.abs(before).max())
    for _ in range(STEPS - 1):
        simulation.run(1)
        pushed += simulation.time_step * (
            mass.sum() * np.array([0.0, -GRAVITY]) - simulation.wall_force(wall)
        )
        largest = max(largest, float(np.abs(mass @ simulation.velocities).max()))
    after = mass @ simulation.velocities
    seconds = time.perf_counter() - started
    off = float(np.abs(after - before - pushed).max()) / largest
    lost = simulation.energy().imbalance
    broken = len(simulation.broken_bonds().bond)
    bonds = len(simulation.assembly.bonds)
    return [
        Row(name, "imbalance of the energy account", lost, 0.0, lost, imbalance, seconds),
        Row(name, "momentum less impulses, over the largest", off, 0.0, off, 1e-10, seconds),
        # some of the bonds, at most all
        Row(name, f"broken of {bonds} bonds", broken, bonds, float(not 0 < broken <= bonds), 0.0, seconds),
    ]


def run() -> list[Row]:
    """All of them."""
    rows = followed("11 rock fall", rock_fall(), "ground", 0.02)
    for packing in ("square", "triangular"):
        rows += followed(f"12 beam, {packing}", beam(packing), "block", 0.02)
    return rows


def draw(folder: Path) -> None:
    """Pictures of both examples: dice2d_rock_fall.png and dice2d_beam_collision.png."""
    _frames(
        [rock_fall()], [HILL], (0, 400, 550, 799), ((-230, 170), (-8, 240)), folder / "dice2d_rock_fall.png"
    )
    scenes = [beam("square"), beam("triangular")]
    window = ((-330, 330), (-330, 130))
    _frames(scenes, [BLOCK, BLOCK], (0, 30, 80, 160), window, folder / "dice2d_beam_collision.png")


def _frames(
    scenes: list[ParticleSimulation],
    walls: list[list[tuple[float, float]]],
    steps: tuple[int, ...],
    window: tuple[tuple[float, float], tuple[float, float]],
    path: Path,
) -> None:
    from matplotlib.collections import EllipseCollection, LineCollection
    from matplotlib.figure import Figure

    (left, right), (low, high) = window
    wide = 2.6
    size = (wide * len(steps), (wide * (high - low) / (right - left) + 0.3) * len(scenes))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(scenes), len(steps), squeeze=False)
    for row, (simulation, wall) in enumerate(zip(scenes, walls, strict=True)):
        bonds = simulation.assembly.bonds
        for axis, step in zip(axes[row], steps, strict=True):
            simulation.run(step - simulation.steps)
            places = simulation.positions
            width = 2.0 * simulation.assembly.radii
            axis.add_collection(
                EllipseCollection(
                    width, width, np.zeros(len(width)), units="xy", offsets=places, offset_transform=axis.transData,
                    facecolor="#d9d2c3", edgecolor="#555555", linewidth=0.4,
                )
            )  # fmt: skip
            intact = simulation.intact()
            axis.add_collection(LineCollection(list(places[bonds[intact]]), colors="#1b4f72", linewidths=0.8))
            # a broken bond is drawn while its discs are still near
            near = np.linalg.norm(places[bonds[:, 0]] - places[bonds[:, 1]], axis=1) < 6.0 * RADIUS
            axis.add_collection(
                LineCollection(places[bonds[~intact & near]], colors="#c0392b", linewidths=0.9)
            )
            axis.plot(*np.array(wall).T, color="black", linewidth=1.2)
            axis.set(xlim=(left, right), ylim=(low, high), aspect="equal", xticks=[], yticks=[])
            axis.set_title(f"{simulation.time:.2f} s", fontsize=8)
    figure.savefig(path, dpi=80)
