"""The workflow from Python: rock caves into an undercut; draw, pieces, swelling, subsidence as in expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.io.frame_reading import frame_paths, read_frame
from geodem.measure.caving import drawn, subsidence, swelling
from geodem.plotting.frame_panels import write_frame_panels

HERE = Path(__file__).resolve().parent
FLOOR = -3.0
"""Below this level rock is drawn [m]."""
MIDDLE = 30.0
VIEW = (-1.0, 61.0, -29.0, 26.0)
ROCK = np.array([[5.0, 0.0], [55.0, 22.0]])
DRIFT = np.array([[10.0, -11.0], [50.0, -4.0]])
"""Within the rock before, within the full drift [m]."""
FULL = "first draw"
"""The stage after which the drift is full."""


def main(out: str = "block_caving-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    share = [drawn(f.positions, f.radii**2, FLOOR) / float((first.radii**2).sum()) for f in frames]
    stages = {stage["name"]: stage for stage in result["stages"]}
    taken = stages["undercut"]["particles_removed"]
    steps = np.cumsum([stage["steps"] for stage in result["stages"]])
    full = next(f for f in frames if f.step == steps[list(stages).index(FULL)])
    swollen = swelling(first.positions, first.radii, ROCK, full.positions, full.radii, DRIFT)
    trough = subsidence(first.positions, first.radii, last.positions, last.radii)
    sides = np.nan_to_num(trough.depth[[0, 1, -2, -1]])
    below = int((last.positions[:, 1] < FLOOR).sum())
    pieces = result["fragments"]["pieces"] + result["fragments"]["single_particles"]
    limits = expected["subsidence"]
    broken = sum(stages["settle"]["new_cracks"].values()) / result["bonds"]
    lost = len(first.radii) - len(last.radii) - taken
    low, high = expected["swelling"]["drift"]
    rows = [
        ("share of the bonds that break in settling", broken, broken <= expected["settling"]["broken"]),
        ("particles lost", lost, lost == expected["mass"]["lost"]),
        ("volume of the rock in the drift over what it was", swollen, low <= swollen <= high),
        ("drawn share", share[-1], share[-1] >= expected["draw"]["at_least"]),
        ("largest fall of the drawn share between two moments", -min(np.diff(share)), min(np.diff(share)) > -0.005),
        ("discs of a piece, mean of what was drawn", below / pieces,
         below / pieces <= expected["draw"]["grains_per_piece"]),
        ("greatest subsidence [m]", trough.greatest, trough.greatest > 0.0),
        ("centre of the trough from the middle [m]", abs(trough.centre - MIDDLE),
         abs(trough.centre - MIDDLE) <= limits["centre_off"]),
        ("subsidence at the sides over the greatest", float(sides.max() / trough.greatest),
         sides.max() <= limits["beside"] * trough.greatest),
    ]  # fmt: skip
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    chosen = [frames[round(k * (len(frames) - 1) / 3)] for k in range(4)]
    titles = [
        f"{100 * drawn(f.positions, f.radii**2, FLOOR) / (first.radii**2).sum():.0f} % drawn" for f in chosen
    ]
    write_frame_panels(Path(out) / "caving.png", chosen, titles=titles, view=VIEW)
    print(f"Report: {out}/report.html, picture: {out}/caving.png")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
