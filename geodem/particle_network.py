"""The links of a particle simulation as they are now: for the critical step, the elastic solve, the scaled masses."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .integrators.link_stiffness import law_stiffness
from .integrators.network import (
    RIGID,
    Links,
    Springs,
    anchor_springs,
    joined,
    links,
)
from .laws.protocol import argument_names
from .particle_joints import joint_values, law_values, open_joints

if TYPE_CHECKING:
    from .particle_cell import ParticleCell
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

LEAST_OVERLAP = 2e-3
"""Over the radius: contacts count at least as stiff as with this overlap where a cell's servo must not overshoot."""

MOST_PARTS = 100
"""Loose parts that are looked at: one that falls is enough to know that there is no equilibrium."""


def current_links(simulation: ParticleSimulation, *, walls_only: bool = False) -> Links:
    """Links of all pairs that are listed, as if those within the buffer touched, and of all listed wall pairs.

    Particles are numbered by row.
    """
    wall = _wall_links(simulation)
    return wall if walls_only else joined(_pair_links(simulation), wall)


def current_springs(simulation: ParticleSimulation) -> Springs | None:
    """Springs of the anchors where the particles are now, by row; None where there are none."""
    s = simulation
    anchors = s.assembly.anchors
    if anchors is None:
        return None
    by_row = np.empty(s.assembly.particles, dtype=np.int32)
    by_row[s.arrays.ids] = np.arange(len(by_row))
    positions = np.ascontiguousarray(s.now[:, s.columns.position])
    return anchor_springs(positions, replace(anchors, particle=by_row[anchors.particle]))


def touching_links(simulation: ParticleSimulation) -> Links:
    """Links of intact bonds and of contacts that touch, by row."""
    pairs = _pair_links(simulation, listed=False)
    wall = _wall_links(simulation)
    touching = simulation.wall_pairs.touching > 0
    return joined(pairs, _chosen(wall, touching))


def falling_freely(simulation: ParticleSimulation) -> NDArray[np.int64]:
    """Particles of parts that nothing holds, with nothing in the way of their fall.

    Parts are what bonds and touching contacts join. A part is held where a particle of it is held or anchored, or
    touches a wall; its fall is along the sum of its loads, and in its way is whatever that is held lies ahead of it
    within its width. Bounded walls count as in the way wherever they are, and in a periodic cell everything does.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    s = simulation
    n, d = s.assembly.particles, s.dimension
    ids = s.arrays.ids
    links = touching_links(s)
    inner = links.second != RIGID
    ends = (links.first[inner], links.second[inner])
    parts, part = connected_components(
        coo_matrix((np.ones(len(ends[0])), ends), shape=(n, n)), directed=False
    )
    held = np.array(s.assembly.held[ids][:, :d].any(axis=1))
    held[links.first[~inner]] = True
    if s.assembly.anchors is not None:
        held |= np.isin(ids, s.assembly.anchors.particle)
    supported = np.bincount(part, held, parts) > 0
    if supported.all() or s.cell is not None or len(s.walls.kind) > np.count_nonzero(s.walls.kind == 0):
        return np.empty(0, dtype=np.int64)
    load = s.assembly.applied[ids, :d] + s.assembly.mass[ids, None] * s.assembly.gravity
    positions, radius = s.now[:, s.columns.position], s.now[:, s.columns.radius]
    planes = -s.walls.corners_now()[:, 1, :d] if len(s.walls.kind) else np.empty((0, d))
    found = []
    for number in np.flatnonzero(~supported)[:MOST_PARTS]:
        own = part == number
        pull = load[own].sum(axis=0)
        size = float(np.sqrt(pull @ pull))
        if size == 0.0 or (planes @ pull > 0.0).any():
            continue
        pull = pull / size
        along = positions @ pull
        aside = positions - along[:, None] * pull
        low = (aside[own] - radius[own, None]).min(axis=0)
        high = (aside[own] + radius[own, None]).max(axis=0)
        ahead = ~own & (along > along[own].min())
        meets = ((aside + radius[:, None] >= low) & (aside - radius[:, None] <= high)).all(axis=1)
        if not (ahead & meets & supported[part]).any():
            found.append(ids[own])
    return np.concatenate([np.empty(0, dtype=np.int64), *found])


def contact_modulus(s: ParticleSimulation) -> float:
    """Sum of kn d^2 over all listed pairs and the volume of the cell [Pa]: no part of its stiffness is more.

    At least that of one contact a particle.
    """
    assert s.cell is not None
    found = _pair_links(s, least=LEAST_OVERLAP)
    contact, _ = s.features.laws()
    radius = s.now[:, s.columns.radius]
    r = np.array([float(radius.max())])
    m = np.array([float(s.now[:, s.columns.mass].max())])
    single = max(
        law_stiffness(
            contact, s.dimension, row[None], radius_a=r, radius_b=r, distance=2 * r, overlap=LEAST_OVERLAP * r,
            mass_a=m, mass_b=m,
        )[0, 0]
        for row in s.table
    )  # fmt: skip
    alone = float(single * (4.0 * radius**2).sum())
    return max(float((found.kn * found.arms.sum(axis=1) ** 2).sum()), alone) / s.cell.volume


def _pair_links(s: ParticleSimulation, *, listed: bool = True, least: float = 0.0) -> Links:
    p, columns = s.pairs, s.columns
    chosen: slice | NDArray[np.intp] = (
        slice(None) if listed else np.flatnonzero((p.bond > 0) | (p.touching > 0) & ~open_joints(s))
    )
    first, second = p.a[chosen].astype(np.int64), p.b[chosen].astype(np.int64)
    bonded = p.bond[chosen] > 0
    now = s.now
    # columns first, rows then: a whole row of every end would not fit beside a large list
    positions = np.ascontiguousarray(now[:, columns.position])
    apart = positions[second]
    apart -= positions[first]
    if s.cell is not None:
        apart += s.cell.shifts(p.image[chosen])
    distance = np.sqrt(np.einsum("ij,ij->i", apart, apart))
    radii = np.ascontiguousarray(now[:, columns.radius])
    radius_a, radius_b = radii[first], radii[second]
    contact, bond = s.features.laws()
    sizes = {"radius_a": radius_a, "radius_b": radius_b, "distance": distance}
    if any(_asks_for_masses(law) for law in (contact, bond) if law is not None):
        mass = np.ascontiguousarray(now[:, columns.mass])
        sizes |= {"mass_a": mass[first], "mass_b": mass[second]}
    overlap = radius_a + radius_b - distance
    materials = len(s.assembly.material_names)
    material = now[:, columns.material].astype(np.int64)

    def parameters(table: Floats, which: NDArray[np.bool_] | slice) -> Floats:
        # one material, one row
        return table[material[first[which]] * materials + material[second[which]]] if materials > 1 else table

    def stiffness_of(
        law: ModuleType, table: Floats, which: NDArray[np.bool_] | slice, given: Floats
    ) -> Floats:
        given_sizes = {name: value[which] for name, value in sizes.items()}
        return law_stiffness(law, s.dimension, parameters(table, which), overlap=given[which], **given_sizes)

    pressed = np.maximum(overlap, least * np.minimum(radius_a, radius_b))
    if bond is not None and bond.REPLACES_CONTACT:
        stiffness = np.zeros((len(first), 4))
        stiffness[~bonded] = stiffness_of(contact, s.table, ~bonded, pressed)
    else:
        stiffness = stiffness_of(contact, s.table, slice(None), pressed)
    if not s.features.shear:
        stiffness[:, 1] = 0.0
    if bond is not None and bonded.any():
        stiffness[bonded] += stiffness_of(bond, s.bond_table, bonded, np.zeros(len(first)))
    apart /= distance[:, None]
    if s.layout.place is not None:
        across = _along_joints(s, np.arange(len(p.a))[chosen], distance, apart, stiffness)
        # a joint's force acts half-way
        radius_a, radius_b = np.where(across, 0.0, radius_a), np.where(across, 0.0, radius_b)
    half = 0.5 * (distance + radius_a - radius_b)
    arms = np.stack([half, distance - half], axis=1)
    del overlap, pressed, half
    return links(first, second, apart, arms, *stiffness.T)


def _along_joints(
    s: ParticleSimulation, listed: NDArray[np.intp], distance: Floats, normal: Floats, stiffness: Floats
) -> NDArray[np.bool_]:
    """Put what joints make of their pairs in place: distance and normal are theirs, and so is the stiffness.

    Returns which pairs lie across joints.
    """
    kind = s.pairs.history[listed, s.layout.place]
    across = np.flatnonzero(kind != 0.0)
    known = joint_values(s, listed[across])
    distance[across], normal[across] = known["distance"], known["normal"]
    stiffness[across] = 0.0
    acts = kind[across] > 0.0
    for number, law in enumerate(s.features.joints()):
        own = np.flatnonzero(acts & (known["law"] == number))
        parameters, _ = law_values(s, law, listed[across[own]])
        given = dict(zip(law.PARAMETERS._fields, parameters.T, strict=True)) | {"area": known["area"][own]}
        values = law.stiffness(**{name: given[name] for name in argument_names(law.stiffness)})
        for k, value in enumerate(values):
            stiffness[across[own], k] = value
    return kind != 0.0


def _asks_for_masses(law: ModuleType) -> bool:
    return bool({"mass_a", "mass_b"} & set(argument_names(law.stiffness)))


def _chosen(found: Links, which: NDArray[np.bool_]) -> Links:
    fields: list[Any] = [field[which] for field in found]
    return Links(*fields)


def _wall_links(s: ParticleSimulation) -> Links:
    w, columns = s.wall_pairs, s.columns
    d = s.dimension
    particle = w.particle.astype(np.int64)
    if not len(particle):
        return links(np.zeros(0, int), RIGID, np.zeros((0, d)), np.zeros((0, 2)), np.zeros(0))
    radius, mass = s.now[particle, columns.radius], s.now[particle, columns.mass]
    material = s.now[particle, columns.material].astype(np.int64)
    row = material * len(s.walls.bodies) + s.walls.body[w.primitive]
    contact, _ = s.features.laws()
    stiffness = law_stiffness(
        contact, d, s.wall_parameters[row], radius_a=radius, radius_b=1e15 * radius, distance=radius,
        overlap=np.zeros(len(radius)), mass_a=mass, mass_b=1e15 * mass,
    )  # fmt: skip
    if not s.features.shear:
        stiffness[:, 1] = 0.0
    normal = wall_normals(s, particle, w.primitive)
    return links(particle, RIGID, normal, np.stack([radius, 0.0 * radius], axis=1), *stiffness.T)


def wall_normals(s: ParticleSimulation, particle: NDArray[np.int64], primitive: NDArray[np.uint32]) -> Floats:
    """Normals (w, d) from the particles to their primitives."""
    corners = s.walls.corners_now()[primitive]
    kind = s.walls.kind[primitive]
    d = s.dimension
    centre = np.zeros((len(particle), 3))
    centre[:, :d] = s.now[particle][:, s.columns.position]
    normal = np.empty((len(particle), 3))
    flat = kind == 0
    normal[flat] = -corners[flat, 1]
    for which, k in ((kind == 1, 2), (kind == 2, 3)):
        if which.any():
            normal[which] = closest_point(centre[which], corners[which][:, :k]) - centre[which]
    size = np.sqrt((normal**2).sum(axis=1))
    size[size == 0.0] = 1.0
    return np.ascontiguousarray((normal / size[:, None])[:, :d])


def wall_branches(s: ParticleCell, which: NDArray[np.int64]) -> Floats:
    """Ways (k, d) [m] from the centres to where the pairs of the list of wall pairs touch."""
    w, d = s.wall_pairs, s.dimension
    particle, primitive = w.particle[which].astype(np.int64), w.primitive[which]
    corners, kind = s.walls.corners_now()[primitive], s.walls.kind[primitive]
    centre = np.zeros((len(particle), 3))
    centre[:, :d] = s.now[particle][:, s.columns.position]
    ways = np.empty((len(particle), 3))
    flat = kind == 0
    normal = corners[flat, 1]
    ways[flat] = -((centre[flat] - corners[flat, 0]) * normal).sum(axis=1)[:, None] * normal
    for chosen, k in ((kind == 1, 2), (kind == 2, 3)):
        if chosen.any():
            ways[chosen] = closest_point(centre[chosen], corners[chosen][:, :k]) - centre[chosen]
    return np.ascontiguousarray(ways[:, :d])


def closest_point(points: Floats, corners: Floats) -> Floats:
    """Points (w, 3) of segments (w, 2, 3) or triangles (w, 3, 3) that are closest to the points (w, 3)."""
    edges = [(0, 1)] if corners.shape[1] == 2 else [(0, 1), (1, 2), (2, 0)]
    best = corners[:, 0].copy()
    nearest = np.full(len(points), np.inf)
    for i, j in edges:
        along = corners[:, j] - corners[:, i]
        share = np.clip(((points - corners[:, i]) * along).sum(1) / (along**2).sum(1), 0.0, 1.0)
        spot = corners[:, i] + share[:, None] * along
        gap = ((points - spot) ** 2).sum(1)
        best[gap < nearest] = spot[gap < nearest]
        nearest = np.minimum(gap, nearest)
    if corners.shape[1] == 3:
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        normal = np.cross(u, v)
        normal /= np.sqrt((normal**2).sum(1))[:, None]
        spot = points - ((points - corners[:, 0]) * normal).sum(1)[:, None] * normal
        inside = np.ones(len(points), dtype=bool)
        for i, j in edges:
            inward = np.cross(normal, corners[:, j] - corners[:, i])
            inside &= ((spot - corners[:, i]) * inward).sum(1) >= 0.0
        best[inside] = spot[inside]
    return best
