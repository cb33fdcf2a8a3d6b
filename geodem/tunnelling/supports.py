"""Linings, bolts and the ground beyond the section as links (see `geodem.model.Links`).

A lining is a chain of bars between the particles of a wall: each resists lengthening with E' t over its length, and
each joint between two resists turning with E' t^3 / 12 over the length that it stands for, E' = E / (1 - nu^2) (H.
Hencky 1920, Der Eisenbau 11:437). Its axis is the wall itself. A bolt is a chain of bars between nodes of its own that
hold to the ground around them through grout. Forces are per metre of tunnel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..laws import GROUND_LAWS
from ..model import Model
from .ground import TunnelGround
from .plan import Bolts, Lining

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

BOLT_PIECES_PER_SPACING = 1.0
"""Pieces of a bolt per spacing of the particles on the wall."""
CROSS = 1.0
"""Stiffness of a bolt across its axis over that of its grout along it."""
HEAD = 100.0
"""Stiffness of a head plate over that of the bolt's first piece."""


class LinkRow(NamedTuple):
    """One link: particles of the whole ground (nodes of bolts counted on behind them), vectors, table row."""

    particles: tuple[int, ...]
    vectors: Floats  # (m, 2)
    stiffness: float
    lower: float = -math.inf
    upper: float = math.inf


@dataclass
class Built:
    """A support that stands: its links, and what is to be read from them.

    Attributes
    ----------
    name : str
    kind : "lining", "bolts" or "far"
    rows : list of LinkRow
    reading : dict of str to (k,) int
        Places in `rows` by what they measure: "axial", "bending", "bar", "grout".
    nodes : (b, 2) [m]
        Nodes of its own.
    at : dict of str to (k, 2) [m]
        Where the readings stand.
    chain : (k,) int
        Particles along a lining.
    """

    name: str
    kind: str
    rows: list[LinkRow]
    reading: dict[str, Integers]
    at: dict[str, Floats]
    nodes: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    chain: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def build_lining(ground: TunnelGround, lining: Lining, wall: Integers) -> Built:
    """Links of a lining on wall edges (k, 2) in order; an end on a held side cannot turn."""
    positions = ground.model.positions
    if len(wall) < 3:
        raise InputError(f"lining {lining.name!r}", "it finds no wall", "Install it after its excavation.")
    closed = bool(wall[0, 0] == wall[-1, 1])
    chain = np.concatenate([wall[:, 0], wall[-1:, 1]])
    along = positions[chain[1:]] - positions[chain[:-1]]
    length = np.hypot(*along.T)
    tangent = along / length[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    rows = [
        LinkRow((int(a), int(b)), np.stack([-t, t]), lining.axial_stiffness / float(size))
        for (a, b), t, size in zip(wall, tangent, length, strict=True)
    ]
    at_axial = 0.5 * (positions[wall[:, 0]] + positions[wall[:, 1]])
    joints: list[LinkRow] = []
    at_joint: list[Floats] = []
    pieces = len(wall)
    for right in range(pieces if closed else pieces + 1):
        left = right - 1
        if closed or 0 < right < pieces:
            stands_for = 0.5 * float(length[left] + length[right % pieces])
            joints.append(_joint(wall, normal, length, left % pieces, right % pieces, lining, stands_for))
            at_joint.append(positions[wall[right % pieces, 0]])
        else:
            # the end of an arch: on a line of symmetry it cannot turn, elsewhere it is a hinge
            end = int(wall[0, 0]) if right == 0 else int(wall[-1, 1])
            if ground.model.held[end].any():
                piece = 0 if right == 0 else pieces - 1
                joints.append(_end(wall, normal, length, piece, lining))
                at_joint.append(positions[end])
    axial, bending = np.arange(pieces), np.arange(pieces, pieces + len(joints))
    return Built(
        lining.name, "lining", [*rows, *joints], {"axial": axial, "bending": bending},
        {"axial": at_axial, "bending": np.array(at_joint).reshape(-1, 2)}, chain=chain,
    )  # fmt: skip


def _joint(
    wall: Integers, normal: Floats, length: Floats, left: int, right: int, lining: Lining, stands_for: float
) -> LinkRow:
    """Turning of the piece on the right against that on the left."""
    before, after = normal[left] / length[left], normal[right] / length[right]
    particles = (int(wall[left, 0]), int(wall[right, 0]), int(wall[right, 1]))
    vectors = np.stack([before, -before - after, after])
    return LinkRow(particles, vectors, lining.bending_stiffness / stands_for)


def _end(wall: Integers, normal: Floats, length: Floats, piece: int, lining: Lining) -> LinkRow:
    """Turning of an end piece against a line of symmetry, over half its length."""
    turn = normal[piece] / length[piece]
    sign = 1.0 if piece == 0 else -1.0
    particles = (int(wall[piece, 0]), int(wall[piece, 1]))
    return LinkRow(
        particles, sign * np.stack([-turn, turn]), lining.bending_stiffness / (0.5 * float(length[piece]))
    )


def build_bolts(
    ground: TunnelGround, bolts: Bolts, dug: Sequence[int], first_node: int, piece: float
) -> Built:
    """Links of bolts in the standing ground.

    Parameters
    ----------
    ground : TunnelGround
    bolts : Bolts
    dug : sequence of int
        Openings that are out.
    first_node : int
        Number of the first node of its own.
    piece : float [m]
        Length of a piece.

    Raises
    ------
    InputError
        A bolt that leaves the ground.
    """
    rows: list[LinkRow] = []
    kinds: list[str] = []
    at: list[Floats] = []
    nodes: list[Floats] = []
    for number, (start, end) in enumerate(bolts.bars):
        head, tip = np.asarray(start), np.asarray(end)
        length = float(np.hypot(*(tip - head)))
        axis = (tip - head) / length
        pieces = 1 if bolts.anchored else max(3, round(BOLT_PIECES_PER_SPACING * length / piece))
        places = head + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (tip - head)
        held = [_around(ground, dug, place, bolts.name, number, k == 0) for k, place in enumerate(places)]
        bar = bolts.young_modulus * bolts.area / (length / pieces) / bolts.spacing
        limit = bolts.yield_force / bolts.spacing
        if bolts.anchored:
            (p, w), (q, v) = held
            vectors = np.concatenate([-w[:, None] * axis, v[:, None] * axis])
            rows.append(LinkRow((*p, *q), vectors, bar, -limit, limit))
            kinds.append("bar")
            at.append(0.5 * (head + tip))
            continue
        own = first_node + len(nodes) + np.arange(pieces + 1)
        nodes += list(places)
        for k in range(pieces):
            rows.append(LinkRow((int(own[k]), int(own[k + 1])), np.stack([-axis, axis]), bar, -limit, limit))
            kinds.append("bar")
            at.append(0.5 * (places[k] + places[k + 1]))
        share = np.full(pieces + 1, length / pieces)
        share[[0, -1]] *= 0.5
        across = np.array([-axis[1], axis[0]])
        for k, (p, w) in enumerate(held):
            shear = bolts.grout_stiffness * share[k] / bolts.spacing
            slip = bolts.grout_strength * share[k] / bolts.spacing
            vectors = np.concatenate([axis[None], -w[:, None] * axis])
            # the head's plate holds without slip
            stiff, most = (shear + HEAD * bar, math.inf) if k == 0 else (shear, slip)
            rows.append(LinkRow((int(own[k]), *p), vectors, stiff, -most, most))
            kinds.append("grout")
            at.append(places[k])
            vectors = np.concatenate([across[None], -w[:, None] * across])
            rows.append(LinkRow((int(own[k]), *p), vectors, CROSS * shear))
            kinds.append("cross")
            at.append(places[k])
    named = np.array(kinds)
    where = np.array(at)
    reading = {kind: np.flatnonzero(named == kind) for kind in ("bar", "grout")}
    return Built(
        bolts.name, "bolts", rows, reading, {kind: where[places] for kind, places in reading.items()},
        nodes=np.array(nodes).reshape(-1, 2),
    )  # fmt: skip


def _around(
    ground: TunnelGround, dug: Sequence[int], place: Floats, name: str, number: int, head: bool
) -> tuple[tuple[int, ...], Floats]:
    """Corners of the standing triangle that holds a place, and their weights; a head is put on the nearest one."""
    model = ground.model
    standing = np.flatnonzero(ground.standing_triangles(dug))
    corner = model.positions[model.triangles[standing]]
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    v0, v1, v2 = b - a, c - a, place - a
    area = v0[:, 0] * v1[:, 1] - v0[:, 1] * v1[:, 0]
    second = (v2[:, 0] * v1[:, 1] - v2[:, 1] * v1[:, 0]) / area
    third = (v0[:, 0] * v2[:, 1] - v0[:, 1] * v2[:, 0]) / area
    weights = np.stack([1.0 - second - third, second, third], axis=1)
    outside = -weights.min(axis=1)
    best = int(np.argmin(outside))
    size = float(np.sqrt(area[best]))
    found = np.clip(weights[best], 0.0, 1.0)
    found /= found.sum()
    nearest = found @ corner[best]
    if outside[best] > 1e-9 and float(np.hypot(*(nearest - place))) > (2.0 if head else 1.0) * size:
        raise InputError(
            f"bolt {name!r}",
            f"bar {number} misses the ground at ({place[0]:.4g}, {place[1]:.4g}) m",
            "Let it begin on the wall and end in the ground; install it after the excavation.",
        )
    return tuple(int(k) for k in model.triangles[standing[best]]), found


def build_far(ground: TunnelGround, centre: Floats) -> Built:
    """Springs on the far sides: the ground beyond, as it answers to a radial displacement of the section.

    Around a hole the elastic displacement falls as u = C / r, with the radial stress -2 G C / r^2 beside the initial
    one: a surface at the distance r feels 2 G / r per area. Exact where the sides are a circle around the opening and
    the load on it is the same all round.
    """
    model, filled = ground.model, ground.particles
    rows: list[LinkRow] = []
    shear = _shear_modulus(model)
    positions, edges = filled.positions, filled.boundary_edges
    low, high = positions.min(axis=0), positions.max(axis=0)
    tolerance = 1e-6 * float((high - low).max())
    sides = {"left": (0, low[0]), "right": (0, high[0]), "bottom": (1, low[1]), "top": (1, high[1])}
    stiffness: dict[int, float] = {}
    for side in ground.far_sides:
        axis, extreme = sides[side]
        on = np.abs(positions[:, axis] - extreme) <= tolerance
        for a, b in edges[on[edges].all(axis=1)].tolist():
            along = positions[b] - positions[a]
            outwards = np.array([along[1], -along[0]])
            for particle in (a, b):
                radius = positions[particle] - centre
                distance = float(np.hypot(*radius))
                facing = 0.5 * float(outwards @ radius) / distance
                stiffness[particle] = stiffness.get(particle, 0.0) + 2.0 * shear[particle] / distance * facing
    for particle, value in sorted(stiffness.items()):
        for direction in ((1.0, 0.0), (0.0, 1.0)):
            rows.append(LinkRow((particle,), np.array([direction]), value))
    return Built(FAR_NAME, "far", rows, {}, {})


FAR_NAME = "far ground"


def _shear_modulus(model: Model) -> Floats:
    law = GROUND_LAWS[model.law]
    moduli = np.array([law.elastic_moduli(p)[1] for p in model.parameters])[model.point_material]
    return model.particle_mean(moduli[:, None])[:, 0]
