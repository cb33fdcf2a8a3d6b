"""What a mesh file says, before it is checked: points, elements and their groups."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.mesh_file import CORNERS, DIMENSION, POINTS, LoadedMesh, load_mesh
from geodem.builders.mesh_inp import element_sets, load_inp
from geodem.errors import InputError

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

ARRAYS = ("material", "materialids", "material_id", "materials", "gmsh:physical", "physicalids", "cellentityids",
          "medit:ref", "region")  # fmt: skip
"""Arrays of cells that number the materials, in small letters; the first that a file has is taken."""


class Elements(NamedTuple):
    """Elements of one kind: corners (k, c) int64; group (k,) int64, index into the names of their dimension or -1."""

    kind: str
    corners: Whole
    group: Whole

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return DIMENSION[self.kind]


@dataclass
class MeshSource:
    """Points (n, 3) in the unit of the file, elements, names of groups by dimension, and what was assumed."""

    points: Floats
    elements: list[Elements]
    names: dict[int, list[str]] = field(default_factory=lambda: {1: [], 2: [], 3: []})
    remarks: list[str] = field(default_factory=list)
    nameless: list[str] = field(default_factory=list)
    """Names that were made of numbers."""
    unit: float | None = None
    """Metres that the file itself says its unit has."""

    def group_number(self, dimension: int, name: str | None) -> int:
        """Index of a name among those of a dimension, where it is added; -1 for none."""
        if name is None:
            return -1
        known = self.names[dimension]
        if name not in known:
            known.append(name)
        return known.index(name)

    def all_remarks(self) -> list[str]:
        """With one on the names that were made of numbers."""
        made = ", ".join(map(repr, dict.fromkeys(self.nameless)))
        return (
            [*self.remarks, f"Groups without names are called by their numbers: {made}."]
            if made
            else self.remarks
        )

    @property
    def dimension(self) -> int:
        """Largest dimension of an element, 0 without any."""
        return max((part.dimension for part in self.elements if len(part.corners)), default=0)


def read_file(path: Path, names: Mapping[int, str] | None, material_array: str | None) -> MeshSource:
    """Read .msh, .vtk, .vtu, .inp or .stl.

    Raises
    ------
    InputError
        meshio is missing, the file cannot be read, elements of a kind that cannot be used, groups that
        leave open what is of which material.
    """
    file = load_mesh(path, load_inp)
    blocks = []
    for given, data in file.blocks:
        kind = re.sub(r"\d+$", "", given)
        if kind in POINTS:
            kind = "vertex"
        elif kind not in CORNERS:
            raise InputError(
                str(path), f"it has elements of the kind {given!r}, which cannot be used",
                "Mesh with triangles or quadrilaterals, in 3D with tetrahedra or hexahedra.",
            )  # fmt: skip
        blocks.append((kind, np.asarray(data, dtype=np.int64)))
    points = np.zeros((len(file.points), 3))
    points[:, : file.points.shape[1]] = file.points
    source = MeshSource(points, [])
    curved = sum(len(data) for kind, data in blocks if kind in CORNERS and data.shape[1] > CORNERS[kind])
    if curved:
        source.remarks.append(f"{curved} elements with nodes between their corners were made straight.")
    tops = max((DIMENSION[kind] for kind, data in blocks if kind in CORNERS and len(data)), default=0)
    if path.suffix.lower() == ".inp":
        groups = element_sets(path, file, blocks, tops, source.names)
    else:
        groups = _numbered(path, file, blocks, tops, names, material_array, source)
    for (kind, data), group in zip(blocks, groups, strict=True):
        if kind != "vertex" and len(data):
            source.elements.append(Elements(kind, data[:, : CORNERS[kind]], group))
    return source


def _numbered(
    path: Path,
    file: LoadedMesh,
    blocks: list[tuple[str, Whole]],
    tops: int,
    names: Mapping[int, str] | None,
    material_array: str | None,
    source: MeshSource,
) -> list[Whole]:
    """Groups from an array that numbers the cells."""
    array = _choose_array(path, file, blocks, tops, names, material_array)
    if array is None:
        return [np.full(len(data), -1, dtype=np.int64) for _, data in blocks]
    numbers = [np.asarray(values).reshape(len(values), -1)[:, 0] for values in file.arrays[array]]
    if any(values.dtype.kind == "f" and (values != np.rint(values)).any() for values in numbers):
        raise InputError(
            str(path), f"the array {array!r} of its cells does not number materials",
            "Name one of whole numbers as material_array.", value=material_array,
        )  # fmt: skip
    named = {
        (int(value[1]), int(value[0])): name for name, value in file.named.items() if np.size(value) == 2
    }
    return [
        _number_groups(
            source,
            kind,
            values.astype(np.int64),
            named,
            names if DIMENSION.get(kind) == tops else None,
            array,
        )
        for (kind, _), values in zip(blocks, numbers, strict=True)
    ]


def _number_groups(
    source: MeshSource,
    kind: str,
    numbers: Whole,
    named: Mapping[tuple[int, int], str],
    given: Mapping[int, str] | None,
    what: str,
) -> Whole:
    """Groups of elements from numbers; names as given, else as in the file, else made of the number."""
    group = np.full(len(numbers), -1, dtype=np.int64)
    if kind == "vertex":
        return group
    dimension = DIMENSION[kind]
    physical = what == "gmsh:physical"
    for number in np.unique(numbers).tolist():
        name = (given or {}).get(number) or named.get((dimension, number))
        # 0 is gmsh's number of what is in no group
        if name is None and physical and number == 0:
            continue
        if name is None:
            name = f"group {number}" if physical else f"{what} {number}"
            source.nameless.append(name)
        group[numbers == number] = source.group_number(dimension, name)
    return group


def _choose_array(
    path: Path,
    file: LoadedMesh,
    blocks: list[tuple[str, Whole]],
    tops: int,
    names: Mapping[int, str] | None,
    wanted: str | None,
) -> str | None:
    arrays = file.arrays
    if wanted is not None:
        if wanted not in arrays:
            raise InputError(
                str(path), f"its cells have no array {wanted!r}",
                f"Name one of {', '.join(map(repr, arrays)) or 'none: it has no array'}.", value=wanted,
            )  # fmt: skip
        return wanted
    if path.suffix.lower() == ".msh":
        # 0: in no physical group
        if set(_tags(arrays.get("gmsh:physical"), blocks, tops)) - {0}:
            return "gmsh:physical"
        tags = _tags(arrays.get("gmsh:geometrical"), blocks, tops)
        if len(tags) > 1 and not set(tags) <= set(names or ()):
            raise ungrouped(path, "surfaces" if tops == 2 else "volumes", tags)
        return "gmsh:geometrical" if names else None
    low = {name.lower(): name for name in arrays}
    for name in ARRAYS:
        if name in low:
            return low[name]
    whole = [
        name
        for name, values in arrays.items()
        if all(np.asarray(part).dtype.kind in "iu" and np.ndim(part) == 1 for part in values)
        and len(_tags(values, blocks, tops)) > 1
    ]
    if whole:
        raise InputError(
            str(path), f"its cells have the array(s) {', '.join(map(repr, whole))}, and none is known to number "
            "materials", f"Give material_array={whole[0]!r}, or name the array 'material'.",
        )  # fmt: skip
    return None


def _tags(values: Any, blocks: list[tuple[str, Whole]], tops: int) -> list[int]:
    """Numbers that an array gives the elements that fill the ground."""
    if values is None:
        return []
    own = [
        np.asarray(part)
        for (kind, _), part in zip(blocks, values, strict=True)
        if DIMENSION.get(kind) == tops
    ]
    return [int(tag) for tag in np.unique(np.concatenate(own))] if own else []


def ungrouped(path: Path, things: str, tags: list[int]) -> InputError:
    """The error of several surfaces or volumes that could be of one material or of several."""
    listed = ", ".join(map(str, tags[:6])) + (", ..." if len(tags) > 6 else "")
    return InputError(
        str(path), f"it has {len(tags)} {things} ({listed}) without physical groups: their materials are unknown",
        f'Make physical groups and write the mesh again, or give names={{{tags[0]}: "clay", ...}}.',
    )  # fmt: skip
