"""Terrain: heights on a regular grid from a survey, as a solid in 3D or a section along a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.body import OUTSIDE, Surface
from geodem.builders.section import Section
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

_MOST_STEPS = 100_000
"""Points of a line across a terrain."""


@dataclass(frozen=True)
class Layer:
    """A layer that follows the surface.

    Attributes
    ----------
    material : str
    bottom : float [m]
        Depth of its lower side below the surface, straight down; of the last layer infinite: down to the base.
    """

    material: str
    bottom: float = np.inf


@dataclass(frozen=True)
class Terrain:
    """Heights at the crossings of a regular grid; bilinear in between.

    Attributes
    ----------
    elevation : (nx, ny) float64 [m]
        x grows along the first axis, y along the second.
    origin : (2,) float64 [m]
        x and y of the first crossing.
    spacing : (2,) float64 [m]
    remarks : tuple of str
        What was repaired when it was read.
    degrees : (2, 2) float64, optional
        Of a terrain that was given in degrees: longitude and latitude of x = y = 0, and metres of a degree of each.
    """

    elevation: Floats
    origin: Floats
    spacing: Floats
    remarks: tuple[str, ...] = ()
    degrees: Floats | None = None

    @property
    def bounds(self) -> Floats:
        """Lowest and highest x, y (2, 2) [m]."""
        return np.stack([self.origin, self.origin + self.spacing * (np.array(self.elevation.shape) - 1)])

    def height(self, points: Floats) -> Floats:
        """Elevation (n,) [m] at points (n, 2) [m], bilinear; NaN outside."""
        place = (np.asarray(points, dtype=np.float64) - self.origin) / self.spacing
        last = np.array(self.elevation.shape) - 1
        # a point on the far edge belongs to the last cell; a hair beyond it is rounding
        within = np.all((place >= -1e-9) & (place <= last + 1e-9), axis=1)
        cell = np.clip(np.floor(np.where(within[:, None], place, 0.0)).astype(np.int64), 0, last - 1)
        u, v = np.clip(place - cell, 0.0, 1.0).T
        i, j = cell.T
        z = self.elevation
        low = z[i, j] * (1.0 - u) + z[i + 1, j] * u
        high = z[i, j + 1] * (1.0 - u) + z[i + 1, j + 1] * u
        return np.where(within, low * (1.0 - v) + high * v, np.nan)

    def metres(self, points: ArrayLike) -> Floats:
        """x and y (n, 2) [m] of places in the coordinates of the file, which are degrees or metres."""
        given = np.asarray(points, dtype=np.float64)
        return given if self.degrees is None else (given - self.degrees[0]) * self.degrees[1]

    def crop(self, low: ArrayLike, high: ArrayLike) -> Terrain:
        """The part between two corners (2,) [m], out to whole cells.

        Raises
        ------
        InputError
            Less than one cell lies between them.
        """
        first, last = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        most = np.array(self.elevation.shape) - 1
        start = np.clip(np.floor((first - self.origin) / self.spacing + 1e-9).astype(int), 0, most)
        stop = np.clip(np.ceil((last - self.origin) / self.spacing - 1e-9).astype(int), 0, most)
        if (start >= stop).any():
            raise InputError(
                "terrain, crop", f"no terrain lies between {first.tolist()} and {last.tolist()} m",
                f"Stay within {self.bounds[0].tolist()} and {self.bounds[1].tolist()} m.",
            )  # fmt: skip
        part = self.elevation[start[0] : stop[0] + 1, start[1] : stop[1] + 1]
        return replace(self, elevation=part.copy(), origin=self.origin + start * self.spacing)

    def body(self, *, base: float, layers: Sequence[Layer] | None = None) -> TerrainBody:
        """The ground between the surface and a level base.

        Parameters
        ----------
        base : float
            Elevation of the lower side [m].
        layers : sequence of Layer, optional
            From the surface down; one material "ground" where it is left out.

        Raises
        ------
        InputError
            Layers out of order, or a base that lies above the surface or within a layer but the last.
        """
        stack = checked_layers(layers)
        _refuse_high_base(base, float(self.elevation.min()), stack)
        return TerrainBody(self, float(base), stack)

    def section_along(
        self,
        points: ArrayLike,
        *,
        base: float,
        layers: Sequence[Layer] | None = None,
        step: float | None = None,
    ) -> Section:
        """The ground below a line, unrolled: x is the distance along it, y the elevation.

        Parameters
        ----------
        points : (k, 2) float [m]
            x and y of the ends and corners of the line, two or more.
        base : float
            Elevation of the lower side [m].
        layers : sequence of Layer, optional
            As in `body`.
        step : float, optional
            Distance between the points of the surface [m]; the spacing of the grid where it is left out. Straight
            in between.

        Raises
        ------
        InputError
            A line with fewer than two points, one that leaves the terrain, and what `body` refuses.
        """
        stack = checked_layers(layers)
        along, places = self._walk(points, step)
        top = self.height(places)
        if np.isnan(top).any():
            lost = places[np.flatnonzero(np.isnan(top))[0]]
            raise InputError(
                "terrain, line", f"it leaves the terrain at ({lost[0]:.6g}, {lost[1]:.6g}) m",
                f"Stay within {self.bounds[0].tolist()} and {self.bounds[1].tolist()} m.",
            )  # fmt: skip
        _refuse_high_base(base, float(top.min()), stack)
        levels = [top, *(top - layer.bottom for layer in stack[:-1]), np.full(len(top), float(base))]
        regions = [
            (layer.material, np.column_stack([np.r_[along, along[::-1]], np.r_[lower, upper[::-1]]]))
            for layer, upper, lower in zip(stack, levels[:-1], levels[1:], strict=True)
        ]
        return Section.from_polygons(regions, place="terrain, section")

    def _walk(self, points: ArrayLike, step: float | None) -> tuple[Floats, Floats]:
        """Distances (k,) and places (k, 2) [m] along a line, its corners included."""
        corners = np.asarray(points, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 2 or not np.isfinite(corners).all():
            raise InputError(
                "terrain, line", "these are not two or more places x, y", "Give [[x, y], [x, y]] in m.",
                value=points,
            )  # fmt: skip
        lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        if (lengths == 0.0).any():
            raise InputError("terrain, line", "a point stands twice", "Take it away.", value=points)
        wanted = float(self.spacing.min()) if step is None else step
        if not (np.isfinite(wanted) and wanted > 0.0):
            raise InputError("terrain, step", "this is not a positive number", "Give metres.", value=step)
        if not lengths.sum() < _MOST_STEPS * wanted:
            raise InputError(
                "terrain, step", f"steps of {wanted:.3g} m on a line of {lengths.sum():.3g} m are too many",
                "Give a larger step, or look whether the spacing of the heights is in metres.", value=step,
            )  # fmt: skip
        along, places = [np.zeros(1)], [corners[:1]]
        for start, end, length, behind in zip(
            corners[:-1], corners[1:], lengths, np.cumsum(lengths) - lengths, strict=True
        ):
            share = np.arange(1, max(1, round(length / wanted)) + 1) / max(1, round(length / wanted))
            along.append(behind + share * length)
            places.append(start + share[:, None] * (end - start))
        return np.concatenate(along), np.concatenate(places)


@dataclass(frozen=True)
class TerrainBody:
    """The ground below a terrain, in 3D; a `geodem.builders.body.Body`.

    Attributes
    ----------
    terrain : Terrain
    base : float [m]
        Elevation of the lower side.
    layers : tuple of Layer
        From the surface down.
    """

    terrain: Terrain
    base: float
    layers: tuple[Layer, ...]

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def materials(self) -> tuple[str, ...]:
        """Names, from the surface down."""
        return tuple(dict.fromkeys(layer.material for layer in self.layers))

    @property
    def bounds(self) -> Floats:
        """Lowest and highest coordinates (2, 3) [m]."""
        heights = np.array([[self.base], [self.terrain.elevation.max()]])
        return np.hstack([self.terrain.bounds, heights])

    @cached_property
    def sizes(self) -> Floats:
        """Volume of each material (m,) [m3], exact for the bilinear surface.

        The mean of a bilinear piece is that of its four corners; two flat triangles over a cell give the same within
        the warp of its corners.
        """
        z = self.terrain.elevation
        mean = float((0.25 * (z[:-1, :-1] + z[1:, :-1] + z[:-1, 1:] + z[1:, 1:])).mean())
        area = float(np.prod(np.diff(self.terrain.bounds, axis=0)))
        depths = np.array([0.0, *(layer.bottom for layer in self.layers[:-1]), mean - self.base])
        volume = dict.fromkeys(self.materials, 0.0)
        for layer, thickness in zip(self.layers, np.diff(depths), strict=True):
            volume[layer.material] += area * float(thickness)
        return np.array(list(volume.values()))

    @cached_property
    def surfaces(self) -> Sequence[Surface]:
        """The surface of the ground as two triangles a cell, and the base."""
        terrain = self.terrain
        nx, ny = terrain.elevation.shape
        x = terrain.origin[0] + terrain.spacing[0] * np.arange(nx)
        y = terrain.origin[1] + terrain.spacing[1] * np.arange(ny)
        corner = np.stack([*np.meshgrid(x, y, indexing="ij"), terrain.elevation], axis=-1)
        a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
        top = np.concatenate([np.stack(t, axis=-2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
        (west, south), (east, north) = terrain.bounds
        p, q, r, s = (
            (w, h, self.base) for w, h in ((west, south), (east, south), (east, north), (west, north))
        )
        return (Surface("surface", top), Surface("base", np.array([(p, r, q), (p, s, r)], dtype=np.float64)))

    @property
    def remarks(self) -> Sequence[str]:
        """What was repaired when the terrain was read."""
        return self.terrain.remarks

    def material_at(self, points: Floats) -> Integers:
        """Number of the material at points (n, 3) [m], -1 outside; (n,) int32."""
        given = np.asarray(points, dtype=np.float64)
        depth = self.terrain.height(given[:, :2]) - given[:, 2]
        bottoms = np.array([layer.bottom for layer in self.layers[:-1]])
        number = np.array([self.materials.index(layer.material) for layer in self.layers], dtype=np.int32)
        # beyond the terrain the depth is no number
        inside = (depth >= 0.0) & (given[:, 2] >= self.base)
        found = np.full(len(given), OUTSIDE, dtype=np.int32)
        found[inside] = number[np.searchsorted(bottoms, depth[inside], side="right")]
        return found


def checked_layers(layers: Sequence[Layer] | None) -> tuple[Layer, ...]:
    """Layers from the surface down, the last without end, or `InputError`."""
    stack = (Layer("ground"),) if layers is None else tuple(layers)
    if not stack:
        raise InputError("terrain, layers", "there is none", 'Give at least Layer("rock").')
    bottoms = np.array([0.0, *(layer.bottom for layer in stack)])
    if not np.isinf(bottoms[-1]) or not np.isfinite(bottoms[:-1]).all() or (np.diff(bottoms) <= 0.0).any():
        raise InputError(
            "terrain, layers", "the depths of their lower sides do not grow from 0 to the last, which has none",
            'Give [Layer("soil", 3.0), Layer("rock")], for instance.',
            value=[(layer.material, layer.bottom) for layer in stack],
        )  # fmt: skip
    return stack


def _refuse_high_base(base: float, lowest: float, layers: tuple[Layer, ...]) -> None:
    depth = layers[-2].bottom if len(layers) > 1 else 0.0
    if not np.isfinite(base) or base >= lowest - depth:
        what = "the surface" if depth == 0.0 else f"the lower side of {layers[-2].material!r}"
        raise InputError(
            "terrain, base", f"{what} goes down to {lowest - depth:.6g} m, and the base is not below it",
            "Give a lower base.", value=f"{base:.6g} m",
        )  # fmt: skip
