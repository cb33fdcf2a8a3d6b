"""Pairs with a direction of their own, collected while an assembly is built: across joints, and along bolts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.assembly import Joints
from geodem.builders import assembly_checks as checks
from geodem.builders.assembly_checks import as_numbers
from geodem.builders.close_pairs import close_pairs
from geodem.builders.interactions import find_law, nearest
from geodem.builders.joint_cut import Cut, cut_joints, find_cut, put_aside, with_links
from geodem.builders.joints import Joint, box_of
from geodem.errors import InputError
from geodem.laws import JOINT_LAWS
from geodem.laws.protocol import make_parameters

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]


@dataclass
class Linkage:
    """What joints and bolts add to an assembly.

    Attributes
    ----------
    dimension : int
    materials : dict of str to (str, tuple)
        Law and parameters by name.
    untouched : list of str
        Materials of particles that touch nothing.
    cut : Joints or None
        Of the joints.
    """

    dimension: int
    materials: dict[str, tuple[str, Any]] = field(default_factory=dict)
    untouched: list[str] = field(default_factory=list)
    cut: Joints | None = None
    _links: list[tuple[Pairs, Floats, Floats, str]] = field(default_factory=list)

    def add_material(self, name: str, law: str, parameters: dict[str, float]) -> None:
        """Add a material of joints or of bolts."""
        place = f"joint material {name!r}"
        if name in self.materials:
            raise InputError(place, "there is such a material already", "Give it another name.")
        module = find_law("joint", law, JOINT_LAWS, self.dimension)
        self.materials[name] = law, make_parameters(module, parameters, place)

    def cut_through(
        self,
        positions: Floats,
        radii: Floats,
        bonds: Pairs,
        joints: Sequence[Joint],
        within: float,
        bounds: ArrayLike | None,
    ) -> tuple[Cut, Pairs, Pairs]:
        """See `AssemblyBuilder.cut`; what is cut, pairs that are bonded faces, and pairs that are not bonded."""
        if self.cut is not None:
            raise InputError("cut", "this has been cut already", "Give all joints at once.")
        other = [joint.dimension for joint in joints if joint.dimension != self.dimension]
        if other or not joints:
            remedy = f"Give joints in {self.dimension}D."
            raise InputError("cut", "there is no joint of this dimension", remedy, value=other[:1])
        if not (np.isfinite(within) and 1.0 <= within <= checks.LONGEST_BOND):
            problem = f"this is not between 1 and {checks.LONGEST_BOND:g}"
            raise InputError("cut, within", problem, "Give a factor such as 1.05.", value=within)
        for joint in joints:
            self._known(joint.material)
        box = np.array([(positions - radii[:, None]).min(axis=0), (positions + radii[:, None]).max(axis=0)])
        box = box if bounds is None else box_of(bounds)
        near, _ = close_pairs(positions, radii, lambda a, b: within * (a + b))
        pairs = np.unique(np.concatenate([near, bonds]), axis=0)
        cut = find_cut(positions, radii, pairs, joints, box)
        sides, idle = put_aside(positions, radii, bonds, cut, joints)
        cut = find_cut(sides, radii, pairs, joints, box, idle, whole=bounds is not None)
        size = radii[cut.pairs].sum(axis=1)
        apart = np.linalg.norm(positions[cut.pairs[:, 1]] - positions[cut.pairs[:, 0]], axis=1)
        reach = max(within, float((apart / size).max(initial=0.0)) * (1.0 + 1e-12))
        self.cut = cut_joints(cut, joints, list(self.materials), sides, radii, reach)
        holds = np.array([self._starts_bonded(joint.material) for joint in joints], dtype=bool)[cut.joint]
        holds &= cut.areas > 0.0
        return cut, cut.pairs[holds], cut.pairs[~holds]

    def link(self, pairs: Pairs, directions: ArrayLike, shares: ArrayLike, material: str) -> None:
        """Link pairs along given directions (k, d), each with a share (k,) of the material."""
        self._known(material)
        count = len(pairs)
        along = as_numbers("link, directions", directions, (count, self.dimension), "units of 1")
        size = np.sqrt((along**2).sum(axis=1))
        share = as_numbers("link, shares", shares, (count,), "m or units of 1")
        if (size == 0.0).any() or not np.isfinite(along).all():
            raise InputError("link, directions", "one has no direction", "Give vectors that are not zero.")
        if not (share > 0.0).all():
            raise InputError("link, shares", "they are not all positive", "Give more than 0.")
        self._links.append((pairs, along / size[:, None], share, material))

    def joints(self, materials: list[str]) -> Joints | None:
        """What an assembly keeps; `materials` are those of its particles."""
        if self.cut is None and not self._links:
            return None
        untouched = np.array([materials.index(name) for name in self.untouched], dtype=np.int32)
        return with_links(self.cut, self._links, self.materials, untouched, self.dimension)

    def crossed(self) -> Pairs:
        """Pairs (k, 2) that joints or links join."""
        parts = [] if self.cut is None else [self.cut.pairs.astype(np.int64)]
        return np.concatenate([np.empty((0, 2), dtype=np.int64), *parts, *(link[0] for link in self._links)])

    def _known(self, material: str) -> None:
        if material not in self.materials:
            remedy = nearest(material, list(self.materials))
            raise InputError("joint, material", "there is no such material of joints", remedy, value=material)

    def _starts_bonded(self, material: str) -> bool:
        law, parameters = self.materials[material]
        return bool(JOINT_LAWS[law].starts_bonded(parameters))
