"""Frames for ParaView and PyVista: VTKHDF files that hold one unstructured grid.

Format: Kitware, "VTKHDF file format", version 2.2, type UnstructuredGrid.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.io.files import write_whole

if TYPE_CHECKING:
    import h5py

VERTEX, LINE, TRIANGLE, TETRAHEDRON = 1, 3, 5, 10  # VTK cell types
_KINDS = {2: LINE, 3: TRIANGLE, 4: TETRAHEDRON}

_CHUNK = 25_000  # values along the first axis; small enough to compress well, large enough to read fast


def write_vtkhdf(
    path: Path | str,
    positions: ArrayLike,
    triangles: ArrayLike | None = None,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    field_data: Mapping[str, ArrayLike | str] | None = None,
    time: float | None = None,
) -> None:
    """Write particles and their triangles as one VTKHDF file, whole or not at all.

    Parameters
    ----------
    path : path
        Usually ``*.vtkhdf``.
    positions : (n, 2) or (n, 3) [m]
    triangles : (m, 2), (m, 3) or (m, 4) integers, optional
        Lines, triangles or tetrahedra; without any, every particle is a vertex, so that it can be seen (but where
        lines were given, none of them is drawn).
    point_data, cell_data : dict of name to array (n, ...) or (m, ...), optional
        Scalars, vectors of two components (a zero third one is added) or more components. Put the unit in the
        name: ``"displacement [m]"``; a slash is written " per ", as HDF5 takes it for a folder. Booleans are
        written as 0 and 1.
    field_data : dict of name to array or text, optional
        What belongs to the whole frame, such as the factor.
    time : float, optional
        Kept as field ``TimeValue``: the number of the frame or the factor in a static run, [s] in a dynamic
        one. ParaView takes the times of several frames from `write_series`.

    Raises
    ------
    InputError
        The file cannot be written.
    ValueError
        Arrays that do not fit together.
    """
    import h5py

    points = _three(np.asarray(positions, dtype=np.float64))
    cells, kind = _cells(triangles, len(points))
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 2], dtype=np.int64)
        root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        for name, count in (
            ("NumberOfPoints", len(points)),
            ("NumberOfCells", len(cells)),
            ("NumberOfConnectivityIds", cells.size),
        ):
            root[name] = np.array([count], dtype=np.int64)
        _dataset(root, "Points", points)
        _dataset(root, "Connectivity", cells.ravel())
        _dataset(root, "Offsets", np.arange(len(cells) + 1, dtype=np.int64) * cells.shape[1])
        _dataset(root, "Types", np.full(len(cells), kind, dtype=np.uint8))
        _group(root, "PointData", point_data or {}, len(points))
        _group(root, "CellData", cell_data or {}, len(cells))
        fields = root.create_group("FieldData")
        for name, value in (field_data or {}).items():
            name = _name(name)
            if isinstance(value, str):
                # VTK reads no string marked as UTF-8, yet takes the bytes of one for what they are
                fields.create_dataset(name, data=[value.encode()], dtype=h5py.string_dtype("ascii"))
            else:
                fields[name] = _plain(np.atleast_1d(np.asarray(value)))
        if time is not None:
            fields["TimeValue"] = np.array([time], dtype=np.float64)
    write_whole(path, buffer.getvalue())


def write_series(path: Path | str, frames: Sequence[tuple[str, float]]) -> None:
    """Write the list of frames that ParaView opens as one animation.

    Parameters
    ----------
    path : path
        ``NAME.vtkhdf.series``, beside the frames.
    frames : sequence of (file name, time)
        In the order of time.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    import json

    files = [{"name": name, "time": float(time)} for name, time in frames]
    write_whole(path, json.dumps({"file-series-version": "1.0", "files": files}, indent=1) + "\n")


def _cells(triangles: ArrayLike | None, count: int) -> tuple[NDArray[np.int64], int]:
    cells = np.empty((0, 3), dtype=np.int64) if triangles is None else np.asarray(triangles).astype(np.int64)
    lines = cells.ndim == 2 and cells.shape[1] == 2
    if not len(cells):
        return (cells, LINE) if lines else (np.arange(count, dtype=np.int64)[:, None], VERTEX)
    if cells.ndim != 2 or cells.shape[1] not in _KINDS:
        raise ValueError(f"triangles must be (m, 2), (m, 3) or (m, 4), not {cells.shape}")
    if cells.min() < 0 or cells.max() >= count:
        raise ValueError(f"triangles name particles outside 0..{count - 1}")
    return cells, _KINDS[cells.shape[1]]


def _group(root: h5py.Group, name: str, arrays: Mapping[str, ArrayLike], count: int) -> None:
    group = root.create_group(name)
    for key, value in arrays.items():
        array = np.asarray(value)
        if array.ndim < 1 or len(array) != count:
            raise ValueError(f"{name} '{key}' must have {count} rows, not shape {array.shape}")
        array = array.reshape(count, int(np.prod(array.shape[1:]))) if array.ndim > 1 else array
        _dataset(
            group, _name(key), _plain(_three(array) if array.ndim == 2 and array.shape[1] == 2 else array)
        )


def _name(name: str) -> str:
    """HDF5 takes a slash for a folder: "N/m" is written "N per m"."""
    if not name:
        raise ValueError("an array without a name")
    return name.replace("/", " per ")


def _dataset(group: h5py.Group, name: str, array: NDArray) -> None:
    if len(array) > 64:
        chunks = (min(len(array), _CHUNK), *array.shape[1:])
        group.create_dataset(name, data=array, chunks=chunks, compression="gzip", compression_opts=4)
    else:
        group.create_dataset(name, data=array)


def _plain(array: NDArray) -> NDArray:
    return array.astype(np.uint8) if array.dtype == np.bool_ else array


def _three(array: NDArray) -> NDArray:
    if array.ndim == 2 and array.shape[1] == 2:
        return np.column_stack([array, np.zeros(len(array), dtype=array.dtype)])
    return array
