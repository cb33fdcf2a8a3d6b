"""Draws the sections of frame_on_rock and frame_over_cavern, one pixel a particle.

The frame on jointed rock of Zhao (2015), High Performance Computing and the Discrete Element Model, section 4.3.4,
whose drawings (figures 4.16 and 4.17) are lost. What the text gives: a megaframe on two blocks with a weak fault
between them, 9,129 particles of radius 2.5 m, a large cavern just below the frame, everything made of a picture. What
is assumed: see README.md.
"""

from __future__ import annotations

import math
from pathlib import Path

from PIL import Image

HERE = Path(__file__).resolve().parent
PIXEL = 5.0
WIDE, GROUND, HIGH = 645.0, 325.0, 485.0
FAULT = ((302.0, 0.0), (410.0, GROUND))
"""Left edge of the fault, from below [m]; it is 30 m wide along x."""
FAULT_WIDTH = 30.0
MEMBERS = (
    (215.0, 325.0, 430.0, 340.0), (215.0, 325.0, 230.0, 485.0), (315.0, 325.0, 330.0, 485.0),
    (415.0, 325.0, 430.0, 485.0), (215.0, 375.0, 430.0, 390.0), (215.0, 420.0, 475.0, 435.0),
    (215.0, 470.0, 475.0, 485.0),
)  # fmt: skip
"""Of the frame: left, bottom, right, top [m]; 15 m thick, the two upper floors overhang on the right."""
CAVERN = (322.5, 205.0, 50.0, 30.0, 30.0)
"""Middle, floor, half its width, height of its walls, rise of its roof [m]; the crown is 60 m below the ground."""
COLOURS = {"rock1": "#c9b28a", "rock2": "#8d99a6", "fault": "#b5531f", "frame": "#1f3a5f"}


def in_cavern(x: float, y: float) -> bool:
    """Whether a point [m] is in the cavern."""
    middle, floor, half, walls, rise = CAVERN
    away = (x - middle) / half
    return abs(away) < 1.0 and floor < y < floor + walls + rise * math.sqrt(1.0 - away * away)


def material(x: float, y: float, *, cavern: bool) -> str | None:
    """What lies at a point [m]."""
    if y > GROUND:
        inside = any(left < x < right and bottom < y < top for left, bottom, right, top in MEMBERS)
        return "frame" if inside else None
    if cavern and in_cavern(x, y):
        return None
    (x0, y0), (x1, y1) = FAULT
    edge = x0 + (x1 - x0) * (y - y0) / (y1 - y0)
    return "rock1" if x < edge else "fault" if x < edge + FAULT_WIDTH else "rock2"


def draw(path: Path, *, cavern: bool) -> None:
    """One pixel a particle, its colour that of what lies at its middle."""
    columns, rows = round(WIDE / PIXEL), round(HIGH / PIXEL)
    image = Image.new("RGB", (columns, rows), "#ffffff")
    for i in range(columns):
        for j in range(rows):
            name = material((i + 0.5) * PIXEL, HIGH - (j + 0.5) * PIXEL, cavern=cavern)
            if name is not None:
                image.putpixel((i, j), tuple(bytes.fromhex(COLOURS[name][1:])))
    image.save(path)


if __name__ == "__main__":
    draw(HERE / "section.png", cavern=False)
    draw(HERE.parent / "frame_over_cavern" / "section.png", cavern=True)
