"""Walls as a user makes them: planes, chains of segments, triangles, triangles of a file, boxes.

What they have in common: `velocity` (d,) [m/s], `spin` about the centre (a number in 2D, (3,) in 3D) [rad/s], `centre`
(d,) [m], where it is not given the middle of the corners; `servo`; and `contact`, numbers that replace what
follows from the particles' materials, such as ``{"friction_coefficient": 0.3}``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Servo, Wall
from ..errors import InputError
from .checks import refuse

Floats = NDArray[np.float64]


class Motion(TypedDict, total=False):
    """What every wall may be given besides its shape."""

    velocity: ArrayLike
    spin: ArrayLike
    centre: ArrayLike
    servo: Servo
    contact: dict[str, Any]


def plane(name: str, point: ArrayLike, normal: ArrayLike, **motion: Unpack[Motion]) -> Wall:
    """An infinite plane (2D: a line) through a point [m]; particles are on the side that the normal points to.

    The normal may have any length. Raises InputError if it has none.
    """
    normal = _numbers(name, "normal", normal)
    length = float(np.linalg.norm(normal))
    if not length > 0.0:
        raise InputError(
            f"wall {name!r}",
            "its normal has no direction",
            "Point it to the particles.",
            value=normal.tolist(),
        )
    planes = np.stack([_numbers(name, "point", point), normal / length])[np.newaxis]
    return _wall(name, planes.shape[2], motion, planes=planes)


def box(name: str, low: ArrayLike, high: ArrayLike, **motion: Unpack[Motion]) -> Wall:
    """The planes around a rectangle or a block with the corners `low` and `high` (d,) [m]; particles are inside.

    All planes are one body. For a box whose sides move on their own make planes. Raises InputError for an empty box.
    """
    low, high = _numbers(name, "low", low), _numbers(name, "high", high)
    if low.shape != high.shape or not (low < high).all():
        raise InputError(f"wall {name!r}", "the box has no inside", "Give low below high along every axis.")
    axes = np.eye(len(low))
    planes = np.concatenate(
        [np.stack([np.tile(low, (len(low), 1)), axes], 1), np.stack([np.tile(high, (len(low), 1)), -axes], 1)]
    )
    return _wall(name, len(low), motion, planes=planes)


def segments(name: str, points: ArrayLike, *, closed: bool = False, **motion: Unpack[Motion]) -> Wall:
    """A chain of segments through `points` (k, 2) [m], and back to the first if closed; discs touch both sides.

    Raises InputError for fewer than two points and for segments without length.
    """
    corners = _numbers(name, "points", points)
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 2:
        raise InputError(
            f"wall {name!r}",
            f"points of shape {corners.shape} make no chain",
            "Give two or more points (x, y).",
        )
    if closed:
        corners = np.concatenate([corners, corners[:1]])
    return _wall(name, 2, motion, segments=np.stack([corners[:-1], corners[1:]], axis=1))


def triangles(name: str, corners: ArrayLike, *, turn_over: bool = False, **motion: Unpack[Motion]) -> Wall:
    """Triangles with `corners` (k, 3, 3) [m]; spheres touch both sides. `turn_over` reverses the order of the corners.

    Triangles that share corners are one surface: a sphere slides over their common edges without feeling them.
    Raises InputError for triangles without area and for closed surfaces that are inside out.
    """
    values = _numbers(name, "corners", corners)
    if values.ndim != 3 or values.shape[1:] != (3, 3):
        raise InputError(
            f"wall {name!r}", f"corners of shape {values.shape} are no triangles", "Give them as (k, 3, 3)."
        )
    return _wall(name, 3, motion, triangles=values[:, ::-1].copy() if turn_over else values)


def facets(name: str, corners: ArrayLike, **motion: Unpack[Motion]) -> Wall:
    """Segments with ends (k, 2, 2), or triangles with corners (k, 3, 3) [m], in any order.

    Raises InputError as `segments` and `triangles` do.
    """
    values = _numbers(name, "corners", corners)
    if values.ndim == 3 and values.shape[1:] == (2, 2):
        return _wall(name, 2, motion, segments=values)
    return triangles(name, values, **motion)


def from_stl(
    name: str, path: str | Path, *, scale: float = 1.0, turn_over: bool = False, **motion: Unpack[Motion]
) -> Wall:
    """The triangles of an STL file, binary or text, or of any other file of triangles that meshio reads.

    `scale`: metres per unit of the file (0.001 for millimetres). Raises InputError where the file cannot be read or
    holds no triangles, and as `triangles` does. Needs meshio (``pip install 'geodem[all]'``).
    """
    try:
        import meshio
    except ImportError:
        raise InputError(
            f"wall {name!r}", "reading a mesh needs meshio", "Run: pip install 'geodem[all]'"
        ) from None
    if not Path(path).is_file():
        raise InputError(f"wall {name!r}", "there is no such file", "Mend the path.", value=str(path))
    try:
        # the reader tells text from binary by a size that overflows on text
        with np.errstate(over="ignore"):
            mesh = meshio.read(path)
    # meshio ends the process on some broken files
    except (Exception, SystemExit) as error:
        raise InputError(
            f"wall {name!r}", f"the file cannot be read ({error})", "Export it again as STL.", value=str(path)
        ) from None
    points = np.asarray(mesh.points, dtype=np.float64) * scale
    found = [points[block.data] for block in mesh.cells if block.type == "triangle"]
    if not found or points.shape[1] != 3:
        raise InputError(
            f"wall {name!r}", "the file holds no triangles", "Export a surface of triangles.", value=str(path)
        )
    return triangles(name, np.concatenate(found), turn_over=turn_over, **motion)


def _numbers(name: str, what: str, values: ArrayLike) -> Floats:
    numbers = np.array(values, dtype=np.float64)
    if not np.isfinite(numbers).all():
        raise InputError(f"wall {name!r}", f"its {what} is not finite", "Give finite numbers in m.")
    return numbers


def _wall(
    name: str,
    dimension: int,
    motion: Motion,
    *,
    planes: Floats | None = None,
    segments: Floats | None = None,
    triangles: Floats | None = None,
) -> Wall:
    corners = planes[:, :1] if planes is not None else segments if segments is not None else triangles
    assert corners is not None
    spots = corners.reshape(-1, dimension)
    middle = 0.5 * (spots.min(axis=0) + spots.max(axis=0))
    wall = Wall(
        name=name,
        planes=np.empty((0, 2, dimension)) if planes is None else planes,
        segments=np.empty((0, 2, 2)) if segments is None else segments,
        triangles=np.empty((0, 3, 3)) if triangles is None else triangles,
        velocity=np.array(motion.get("velocity", np.zeros(dimension)), dtype=np.float64),
        spin=np.atleast_1d(np.array(motion.get("spin", np.zeros(2 * dimension - 3)), dtype=np.float64)),
        centre=np.array(motion.get("centre", middle), dtype=np.float64),
        contact=dict(motion.get("contact", {})),
        servo=motion.get("servo"),
    )
    refuse([wall], dimension)
    return wall
