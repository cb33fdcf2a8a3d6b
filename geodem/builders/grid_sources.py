"""Bodies of pixels and voxels from files: drawings with a legend, stacks of slices, VTK image data.

Photographs and other grey pictures are cut into classes by `geodem.builders.segmentation`, stacks of them as
``segment(read_slices(...))``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body import OUTSIDE
from geodem.builders.grid_body import GridBody, cell_sides, grid_body
from geodem.builders.image_labels import TRANSPARENT, label_image, parse_colour
from geodem.builders.image_pixels import read_pixels
from geodem.builders.segmentation import upright
from geodem.builders.vtk_image import read_vtk_image
from geodem.errors import InputError

Bytes = NDArray[np.uint8]

PICTURES = (".png", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".gif", ".webp")
STACKS = (".tif", ".tiff")
# distance in 8-bit colour space up to which a colour counts as listed, and the share that may be farther
NEAR = 48.0
UNLISTED_SHARE = 5e-4


def grid_from_image(
    path: str | Path,
    *,
    scale: float,
    legend: Mapping[str, str],
    background: Sequence[str] | None = None,
    origin: float | Sequence[float] = 0.0,
) -> GridBody:
    """A plane body of the pixels of a picture whose colours are the materials.

    Parameters
    ----------
    path : str or Path
        PNG, BMP, JPEG, GIF, TIFF or WebP file.
    scale : float
        Side of a pixel [m].
    legend, background
        As in `geodem.builders.image_labels.label_image`.
    origin : float or (2,) float [m]
        Lower left corner.

    Raises
    ------
    InputError
        A scale that is not positive, and everything that `label_image` refuses.
    """
    side = cell_sides(scale, 2, "grid, scale")
    image = label_image(path, legend=legend, background=background, place="grid")
    return grid_body(upright(image.labels.astype(np.int32) - 1), image.materials, side, origin=origin)


def read_slices(path: str | Path) -> NDArray[np.generic]:
    """A stack of slices: the pictures of a folder in the natural order of their names, or a TIFF of many pages.

    Parameters
    ----------
    path : str or Path
        Folder, or .tif file. In the natural order slice-2 comes before slice-10.

    Returns
    -------
    (slices, rows, columns) or (slices, rows, columns, 3) array
        Brightness, or red, green and blue where any slice has colours; the first slice is the lowest.

    Raises
    ------
    InputError
        No such file, fewer than two slices, slices of different sizes, a file that cannot be read.
    """
    source = Path(path)
    if not source.exists():
        raise InputError("slices", "there is no such file or folder", "Mend the path.", value=str(path))
    if not source.is_dir():
        return _read_pages(source)
    files = sorted((f for f in source.iterdir() if f.suffix.lower() in PICTURES), key=natural_order)
    if len(files) < 2:
        raise InputError(
            "slices", f"the folder holds {len(files)} pictures", "Give one with at least two slices.",
            value=str(path),
        )  # fmt: skip
    slices: list[Bytes] = []
    for file in files:
        slices.append(read_pixels(file, "slices").colour)
        if slices[-1].shape != slices[0].shape:
            (rows, columns), (other_rows, other_columns) = slices[0].shape[:2], slices[-1].shape[:2]
            raise InputError(
                "slices", f"the slice has {other_columns} x {other_rows} pixels, the first one {columns} x {rows}",
                "Bring all slices to one size.", value=str(file),
            )  # fmt: skip
    stack = np.stack(slices)
    grey = (stack[..., 0] == stack[..., 1]).all() and (stack[..., 0] == stack[..., 2]).all()
    return np.ascontiguousarray(stack[..., 0]) if grey else stack


def natural_order(file: Path) -> tuple[tuple[int, int, str], ...]:
    """Key that sorts numbers in names by their value."""
    parts = re.split(r"(\d+)", file.name.lower())
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts)


def _read_pages(source: Path) -> NDArray[np.generic]:
    import tifffile

    if source.suffix.lower() not in STACKS:
        raise InputError(
            "slices", "this is neither a folder nor a TIFF file", "Give one of the two.", value=str(source)
        )
    try:
        with tifffile.TiffFile(source) as file:
            pages = [page.asarray() for page in file.pages]
    except (tifffile.TiffFileError, ValueError, OSError, KeyError) as error:
        raise InputError(
            "slices", f"the file is damaged ({error})", "Save it again.", value=str(source)
        ) from error
    # one page may hold a whole stack
    if len(pages) == 1 and pages[0].ndim == 3 and pages[0].shape[-1] not in (3, 4):
        pages = list(pages[0])
    if len(pages) < 2:
        raise InputError("slices", "the file has one page", "Give at least two slices.", value=str(source))
    for number, page in enumerate(pages):
        if page.shape != pages[0].shape:
            raise InputError(
                "slices", f"page {number} has the shape {page.shape}, the first one {pages[0].shape}",
                "Bring all slices to one size.", value=str(source),
            )  # fmt: skip
    stack = np.stack(pages)
    return stack[..., :3] if stack.ndim == 4 else stack


def grid_from_slices(
    path: str | Path,
    *,
    voxel: float | Sequence[float] | None,
    legend: Mapping[str, str],
    background: Sequence[str] | None = None,
    origin: float | Sequence[float] = 0.0,
) -> GridBody:
    """A body of the voxels of coloured slices, the first the lowest.

    Parameters
    ----------
    path : str or Path
        As in `read_slices`.
    voxel : float or (3,) float [m]
        Sides of a voxel: along columns, rows, and from slice to slice.
    legend : mapping of str to str
        Material of each colour, as ``{"#8c6d31": "soil"}``; a pixel takes the nearest.
    background : sequence of str, optional
        Colours that are not ground; white where it is left out and the legend does not list it.
    origin : float or (3,) float [m]
        Lowest corner.

    Raises
    ------
    InputError
        What `read_slices` refuses, no voxel size, colours that are not listed.
    """
    sides = cell_sides(voxel, 3, "slices, voxel")
    if not legend:
        raise InputError("slices, legend", "no colour is listed", 'Give {"#8c6d31": "soil"}, for instance.')
    stack = read_slices(path)
    if stack.ndim == 3:
        stack = np.repeat(stack[..., None], 3, axis=-1)
    if stack.dtype != np.uint8:
        raise InputError(
            "slices", f"a legend goes with 8-bit colours, not with {stack.dtype}",
            "Cut them by brightness: segment(read_slices(path)).", value=str(path),
        )  # fmt: skip
    names = tuple(dict.fromkeys(legend.values()))
    white = [] if "#ffffff" in {key.lower() for key in legend} else ["#ffffff"]
    others = [key for key in (white if background is None else background) if key != TRANSPARENT]
    colours = np.array(
        [parse_colour(key, "slices, legend") for key in legend]
        + [parse_colour(key, "slices, background") for key in others]
    )
    owners = np.array([names.index(name) for name in legend.values()] + [OUTSIDE] * len(others))
    # few colours occur in a drawing: each is looked up once
    code = stack.astype(np.int64) @ np.array([65536, 256, 1])
    found, index, count = np.unique(code, return_inverse=True, return_counts=True)
    rgb = np.stack([found >> 16, (found >> 8) & 255, found & 255], axis=1)
    nearest = np.full(len(found), np.inf)
    owner = np.full(len(found), OUTSIDE)
    for colour, number in zip(colours, owners, strict=True):
        distance = np.linalg.norm(rgb - colour, axis=1)
        owner[distance < nearest] = number
        nearest = np.minimum(nearest, distance)
    far = nearest > NEAR
    if count[far].sum() > UNLISTED_SHARE * code.size:
        worst = found[far][np.argmax(count[far])]
        raise InputError(
            "slices, legend", f"the slices show the colour #{worst:06x}, which is not listed",
            "Add it to the legend or the background.", value=str(path),
        )  # fmt: skip
    return grid_body(upright(owner[index.reshape(code.shape)]), names, sides, origin=origin, place="slices")


def grid_from_vtk(
    path: str | Path,
    *,
    thresholds: Sequence[float],
    materials: Sequence[str | None],
    scalars: str | None = None,
) -> GridBody:
    """A body of the voxels of VTK image data (.vti, .vtk).

    Parameters
    ----------
    path : str or Path
    thresholds : sequence of float
        Between the materials, ascending; a value on a threshold belongs above it.
    materials : sequence of str or None
        Below the first threshold, between it and the second, and so on; None where there is nothing.
    scalars : str, optional
        Name of the array; where it is left out, the only one. One of points makes a voxel around each point.

    Raises
    ------
    InputError
        A file that is missing or holds no image data, an array that is missing, thresholds out of order, another
        number of materials than they part.
    """
    source = Path(path)
    shown = str(path)
    if not source.is_file():
        raise InputError("grid", "there is no such file", "Mend the path.", value=shown)
    if source.suffix.lower() not in (".vti", ".vtk"):
        raise InputError("grid", "this is no .vti or .vtk file", "Give image data.", value=shown)
    image = read_vtk_image(source, shown)
    if scalars is None and len(image.names) == 1:
        scalars = image.names[0]
    if scalars not in image.names:
        raise InputError(
            "grid, scalars", "there is no such array", f"Known: {', '.join(image.names) or 'none'}.",
            value=scalars,
        )  # fmt: skip
    cuts = np.asarray(thresholds, dtype=np.float64)
    if not np.isfinite(cuts).all() or (np.diff(cuts) <= 0.0).any():
        raise InputError("grid, thresholds", "these do not grow", "Mend them.", value=list(thresholds))
    if len(materials) != len(cuts) + 1:
        raise InputError(
            "grid, materials", f"{len(cuts)} thresholds part {len(cuts) + 1} materials",
            "Give a name or None for each.", value=list(materials),
        )  # fmt: skip
    at_points = scalars in image.points
    values = image.points[scalars] if at_points else image.cells[scalars]
    if values.ndim != 1:
        raise InputError("grid, scalars", "the array holds vectors", "Give one of numbers.", value=scalars)
    sides = image.spacing
    start = image.corner - (0.5 * sides if at_points else 0.0)
    shape = image.dimensions - (0 if at_points else 1)
    flat = np.flatnonzero(image.dimensions == 1)
    names = tuple(dict.fromkeys(name for name in materials if name is not None))
    number = np.array([OUTSIDE if name is None else names.index(name) for name in materials])
    labels = number[np.digitize(values, cuts)].reshape(np.maximum(shape, 1), order="F")
    if len(flat):
        labels = labels.squeeze(tuple(flat))
    kept = np.setdiff1d(np.arange(3), flat)
    return grid_body(labels, names, sides[kept], origin=start[kept])
