"""The workflow from Python: the fir falls down; mass, fall and density of the heap are held to expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np

import geodem
from geodem.io.frame_reading import frame_paths, read_frame

HERE = Path(__file__).resolve().parent
LEFT, RIGHT = -100.0, 920.0
"""Walls of the container [m]."""


def main(out: str = "tree_collapse-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    x, y = last.positions.T
    inside = float(((x > LEFT) & (x < RIGHT) & (y > 0.0)).mean())
    # all discs are alike
    height = np.array([frame.positions[:, 1].mean() for frame in frames])
    # below the level that nine tenths of the discs lie under: the upper side is not level
    level = float(np.quantile(y, 0.8))
    low = y < level
    solid = float((np.pi * last.radii[low] ** 2).sum()) / ((RIGHT - LEFT) * level)
    rows = [
        ("discs", float(result["particles"]), result["particles"] == expected["picture"]["discs"]),
        ("share in the container", inside, inside >= expected["mass"]["inside"]),
        ("mean height before [m]", float(height[0]), len(first.radii) == len(last.radii)),
        ("mean height after over before", float(height[-1] / height[0]),
         height[-1] < (1.0 - expected["energy"]["lost_from"]) * height[0]),
        ("solid fraction below four fifths of the discs", solid,
         expected["heap"]["solid_low"] <= solid <= expected["heap"]["solid_high"]),
    ]  # fmt: skip
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    print(f"Report: {out}/report.html")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
