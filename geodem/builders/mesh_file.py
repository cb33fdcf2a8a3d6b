"""Load a mesh file with meshio, and make sure that it is whole."""

from __future__ import annotations

import contextlib
import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geodem.errors import InputError

CORNERS = {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
DIMENSION = {"line": 1, "triangle": 2, "quad": 2, "tetra": 3, "pyramid": 3, "wedge": 3, "hexahedron": 3}
POINTS = ("vertex", "poly_vertex")


class LoadedMesh(NamedTuple):
    """What the libraries return: points, (kind, nodes) of blocks of elements, arrays and sets of elements by block."""

    points: Any
    blocks: list[tuple[str, Any]]
    arrays: dict[str, list[Any]]
    named: dict[str, Any]
    sets: dict[str, Any]


def load_mesh(path: Path, load_inp: Callable[[Path], LoadedMesh]) -> LoadedMesh:
    """Read a file with meshio, and .inp files by `load_inp`.

    Raises InputError where it is missing, or the file cannot be read or makes no sense.
    """
    own = {".vtk": _load_vtk, ".inp": load_inp}
    said = io.StringIO()
    try:
        # they print what they make of a broken file, and the reader of STL overflows on text
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), np.errstate(all="ignore"):
            file = own.get(path.suffix.lower(), _load_meshio)(path)
        if np.ndim(file.points) != 2 or not file.blocks:
            raise ValueError("no nodes or no elements in it")
        if not np.isfinite(np.asarray(file.points, dtype=np.float64)).all():
            raise ValueError("coordinates that are not finite")
        for _, data in file.blocks:
            if np.size(data) and not (np.min(data) >= 0 and np.max(data) < len(file.points)):
                raise ValueError("elements name nodes that are not there")
    except ImportError as error:
        raise InputError(
            str(path),
            f"reading it needs {error.name}, which is not installed",
            "Run: pip install 'geodem[meshes]'",
        ) from None
    # on some broken files meshio ends the process
    except (Exception, SystemExit) as error:
        words = said.getvalue() if isinstance(error, SystemExit) else str(error)
        why = " ".join(words.split()) or type(error).__name__
        raise InputError(
            str(path), f"the file cannot be read ({why})",
            "Is it complete? Export it again, for instance as .msh.",
        ) from None  # fmt: skip
    return file


def _load_meshio(path: Path) -> LoadedMesh:
    import meshio

    mesh = meshio.read(path)
    blocks = [(block.type, block.data) for block in mesh.cells]
    return LoadedMesh(mesh.points, blocks, mesh.cell_data, mesh.field_data or {}, mesh.cell_sets)


def _load_vtk(path: Path) -> LoadedMesh:
    """A legacy file of VTK, which may lack the last end of a line, as gmsh writes it."""
    text = path.read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(text if text.endswith(b"\n") else text + b"\n")
        return _load_meshio(copy)
