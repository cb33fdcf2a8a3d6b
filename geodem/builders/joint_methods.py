"""What an assembly's builder does about joints and bolts: one mix-in class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.assembly import Cell
from geodem.builders import assembly_checks as checks
from geodem.builders.assembly_checks import as_numbers, chosen
from geodem.builders.interactions import Materials
from geodem.builders.joint_cut import Cut
from geodem.builders.joints import Joint
from geodem.builders.linkage import Linkage
from geodem.errors import InputError

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]


class JointMethods:
    """Joints through the particles, and links with directions of their own.

    `AssemblyBuilder` has the arrays and materials that are named here.
    """

    dimension: int
    _positions: Floats
    _radii: Floats
    _material: NDArray[np.int32]
    _bonds: Pairs
    _scale: Floats
    _cell: Cell | None
    _bond_law: ModuleType | None
    _materials: Materials
    _linkage: Linkage

    if TYPE_CHECKING:

        @property
        def particles(self) -> int: ...

        def add_material(
            self,
            name: str,
            *,
            density: float,
            contact: Mapping[str, float],
            bond: Mapping[str, float] | None = None,
        ) -> None: ...

    def add_joint_material(self, name: str, *, law: str = "smooth_joint", **parameters: float) -> None:
        """Add a material of joints or bolts: a law in `geodem.laws.JOINT_LAWS` and its parameters, SI."""
        self._linkage.add_material(name, law, parameters)

    def add_untouched_material(self, name: str, *, density: float) -> None:
        """Add a material of particles that touch no others [kg/m3]: only links act on them, see `link`."""
        if not self._materials.names:
            raise InputError(
                f"material {name!r}", "there is no ground yet", "Add the ground's material first."
            )
        contact = self._materials.contact[self._materials.names[0]]
        self.add_material(name, density=density, contact=contact._asdict())
        self._linkage.untouched.append(name)

    def cut(self, joints: Sequence[Joint], *, within: float = 1.05, bounds: ArrayLike | None = None) -> Cut:
        """Cut joints through the particles; to be called once, after particles have been bonded.

        Pairs that a joint crosses, bonded or as near as touching, become faces of the joint: bonded where its
        material has cohesion or tensile strength, else free to slide and open. A particle that is bonded to the other
        side alone is counted there, and one that hardly holds to its own bears nothing of the joint.

        Parameters
        ----------
        joints : sequence of Joint
        within : float
            Pairs up to this many times the sum of their radii apart act on each other through a joint, bonded or not.
        bounds : (2, d) float, optional
            Of a body that fills them [m]: all of a face that lies in them counts. Where they are left out, what is
            farther than a particle from every pair that is crossed has no area.

        Returns
        -------
        Cut
            Pairs, normals, places and areas; `geodem.builders.joint_loads` takes it.
        """
        self._refuse_cell("cut")
        cut, bonded, loose = self._linkage.cut_through(
            self._positions, self._radii, self._bonds, joints, within, bounds
        )
        keep = ~np.isin(
            checks.pair_keys(self._bonds, self.particles), checks.pair_keys(loose, self.particles)
        )
        self._bonds, self._scale = self._bonds[keep], self._scale[keep]
        self._record_like_bonds("cut", bonded)
        return cut

    def link(self, pairs: ArrayLike, directions: ArrayLike, shares: ArrayLike, material: str) -> None:
        """Link pairs of particles along directions of their own, for instance the pieces of a bolt.

        Parameters
        ----------
        pairs : (k, 2) int
        directions : (d,) or (k, d) float
            Vectors that keep their direction.
        shares : float or (k,) float
            Of the material, see its law.
        material : str
            Of `add_joint_material`.
        """
        self._refuse_cell("link")
        numbers = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
        chosen("link", numbers.ravel(), self.particles)
        along = as_numbers("link, directions", directions, (len(numbers), self.dimension), "units of 1")
        along = np.where((numbers[:, 0] > numbers[:, 1])[:, None], -along, along)
        numbers = np.sort(numbers, axis=1)
        self._linkage.link(numbers, along, shares, material)
        self._record_like_bonds("link", numbers)

    def _record_like_bonds(self, place: str, pairs: Pairs) -> None:
        """Number links like bonds, so that their breaks are recorded; bonds that are there already keep theirs."""
        new = pairs[
            ~np.isin(checks.pair_keys(pairs, self.particles), checks.pair_keys(self._bonds, self.particles))
        ]
        if self._bond_law is None and len(new):
            raise InputError(
                place, "what breaks here is recorded like a bond, and there is no bond law",
                "Give AssemblyBuilder a bond_law, or the joint no strength.",
            )  # fmt: skip
        self._bonds = np.concatenate([self._bonds, new])
        self._scale = np.concatenate([self._scale, np.ones(len(new))])

    def _refuse_cell(self, place: str) -> None:
        if self._cell is not None:
            raise InputError(place, "a periodic cell has neither joints nor bolts", "Leave set_cell out.")

    def solid(self) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Particles (k,) that touch others so far, their centres (k, d) and radii (k,) [m]."""
        names = [self._materials.names.index(name) for name in self._linkage.untouched]
        own = np.flatnonzero(~np.isin(self._material, names))
        return own, self._positions[own], self._radii[own]
