"""How large the spacing of particles may be at each place of a section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from geodem.builders.outline import (
    Chain,
    Floats,
    Graph,
    Ints,
    Mask,
    along,
    first_hits,
    place_along,
    segment_distance,
    split_at_corners,
)

if TYPE_CHECKING:
    from geodem.builders.section import Section

# two faces bound a thin region where the ray across meets the far one within 60 degrees of its normal
FACING = 0.5
# a wedge wider than this (tangent of 15 degrees) is a corner, not a thin region
WEDGE = 0.268
# towards its tip, a lens is looked at down to this share of its thickness (or of what would be thick enough)
TIP = 1.0 / 3.0
# sources within 7 % of each other are looked up together
LEVEL = 1.07


@dataclass(frozen=True)
class SizeField:
    """Largest spacing allowed at a place: the least of all limits, each growing away from where it acts.

    h(x) = min(base, s_i + grading max(|x - x_i| - s_i / 2, 0), s_k + grading distance(x, geometry_k))

    The flat middle of a point's limit makes neighbouring points act as the line that they stand for.

    Attributes
    ----------
    base : float [m]
    grading : float
        Growth of the spacing per unit of distance.
    places, limits : (k, 2), (k,) float64 [m]
        Points x_i and their limits s_i.
    shapes : tuple of (geometry, float [m])
    """

    base: float
    grading: float
    places: Floats
    limits: Floats
    shapes: tuple[tuple[Any, float], ...] = ()
    trees: tuple[tuple[float, Any, Floats], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.spatial import cKDTree

        acts = self.limits < self.base
        places, limits = self.places[acts], self.limits[acts]
        level = np.floor(np.log(limits) / np.log(LEVEL)).astype(np.int64)
        trees = []
        for value in np.unique(level):
            here = level == value
            trees.append((float(limits[here].min()), cKDTree(places[here]), limits[here]))
        object.__setattr__(self, "trees", tuple(trees))

    @property
    def uniform(self) -> bool:
        """True where the spacing is the base everywhere."""
        return not self.trees and not any(limit < self.base for _, limit in self.shapes)

    @property
    def smallest(self) -> float:
        """Least spacing anywhere [m]."""
        shapes = [limit for _, limit in self.shapes]
        return float(min([self.base, *(tree[0] for tree in self.trees), *shapes]))

    def __call__(self, points: Floats) -> Floats:
        """Spacing [m] at (n, 2) points [m], shape (n,)."""
        import shapely

        spacing = np.full(len(points), self.base)
        for shape, limit in self.shapes:
            if limit < self.base:
                distance = shapely.distance(shapely.points(points), shape)
                spacing = np.minimum(spacing, limit + self.grading * distance)
        for least, tree, limits in self.trees:
            open_ = np.flatnonzero(spacing > least)
            if not len(open_):
                continue
            reach = (spacing[open_].max() - least) / self.grading + 0.5 * LEVEL * least
            distance, nearest = tree.query(points[open_], distance_upper_bound=reach)
            found = np.isfinite(distance)
            limit = limits[nearest[found]]
            limit = limit + self.grading * np.maximum(distance[found] - 0.5 * limit, 0.0)
            spacing[open_[found]] = np.minimum(spacing[open_[found]], limit)
        return spacing

    def with_limits(self, places: Floats, limits: Floats) -> SizeField:
        """The same field with further limits."""
        return SizeField(
            self.base,
            self.grading,
            np.concatenate([self.places, places]),
            np.concatenate([self.limits, limits]),
            self.shapes,
        )


@dataclass(frozen=True)
class ThinPlaces:
    """Places where a region is thinner than the layers asked for.

    Attributes
    ----------
    places : (k, 2) float64 [m]
        On the faces of the region.
    thickness : (k,) float64 [m]
    spacing : (k,) float64 [m]
        What it would be there without the thin region.
    region : (k,) int64
        Index into the section's regions.
    """

    places: Floats
    thickness: Floats
    spacing: Floats
    region: Ints


@dataclass(frozen=True)
class Layout:
    """Lines of a section cut into chains, and the spacing that they allow."""

    chains: list[Chain]
    corner: Mask
    field: SizeField
    thin: ThinPlaces


def lay_out(
    section: Section,
    graph: Graph,
    free: Floats,
    base: float,
    *,
    layers: int,
    grading: float,
    shapes: Sequence[tuple[Any, float]],
    heed_thin: bool = True,
) -> Layout:
    """Chains and size field of a section for one base spacing.

    Parameters
    ----------
    section : Section
    graph : Graph
        Its noded lines.
    free : (p, 2) float64 [m]
        Prescribed particles that lie on no line.
    base : float [m]
    layers : int
        Rows of triangles wanted across every region.
    grading : float
    shapes : sequence of (geometry, spacing [m])
        Further places to refine.
    heed_thin : bool
        False: thin regions are found but do not limit the spacing.
    """
    own = SizeField(base, grading, np.empty((0, 2)), np.empty(0), tuple(shapes))
    size, shape, corner = own, own, graph.pinned
    chains: list[Chain] = []
    thin = ThinPlaces(np.empty((0, 2)), np.empty(0), np.empty(0), np.empty(0, dtype=np.int64))
    # what is found depends on how finely it is looked for: look again where the first look refined much
    for _ in range(4):
        before = size.smallest
        # what counts as noise of a line follows from what was asked for, not from the refinement at its corners
        chains, corner, (bends, allowed) = split_at_corners(graph, shape(graph.vertices))
        bare = own.with_limits(bends, allowed)
        bare = bare.with_limits(*_near_corners(chains, graph.vertices[corner], free, base))
        _, lengths = place_along(
            chains, size if size is not own else bare, min(before, bare.smallest), density=2.0
        )
        thin = _thin_places(section, chains, lengths, bare, layers)
        size = bare.with_limits(thin.places, thin.thickness / layers) if heed_thin else bare
        shape = own.with_limits(thin.places, thin.thickness / layers)
        if size.smallest > 0.6 * before:
            break
    return Layout(chains, corner, size, thin)


def _near_corners(
    chains: Sequence[Chain], corners: Floats, free: Floats, base: float
) -> tuple[Floats, Floats]:
    """Limits at corners and free points: the distance to the next one, or to a line that is not its own."""
    import shapely
    from scipy.spatial import cKDTree

    points = np.concatenate([corners, free])
    limits = np.full(len(points), np.inf)
    if len(points) > 1:
        limits = np.asarray(cKDTree(points).query(points, k=2)[0])[:, 1]
    a = np.concatenate([chain.points[:-1] for chain in chains])
    b = np.concatenate([chain.points[1:] for chain in chains])
    owner = np.repeat(np.arange(len(chains)), [len(chain.points) - 1 for chain in chains])
    tree = shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))
    point, segment = tree.query(shapely.points(points), predicate="dwithin", distance=base)
    first = np.array([chain.points[0] for chain in chains])
    last = np.array([chain.points[-1] for chain in chains])
    meets = (first[owner[segment]] == points[point]).all(axis=1)
    meets |= (last[owner[segment]] == points[point]).all(axis=1)
    point, segment = point[~meets], segment[~meets]
    np.minimum.at(limits, point, segment_distance(points[point], a[segment], b[segment]))
    return points, limits


def _thin_places(
    section: Section, chains: Sequence[Chain], lengths: Sequence[Floats], bare: SizeField, layers: int
) -> ThinPlaces:
    """Look across from both sides of every line, and keep what is thinner than `layers` spacings."""
    a = np.concatenate([chain.points[:-1] for chain in chains])
    b = np.concatenate([chain.points[1:] for chain in chains])
    owner = np.repeat(np.arange(len(chains)), [len(chain.points) - 1 for chain in chains])
    starts = np.concatenate([[0], np.cumsum([len(chain.points) - 1 for chain in chains])])
    places, own = [], []
    for index, (chain, at) in enumerate(zip(chains, lengths, strict=True)):
        arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(chain.points, axis=0).T))])
        middle = 0.5 * (at[1:] + at[:-1])
        places.append(along(chain, arc, middle))
        own.append(starts[index] + np.clip(np.searchsorted(arc, middle, side="right") - 1, 0, len(arc) - 2))
    origin = np.tile(np.concatenate(places), (2, 1))
    from_ = np.tile(np.concatenate(own), 2)
    run = b[from_] - a[from_]
    normal = np.column_stack([-run[:, 1], run[:, 0]]) / np.hypot(*run.T)[:, None]
    normal[len(normal) // 2 :] *= -1.0
    spacing = bare(origin)
    thickness, hit = first_hits(origin, normal, layers * spacing, a, b, from_)
    reach = layers * spacing
    region = _region_at(section, origin + 0.5 * np.minimum(thickness, reach)[:, None] * normal)
    thickest = np.zeros(len(section.regions))
    known = region >= 0
    np.maximum.at(thickest, region[known], np.minimum(thickness, reach)[known])
    seen = np.flatnonzero((hit >= 0) & known)
    origin, normal, spacing, thickness = origin[seen], normal[seen], spacing[seen], thickness[seen]
    from_, hit, region = from_[seen], hit[seen], region[seen]
    across = b[hit] - a[hit]
    turned = np.abs(normal[:, 0] * across[:, 1] - normal[:, 1] * across[:, 0]) / np.hypot(*across.T)
    keep = (turned >= FACING) & (thickness < layers * spacing * (1.0 - 1e-9))
    tip = _distance_to_tip(chains, origin, thickness, owner[from_], owner[hit], a, b, from_, hit)
    # a wedge has no thickness of its own: every spacing is too large for its tip
    keep &= (thickness <= WEDGE * tip) & (tip >= 2.0 * spacing)
    keep &= ~np.isfinite(tip) | (thickness >= TIP * thickest[region])
    return ThinPlaces(origin[keep], thickness[keep], spacing[keep], region[keep])


def _region_at(section: Section, points: Floats) -> Ints:
    """Index of the region that holds each point; -1 outside."""
    import shapely

    region = np.full(len(points), -1, dtype=np.int64)
    for index, part in enumerate(section.regions):
        region[shapely.contains_xy(part.polygon, points[:, 0], points[:, 1])] = index
    return region


def _distance_to_tip(
    chains: Sequence[Chain],
    origin: Floats,
    thickness: Floats,
    near: Ints,
    far: Ints,
    a: Floats,
    b: Floats,
    from_: Ints,
    hit: Ints,
) -> Floats:
    """Distance [m] to the corner in which the two faces meet; inf where they meet in none."""
    from scipy.spatial import cKDTree

    tip = np.full(len(origin), np.inf)
    ends = np.array([[chain.first, chain.last] for chain in chains])
    corners = np.array([[chain.points[0], chain.points[-1]] for chain in chains])
    for i in range(2):
        for j in range(2):
            shared = (ends[near, i] == ends[far, j]) & (near != far)
            tip[shared] = np.minimum(tip[shared], np.hypot(*(origin - corners[near, i]).T)[shared])
    # faces that are cut into several chains still point at the corner where they would meet
    run, across = b[from_] - a[from_], b[hit] - a[hit]
    cross = run[:, 0] * across[:, 1] - run[:, 1] * across[:, 0]
    slanted = np.abs(cross) > 1e-6 * np.hypot(*run.T) * np.hypot(*across.T)
    gap = a[hit] - a[from_]
    share = (gap[:, 0] * across[:, 1] - gap[:, 1] * across[:, 0]) / np.where(slanted, cross, 1.0)
    apex = a[from_] + share[:, None] * run
    if len(apex):
        off, _ = cKDTree(corners.reshape(-1, 2)).query(apex)
        meets = slanted & (off < 1e-3 * thickness)
        tip[meets] = np.minimum(tip[meets], np.hypot(*(origin - apex).T)[meets])
    return tip
