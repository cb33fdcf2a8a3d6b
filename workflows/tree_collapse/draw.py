"""Draws tree.png: a fir of 846 pixels, each of them a disc."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

GREEN, BROWN, SKY = (46, 110, 62), (122, 84, 52), (255, 255, 255)
TIERS = ((1, 13), (7, 23), (11, 31), (17, 41))
"""Widths of the first and the last row of every tier; each row is two pixels wider than the one above."""
TRUNK = (3, 18)
"""Width and height."""


def fir() -> np.ndarray:
    """The picture (rows, columns, 3), the top row first."""
    widths = [width for first, last in TIERS for width in range(first, last + 1, 2)]
    wide = max(widths)
    rows = [(width, GREEN) for width in widths] + [(TRUNK[0], BROWN)] * TRUNK[1]
    picture = np.full((len(rows), wide, 3), SKY, dtype=np.uint8)
    for number, (width, colour) in enumerate(rows):
        left = (wide - width) // 2
        picture[number, left : left + width] = colour
    return picture


def draw(path: Path) -> None:
    """Write the picture."""
    Image.fromarray(fir()).save(path, optimize=True)


if __name__ == "__main__":
    draw(Path(__file__).parent / "tree.png")
