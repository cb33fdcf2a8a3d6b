"""A section of the ground from a picture whose colours are the materials."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geodem.builders.image_labels import LabelImage, label_image
from geodem.builders.section import Region, Section
from geodem.errors import InputError

__all__ = ["LabelImage", "label_image", "section_from_image", "section_from_labels"]


def section_from_image(
    path: str | Path,
    *,
    scale: float,
    legend: Mapping[str, str],
    background: Sequence[str] | None = None,
    origin: tuple[float, float] = (0.0, 0.0),
    y_axis: Literal["up", "down"] = "up",
    picture: Path | None = None,
    place: str = "section",
) -> Section:
    """Trace the materials of a picture.

    Edges are placed to a part of a pixel where the drawing program blended them. Straight edges are fitted as
    straight lines; nearly upright and level ones become exactly so, and those along the edge of the picture
    lie on it.

    Parameters
    ----------
    path : str or Path
        PNG, BMP, JPEG, GIF, TIFF or WebP file. A drawing saved as PNG gives the best edges.
    scale : float
        Size of a pixel [m].
    legend : mapping of str to str
        Material of each colour, for example ``{"#8c6d31": "soil", "#d62728": "seam"}``.
    background : sequence of str, optional
        Colours that are not ground; left out: white, unless the legend lists it. Transparent pixels are
        always background.
    origin : (float, float)
        Coordinates of the lower left corner of the section's frame [m].
    y_axis : {"up", "down"}
        "up" for a picture that shows the ground as it stands; "down" for one that was stored upside down (the
        first row of the file is the lowest), which is turned over.
    picture : Path, optional
        Where to write the picture that shows unlisted colours (PNG); left out: a new temporary folder.
    place : str
        Table of the case file that the errors name.

    Returns
    -------
    Section
        Coordinates [m]: x to the right from the left edge of the picture, y upwards from its lower edge.

    Raises
    ------
    InputError
        A scale, origin or axis that cannot be used, and everything that `label_image` refuses.
    """
    _check_frame(scale, origin, y_axis, place)
    image = label_image(path, legend=legend, background=background, picture=picture, place=place)
    return section_from_labels(image, scale=scale, origin=origin, y_axis=y_axis, place=place)


def section_from_labels(
    image: LabelImage,
    *,
    scale: float,
    origin: tuple[float, float] = (0.0, 0.0),
    y_axis: Literal["up", "down"] = "up",
    place: str = "section",
) -> Section:
    """Trace a picture that `label_image` has read; parameters as in `section_from_image`."""
    import shapely

    from geodem.builders.image_outlines import outline_polygons

    _check_frame(scale, origin, y_axis, place)
    rows = image.labels.shape[0]

    def to_metres(points: NDArray[np.float64]) -> NDArray[np.float64]:
        height = rows - points[:, 1] if y_axis == "up" else points[:, 1]
        return np.stack([points[:, 0] * scale + origin[0], height * scale + origin[1]], axis=1)

    traced = outline_polygons(image)
    # Order by material and then from the largest piece on, so that the order does not hang on the tracing.
    traced.sort(key=lambda item: (item[0], -item[1].area, item[1].bounds))
    return Section(
        tuple(
            Region(image.materials[label - 1], shapely.transform(polygon, to_metres))
            for label, polygon in traced
        )
    )


def _check_frame(scale: float, origin: tuple[float, float], y_axis: str, place: str) -> None:
    if not (math.isfinite(scale) and scale > 0.0):
        raise InputError(
            f"{place}.scale",
            "the size of a pixel must be positive and finite [m/px]",
            'Give it with its unit, for example "0.25 m/px".',
            value=scale,
        )
    if len(origin) != 2 or not all(math.isfinite(value) for value in origin):
        raise InputError(
            f"{place}.origin", "the origin must be two finite lengths", "Give x and y [m].", value=origin
        )
    if y_axis not in ("up", "down"):
        raise InputError(
            f"{place}.y_axis",
            "the direction of the picture is not known",
            'Give "up" or "down".',
            value=y_axis,
        )
