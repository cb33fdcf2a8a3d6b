"""Builder of an assembly of discs or spheres: materials, particles, bonds, supports, walls.

Every number is looked at when it is given, the whole when it is built; nothing runs on bad input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.assembly import DISC_INERTIA, SPHERE_INERTIA, Anchors, Assembly, Cell, Wall
from geodem.boundaries.checks import wall_errors
from geodem.builders import assembly_checks as checks
from geodem.builders.assembly_checks import as_numbers, bad_entries, chosen, raise_all
from geodem.builders.bond_scatter import LognormalScatter, NormalScatter
from geodem.builders.cell_checks import cell_errors, make_cell
from geodem.builders.close_pairs import close_pairs
from geodem.builders.interactions import Materials, find_law, pair_of
from geodem.builders.joint_methods import JointMethods
from geodem.builders.linkage import Linkage
from geodem.builders.memory import refuse_too_large
from geodem.errors import InputError
from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.laws.protocol import make_parameters

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]

AXES = "xyz"


class AssemblyBuilder(JointMethods):
    """Collects discs (2D, per metre of length) or spheres (3D) and what acts on them.

    Parameters
    ----------
    dimension : int
        2 or 3.
    contact_law : str
        Name in `geodem.laws.CONTACT_LAWS`.
    bond_law : str, optional
        Name in `geodem.laws.BOND_LAWS`.
    gravity : (d,) float, optional
        [m/s2]; none where it is left out.

    Raises
    ------
    InputError
        From every method, where the input cannot be used; the message names the place and what to do.
    """

    def __init__(
        self,
        dimension: int,
        contact_law: str = "linear_frictional",
        bond_law: str | None = None,
        gravity: ArrayLike | None = None,
    ) -> None:
        if dimension not in (2, 3):
            raise InputError("dimension", "particles are discs or spheres", "Give 2 or 3.", value=dimension)
        self.dimension = dimension
        self._rotations = 1 if dimension == 2 else 3
        self._law = find_law("contact", contact_law, CONTACT_LAWS, dimension)
        self._bond_law = None if bond_law is None else find_law("bond", bond_law, BOND_LAWS, dimension)
        self._linkage = Linkage(dimension)
        self._materials = Materials(self._law, self._bond_law)
        self._gravity = as_numbers("gravity", 0.0 if gravity is None else gravity, (dimension,), "m/s2")
        if not np.isfinite(self._gravity).all() or (gravity is not None and np.ndim(gravity) != 1):
            raise InputError(
                "gravity", f"these are not {dimension} finite numbers",
                f"Give {(0.0,) * (dimension - 1) + (-9.81,)}, for instance.", value=gravity,
            )  # fmt: skip
        freedoms = dimension + self._rotations
        self._positions = np.empty((0, dimension))
        self._radii = np.empty(0)
        self._density = np.empty(0)
        self._material = np.empty(0, dtype=np.int32)
        self._motion = np.empty((0, freedoms))  # velocities and spins
        self._held = np.empty((0, freedoms), dtype=bool)
        self._applied = np.empty((0, freedoms))
        self._bonds = np.empty((0, 2), dtype=np.int64)
        self._scale = np.empty(0)
        self._anchors: list[tuple[NDArray[np.int64], Floats, Floats, Floats]] = []
        self._walls: list[Wall] = []
        self._cell: Cell | None = None

    @property
    def particles(self) -> int:
        """Number of particles so far."""
        return len(self._radii)

    @property
    def contact_law(self) -> str:
        """Name of the contact law."""
        return str(self._law.NAME)

    @property
    def bond_law(self) -> str | None:
        """Name of the bond law."""
        return None if self._bond_law is None else str(self._bond_law.NAME)

    def set_cell(self, vectors: ArrayLike, *, periodic: bool | Sequence[bool] = True) -> None:
        """Make everything periodic; to be called before particles are bonded.

        Parameters
        ----------
        vectors : (d,) or (d, d) float
            Sides of a right-angled cell, or its edges as rows, right-handed [m].
        periodic : bool or (d,) bool
            Along which edges. Where some are not, walls may bound the particles there; such a cell cannot deform.
        """
        self._cell = make_cell(self.dimension, vectors, periodic)

    def add_material(
        self,
        name: str,
        *,
        density: float,
        contact: Mapping[str, float],
        bond: Mapping[str, float] | None = None,
    ) -> None:
        """Add a material.

        Parameters
        ----------
        name : str
        density : float
            [kg/m3]
        contact : dict
            The contact law's parameters between two particles of this material, SI.
        bond : dict, optional
            The bond law's; particles of a material without them cannot be bonded.
        """
        place = f"material {name!r}"
        if name in self._materials.density:
            raise InputError(place, "there is such a material already", "Give it another name.")
        errors = bad_entries("density", np.array([density], dtype=float), 0, "kg/m3", positive=True)
        found = [InputError(f"{place}, density", e.problem, e.remedy, value=density) for e in errors]
        own, bonded = None, None
        try:
            own = make_parameters(self._law, contact, f"{place}, contact")
        except InputError as error:
            found.append(error)
        if bond is not None and self._bond_law is None:
            found.append(
                InputError(
                    f"{place}, bond", "there is no bond law", "Give AssemblyBuilder a bond_law.", value=bond
                )
            )
        elif bond is not None and self._bond_law is not None:
            try:
                bonded = make_parameters(self._bond_law, bond, f"{place}, bond")
            except InputError as error:
                found.append(error)
        raise_all(found)
        self._materials.density[name] = float(density)
        self._materials.contact[name] = own
        if bonded is not None:
            self._materials.bond[name] = bonded

    def set_contact(self, first: str, second: str, **parameters: float) -> None:
        """Parameters of contacts between two materials, or a material and a wall, that replace the combined ones."""
        self._materials.contact_overrides.setdefault(pair_of(first, second), {}).update(parameters)

    def set_bond(self, first: str, second: str, **parameters: float) -> None:
        """Parameters of bonds between two materials that replace the combined ones."""
        if self._bond_law is None:
            raise InputError("set_bond", "there is no bond law", "Give AssemblyBuilder a bond_law.")
        self._materials.bond_overrides.setdefault(pair_of(first, second), {}).update(parameters)

    def add_particles(
        self,
        positions: ArrayLike,
        radii: ArrayLike,
        material: str,
        *,
        velocity: ArrayLike = 0.0,
        spin: ArrayLike = 0.0,
        density: ArrayLike | None = None,
    ) -> range:
        """Add discs or spheres.

        Parameters
        ----------
        positions : (k, d) float
            Centres [m].
        radii : float or (k,) float [m]
        material : str
        velocity : float, (d,) or (k, d) float [m/s]
        spin : float, (s,) or (k, s) float
            [rad/s]; s = 1 in 2D, 3 in 3D.
        density : float or (k,) float, optional
            [kg/m3]; the material's where it is left out.

        Returns
        -------
        range
            Numbers of the new particles.
        """
        first, d = self.particles, self.dimension
        try:
            centres = np.array(positions, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError("positions", "these are not numbers", "Give metres.") from None
        if centres.ndim != 2 or centres.shape[1] != d:
            raise InputError(
                "positions", f"an array of shape {centres.shape} does not hold centres in {d}D",
                f"Give one row of {d} coordinates per particle.",
            )  # fmt: skip
        count = len(centres)
        number = self._materials.index(material, "material of particles")
        refuse_too_large(d, first + count, len(self._bonds))
        size = as_numbers("radii", radii, (count,), "m")
        own = self._materials.density[material] if density is None else density
        heavy = as_numbers("density", own, (count,), "kg/m3")
        moving = as_numbers("velocity", velocity, (count, d), "m/s")
        if self._rotations == 1 and np.ndim(spin) == 1 and np.size(spin) == count:
            spin = np.reshape(spin, (count, 1))
        turning = as_numbers("spin", spin, (count, self._rotations), "rad/s")
        errors = bad_entries("position", centres, first, "m")
        errors += bad_entries("radius", size, first, "m", positive=True)
        errors += bad_entries("density", heavy, first, "kg/m3", positive=True)
        errors += bad_entries("velocity", moving, first, "m/s")
        errors += bad_entries("spin", turning, first, "rad/s")
        raise_all(errors)
        freedoms = d + self._rotations
        self._positions = np.concatenate([self._positions, centres])
        self._radii = np.concatenate([self._radii, size])
        self._density = np.concatenate([self._density, heavy])
        self._material = np.concatenate([self._material, np.full(count, number, dtype=np.int32)])
        self._motion = np.concatenate([self._motion, np.hstack([moving, turning])])
        self._held = np.concatenate([self._held, np.zeros((count, freedoms), dtype=bool)])
        self._applied = np.concatenate([self._applied, np.zeros((count, freedoms))])
        return range(first, first + count)

    def bond(self, pairs: ArrayLike, *, scale: ArrayLike | LognormalScatter | NormalScatter = 1.0) -> Pairs:
        """Bond pairs of particles.

        Parameters
        ----------
        pairs : (k, 2) int
        scale : float, (k,) float, LognormalScatter or NormalScatter
            Factor on the strength of every bond [-].

        Returns
        -------
        (k, 2) int64
            The pairs, lower number first.
        """
        given = np.asarray(pairs)
        if given.size == 0:
            return np.empty((0, 2), dtype=np.int64)
        if given.ndim != 2 or given.shape[1] != 2:
            raise InputError(
                "bonds", f"an array of shape {given.shape} does not hold pairs", "Give two numbers a bond."
            )
        new = chosen("bonds", given.ravel(), self.particles).reshape(-1, 2)
        new.sort(axis=1)
        checks.refuse_bad_bonds(new, self._positions, self._radii, self._bonds, self._cell)
        self._join(new, scale)
        return new

    def bond_within(
        self,
        factor: float = 1.05,
        between: tuple[str, str] | None = None,
        *,
        scale: ArrayLike | LognormalScatter | NormalScatter = 1.0,
    ) -> Pairs:
        """Bond every pair, not bonded yet, whose distance is at most `factor` times the sum of the radii.

        Parameters
        ----------
        factor : float
            [-]
        between : two names of materials, optional
            Only pairs of these; the same name twice for those within one material.
        scale : float, (k,) float, LognormalScatter or NormalScatter
            Factor on the strength of every bond [-].

        Returns
        -------
        (k, 2) int64
            The new bonds, lower number first, in ascending order.
        """
        if not (np.isfinite(factor) and 0.0 < factor <= checks.LONGEST_BOND):
            raise InputError(
                "bond_within, factor", f"this is not between 0 and {checks.LONGEST_BOND:g}",
                "Give a factor such as 1.05: all pairs up to 5 % farther apart than touching.", value=factor,
            )  # fmt: skip
        pairs, _ = close_pairs(self._positions, self._radii, lambda a, b: factor * (a + b), self._cell)
        if between is not None:
            first, second = (self._materials.index(name, "bond_within, between") for name in between)
            kind = np.sort(self._material[pairs], axis=1)
            pairs = pairs[(kind == sorted((first, second))).all(axis=1)]
        taken = checks.pair_keys(self._bonds, self.particles)
        pairs = pairs[~np.isin(checks.pair_keys(pairs, self.particles), taken)]
        self._join(pairs, scale)
        return pairs

    def _join(self, pairs: Pairs, scale: ArrayLike | LognormalScatter | NormalScatter) -> None:
        if self._bond_law is None:
            raise InputError("bonds", "there is no bond law", "Give AssemblyBuilder a bond_law.")
        able = np.array([name in self._materials.bond for name in self._materials.names], dtype=bool)
        unable = np.unique(self._material[pairs][~able[self._material[pairs]]])
        if len(unable):
            name = self._materials.names[int(unable[0])]
            raise InputError(
                f"material {name!r}, bond",
                f"its particles are bonded, but it has no parameters of the law {self._bond_law.NAME!r}",
                "Give add_material bond={...}.",
            )
        factors = scale.factors(len(pairs)) if isinstance(scale, LognormalScatter | NormalScatter) else scale
        strength = as_numbers("scale", factors, (len(pairs),), "units of 1")
        raise_all(bad_entries("scale", strength, 0, "units of 1", positive=True, item="bond"))
        self._bonds = np.concatenate([self._bonds, pairs])
        self._scale = np.concatenate([self._scale, strength])

    def hold(
        self,
        ids: Any,
        *,
        x: ArrayLike | None = None,
        y: ArrayLike | None = None,
        z: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
    ) -> None:
        """Hold freedoms of particles, or drive them at a given velocity.

        Parameters
        ----------
        ids : range, int array or mask
        x, y, z : float or (k,) float, optional
            Velocity [m/s]: 0 for a support. Free where left out.
        rotation : float, (s,) or (k, s) float, optional
            Angular velocity [rad/s].
        """
        which = chosen("hold", ids, self.particles)
        for axis, velocity in zip(AXES, (x, y, z), strict=True):
            if velocity is None:
                continue
            if axis == "z" and self.dimension == 2:
                raise InputError("hold, z", "discs have no freedom z", "Leave it out.", value=velocity)
            speed = as_numbers(f"hold, {axis}", velocity, (len(which),), "m/s")
            raise_all(bad_entries(f"hold, {axis}: velocity", speed, 0, "m/s", item="entry"))
            self._held[which, AXES.index(axis)] = True
            self._motion[which, AXES.index(axis)] = speed
        if rotation is not None:
            if self._rotations == 1 and np.ndim(rotation) == 1:
                rotation = np.reshape(rotation, (-1, 1))
            spin = as_numbers("hold, rotation", rotation, (len(which), self._rotations), "rad/s")
            raise_all(bad_entries("hold, rotation: spin", spin, 0, "rad/s", item="entry"))
            self._held[which, self.dimension :] = True
            self._motion[which, self.dimension :] = spin

    def apply(self, ids: Any, *, force: ArrayLike | None = None, torque: ArrayLike | None = None) -> None:
        """Add constant forces (d,) or (k, d) [N] and torques, a number, (s,) or (k, s) [N m], to particles."""
        which = chosen("apply", ids, self.particles)
        d = self.dimension
        added = np.zeros((len(which), d + self._rotations))
        if force is not None:
            if np.ndim(force) == 0:
                raise InputError("apply, force", "a force has a direction", f"Give {d} numbers.", value=force)
            added[:, :d] = as_numbers("apply, force", force, (len(which), d), "N")
        if torque is not None:
            if self._rotations == 1 and np.ndim(torque) == 1:
                torque = np.reshape(torque, (-1, 1))
            elif self._rotations == 3 and np.ndim(torque) == 0:
                raise InputError("apply, torque", "a torque has an axis", "Give 3 numbers.", value=torque)
            added[:, d:] = as_numbers("apply, torque", torque, (len(which), self._rotations), "N m")
        raise_all(bad_entries("apply: force or torque", added, 0, "N and N m", item="entry"))
        np.add.at(self._applied, which, added)

    def anchor(
        self, ids: Any, point: ArrayLike, stiffness: ArrayLike, length: ArrayLike | None = None
    ) -> None:
        """Springs between particle centres and points fixed in space.

        Parameters
        ----------
        ids : range, int array or mask
        point : (d,) or (k, d) float [m]
        stiffness : float or (k,) float [N/m]
        length : float or (k,) float, optional
            Length without force [m]; the distance now where it is left out.
        """
        which = chosen("anchor", ids, self.particles)
        count = len(which)
        ends = as_numbers("anchor, point", point, (count, self.dimension), "m")
        spring = as_numbers("anchor, stiffness", stiffness, (count,), "N/m")
        distance = np.linalg.norm(self._positions[which] - ends, axis=1)
        free = distance if length is None else as_numbers("anchor, length", length, (count,), "m")
        errors = bad_entries("anchor, point", ends, 0, "m", item="spring")
        errors += bad_entries("anchor, stiffness", spring, 0, "N/m", positive=True, item="spring")
        errors += bad_entries("anchor, length", free, 0, "m", item="spring")
        wrong = np.flatnonzero((free < 0.0) | ((free > 0.0) & (distance == 0.0)))
        if len(wrong) and not errors:
            errors.append(
                InputError(
                    f"anchor, length of spring {wrong[0]}",
                    "a spring has no negative length, and none but 0 where its ends coincide",
                    "Give another length or point.",
                    value=float(free[wrong[0]]),
                )
            )
        raise_all(errors)
        self._anchors.append((which, ends, spring, free))

    def add_wall(self, wall: Wall) -> None:
        """Add a wall (`geodem.boundaries.walls` makes them); its `contact` goes over what the materials say."""
        if wall.name in [other.name for other in self._walls]:
            raise InputError(f"wall {wall.name!r}", "there is such a wall already", "Give it another name.")
        self._walls.append(wall)

    def build(self) -> Assembly:
        """The assembly, after everything has been looked at as a whole.

        Raises
        ------
        InputError
            No particle; more than memory holds; particles in one another or behind a plane; a name that is
            neither a material nor a wall; bonds whose breaking would create energy. Several errors come as one
            `InputErrors`.
        """
        d = self.dimension
        if not self.particles:
            raise InputError("particles", "there is no particle", "Call add_particles first.")
        refuse_too_large(d, self.particles, len(self._bonds))
        names = self._materials.names
        for wall in self._walls:
            if wall.name in names:
                raise InputError(f"wall {wall.name!r}", "a material has that name", "Give it another name.")
        self._materials.refuse_unknown_names([wall.name for wall in self._walls])
        volume = np.pi * self._radii**2 if d == 2 else 4.0 / 3.0 * np.pi * self._radii**3
        mass = self._density * volume
        replaces = self._bond_law is not None and self._bond_law.REPLACES_CONTACT
        joints = self._linkage.joints(names)
        excepted = np.concatenate([self._bonds if replaces else self._bonds[:0], self._linkage.crossed()])
        solid = np.ones(self.particles, dtype=bool)
        if joints is not None:
            solid = ~np.isin(self._material, joints.untouched)
        numbered = np.cumsum(solid) - 1
        inner = excepted[solid[excepted].all(axis=1)]
        errors = checks.deep_overlaps(self._positions[solid], self._radii[solid], numbered[inner], self._cell)
        if self._cell is not None:
            errors += cell_errors(self._cell, self._radii, self._walls, anchored=bool(self._anchors))
        walls = []
        for wall in self._walls:
            wrong = wall_errors(wall, d)
            errors += wrong or checks.behind_planes(wall, self._positions, self._radii)
            try:
                walls.append(self._materials.against_wall(wall))
            except InputError as error:
                errors.append(error)
        raise_all(errors)
        assembly = Assembly(
            dimension=d,
            positions=self._positions.copy(),
            radii=self._radii.copy(),
            mass=mass,
            inertia=(DISC_INERTIA if d == 2 else SPHERE_INERTIA) * mass * self._radii**2,
            velocities=self._motion[:, :d].copy(),
            spins=self._motion[:, d:].copy(),
            material=self._material.copy(),
            material_names=tuple(names),
            contact_law=self._law.NAME,
            contact_table=self._materials.contact_table(),
            bond_law=self._bond_law.NAME if self._bond_law is not None and len(self._bonds) else None,
            bond_table=self._materials.bond_table(),
            bonds=self._bonds.astype(np.int32),
            bond_scale=self._scale.copy(),
            held=self._held.copy(),
            applied=self._applied.copy(),
            gravity=self._gravity.copy(),
            anchors=self._springs(),
            walls=tuple(walls),
            cell=self._cell,
            joints=joints,
        )
        if replaces and self._bond_law is not None and len(self._bonds):
            raise_all(checks.energy_of_breaking(self._law, self._bond_law, assembly))
        return assembly

    def _springs(self) -> Anchors | None:
        if not self._anchors:
            return None
        which, ends, spring, free = (np.concatenate(part) for part in zip(*self._anchors, strict=True))
        return Anchors(which.astype(np.int32), ends, spring, free)
