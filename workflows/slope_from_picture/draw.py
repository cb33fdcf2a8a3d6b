"""Draws section.png: the section of ACADS EX3(a), as an engineer might export it from a drawing program.

Ground surface (20, 27.75) (43, 27.75) (67.5, 40) (84, 40) m, base at 20 m, a weak seam between 26.5 and 27.0 m;
ten pixels a metre, edges anti-aliased.
"""

from pathlib import Path

from PIL import Image, ImageDraw

PIXELS_PER_METRE = 10
SMOOTHING = 8
LEFT, RIGHT, BASE, TOP = 20.0, 84.0, 20.0, 41.0
SKY, SOIL, SEAM = "#ffffff", "#c8a464", "#b2182b"
GROUND = [(20, 20), (84, 20), (84, 40), (67.5, 40), (43, 27.75), (20, 27.75)]
WEAK = [(20, 26.5), (84, 26.5), (84, 27.0), (20, 27.0)]


def draw(path: Path) -> None:
    """Write the picture."""
    scale = PIXELS_PER_METRE * SMOOTHING
    size = (round((RIGHT - LEFT) * scale), round((TOP - BASE) * scale))
    picture = Image.new("RGB", size, SKY)
    pen = ImageDraw.Draw(picture)
    for corners, colour in ((GROUND, SOIL), (WEAK, SEAM)):
        # the pen includes the last pixel, hence the half
        pen.polygon([((x - LEFT) * scale - 0.5, (TOP - y) * scale - 0.5) for x, y in corners], fill=colour)
    picture.resize((size[0] // SMOOTHING, size[1] // SMOOTHING), Image.Resampling.BOX).save(
        path, optimize=True
    )


if __name__ == "__main__":
    draw(Path(__file__).parent / "section.png")
