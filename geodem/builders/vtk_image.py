"""VTK image data, read by a process of its own: a damaged file can end the process that VTK reads it in."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError

WHOLE, DAMAGED, OTHER = 0, 3, 4
"""Exit statuses of the process: the image is read, the file is damaged, it holds something else (told on stdout)."""


class VtkImage(NamedTuple):
    """Image data: points along x, y, z (3,); sides of a voxel and lower corner (3,) [m]; arrays by name."""

    dimensions: NDArray[np.int64]
    spacing: NDArray[np.float64]
    corner: NDArray[np.float64]
    points: dict[str, NDArray[Any]]
    cells: dict[str, NDArray[Any]]

    @property
    def names(self) -> list[str]:
        """Of all arrays; one of points hides one of cells."""
        return [*self.points, *(name for name in self.cells if name not in self.points)]


def read_vtk_image(path: Path, shown: str) -> VtkImage:
    """The image data of a file; `shown` is how messages call it.

    Raises
    ------
    InputError
        The file is damaged, or holds no image data.
    """
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "image.npz"
        done = subprocess.run(
            [sys.executable, "-m", __name__, str(path.resolve()), str(out)],
            capture_output=True, text=True, errors="replace", check=False,
        )  # fmt: skip
        told = " ".join(done.stdout.split())[:200]
        if done.returncode == OTHER:
            raise InputError(
                "grid", f"the file holds {told}, not image data", "Resample it to a grid.", value=shown
            )
        if done.returncode != WHOLE:
            why = told or " ".join(done.stderr.split())[-200:] or f"VTK ended with {done.returncode}"
            raise InputError("grid", f"the file is damaged ({why})", "Save it again.", value=shown)
        with np.load(out, allow_pickle=False) as file:
            held = {name: file[name] for name in file.files}
    parts = {
        kind: {name.split(":", 1)[1]: array for name, array in held.items() if name.startswith(f"{kind}:")}
        for kind in ("points", "cells")
    }
    return VtkImage(held["dimensions"], held["spacing"], held["corner"], parts["points"], parts["cells"])


def _read(path: str, out: str) -> int:
    import pyvista

    try:
        # VTK prints what it makes of a broken file and goes on with nothing; pyvista warns
        with warnings.catch_warnings(), pyvista.VtkErrorCatcher(raise_errors=True, send_to_logging=False):
            warnings.simplefilter("error")
            image = pyvista.read(path)
    except Exception as error:
        print(error)
        return DAMAGED
    if not isinstance(image, pyvista.ImageData):
        print(type(image).__name__)
        return OTHER
    arrays = {f"points:{name}": np.asarray(image.point_data[name]) for name in image.point_data}
    arrays |= {f"cells:{name}": np.asarray(image.cell_data[name]) for name in image.cell_data}
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "biuf"}
    held: dict[str, Any] = {
        **numbers,
        "dimensions": np.array(image.dimensions),
        "spacing": np.array(image.spacing),
        "corner": np.array(image.bounds)[::2],
    }
    np.savez(out, **held)
    return WHOLE


if __name__ == "__main__":
    sys.exit(_read(*sys.argv[1:]))
