"""The workflow from Python: the pressure on a door that sinks, held to expected.toml."""

from __future__ import annotations

import csv
import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.io.frame_reading import ParticleFrame, frame_paths, read_frame

HERE = Path(__file__).resolve().parent
DOOR, HEIGHT, DENSITY, GRAVITY, SPEED, TIME = 0.4, 0.4, 1600.0, 9.81, 12e-3, 1.0
MIDDLE = 1.0
"""Of the door [m]."""
FLOOR = -0.01
WINDOW = 0.0025
"""Movement over the width of the door that a pressure is the mean of."""


def pressures(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Movement of the door over its width, and pressure over gamma H, means of windows."""
    with path.open() as file:
        rows = [row for row in csv.DictReader(file) if float(row["stage [-]"]) == 2.0]
    time = np.array([float(row["time [s]"]) for row in rows])
    force = np.abs([float(row["force on door, y [N/m]"]) for row in rows])
    moved = (time - time[0]) * SPEED / DOOR
    number = (moved / WINDOW).astype(int)
    # the last window is not whole
    windows = np.unique(number)[:-1]
    mean = np.array([force[number == k].mean() for k in windows]) / DOOR / (DENSITY * GRAVITY * HEIGHT)
    return (windows + 0.5) * WINDOW, mean


def draw(
    path: Path, frames: tuple[ParticleFrame, ParticleFrame], curve: tuple[np.ndarray, np.ndarray],
    limits: tuple[float, float],
) -> None:  # fmt: skip
    """What sank with the door, and the pressure by its movement."""
    from matplotlib.collections import EllipseCollection

    from geodem.plotting.theme import INK, STABLE, new_figure, png, quiet_axes, style

    before, after = frames
    sunk = 100.0 * (before.positions - after.positions)[:, 1] / DOOR
    with style():
        figure = new_figure(8.6, 3.3)
        ground, axes = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.5, 1.0]})
        discs = EllipseCollection(
            2.0 * after.radii, 2.0 * after.radii, np.zeros(len(after.radii)), units="xy", offsets=after.positions,
            transOffset=ground.transData, array=np.clip(sunk, 0.0, None), cmap="YlGnBu", edgecolor="none",
        )  # fmt: skip
        ground.add_collection(discs)
        drop = FLOOR - SPEED * TIME
        left, right = MIDDLE - 0.5 * DOOR, MIDDLE + 0.5 * DOOR
        ground.plot([0.4, left], [FLOOR, FLOOR], color=INK, linewidth=2.0)
        ground.plot([right, 1.6], [FLOOR, FLOOR], color=INK, linewidth=2.0)
        ground.plot([left, right], [drop, drop], color=INK, linewidth=2.0)
        ground.set_xlim(0.4, 1.6)
        ground.set_ylim(-0.04, 1.08 * HEIGHT)
        ground.set_aspect("equal")
        ground.set_axis_off()
        figure.colorbar(
            discs,
            ax=ground,
            orientation="horizontal",
            shrink=0.6,
            pad=0.02,
            label="settlement over the width [%]",
        )
        axes.axhspan(*limits, color=STABLE, alpha=0.12, linewidth=0.0, label="limit analysis to Terzaghi")
        axes.plot(100.0 * curve[0], curve[1], color=STABLE, linewidth=1.4, label="discs")
        axes.set_xlabel("movement of the door over its width [%]")
        axes.set_ylabel("pressure over gamma H")
        axes.set_ylim(0.0, 1.1)
        axes.legend(loc="lower left")
        quiet_axes(axes)
        path.write_bytes(png(figure))


def main(out: str = "trapdoor-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())["pressure"]
    geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    moved, pressure = pressures(Path(out) / "history.csv")
    least, at = float(pressure.min()), float(moved[pressure.argmin()])
    low, high = expected["limit_analysis"], expected["terzaghi"]
    slack = expected["slack"]
    # few discs across the door hang on its edges
    lowest = 0.0 if quickly else low * (1.0 - slack)
    rows = [
        ("pressure at first, over gamma H", float(pressure[0]), pressure[0] > least),
        ("least pressure, over gamma H", least, lowest < least <= high * (1.0 + slack)),
        ("movement over the width there", at, 0.0 < at <= expected["movement"]),
    ]
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    draw(Path(out) / "pressure.png", (frames[0], frames[-1]), (moved, pressure), (low, high))
    print(f"Report: {out}/report.html, picture: {out}/pressure.png")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
