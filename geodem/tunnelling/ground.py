"""The ground with its openings still full, as one model whose parts can be taken out exactly.

The ground of every opening is a material of its own, so that the particles of a wall have separate stress points
inside and outside of it (see `geodem.model`). Taking the opening out then takes those points away and changes none of
the others: what the excavated ground exerted on the rest is the sum of its stress points' forces, to the last bit.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from ..builders.ground import STANDARD_GRAVITY, GroundProperties, Surcharge, build_ground, held_freedoms
from ..builders.particles import Particles, fill_section
from ..builders.section import Region, Section
from ..errors import InputError
from ..laws import GROUND_LAWS
from ..model import Links, Model, SparseVectors, transposed
from .plan import Opening

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

GRADING = 0.1
"""Growth of the spacing per metre away from a wall: the yielded zone wants as many particles as the wall."""
WALL_PARTICLES = 80
"""Particles around an opening where nothing is said of their spacing, at the number of particles below."""
USUAL_PARTICLES = 4000
FAR = "far"
"""A side beyond which the ground goes on: see `geodem.tunnelling.far`."""


@dataclass(frozen=True, eq=False)
class TunnelGround:
    """Particles of the whole section and which of its parts are openings.

    Attributes
    ----------
    particles : Particles
        Its materials are those of the parts.
    model : Model
        Of everything, nothing dug out.
    openings : tuple of Opening
        Their polygons cut to the section.
    material_of : tuple of str
        Material of every part.
    opening_of : (parts,) int
        Opening of every part, -1 for ground that stays.
    weight_of_point : (s, 2) [N/m]
    far_sides : tuple of str
    """

    particles: Particles
    model: Model
    openings: tuple[Opening, ...]
    material_of: tuple[str, ...]
    opening_of: Integers
    weight_of_point: Floats
    far_sides: tuple[str, ...] = ()

    def standing_points(self, dug: Collection[int]) -> NDArray[np.bool_]:
        """Stress points (s,) that are left where the openings `dug` are out."""
        gone = np.isin(self.opening_of, list(dug))
        return np.asarray(~gone[self.model.point_material])

    def standing_triangles(self, dug: Collection[int]) -> NDArray[np.bool_]:
        """Triangles (m,) that are left."""
        gone = np.isin(self.opening_of, list(dug))
        return np.asarray(~gone[self.model.triangle_material])

    def wall(self, opening: int, dug: Collection[int]) -> Integers:
        """Edges (k, 2) of the standing ground along an opening that is out, ground on the left, in order.

        Edges to ground that is still inside another opening belong to the wall as well.
        """
        triangles = self.model.triangles.astype(np.int64)
        standing = self.standing_triangles(dug)
        inside = self.opening_of[self.model.triangle_material] == opening
        sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
        count = self.model.particles
        opposite = {int(a) * count + int(b) for a, b in sides[inside].reshape(-1, 2)}
        own = sides[standing].reshape(-1, 2)
        wall = [edge for edge in own.tolist() if edge[1] * count + edge[0] in opposite]
        return _chained(np.array(wall, dtype=np.int64).reshape(-1, 2))


def make_tunnel_ground(
    section: Section,
    openings: Sequence[Opening],
    materials: Mapping[str, GroundProperties],
    *,
    boundary: Mapping[str, str],
    particles: int | None = None,
    spacing: float | None = None,
    wall_spacing: float | None = None,
    grading: float = GRADING,
    seed: int = 1,
    surcharges: Sequence[Surcharge] = (),
    gravity: float = STANDARD_GRAVITY,
    refine: Sequence[tuple[object, float]] = (),
    points: Sequence[tuple[float, float]] = (),
) -> TunnelGround:
    """Fill a section and its openings with particles, closest at the walls.

    Parameters
    ----------
    section : Section
        The ground before anything is dug.
    openings : sequence of Opening
        Disjoint; one that reaches over a side of the section is cut there, as half a tunnel is at a line of symmetry.
    materials : mapping of str to GroundProperties
    boundary : mapping
        Side to "free", "roller", "fixed" or "far".
    particles, spacing : exactly one of the two
    wall_spacing : float, optional [m]
        Of the particles on the walls.
    grading : float
        Growth of the spacing per unit of distance from a wall.
    seed : int
    surcharges : sequence of Surcharge
    gravity : float [m/s2]
        Zero where the initial stress is uniform.
    refine : sequence of (geometry, spacing)
    points : sequence of (x, y) that must be particles

    Raises
    ------
    InputError
    """
    outline = section.outline
    cut = tuple(replace(o, polygon=_cut(o, outline)) for o in openings)
    parts, material_of, opening_of = _parts(section, cut)
    wall = wall_spacing or _usual_wall_spacing(openings, particles)
    lines = [(o.polygon.exterior, wall) for o in cut]
    filled = fill_section(
        parts, particles=particles, spacing=spacing, seed=seed, thin="refine", layers=2, grading=grading,
        refine=[*lines, *refine], points=[*points, *(p for s in surcharges for p in (s.start, s.end))],
    )  # fmt: skip
    far = tuple(side for side, support in boundary.items() if support == FAR)
    named = {part: materials[material] for part, material in zip(parts.materials, material_of, strict=True)}
    model = _build(filled, named, boundary, surcharges, gravity, held=not far)
    densities = np.array([named[part].density for part in parts.materials])
    weights = model.point_area * densities[model.point_material]
    return TunnelGround(
        particles=filled,
        model=model,
        openings=cut,
        material_of=material_of,
        opening_of=opening_of,
        weight_of_point=weights[:, None] * np.array([0.0, -gravity]),
        far_sides=far,
    )


def _build(
    filled: Particles,
    named: Mapping[str, GroundProperties],
    boundary: Mapping[str, str],
    surcharges: Sequence[Surcharge],
    gravity: float,
    *,
    held: bool,
) -> Model:
    """The whole model; far sides are held while it is made, and free again afterwards."""
    sides = {side: "fixed" if support == FAR else support for side, support in boundary.items()}
    model = build_ground(filled, named, boundary=sides, surcharges=surcharges, gravity=gravity)
    if held:
        return model
    kept = {side: support for side, support in boundary.items() if support != FAR}
    return replace(model, held=held_freedoms(filled, kept))


def _usual_wall_spacing(openings: Sequence[Opening], particles: int | None) -> float:
    shortest = min(float(o.polygon.exterior.length) for o in openings)
    return shortest / WALL_PARTICLES * float(np.sqrt(USUAL_PARTICLES / (particles or USUAL_PARTICLES)))


def _cut(opening: Opening, outline: object) -> object:
    inside = shapely.intersection(opening.polygon, outline)
    if inside.geom_type != "Polygon" or inside.area <= 0.0:
        raise InputError(
            opening.name, "the opening does not lie in the ground as one piece", "Move it into the section."
        )
    return inside


def _parts(section: Section, openings: Sequence[Opening]) -> tuple[Section, tuple[str, ...], Integers]:
    """Section of the parts, and the material and opening of each part."""
    dug = shapely.union_all([o.polygon for o in openings])
    regions: list[Region] = []
    names: dict[str, tuple[str, int]] = {}
    for region in section.regions:
        regions += [Region(region.material, p) for p in _polygons(shapely.difference(region.polygon, dug))]
        if regions and regions[-1].material == region.material:
            names.setdefault(region.material, (region.material, -1))
    for number, opening in enumerate(openings):
        for region in section.regions:
            part = f"{region.material} in {opening.name}"
            found = _polygons(shapely.intersection(region.polygon, opening.polygon))
            regions += [Region(part, p) for p in found]
            if found:
                names[part] = (region.material, number)
    parts = Section(tuple(regions))
    material_of = tuple(names[part][0] for part in parts.materials)
    opening_of = np.array([names[part][1] for part in parts.materials], dtype=np.int64)
    return parts, material_of, opening_of


def _polygons(shape: object) -> list[shapely.Polygon]:
    area = float(shapely.area(shape))
    return [p for p in shapely.get_parts(shape) if p.geom_type == "Polygon" and p.area > 1e-9 * area]


def _chained(edges: Integers) -> Integers:
    """Edges in the order in which they follow each other; an open line from its beginning."""
    if len(edges) == 0:
        return edges
    following = {int(a): int(b) for a, b in edges}
    begins = sorted(set(following) - set(following.values()))
    ordered: list[tuple[int, int]] = []
    left = dict(following)
    for start in [*begins, *sorted(following)]:
        node = start
        while node in left:
            after = left.pop(node)
            ordered.append((node, after))
            node = after
    return np.array(ordered, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Standing:
    """What is left of the ground as a model of its own.

    Attributes
    ----------
    model : Model
    particle : (n,) int
        Of the whole ground; nodes of bolts are not among them.
    point : (s,) int
        Stress points of the whole ground.
    """

    model: Model
    particle: Integers
    point: Integers

    def own(self, whole: Integers, count: int) -> Integers:
        """Numbers in this model of particles of the whole ground of `count` particles; -1 where they are gone."""
        number = np.full(count, -1, dtype=np.int64)
        number[self.particle] = np.arange(len(self.particle))
        return np.asarray(number[whole])


def standing(
    ground: TunnelGround, dug: Collection[int], nodes: Floats | None = None, links: Links | None = None
) -> Standing:
    """The model of what is left.

    Parameters
    ----------
    ground : TunnelGround
    dug : collection of int
    nodes : (b, 2) [m], optional
        Nodes of bolts, which become particles behind the others.
    links : Links, optional
        Of supports; their particles are those of the model that results.
    """
    whole = ground.model
    keep = ground.standing_points(dug)
    point = np.flatnonzero(keep)
    particle = np.unique(whole.point_particle[keep]).astype(np.int64)
    number = np.full(whole.particles, -1, dtype=np.int64)
    number[particle] = np.arange(len(particle))
    nodes = np.zeros((0, 2)) if nodes is None else nodes
    more = len(nodes)
    entries = np.repeat(keep, np.diff(whole.point_gradient.start))
    start = np.zeros(len(point) + 1, dtype=np.int32)
    np.cumsum(np.diff(whole.point_gradient.start)[keep], out=start[1:])
    gradient = SparseVectors(
        start,
        number[whole.point_gradient.column[entries]].astype(np.int32),
        np.ascontiguousarray(whole.point_gradient.vector[entries]),
    )
    used = np.unique(whole.point_material[keep])
    renumber = np.full(len(whole.parameters), -1, dtype=np.int32)
    # openings of one material share its parameters: fewer materials make a faster kernel
    distinct = list(dict.fromkeys(whole.parameters[k] for k in used))
    for k in used:
        renumber[k] = distinct.index(whole.parameters[k])
    owner = number[whole.point_particle[keep]]
    area = np.bincount(owner, whole.point_area[keep], minlength=len(particle))
    weight = np.stack(
        [np.bincount(owner, ground.weight_of_point[keep, axis], minlength=len(particle)) for axis in (0, 1)],
        axis=1,
    )
    triangles = ground.standing_triangles(dug)
    model = Model(
        positions=np.concatenate([whole.positions[particle], nodes]),
        triangles=number[whole.triangles[triangles]].astype(np.int32),
        triangle_material=whole.triangle_material[triangles],
        material_names=whole.material_names,
        law=whole.law,
        parameters=tuple(distinct),
        point_particle=owner.astype(np.int32),
        point_material=renumber[whole.point_material[keep]],
        point_area=np.ascontiguousarray(whole.point_area[keep]),
        point_gradient=gradient,
        particle_gradient=transposed(gradient, len(particle) + more),
        particle_area=np.concatenate([area, np.zeros(more)]),
        weight=np.concatenate([weight, np.zeros((more, 2))]),
        load=np.concatenate([whole.load[particle], np.zeros((more, 2))]),
        held=np.concatenate([whole.held[particle], np.zeros((more, 2), dtype=bool)]),
        links=links,
    )
    return Standing(model, particle, point)


def internal_forces(model: Model, stress: Floats) -> Floats:
    """What the stresses (s, >= 3) ask of every particle: sum of sigma g over its stress points (n, 2) [N/m]."""
    start, index, vector = model.particle_gradient
    row = np.repeat(np.arange(model.particles), np.diff(start))
    xx, yy, xy = stress[index, 0], stress[index, 1], stress[index, 2]
    along = xx * vector[:, 0] + xy * vector[:, 1], xy * vector[:, 0] + yy * vector[:, 1]
    return np.stack([np.bincount(row, part, minlength=model.particles) for part in along], axis=1)


def strength(model: Model, stress: Floats) -> tuple[Floats, Floats]:
    """Radius of every stress point's circle and the radius that its strength allows (s,), (s,) [Pa]."""
    law = GROUND_LAWS[model.law]
    mean = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    allowed = np.empty(len(stress))
    for number, parameters in enumerate(model.parameters):
        own = model.point_material == number
        allowed[own] = law.radius_allowed(parameters, mean[own])
    return radius, allowed
