"""Trapdoor under dry discs, active: `python -m reference run trapdoor`; draws docs/pictures/trapdoor.png.

A layer of discs, H high, on a rough floor of which a part, B wide, sinks. The mean pressure on it falls to a minimum
and recovers a little. Limit analysis with associated flow (finite elements, upper bound) gives the least pressure that
may be, Terzaghi's silo with K = 1 more: K. Terzaghi (1943), Theoretical Soil Mechanics. Real sand lies between.
The friction of the discs is that of `geodem.runout.friction`: their friction angle in biaxial compression at large
strain, which dense packings exceed by some degrees at first.

The door sinks faster than in a laboratory: what matters is the inertial number of the bands that shear, (speed / width
of the band) d / sqrt(p / rho), and that a slower door finds the same.

The floor has edges down beside the door, so that no disc slips under it.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from geodem.assembly import Assembly
from geodem.boundaries.walls import plane, segments
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.random_packing import random_packing
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation.settling import run_to_rest
from geodem.runout.friction import SHEAR_STIFFNESS, disc_friction
from geodem.runout.handing import take_contacts

from .granular_grains import Floats
from .rows import Row, at_most

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"

SEEDS = (1, 2, 3, 4)
LEAST = {(20, 1): 0.627, (20, 2): 0.390, (30, 1): 0.434, (30, 2): 0.232}
"""Pressure over gamma H by limit analysis, the lower of its two bounds: (friction angle [deg], H/B)."""
SLACK = 0.10
"""Share by which a minimum may lie outside the two."""
WIDTH = {1: 43.0, 2: 26.0}
"""Door over the mean diameter of the discs."""
SIZE_RATIO = 2.0
SOLID = 0.80
STIFFNESS = 500.0  # normal stiffness of a contact over rho g H
SPEED = 0.04  # of the door over sqrt(g d)
BAND = 8.0  # width of a band that shears over d
QUASI_STATIC = 1e-3  # inertial number: MiDi (2004), Eur. Phys. J. E 14:341
SLOWER = 4.0
"""A door that sinks so many times as slow is opened too, with few discs across it but many packings."""
SLOW_WIDTH, SLOW_SEEDS, SAME = 16.0, (1, 2, 3, 4), 0.05
STEP = 0.7  # time step over the critical one
TRAVEL = {1: 0.03, 2: 0.04}  # of the door over B
WINDOW = 0.0025  # movement over B that a pressure is the mean of
RESTITUTION_RATIO = 0.3  # share of critical damping of a contact


class Opening(NamedTuple):
    """One door that sank: pressures over gamma H by its movement over B."""

    angle: int
    cover: int
    discs: int
    movement: Floats
    pressure: Floats
    seconds: float

    @property
    def least(self) -> float:
        """The smallest mean over a window."""
        return float(self.pressure.min())

    @property
    def at(self) -> float:
        """Movement of the door over B there."""
        return float(self.movement[self.pressure.argmin()])


def terzaghi(angle: float, cover: float) -> float:
    """Pressure over gamma H of a silo over the door, K = 1; `angle` [rad], `cover` H/B."""
    slope = 2.0 * math.tan(angle) * cover
    return (1.0 - math.exp(-slope)) / slope


def opened(angle: int, cover: int, seed: int, *, width: float, speed: float = SPEED) -> Opening:
    """Let the discs settle, then the door sink; mean diameter, density and gravity are 1."""
    begun = time.perf_counter()
    # in largest diameters
    door = width * 0.5 * (1.0 + 1.0 / SIZE_RATIO)
    high, wide = cover * door, 2.0 * (1.5 * cover + 1.0) * door
    packing = random_packing(
        2, box=(wide, 1.04 * high), solid_fraction=SOLID, radius=0.5, size_ratio=SIZE_RATIO, periodic=False,
        seed=seed,
    )  # fmt: skip
    # from here in mean diameters
    size = 1.0 / (2.0 * float(packing.radii.mean()))
    places, radii = packing.positions * size, packing.radii * size
    door, high, wide = door * size, high * size, wide * size
    rest = ParticleSimulation(_assembly(places, radii, angle, wide, door, high, 0.0), local_damping=0.3)
    run_to_rest(rest, tolerance=5e-3, most_steps=40_000)
    sinking = ParticleSimulation(
        _assembly(rest.positions, radii, angle, wide, door, high, speed), local_damping=0.1
    )
    take_contacts(rest, sinking)
    sinking.time_step = STEP * sinking.critical_time_step
    weight = float(sinking.assembly.mass.sum()) / wide
    parts = 25
    steps = max(1, round(WINDOW * door / speed / sinking.time_step / parts))
    movement, pressure = [], []
    for _ in range(round(TRAVEL[cover] / WINDOW)):
        force = 0.0
        for _ in range(parts):
            sinking.run(steps)
            force += abs(float(sinking.wall_force("door")[1])) / parts
        movement.append(sinking.time * speed / door - 0.5 * WINDOW)
        pressure.append(force / door / weight)
    return Opening(
        angle, cover, len(radii), np.array(movement), np.array(pressure), time.perf_counter() - begun
    )


def _assembly(
    places: Floats, radii: Floats, angle: int, wide: float, door: float, high: float, speed: float
) -> Assembly:
    friction = disc_friction(math.radians(angle))
    stiffness = STIFFNESS * high * SOLID
    viscosity = 2.0 * RESTITUTION_RATIO * math.sqrt(0.125 * math.pi / stiffness)
    builder = AssemblyBuilder(2, contact_law="linear_rolling", gravity=(0.0, -1.0))
    builder.add_material(
        "grain",
        density=1.0,
        contact={
            "normal_stiffness": stiffness,
            "shear_stiffness": SHEAR_STIFFNESS * stiffness,
            "friction_coefficient": friction.sliding,
            "rolling_friction": friction.rolling,
            "normal_viscosity": viscosity,
            "shear_viscosity": 0.0,  # it would act beyond the friction
        },
    )
    builder.add_particles(places, radii, "grain")
    smooth = {"friction_coefficient": 0.0, "rolling_friction": 0.0}
    builder.add_wall(plane("left", (0.0, 0.0), (1.0, 0.0), contact=smooth))
    builder.add_wall(plane("right", (wide, 0.0), (-1.0, 0.0), contact=smooth))
    left, right = 0.5 * (wide - door), 0.5 * (wide + door)
    builder.add_wall(segments("floor, left", [(-2.0, 0.0), (left, 0.0), (left, -3.0)]))
    builder.add_wall(segments("door", [(left, 0.0), (right, 0.0)], velocity=(0.0, -speed)))
    builder.add_wall(segments("floor, right", [(right, -3.0), (right, 0.0), (wide + 2.0, 0.0)]))
    return builder.build()


def speed_rows() -> list[Row]:
    """Whether the door is slow enough."""
    quick, slow = (
        [opened(30, 1, seed, width=SLOW_WIDTH, speed=SPEED / share) for seed in SLOW_SEEDS]
        for share in (1.0, SLOWER)
    )
    least, slowly = (float(np.mean([run.least for run in runs])) for runs in (quick, slow))
    inertial = max(SPEED / BAND / math.sqrt(SOLID * cover * WIDTH[cover]) for cover in WIDTH)
    name = f"phi 30 deg, H/B 1, B/d {SLOW_WIDTH:g}"
    return [
        Row(name, f"least pressure, against a door {SLOWER:g} times as slow", least, slowly, least / slowly - 1.0, SAME,
            sum(run.seconds for run in quick + slow), f"mean of seeds {SLOW_SEEDS[0]} to {SLOW_SEEDS[-1]}"),
        at_most("all doors", "inertial number of the bands that shear, at most", inertial, QUASI_STATIC, 0.0,
                f"bands {BAND:g} d wide, pressure rho g H; MiDi (2004)"),
    ]  # fmt: skip


def rows_of(found: dict[tuple[int, int], list[Opening]]) -> list[Row]:
    """Every minimum beside what it may be."""
    rows = []
    for (angle, cover), runs in found.items():
        name = f"phi {angle} deg, H/B {cover}, B/d {WIDTH[cover]:g}"
        least = np.array([run.least for run in runs])
        low, high = LEAST[angle, cover], terzaghi(math.radians(angle), cover)
        mean = float(least.mean())
        nearest = min(max(mean, low), high)
        seconds = sum(run.seconds for run in runs)
        rows += [
            Row(name, "least pressure on the door over gamma H, mean of the seeds", mean, nearest,
                mean / nearest - 1.0, SLACK, seconds,
                f"between {low:.3f} (limit analysis) and {high:.3f} (Terzaghi); {_each(runs)}"),
            at_most(name, "half the range of the seeds over their mean, at most", float(np.ptp(least)) / 2.0 / mean,
                    0.15, seconds, f"seeds {SEEDS[0]} to {SEEDS[-1]}"),
        ]  # fmt: skip
    for angle in (20, 30):
        fall = np.mean([r.least for r in found[angle, 2]]) / np.mean([r.least for r in found[angle, 1]])
        rows.append(
            at_most(f"phi {angle} deg", "least pressure at H/B 2 over that at H/B 1, at most", float(fall), 0.85, 0.0,
                    "falls with H/B: limit analysis 0.53 to 0.63, Terzaghi 0.66 to 0.74")
        )  # fmt: skip
    return rows


def _each(runs: list[Opening]) -> str:
    """Minima and where they are, in words."""
    return "seeds: " + ", ".join(f"{run.least:.3f} at {100.0 * run.at:.1f} % B" for run in runs)


def draw(found: dict[tuple[int, int], list[Opening]]) -> bytes:
    """Pressure by the movement of the door, with the two bounds."""
    from geodem.plotting.theme import FAILED, SOFT, STABLE, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(9.0, 3.4)
        panels = figure.subplots(1, 2, sharey=True)
        for axes, cover in zip(panels, (1, 2), strict=True):
            for angle, colour in ((20, STABLE), (30, FAILED)):
                for number, run in enumerate(found[angle, cover]):
                    axes.plot(100.0 * run.movement, run.pressure, color=colour, linewidth=1.1, alpha=0.8,
                              label=f"phi {angle} deg" if number == 0 else None)  # fmt: skip
                axes.axhspan(
                    LEAST[angle, cover],
                    terzaghi(math.radians(angle), cover),
                    color=colour,
                    alpha=0.10,
                    linewidth=0.0,
                )
            axes.set_title(f"H/B = {cover}")
            axes.set_xlabel("movement of the door over B [%]")
            axes.set_ylim(0.0, 1.0)
            quiet_axes(axes)
        panels[0].set_ylabel("pressure on the door over gamma H")
        panels[0].legend(loc="upper right")
        panels[1].text(0.98, 0.97, "bands: limit analysis to Terzaghi", transform=panels[1].transAxes, ha="right",
                       va="top", color=SOFT, fontsize=8.5)  # fmt: skip
        return png(figure)


def run() -> list[Row]:
    """All doors, and the picture."""
    found = {key: [opened(*key, seed, width=WIDTH[key[1]]) for seed in SEEDS] for key in LEAST}
    PICTURES.mkdir(parents=True, exist_ok=True)
    (PICTURES / "trapdoor.png").write_bytes(draw(found))
    return rows_of(found) + speed_rows()
