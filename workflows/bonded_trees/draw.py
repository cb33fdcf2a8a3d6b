"""Draws trees.png: three firs of 2,539 pixels in all, each of them a disc; the middle one has a star."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
from PIL import Image

HERE = Path(__file__).resolve().parent
GAP = 4
"""Columns between two firs."""


def trees() -> np.ndarray:
    """The picture (rows, columns, 3), the top row first."""
    one = runpy.run_path(str(HERE.parent / "tree_collapse" / "draw.py"), run_name="imported")
    fir, sky = one["fir"](), one["SKY"]
    high, wide, _ = fir.shape
    picture = np.full((high + 1, 3 * wide + 2 * GAP, 3), sky, dtype=np.uint8)
    for number in range(3):
        left = number * (wide + GAP)
        picture[1:, left : left + wide] = fir
    picture[0, wide + GAP + wide // 2] = one["GREEN"]
    return picture


if __name__ == "__main__":
    Image.fromarray(trees()).save(HERE / "trees.png", optimize=True)
