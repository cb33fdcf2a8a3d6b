"""The particles of a body: what stands where, for how much of the source, and how they touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.close_pairs import close_pairs
from geodem.builders.packings import volumes
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
Pairs = NDArray[np.int64]


class MaterialShare(NamedTuple):
    """What the particles of one material are and stand for.

    Attributes
    ----------
    name : str
    particles : int
    solid : float [m2 or m3]
        Areas or volumes of the particles themselves.
    represented : float [m2 or m3]
        What they stand for, their voids included: `solid` over the solid fraction of the arrangement.
    source : float [m2 or m3]
        Area or volume in the source.
    density_factor : float [-]
        Density of a particle over that of the ground, so that the mass of the material is exactly that of the
        source: `source` over `solid`.
    """

    name: str
    particles: int
    solid: float
    represented: float
    source: float
    density_factor: float

    @property
    def difference(self) -> float:
        """What is represented over the source, minus 1 [-]."""
        return self.represented / self.source - 1.0


class Contacts(NamedTuple):
    """How particles touch.

    Attributes
    ----------
    pairs : int
    coordination : float
        Mean number of neighbours of a particle [-].
    largest_overlap : float
        Over the smaller radius [-].
    loose : int
        Particles without any neighbour.
    """

    pairs: int
    coordination: float
    largest_overlap: float
    loose: int


@dataclass(frozen=True)
class BodyFilling:
    """Discs or spheres that fill a body.

    Attributes
    ----------
    positions : (n, d) float64 [m]
    radii : (n,) float64 [m]
    material : (n,) int32
        Index into `materials`.
    materials : tuple of str
    sources : (m,) float64 [m2 or m3]
        Area or volume of every material in the source.
    solid_fraction : float [-]
        Of the arrangement in an unbounded body.
    arrangement : str
    group : (n,) int32
        Grain or block that a particle belongs to, -1 for none.
    remarks : tuple of str
        What a user should know: those of the body, thin layers, differences from the source.
    """

    positions: Floats
    radii: Floats
    material: Integers
    materials: tuple[str, ...]
    sources: Floats
    solid_fraction: float
    arrangement: str
    group: Integers
    remarks: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.positions.shape[1])

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.radii)

    @cached_property
    def shares(self) -> tuple[MaterialShare, ...]:
        """One entry a material."""
        count = np.bincount(self.material, minlength=len(self.materials))
        solid = np.bincount(self.material, volumes(self.radii, self.dimension), minlength=len(self.materials))
        return tuple(
            MaterialShare(
                name, int(number), float(own), float(own / self.solid_fraction), float(source),
                float(source / own),
            )
            for name, number, own, source in zip(self.materials, count, solid, self.sources, strict=True)
        )  # fmt: skip

    def density(self, densities: Mapping[str, float]) -> Floats:
        """Density (n,) [kg/m3] of every particle, given that of the ground by material [kg/m3].

        Raises
        ------
        InputError
            A material without density, or one that is not positive.
        """
        own = np.empty(len(self.materials))
        for number, share in enumerate(self.shares):
            value = densities.get(share.name)
            if value is None or not (np.isfinite(value) and value > 0.0):
                raise InputError(
                    f"density of {share.name!r}", "this is not a positive number", "Give it in kg/m3.",
                    value=value,
                )  # fmt: skip
            own[number] = value * share.density_factor
        return np.asarray(own[self.material])

    def summary(self) -> str:
        """Table of the materials: particles, size in the source and as represented, differences of size and mass."""
        unit = "m2" if self.dimension == 2 else "m3"
        mass = np.bincount(
            self.material,
            volumes(self.radii, self.dimension) * self.density(dict.fromkeys(self.materials, 1.0)),
            minlength=len(self.materials),
        )
        head = (
            "material", "particles", f"source [{unit}]", f"represented [{unit}]", "difference [%]",
            "mass difference [%]",
        )  # fmt: skip
        rows = [
            (
                share.name, str(share.particles), f"{share.source:.6g}", f"{share.represented:.6g}",
                f"{100.0 * share.difference:+.3f}", f"{100.0 * (mass[k] / share.source - 1.0):+.3f}",
            )
            for k, share in enumerate(self.shares)
        ]  # fmt: skip
        widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
        return "\n".join(
            "  ".join(
                cell.ljust(width) if k == 0 else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
            for row in (head, *rows)
        )

    def contacts(self, factor: float = 1.0 + 1e-9) -> Contacts:
        """Statistics of all pairs whose distance is at most `factor` times the sum of the radii."""
        pairs, distance = close_pairs(self.positions, self.radii, lambda a, b: factor * (a + b))
        ends = self.radii[pairs]
        overlap = (ends.sum(axis=1) - distance) / ends.min(axis=1) if len(pairs) else np.zeros(1)
        degree = np.bincount(pairs.ravel(), minlength=self.particles)
        return Contacts(
            pairs=len(pairs),
            coordination=float(degree.mean()),
            largest_overlap=max(0.0, float(overlap.max())),
            loose=int((degree == 0).sum()),
        )


class AddedBody(NamedTuple):
    """Where a body's particles stand in an assembly.

    Attributes
    ----------
    ids : (n,) int64
        Number in the assembly of every particle of the filling.
    bonds : (k, 2) int64
        Bonds within grains or blocks, and within the ground between them.
    across : (l, 2) int64
        Bonds from one grain or block to another, or to the ground between them.
    """

    ids: NDArray[np.int64]
    bonds: Pairs
    across: Pairs


def add_body(
    build: AssemblyBuilder,
    filling: BodyFilling,
    densities: Mapping[str, float],
    *,
    bond_factor: float | None = None,
    across: float = 1.0,
    velocity: ArrayLike = 0.0,
) -> AddedBody:
    """Put the particles of a body into an assembly, with the masses of the source.

    Bonds between two materials take what `AssemblyBuilder.set_bond` says.

    Parameters
    ----------
    build : AssemblyBuilder
        Has every material of the filling (`add_material`) already.
    filling : BodyFilling
    densities : dict
        Density of the ground [kg/m3] by material, voids between the particles included.
    bond_factor : float, optional
        Particles of the body whose distance is at most this times the sum of the radii are bonded; none where it
        is left out.
    across : float
        Factor on the strength of bonds between two grains, or a grain and what lies between grains, where the
        body has such [-]; 0: these are not bonded.
    velocity : (d,) float [m/s]

    Raises
    ------
    InputError
        Another dimension, a material or density that is missing, a factor that cannot be.
    """
    if build.dimension != filling.dimension:
        raise InputError(
            "add_body", f"the assembly is {build.dimension}D and the body {filling.dimension}D",
            "Make both of one dimension.",
        )  # fmt: skip
    density = filling.density(densities)
    ids = np.empty(filling.particles, dtype=np.int64)
    for number, name in enumerate(filling.materials):
        mine = np.flatnonzero(filling.material == number)
        ids[mine] = build.add_particles(
            filling.positions[mine], filling.radii[mine], name, density=density[mine], velocity=velocity
        )
    none = np.empty((0, 2), dtype=np.int64)
    if bond_factor is None:
        return AddedBody(ids, none, none)
    if not (np.isfinite(bond_factor) and bond_factor > 0.0):
        raise InputError(
            "add_body, bond_factor", "this is not a positive number",
            "Give 1.05: all pairs up to 5 % farther apart than touching.", value=bond_factor,
        )  # fmt: skip
    if not (np.isfinite(across) and across >= 0.0):
        raise InputError("add_body, across", "this is not a number from 0", "Give 1.", value=across)
    pairs, _ = close_pairs(filling.positions, filling.radii, lambda a, b: bond_factor * (a + b))
    apart = filling.group[pairs[:, 0]] != filling.group[pairs[:, 1]]
    within = build.bond(ids[pairs[~apart]])
    between = build.bond(ids[pairs[apart]], scale=across) if across > 0.0 else none
    return AddedBody(ids, within, between)


def few_remarks(shares: Sequence[MaterialShare], tolerance: float) -> list[str]:
    """Words on materials of a handful of particles and those that represent another size than the source's."""
    remarks = []
    for share in shares:
        if share.particles < FEW:
            remarks.append(f"{share.name} has only {share.particles} particles: take smaller ones.")
        if abs(share.difference) > tolerance:
            remarks.append(
                f"The particles of {share.name} stand for {100.0 * share.difference:+.2f} % of its size; "
                "their mass is that of the source all the same."
            )
    return remarks


FEW = 10
"""Below this number a material gets a remark."""
