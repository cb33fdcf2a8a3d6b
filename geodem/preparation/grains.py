"""What the particles of a sample are made of, and the assembly of a state of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assembly import Assembly, Wall
from ..builders.assembly_builder import AssemblyBuilder
from ..builders.interactions import nearest
from ..errors import InputError
from ..integrators.link_stiffness import law_stiffness
from ..laws import CONTACT_LAWS

Floats = NDArray[np.float64]

FRICTION = "friction_coefficient"
SHARE = 0.5
"""Of the time step at which the smallest particle, touched all around, would explode."""
DEEP = 0.02
"""Overlap over the smallest radius that the time step is made for; a linear contact does not care."""
AROUND = {2: 6, 3: 12}
"""Equal particles around one."""


@dataclass(frozen=True)
class Grains:
    """Material of all particles of a sample.

    Attributes
    ----------
    density : float [kg/m3]
    contact : dict of str to float
        Parameters of the contact law, SI.
    contact_law : str
        Name in `geodem.laws.CONTACT_LAWS`.
    name : str
        Of the material, for `AssemblyBuilder`.
    """

    density: float
    contact: Mapping[str, float]
    contact_law: str = "linear_frictional"
    name: str = "grain"

    def with_friction(self, friction: float | None) -> Grains:
        """These grains with another friction coefficient, or as they are where it is None.

        Raises InputError for one that is no number from 0, or above 0 for a law without friction.
        """
        if friction is None:
            return self
        if not (math.isfinite(friction) and friction >= 0.0):
            raise InputError("friction", "this is no friction coefficient", "Give 0 or more.", value=friction)
        if self.contact_law not in CONTACT_LAWS:
            remedy = nearest(self.contact_law, list(CONTACT_LAWS))
            raise InputError("contact law", "there is no such law", remedy, value=self.contact_law)
        law = CONTACT_LAWS[self.contact_law]
        if FRICTION not in law.PARAMETERS._fields:
            if friction == 0.0 and not law.TANGENTIAL:
                return self
            raise InputError(
                "friction", f"the law {self.contact_law!r} has no {FRICTION}", "Leave it out.", value=friction
            )
        return replace(self, contact={**self.contact, FRICTION: float(friction)})

    @property
    def friction(self) -> float:
        """Friction coefficient [-]; 0 for a law without."""
        return float(self.contact.get(FRICTION, 0.0))

    def assembly(
        self,
        positions: Floats,
        radii: Floats,
        *,
        gravity: ArrayLike | None = None,
        walls: Sequence[Wall] = (),
        cell: Floats | None = None,
        periodic: Sequence[bool] | bool = True,
    ) -> Assembly:
        """Particles at rest, with walls or in a cell with vectors (d, d) [m]; raises InputError as the builder does."""
        builder = AssemblyBuilder(positions.shape[1], contact_law=self.contact_law, gravity=gravity)
        builder.add_material(self.name, density=self.density, contact=self.contact)
        builder.add_particles(positions, radii, self.name)
        for wall in walls:
            builder.add_wall(wall)
        if cell is not None:
            builder.set_cell(cell, periodic=periodic)
        return builder.build()

    def time_step(self, assembly: Assembly) -> float:
        """A step [s] that holds for any arrangement of the particles, as long as overlaps stay small.

        Half of what the smallest particle bears that is touched all around by its like: 2/omega with
        omega^2 = 2 (z/d) (kn + (d - 1) ks)/m, or of its spin, omega^2 = 4 z ks r^2/I.
        """
        law = CONTACT_LAWS[self.contact_law]
        d = assembly.dimension
        smallest = int(np.argmin(assembly.radii))
        # the stiffest contact of all: with the largest, and against a wall
        radius, largest = float(assembly.radii[smallest]), float(assembly.radii.max())
        partners = np.array([radius, largest])
        overlap = np.full(2, DEEP * radius)
        rows = [assembly.pair_parameters(0, 0)]
        rows += [np.array(tuple(wall.contact[self.name]), dtype=np.float64) for wall in assembly.walls]
        found = np.concatenate(
            [
                law_stiffness(
                    law, d, row[None, :], radius_a=np.full(2, radius), radius_b=partners,
                    distance=radius + partners - overlap, overlap=overlap,
                )
                for row in rows
            ]
        )  # fmt: skip
        # of walls there is one among many contacts
        kn, ks = float(found[:2, 0].max()), float(found[:2, 1].max())
        if len(rows) > 1:
            share = 1.0 / AROUND[d]
            kn = (1.0 - share) * kn + share * float(found[2:, 0].max())
            ks = (1.0 - share) * ks + share * float(found[2:, 1].max())
        z = AROUND[d]
        mass, inertia = float(assembly.mass[smallest]), float(assembly.inertia[smallest])
        moving = 2.0 * (z / d) * (kn + (d - 1) * ks) / mass
        turning = 4.0 * z * ks * radius**2 / inertia
        return SHARE * 2.0 / math.sqrt(max(moving, turning))
