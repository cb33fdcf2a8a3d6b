"""What joints cut: pairs of particles whose line of centres crosses a face, and who lies on which side.

Every pair stands for the part of the face that is nearest to where it crosses it, so that the pairs of a joint have the
joint's area together, whatever the packing: cohesion and stiffness of the whole are those that were given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Joints
from geodem.builders.joints import Joint, distance_to

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

FINE = {2: 20.0, 3: 5.0}
"""Points on a face per smallest radius, along each direction, by which areas are told."""

LEAST_AREA = 1e-6
"""Of a pair over the square of its smaller radius (2D: over the radius): where hardly any of a face is left for it."""

MOST_POINTS = 4_000_000
"""Points on one face: a larger face gets coarser ones."""


@dataclass(frozen=True, eq=False)
class Cut:
    """Pairs of particles that joints cross.

    Attributes
    ----------
    pairs : (c, 2) int64
        Lower number first.
    joint : (c,) int64
        Which joint crosses each.
    face : (c,) int64
        Which face, counted through all joints.
    upward : (c,) bool
        The first particle is on its lower side.
    normals : (c, d)
        Unit normal of the joint, from the first particle to the second.
    places : (c, d) [m]
        Where the line of centres crosses it.
    areas : (c,) [m2] (2D: [m])
        0 where the pair bears nothing.
    """

    pairs: Integers
    joint: Integers
    face: Integers
    upward: NDArray[np.bool_]
    normals: Floats
    places: Floats
    areas: Floats


class _Crossed(NamedTuple):
    pair: Integers
    face: Integers
    share: Floats
    upward: NDArray[np.bool_]


def find_cut(
    positions: Floats,
    radii: Floats,
    pairs: Integers,
    joints: Sequence[Joint],
    bounds: Floats,
    idle: NDArray[np.bool_] | None = None,
    *,
    whole: bool = False,
) -> Cut:
    """Pairs that joints cross; of several joints across one pair, the one nearest to its middle.

    Parameters
    ----------
    positions, radii : (n, d), (n,) [m]
    pairs : (p, 2) int
        Neighbours: bonded, or as near as touching.
    joints : sequence of Joint
    bounds : (2, d) [m]
        Of the body: faces count within them.
    idle : (n,) bool, optional
        Particles that bear nothing of a joint: their pairs have no area.
    whole : bool
        Faces count wherever they are in the bounds, however far from a pair that is crossed.
    """
    d = positions.shape[1]
    count = len(pairs)
    best = np.full(count, math.inf)
    owner = np.full(count, -1, dtype=np.int64)
    face = np.zeros(count, dtype=np.int64)
    share = np.zeros(count)
    upward = np.zeros(count, dtype=bool)
    first_face = 0
    for number, joint in enumerate(joints):
        found = _crossed(positions, pairs, joint)
        nearer = np.abs(found.share - 0.5) < best[found.pair]
        at = found.pair[nearer]
        best[at] = np.abs(found.share[nearer] - 0.5)
        owner[at], face[at] = number, first_face + found.face[nearer]
        share[at], upward[at] = found.share[nearer], found.upward[nearer]
        first_face += joint.faces
    which = np.flatnonzero(owner >= 0)
    ends = np.sort(pairs[which], axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    which, ends = which[order], ends[order]
    one, other = positions[pairs[which, 0]], positions[pairs[which, 1]]
    places = one + share[which, None] * (other - one)
    normals = np.concatenate([joint.normals for joint in joints])[face[which]]
    swapped = pairs[which, 0] != ends[:, 0]
    below = upward[which] != swapped
    sign = np.where(below, 1.0, -1.0)
    areas = np.zeros(len(which))
    bears = np.ones(len(which), dtype=bool) if idle is None else ~idle[ends].any(axis=1)
    for number, joint in enumerate(joints):
        own = np.flatnonzero((owner[which] == number) & bears)
        reach = np.full(len(own), math.inf) if whole else radii[ends[own]].sum(axis=1)
        share_of = face_shares(joint, places[own], reach, float(radii.min()), bounds)
        areas[own] = np.maximum(share_of, LEAST_AREA * radii[ends[own]].min(axis=1) ** (d - 1))
    return Cut(ends, owner[which], face[which], below, sign[:, None] * normals.reshape(-1, d), places, areas)


def put_aside(
    positions: Floats, radii: Floats, bonds: Integers, cut: Cut, joints: Sequence[Joint]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Places (n, d) [m] by which particles belong to sides, and which of them (n,) bear nothing of a joint.

    Up to d particles that are bonded to nothing but each other and across a joint lie beyond it; a particle with less
    than d bonds on its own side, and more across, is a loose grain at the surface that would roll between both sides.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n, d = positions.shape
    crossed = np.isin(bonds.min(axis=1) * n + bonds.max(axis=1), cut.pairs[:, 0] * n + cut.pairs[:, 1])
    across = np.bincount(bonds[crossed].ravel(), minlength=n)
    own = np.bincount(bonds[~crossed].ravel(), minlength=n)
    kept = bonds[~crossed]
    parts, part = connected_components(
        coo_matrix((np.ones(len(kept)), (kept[:, 0], kept[:, 1])), shape=(n, n)), directed=False
    )
    few = (np.bincount(part, minlength=parts) <= d)[part]
    hanging = few & (np.bincount(part, across, parts) > 0)[part]
    loose = ~hanging & (own < d) & (across > own)
    placed = positions.copy()
    for particle in np.flatnonzero(hanging & (across > 0)):
        number = int(cut.joint[np.flatnonzero((cut.pairs == particle).any(axis=1))[0]])
        joint = joints[number]
        face = distance_to(joint, positions[particle][None])[1][0]
        height = float((positions[particle] - joint.centres[face]) @ joint.normals[face])
        beyond = math.copysign(1e-3 * float(radii[particle]), height if height != 0.0 else 1.0)
        placed[particle] -= (height + beyond) * joint.normals[face]
    return placed, loose


def face_shares(joint: Joint, places: Floats, reach: Floats, smallest: float, bounds: Floats) -> Floats:
    """Area (k,) [m2] (2D: [m]) of a joint that is nearest to each of the places (k, d) where it is crossed.

    What is farther than `reach` (k,) [m] from every place, or out of bounds (2, d), belongs to none.
    """
    from scipy.spatial import cKDTree

    areas = np.zeros(len(places))
    if not len(places):
        return areas
    tree = cKDTree(places)
    for centre, normal, radius in zip(joint.centres, joint.normals, joint.radii, strict=True):
        points, size = _points(centre, normal, float(radius), smallest)
        inside = ((points >= bounds[0]) & (points <= bounds[1])).all(axis=1)
        found = tree.query(points[inside])
        distance, nearest = np.asarray(found[0]), np.asarray(found[1])
        near = distance <= reach[nearest]
        areas += size * np.bincount(nearest[near], minlength=len(places))
    return areas


def _points(centre: Floats, normal: Floats, radius: float, smallest: float) -> tuple[Floats, float]:
    """Points (k, d) spread evenly over a face, and the area that each stands for."""
    d = len(centre)
    most = MOST_POINTS if d == 2 else math.isqrt(MOST_POINTS)
    count = min(max(8, math.ceil(2.0 * radius * FINE[d] / smallest)), most)
    line = radius * ((2.0 * np.arange(count) + 1.0) / count - 1.0)
    step = 2.0 * radius / count
    if d == 2:
        return centre + line[:, None] * np.array([normal[1], -normal[0]]), step
    aside = np.eye(3)[int(np.argmin(np.abs(normal)))]
    one = np.cross(normal, aside)
    one /= np.linalg.norm(one)
    other = np.cross(normal, one)
    u, v = (part.ravel() for part in np.meshgrid(line, line, indexing="ij"))
    round_ = u * u + v * v <= radius * radius
    points = centre + u[round_, None] * one + v[round_, None] * other
    # exactly the disc's area in all
    return points, math.pi * radius * radius / len(points)


def _crossed(positions: Floats, pairs: Integers, joint: Joint) -> _Crossed:
    """Pairs whose line of centres crosses a joint an odd number of times, and where."""
    one, other = positions[pairs[:, 0]], positions[pairs[:, 1]]
    times = np.zeros(len(pairs), dtype=np.int64)
    best = np.full(len(pairs), math.inf)
    face = np.zeros(len(pairs), dtype=np.int64)
    share = np.zeros(len(pairs))
    upward = np.zeros(len(pairs), dtype=bool)
    for number, (centre, normal, radius) in enumerate(
        zip(joint.centres, joint.normals, joint.radii, strict=True)
    ):
        low, high = (one - centre) @ normal, (other - centre) @ normal
        # a centre on the face counts as above it
        unlike = np.flatnonzero((low < 0.0) != (high < 0.0))
        part = low[unlike] / (low[unlike] - high[unlike])
        place = one[unlike] + part[:, None] * (other[unlike] - one[unlike]) - centre
        met = np.sqrt((place**2).sum(axis=1)) <= radius
        at, part = unlike[met], part[met]
        times[at] += 1
        nearer = np.abs(part - 0.5) < best[at]
        at, part = at[nearer], part[nearer]
        best[at] = np.abs(part - 0.5)
        face[at], share[at], upward[at] = number, part, low[at] < 0.0
    which = np.flatnonzero(times % 2 == 1)
    return _Crossed(which, face[which], share[which], upward[which])


def cut_joints(
    cut: Cut, joints: Sequence[Joint], names: Sequence[str], positions: Floats, radii: Floats, reach: float
) -> Joints:
    """What an assembly keeps of what is cut; `with_links` adds laws and parameters.

    Parameters
    ----------
    cut : Cut
    joints : sequence of Joint
    names : sequence of str
        Of the materials of joints.
    positions : (n, d) [m]
        By which particles belong to sides, see `put_aside`.
    reach : float
        See `geodem.assembly.Joints`.
    """
    d = positions.shape[1]
    size = radii[cut.pairs].min(axis=1) ** (d - 1)
    per_size = np.ones(sum(joint.faces for joint in joints))
    sides: list[tuple[Integers, Integers, Integers]] = []
    first = 0
    for number, joint in enumerate(joints):
        own = cut.joint == number
        if size[own].sum() > 0.0:
            per_size[first : first + joint.faces] = cut.areas[own].sum() / size[own].sum()
        particle, face = _sides(joint, positions, radii, reach)
        side = np.where(face > 0, face + first, face - first)
        sides.append((particle, np.full(len(particle), number, dtype=np.int64), side))
        first += joint.faces
    particle, of_joint, side = (np.concatenate(part) for part in zip(*sides, strict=True))
    rows = [names.index(joint.material) for joint in joints for _ in range(joint.faces)]
    return replace(
        _no_joints(d),
        normal=np.concatenate([joint.normals for joint in joints]),
        material=np.array(rows, dtype=np.int32),
        per_size=per_size,
        reach=float(reach),
        pairs=cut.pairs.astype(np.int32),
        face=np.where(cut.upward, cut.face + 1, -cut.face - 1).astype(np.int32),
        area=cut.areas.copy(),
        side_particle=particle.astype(np.int32),
        side_joint=of_joint.astype(np.int32),
        side_face=side.astype(np.int32),
    )


def with_links(
    cut: Joints | None,
    links: Sequence[tuple[Integers, Floats, Floats, str]],
    materials: Mapping[str, tuple[str, Sequence[float]]],
    untouched: NDArray[np.int32],
    dimension: int,
) -> Joints:
    """Joints with links of bolts, and the table of laws and parameters.

    Parameters
    ----------
    cut : Joints or None
        By `cut_joints`.
    links : sequence of (pairs (k, 2), directions (k, d), shares (k,), material)
    materials : dict of str to (str, tuple)
        Law and parameters by name.
    untouched : (u,) int32
        See `geodem.assembly.Joints`.
    """
    found = cut or _no_joints(dimension)
    names = tuple(materials)
    laws = tuple(sorted({law for law, _ in materials.values()}))
    table = np.zeros((len(materials), 1 + max((len(values) for _, values in materials.values()), default=0)))
    for row, (law, values) in zip(table, materials.values(), strict=True):
        row[0] = laws.index(law)
        row[1 : 1 + len(values)] = values
    for pairs, directions, shares, material in links:
        count, first = len(pairs), len(found.normal)
        found = replace(
            found,
            normal=np.concatenate([found.normal, directions]),
            material=np.concatenate([found.material, np.full(count, names.index(material), dtype=np.int32)]),
            per_size=np.concatenate([found.per_size, np.ones(count)]),
            pairs=np.concatenate([found.pairs, pairs.astype(np.int32)]),
            face=np.concatenate([found.face, np.arange(first + 1, first + count + 1, dtype=np.int32)]),
            area=np.concatenate([found.area, shares]),
        )
    return replace(found, laws=laws, names=names, table=table, untouched=untouched)


def _no_joints(dimension: int) -> Joints:
    whole, number = np.empty(0), np.empty(0, dtype=np.int32)
    return Joints(
        (), (), np.empty((0, 1)), np.empty((0, dimension)), number, whole, 1.0, np.empty((0, 2), dtype=np.int32),
        number, whole, number, number, number, number,
    )  # fmt: skip


def _sides(joint: Joint, positions: Floats, radii: Floats, reach: float) -> tuple[Integers, Integers]:
    """Particles near enough to a joint to meet one beyond it, and 1 + the nearest face, negative below it.

    What lies beyond its ends is on neither side.
    """
    gap, nearest = distance_to(joint, positions)
    near = np.flatnonzero(gap <= reach * (radii + float(radii.max())))
    face = nearest[near]
    away = positions[near] - joint.centres[face]
    height = (away * joint.normals[face]).sum(axis=1)
    aside = np.sqrt(np.maximum((away**2).sum(axis=1) - height**2, 0.0))
    within = aside <= joint.radii[face]
    if joint.dimension == 2 and joint.faces > 1:
        # at a kink a particle may lie beyond the ends of both lines
        along = away[:, 0] * joint.normals[face, 1] - away[:, 1] * joint.normals[face, 0]
        inner = ((along < 0.0) & (face > 0)) | ((along > 0.0) & (face < joint.faces - 1))
        within |= inner
    near, face, height = near[within], face[within], height[within]
    return near, np.where(height < 0.0, -(face + 1), face + 1)
