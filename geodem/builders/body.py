"""What a body is, whatever it was made from: where it is, of which materials, how much of each, what bounds it.

An image, a stack of slices, a mesh, a closed surface and a terrain each become a body; `geodem.builders.fill_body`
makes particles of any of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

OUTSIDE = -1
"""Material of a point outside."""


@dataclass(frozen=True)
class Surface:
    """A named piece of a body's boundary, as flat facets.

    Attributes
    ----------
    name : str
        As in the source: a physical group, or "left", "top" and so on.
    corners : (f, d, d) float64 [m]
        Segments in 2D, triangles in 3D; the body lies on their left (2D) or behind their right-handed normal (3D).
    """

    name: str
    corners: Floats


class Body(Protocol):
    """A solid of one or several materials, in 2D or 3D.

    Attributes
    ----------
    dimension : int
        2 or 3.
    materials : tuple of str
    bounds : (2, d) float64 [m]
        Lowest and highest coordinates.
    sizes : (m,) float64 [m2 or m3]
        Area or volume of each material, of the source itself.
    surfaces : sequence of Surface
        Named boundaries; may be empty.
    remarks : sequence of str
        What was repaired or left out when it was made, in words for the user.
    """

    @property
    def dimension(self) -> int: ...

    @property
    def materials(self) -> tuple[str, ...]: ...

    @property
    def bounds(self) -> Floats: ...

    @property
    def sizes(self) -> Floats: ...

    @property
    def surfaces(self) -> Sequence[Surface]: ...

    @property
    def remarks(self) -> Sequence[str]: ...

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, d) [m], `OUTSIDE` where there is none; (n,) int32."""
        ...
