"""Model: what does not change while the ground deforms.

Stress-carrying particles (node-integrated triangles): a stress point is the share that one particle has in one
material (and, at the edge of a load, in one sector of its surroundings). With triangles e of area A_e and shape
gradients B_ek, a stress point s that owns the set T_s of corners of triangles has

    area      A_s  = sum over e in T_s of A_e / 3
    gradient  g_sk = sum over e in T_s of A_e / 3 B_ek

so that its strain is (1/A_s) sum_k g_sk (x) u_k and the force on particle k is -sum_s sigma_s g_sk. Both are
gathers, so the sum's order never depends on threads. Reference: node-based smoothed finite elements, Liu et
al. 2009 (Computers & Structures 87:14), explicit as in the smoothed particle finite element method, Yuan et al.
2019.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


class SparseVectors(NamedTuple):
    """Compressed rows of two-component vectors.

    start (rows + 1,) int32; column (entries,) int32; vector (entries, 2) float64.
    """

    start: Integers
    column: Integers
    vector: Floats


class Links(NamedTuple):
    """Links of supports: each answers to one generalised stretch, sum over particles of g . u, with one force.

    Attributes
    ----------
    gradient : SparseVectors, rows = links, columns = particles
        [-] for a lengthening, [1/m] for a turning.
    particle_gradient : SparseVectors, rows = particles, columns = links
    table : (k, 3)
        Stiffness, lower and upper limit of the force, per metre of tunnel: [N/m2, N/m] for a lengthening,
        [N, N] for a turning.
    """

    gradient: SparseVectors
    particle_gradient: SparseVectors
    table: Floats

    @property
    def number(self) -> int:
        """Number of links."""
        return len(self.table)


@dataclass(frozen=True)
class Model:
    """Stress-carrying particles of one section, their materials, supports and loads.

    Attributes
    ----------
    positions : (n, 2) [m]
    triangles : (m, 3) int32, counter-clockwise
    triangle_material : (m,) int32
    material_names : tuple of str
    law : str
        Name in `geodem.laws.GROUND_LAWS`.
    parameters : tuple of the law's parameter tuples, one per material
    point_particle, point_material : (s,) int32
        Particle and material of each stress point.
    point_area : (s,) [m2 per m of length, i.e. m2 of section]
    point_gradient : SparseVectors, rows = stress points, columns = particles [m]
    particle_gradient : SparseVectors, rows = particles, columns = stress points [m]
    particle_area : (n,) [m2]
    weight : (n, 2) [N/m]
        Body force at a gravity factor of one (pseudo-static horizontal part included).
    load : (n, 2) [N/m]
        Forces that gravity does not scale (surcharges).
    held : (n, 2) bool
        Freedoms held by supports.
    links : Links
        Linings, bolts and springs of the far ground; none in a plain section. Nodes of bolts are particles without
        area, weight or stress points, behind the ground's own.
    """

    positions: Floats
    triangles: Integers
    triangle_material: Integers
    material_names: tuple[str, ...]
    law: str
    parameters: tuple[Any, ...]
    point_particle: Integers
    point_material: Integers
    point_area: Floats
    point_gradient: SparseVectors
    particle_gradient: SparseVectors
    particle_area: Floats
    weight: Floats
    load: Floats
    held: NDArray[np.bool_]
    links: Links | None = None

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.positions)

    @property
    def stress_points(self) -> int:
        """Number of stress points."""
        return len(self.point_area)

    def parameter_table(self) -> Floats:
        """The parameters of all materials, (materials, parameters) [SI]."""
        return np.array([tuple(p) for p in self.parameters], dtype=np.float64)

    def particle_mean(self, values: Floats) -> Floats:
        """Area-weighted mean over every particle's stress points: (s, k) to (n, k)."""
        columns = [
            np.bincount(self.point_particle, values[:, k] * self.point_area, minlength=self.particles)
            for k in range(values.shape[1])
        ]
        area = np.where(self.particle_area > 0.0, self.particle_area, 1.0)
        return np.asarray(np.stack(columns, axis=1) / area[:, None])

    def with_parameters(self, parameters: Sequence[Any]) -> Model:
        """The same model with other material parameters (one tuple per material)."""
        return replace(self, parameters=tuple(parameters))

    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        total = 0
        for value in self.__dict__.values():
            parts = value if isinstance(value, SparseVectors) else (value,)
            total += sum(part.nbytes for part in parts if isinstance(part, np.ndarray))
        return total


def make_links(rows: Sequence[tuple[Sequence[int], Floats]], table: Floats, particles: int) -> Links:
    """Links from the particles (m,) and vectors (m, 2) of each, and their table (k, 3)."""
    count = len(rows)
    row = np.repeat(np.arange(count), [len(index) for index, _ in rows])
    column = np.concatenate(
        [np.asarray(index, dtype=np.int64) for index, _ in rows] or [np.zeros(0, np.int64)]
    )
    vector = np.concatenate([np.asarray(v, dtype=np.float64) for _, v in rows] or [np.zeros((0, 2))])
    gradient = _compress(row, column, vector, count, particles)
    return Links(
        gradient, transposed(gradient, particles), np.asarray(table, dtype=np.float64).reshape(-1, 3)
    )


def triangle_areas(positions: Floats, triangles: Integers) -> Floats:
    """Signed areas (m,) [m2]; positive counter-clockwise."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def triangle_gradients(positions: Floats, triangles: Integers) -> Floats:
    """A_e B_ek (m, 3, 2) [m]: shape gradient times area, half the opposite edge turned inwards."""
    corner = positions[triangles]
    opposite = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
    return np.asarray(0.5 * np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1))


def build_model(
    positions: Floats,
    triangles: Integers,
    triangle_material: Integers,
    *,
    material_names: Sequence[str],
    law: str,
    parameters: Sequence[Any],
    densities: Sequence[float],
    gravity: tuple[float, float],
    load: Floats,
    held: NDArray[np.bool_],
    split: Sequence[tuple[int, int]] = (),
) -> Model:
    """Assemble a model.

    Parameters
    ----------
    positions : (n, 2) [m]
    triangles : (m, 3) int, counter-clockwise
    triangle_material : (m,) int
        Index into `material_names`.
    parameters : sequence
        The law's parameter tuple per material.
    densities : sequence of float [kg/m3]
    gravity : (2,) [m/s2]
        Acceleration, usually (0, -9.81); a pseudo-static part is added to x.
    load : (n, 2) [N/m]
    held : (n, 2) bool
    split : sequence of (particle, sectors)
        Particles at the edge of a load, whose stress jumps: each gets that many stress points, one per sector of
        equal angle of its fan of triangles (averaging over the jump costs a footing 13 % at phi = 30 deg).
    """
    count = len(positions)
    areas = triangle_areas(positions, triangles)
    gradients = triangle_gradients(positions, triangles) / 3.0

    # one stress point per (particle, material, sector)
    corner_particle = triangles.astype(np.int64).ravel()
    corner_material = np.repeat(triangle_material.astype(np.int64), 3)
    sector = _sectors(positions, triangles, split)
    key = (corner_particle * len(material_names) + corner_material) * 16 + sector
    unique, corner_point = np.unique(key, return_inverse=True)
    point_particle = (unique // 16 // len(material_names)).astype(np.int32)
    point_material = (unique // 16 % len(material_names)).astype(np.int32)
    points = len(unique)
    corner_area = np.repeat(areas / 3.0, 3)
    point_area = np.asarray(np.bincount(corner_point, corner_area, minlength=points), dtype=np.float64)
    particle_area = np.asarray(np.bincount(corner_particle, corner_area, minlength=count), dtype=np.float64)

    rows = np.repeat(corner_point, 3)
    columns = np.repeat(triangles.astype(np.int64), 3, axis=0).ravel()
    vectors = np.repeat(gradients, 3, axis=0).reshape(-1, 2)
    point_gradient = _compress(rows, columns, vectors, points, count)
    particle_gradient = transposed(point_gradient, count)

    point_weight = point_area * np.asarray(densities, dtype=np.float64)[point_material]
    mass = np.bincount(point_particle, point_weight, minlength=count)
    return Model(
        positions=np.ascontiguousarray(positions, dtype=np.float64),
        triangles=np.ascontiguousarray(triangles, dtype=np.int32),
        triangle_material=np.ascontiguousarray(triangle_material, dtype=np.int32),
        material_names=tuple(material_names),
        law=law,
        parameters=tuple(parameters),
        point_particle=point_particle,
        point_material=point_material,
        point_area=point_area,
        point_gradient=point_gradient,
        particle_gradient=particle_gradient,
        particle_area=particle_area,
        weight=mass[:, None] * np.asarray(gravity, dtype=np.float64)[None, :],
        load=np.ascontiguousarray(load, dtype=np.float64),
        held=np.ascontiguousarray(held, dtype=np.bool_),
    )


def _sectors(positions: Floats, triangles: Integers, split: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    """Sector of every corner of every triangle (3 m,): 0 but around the particles in `split`."""
    sector = np.zeros(triangles.size, dtype=np.int64)
    centres = positions[triangles].mean(axis=1)
    for particle, sectors in split:
        corners = np.flatnonzero(triangles.ravel() == particle)
        to = centres[corners // 3] - positions[particle]
        angle = np.unwrap(np.sort(np.arctan2(to[:, 1], to[:, 0])))
        # cut the circle in its widest gap, so that the fan is one interval
        raw = np.arctan2(to[:, 1], to[:, 0])
        ordered = np.sort(raw)
        gaps = np.diff(np.append(ordered, ordered[0] + 2 * np.pi))
        start = ordered[(np.argmax(gaps) + 1) % len(ordered)]
        angle = np.mod(raw - start + 1e-12, 2 * np.pi)
        span = angle.max() + 1e-9
        sector[corners] = np.minimum((angle / span * sectors).astype(np.int64), sectors - 1)
    return sector


def _compress(
    rows: NDArray[np.int64], columns: NDArray[np.int64], vectors: Floats, row_count: int, column_count: int
) -> SparseVectors:
    """Sum duplicates into compressed rows; entries that cancel exactly to round-off are dropped."""
    key = rows * column_count + columns
    unique, place = np.unique(key, return_inverse=True)
    total = np.stack([np.bincount(place, vectors[:, axis], minlength=len(unique)) for axis in (0, 1)], axis=1)
    size = np.bincount(place, np.abs(vectors).sum(axis=1), minlength=len(unique))
    keep = np.abs(total).sum(axis=1) > 1e-13 * size
    unique, total = unique[keep], total[keep]
    row, column = unique // column_count, unique % column_count
    start = np.zeros(row_count + 1, dtype=np.int32)
    np.cumsum(np.bincount(row, minlength=row_count), out=start[1:])
    return SparseVectors(start, column.astype(np.int32), np.ascontiguousarray(total))


def transposed(rows: SparseVectors, column_count: int) -> SparseVectors:
    """The same entries by column: rows of the result are columns of `rows`, each in the order of the old rows."""
    row_of_entry = np.repeat(np.arange(len(rows.start) - 1), np.diff(rows.start))
    order = np.argsort(rows.column, kind="stable")
    start = np.zeros(column_count + 1, dtype=np.int32)
    np.cumsum(np.bincount(rows.column, minlength=column_count), out=start[1:])
    return SparseVectors(
        start, row_of_entry[order].astype(np.int32), np.ascontiguousarray(rows.vector[order])
    )
