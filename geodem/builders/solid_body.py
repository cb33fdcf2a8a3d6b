"""What closed surfaces enclose, such as those of STL files: one body for each material."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders import mesh_checks as checks
from geodem.builders.body import OUTSIDE, Surface
from geodem.builders.closed_surface import ClosedSurface, close_surface, read_surface, shared_facets
from geodem.builders.point_location import SurfaceLocator
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

PROBES = 400_000
"""Points at which it is asked whether two bodies are there."""
OVERLAP = 1e-3
"""Share of the smaller of two bodies that may be in both, as surfaces meshed apart have it."""


@dataclass(frozen=True)
class SolidBody:
    """A `geodem.builders.body.Body` in 3D; a point in two bodies belongs to the first.

    Parameters
    ----------
    materials : tuple of str
        One a surface.
    enclosures : tuple of ClosedSurface
    remarks : tuple of str
        What was assumed and repaired.
    """

    materials: tuple[str, ...]
    enclosures: tuple[ClosedSurface, ...]
    remarks: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @cached_property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, 3) [m]."""
        every = np.concatenate([part.corners.reshape(-1, 3) for part in self.enclosures])
        return np.stack([every.min(axis=0), every.max(axis=0)])

    @cached_property
    def sizes(self) -> Floats:
        """Volume of each material (m,) [m3]."""
        return np.array([part.volume for part in self.enclosures])

    @cached_property
    def surfaces(self) -> Sequence[Surface]:
        """The surface of each material, called as it is, without what it has in common with another."""
        shared = shared_facets([part.corners for part in self.enclosures])
        return tuple(
            Surface(name, part.corners[~inner])
            for name, part, inner in zip(self.materials, self.enclosures, shared, strict=True)
            if not inner.all()
        )

    @cached_property
    def _locators(self) -> list[SurfaceLocator]:
        return [SurfaceLocator(part.corners) for part in self.enclosures]

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, 3) [m], -1 outside; (n,) int32."""
        points = np.asarray(points, dtype=np.float64)
        material = np.full(len(points), OUTSIDE, dtype=np.int32)
        for number, locator in enumerate(self._locators):
            left = np.flatnonzero(material == OUTSIDE)
            material[left[locator.encloses(points[left])]] = number
        return material


def read_solids(paths: Mapping[str, str | Path], *, length_unit: float | None = None) -> SolidBody:
    """Bodies from files of closed surfaces.

    Parameters
    ----------
    paths : mapping
        File of each material: .stl, or another that holds triangles (.msh, .vtk, .vtu, .inp).
    length_unit : float, optional
        Metres per unit of the files: 0.001 for millimetres. Left out: 1; a span below 1 cm or beyond 10 km is refused
        then.

    Raises
    ------
    InputError
        No such file, or one that cannot be read; an open surface, with the number of open edges and a place; edges of
        more than two triangles; a span that looks like another unit; two bodies that overlap, with volume and place.
    """
    if not paths:
        raise InputError("read_solids", "there is no file", 'Give for instance {"rock": "rock.stl"}.')
    unit = 1.0 if length_unit is None else length_unit
    if not (math.isfinite(unit) and unit > 0.0):
        raise InputError("length_unit", "not a positive length in m", "Give 0.001 for mm.", value=length_unit)
    corners = [read_surface(Path(path), unit) for path in paths.values()]
    every = np.concatenate([part.reshape(-1, 3) for part in corners])
    first = str(next(iter(paths.values())))
    remarks = checks.check_span(first, np.ptp(every, axis=0), length_unit, own_unit=False)
    parts = []
    for (name, path), own in zip(paths.items(), corners, strict=True):
        closed = close_surface(str(path), own)
        remarks += [f"{name}: {remark}" for remark in closed.remarks] if len(paths) > 1 else closed.remarks
        parts.append(closed)
    body = SolidBody(tuple(paths), tuple(parts), tuple(remarks))
    return SolidBody(body.materials, body.enclosures, (*remarks, *_refuse_overlap(body)))


def _refuse_overlap(body: SolidBody) -> list[str]:
    """Refuse two bodies at one place; say so where it is next to nothing."""
    remarks = []
    boxes = [np.stack([p.corners.min(axis=(0, 1)), p.corners.max(axis=(0, 1))]) for p in body.enclosures]
    for second in range(len(boxes)):
        for first in range(second):
            low = np.maximum(boxes[first][0], boxes[second][0])
            high = np.minimum(boxes[first][1], boxes[second][1])
            if not (low < high).all():
                continue
            points = _middles(low, high)
            both = body._locators[first].encloses(points) & body._locators[second].encloses(points)
            if not both.any():
                continue
            share = float(np.prod(high - low)) * float(both.mean())
            text = (
                f"{body.materials[first]!r} and {body.materials[second]!r} overlap by about {share:.3g} m3 around "
                f"{checks.place_of(points[both].mean(axis=0))}"
            )
            if share > OVERLAP * float(min(body.sizes[first], body.sizes[second])):
                raise InputError("bodies", text, "Cut one out of the other in the program that drew them.")
            remarks.append(f"{text}; it was left to the first.")
    return remarks


def _middles(low: Floats, high: Floats) -> Floats:
    """Middles (n, 3) of equal cells of a box, about as many as `PROBES`."""
    side = (float(np.prod(high - low)) / PROBES) ** (1.0 / 3.0)
    counts = np.clip(np.ceil((high - low) / side), 4, PROBES).astype(int)
    while counts.prod() > 4 * PROBES:
        counts = np.maximum(counts // 2, 4)
    axes = [lo + (np.arange(n) + 0.5) * (hi - lo) / n for lo, hi, n in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
