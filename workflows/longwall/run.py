"""The workflow from Python: a seam is taken away under rock; subsidence and pieces are held to expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.io.frame_reading import frame_paths, read_frame
from geodem.measure.caving import subsidence, swelling
from geodem.plotting.frame_panels import write_frame_panels

HERE = Path(__file__).resolve().parent
EDGE, SIDE = 30.0, 60.0
"""Of the pillar, and the middle of the panel [m]."""
SEAM, COVER = 4.0, 24.0
"""Thickness of the seam and of the rock over it [m]."""
VIEW = (-1.0, 63.0, -7.0, 26.0)
ROCK = np.array([[5.0, 0.0], [55.0, 22.0]])
CAVED = np.array([[EDGE + 4.0, 0.5 - SEAM], [SIDE - 1.0, 18.0]])
"""Within the rock before, within what has caved [m]."""


def main(out: str = "longwall-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    stages = result["stages"]
    broken = sum(stages[0]["new_cracks"].values()) / result["bonds"]
    taken = sum(stage.get("particles_removed", 0) for stage in stages)
    lost = len(first.radii) - len(last.radii) - taken
    trough = subsidence(first.positions, first.radii, last.positions, last.radii, columns=40)
    over_panel = float(np.nanmedian(trough.depth[trough.place > 0.5 * (EDGE + SIDE)])) / SEAM
    over_pillar = float(np.nanmedian(trough.depth[trough.place < EDGE])) / SEAM
    swollen = swelling(first.positions, first.radii, ROCK, last.positions, last.radii, CAVED)
    # what is over the panel now fills the seam and the cover less the trough
    seam = SEAM * (SIDE - EDGE)
    now = (SEAM + COVER) * (SIDE - EDGE) - trough.area
    balance = (trough.area + now * (1.0 - 1.0 / swollen)) / seam
    largest = result["fragments"]["largest_share_of_mass"]
    limits = expected["subsidence"]
    rows = [
        ("share of the bonds that break in settling", broken, broken <= expected["settling"]["broken"]),
        ("particles lost", lost, lost == expected["mass"]["lost"]),
        ("subsidence over the panel, over the seam", over_panel, _within(over_panel, limits["over_panel"])),
        ("subsidence over the pillar, over the seam", over_pillar, over_pillar <= limits["over_pillar"]),
        ("trough and swelling over the seam", balance, _within(balance, expected["balance"]["share"])),
        ("share of the largest piece", largest, _within(largest, expected["pieces"]["largest_share"])),
    ]
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    chosen = [frames[round(k * (len(frames) - 1) / 3)] for k in range(4)]
    write_frame_panels(Path(out) / "mining.png", chosen, titles=["", "", "", ""], view=VIEW)
    print(f"Report: {out}/report.html, picture: {out}/mining.png")
    return 0 if all(good for *_, good in rows) else 1


def _within(value: float, ends: list[float]) -> bool:
    return ends[0] <= value <= ends[1]


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
