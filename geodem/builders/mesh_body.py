"""The ground of a mesh as a body: materials by the element that holds a point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geodem.builders.body import OUTSIDE, Surface
from geodem.builders.mesh import Mesh
from geodem.builders.point_location import SimplexLocator

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

REST = "rest"
"""Name of what of the boundary is in no group."""


@dataclass(frozen=True)
class MeshBody:
    """A `geodem.builders.body.Body` in 2D or 3D.

    Parameters
    ----------
    mesh : Mesh
        See `geodem.builders.mesh_reading.read_mesh`.
    """

    mesh: Mesh

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.mesh.dimension

    @property
    def materials(self) -> tuple[str, ...]:
        """Names, as in the mesh."""
        return self.mesh.materials

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, d) [m]."""
        return np.stack([self.mesh.nodes.min(axis=0), self.mesh.nodes.max(axis=0)])

    @property
    def sizes(self) -> Floats:
        """Area or volume of each material (m,) [m2 or m3], the sum of its elements."""
        return self.mesh.sizes

    @cached_property
    def surfaces(self) -> Sequence[Surface]:
        """The boundary, one surface for each group and one, "rest", for what is in none."""
        mesh = self.mesh
        found = []
        for number, name in [*enumerate(mesh.groups), (-1, REST)]:
            mine = mesh.facets[mesh.facet_group == number]
            if len(mine):
                found.append(Surface(name, mesh.nodes[mine]))
        return tuple(found)

    @property
    def remarks(self) -> Sequence[str]:
        """What was assumed and repaired when the mesh was read."""
        return self.mesh.remarks

    @cached_property
    def _locator(self) -> SimplexLocator:
        return SimplexLocator(self.mesh.nodes[self.mesh.cells])

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, d) [m], -1 outside; (n,) int32."""
        found, _ = self._locator.locate(points)
        material = np.full(len(found), OUTSIDE, dtype=np.int32)
        inside = found >= 0
        material[inside] = self.mesh.cell_material[found[inside]]
        return material
