"""A section given by a mesh: its materials filled with particles, or particles on its own nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from geodem.case.data import SectionOptions
from geodem.case.source_files import (
    LENGTH_UNITS,
    MESH_KEYS,
    find_file,
    metres,
    read_names,
    read_or_tell,
)
from geodem.case.table import Table

if TYPE_CHECKING:
    from geodem.builders.mesh import Mesh
    from geodem.builders.section import Section

KEYS = ("mesh_unit", "particles_on", *MESH_KEYS)
PARTICLES_ON = ("polygons", "nodes")


@dataclass(frozen=True, eq=False)
class MeshSection(SectionOptions):
    """A section from a mesh or a geometry, its groups the materials.

    Attributes
    ----------
    path : pathlib.Path
        Absolute.
    mesh : Mesh
        What the file says [m].
    unit : str or None
        Of the file; None: metres, or what the file itself says.
    particles_on : str
        ``polygons``: the materials are filled with particles; ``nodes``: the nodes are the particles.
    names : mapping of int to str
        Materials of groups without a name.
    material_array : str or None
    size : float or None [m]
        Largest side of an element where a geometry is meshed.
    """

    path: Path
    mesh: Mesh
    unit: str | None
    particles_on: str
    names: Mapping[int, str]
    material_array: str | None
    size: float | None

    key: ClassVar[str] = "mesh"

    @property
    def file(self) -> Path:
        """The mesh or geometry."""
        return self.path

    def beside(self) -> MeshSection:
        """The same with its file named without a folder."""
        return replace(self, path=Path(self.path.name))

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials of the file."""
        return self.mesh.materials

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top [m]."""
        (left, bottom), (right, top) = self.mesh.nodes.min(axis=0), self.mesh.nodes.max(axis=0)
        return float(left), float(bottom), float(right), float(top)

    @cached_property
    def section(self) -> Section:
        """The materials as polygons."""
        from geodem.builders.from_mesh import section_from_mesh

        return section_from_mesh(self.mesh)


def read_mesh_section(table: Table, folder: Path, options: dict[str, Any]) -> MeshSection | None:
    """The section of a table that names a mesh; None where something is wrong, which has then been told."""
    findings = table.findings
    before = len(findings.errors)
    path = find_file(table, "mesh", folder)
    unit: str | None = None
    # coordinates of the case are in length_unit, too; mesh_unit is for a file that differs
    for key in ("length_unit", "mesh_unit"):
        if key in table:
            unit = table.choice(key, LENGTH_UNITS) or unit
    particles_on = table.choice("particles_on", PARTICLES_ON, default="polygons")
    names = read_names(table)
    array = table.text("material_array", remedy='Write material_array = "MaterialIDs".')
    size = table.quantity("size", "length")
    if particles_on == "nodes":
        for key in ("refine", "layers", "thin"):
            if key in table:
                table.error(
                    key, "the nodes of the mesh are the particles, closer where the mesh is finer",
                    f'Remove {key}, or write particles_on = "polygons".',
                )  # fmt: skip
    if path is None or particles_on is None or len(findings.errors) > before:
        return None
    found = read_or_tell(
        findings, table.at("mesh"), lambda: _read(path, unit, names, array, size, options, particles_on),
        value=table.content["mesh"], keys={"length_unit": "length_unit", "size": "size"},
    )  # fmt: skip
    if found is not None:
        findings.notices += [f"{table.at('mesh')}: {remark}" for remark in found.mesh.remarks]
    return found


def _read(
    path: Path,
    unit: str | None,
    names: dict[int, str],
    array: str | None,
    size: float | None,
    options: dict[str, Any],
    particles_on: str,
) -> MeshSection:
    from geodem.builders.from_mesh import particles_from_mesh
    from geodem.builders.mesh_reading import read_mesh

    mesh = read_mesh(path, length_unit=metres(unit), size=size, names=names or None, material_array=array)
    found = MeshSection(
        path=path, mesh=mesh, unit=unit, particles_on=particles_on, names=names, material_array=array, size=size,
        **options,
    )  # fmt: skip
    # what cannot become particles is told with all else
    if particles_on == "nodes":
        particles_from_mesh(mesh)
    _ = found.section
    return found
