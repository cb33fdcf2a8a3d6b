"""Contacts and bonds as a network of springs: strains B u and stiffness K = B^T D B at one state of an assembly.

Every link (contact or bond) between the particles a and b, with the unit vector n from a to b, has the strains

    extension = n . (u_b - u_a)
    slip      = the part across n of (u_b - u_a) - (arm_a theta_a + arm_b theta_b) x n
    twist     = n . (theta_b - theta_a)
    bend      = the part across n of theta_b - theta_a

with one stiffness each. The arms sum to the distance, so that no strain answers to a rotation of the whole. In 2D
there is no twist, slip is along t = (-n_y, n_x) and bend is theta_b - theta_a.

Freedoms are ordered by particle: d translations [m], then s rotations [rad]; s = 1 in 2D, 3 in 3D.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Anchors

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

RIGID = -1
"""Stands for the second particle where a link leads to a wall."""


class Links(NamedTuple):
    """Springs between particles, and between particles and walls.

    Attributes
    ----------
    first, second : (p,) int64
        Particles a and b; `RIGID` as b: a wall.
    normal : (p, d)
        Unit vectors from a to b, or from a to the wall.
    arms : (p, 2) [m]
        From the centres of a and b to the contact.
    kn, ks : (p,) [N/m] (2D: N/m per m)
    k_twist, k_bend : (p,) [N m/rad]
    """

    first: Integers
    second: Integers
    normal: Floats
    arms: Floats
    kn: Floats
    ks: Floats
    k_twist: Floats
    k_bend: Floats


class Springs(NamedTuple):
    """Springs between particle centres and points fixed in space.

    Attributes
    ----------
    particle : (k,) int64
    direction : (k, d)
        Unit vectors from the particles to the points.
    along, across : (k,) [N/m]
        Stiffness in the direction, and in all directions across it.
    """

    particle: Integers
    direction: Floats
    along: Floats
    across: Floats


class Strains(NamedTuple):
    """Strains of every link, or its forces and moments on a: `link_strains`, `link_forces`.

    Attributes
    ----------
    extension : (p,) [m]
        Positive: apart, the overlap falls by as much. As a force [N]: tension.
    slip : (p, s) [m]
        2D: along t. 3D: the vector. As a force [N]: shear on a.
    twist : (p,) [rad]
        0 in 2D. As a moment [N m]: on a.
    bend : (p, s) [rad]
        2D: the angle. 3D: the vector. As a moment [N m]: on a.
    """

    extension: Floats
    slip: Floats
    twist: Floats
    bend: Floats


def links(
    first: ArrayLike,
    second: ArrayLike,
    normal: ArrayLike,
    arms: ArrayLike,
    kn: ArrayLike,
    ks: ArrayLike = 0.0,
    k_twist: ArrayLike = 0.0,
    k_bend: ArrayLike = 0.0,
) -> Links:
    """`Links` from arrays or, where all links are alike, single numbers; for shapes see `Links`.

    Arrays that fit are not copied.
    """
    first = np.atleast_1d(np.asarray(first, dtype=np.int64))
    count = len(first)
    normal = np.asarray(normal, dtype=float)

    def each(value: ArrayLike) -> Floats:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), (count,)))

    return Links(
        first,
        np.ascontiguousarray(np.broadcast_to(np.asarray(second, dtype=np.int64), (count,))),
        np.ascontiguousarray(np.broadcast_to(normal, (count, normal.shape[-1]))),
        np.ascontiguousarray(np.broadcast_to(np.asarray(arms, dtype=float), (count, 2))),
        each(kn),
        each(ks),
        each(k_twist),
        each(k_bend),
    )


def pair_links(
    positions: Floats,
    radii: Floats,
    pairs: ArrayLike,
    kn: ArrayLike,
    ks: ArrayLike = 0.0,
    k_twist: ArrayLike = 0.0,
    k_bend: ArrayLike = 0.0,
) -> Links:
    """Links between particles; the contact lies in the middle of the overlap (or of the gap).

    Parameters
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    pairs : (p, 2) int
    kn, ks, k_twist, k_bend : (p,) or float
        See `Links`.
    """
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    first, second = pairs.T
    branch = positions[second] - positions[first]
    distance = np.sqrt((branch * branch).sum(axis=1))
    half = 0.5 * (radii[first] + radii[second] - distance)
    arms = np.stack([radii[first] - half, radii[second] - half], axis=1)
    return links(first, second, branch / distance[:, None], arms, kn, ks, k_twist, k_bend)


def joined(*parts: Links) -> Links:
    """All links of several `Links`, in order."""
    if sum(len(part.first) > 0 for part in parts) == 1:
        return next(part for part in parts if len(part.first))
    return Links(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))


def anchor_springs(positions: Floats, anchors: Anchors) -> Springs:
    """The tangent stiffness of anchors where the particles are now.

    Across, a spring in tension T at the distance l resists with T/l. Compressed ones would push the particle
    further out: that term is left out, which keeps the matrix positive and the time step on the safe side.

    Parameters
    ----------
    positions : (n, d) [m]
    anchors : Anchors
    """
    particle = np.asarray(anchors.particle, dtype=np.int64)
    branch = anchors.point - positions[particle]
    distance = np.sqrt((branch * branch).sum(axis=1))
    direction = np.zeros_like(branch)
    direction[:, 0] = 1.0
    apart = distance > 0.0
    direction[apart] = branch[apart] / distance[apart, None]
    # k (distance - length)/distance; a spring without length is as stiff in every direction, at its point too
    share = np.where(anchors.length == 0.0, 1.0, 0.0)
    share[apart] = 1.0 - anchors.length[apart] / distance[apart]
    return Springs(particle, direction, anchors.stiffness, anchors.stiffness * np.maximum(share, 0.0))


@dataclass(frozen=True)
class Network:
    """Made by `build_network`.

    Attributes
    ----------
    positions : (n, d) [m]
    links : Links
    springs : Springs or None
    tangents : (p, d - 1, d)
        Unit vectors across every normal in which slip and bend are written.
    operator : sparse (r, n (d + s))
        B: rows of all links for the extension, slips, twist and bends one after the other, then of the springs.
    stiffness : (r,) [N/m, N m/rad]
        Diagonal of D.
    """

    positions: Floats
    links: Links
    springs: Springs | None
    tangents: Floats
    operator: csr_matrix
    stiffness: Floats

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.positions.shape[1]

    @property
    def freedoms(self) -> int:
        """Freedoms of a particle, d + s."""
        return 3 if self.dimension == 2 else 6


def across(normal: Floats) -> Floats:
    """Unit vectors (p, d - 1, d) across the normals (p, d); in 3D right-handed with them."""
    if normal.shape[1] == 2:
        return np.stack([-normal[:, 1], normal[:, 0]], axis=1)[:, None, :]
    x, y, z = normal.T
    # without a branch at one pole only: Duff et al. 2017, Building an orthonormal basis, revisited
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    second = np.stack([b, sign + y * y * a, -y], axis=1)
    return np.stack([first, second], axis=1)


def build_network(positions: Floats, links: Links, springs: Springs | None = None) -> Network:
    """The strain operator of an assembly's contacts, bonds and anchors.

    Parameters
    ----------
    positions : (n, d) [m]
    links : Links
        Normals need not agree with the positions (a periodic cell has links across its sides).
    springs : Springs, optional
    """
    from scipy.sparse import csr_matrix

    particles, dimension = positions.shape
    freedoms = 3 if dimension == 2 else 6
    count = len(links.first)
    tangents = across(links.normal)
    rows: list[Integers] = []
    columns: list[Integers] = []
    values: list[Floats] = []
    stiffness: list[Floats] = []
    started = 0

    def put(particle: Integers, offset: int, vector: Floats) -> None:
        used = particle != RIGID
        width = vector.shape[1]
        at = started + np.arange(len(particle))[used]
        rows.append(np.repeat(at, width))
        columns.append((freedoms * particle[used, None] + offset + np.arange(width)).ravel())
        values.append(vector[used].ravel())

    def row_of_links(translation: Floats | None, turn_a: Floats | None, turn_b: Floats | None) -> None:
        if translation is not None:
            put(links.first, 0, -translation)
            put(links.second, 0, translation)
        if turn_a is not None and turn_b is not None:
            put(links.first, dimension, turn_a)
            put(links.second, dimension, turn_b)

    row_of_links(links.normal, None, None)
    stiffness.append(links.kn)
    started += count
    arm_a, arm_b = links.arms[:, :1], links.arms[:, 1:]
    for k in range(dimension - 1):
        tangent = tangents[:, k]
        # t . (theta x n) = theta . (n x t)
        lever = np.ones((count, 1)) if dimension == 2 else np.cross(links.normal, tangent)
        row_of_links(tangent, -arm_a * lever, -arm_b * lever)
        stiffness.append(links.ks)
        started += count
    axes = [np.ones((count, 1))] if dimension == 2 else [links.normal, tangents[:, 0], tangents[:, 1]]
    for k, axis in enumerate(axes):
        row_of_links(None, -axis, axis)
        stiffness.append(links.k_twist if dimension == 3 and k == 0 else links.k_bend)
        started += count
    if springs is not None:
        for k, vector in enumerate([springs.direction, *np.moveaxis(across(springs.direction), 1, 0)]):
            put(springs.particle, 0, vector)
            stiffness.append(springs.along if k == 0 else springs.across)
            started += len(springs.particle)
    operator = csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(started, particles * freedoms),
    )
    return Network(positions, links, springs, tangents, operator, np.concatenate(stiffness))


def stiffness_matrix(network: Network) -> csr_matrix:
    """K = B^T D B (n (d + s), n (d + s)) [N/m, N/rad, N m/rad]."""
    from scipy.sparse import diags

    acting = np.flatnonzero(network.stiffness)
    operator = network.operator[acting]
    return (operator.T @ (diags(network.stiffness[acting]) @ operator)).tocsr()


def imposed_strain(network: Network, motion: Floats) -> Floats:
    """Strain (r,) from a motion (p, d) [m] of b against a that comes on top of the particles' own.

    Of a wall where it touches, or of one side of a periodic cell against the other.
    """
    strain = np.zeros(len(network.stiffness))
    count, dimension = motion.shape
    strain[:count] = (network.links.normal * motion).sum(axis=1)
    for k in range(dimension - 1):
        strain[(k + 1) * count : (k + 2) * count] = (network.tangents[:, k] * motion).sum(axis=1)
    return strain


def _by_link(network: Network, rows: Floats) -> Strains:
    count, dimension = len(network.links.first), network.dimension
    parts = rows[: count * network.freedoms].reshape(network.freedoms, count)
    if dimension == 2:
        return Strains(parts[0], parts[1][:, None], np.zeros(count), parts[2][:, None])
    t1, t2 = network.tangents[:, 0], network.tangents[:, 1]
    return Strains(
        parts[0],
        parts[1][:, None] * t1 + parts[2][:, None] * t2,
        parts[3],
        parts[4][:, None] * t1 + parts[5][:, None] * t2,
    )


def link_strains(network: Network, displacement: Floats, imposed: Floats | None = None) -> Strains:
    """Strains of every link.

    Parameters
    ----------
    network : Network
    displacement : (n, d + s) [m, rad]
    imposed : (r,), optional
        From `imposed_strain`.
    """
    rows = network.operator @ displacement.ravel()
    return _by_link(network, rows if imposed is None else rows + imposed)


def link_forces(network: Network, displacement: Floats, imposed: Floats | None = None) -> Strains:
    """Tension, shear force, twisting and bending moment on a of every link [N, N m]; arguments: `link_strains`."""
    rows = network.operator @ displacement.ravel()
    return _by_link(network, network.stiffness * (rows if imposed is None else rows + imposed))
