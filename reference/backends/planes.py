"""Walls as other codes have them: planes along the axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from .program import refuse


def plane_of(name: str, wall: Any, code: str) -> list[tuple[int, int, float]]:
    """Axis, sense and place of every plane of a wall; refused where it is more than planes along the axes at rest."""
    if len(wall.segments) or len(wall.triangles):
        raise refuse(code, f"wall {name!r} is made of facets; only planes are translated")
    if np.any(wall.spin) or wall.servo is not None:
        raise refuse(code, f"wall {name!r} turns or is driven by a servo")
    found = []
    for point, normal in wall.planes:
        axis = int(np.argmax(np.abs(normal)))
        if abs(normal[axis]) != 1.0:
            raise refuse(code, f"wall {name!r} has a plane that is not along the axes")
        found.append((axis, int(normal[axis]), float(point[axis])))
    return found
