"""A vertical section of the ground: which material lies where, as polygons that fit together exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from geodem.errors import InputError, InputErrors

# Gaps and overlaps below this part of the section's span are closed: corners with few decimals leave them.
_CLOSED_GAP = 1e-6


@dataclass(frozen=True)
class Region:
    """One connected piece of one material.

    Parameters
    ----------
    material : str
        Name of the material.
    polygon : shapely.Polygon
        Outline [m], x to the right and y upwards; may have holes.
    """

    material: str
    polygon: shapely.Polygon


@dataclass(frozen=True)
class Section:
    """The ground of a plane problem.

    The interiors of the regions are disjoint, and neighbouring regions share the vertices of their common
    boundary exactly, so that a mesh or a packing of one fits that of the other.

    Parameters
    ----------
    regions : tuple of Region
        At least one; a material may own several.
    """

    regions: tuple[Region, ...]

    @classmethod
    def from_polygons(
        cls, regions: Sequence[tuple[str, ArrayLike]], *, place: str = "section.regions"
    ) -> Section:
        """Lay polygons over each other, a later one over the earlier ones.

        Parameters
        ----------
        regions : sequence of (str, array_like)
            Material and corners [m], shape (n, 2), n >= 3, in either sense; the first corner may be repeated
            at the end.
        place : str
            Key of the case file that the errors name.

        Returns
        -------
        Section
            Adjacent polygons of one material are joined. Gaps and overlaps below one millionth of the span,
            as rounded corners leave them, are closed.

        Raises
        ------
        InputError
            A polygon with fewer than three corners, corners that are not finite, an outline that crosses
            itself, no thickness, or a region that later ones hide entirely.
        """
        if len(regions) == 0:
            raise InputError(place, "no region is given", "Give at least one material with its polygon.")
        errors: list[InputError] = []
        polygons: list[shapely.Polygon] = []
        for index, (material, corners) in enumerate(regions):
            try:
                if not isinstance(material, str) or not material.strip():
                    raise InputError(
                        f"{place}[{index}].material",
                        "a material name is needed",
                        'Name a material that has its own table, for example "soil".',
                        value=material,
                    )
                polygons.append(_checked_polygon(corners, f"{place}[{index}].polygon"))
            except InputError as error:
                errors.append(error)
        if errors:
            raise errors[0] if len(errors) == 1 else InputErrors(errors)

        faces, owners = _overlay(polygons)
        for index, (material, _) in enumerate(regions):
            seen = math.fsum(face.area for face, owner in zip(faces, owners, strict=True) if owner == index)
            if seen <= _CLOSED_GAP * polygons[index].area:
                errors.append(_hidden(f"{place}[{index}].polygon", material, polygons, index))
        if errors:
            raise errors[0] if len(errors) == 1 else InputErrors(errors)

        names = [material for material, _ in regions]
        joined: list[Region] = []
        for material in dict.fromkeys(names):
            mine = [face for face, owner in zip(faces, owners, strict=True) if names[owner] == material]
            pieces = _polygons_of(shapely.unary_union(mine))
            joined += [Region(material, piece) for piece in pieces]
        return cls(tuple(joined))

    @cached_property
    def outline(self) -> shapely.Polygon | shapely.MultiPolygon:
        """Union of all regions [m]."""
        return shapely.unary_union([region.polygon for region in self.regions])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest x, smallest y, largest x, largest y [m]."""
        return tuple(self.outline.bounds)

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials in order of first appearance."""
        return tuple(dict.fromkeys(region.material for region in self.regions))

    @cached_property
    def parts(self) -> list[shapely.Polygon]:
        """Connected pieces of the ground [m], largest first; those that touch in a point are separate."""
        return sorted(_polygons_of(self.outline), key=lambda polygon: -polygon.area)

    def area(self, material: str) -> float:
        """Area of one material [m2].

        Raises
        ------
        KeyError
            The section has no such material.
        """
        if material not in self.materials:
            raise KeyError(f"no material {material!r} in the section; it has {', '.join(self.materials)}")
        return math.fsum(region.polygon.area for region in self.regions if region.material == material)


def _polygons_of(geometry: Any) -> list[shapely.Polygon]:
    return [part for part in shapely.get_parts(geometry) if part.geom_type == "Polygon" and not part.is_empty]


def _checked_polygon(corners: ArrayLike, place: str) -> shapely.Polygon:
    """Polygon from corners as typed, or an error that says what is wrong and where."""
    example = "Give corners as [[x, y], ...], for example [[0, 0], [40, 0], [40, 10]]."
    try:
        points = np.asarray(corners, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(place, "the corners are not pairs of numbers", example) from error
    if points.size == 0:
        points = points.reshape(0, 2)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError(place, "the corners are not pairs of numbers", example)
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise InputError(
            f"{place}[{bad}]",
            "the corner is not finite",
            "Give a finite x and y.",
            value=points[bad].tolist(),
        )
    repeated = (
        np.r_[False, (points[1:] == points[:-1]).all(axis=1)] if len(points) else np.zeros(0, dtype=bool)
    )
    points = points[~repeated]
    if len(points) > 1 and (points[0] == points[-1]).all():
        points = points[:-1]
    if len(points) < 3:
        raise InputError(
            place, f"the polygon has {len(points)} different corners, and needs at least 3", example
        )
    polygon = shapely.Polygon(points)
    span = max(np.ptp(points[:, 0]), np.ptp(points[:, 1]))
    # half the perimeter times the thickness is the area of a thin strip
    if polygon.area <= _CLOSED_GAP * span * polygon.length / 2 and _is_flat(points, span):
        raise InputError(
            place,
            f"the polygon has no thickness (area {polygon.area:.3g} m2)",
            "Give corners that enclose an area; a thin seam needs an upper and a lower side.",
        )
    if not polygon.is_valid:
        reason = shapely.is_valid_reason(polygon)
        kind, _, position = reason.partition("[")
        where = ", ".join(position.rstrip("]").split())
        raise InputError(
            place,
            f"the outline crosses or touches itself at (x, y) = ({where}) m ({kind.lower()})",
            "Give the corners in the order in which they follow each other around the region.",
        )
    return polygon


def _is_flat(points: NDArray[np.float64], span: float) -> bool:
    """Whether all points lie on one straight line, to the width of a closed gap."""
    centred = points - points.mean(axis=0)
    return bool(np.linalg.svd(centred, compute_uv=False)[-1] <= _CLOSED_GAP * span)


def _overlay(polygons: list[shapely.Polygon]) -> tuple[list[shapely.Polygon], NDArray[np.int64]]:
    """Cut the plane along all outlines; faces and, for each, the last polygon that covers it."""
    bounds = shapely.total_bounds(polygons)
    span = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    grid = 10.0 ** math.floor(math.log10(_CLOSED_GAP * span))
    # Work near the origin: large survey coordinates would lose the digits that the grid needs.
    shift = np.floor(bounds[:2])
    moved = [shapely.transform(polygon, lambda xy: xy - shift) for polygon in polygons]
    lines = shapely.unary_union([polygon.boundary for polygon in moved], grid_size=grid)
    faces = _polygons_of(shapely.polygonize(shapely.get_parts(lines)))
    points = shapely.get_coordinates(shapely.point_on_surface(faces)) if faces else np.zeros((0, 2))
    owners = np.full(len(faces), -1)
    for index, polygon in enumerate(moved):
        shapely.prepare(polygon)
        owners[shapely.contains_xy(polygon, points)] = index

    typed = np.concatenate([shapely.get_coordinates(polygon) for polygon in polygons])
    kept = [(face, owner) for face, owner in zip(faces, owners.tolist(), strict=True) if owner >= 0]
    restored = [shapely.transform(face, lambda xy: _as_typed(xy, typed, shift, grid)) for face, _ in kept]
    if not all(face.is_valid for face in restored):
        restored = [shapely.transform(face, lambda xy: xy + shift) for face, _ in kept]
    return restored, np.array([owner for _, owner in kept], dtype=np.int64)


def _as_typed(
    points: NDArray[np.float64], typed: NDArray[np.float64], shift: NDArray[np.float64], grid: float
) -> NDArray[np.float64]:
    """Points of the grid, moved back to the corner as typed where one lies in the grid cell."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(typed - shift).query(points, distance_upper_bound=grid)
    nearest = np.asarray(nearest)
    found = np.isfinite(distance)
    result = points + shift
    result[found] = typed[nearest[found]]
    return result


def _hidden(place: str, material: str, polygons: list[shapely.Polygon], index: int) -> InputError:
    covering = [str(j) for j in range(index + 1, len(polygons)) if polygons[j].intersects(polygons[index])]
    return InputError(
        place,
        f"later regions ({', '.join(covering)}, counted from 0) hide this region of {material!r} entirely",
        "Put the region after those that lie under it, or take it away.",
    )
