"""Assembly: discs or spheres, their materials, bonds, walls and supports; what does not change while they move.

`geodem.builders.assembly_builder.AssemblyBuilder` makes one and checks every number on the way.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

DISC_INERTIA = 0.5
"""Moment of inertia over m r^2: of a disc about its axis, per metre of length."""
SPHERE_INERTIA = 0.4
"""Moment of inertia over m r^2 of a sphere."""


@dataclass(frozen=True)
class Servo:
    """Drives a wall so that the force it feels reaches a target.

    Each step the wall moves along `direction` with the velocity gain * (target - force), at most `limit`.

    Attributes
    ----------
    direction : (d,) float
        Unit vector into the particles: the way in which the wall pushes.
    force : float
        Force that the particles shall exert on the wall against `direction` [N] (2D: N per m).
    limit : float
        Largest speed [m/s].
    gain : float, optional
        [m/(N s)]; chosen from the stiffness of the contacts where it is None.
    """

    direction: tuple[float, ...]
    force: float
    limit: float
    gain: float | None = None


@dataclass(frozen=True)
class Wall:
    """A rigid body made of planes, segments or triangles, fixed, moving or driven by a servo.

    Attributes
    ----------
    name : str
    planes : (k, 2, d) [m]
        A point on each plane and its unit normal; particles are on the side the normal points to.
    segments : (k, 2, 2) [m]
        Ends of segments; 2D only. Particles may touch both sides.
    triangles : (k, 3, 3) [m]
        Corners; 3D only. Particles may touch both sides.
    velocity : (d,) [m/s]
    spin : (1,) or (3,) [rad/s]
        Angular velocity about `centre`.
    centre : (d,) [m]
        Moves with the wall; torques are taken about it.
    servo : Servo, optional
    contact : dict
        For every particle material the contact law's parameters against this wall.
    """

    name: str
    planes: Floats
    segments: Floats
    triangles: Floats
    velocity: Floats
    spin: Floats
    centre: Floats
    contact: dict[str, Any]
    servo: Servo | None = None


@dataclass(frozen=True)
class Anchors:
    """Springs between particle centres and points fixed in space (DICE2D's fixed-spring condition).

    Attributes
    ----------
    particle : (k,) int32
    point : (k, d) [m]
    stiffness : (k,) [N/m]
    length : (k,) [m]
        Length without force.
    """

    particle: Integers
    point: Floats
    stiffness: Floats
    length: Floats


@dataclass(frozen=True)
class Cell:
    """A periodic cell as it is at the start.

    Attributes
    ----------
    vectors : (d, d) [m]
        Rows: its edges, right-handed.
    periodic : (d,) bool
        Along which edges it is periodic.
    """

    vectors: Floats
    periodic: tuple[bool, ...]

    def nearest(self, apart: Floats) -> Floats:
        """Ways (k, d) [m] to the nearest images; right for ways up to half the thickness of the cell."""
        share = np.floor(apart @ np.linalg.inv(self.vectors) + 0.5)
        share[:, ~np.array(self.periodic)] = 0.0
        return np.asarray(apart - share @ self.vectors)


@dataclass(frozen=True)
class Joints:
    """Joints through an assembly: flat faces, the pairs of particles that they cross, and who lies on which side.

    `geodem.builders.joint_cut` makes them.

    Attributes
    ----------
    laws : tuple of str
        Names in `geodem.laws.JOINT_LAWS`.
    names : tuple of str
        Materials of joints, and of bolts.
    table : (k, 1 + q)
        Which of the laws each has, and its parameters.
    normal : (f, d)
        Unit normal of every face, from its lower to its upper side.
    material : (f,) int32
        Row of `table`.
    per_size : (f,)
        Mean area of a pair over the square of its smaller radius (2D: over that radius) [-].
    reach : float
        Two particles nearer than this many times the sum of their radii act on each other through a joint [-].
    pairs : (c, 2) int32
        Pairs that are crossed at the start, lower number first.
    face : (c,) int32
        1 + face, negative where the first of the two is above it.
    area : (c,) [m2] (2D: [m])
        Of the face that each stands for.
    side_particle, side_joint, side_face : (l,) int32
        Particles near joints: joint, and 1 + the face that is nearest, negative below it.
    untouched : (u,) int32
        Materials of particles that touch nothing but by such links: bolts.
    """

    laws: tuple[str, ...]
    names: tuple[str, ...]
    table: Floats
    normal: Floats
    material: Integers
    per_size: Floats
    reach: float
    pairs: Integers
    face: Integers
    area: Floats
    side_particle: Integers
    side_joint: Integers
    side_face: Integers
    untouched: Integers


@dataclass(frozen=True)
class Assembly:
    """Discs (2D, per metre of length) or spheres (3D).

    Attributes
    ----------
    dimension : int
        d = 2 or 3. Rotations have s = 1 or 3 components.
    positions : (n, d) [m]
    radii : (n,) [m]
    mass : (n,) [kg] (2D: kg per m)
    inertia : (n,) [kg m2]
    velocities : (n, d) [m/s]
    spins : (n, s) [rad/s]
    material : (n,) int32
        Index into `material_names`.
    material_names : tuple of str
    contact_law : str
        Name in `geodem.laws.CONTACT_LAWS`.
    contact_table : (m * m, k)
        Parameters of the contact law; row first * m + second.
    bond_law : str or None
        Name in `geodem.laws.BOND_LAWS`; None where nothing is bonded.
    bond_table : (m * m, k)
    bonds : (b, 2) int32
        Particles of every bond, the lower number first.
    bond_scale : (b,) [-]
        Factor on the strength of every bond.
    held : (n, d + s) bool
        Freedoms whose velocity stays as it is given: 0 for a support, anything for a driven particle.
    applied : (n, d + s) [N, N m]
        Constant forces and torques.
    gravity : (d,) [m/s2]
    anchors : Anchors or None
    walls : tuple of Wall
    cell : Cell or None
        Positions may lie anywhere: every particle stands for all its images.
    joints : Joints or None
        Bonds between their pairs are those of the joint.
    """

    dimension: int
    positions: Floats
    radii: Floats
    mass: Floats
    inertia: Floats
    velocities: Floats
    spins: Floats
    material: Integers
    material_names: tuple[str, ...]
    contact_law: str
    contact_table: Floats
    bond_law: str | None
    bond_table: Floats
    bonds: Integers
    bond_scale: Floats
    held: NDArray[np.bool_]
    applied: Floats
    gravity: Floats
    anchors: Anchors | None = None
    walls: tuple[Wall, ...] = field(default=())
    cell: Cell | None = None
    joints: Joints | None = None

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.positions)

    @property
    def rotations(self) -> int:
        """Components of a rotation: 1 in 2D, 3 in 3D."""
        return 1 if self.dimension == 2 else 3

    def pair_parameters(self, first: int, second: int) -> Floats:
        """Row of the contact table for two materials."""
        return np.asarray(self.contact_table[first * len(self.material_names) + second])
