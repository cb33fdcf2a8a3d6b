"""From particles, materials, supports and loads to a model of ground that yields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, InputErrors
from ..laws import GROUND_LAWS
from ..model import Model, build_model
from .particles import Particles

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

STANDARD_GRAVITY = 9.81
"""Acceleration of gravity [m/s2]; the value geotechnical codes turn unit weights into densities with."""

LOAD_EDGE_SECTORS = (4, 3, 2)
"""Stress points around a particle at the edge of a load, each of its neighbours, and each of theirs."""

SIDES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}
"""Side of the section: its axis, and whether it is the lowest or the highest coordinate."""


@dataclass(frozen=True)
class GroundProperties:
    """What the ground needs of a material.

    Attributes
    ----------
    density : float [kg/m3]
    law : str
        Name in `geodem.laws.GROUND_LAWS`.
    parameters : tuple
        The law's parameters.
    """

    density: float
    law: str
    parameters: Any

    @classmethod
    def of(cls, density: float, law: str = "mohr_coulomb", **constants: float) -> GroundProperties:
        """From the engineer's constants, those that the law's own `parameters` takes.

        ``GroundProperties.of(2000.0, cohesion=10e3, friction_angle=0.35, ...)``: [kg/m3], [Pa], [rad].
        """
        return cls(density, law, GROUND_LAWS[law].parameters(**constants))


@dataclass(frozen=True)
class Surcharge:
    """Pressure on the surface of the ground, normal to it.

    Attributes
    ----------
    start, end : (x, y) [m]
        Both on the surface; the load covers the surface between them.
    pressure : float [Pa]
    """

    start: tuple[float, float]
    end: tuple[float, float]
    pressure: float


def build_ground(
    particles: Particles,
    materials: Mapping[str, GroundProperties],
    *,
    boundary: Mapping[str, str],
    horizontal_acceleration: float = 0.0,
    surcharges: Sequence[Surcharge] = (),
    gravity: float = STANDARD_GRAVITY,
) -> Model:
    """Make a model.

    Parameters
    ----------
    particles : Particles
    materials : mapping
        Of every material name of the particles.
    boundary : mapping
        Side ("left", "right", "bottom", "top") to "free", "roller" or "fixed"; free where nothing is said. A side is
        the straight part of the outline at the section's extreme coordinate.
    horizontal_acceleration : float [m/s2]
        Pseudo-static body force, positive towards the lower side of the slope.
    surcharges : sequence of Surcharge
    gravity : float [m/s2]

    Raises
    ------
    InputError
        A side that is not straight, ground that is not held, a surcharge that is not on the surface.
    """
    positions, triangles = particles.positions, particles.triangles
    held = held_freedoms(particles, boundary)
    _require_held(particles, held)
    load = np.zeros_like(positions)
    split: list[tuple[int, int]] = []
    for number, surcharge in enumerate(surcharges):
        path = surface_between(particles, surcharge.start, surcharge.end, place=f"loads.surcharge[{number}]")
        _require_free(positions, path, held, place=f"loads.surcharge[{number}]")
        load += pressure_load(positions, path, surcharge.pressure)
        ends = {int(path[0, 0]), int(path[-1, 1])}
        for end in sorted(ends):
            split += around_load_edge(triangles, end)
    names = particles.materials
    laws = {materials[name].law for name in names}
    if len(laws) > 1:
        raise InputError(
            "material", f"one section with several laws {sorted(laws)}", "Use one law for all materials"
        )
    sideways = horizontal_acceleration * downhill(positions, particles.boundary_edges)
    return build_model(
        positions,
        triangles,
        particles.triangle_material,
        material_names=names,
        law=laws.pop(),
        parameters=[materials[name].parameters for name in names],
        densities=[materials[name].density for name in names],
        gravity=(sideways, -gravity),
        load=load,
        held=held,
        split=sorted(split),
    )


def around_load_edge(triangles: Integers, particle: int) -> list[tuple[int, int]]:
    """Particles near the edge of a load whose stress is split, and into how many sectors.

    Around the edge the principal stresses turn by a right angle, however near one looks, and one mean stress for
    all sides of a particle cannot follow: a mechanism of a few particles then fails below the bearing capacity of
    the strip, at any spacing. For a strip load at phi = 30 deg, 1,000 to 10,000 particles: 8 % below without a
    split, 3 to 6 % where the particle at the edge alone is split, 1 % with its neighbours, 0.5 % with theirs too.
    """
    split: dict[int, int] = {}
    front = np.array([particle])
    for sectors in LOAD_EDGE_SECTORS:
        split.update((int(k), sectors) for k in front if int(k) not in split)
        front = np.unique(triangles[np.isin(triangles, front).any(axis=1)])
    return sorted(split.items())


def held_freedoms(particles: Particles, boundary: Mapping[str, str]) -> NDArray[np.bool_]:
    """Freedoms held by the supports of the four sides, (n, 2) bool."""
    positions = particles.positions
    held = np.zeros((len(positions), 2), dtype=bool)
    low, high = positions.min(axis=0), positions.max(axis=0)
    tolerance = 1e-6 * float((high - low).max())
    errors = []
    for side, support in boundary.items():
        if support == "free":
            continue
        axis, end = SIDES[side]
        extreme = (low, high)[end][axis]
        on_side = np.abs(positions[:, axis] - extreme) <= tolerance
        edges = particles.boundary_edges
        nodes = np.unique(edges[on_side[edges].all(axis=1)])
        if len(nodes) == 0:
            direction = "vertical" if axis == 0 else "horizontal"
            errors.append(
                InputError(
                    f"boundary.{side}",
                    f"the section has no straight {direction} side at {'xy'[axis]} = {extreme:g} m to hold",
                    f"Draw the {side} end of the section {direction}, or leave it 'free'",
                    value=support,
                )
            )
            continue
        held[nodes, axis] = True
        if support == "fixed":
            held[nodes] = True
    if errors:
        raise InputErrors(errors)
    return held


def _require_held(particles: Particles, held: NDArray[np.bool_]) -> None:
    """Every connected part must be held in both directions and against rotation."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components

    triangles, count = particles.triangles, len(particles.positions)
    a, b = triangles.ravel(), np.roll(triangles, 1, axis=1).ravel()
    parts, label = connected_components(
        csr_matrix((np.ones(len(a)), (a, b)), shape=(count, count)), directed=False
    )
    for part in range(parts):
        inside = label == part
        x, y = held[inside].sum(axis=0)
        where = particles.positions[inside].mean(axis=0)
        place = f"the part of the ground around ({where[0]:.4g}, {where[1]:.4g}) m"
        if x + y == 0:
            raise InputError(
                "section",
                f"{place} floats: no support holds it",
                "Join it to the rest, remove it, or support it",
            )
        if x == 0 or y == 0 or x + y < 3:
            missing = "horizontally" if x == 0 else "vertically" if y == 0 else "against rotation"
            raise InputError(
                "boundary",
                f"{place} is not held {missing}",
                "Use for instance bottom = 'fixed', left = 'roller', right = 'roller'",
            )


def downhill(positions: Floats, boundary_edges: Integers) -> float:
    """+1 where the surface falls towards +x, -1 where it falls towards -x: the mean fall of its upper edges."""
    start, end = positions[boundary_edges[:, 0]], positions[boundary_edges[:, 1]]
    along = end - start
    upper = along[:, 0] < 0.0  # ground on the left: upper edges run towards -x
    rise = along[upper, 1].sum()
    return 1.0 if rise > 0.0 else -1.0


def surface_between(
    particles: Particles, start: Sequence[float], end: Sequence[float], *, place: str
) -> Integers:
    """Edges (k, 2) of the outline between two points on it, the shorter way, ordered with the ground on the left.

    Raises
    ------
    InputError
        A point is not on the outline, the two coincide, or lie on different outlines.
    """
    positions, edges = particles.positions, particles.boundary_edges
    nodes = np.unique(edges)
    ends = []
    for key, point in (("from", start), ("to", end)):
        distance = np.sqrt(((positions[nodes] - np.asarray(point)) ** 2).sum(axis=1))
        nearest = int(np.argmin(distance))
        if distance[nearest] > 0.5 * particles.spacing:
            found = positions[nodes[nearest]]
            raise InputError(
                f"{place}.{key}",
                f"the point is not on the surface of the ground; the nearest particle there is at "
                f"({found[0]:.4g}, {found[1]:.4g}) m",
                "Give a point on the outline of the section",
                value=[float(c) for c in point],
            )
        ends.append(int(nodes[nearest]))
    if ends[0] == ends[1]:
        raise InputError(place, "the load covers no length", "Give two points of the surface further apart")
    following: dict[int, list[int]] = {}
    for first, second in edges.tolist():
        following.setdefault(first, []).append(second)
    routes = [_route(following, ends[k], ends[1 - k]) for k in (0, 1)]
    found_routes = [np.array(route, dtype=np.int32) for route in routes if route]
    if not found_routes:
        raise InputError(place, "its two ends lie on different outlines", "Give two points of one surface")

    def length(route: Integers) -> float:
        return float(np.sqrt(((positions[route[:, 1]] - positions[route[:, 0]]) ** 2).sum(axis=1)).sum())

    return min(found_routes, key=length)


def _route(following: Mapping[int, list[int]], start: int, end: int) -> list[tuple[int, int]]:
    """Edges from `start` along the outline until `end`; empty where the outline closes before."""
    route: list[tuple[int, int]] = []
    node = start
    while True:
        options = following.get(node)
        if not options:
            return []
        route.append((node, options[0]))
        node = options[0]
        if node == end:
            return route
        if node == start or len(route) > len(following):
            return []


def _require_free(positions: Floats, edges: Integers, held: NDArray[np.bool_], *, place: str) -> None:
    """A load on a support goes into the support: it was meant for another place."""
    touched: NDArray[np.bool_] = np.asarray(held.any(axis=1))
    resting = touched[edges].all(axis=1)
    if resting.any():
        first, second = positions[edges[np.flatnonzero(resting)[0]]]
        raise InputError(
            place,
            f"it lies on a support between ({first[0]:.4g}, {first[1]:.4g}) and ({second[0]:.4g}, {second[1]:.4g}) m",
            "Put it on the free surface of the ground",
        )


def pressure_load(positions: Floats, edges: Integers, pressure: float | Floats) -> Floats:
    """Nodal forces (n, 2) [N/m] of a pressure [Pa] on boundary edges (k, 2) with the ground on their left.

    `pressure` is one number, or one per edge (k,).
    """
    along = positions[edges[:, 1]] - positions[edges[:, 0]]
    force = (
        0.5 * np.stack([-along[:, 1], along[:, 0]], axis=1) * np.broadcast_to(pressure, len(edges))[:, None]
    )
    load = np.zeros_like(positions)
    np.add.at(load, edges[:, 0], force)
    np.add.at(load, edges[:, 1], force)
    return load
