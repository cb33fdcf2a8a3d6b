"""Pictures of the bodies of `ground_bodies`: docs/pictures/body_*.png."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body_filling import BodyFilling
from geodem.builders.segmentation import Segmentation
from geodem.plotting.bodies import filling_figure, filling_picture, segmentation_figure
from geodem.plotting.theme import png, style

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"

COLOURS = 256

TITLES = {
    "drawing": "A drawing with a legend, as discs",
    "slices": "Balls in clay from slices, cut open",
    "channels": "River channels in a flood plain, down from half of the height",
    "terrain": "Cut-out of an elevation model, with a weathered layer",
    "gravel": "Gravel",
    "brick": "Bricks",
}
FILLS = {
    "terrain": ("#f2dba6", "#cfd8e0"),
    "slices": ("#d9b382", "#8496a6"),
    "channels": ("#e6d3ad", "#4f86b5"),
}


def draw(name: str, filling: BodyFilling, folder: Path = PICTURES) -> Path:
    """A picture of the particles of a body."""
    with style():
        if filling.dimension == 2:
            figure = filling_figure(filling, title=TITLES[name])
        else:
            figure = filling_picture(
                filling, title=TITLES[name], shown=_shown(name, filling), fills=FILLS[name],
                shade_height=name == "terrain", view=(-55.0, 32.0),
            )  # fmt: skip
        return _write(png(figure), folder / f"body_{name}.png")


def _shown(name: str, filling: BodyFilling) -> NDArray[np.bool_] | None:
    """What is left where something is cut away to look inside."""
    if name == "slices":
        return np.asarray((filling.material != 0) | (filling.positions[:, 1] > 0.42))
    if name == "channels":
        return np.asarray(filling.positions[:, 2] < 50.0)
    return None


def draw_segmentation(
    name: str, original: NDArray[np.generic], cut: Segmentation, filling: BodyFilling, folder: Path = PICTURES
) -> Path:
    """A photograph, its thresholds, classes, grains and discs."""
    with style():
        drawn = png(segmentation_figure(original, cut, filling, title=TITLES[name]))
        return _write(drawn, folder / f"body_{name}.png")


def _write(drawn: bytes, path: Path) -> Path:
    """A PNG of few colours, which is a quarter of the size."""
    from PIL import Image

    picture = Image.open(io.BytesIO(drawn)).convert("RGB")
    picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE).save(
        path, optimize=True
    )
    return path
