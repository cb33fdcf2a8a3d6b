"""Scenes that geodem, YADE, LIGGGHTS, LAMMPS and a plain C loop all run: spheres in a box, bonded spheres and discs.

A scene is plain arrays and SI numbers, made on the fly from a seed and stored nowhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .scene_packings import hexagonal_discs, random_spheres, touching_pairs, vacant_lattice

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Bonds:
    """Linear bonds; a bond measures its elongation from the distance at which it was made.

    Attributes
    ----------
    pairs : (b, 2) int
    normal, shear : float
        Stiffnesses [N/m].
    twist, bend : float
        Stiffnesses against rotation [N m/rad]; 0: none.
    tension, cohesion : float
        Strengths [N]; a bond's shear limit is cohesion + friction * normal force.
    """

    pairs: Integers
    normal: float
    shear: float
    twist: float
    bend: float
    tension: float
    cohesion: float


@dataclass(frozen=True)
class Scene:
    """Spheres, or discs as spheres that move in the plane z = 0.

    Attributes
    ----------
    name : str
    dimension : int
    positions, velocities : (n, 3) [m], [m/s]
        The velocities are those half a step before the start; `velocities_at_start` gives the later ones that
        codes with velocity Verlet (LIGGGHTS, LAMMPS) begin with.
    spins : (n, 3) [rad/s]
    radii : (n,) [m]
    density : float
        [kg/m3]; the mass is that of a sphere in both dimensions.
    normal, shear : float
        Stiffnesses of every contact of two particles [N/m]; against a wall twice as much.
    friction : float
        Coefficient.
    gravity : (3,) [m/s2]
    box : (2, 3) [m] or None
        Low and high corner of six fixed walls.
    time_step : float
        [s]
    bonds : Bonds or None
    """

    name: str
    dimension: int
    positions: Floats
    velocities: Floats
    spins: Floats
    radii: Floats
    density: float
    normal: float
    shear: float
    friction: float
    gravity: tuple[float, float, float]
    box: Floats | None
    time_step: float
    bonds: Bonds | None = None

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.radii)

    @property
    def mass(self) -> Floats:
        """(n,) [kg]"""
        return np.asarray(4.0 / 3.0 * np.pi * self.density * self.radii**3)

    def velocities_at_start(self) -> Floats:
        """(n, 3) velocities half a step on [m/s]: by gravity, walls and the contacts' overlaps; shear starts at 0."""
        force = self.mass[:, None] * np.array(self.gravity)
        if self.bonds is None:
            first, second = self.pairs().T
            apart = self.positions[second] - self.positions[first]
            distance = np.sqrt((apart**2).sum(1))
            push = (
                apart
                * (self.normal * (self.radii[first] + self.radii[second] - distance) / distance)[:, None]
            )
            for axis in range(3):
                force[:, axis] += np.bincount(second, push[:, axis], self.particles)
                force[:, axis] -= np.bincount(first, push[:, axis], self.particles)
        if self.box is not None:
            reach = self.radii[:, None]
            force += 2.0 * self.normal * np.maximum(self.box[0] + reach - self.positions, 0.0)
            force -= 2.0 * self.normal * np.maximum(self.positions + reach - self.box[1], 0.0)
        return np.asarray(self.velocities + 0.5 * self.time_step * force / self.mass[:, None])

    def pairs(self, margin: float = 0.0) -> Integers:
        """(p, 2) pairs closer than `margin` times the largest radius, the lower number first."""
        return touching_pairs(self.positions, self.radii, margin * float(self.radii.max()))


RADIUS = 5e-3
DENSITY = 2600.0
STIFFNESS = 1e5
SHEAR_SHARE = 0.8
FRICTION = 0.5
STEP_SHARE = 0.1
"""Time step over sqrt(m/kn) of the lightest particle: well below the critical one in a dense packing."""

NO_OVERLAP = 1.0 - 1e-9
"""Bonded particles just touch: YADE's CohFrict counts the overlap at bonding as pressed, the others do not."""


def spheres_in_a_box(n: int, *, seed: int = 1) -> Scene:
    """Random dense packing of n spheres at rest in a box that just holds it, radii within 20 % of 5 mm."""
    packing = random_spheres(n, seed=seed)
    return _scene(
        f"random spheres {n}", packing.positions * RADIUS, packing.radii * RADIUS, packing.box * RADIUS
    )


def moving_spheres(n: int, *, seed: int = 1) -> Scene:
    """The packing of `spheres_in_a_box`, its spheres moving at random, so that neighbours are searched now and then.

    At 0.3 m/s a sphere covers a tenth of its radius in some 150 steps.
    """
    return _shaken(replace(spheres_in_a_box(n, seed=seed), name=f"moving spheres {n}"), seed, speed=0.3)


def touching_spheres(n: int, *, seed: int = 1) -> Scene:
    """n equal spheres on a face-centred lattice with one site in twenty empty, pressed by 0.1 % of the diameter.

    Every listed pair touches: 5.7 pairs a particle inside. There is no box; the time step is so small against the
    contact's period that the spheres hardly move, so that every step does the same work.
    """
    scene = _shaken(_lattice(f"touching spheres {n}", n, seed, 0.999), seed)
    return replace(scene, time_step=1e-4 * scene.time_step)


def bonded_block(n: int, *, seed: int = 1) -> Scene:
    """A free block of n spheres on a lattice with gaps, all touching pairs bonded, with moments; unbreakable."""
    scene = _lattice(f"bonded block {n}", n, seed, NO_OVERLAP)
    shear = SHEAR_SHARE * STIFFNESS
    # those of a round beam of the spheres' radius
    bend, twist = STIFFNESS * RADIUS**2 / 4.0, shear * RADIUS**2 / 2.0
    bonds = Bonds(scene.pairs(), STIFFNESS, shear, twist, bend, np.inf, np.inf)
    return _shaken(replace(scene, bonds=bonds), seed)


def bonded_discs(n: int, *, seed: int = 1) -> Scene:
    """A free plate of n equal discs, hexagonal, all touching pairs bonded, without moments; unbreakable."""
    positions = hexagonal_discs(n) * (NO_OVERLAP * RADIUS)
    scene = replace(
        _scene(f"bonded discs {n}", positions, np.full(n, RADIUS), None), dimension=2, gravity=(0.0, 0.0, 0.0)
    )
    bonds = Bonds(scene.pairs(), STIFFNESS, SHEAR_SHARE * STIFFNESS, 0.0, 0.0, np.inf, np.inf)
    return _shaken(replace(scene, bonds=bonds), seed)


def head_on(radii: tuple[float, float], speed: float, *, steps_in_contact: float = 500.0) -> Scene:
    """Two spheres that meet without friction at a relative `speed` [m/s]; the contact lasts so many steps.

    They touch after 10.25 steps.
    """
    radius = np.array(radii)
    mass = 4.0 / 3.0 * np.pi * DENSITY * radius**3
    reduced = mass.prod() / mass.sum()
    step = np.pi * np.sqrt(reduced / STIFFNESS) / steps_in_contact
    positions = np.zeros((2, 3))
    positions[1, 0] = radius.sum() + 10.25 * step * speed
    velocities = np.zeros((2, 3))
    velocities[0, 0], velocities[1, 0] = speed * mass[1] / mass.sum(), -speed * mass[0] / mass.sum()
    scene = _scene("head-on", positions, radius, None)
    return replace(scene, velocities=velocities, gravity=(0.0, 0.0, 0.0), time_step=float(step))


def _scene(name: str, positions: Floats, radii: Floats, box: Floats | None) -> Scene:
    lightest = 4.0 / 3.0 * np.pi * DENSITY * float(radii.min()) ** 3
    return Scene(
        name=name,
        dimension=3,
        positions=positions,
        velocities=np.zeros_like(positions),
        spins=np.zeros_like(positions),
        radii=radii,
        density=DENSITY,
        normal=STIFFNESS,
        shear=SHEAR_SHARE * STIFFNESS,
        friction=FRICTION,
        gravity=(0.0, 0.0, -9.81),
        box=box,
        time_step=STEP_SHARE * float(np.sqrt(lightest / STIFFNESS)),
    )


def _lattice(name: str, n: int, seed: int, shrink: float) -> Scene:
    scene = _scene(name, vacant_lattice(n, seed=seed) * (shrink * RADIUS), np.full(n, RADIUS), None)
    return replace(scene, gravity=(0.0, 0.0, 0.0))


def _shaken(scene: Scene, seed: int, speed: float = 1e-2) -> Scene:
    """The scene with random velocities [m/s]; the small ones of the default see to it that no force stays zero."""
    velocities = np.random.default_rng(seed).normal(0.0, speed, scene.positions.shape)
    if scene.dimension == 2:
        velocities[:, 2] = 0.0
    return replace(scene, velocities=velocities)
