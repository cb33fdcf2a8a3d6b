"""What the bodies of `ground_bodies` are made from, and how much of each material it holds by another count."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.terrain import Terrain

# --- a drawing: corners in units of two pixels or 0.1 m, y downwards ----------------------------------------

UNIT = 0.1
SECTION_SCALE = 0.5 * UNIT
SIZE = (1200, 520)
COLOURS = {"soil": "#c8a464", "clay": "#8c6d31", "rock": "#7f8c99", "boulder": "#4d5964"}
LEGEND = {colour: name for name, colour in COLOURS.items()}
POLYGONS = {
    "soil": [(0, 260), (0, 150), (180, 150), (330, 60), (600, 60), (600, 260)],
    "clay": [(0, 260), (0, 190), (600, 150), (600, 260)],
    "rock": [(0, 260), (0, 225), (250, 215), (600, 190), (600, 260)],
}
BOULDER = ((470.0, 108.0), 30.0)
FINER = 4


def _section_areas() -> dict[str, float]:
    """Areas [m2] by material, a later polygon over the earlier ones."""
    shapes = {name: shapely.Polygon(corners) for name, corners in POLYGONS.items()}
    boulder = np.pi * BOULDER[1] ** 2
    units = {
        "soil": shapes["soil"].difference(shapes["clay"]).difference(shapes["rock"]).area - boulder,
        "clay": shapes["clay"].difference(shapes["rock"]).area,
        "rock": shapes["rock"].area,
        "boulder": boulder,
    }
    return {name: float(area) * UNIT**2 for name, area in units.items()}


SECTION_AREAS = _section_areas()


def draw_section(path: Path) -> Path:
    """Draw the section, pixels on its edges blended by the share of each colour."""
    from PIL import Image

    across, down = (FINER * side for side in SIZE)
    x, y = np.meshgrid(*((np.arange(count) + 0.5) * SECTION_SCALE / UNIT / FINER for count in (across, down)))
    picture = np.full((down, across, 3), 255.0)
    for name, corners in POLYGONS.items():
        shape = shapely.Polygon(corners)
        shapely.prepare(shape)
        picture[shapely.contains_xy(shape, x, y)] = _rgb(name)
    (left, top), radius = BOULDER
    picture[np.hypot(x - left, y - top) < radius] = _rgb("boulder")
    blended = picture.reshape(SIZE[1], FINER, SIZE[0], FINER, 3).mean(axis=(1, 3))
    Image.fromarray(blended.round().astype(np.uint8)).save(path)
    return path


def _rgb(name: str) -> list[int]:
    return [int(COLOURS[name][k : k + 2], 16) for k in (1, 3, 5)]


# --- slices through balls -----------------------------------------------------------------------------------

VOXEL = (0.01, 0.01, 0.0125)
STACK = (96, 80, 100)
"""Slices, rows, columns."""
BALLS = [((0.3, 0.3, 0.45), 0.22), ((0.7, 0.45, 0.8), 0.27), ((0.75, 0.25, 0.25), 0.18)]
"""Centre x, y, z and radius [m]; they do not touch."""


def balls_in_clay(folder: Path) -> dict[str, float]:
    """Draw the slices, named so that only their numbers sort them; volumes [m3] by material."""
    from PIL import Image

    slices, rows, columns = STACK
    x = (np.arange(columns) + 0.5) * VOXEL[0]
    y = (rows - 0.5 - np.arange(rows)) * VOXEL[1]
    for number in range(slices):
        z = (number + 0.5) * VOXEL[2]
        inside = np.zeros((rows, columns), dtype=bool)
        for (a, b, c), radius in BALLS:
            inside |= (x[None, :] - a) ** 2 + (y[:, None] - b) ** 2 + (z - c) ** 2 < radius**2
        picture = np.where(inside[..., None], (0x7F, 0x8C, 0x99), (0xB0, 0x7D, 0x4F)).astype(np.uint8)
        Image.fromarray(picture).save(folder / f"slice-{number}.png")
    ball = sum(4.0 / 3.0 * np.pi * radius**3 for _, radius in BALLS)
    whole = float(np.prod(np.array(STACK[::-1]) * VOXEL))
    return {"clay": whole - ball, "ball": ball}


# --- files of other libraries -------------------------------------------------------------------------------


def photograph(name: str) -> NDArray[np.uint8]:
    """One of the grey photographs that come with scikit-image."""
    from skimage import data

    return np.asarray(getattr(data, name)())


def classes_by_scikit_image(
    picture: NDArray[np.uint8], *, smoothing: float, smallest: int, lighting: float | None = None
) -> tuple[float, NDArray[np.bool_]]:
    """Otsu's threshold and the light class of a photograph, by scikit-image's own filters one after the other."""
    from skimage import filters, morphology, util

    grey = util.img_as_float(picture)
    if lighting is not None:
        even = grey - filters.gaussian(grey, lighting, mode="reflect") + grey.mean()
        grey = np.clip(even, 0.0, 1.0)
    grey = filters.gaussian(grey, smoothing)
    threshold = float(filters.threshold_otsu(grey))
    light = morphology.remove_small_objects(grey > threshold, max_size=smallest - 1, connectivity=1)
    return threshold, morphology.remove_small_holes(light, max_size=smallest - 1, connectivity=1)


def channels_file() -> Path:
    """pyvista's example of river channels."""
    from pyvista import examples

    return Path(examples.__file__).with_name("channels.vti")


def channels_volumes() -> dict[str, float]:
    """Volumes [m3] of its two materials: voxels as VTK's threshold filter counts them."""
    import pyvista

    image: Any = pyvista.read(channels_file())
    voxel = float(np.prod(image.spacing))
    channel = float(image.threshold(0.5, scalars="facies").n_cells)
    return {"plain": (image.n_cells - channel) * voxel, "channel": channel * voxel}


def elevation_file() -> Path:
    """matplotlib's example of an elevation model: Jacksboro fault, in degrees."""
    from matplotlib.cbook import get_sample_data

    return Path(str(get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)))


MINE: dict[str, Any] = {"corners": ((13_500.0, 3_000.0), (18_500.0, 7_500.0)), "base": 150.0, "depth": 80.0}
"""A cut-out, its base [m] and the depth of its weathered layer [m]."""


def terrain_volumes(part: Terrain) -> dict[str, float]:
    """Volumes [m3] of the weathered layer and the rock below it: heights added up by the trapezoidal rule."""
    from scipy.integrate import trapezoid

    high = trapezoid(trapezoid(part.elevation - MINE["base"], dx=part.spacing[1]), dx=part.spacing[0])
    weathered = float(np.prod(np.ptp(part.bounds, axis=0))) * MINE["depth"]
    return {"weathered": weathered, "rock": float(high) - weathered}
