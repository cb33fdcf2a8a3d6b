"""Load a mesh file by the library that reads its kind best: VTK its own, meshio the others."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geodem.errors import InputError

CORNERS = {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
DIMENSION = {"line": 1, "triangle": 2, "quad": 2, "tetra": 3, "pyramid": 3, "wedge": 3, "hexahedron": 3}
POINTS = ("vertex", "poly_vertex")
VTK_KINDS = {
    "quadratic_edge": "line3", "quadratic_triangle": "triangle6", "quadratic_quad": "quad8",
    "biquadratic_quad": "quad9", "quadratic_tetra": "tetra10", "quadratic_hexahedron": "hexahedron20",
    "triquadratic_hexahedron": "hexahedron27", "quadratic_wedge": "wedge15", "quadratic_pyramid": "pyramid13",
}  # fmt: skip
"""Names of quadratic cells of VTK, as meshio has them."""


class LoadedMesh(NamedTuple):
    """What the libraries return: points, (kind, nodes) of blocks of elements, arrays and sets of elements by block."""

    points: Any
    blocks: list[tuple[str, Any]]
    arrays: dict[str, list[Any]]
    named: dict[str, Any]
    sets: dict[str, Any]


def load_mesh(path: Path) -> LoadedMesh:
    """Read a file by the library that reads its kind best.

    Raises InputError where it is missing, or the file cannot be read or makes no sense.
    """
    vtk = path.suffix.lower() in (".vtk", ".vtu")
    said = io.StringIO()
    try:
        # they print what they make of a broken file, and the reader of STL overflows on text
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), np.errstate(all="ignore"):
            file = _load_vtk(path) if vtk else _load_meshio(path)
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
        why = said.getvalue().strip() or str(error).strip() or type(error).__name__
        raise InputError(
            str(path), f"the file cannot be read ({why.splitlines()[-1]})",
            "Is it complete? Export it again, for instance as .msh.",
        ) from None  # fmt: skip
    return file


def _load_meshio(path: Path) -> LoadedMesh:
    import meshio

    mesh = meshio.read(path)
    blocks = [(block.type, block.data) for block in mesh.cells]
    return LoadedMesh(mesh.points, blocks, mesh.cell_data, mesh.field_data or {}, mesh.cell_sets)


def _load_vtk(path: Path) -> LoadedMesh:
    import pyvista

    # a broken file is told by what is missing from the grid, not by the words that VTK prints
    with pyvista.vtk_verbosity("off"):
        read = pyvista.read(path)
    if not isinstance(read, pyvista.DataSet):
        raise ValueError(f"{type(read).__name__} is no mesh")
    grid = read.cast_to_unstructured_grid()
    if not grid.n_cells:
        raise ValueError("no cells")
    types = np.asarray(grid.celltypes)
    names = {int(kind): kind.name.lower() for kind in pyvista.CellType}
    blocks: list[tuple[str, Any]] = []
    arrays: dict[str, list[Any]] = {name: [] for name in grid.cell_data}
    first, nodes = np.asarray(grid.offset), np.asarray(grid.cell_connectivity)
    size = np.diff(first)
    for kind in dict.fromkeys(types.tolist()):
        mine = np.flatnonzero(types == kind)
        width = int(size[mine[0]])
        if (size[mine] != width).any():
            raise ValueError(f"cells of the kind {names[kind]} of several sizes")
        rows = nodes[first[mine][:, None] + np.arange(width)]
        name = VTK_KINDS.get(names[kind], names[kind])
        if name == "pixel":
            name, rows = "quad", rows[:, [0, 1, 3, 2]]
        if name == "voxel":
            name, rows = "hexahedron", rows[:, [0, 1, 3, 2, 4, 5, 7, 6]]
        blocks.append((name, rows))
        for array, values in grid.cell_data.items():
            arrays[array].append(np.asarray(values)[mine])
    return LoadedMesh(np.asarray(grid.points, dtype=np.float64), blocks, arrays, {}, {})
