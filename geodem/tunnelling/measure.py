"""What is read around an opening: convergence, pressure on the wall, ground that yielded, forces in supports."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..laws import GROUND_LAWS
from ..model import Model
from .ground import TunnelGround, strength
from .supports import Built

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

YIELDED = 0.01
"""Plastic shear strain over the elastic one at the strength that counts as yielded; below is the overshoot of steps."""


class Convergence(NamedTuple):
    """How far a wall has moved into its opening [m].

    Attributes
    ----------
    mean : float
        Area that the opening lost over its wall's length.
    largest : float
        Largest displacement of the wall.
    crown, invert : float
        Of the highest and the lowest particle: down, up.
    horizontal, vertical : float
        What the width and the height lost, between the outermost particles; of half a tunnel, half of the width.
    """

    mean: float
    largest: float
    crown: float
    invert: float
    horizontal: float
    vertical: float


def wall_normals(positions: Floats, wall: Integers) -> tuple[Integers, Floats]:
    """Particles (k,) of a wall and the lengths that they stand for along the normals into the ground (k, 2) [m]."""
    along = positions[wall[:, 1]] - positions[wall[:, 0]]
    into = 0.5 * np.stack([-along[:, 1], along[:, 0]], axis=1)
    particles = np.unique(wall)
    place = {int(p): k for k, p in enumerate(particles)}
    normals = np.zeros((len(particles), 2))
    for end in (0, 1):
        np.add.at(normals, [place[int(p)] for p in wall[:, end]], into)
    return particles, normals


def wall_length(positions: Floats, wall: Integers) -> float:
    """Length of a wall [m]."""
    return float(np.hypot(*(positions[wall[:, 1]] - positions[wall[:, 0]]).T).sum())


def convergence(positions: Floats, displacement: Floats, wall: Integers) -> Convergence:
    """Convergence of a wall (k, 2) of edges."""
    particles, normals = wall_normals(positions, wall)
    moved, at = displacement[particles], positions[particles]
    mean = -float((moved * normals).sum()) / wall_length(positions, wall)
    top, bottom = int(np.argmax(at[:, 1])), int(np.argmin(at[:, 1]))
    left, right = int(np.argmin(at[:, 0])), int(np.argmax(at[:, 0]))
    return Convergence(
        mean=mean,
        largest=float(np.hypot(*moved.T).max()),
        crown=-float(moved[top, 1]),
        invert=float(moved[bottom, 1]),
        horizontal=float(moved[left, 0] - moved[right, 0]),
        vertical=float(moved[bottom, 1] - moved[top, 1]),
    )


def mean_pressure(positions: Floats, force: Floats, wall: Integers) -> float:
    """Pressure [Pa] that forces (n, 2) [N/m] on the particles of a wall press into the ground, mean over the wall.

    A pressure p gives the forces p times the normals; this is its least-squares value. The two ends of an open wall
    are left out: on a line of symmetry half of their force goes into the support.
    """
    particles, normals = wall_normals(positions, wall)
    if wall[0, 0] != wall[-1, 1]:
        inside = (particles != wall[0, 0]) & (particles != wall[-1, 1])
        particles, normals = particles[inside], normals[inside]
    return float((force[particles] * normals).sum() / (normals**2).sum())


class Yielded(NamedTuple):
    """Ground that has yielded.

    Attributes
    ----------
    area : float [m2]
    radius_ratio : float
        Radius R0 of a round zone of that area around the opening over the radius of a round opening of its area:
        root of (1 + yielded area / area of the opening) [-].
    reach : float
        Distance from the opening's centre to the farthest yielded particle [m]; 0 where nothing yielded.
    points : (s,) bool
        Stress points of the model.
    """

    area: float
    radius_ratio: float
    reach: float
    points: NDArray[np.bool_]


def yielded(model: Model, stress: Floats, opening_area: float, centre: tuple[float, float]) -> Yielded:
    """The yielded zone of stresses and plastic shear strains (s, 4)."""
    _, allowed = strength(model, stress)
    law = GROUND_LAWS[model.law]
    shear = np.array([law.elastic_moduli(p)[1] for p in model.parameters])[model.point_material]
    points = stress[:, 3] > YIELDED * np.maximum(allowed, 0.0) / shear
    points &= stress[:, 3] > 1e-12
    area = float(model.point_area[points].sum())
    at = model.positions[model.point_particle[points]] - np.asarray(centre)
    reach = float(np.hypot(*at.T).max()) if len(at) else 0.0
    return Yielded(area, math.sqrt(1.0 + area / opening_area), reach, points)


class LiningForces(NamedTuple):
    """Forces in a lining, per metre of tunnel: thrust [N/m], compression positive, and moment [N].

    Attributes
    ----------
    thrust, moment : (k,) [N/m], (j,) [N]
    thrust_at, moment_at : (k, 2), (j, 2) [m]
    largest_compression, largest_tension : float
        Of the outermost fibre, N/t + 6 |M|/t^2 and 6 |M|/t^2 - N/t [Pa].
    """

    thrust: Floats
    moment: Floats
    thrust_at: Floats
    moment_at: Floats
    largest_compression: float
    largest_tension: float


def lining_forces(built: Built, support: Floats, thickness: float) -> LiningForces:
    """Forces in a lining from the state (k, 3) of its links."""
    thrust = -support[built.reading["axial"], 0]
    moment = support[built.reading["bending"], 0]
    # thrust of the two pieces beside a joint, by the nearest one: the joints lie at their ends
    nearest = [int(np.argmin(np.hypot(*(built.at["axial"] - at).T))) for at in built.at["bending"]]
    beside = thrust[nearest] / thickness
    bending = 6.0 * np.abs(moment) / thickness**2
    return LiningForces(
        thrust, moment, built.at["axial"], built.at["bending"],
        float((beside + bending).max(initial=0.0)), float((bending - beside).max(initial=0.0)),
    )  # fmt: skip


def settlement(ground: TunnelGround, displacement: Floats) -> float:
    """Largest fall of the highest side of the section [m]; 0 where it does not move down."""
    y = ground.model.positions[:, 1]
    top = y > y.max() - 1e-6 * float(np.ptp(y))
    return float(max(0.0, -displacement[top, 1].min()))
