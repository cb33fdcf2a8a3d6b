"""Links of an assembly: its contacts, bonds and wall contacts with the stiffness that their laws give them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Assembly
from ..laws import BOND_LAWS, CONTACT_LAWS
from .link_stiffness import law_stiffness
from .network import RIGID, Links, links, pair_links

Floats = NDArray[np.float64]

WALL_SIZE = 1e15
"""Radius of a wall over that of the particle."""


def contact_links(
    assembly: Assembly, positions: Floats, pairs: ArrayLike, overlap: Floats | None = None
) -> Links:
    """Links of particles that touch.

    Parameters
    ----------
    assembly : Assembly
    positions : (n, d) [m]
    pairs : (p, 2) int
    overlap : (p,) [m], optional
        Radii less distance if left out; contacts that took over from a bond measure it from elsewhere.
    """
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    first, second = pairs.T
    distance = np.sqrt(((positions[second] - positions[first]) ** 2).sum(axis=1))
    if overlap is None:
        overlap = assembly.radii[first] + assembly.radii[second] - distance
    stiffness = law_stiffness(
        CONTACT_LAWS[assembly.contact_law],
        assembly.dimension,
        assembly.contact_table[_row(assembly, first, second)],
        radius_a=assembly.radii[first],
        radius_b=assembly.radii[second],
        distance=distance,
        overlap=overlap,
    )
    return pair_links(positions, assembly.radii, pairs, *stiffness.T)


def bond_links(assembly: Assembly, positions: Floats, intact: ArrayLike | None = None) -> Links:
    """Links of bonds as the assembly has them; a bond law that acts beside the contact law adds to its links.

    Parameters
    ----------
    assembly : Assembly
    positions : (n, d) [m]
    intact : (b,) bool, optional
        All if left out.
    """
    bonds = np.asarray(assembly.bonds, dtype=np.int64).reshape(-1, 2)
    if intact is not None:
        bonds = bonds[np.asarray(intact, dtype=bool)]
    if assembly.bond_law is None:
        return pair_links(positions, assembly.radii, [], 0.0)
    first, second = bonds.T
    at_bonding = np.sqrt(((assembly.positions[second] - assembly.positions[first]) ** 2).sum(axis=1))
    distance = np.sqrt(((positions[second] - positions[first]) ** 2).sum(axis=1))
    stiffness = law_stiffness(
        BOND_LAWS[assembly.bond_law],
        assembly.dimension,
        assembly.bond_table[_row(assembly, first, second)],
        radius_a=assembly.radii[first],
        radius_b=assembly.radii[second],
        distance=distance,
        overlap=at_bonding - distance,
    )
    return pair_links(positions, assembly.radii, bonds, *stiffness.T)


def wall_links(
    assembly: Assembly, particle: ArrayLike, wall: ArrayLike, normal: Floats, overlap: Floats
) -> Links:
    """Links of particles that touch walls; the overlap lies in the particle, the arm is the distance to the wall.

    Parameters
    ----------
    assembly : Assembly
    particle, wall : (k,) int
        Numbers of the particles, and of the walls in `assembly.walls`.
    normal : (k, d)
        Unit vectors from the particles to the walls.
    overlap : (k,) [m]
    """
    particle = np.asarray(particle, dtype=np.int64)
    wall = np.asarray(wall, dtype=np.int64)
    law = CONTACT_LAWS[assembly.contact_law]
    fields = len(law.PARAMETERS._fields)
    table = np.array(
        [[each.contact[name] for name in assembly.material_names] for each in assembly.walls], dtype=float
    ).reshape(-1, len(assembly.material_names), fields)
    radius = assembly.radii[particle]
    stiffness = law_stiffness(
        law,
        assembly.dimension,
        table[wall, assembly.material[particle]],
        radius_a=radius,
        radius_b=WALL_SIZE * radius,
        distance=(1.0 + WALL_SIZE) * radius - overlap,
        overlap=overlap,
    )
    arms = np.stack([radius - overlap, np.zeros_like(radius)], axis=1)
    return links(particle, RIGID, normal, arms, *stiffness.T)


def _row(assembly: Assembly, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    material = assembly.material.astype(np.int64)
    return np.asarray(material[first] * len(assembly.material_names) + material[second])
