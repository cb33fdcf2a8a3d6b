"""Layered ground cut into slices: the geometry that limit equilibrium needs, in numpy alone.

The section is divided into vertical strips at the x of every polygon vertex. Polygons with disjoint interiors
leave, inside one strip, a stack of trapezoids; a column through it, its weight and its first moment follow
exactly.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Stands for "above everything" in strips with fewer layers than others; finite, so that 0 times it is 0.
_NOWHERE = 1e30


class NotASlopeError(ValueError):
    """The section is no slope that can be cut into slices; the text says why."""


@dataclass(frozen=True)
class Soil:
    """Strength and weight of one material.

    Parameters
    ----------
    unit_weight : float
        [N/m3].
    cohesion : float
        [Pa].
    friction_angle : float
        [rad].
    """

    unit_weight: float
    cohesion: float
    friction_angle: float


@dataclass(frozen=True)
class Surcharge:
    """Pressure normal to the ground surface between two of its points.

    Parameters
    ----------
    start, end : tuple of float
        Points (x, y) of the ground surface [m], in either order.
    pressure : float
        [Pa], positive when it presses on the ground.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    pressure: float


@dataclass(frozen=True)
class Slices:
    """Slices of one or many sliding masses, all moving towards -x; arrays of shape (masses, slices).

    Attributes
    ----------
    x, y : mid-point of the base [m]
    width : horizontal width [m]
    height : ground surface minus base at the middle of the slice [m]
    length : length of the base, a straight chord [m]
    sine, cosine : of the inclination of the base, positive where it drives the slide
    weight : vertical force per metre run, surcharge included [N/m]
    horizontal : force out of the slope [N/m]
    horizontal_moment : sum of such forces times their heights y [N]
    cohesion, tan_phi : strength at the base mid-point [Pa], [-]
    """

    x: Array
    y: Array
    width: Array
    height: Array
    length: Array
    sine: Array
    cosine: Array
    weight: Array
    horizontal: Array
    horizontal_moment: Array
    cohesion: Array
    tan_phi: Array


@dataclass
class Ground:
    """A section of layered ground, loads included.

    Parameters
    ----------
    regions : sequence of (str, sequence of array_like)
        Material name and rings (n, 2) [m]; the interior of a region is what an odd number of its rings
        enclose, so that further rings are holes. Interiors of different regions are disjoint.
    soils : mapping of str to Soil
    horizontal_acceleration : float, default 0
        Pseudo-static acceleration out of the slope, as a fraction of gravity. It acts on the soil, not on the
        surcharge.
    surcharges : sequence of Surcharge

    Raises
    ------
    NotASlopeError
        The section is in pieces, overlaps itself, or holds voids or overhangs above 0.1 % of its area.
    """

    regions: Sequence[tuple[str, Sequence[ArrayLike]]]
    soils: Mapping[str, Soil]
    horizontal_acceleration: float = 0.0
    surcharges: Sequence[Surcharge] = ()

    strip_edges: Array = field(init=False, repr=False)
    surface: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        names = list(dict.fromkeys(name for name, _ in self.regions))
        if not names:
            raise NotASlopeError("the section holds no ground")
        soils = [self.soils[name] for name in names]
        self._unit_weight = np.array([soil.unit_weight for soil in soils])
        self._cohesion = np.array([soil.cohesion for soil in soils])
        self._tan_phi = np.tan([soil.friction_angle for soil in soils])
        self._build_strips(names)
        self._build_surface()

    # -- geometry ------------------------------------------------------------------------------------------

    def _region_edges(self) -> tuple[Array, NDArray[np.int64]]:
        """Edges (x1, y1, x2, y2) with x1 <= x2 of all rings, and the number of the region of each."""
        edges, owner = [], []
        for number, (_, rings) in enumerate(self.regions):
            for ring in rings:
                points = np.asarray(ring, dtype=np.float64)
                if np.array_equal(points[0], points[-1]):
                    points = points[:-1]
                edge = np.hstack([points, np.roll(points, -1, axis=0)])
                backward = edge[:, 0] > edge[:, 2]
                edge[backward] = edge[backward][:, [2, 3, 0, 1]]
                edges.append(edge)
                owner.append(np.full(len(edge), number))
        return np.vstack(edges), np.concatenate(owner)

    def _build_strips(self, names: list[str]) -> None:
        edges, owner = self._region_edges()
        x_all = np.unique(edges[:, [0, 2]])
        self.tolerance = 1e-9 * float(max(np.ptp(x_all), np.ptp(edges[:, [1, 3]])))
        keep = np.concatenate([[True], np.diff(x_all) > self.tolerance])
        x = self.strip_edges = x_all[keep]
        upright = edges[:, 2] - edges[:, 0] <= self.tolerance
        edges, owner = edges[~upright], owner[~upright]
        material_of = np.array([names.index(name) for name, _ in self.regions])
        slope = (edges[:, 3] - edges[:, 1]) / (edges[:, 2] - edges[:, 0])

        stacks: list[list[tuple[float, float, float, float, int]]] = []
        for left, right in itertools.pairwise(x):
            on = np.flatnonzero(
                (edges[:, 0] <= left + self.tolerance) & (edges[:, 2] >= right - self.tolerance)
            )
            y_left = edges[on, 1] + slope[on] * (left - edges[on, 0])
            y_right = edges[on, 1] + slope[on] * (right - edges[on, 0])
            # Inside one region the boundaries alternate: in, out, in, out.
            order = np.lexsort((y_left + y_right, owner[on]))
            low, high = order[0::2], order[1::2]
            stack = [
                (y_left[i], y_right[i], y_left[j], y_right[j], int(material_of[owner[on[i]]]))
                for i, j in zip(low, high, strict=True)
                if y_left[j] + y_right[j] - y_left[i] - y_right[i] > self.tolerance
            ]
            if not stack:
                raise NotASlopeError(f"the section is in separate pieces: no ground near x = {left:.6g} m")
            stacks.append(sorted(stack, key=lambda layer: layer[0] + layer[1]))

        layers = max(len(stack) for stack in stacks)
        shape = (len(stacks), layers)
        self._low_left, self._low_right = np.full(shape, _NOWHERE), np.full(shape, _NOWHERE)
        self._high_left, self._high_right = np.full(shape, _NOWHERE), np.full(shape, _NOWHERE)
        self._material = np.zeros(shape, dtype=np.int64)
        for k, stack in enumerate(stacks):
            n = len(stack)
            columns = list(zip(*stack, strict=True))
            self._low_left[k, :n], self._low_right[k, :n] = columns[0], columns[1]
            self._high_left[k, :n], self._high_right[k, :n] = columns[2], columns[3]
            self._material[k, :n] = columns[4]
        self._layers = np.array([len(stack) for stack in stacks])
        self._refuse_voids()

    def _refuse_voids(self) -> None:
        width = np.diff(self.strip_edges)
        last = self._layers - 1
        rows = np.arange(len(width))
        self._top_left, self._top_right = self._high_left[rows, last], self._high_right[rows, last]
        middle_low = 0.5 * (self._low_left + self._low_right)
        middle_high = 0.5 * (self._high_left + self._high_right)
        gap = np.where(middle_low[:, 1:] < 0.5 * _NOWHERE, middle_low[:, 1:] - middle_high[:, :-1], 0.0)
        top, bottom = middle_high[rows, last], middle_low[:, 0]
        area = float(np.sum((top - bottom) * width))
        void = float(np.sum(np.clip(gap, 0.0, None).sum(axis=1) * width))
        overlap = float(np.sum(np.clip(-gap, 0.0, None).sum(axis=1) * width))
        if void > 1e-3 * area:
            raise NotASlopeError(f"the section holds an opening or an overhang of {void:.3g} m2")
        if overlap > 1e-3 * area:
            raise NotASlopeError(f"regions of the section overlap over {overlap:.3g} m2")

    def _build_surface(self) -> None:
        """Ground surface from left to right; a vertical face is two points with one x."""
        x = self.strip_edges
        points = np.empty((2 * len(self._top_left), 2))
        points[0::2] = np.column_stack([x[:-1], self._top_left])
        points[1::2] = np.column_stack([x[1:], self._top_right])
        step = np.hypot(*np.diff(points, axis=0).T)
        points = points[np.concatenate([[True], step > self.tolerance])]
        # Points on a straight run add nothing but slices.
        a, b = np.diff(points[:-1], axis=0), np.diff(points[1:], axis=0)
        bent = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > self.tolerance * np.hypot(*(a + b).T)
        self.surface = points[np.concatenate([[True], bent, [True]])]

    @property
    def height(self) -> float:
        """Difference in level of the highest and the lowest point of the ground surface [m]."""
        return float(np.ptp(self.surface[:, 1]))

    def mirrored(self) -> Ground:
        """The same ground with x reversed."""
        regions = [
            (name, [np.asarray(ring, dtype=np.float64) * [-1.0, 1.0] for ring in rings])
            for name, rings in self.regions
        ]
        surcharges = [
            Surcharge((-load.end[0], load.end[1]), (-load.start[0], load.start[1]), load.pressure)
            for load in self.surcharges
        ]
        return Ground(regions, self.soils, self.horizontal_acceleration, surcharges)

    def _strip(self, x: Array) -> tuple[NDArray[np.int64], Array]:
        k = np.clip(np.searchsorted(self.strip_edges, x, side="right") - 1, 0, len(self._layers) - 1)
        return k, (x - self.strip_edges[k]) / (self.strip_edges[k + 1] - self.strip_edges[k])

    def bottom(self, x: Array) -> Array:
        """Level of the underside of the section at x [m]."""
        k, t = self._strip(x)
        return self._low_left[k, 0] * (1.0 - t) + self._low_right[k, 0] * t

    def cohesionless_surface(self) -> Array:
        """Pieces (n, 5) of the surface whose soil has no cohesion: x1, y1, x2, y2, tan(phi)."""
        rows = np.arange(len(self._layers))
        material = self._material[rows, self._layers - 1]
        bare = self._cohesion[material] == 0.0
        x = self.strip_edges
        pieces = [x[:-1], self._top_left, x[1:], self._top_right, self._tan_phi[material]]
        return np.column_stack(pieces)[bare]

    def boundaries(self) -> Array:
        """Undersides of all layers as pieces (n, 4): x1, y1, x2, y2 [m]."""
        x = self.strip_edges
        shape = self._low_left.shape
        pieces = np.stack(
            [
                np.broadcast_to(x[:-1, None], shape),
                self._low_left,
                np.broadcast_to(x[1:, None], shape),
                self._low_right,
            ],
            axis=-1,
        )
        return pieces[self._low_left < 0.5 * _NOWHERE]

    def layer_lines(self) -> list[tuple[Array, Array]]:
        """Middle lines x (k,), y (k,) of the layers with other ground above or below, one a material.

        Where a material occurs twice in a strip the lower layer counts.
        """
        lines = []
        rows = np.arange(len(self._layers))
        x = self.strip_edges
        for material in np.unique(self._material[self._low_left < 0.5 * _NOWHERE]):
            here = (self._material == material) & (self._low_left < 0.5 * _NOWHERE)
            with_other = here.any(axis=1) & (self._layers > here.sum(axis=1))
            if not np.any(with_other):
                continue
            first = np.argmax(here, axis=1)
            k, layer = rows[with_other], first[with_other]
            left = 0.5 * (self._low_left[k, layer] + self._high_left[k, layer])
            right = 0.5 * (self._low_right[k, layer] + self._high_right[k, layer])
            lines.append((np.column_stack([x[k], x[k + 1]]).ravel(), np.column_stack([left, right]).ravel()))
        return lines

    def breaks(self) -> Array:
        """The x where slices must end: bends of the surface, ends of layers, ends of surcharges [m]."""
        ends = [x for load in self.surcharges for x in (load.start[0], load.end[0])]
        return np.unique(np.concatenate([self.strip_edges, ends]))

    # -- slices --------------------------------------------------------------------------------------------

    def slices(self, x_edges: Array, y_edges: Array) -> Slices:
        """Cut sliding masses into slices.

        Parameters
        ----------
        x_edges, y_edges : ndarray, (masses, slices + 1)
            Slip surface at the slice sides, x not decreasing [m]; slices of no width are allowed and weigh
            nothing.
        """
        left, right = x_edges[:, :-1], x_edges[:, 1:]
        x = 0.5 * (left + right)
        y = 0.5 * (y_edges[:, :-1] + y_edges[:, 1:])
        width = right - left
        rise = np.diff(y_edges, axis=1)
        length = np.hypot(width, rise)
        safe = np.where(length > 0.0, length, 1.0)

        k, t = self._strip(x)
        t = t[..., None]
        low = self._low_left[k] * (1.0 - t) + self._low_right[k] * t
        high = self._high_left[k] * (1.0 - t) + self._high_right[k] * t
        base = np.maximum(low, y[..., None])
        material = self._material[k]
        load = np.clip(high - base, 0.0, None) * self._unit_weight[material]
        soil_weight = load.sum(axis=-1) * width
        moment = (load * 0.5 * (high + base)).sum(axis=-1) * width
        layer = np.maximum((low <= y[..., None] + self.tolerance).sum(axis=-1) - 1, 0)
        at_base = np.take_along_axis(material, layer[..., None], axis=-1)[..., 0]
        top = self._top_left[k] * (1.0 - t[..., 0]) + self._top_right[k] * t[..., 0]

        weight = soil_weight
        horizontal = self.horizontal_acceleration * soil_weight
        horizontal_moment = self.horizontal_acceleration * moment
        if self.surcharges:
            slope = (self._top_right[k] - self._top_left[k]) / np.diff(self.strip_edges)[k]
            for surcharge in self.surcharges:
                first, last = sorted((surcharge.start[0], surcharge.end[0]))
                covered = np.clip(np.minimum(right, last) - np.maximum(left, first), 0.0, None)
                # Pressure p on the surface y = g(x) is p g' dx along +x (into the slope) and p dx downwards.
                push = surcharge.pressure * slope * covered
                weight = weight + surcharge.pressure * covered
                horizontal = horizontal - push
                horizontal_moment = horizontal_moment - push * top
            faces, face_moment = self._surcharge_on_faces(left, right, y_edges)
            horizontal, horizontal_moment = horizontal - faces, horizontal_moment - face_moment
        return Slices(
            x=x,
            y=y,
            width=width,
            height=top - y,
            length=length,
            sine=rise / safe,
            cosine=np.where(length > 0.0, width / safe, 1.0),
            weight=weight,
            horizontal=horizontal,
            horizontal_moment=horizontal_moment,
            cohesion=self._cohesion[at_base],
            tan_phi=self._tan_phi[at_base],
        )

    def _surcharge_on_faces(self, left: Array, right: Array, y_edges: Array) -> tuple[Array, Array]:
        """Force along +x of surcharges on vertical faces, and its moment about y = 0, slice by slice."""
        force, moment = np.zeros_like(left), np.zeros_like(left)
        step = self._top_left[1:] - self._top_right[:-1]
        for k in np.flatnonzero(np.abs(step) > self.tolerance):
            x, levels = self.strip_edges[k + 1], sorted((self._top_right[k], self._top_left[k + 1]))
            for load in self.surcharges:
                first, last = sorted((load.start[0], load.end[0]))
                if not first - self.tolerance <= x <= last + self.tolerance:
                    continue
                # A surcharge that runs past the face covers all of it; one that ends there ends at its point.
                ends = [p[1] for p in (load.start, load.end) if abs(p[0] - x) <= self.tolerance]
                toe, crest = levels
                if len(ends) == 2:
                    toe, crest = max(toe, min(ends)), min(crest, max(ends))
                elif ends:
                    other = load.start if abs(load.end[0] - x) <= self.tolerance else load.end
                    on_upper_side = (other[0] > x) == (step[k] > 0.0)
                    toe, crest = (max(toe, ends[0]), crest) if on_upper_side else (toe, min(crest, ends[0]))
                holds = (left <= x + self.tolerance) & (right > x + self.tolerance)
                covered = np.clip(crest - np.maximum(toe, y_edges[:, :-1]), 0.0, None) * holds
                push = np.sign(step[k]) * load.pressure * covered
                force += push
                moment += push * (crest - 0.5 * covered)
        return force, moment
