"""The workflow from Python: a support moves down under rock; subsidence and pieces are held to expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.io.frame_reading import frame_paths, read_frame
from geodem.measure.caving import subsidence
from geodem.plotting.frame_panels import write_frame_panels

HERE = Path(__file__).resolve().parent
EDGE = 30.0
"""Where the support begins [m]."""
VIEW = (-1.0, 63.0, -6.0, 26.0)


def main(out: str = "longwall-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    kept = float((last.radii**2).sum() / (first.radii**2).sum())
    trough = subsidence(first.positions, first.radii, last.positions, last.radii)
    over_support = float(np.nanmedian(trough.depth[trough.place > EDGE + 10.0]))
    over_floor = float(np.nanmedian(trough.depth[trough.place < EDGE - 10.0]))
    limits = expected["subsidence"]
    largest = result["fragments"]["largest_share_of_mass"]
    rows = [
        ("share of the mass that is there in the end", kept, abs(kept - expected["mass"]["share"]) < 1e-12),
        ("subsidence over the support [m]", over_support,
         over_support >= limits["over_support"] * limits["support_m"]),
        ("subsidence over the floor [m]", over_floor, over_floor <= limits["over_floor"] * limits["support_m"]),
        ("share of the largest piece", largest, largest >= expected["pieces"]["largest_share"]),
    ]  # fmt: skip
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    chosen = [frames[round(k * (len(frames) - 1) / 3)] for k in range(4)]
    write_frame_panels(Path(out) / "mining.png", chosen, titles=["", "", "", ""], view=VIEW)
    print(f"Report: {out}/report.html, picture: {out}/mining.png")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
