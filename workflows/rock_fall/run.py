"""The workflow from Python: boulders roll and bounce down a slope; held to expected.toml."""

from __future__ import annotations

import math
import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.io.frame_reading import ParticleFrame, frame_paths, read_frame
from geodem.particle_simulation import ParticleSimulation

HERE = Path(__file__).resolve().parent
CASE = tomllib.loads((HERE / "case.toml").read_text())
HILL = np.array(CASE["wall"][0]["points"], dtype=float)
RADIUS, DENSITY, GRAVITY = 0.5, 2200.0, 9.81
STIFFNESS, VISCOSITY, FRICTION = 2e7, 2.2e-3, 0.6
ROLLING = 0.1
EDGE = 12.0
"""Beyond it the slope is steep [m]: what comes so far has fallen."""
VIEW = (-9.0, 102.0, -4.0, 50.0)


def boulder(place: tuple[float, float], normal: tuple[float, float], rolling: float) -> ParticleSimulation:
    """One boulder over a plane through the origin."""
    builder = AssemblyBuilder(2, contact_law="linear_rolling", gravity=(0.0, -GRAVITY))
    contact = {
        "normal_stiffness": STIFFNESS, "shear_stiffness": 0.5 * STIFFNESS, "friction_coefficient": FRICTION,
        "rolling_friction": rolling, "normal_viscosity": VISCOSITY, "shear_viscosity": 0.0,
    }  # fmt: skip
    builder.add_material("boulder", density=DENSITY, contact=contact)
    builder.add_particles([place], RADIUS, "boulder")
    builder.add_wall(plane("ground", (0.0, 0.0), normal))
    # a hundredth of a contact: its loss is that of the closed form
    return ParticleSimulation(builder.build(), time_step=2e-4)


def rolling_error() -> float:
    """Acceleration on an incline against the closed form, relative."""
    slope = math.radians(20.0)
    normal = (math.sin(slope), math.cos(slope))
    mass = DENSITY * math.pi * RADIUS**2
    sunk = mass * GRAVITY * math.cos(slope) / (2.0 * STIFFNESS)
    s = boulder(((RADIUS - sunk) * normal[0], (RADIUS - sunk) * normal[1]), normal, ROLLING)
    s.run(round(0.5 / s.time_step))
    first, start = s.velocities[0] @ (math.cos(slope), -math.sin(slope)), s.time
    s.run(round(2.0 / s.time_step))
    found = (s.velocities[0] @ (math.cos(slope), -math.sin(slope)) - first) / (s.time - start)
    wanted = 2.0 / 3.0 * GRAVITY * (math.sin(slope) - ROLLING * math.cos(slope))
    return float(found / wanted - 1.0)


def bouncing_error() -> float:
    """Height of rebound over that of the fall against the restitution of spring and dashpot, relative."""
    high = 3.0
    s = boulder((0.0, RADIUS + high), (0.0, 1.0), 0.0)
    fall = math.sqrt(2.0 * high / GRAVITY)
    s.run(round(1.15 * fall / s.time_step))
    top = 0.0
    for _ in range(400):
        s.run(max(1, round(0.005 * fall / s.time_step)))
        top = max(top, float(s.positions[0, 1]) - RADIUS)
        if s.velocities[0, 1] < 0.0 and top > 0.0:
            break
    mass = DENSITY * math.pi * RADIUS**2
    # against a rigid wall the spring is twice as stiff
    ratio = 0.5 * VISCOSITY * math.sqrt(2.0 * STIFFNESS / mass)
    restitution = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio**2))
    return top / high / restitution**2 - 1.0


def draw(path: Path, frames: list[ParticleFrame], fell: np.ndarray, line: float) -> None:
    """Paths of the boulders that fell, where all rest, and the energy line from the crest, `line` [rad]."""
    from matplotlib.collections import EllipseCollection

    from geodem.plotting.theme import INK, SOFT, new_figure, png, quiet_axes, style

    paths = np.array([frame.positions for frame in frames])
    with style():
        figure = new_figure(8.0, 4.1)
        axes = figure.add_subplot()
        ground = np.vstack([HILL[:-1], [[260.0, -20.0], [-10.0, -20.0]]])
        axes.fill(*ground.T, color="#e9e4dc", linewidth=0.0)
        axes.plot(*HILL.T, color=INK, linewidth=1.4)
        axes.plot(*paths[:, fell].transpose(2, 0, 1), color="#b06a3b", linewidth=0.7, alpha=0.55)
        for frame, colour in ((frames[0], "#c9b9ab"), (frames[-1], "#8c4a20")):
            axes.add_collection(
                EllipseCollection(
                    2.0 * frame.radii, 2.0 * frame.radii, np.zeros(len(frame.radii)), units="xy",
                    offsets=frame.positions, transOffset=axes.transData, facecolor=colour, edgecolor="none",
                )
            )  # fmt: skip
        start = paths[0, fell].mean(axis=0)
        reach = np.array([start[0], VIEW[1]])
        axes.plot(
            reach, start[1] - (reach - start[0]) * math.tan(line), color=SOFT, linewidth=1.0, linestyle="--"
        )
        axes.text(
            62.0, start[1] - (62.0 - start[0]) * math.tan(line) + 2.0, "energy line of the rolling friction",
            color=SOFT, fontsize=8.5,
        )  # fmt: skip
        axes.set_aspect("equal")
        axes.set_xlim(VIEW[:2])
        axes.set_ylim(VIEW[2:])
        axes.set_xlabel("distance [m]")
        axes.set_ylabel("height [m]")
        quiet_axes(axes)
        path.write_bytes(png(figure))


def main(out: str = "rock_fall-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    fell = last.positions[:, 0] > EDGE
    moved = (last.positions - first.positions)[fell]
    angles = np.degrees(np.arctan2(-moved[:, 1], moved[:, 0]))
    rests = float((np.hypot(*last.velocities.T) < 0.05).mean())
    fall = expected["fall"]
    low, high = fall["angle_low_deg"], fall["angle_high_deg"]
    rolling, bouncing = rolling_error(), bouncing_error()
    rows = [
        ("acceleration of a boulder that rolls, error", rolling, abs(rolling) <= expected["rolling"]["within"]),
        ("rebound of a boulder, error", bouncing, abs(bouncing) <= expected["bouncing"]["within"]),
        ("boulders", float(len(last.radii)), len(last.radii) == len(first.radii)),
        ("of these fell", float(fell.sum()), fell.sum() >= fall["fell"]),
        ("share at rest", rests, rests >= fall["stopped"]),
        ("median angle of reach [deg]", float(np.median(angles)), low <= np.median(angles) <= high),
        ("least angle of reach [deg]", float(angles.min()), angles.min() >= low),
    ]  # fmt: skip
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    print(f"farthest boulder: {last.positions[:, 0].max():.4g} m")
    draw(Path(out) / "fall.png", frames, fell, math.radians(low))
    print(f"Report: {out}/report.html, picture: {out}/fall.png")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
