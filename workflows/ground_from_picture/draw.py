"""Draws section.png: a fill of gravel with boulders on clay and rock, as an engineer might export it from a drawing.

30 m by 16 m, ten pixels a metre, edges anti-aliased.
"""

from math import cos, pi, sin
from pathlib import Path

from PIL import Image, ImageDraw

PIXELS_PER_METRE = 10
SMOOTHING = 8
WIDTH, HEIGHT = 30.0, 16.0
SKY, GRAVEL, BOULDER, CLAY, ROCK = "#ffffff", "#d9b36c", "#8a8f98", "#b5651d", "#5b6770"
ROCK_TOP = [(0, 3.0), (6, 2.2), (12, 3.6), (19, 2.6), (25, 3.8), (30, 3.4)]
CLAY_TOP = [(0, 6.0), (30, 6.0)]
FILL_TOP = [(0, 5.0), (6, 6.0), (18, 14.0), (30, 14.0)]
# middle, half axes [m] and turn [deg]
BOULDERS = [
    (13.0, 8.3, 1.1, 0.8, 20), (17.2, 11.2, 0.9, 0.7, 65), (20.5, 8.6, 1.4, 0.9, -15), (24.0, 12.0, 1.0, 0.8, 40),
    (27.2, 8.4, 1.2, 1.0, 10), (21.6, 11.6, 0.7, 0.6, 0), (16.6, 8.0, 0.7, 0.5, 30), (27.4, 11.6, 0.8, 0.6, 80),
]  # fmt: skip


def draw(path: Path) -> None:
    """Write the picture."""
    scale = PIXELS_PER_METRE * SMOOTHING
    size = (round(WIDTH * scale), round(HEIGHT * scale))
    picture = Image.new("RGB", size, SKY)
    pen = ImageDraw.Draw(picture)

    def fill(corners: list[tuple[float, float]], colour: str) -> None:
        # the pen includes the last pixel, hence the half
        pen.polygon([(x * scale - 0.5, (HEIGHT - y) * scale - 0.5) for x, y in corners], fill=colour)

    for top, colour in ((FILL_TOP, GRAVEL), (CLAY_TOP, CLAY), (ROCK_TOP, ROCK)):
        fill([*top, (WIDTH, 0.0), (0.0, 0.0)], colour)
    for x, y, a, b, turn in BOULDERS:
        c, s = cos(pi * turn / 180), sin(pi * turn / 180)
        ring = [(a * cos(pi * k / 24), b * sin(pi * k / 24)) for k in range(48)]
        fill([(x + c * u - s * v, y + s * u + c * v) for u, v in ring], BOULDER)
    picture.resize((size[0] // SMOOTHING, size[1] // SMOOTHING), Image.Resampling.BOX).save(
        path, optimize=True
    )


if __name__ == "__main__":
    draw(Path(__file__).parent / "section.png")
