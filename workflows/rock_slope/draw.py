"""Draws the sections of rock_slope and bolted_slope, one pixel a particle.

The slope of Zhao (2015), High Performance Computing and the Discrete Element Model, section 4.3.3, whose drawing
(figure 4.8) is lost. What the text gives: about 700 m x 400 m, base rock, weak layer and top block, 10,951 particles of
"mean size" 2.5 m, which is their radius: one particle a pixel of 5 m, as its chapter 2 makes particles of pictures.
What is assumed: see README.md.
"""

from __future__ import annotations

import math
from pathlib import Path

from PIL import Image
from shapely import Point, Polygon
from shapely.prepared import prep

HERE = Path(__file__).resolve().parent
PIXEL = 5.0
WIDE, HIGH = 740.0, 420.0
FOOT, CREST = (50.0, 170.0), (246.0, 420.0)
DAYLIGHT = 20.0
"""Height of the layer's middle line above the foot, where it would meet the face [m]: four particles."""
BEHIND = 250.0
"""Of the crest: where the layer's middle line meets the top [m], as far as the face is high."""
THICK = 15.0
"""Of the layer [m]: three particles."""
BRIDGE = 20.0
"""Rock between the layer and the face [m]: four particles."""
BOLTS, BOLT_WIDTH, ANCHORAGE = 5, 10.0, 60.0
"""Number; two particles wide; length beyond the layer [m]."""
COLOURS = {"base": "#8d99a6", "block": "#c9b28a", "weak": "#b5531f", "bolt": "#1f3a5f"}

Point2 = tuple[float, float]


def outline() -> Polygon:
    """The slope."""
    return Polygon([(0, 0), (WIDE, 0), (WIDE, HIGH), CREST, FOOT, (0, FOOT[1])])


def _along(first: Point2, last: Point2, way: float) -> Point2:
    length = math.dist(first, last)
    x, y = (a + way * (b - a) / length for a, b in zip(first, last, strict=True))
    return x, y


def face_point(height: float) -> Point2:
    """On the face, so high above the foot."""
    return _along(FOOT, CREST, height * math.dist(FOOT, CREST) / (CREST[1] - FOOT[1]))


def layer() -> Polygon:
    """The weak layer: it ends parallel to the face, with the bridge between."""
    start, end = face_point(DAYLIGHT), (CREST[0] + BEHIND, HIGH)
    length = math.dist(start, end)
    along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length)
    up = (-along[1], along[0])
    face = math.dist(FOOT, CREST)
    inward = ((CREST[1] - FOOT[1]) / face, -(CREST[0] - FOOT[0]) / face)

    def at(way: float, side: float) -> Point2:
        x, y = (s + way * a + side * u for s, a, u in zip(start, along, up, strict=True))
        return x, y

    def bridge(side: float) -> float:
        away = sum((p - f) * n for p, f, n in zip(at(0.0, side), FOOT, inward, strict=True))
        return (BRIDGE - away) / sum(a * n for a, n in zip(along, inward, strict=True))

    half = 0.5 * THICK
    corners = [
        at(bridge(-half), -half),
        at(length + 40.0, -half),
        at(length + 40.0, half),
        at(bridge(half), half),
    ]
    return Polygon(corners).intersection(outline())


def block() -> Polygon:
    """The ground above the layer's middle line."""
    return Polygon([face_point(DAYLIGHT), CREST, (CREST[0] + BEHIND, HIGH)])


def bolts() -> list[Polygon]:
    """Across the face, evenly spread over it, each to 60 m beyond the layer."""
    start, end = face_point(DAYLIGHT), (CREST[0] + BEHIND, HIGH)
    face = math.dist(FOOT, CREST)
    inward = ((CREST[1] - FOOT[1]) / face, -(CREST[0] - FOOT[0]) / face)
    up = (-(end[1] - start[1]), end[0] - start[0])
    found = []
    for k in range(1, BOLTS + 1):
        head = face_point((CREST[1] - FOOT[1]) * k / (BOLTS + 1))
        reach = sum((s - h) * u for s, h, u in zip(start, head, up, strict=True))
        reach /= sum(i * u for i, u in zip(inward, up, strict=True))
        tip = tuple(h + (reach + ANCHORAGE) * i for h, i in zip(head, inward, strict=True))
        half = (0.5 * BOLT_WIDTH * -inward[1], 0.5 * BOLT_WIDTH * inward[0])
        corners = [
            (p[0] + s * half[0], p[1] + s * half[1]) for p, s in ((head, 1), (tip, 1), (tip, -1), (head, -1))
        ]
        found.append(Polygon(corners).intersection(outline()))
    return found


def draw(path: Path, *, bolted: bool) -> None:
    """One pixel a particle, its colour that of what lies at its middle."""
    parts = [("base", outline()), ("block", block()), ("weak", layer())]
    parts += [("bolt", bolt) for bolt in bolts()] if bolted else []
    prepared = [(COLOURS[name], prep(shape)) for name, shape in parts]
    columns, rows = round(WIDE / PIXEL), round(HIGH / PIXEL)
    image = Image.new("RGB", (columns, rows), "#ffffff")
    for i in range(columns):
        for j in range(rows):
            middle = Point((i + 0.5) * PIXEL, HIGH - (j + 0.5) * PIXEL)
            for colour, shape in prepared:
                if shape.contains(middle):
                    image.putpixel((i, j), tuple(bytes.fromhex(colour[1:])))
    image.save(path)


if __name__ == "__main__":
    draw(HERE / "section.png", bolted=False)
    draw(HERE.parent / "bolted_slope" / "section.png", bolted=True)
