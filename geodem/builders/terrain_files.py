"""Terrains from files: NumPy archives, GeoTIFF, ESRI ASCII grids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.terrain import Terrain
from geodem.errors import InputError

Floats = NDArray[np.float64]
Holes = Literal["refuse", "fill"]

# TIFF tags and keys of GeoTIFF 1.1 (OGC 19-008r4)
PIXEL_SCALE, TIE_POINT, TRANSFORMATION, GEO_KEYS, NO_DATA = 33550, 33922, 34264, 34735, 42113
MODEL_TYPE, RASTER_TYPE = 1024, 1025
GEOGRAPHIC, PIXEL_IS_POINT = 2, 2
# largest spacing, in degrees, of a grid that looks like one of longitudes and latitudes
FINE_DEGREES = 0.1


def read_terrain(
    path: str | Path, *, degrees: bool | None = None, holes: Holes = "refuse", place: str = "terrain"
) -> Terrain:
    """Read a terrain.

    Parameters
    ----------
    path : str or Path
        ``.npz`` with either x (nx,), y (ny,) and z (nx, ny), or elevation (rows from the north, columns from the
        west), dx and dy, and xmin and ymin or none; ``.tif``: GeoTIFF with a pixel scale and a tie point; ``.asc``:
        ESRI ASCII grid. Elevations in m.
    degrees : bool, optional
        Whether x and y are longitude and latitude: they become metres from the south-west corner, with the lengths
        of a degree in the middle of the terrain. Left out: what a GeoTIFF says, of other files no.
    holes : {"refuse", "fill"}
        What becomes of crossings without data: "fill" takes the mean of their neighbours, spread inwards.
    place : str
        What the errors name.

    Raises
    ------
    InputError
        A file that is missing, damaged or of another kind; no regular grid; holes; degrees taken for metres.
    """
    source = Path(path)
    if not source.is_file():
        raise InputError(place, "there is no such file", "Mend the path.", value=str(path))
    readers = {".npz": _read_npz, ".tif": _read_geotiff, ".tiff": _read_geotiff, ".asc": _read_ascii}
    reader = readers.get(source.suffix.lower())
    if reader is None:
        raise InputError(
            place,
            "this is no terrain that can be read",
            f"Give one of {', '.join(readers)}.",
            value=str(path),
        )
    try:
        heights, origin, spacing, geographic = reader(source, place)
    except InputError:
        raise
    # NumPy, zipfile and tifffile raise what they come upon in a broken file, each its own sort
    except Exception as error:
        raise InputError(place, f"the file is damaged ({error})", "Save it again.", value=str(path)) from None
    return terrain_from(
        heights, origin, spacing, degrees=geographic if degrees is None else degrees, holes=holes, place=place
    )


def terrain_from(
    elevation: ArrayLike,
    origin: ArrayLike,
    spacing: ArrayLike,
    *,
    degrees: bool = False,
    holes: Holes = "refuse",
    place: str = "terrain",
) -> Terrain:
    """A terrain from an array (nx, ny) of heights, x and y growing; NaN where there is none.

    `origin` (2,) and `spacing`, a number or (2,), in metres, or in degrees; further arguments and errors as in
    `read_terrain`.
    """
    heights = np.array(elevation, dtype=np.float64)
    start = np.broadcast_to(np.asarray(origin, dtype=np.float64), (2,)).copy()
    step = np.broadcast_to(np.asarray(spacing, dtype=np.float64), (2,)).copy()
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise InputError(
            place, f"this is not a grid of heights (shape {heights.shape})", "Give at least 2 by 2 of them."
        )
    if not (np.isfinite(start).all() and (np.isfinite(step) & (step > 0.0)).all()):
        raise InputError(
            f"{place}, spacing", "these are not two positive lengths", "Give the distance of the heights.",
            value=step.tolist(),
        )  # fmt: skip
    remarks: list[str] = []
    own: Floats | None = None
    if degrees:
        latitude = start[1] + 0.5 * step[1] * (heights.shape[1] - 1)
        if not abs(latitude) < 89.0:
            raise InputError(f"{place}, degrees", "this is no latitude", "Give metres.", value=latitude)
        own = np.stack([start, degree_lengths(latitude)])
        step *= own[1]
        start = np.zeros(2)
        remarks.append(
            f"Degrees became metres at latitude {latitude:.4f} degrees: {step[0]:.3f} m by {step[1]:.3f} m a cell."
        )
    elif _looks_like_degrees(heights, start, step):
        raise InputError(
            place, "x and y look like longitude and latitude: the surface would be steeper than a wall",
            "Say degrees=True, or give metres.", value=step.tolist(),
        )  # fmt: skip
    missing = ~np.isfinite(heights)
    if missing.any():
        count = int(missing.sum())
        if missing.all():
            raise InputError(
                place, f"all of its {heights.size} heights are missing",
                "Look whether its no-data value is that of the heights.",
            )  # fmt: skip
        if holes != "fill":
            where = np.argwhere(missing)[0]
            x, y = start + step * where
            raise InputError(
                place, f"{count} of {heights.size} heights are missing, one at ({x:.6g}, {y:.6g}) m",
                'Cut them off, or say holes="fill".',
            )  # fmt: skip
        heights = _filled(heights)
        remarks.append(f"{count} heights were missing and filled from those around them.")
    return Terrain(heights, start, step, tuple(remarks), own)


def degree_lengths(latitude: float) -> Floats:
    """Metres of a degree of longitude and of latitude, WGS 84.

    Radii of curvature of the ellipsoid (NGA.STND.0036, 2014): N cos(latitude) along the parallel, M along the
    meridian.
    """
    axis, eccentricity = 6378137.0, 0.00669437999014
    phi = math.radians(latitude)
    bent = 1.0 - eccentricity * math.sin(phi) ** 2
    prime, meridian = axis / bent**0.5, axis * (1.0 - eccentricity) / bent**1.5
    return np.radians(1.0) * np.array([prime * math.cos(phi), meridian])


def _looks_like_degrees(heights: Floats, start: Floats, step: Floats) -> bool:
    end = start + step * np.array(heights.shape)
    earthly = (np.abs(start) <= (360.0, 90.0)).all() and (np.abs(end) <= (360.0, 90.0)).all()
    known = heights[np.isfinite(heights)]
    steps = np.abs(np.diff(heights, axis=0))
    steep = np.nanmedian(steps) > 10.0 * step[0] if len(known) and not np.isnan(steps).all() else False
    return bool(earthly and step.max() < FINE_DEGREES and steep)


def _filled(heights: Floats) -> Floats:
    """Missing heights from the mean of their neighbours, ring by ring, then smoothed to be harmonic."""
    from scipy import ndimage

    found = heights.copy()
    holes = ~np.isfinite(heights)
    cross = ndimage.generate_binary_structure(2, 1).astype(np.float64)
    while (lost := ~np.isfinite(found)).any():
        total = ndimage.convolve(np.where(lost, 0.0, found), cross, mode="constant")
        count = ndimage.convolve((~lost).astype(np.float64), cross, mode="constant")
        ring = lost & (count > 0.0)
        found[ring] = total[ring] / count[ring]
    for _ in range(200):
        mean = (ndimage.convolve(found, cross, mode="nearest") - found) / 4.0
        found[holes] = mean[holes]
    return found


Read = tuple[Floats, Floats, Floats, bool]


def _read_npz(source: Path, place: str) -> Read:
    with np.load(source, allow_pickle=False) as archive:
        held = {name: np.asarray(archive[name]) for name in archive.files}
    if {"x", "y", "z"} <= set(held):
        x, y = (np.asarray(held[name], dtype=np.float64).ravel() for name in "xy")
        heights = np.asarray(held["z"], dtype=np.float64)
        if heights.shape != (len(x), len(y)):
            raise InputError(
                place, f"z has the shape {heights.shape}, x and y say {(len(x), len(y))}", "Mend them.",
                value=str(source),
            )  # fmt: skip
        return heights, np.array([x[0], y[0]]), np.array([_step(x, "x", place), _step(y, "y", place)]), False
    if not {"elevation", "dx", "dy"} <= set(held):
        raise InputError(
            place, f"the archive holds {', '.join(held) or 'nothing'}", "It needs x, y, z or elevation, dx, dy.",
            value=str(source),
        )  # fmt: skip
    step = np.abs(np.array([float(held["dx"]), float(held["dy"])]))
    rows = np.asarray(held["elevation"])
    if rows.ndim != 2:
        raise InputError(
            place, f"elevation has the shape {rows.shape}", "Give rows of heights.", value=str(source)
        )
    origin = [
        _first(held, axis, count, side)
        for axis, count, side in zip("xy", rows.shape[::-1], step, strict=True)
    ]
    return _northern(rows), np.array(origin), step, False


def _first(held: dict[str, np.ndarray], axis: str, count: int, side: float) -> float:
    """Coordinate of the first height along an axis, from what the archive says of its edges.

    Some archives have the names of the northern and southern edge exchanged.
    """
    edges = sorted(float(held[name]) for name in (f"{axis}min", f"{axis}max") if name in held)
    if not edges:
        return 0.0
    # as wide as all cells together: heights stand for the middles of cells
    cells = len(edges) == 2 and side > 0.0 and abs((edges[1] - edges[0]) / side - count) < 0.25
    return edges[0] + (0.5 * side if cells else 0.0)


def _step(values: Floats, name: str, place: str) -> float:
    steps = np.diff(values)
    if len(steps) == 0 or not (steps > 0.0).all() or not np.allclose(steps, steps[0], rtol=1e-4):
        raise InputError(
            f"{place}, {name}", "these are not ascending in equal steps", "Put the heights on a regular grid."
        )
    return float(values[-1] - values[0]) / len(steps)


def _northern(rows: ArrayLike) -> Floats:
    """Rows from the north and columns from the west, as x and y growing."""
    return np.ascontiguousarray(np.asarray(rows, dtype=np.float64)[::-1].T)


def _read_geotiff(source: Path, place: str) -> Read:
    import tifffile

    try:
        with tifffile.TiffFile(source) as file:
            page: Any = file.pages[0]
            rows = np.asarray(page.asarray(), dtype=np.float64)
            tags = {number: page.tags[number].value for number in
                    (PIXEL_SCALE, TIE_POINT, TRANSFORMATION, GEO_KEYS, NO_DATA) if number in page.tags}  # fmt: skip
    except tifffile.TiffFileError as error:
        raise InputError(place, f"this is no TIFF file ({error})", "Mend it.", value=str(source)) from error
    if rows.ndim != 2:
        raise InputError(
            place, f"the picture has the shape {rows.shape}", "Give one band of heights.", value=str(source)
        )
    if PIXEL_SCALE not in tags or TIE_POINT not in tags:
        raise InputError(
            place, "the file does not say where its pixels lie (ModelPixelScale and ModelTiepoint)",
            "Save it as a GeoTIFF without rotation.", value=str(source),
        )  # fmt: skip
    if NO_DATA in tags:
        rows[rows == float(str(tags[NO_DATA]).strip("\x00 "))] = np.nan
    keys = _geo_keys(tags.get(GEO_KEYS, ()))
    step = np.array(tags[PIXEL_SCALE][:2], dtype=np.float64)
    column, row, _, x, y, _ = tags[TIE_POINT][:6]
    # a height stands for the middle of its pixel, unless the file says that pixels are points
    middle = 0.0 if keys.get(RASTER_TYPE) == PIXEL_IS_POINT else 0.5
    west = x + (middle - column) * step[0]
    north = y - (middle - row) * step[1]
    origin = np.array([west, north - (rows.shape[0] - 1) * step[1]])
    return _northern(rows), origin, step, keys.get(MODEL_TYPE) == GEOGRAPHIC


def _geo_keys(directory: Sequence[int]) -> dict[int, int]:
    """Keys whose value stands in the directory itself."""
    entries = [directory[k : k + 4] for k in range(4, len(directory) - 3, 4)]
    return {int(key): int(value) for key, where, _, value in entries if where == 0}


def _read_ascii(source: Path, place: str) -> Read:
    head: dict[str, float] = {}
    lines = source.read_text(encoding="ascii", errors="replace").splitlines()
    start = 0
    for line in lines:
        words = line.split()
        if len(words) != 2 or not words[0][0].isalpha():
            break
        head[words[0].lower()] = float(words[1])
        start += 1
    needed = {"ncols", "nrows"}
    if not needed <= set(head) or not ({"cellsize"} <= set(head) or {"dx", "dy"} <= set(head)):
        raise InputError(
            place, "the head of the grid lacks ncols, nrows or cellsize", "Mend it.", value=str(source)
        )
    try:
        numbers = np.array(" ".join(lines[start:]).split(), dtype=np.float64)
    except ValueError as error:
        raise InputError(
            place, f"a height is no number ({error})", "Write heights with decimal points.", value=str(source)
        ) from None
    shape = (int(head["nrows"]), int(head["ncols"]))
    if numbers.size != shape[0] * shape[1]:
        raise InputError(
            place, f"the grid has {numbers.size} heights, its head says {shape[0]} x {shape[1]}", "Mend it.",
            value=str(source),
        )  # fmt: skip
    numbers[numbers == head.get("nodata_value", np.nan)] = np.nan
    step = np.array([head.get("dx", head.get("cellsize", 0.0)), head.get("dy", head.get("cellsize", 0.0))])
    # heights stand for the middles of cells
    origin = [
        head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", 0.0) + 0.5 * side)
        for axis, side in zip("xy", step, strict=True)
    ]
    return _northern(numbers.reshape(shape)), np.array(origin), step, False
